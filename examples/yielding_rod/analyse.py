#!/usr/bin/env python3
"""What examples/yielding_rod/run.sh makes of a run: summary.json, energies.png, timeline.png, rod.png, crack.png, a table in log.lammps.

analyse.py run FOLDER     events.txt, energies.txt, rod.dump, log.lammps, *.png of one run
analyse.py compare ROOT   force.png of the variants in ROOT
"""

import os
import sys
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[1]), str(Path(__file__).resolve().parents[2] / "python")]
import defe
import laminate
from defe import plots, summary

ROD = 2         # number of its part
LENGTH, WIDTH = 0.018, 0.006
TITLES = {"yielding": "copper", "elastic": "the same, elastic"}


def force_on_rod(energies):
    """Times (s) and force (N) on the rod, from its velocity."""
    return defe.force_from_velocity(energies.seconds(), energies["vz"], float(energies["m"][0]))


def rod_of(frame):
    """Positions (m, n x 3) of the rod's elements and their plastic strain."""
    own = frame["c_strain[1]"] == ROD
    return np.column_stack([frame[f"c_strain[{k}]"][own] for k in (2, 3, 4)]), frame["c_strain[5]"][own]


def ids_of_rod(frame):
    return frame["c_strain[7]"][frame["c_strain[1]"] == ROD]


def measure(folder):
    log = defe.read_log(folder / "log.lammps")
    energies = defe.read_table(folder / "energies.txt")
    events = defe.read_events(folder / "events.txt")
    frames = defe.read_dump(folder / "rod.dump")
    first, last = rod_of(frames[0])[0], rod_of(frames[-1])
    time, force = force_on_rod(energies)
    end = last[0][:, 2] < np.min(last[0][:, 2]) + 0.1 * LENGTH
    s = {
        "variant": folder.name,
        "first_damage_us": laminate.us(events.first("cohesive", "broken")),
        "force_max_kN": round(1e-3 * float(force.max()), 3),
        "force_max_us": round(1e6 * float(time[force.argmax()]), 2),
        "rod_leaves_with_m_s": round(float(energies["vz"][-1]), 3),
        "plastic_strain_max": round(float(last[1].max()), 4),
        "plastic_work_J": round(float(energies["viscous"][-1]), 5),
        "rod_length_mm": round(1e3 * LENGTH * float(np.ptp(last[0][:, 2]) / np.ptp(first[:, 2])), 3),
        "rod_end_width_mm": round(1e3 * WIDTH * float(np.ptp(last[0][end, 0]) / np.ptp(first[:, 0])), 3),
        "elements_converted": len(events.of("convert")),
        "joints_broken": len(events.of("broken")),
        **summary.totals(log, energies),
    }
    return s, energies, events, frames


def corners(centres):
    """Corners (n + 1, m + 1) of a grid of quadrangles with these centres (n, m): means of four, beyond the rim as inside it."""
    wide = np.pad(centres, 1, mode="reflect", reflect_type="odd")
    return 0.25 * (wide[:-1, :-1] + wide[1:, :-1] + wide[:-1, 1:] + wide[1:, 1:])


