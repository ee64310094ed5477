"""See README.md."""

import subprocess
import sys

import defe
import numpy as np
from manual import ROOT, Accept, plt

TITLE = "Three plies of laminated glass at low velocity: which break first"
CTU = "Zemanova et al., arXiv:2107.12151: panes of 3 and 4 plies under a pendulum"
PLOS = "Chen et al., PLoS ONE 9 (2014) e98196: two plies, 3.7 m/s"
PLY, FILM, STEEL = 3e-3, 0.76e-3, 7850.0
HEIGHT = 3 * PLY + 2 * FILM
PLIES = ("upper", "middle", "lower")
END = 1.5e-4

ACCEPTANCE = [
    Accept("an outer ply breaks first (1: yes)", CTU, low=1, high=1),
    Accept("the ball presses harder after the first ply has broken (1: yes)", CTU + ": in many cases", low=1, high=1, certain=False),
    Accept("radial cracks of the ply away from the ball", PLOS + ": they are counted there", low=3, high=12, certain=False),
    Accept("largest rise of the total energy", "exact", high=0.1, unit="%", digits=2),
]


def run(s):
    # elements along the pane and through a ply; none longer than twice its height
    meshes = {"2.5 mm": (40, 2), "2 mm": (50, 3), "1.5 mm": (67, 3)}
    jobs = [("2.5 mm", 3.7, "no"), ("2 mm", 3.7, "no")]
    if s.fine:
        jobs += [("1.5 mm", 3.7, "no"), ("2 mm", 7.4, "no"), ("2.5 mm", 3.7, "all")]

    def one(job):
        label, speed, start = job
        n, through = meshes[label]
        name = f"{label.replace(' ', '')}_{speed:g}_{start}"
        layers = [w for ply, film in (("lower", "film1"), ("middle", "film2"), ("upper", None))
                  for w in ["--layer", ply, str(PLY), str(through), "1"] + (["--layer", film, str(FILM), "1", "5"] if film else [])]
        subprocess.run([sys.executable, ROOT / "tools" / "layers2data", s.path(name + ".data"), "--axis", "z", *layers, "--x", "-0.05", str(n), "0.05",
                        "--y", "-0.05", str(n), "0.05"], check=True, stdout=subprocess.DEVNULL)
        dt = 3e-8
        s.lammps("in.laminate", name, mesh=name + ".data", height=HEIGHT, edge=0.1 / n, fs=0.1e3 * PLY / through, speed=speed, dt=dt, steps=int(END / dt), every=60, start=start)
        mesh, events = defe.read_mesh(s.path(name + ".data")), defe.read_events(s.path(name + ".events"))
        log = defe.read_log(s.path(name + ".log"))
        part = mesh.parts[events.elements_of(int(log.value(r"Nodes: (\d+)", "the number of nodes")))]
        s.path(name + ".data").unlink()
        step, v = np.loadtxt(s.path(name + ".ball")).T
        mass = STEEL * 4.0 / 3.0 * np.pi * 0.02**3
        return name, dt, {p: events.where(part == p) for p in PLIES}, defe.force_from_velocity(step * dt, v, mass)

    found = dict(zip(jobs, s.all(one, jobs)))

    def broken(ply):
        t = ply.first("broken")
        return np.inf if t is None else t

    def at(force, time):
        """Force (N) on the ball at this time, and the largest later."""
        if not np.isfinite(time):
            return np.nan, np.nan
        t, f = force
        return float(np.interp(time, t, f)), float(f[t > time].max(initial=0.0))

    rows = [["elements", "speed (m/s)", "", "first broken joint: upper, middle, lower (us)", "force then (kN)", "largest later (kN)",
             "radial cracks, lower", "joints broken: upper, middle, lower", "processor time (s)", "energy rises (%)"]]
    summary = {}
    for (label, speed, start), (name, dt, plies, force) in found.items():
        times = [broken(plies[p]) for p in PLIES]
        low = plies["lower"].of("broken")
        reach = np.hypot(low.x[:, 0], low.x[:, 1]).max(initial=0.0)
        radial = defe.cracks.count_radial(low.x, low.n, 0.65 * reach, 1.5e-3, 12.0) if len(low) else 0
        then, later = at(force, min(times))
        summary[(label, speed, start)] = times, then, later, radial
        rows.append([label, f"{speed:g}", "DEs" if start == "all" else "adaptive", ", ".join("-" if np.isinf(t) else f"{1e6 * t:.1f}" for t in times),
                     f"{1e-3 * then:.2f}", f"{1e-3 * later:.2f}", radial, ", ".join(str(len(plies[p].of("broken"))) for p in PLIES),
                     f"{s.loops[name]:.0f}", f"{100 * s.energies(name).rise():.4f}"])
    s.table("All runs:", rows)

    main = ("2 mm", 3.7, "no")
    name, dt, plies, force = found[main]
    figure, axes = plt.subplots(1, 4, figsize=(12, 3.3), gridspec_kw={"width_ratios": (1, 1, 1, 1.3)})
    for ax, p in zip(axes, PLIES):
        x = plies[p].of("broken").x * 1e3
        c = plies[p].of("convert").x * 1e3
        ax.scatter(c[:, 0], c[:, 1], s=4, marker="s", color="0.85", linewidths=0)
        ax.scatter(x[:, 0], x[:, 1], s=1.5, color="#1f4e9c", linewidths=0)
        ax.set(xlim=(-50, 50), ylim=(-50, 50), aspect="equal", title=p)
        ax.tick_params(labelsize=7)
    for (label, speed, start), (_, _, _, (t, f)) in found.items():
        axes[3].plot(1e6 * t, 1e-3 * f, lw=0.8, label=f"{label}, {speed:g} m/s{', DEs' if start == 'all' else ''}")
    axes[3].set(xlabel="time (us)", ylabel="force on the ball (kN)")
    axes[3].legend(fontsize=7)
    figure.tight_layout()
    s.figure(figure, "cracks", "Broken joints (blue) and converted elements (grey) of the three plies, in mm, 3.7 m/s, 2 mm; force on the ball.")
    s.plot_energies(name, dt, "3.7 m/s, 2 mm")
    times, then, later, radial = summary[main]
    first = PLIES[int(np.argmin(times))] if np.isfinite(min(times)) else "none"
    return {
        "an outer ply breaks first (1: yes)": int(first in ("upper", "lower")),
        "the ball presses harder after the first ply has broken (1: yes)": int(later > then),
        "radial cracks of the ply away from the ball": radial,
        "largest rise of the total energy": 100.0 * max(s.energies(f[0]).rise() for f in found.values()),
    }
