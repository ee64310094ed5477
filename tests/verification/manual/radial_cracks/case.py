"""See README.md."""

import defe
import numpy as np
from manual import Accept, plt
from plates import Crack, Mesh, stable_step, turned

SLOW = True
TITLE = "Radial cracks of a thin plate against the speed of the ball"
VV = "Vandenberghe, Vermorel, Villermaux, Phys. Rev. Lett. 110 (2013) 174302"
E, NU, RHO, GF, SIGMA_T = 3e9, 0.35, 1180.0, 400.0, 80e6    # PMMA; G_f and strength: see README.md
SIDE, THICKNESS, RADIUS, END = 0.06, 1e-3, 2e-3, 120e-6
SPEEDS = (20.0, 40.0, 60.0, 78.0)
CIRCLE = 0.65    # of the longest one: there they are counted

ACCEPTANCE = [
    Accept("radial cracks at 20 m/s", VV, low=3, high=5, known=True),
    Accept("radial cracks at 60 m/s", VV, low=7, high=9, known=True),
    Accept("radial cracks at 78 m/s", VV, low=7, high=9, known=True),
    Accept("exponent of the number over speed", VV, target=0.5, tolerance=0.15, known=True),
    Accept("largest rise of the total energy", "exact", high=0.1, unit="%"),
]


def run(s):
    h = 0.5e-3
    meshes = [("0.5 mm", h, 0.0), ("0.5 mm, turned by 45 degrees", h, 45.0), ("1 mm", 1e-3, 0.0)]
    jobs = [(m, v, "no") for m in meshes for v in SPEEDS if m != meshes[1] or v in (20.0, 60.0)]
    also = [("0.75 mm", 0.75e-3, 0.0)] + ([("0.333 mm", 1e-3 / 3.0, 0.0)] if s.fine else [])
    jobs += [(m, 60.0, "no") for m in also] + [(meshes[2], 60.0, "all")]

    def one(job):
        (label, h, angle), speed, start = job
        name = f"{label.replace(' ', '').replace(',', '_')}_{speed:g}_{start}"
        edge = np.array([h, h, THICKNESS / 2])
        half = SIDE / 2
        mesh = Mesh(edge, turned(angle), lambda c: (np.abs(c) < [half, half, THICKNESS / 2]).all(axis=1),
                    np.array([1.45 * half, 1.45 * half, THICKNESS / 2]) + 2 * h, shift=(0.5, 0.5, 0.5))
        mesh.write(s.path(name + ".data"), 4, np.full(len(mesh.hex), "body"))
        dt = stable_step(E, NU, RHO, edge.min())
        steps = int(END / dt)
        room = max(0.01, 3.0 * speed * END)    # splinters are faster than the ball
        s.lammps("in.pane", name, mesh=name + ".data", speed=speed, radius=RADIUS, off_x=0.13 * h, off_y=0.21 * h, thickness=THICKNESS, young=E, nu=NU, rho=RHO,
                 sigma=SIGMA_T, gf=GF, start=start, dt=dt, steps=steps, every=max(1, steps // 60), skin=0.15 * h, **mesh.box(room))
        s.path(name + ".data").unlink()
        return name, dt, Crack(s.path(name + ".events"), 0.0, h / 2)

    found = dict(zip([(m[0] + (", all DEs" if start == "all" else ""), v) for m, v, start in jobs], s.all(one, jobs)))

    def radial(crack):
        """Cracks along a radius in the lower half that cross a circle: broken joints more than 12 degrees apart."""
        low = crack.broken.where(crack.broken.x[:, 2] < 0.0)
        longest = np.hypot(crack.broken.x[:, 0], crack.broken.x[:, 1]).max(initial=0.0)
        return defe.cracks.count_radial(low.x, low.n, CIRCLE * longest, 2.0 * crack.d, 12.0)

    rows = [["mesh", "speed (m/s)", "radial cracks", "farthest joint (mm)", "converted", "processor time (s)", "energy rises (%)"]]
    for (label, v), (name, dt, crack) in found.items():
        e = s.energies(name)
        far = np.hypot(crack.broken.x[:, 0], crack.broken.x[:, 1])
        rows.append([label, f"{v:g}", radial(crack), f"{far.max() * 1e3:.0f}" if len(far) else "-", int(e.converted[-1]),
                     f"{s.loops[name]:.1f}", f"{100 * e.rise():.3f}"])
    s.table("All runs:", rows)
    shown = [[key for key in found if key[0] == m[0]] for m in meshes] + [[key for key in found if key[0] not in {m[0] for m in meshes}]]
    figure, axes = plt.subplots(len(shown), len(SPEEDS), figsize=(10, 2.6 * len(shown)), sharex=True, sharey=True)
    for row, keys in enumerate(shown):
        for ax in axes[row][len(keys):]:
            ax.axis("off")
        for ax, (label, v) in zip(axes[row], keys):
            _, _, crack = found[(label, v)]
            low = crack.broken.x[:, 2] < 0.0
            c = crack.converted.x * 1e3
            ax.scatter(c[:, 0], c[:, 1], s=2, marker="s", color="0.85", linewidths=0)
            ax.scatter(crack.broken.x[low, 0] * 1e3, crack.broken.x[low, 1] * 1e3, s=1.5, color="#1f4e9c", linewidths=0)
            ax.set(xlim=(-30, 30), ylim=(-30, 30), aspect="equal")
            ax.set_title(f"{label}, {v:g} m/s", fontsize=8)
            ax.tick_params(labelsize=7)
    figure.tight_layout()
    s.figure(figure, "cracks", "Broken joints of the lower half (blue) and converted elements (grey) after 120 us, in mm.")
    numbers = np.array([radial(found[("0.5 mm", v)][2]) for v in SPEEDS], float)
    ok = numbers > 0
    slope = np.polyfit(np.log(np.array(SPEEDS)[ok]), np.log(numbers[ok]), 1)[0] if ok.sum() > 1 else np.nan
    figure, ax = plt.subplots(figsize=(5.5, 3.6))
    for m in meshes:
        speeds = [v for label, v in found if label == m[0]]
        ax.plot(speeds, [radial(found[(m[0], v)][2]) for v in speeds], "o-", ms=4, lw=0.7, label=m[0])
    v = np.linspace(15, 80, 50)
    ax.plot(v, 4.0 * np.sqrt(v / 20.5), color="k", lw=0.8, label="measured: 4 at 20 m/s, as the root of the speed")
    ax.set(xlabel="speed (m/s)", ylabel="radial cracks", ylim=(0, 12))
    ax.legend(fontsize=7)
    figure.tight_layout()
    s.figure(figure, "number", "Radial cracks against the speed of the ball.")
    name, dt, _ = found[("0.5 mm", 60.0)]
    s.plot_energies(name, dt, "0.5 mm, 60 m/s")
    return {"radial cracks at 20 m/s": numbers[0], "radial cracks at 60 m/s": numbers[2], "radial cracks at 78 m/s": numbers[3],
            "exponent of the number over speed": slope,
            "largest rise of the total energy": 100 * max(s.energies(f[0]).rise() for f in found.values())}