def draw_rod(path, frames, dt, title):
    """The layer of elements beside the rod's middle plane, coloured by plastic strain, at the times of the frames."""
    plt = plots.plotting()
    shown = frames[:4]
    figure, axes = plt.subplots(1, len(shown), figsize=(2.6 * len(shown), 5.2), sharex=True, sharey=True, squeeze=False, constrained_layout=True)
    axes = axes[0]
    start, ids = rod_of(frames[0])[0], ids_of_rod(frames[0])
    layer = (start[:, 1] > 0.0) & (start[:, 1] < 2.0 * np.min(abs(start[:, 1])))
    rows = len(set(np.round(start[layer, 2], 7)))
    # IDs of the layer, row by row upwards; the order of entries in a dump is that of ranks
    grid = ids[layer][np.lexsort((start[layer, 0], np.round(start[layer, 2], 7)))].reshape(rows, -1)
    most = max(float(rod_of(f)[1].max()) for f in shown) or 1.0
    for axis, frame in zip(axes, shown):
        x, strain = rod_of(frame)
        ids = ids_of_rod(frame)
        order = np.argsort(ids)
        at = order[np.searchsorted(ids[order], grid)]
        image = axis.pcolormesh(1e3 * corners(x[at, 0]), 1e3 * corners(x[at, 2]), strain[at], vmin=0.0, vmax=most,
                                cmap="inferno_r", edgecolors="#888888", linewidth=0.4, antialiased=True, snap=False)
        axis.use_sticky_edges = False
        axis.margins(0.15, 0.03)
        axis.axhline(8.0, color="#6aa0c8")
        axis.set(title=f"{1e6 * dt * frame.step:.0f} us", xlabel="x (mm)", aspect="equal")
    axes[0].set_ylabel("z (mm); line: face of the pane before the blow")
    figure.colorbar(image, ax=axes, label="plastic strain")
    figure.suptitle(title)
    figure.savefig(path, dpi=100)
    plt.close(figure)


def analyse_run(folder):
    s, energies, events, frames = measure(folder)
    summary.write_json(folder / "summary.json", s)
    title = f"rod on a pane: {TITLES.get(s['variant'], s['variant'])}"
    summary.report(folder / "log.lammps", "Rod on a pane,", [
        f"Rod on a pane, {TITLES.get(s['variant'], s['variant'])}, after {s['end_us']:.0f} us",
        f"  force up to {s['force_max_kN']:.2f} kN at {s['force_max_us']:.1f} us; the rod leaves with {s['rod_leaves_with_m_s']:.2f} m/s",
        f"  plastic work {s['plastic_work_J']:.4f} J of {s['energy_initial_J']:.4f} J; plastic strain up to {s['plastic_strain_max']:.3f}; "
        f"the rod is {s['rod_length_mm']:.2f} mm long, its end {s['rod_end_width_mm']:.2f} mm wide",
        f"  first damage at {laminate.shown(s['first_damage_us'])} us; {s['elements_converted']} elements converted, {s['joints_broken']} joints broken",
    ])
    dt = 1e-6 * s["end_us"] / s["steps"]
    plots.energies(folder / "energies.png", f"{title}; dashed: first damage", energies, [s["first_damage_us"]], limit=laminate.ALLOWED_RISE)
    plots.timeline(folder / "timeline.png", title, events, s["end_us"])
    draw_rod(folder / "rod.png", frames, dt, title)
    cells = [(path, f"{view}, {time:.0f} us") for view in ("bottom", "side") for time, path in plots.pictures(folder, f"{view}.*.png", dt)]
    if cells:
        plots.sheet(folder / "crack.png", title, cells, len(cells), 480)
    summary.closing_line(folder, s)
    if s["energy_rise_percent"] > laminate.ALLOWED_RISE:
        sys.exit(f"yielding_rod: the total energy rises by {s['energy_rise_percent']} % of its initial value")


def compare(root):
    plt = plots.plotting()
    figure, axis = plt.subplots(figsize=(8, 4), constrained_layout=True)
    for variant, colour in (("yielding", "#b5651d"), ("elastic", "#444444")):
        energies = defe.read_table(root / variant / "energies.txt")
        time, force = force_on_rod(energies)
        axis.plot(1e6 * time, 1e-3 * force, color=colour, label=TITLES[variant])
    axis.set(xlabel="us", ylabel="kN", title="force on the rod", xlim=(0, 40))
    axis.grid(alpha=0.3)
    axis.legend()
    figure.savefig(root / "force.png", dpi=100)
    print(f"force.png in {os.path.relpath(root)}")


def main(argv):
    match argv:
        case ["run", folder]:
            analyse_run(Path(folder))
        case ["compare", root]:
            compare(Path(root))
        case _:
            sys.exit(__doc__)


if __name__ == "__main__":
    summary.main(main, sys.argv[1:])
