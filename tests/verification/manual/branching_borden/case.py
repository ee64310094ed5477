"""See README.md."""

import numpy as np
from manual import Accept, plt
from plates import Crack, NotchedPlate, draw, stable_step

TITLE = "Borden et al.: branching under 1 MPa"
BORDEN = "Borden et al., Comput. Methods Appl. Mech. Engrg. 217 (2012) 77"
E, NU, RHO, GF = 32e9, 0.2, 2450.0, 3.0
SIGMA_T = 6.36e6    # of their phase field: 3/16 sqrt(3 E G/l), l = 0.25 mm
PULL, END = 1e6, 80e-6
RAYLEIGH = 2125.0

ACCEPTANCE = [
    Accept("start of the crack", BORDEN + ", from the curve", target=10.0, tolerance=4.0, unit="us", certain=False),
    Accept("branching", BORDEN, target=68.0, tolerance=14.0, unit="us", certain=False),
    Accept("largest speed over Rayleigh's", BORDEN, high=0.6, certain=False),
    Accept("cracks at x = 45 mm", BORDEN, low=2, high=2, certain=False),
    Accept("largest rise of the total energy", "exact", high=0.1, unit="%"),
]


def run(s):
    meshes = [("2 mm", 2e-3, 0.0, 0.0), ("1 mm, turned by 45 degrees", 1e-3, 45.0, 0.0), ("1 mm", 1e-3, 0.0, 0.0),
              ("0.5 mm", 0.5e-3, 0.0, 0.0)]
    if s.quick:
        meshes.pop()
    if s.fine:
        meshes.append(("0.25 mm", 0.25e-3, 0.0, 0.0))
    jobs = [(m, "no") for m in meshes] + [(meshes[2], "all")]

    def one(job):
        (label, h, lattice, moved), start = job
        name = f"{label.replace(' ', '').replace(',', '_')}_{start}"
        plate = NotchedPlate(0.1, 0.04, h, 0.05, h, lattice, moved, band=2e-3)
        plate.write(s.path(name + ".data"))
        plate.write_traction(s.path(name + ".force"))
        dt = stable_step(E, NU, RHO, h)
        steps = int(END / dt)
        s.lammps("../branching_soda_lime/in.plate", name, mesh=name + ".data", traction=name + ".force", pull=PULL, young=E, nu=NU,
                 rho=RHO, sigma=SIGMA_T, gf=GF, start=start, dt=dt, steps=steps, every=max(1, steps // 100), skin=0.15 * h,
                 **plate.mesh.box())
        for end in ("data", "force"):
            s.path(f"{name}.{end}").unlink()
        return name, plate, Crack(s.path(name + ".events"), 0.0, h / 2), dt

    found = dict(zip([(m[0], st) for m, st in jobs], s.all(one, jobs)))
    rows = [["mesh", "", "first joint breaks (us)", "branches at x (mm)", "after (us)", "cracks at x = 45 mm", "processor time (s)",
             "energy rises (%)"]]
    for (label, start), (name, plate, crack, dt) in found.items():
        at, when = crack.branching(0.046)
        rows.append([label, "DEs" if start == "all" else "adaptive", f"{crack.start() * 1e6:.1f}",
                     "-" if np.isnan(at) else f"{at * 1e3:.0f}", "-" if np.isnan(at) else f"{when * 1e6:.0f}", crack.arms(0.045),
                     f"{s.loops[name]:.1f}", f"{100 * s.energies(name).rise():.3f}"])
    s.table("All runs:", rows)
    figure, axes = plt.subplots(len(found), 1, figsize=(5, 2.1 * len(found)), sharex=True)
    for ax, ((label, start), (_, plate, crack, _)) in zip(axes, found.items()):
        draw(ax, plate, crack, label + (", all DEs" if start == "all" else ""))
    figure.tight_layout()
    s.figure(figure, "cracks", "Broken joints (blue) and converted elements (grey) after 80 us, in mm.")
    name, plate, crack, dt = found[(meshes[-1][0], "no")]
    s.plot_energies(name, dt, meshes[-1][0])
    windows = [crack.speed(a, a + 0.01) for a in np.arange(0.002, 0.038, 0.002)]
    return {
        "start of the crack": crack.start() * 1e6,
        "branching": crack.branching(0.046)[1] * 1e6,
        "largest speed over Rayleigh's": float(np.nanmax(windows)) / RAYLEIGH if np.isfinite(windows).any() else np.nan,
        "cracks at x = 45 mm": crack.arms(0.045),
        "largest rise of the total energy": 100 * max(s.energies(f[0]).rise() for f in found.values()),
    }
