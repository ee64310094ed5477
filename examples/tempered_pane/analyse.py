#!/usr/bin/env python3
"""What examples/tempered_pane/run.sh makes of a run: summary.json, energies.png, timeline.png, cells.png, crack.png, a table
in log.lammps.

analyse.py FOLDER     events.txt, energies.txt, pieces.dump, log.lammps, *.png of one run
"""

import re
import sys
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[1]), str(Path(__file__).resolve().parents[2] / "python")]
import defe
import laminate
from defe import plots, summary

ALLOWED_RISE = 0.5  # of the total energy, percent: there is no other than that of the stress
THICKNESS = 8e-3
LEAST = 4e-6  # m2: smaller cells are not counted
CORNERS = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)])  # of the DEs of an element
E, NU = 72e9, 0.22


def speed_of_crack(events):
    """m/s between a quarter and three quarters of the way that joints break away from the edge, or None."""
    broken = events.of("broken")
    if not len(broken):
        return None
    order = np.argsort(broken.time, kind="stable")
    time, reach = broken.time[order], np.maximum.accumulate(broken.x[order, 0])
    low, high = (float(time[np.argmax(reach >= share * reach[-1])]) for share in (0.25, 0.75))
    return round(0.5 * float(reach[-1]) / (high - low), 0) if high > low else None


