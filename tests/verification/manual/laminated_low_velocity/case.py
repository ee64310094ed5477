"""See README.md."""

import subprocess
import sys

import defe
import numpy as np
from manual import ROOT, Accept, plt

SLOW = True
TITLE = "Three plies of laminated glass at low velocity: which break first"
CTU = "Zemanova et al., arXiv:2107.12151: panes of 3 and 4 plies under a pendulum"
PLOS = "Chen et al., PLoS ONE 9 (2014) e98196: two plies, 3.7 m/s"
PLY, FILM, STEEL = 3e-3, 0.76e-3, 7850.0
HEIGHT = 3 * PLY + 2 * FILM
PLIES = ("upper", "middle", "lower")
END = 1.5e-4
TURNED = "2 mm, turned by 45 degrees"

ACCEPTANCE = [
    Accept("an outer ply breaks first (1: yes)", CTU, low=1, high=1),
    Accept("the ball presses harder after the first ply has broken (1: yes)", CTU + ": in many cases", low=1, high=1, certain=False),
    Accept("radial cracks of the ply away from the ball", PLOS + ": they are counted there", low=3, high=12, certain=False),
    Accept("largest rise of the total energy", "exact", high=0.1, unit="%", digits=2),
]


def run(s):
    # elements along the pane and through a ply; none longer than twice its height
    meshes = {"2.5 mm": (40, 2), "2 mm": (50, 3), TURNED: (50, 3), "1.5 mm": (67, 3), "1 mm": (100, 3)}
    # the slowest first, so that the last core is not alone with it
    jobs = [("1.5 mm", 3.7, "no"), ("2.5 mm", 3.7, "all"), ("2 mm", 3.7, "no"), (TURNED, 3.7, "no"), ("2.5 mm", 3.7, "no")]
    if s.fine:
        jobs = [("1 mm", 3.7, "no"), ("2 mm", 7.4, "no")] + jobs

    def one(job):
        label, speed, start = job
        n, through = meshes[label]
        name = f"{label.replace(' ', '').replace(',', '_')}_{speed:g}_{start}"
        layers = [w for ply, film in (("lower", "film1"), ("middle", "film2"), ("upper", None))
                  for w in ["--layer", ply, str(PLY), str(through), "1"] + (["--layer", film, str(FILM), "1", "5"] if film else [])]
        data = s.path(name + ".data")
        make = ([ROOT / "examples" / "laminated_plate" / "mesh.py", data, "turned", "--size", "2", *layers] if label == TURNED else
                [ROOT / "tools" / "layers2data", data, "--axis", "z", *layers, "--x", "-0.05", str(n), "0.05", "--y", "-0.05", str(n), "0.05"])
        subprocess.run([sys.executable, *make], check=True, stdout=subprocess.DEVNULL)
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
    finest = {label: k for k, label in enumerate(meshes)}
    ordered = sorted(found.items(), key=lambda run: (run[0][1], run[0][2] == "all", finest[run[0][0]]))
    for (label, speed, start), (name, dt, plies, force) in ordered:
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

    main = ("1 mm" if s.fine else "1.5 mm", 3.7, "no")
    figure, axes = plt.subplots(len(ordered), 3, figsize=(7.5, 2.6 * len(ordered)), sharex=True, sharey=True, squeeze=False)
    for row, ((label, speed, start), (_, _, plies, _)) in zip(axes, ordered):
        for ax, p in zip(row, PLIES):
            x = plies[p].of("broken").x * 1e3
            c = plies[p].of("convert").x * 1e3
            ax.scatter(c[:, 0], c[:, 1], s=3, marker="s", color="0.85", linewidths=0)
            ax.scatter(x[:, 0], x[:, 1], s=1, color="#1f4e9c", linewidths=0)
            ax.set(xlim=(-50, 50), ylim=(-50, 50), aspect="equal")
            ax.set_title(f"{p}, {label}{', ' + format(speed, 'g') + ' m/s' if speed != 3.7 else ''}{', all DEs' if start == 'all' else ''}", fontsize=7)
            ax.tick_params(labelsize=6)
    figure.tight_layout()
    s.figure(figure, "cracks", "Broken joints (blue) and converted elements (grey) of the three plies after 150 us, in mm.")
    figure, ax = plt.subplots(figsize=(6, 3.6))
    for (label, speed, start), (_, _, _, (t, f)) in ordered:
        ax.plot(1e6 * t, 1e-3 * f, lw=0.8, label=f"{label}, {speed:g} m/s{', all DEs' if start == 'all' else ''}")
    ax.set(xlabel="time (us)", ylabel="force on the ball (kN)", ylim=(0, None))
    ax.legend(fontsize=7)
    figure.tight_layout()
    s.figure(figure, "force", "Force on the ball.")
    name, dt = found[main][:2]
    s.plot_energies(name, dt, f"3.7 m/s, {main[0]}")
    times, then, later, radial = summary[main]
    first = PLIES[int(np.argmin(times))] if np.isfinite(min(times)) else "none"
    return {
        "an outer ply breaks first (1: yes)": int(first in ("upper", "lower")),
        "the ball presses harder after the first ply has broken (1: yes)": int(later > then),
        "radial cracks of the ply away from the ball": radial,
        "largest rise of the total energy": 100.0 * max(s.energies(f[0]).rise() for f in found.values()),
    }
