"""See README.md."""

import numpy as np
from manual import Accept, plt
from plates import Crack, NotchedPlate, draw, stable_step

TITLE = "Kalthoff and Winkler: a crack that starts from a notch under shear"
E, NU, RHO, GF = 190e9, 0.3, 8000.0, 22.13e3
SIGMA_T = 844e6    # Belytschko et al. 2003
SPEED, END = 16.5, 85e-6

ACCEPTANCE = [
    Accept("angle of the crack to the notch", "Kalthoff and Winkler (1987), experiment", target=70.0, tolerance=7.0, unit="degrees",
           certain=False),
    Accept("start of the crack", "phase fields and peridynamics", low=20.0, high=26.0, unit="us", certain=False),
    Accept("speed over Rayleigh's (2803 m/s)", "phase fields and peridynamics", high=0.75, certain=False),
    Accept("largest rise of the total energy, regular meshes", "exact", high=0.1, unit="%"),
    Accept("largest rise of the total energy, nodes moved", "exact", high=0.1, unit="%"),
]


def run(s):
    # whole numbers of elements between the notch and the plane of symmetry
    meshes = [("5 mm", 5e-3, 0.0, 0.0), ("2.5 mm", 2.5e-3, 0.0, 0.0)] + ([] if s.quick else [("1.25 mm", 1.25e-3, 0.0, 0.0)])
    main, h = meshes[-1][:2]
    moved = f"{main}, nodes moved by 20 %"
    meshes.append((moved, h, 0.0, 0.2))
    if s.fine:
        meshes.append(("0.625 mm", 0.625e-3, 0.0, 0.0))
        main = meshes[-1][0]
    jobs = [(m, "no") for m in meshes] + [(meshes[1], "all")]

    def one(job):
        (label, h, lattice, share), start = job
        name = f"{label.replace(' ', '').replace(',', '_').replace('%', '')}_{start}"
        plate = NotchedPlate(0.1, 0.1, h, 0.05, h, lattice, share, below=0.025)
        layer = 2.5e-3
        plate.held = (plate.mesh.centre[:, 0] < -0.05 + layer + h) | (plate.mesh.centre[:, 1] < plate.low + 1.05 * max(layer, 0.5 * h))
        plate.held &= plate.mesh.centre[:, 1] < 0.0
        plate.write(s.path(name + ".data"))
        dt = stable_step(E, NU, RHO, h) * (0.5 if share else 1.0)
        steps = int(END / dt)
        s.lammps("in.kalthoff", name, mesh=name + ".data", speed=SPEED, young=E, nu=NU, rho=RHO, sigma=SIGMA_T, gf=GF, start=start,
                 dt=dt, steps=steps, every=max(1, steps // 100), skin=0.15 * h, left=-0.05, low=plate.low + (share + 0.01) * h, layer=layer,
                 **plate.mesh.box())
        s.path(name + ".data").unlink()
        return name, plate, Crack(s.path(name + ".events"), 0.0, h / 2), dt

    found = dict(zip([(m[0], st) for m, st in jobs], s.all(one, jobs)))

    def from_notch(crack):
        """Joints broken within 50 mm of the end of the notch, above it: not those that start at the free edge."""
        r = np.hypot(crack.x[:, 0], crack.x[:, 1])
        near = (r > 3e-3) & (r < 0.05) & (crack.x[:, 1] > 0.0)
        return crack.x[near], crack.broken.time[near], r[near]

    def angle(crack):
        x, _, _ = from_notch(crack)
        if len(x) < 10:
            return np.nan
        values, vectors = np.linalg.eigh(x[:, :2].T @ x[:, :2])
        return float(np.degrees(np.arctan2(*np.abs(vectors[::-1, 1]))))

    def speed(crack):
        x, t, r = from_notch(crack)
        order = np.argsort(t, kind="stable")
        far = np.maximum.accumulate(r[order]) if len(r) else r
        if len(far) == 0 or far[-1] < 0.03:
            return np.nan
        first, last = np.searchsorted(far, 0.005), np.searchsorted(far, 0.03)
        return 0.025 / (t[order][last] - t[order][first])

    rows = [["mesh", "", "first joint breaks (us)", "angle (degrees)", "speed, 5 to 30 mm (m/s)", "converted", "processor time (s)",
             "energy rises (%)"]]
    for (label, start), (name, plate, crack, dt) in found.items():
        e = s.energies(name)
        rows.append([label, "DEs" if start == "all" else "adaptive", f"{crack.start() * 1e6:.1f}", f"{angle(crack):.1f}",
                     f"{speed(crack):.0f}", int(e.converted[-1]), f"{s.loops[name]:.1f}", f"{100 * e.rise():.3f}"])
    s.table("All runs:", rows)
    figure, axes = plt.subplots(1, len(found), figsize=(3.1 * len(found), 3.3), sharey=True)
    for ax, ((label, start), (_, plate, crack, _)) in zip(axes, found.items()):
        draw(ax, plate, crack, label + (", all DEs" if start == "all" else ""))
        ax.plot([0, 75 / np.tan(np.radians(70))], [0, 75], color="k", lw=0.6, ls=":")
    figure.tight_layout()
    s.figure(figure, "cracks", "Broken joints (blue) and converted elements (grey) after 85 us, in mm; dotted: 70 degrees.")
    name, plate, crack, dt = found[(main, "no")]
    s.plot_energies(name, dt, main)
    return {
        "angle of the crack to the notch": angle(crack),
        "start of the crack": crack.start() * 1e6,
        "speed over Rayleigh's (2803 m/s)": speed(crack) / 2803.0,
        "largest rise of the total energy, regular meshes": 100 * max(s.energies(f[0]).rise() for (m, _), f in found.items() if "moved" not in m),
        "largest rise of the total energy, nodes moved": 100 * s.energies(found[(moved, "no")][0]).rise(),
    }