def cut_at(events, n, through, layer):
    """Joints that soften or are broken in one layer of DEs: places (along x, along y) of both DEs, (joints, 2, 2). n, through:
    elements along an edge of the pane and through it."""
    ids = events.of("cohesive", "broken").ids
    nodes = (n + 1) ** 2 * (through + 1)  # IDs of DEs follow theirs, elements are numbered along x, then y, then z
    element, corner = np.divmod(ids - 1 - nodes, 8)
    place = 2 * np.stack([element % n, element // n % n, element // n**2], axis=-1) + CORNERS[corner]
    here = np.all(place[:, :, 2] == layer, axis=1)
    return place[here][:, :, :2]


def cells_of(cut, size):
    """Number of its cell for each of size x size DEs, (y, x), which cut joints divide."""
    parent = list(range(size * size))

    def root(k):
        while parent[k] != k:
            parent[k] = parent[parent[k]]
            k = parent[k]
        return k

    gone = {tuple(sorted(pair)) for pair in (cut[:, :, 1] * size + cut[:, :, 0]).tolist()}
    for k in range(size * size):
        for other in ([k + 1] if (k + 1) % size else []) + ([k + size] if k + size < size * size else []):
            if (k, other) not in gone:
                parent[root(other)] = root(k)
    return np.unique([root(k) for k in range(size * size)], return_inverse=True)[1].reshape(size, size)


def draw_cells(path, cell, counted, side, title):
    """The layer of DEs from above: cells that are counted in colours, smaller ones in grey."""
    plt = plots.plotting()
    colours = plt.get_cmap("hsv")((np.arange(counted.size) * 0.61803399) % 1.0)
    colours[:, :3] = 0.35 + 0.6 * colours[:, :3]
    colours[~counted] = (0.4, 0.4, 0.4, 1.0)
    figure, axis = plt.subplots(figsize=(6, 6), constrained_layout=True)
    axis.imshow(colours[cell], origin="lower", extent=(0, 1e3 * side, 0, 1e3 * side), interpolation="nearest")
    axis.set(title=title, xlabel="x (mm)", ylabel="y (mm)")
    figure.savefig(path, dpi=100)
    plt.close(figure)


def main(folder):
    log = defe.read_log(folder / "log.lammps")
    energies = defe.read_table(folder / "energies.txt")
    events = defe.read_events(folder / "events.txt")
    frame = defe.read_dump(folder / "pieces.dump")[-1]
    pieces = defe.fragments(frame["c_pieces"], frame["mass"])
    surface = log.value(r"Fix defe: prestress of part glass: parabola z 0 0\.008 surface -(\S+),", "the prestress")
    dt = float(log.value(r"Elements of \S+ m, steps of (\S+) s,", "the time step"))
    edge = float(log.value(r"Elements of (\S+) m,", "the size of elements"))
    area = pieces.mass.sum() / (2500 * THICKNESS)
    n, through = round(area**0.5 / edge), round(THICKNESS / edge)
    cell = cells_of(cut_at(events, n, through, through), 2 * n)  # in the layer of DEs beside the middle plane
    counted = np.bincount(cell.ravel()) * (0.5 * edge) ** 2 >= LEAST
    took = (energies["fracture"][-1] + energies["released"][-1]) / area
    # what is shut in by so much crack through the whole thickness, in squares
    coarse = re.findall(r"^Joints of part glass .* a joint releases (\S+) per area", log.text, re.M)
    per_joint = float((coarse or [log.value(r"Elements of .*, cracks take (\S+) J/m2", "the fracture energy")])[-1])
    squares = 2.5e-3 * (0.5 * took / per_joint / THICKNESS) ** 2
    s = {
        "surface_MPa": round(1e-6 * float(surface), 3),
        "area_mm2": round(1e6 * area, 1),
        "stored_per_area_J_m2": round((1 - NU) / E * float(surface) ** 2 * THICKNESS / 5, 2),
        "at_rest_J": float(log.value(r"Energy of the pane at rest: (\S+) J", "the energy at rest")),
        "first_damage_us": laminate.us(events.first("cohesive", "broken")),
        "crack_speed_m_s": speed_of_crack(events),
        "elements_converted": len(events.of("convert")),
        "joints_broken": len(events.of("broken")),
        "pieces": len(pieces),
        "single_DEs": int(pieces.single.sum()),
        "pieces_of_the_middle": int(counted.sum()),
        "pieces_of_the_middle_in_50_x_50_mm": round(int(counted.sum()) * 2.5e-3 / area, 1),
        "squares_in_50_x_50_mm": round(squares, 1),
        "fracture_J_m2": round(took, 2),
        "crack_area_by_pane_area": round(took / per_joint, 3),
        **summary.totals(log, energies),
    }
    summary.write_json(folder / "summary.json", s)
    summary.report(folder / "log.lammps", "Tempered,", [
        f"Tempered, {s['surface_MPa']:g} MPa at the faces, after {s['end_us']:.0f} us",
        f"  stored {s['stored_per_area_J_m2']:.1f} J per m2 of pane, of which cracks took {s['fracture_J_m2']:.1f}",
        f"  crack: {laminate.shown(s['crack_speed_m_s'])} m/s; {s['elements_converted']} elements converted, {s['joints_broken']} joints broken",
        f"  pieces: {s['pieces']}; cells of the middle plane above 2 x 2 mm: {s['pieces_of_the_middle']}, which is "
        f"{s['pieces_of_the_middle_in_50_x_50_mm']:.0f} in 50 x 50 mm",
        f"  {s['crack_area_by_pane_area']:.2f} times the area of the pane has cracked, which would shut in "
        f"{s['squares_in_50_x_50_mm']:.0f} squares in 50 x 50 mm",
        f"  total energy: {s['energy_initial_J']:.6f} J at first, {s['energy_final_J']:.6f} J at last, "
        f"largest rise {s['energy_rise_percent']:.4f} %",
    ])
    title = f"tempered pane, {s['surface_MPa']:g} MPa"
    plots.energies(folder / "energies.png", f"{title}; dashed: first damage", energies, [s["first_damage_us"]], limit=ALLOWED_RISE)
    plots.timeline(folder / "timeline.png", title, events, s["end_us"])
    draw_cells(folder / "cells.png", cell, counted, area**0.5, f"{title}, cells of the middle plane")
    cells = [(path, f"{time:.0f} us") for time, path in plots.pictures(folder, "top.*.png", dt)]
    if cells:
        plots.sheet(folder / "crack.png", title, cells, (len(cells) + 1) // 2, 480)
    summary.closing_line(folder, s)
    if s["energy_rise_percent"] > ALLOWED_RISE:
        sys.exit(f"the total energy rises by {s['energy_rise_percent']} % of its initial value")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    summary.main(main, Path(sys.argv[1]))
