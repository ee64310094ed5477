#!/usr/bin/env python3
"""What examples/tempered_pane/run.sh makes of a run: summary.json, energies.png, timeline.png, cells.png, crack.png, a table
in log.lammps.

analyse.py FOLDER                    events.txt, energies.txt, pieces.dump, log.lammps, *.png of one run
analyse.py --compare PLOT FOLDER...  cells and squares of some runs, analysed before, beside what is published
"""

import functools
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
NECK = 0.5e-3  # m: between cracks that end beside one another
MIDDLE = 0.5e-3  # m: layers so near to the middle plane are counted, and the mean is taken
SHIELD = 1.5  # spacings of DEs: so near to a crack glass takes more (overstrength), so that the next one ends in a neck as wide as that
CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
E, NU = 72e9, 0.22
PUBLISHED = {102: 79, 112: 100, 136: 193, 154: 207, 163: 215}  # MPa at the faces: fragments in 50 x 50 mm, means of 4 to 15 panes


def places_of(split):
    """Of the DEs of an element, (split^3, 3) from 0: those at corners in the order of its nodes, then the others, along x first."""
    corners = [tuple((split - 1) * c for c in corner) for corner in CORNERS] if split > 1 else []
    others = [(x, y, z) for z in range(split) for y in range(split) for x in range(split)]
    return np.array(corners + [place for place in others if place not in corners])


def speed_of_crack(events, at, side):
    """m/s between a quarter and three quarters of the way that joints break away from `at` (x, y), or None. An edge is
    struck at x = 0, and a piece in its middle."""
    broken = events.of("broken")
    if not len(broken):
        return None
    order = np.argsort(broken.time, kind="stable")
    away = broken.x[order, 0] if at[0] == 0 else np.hypot(*(broken.x[order, :2] - at).T)
    time, reach = broken.time[order], np.maximum.accumulate(np.minimum(away, side - at[0]))
    low, high = (float(time[np.argmax(reach >= share * reach[-1])]) for share in (0.25, 0.75))
    return round(0.5 * float(reach[-1]) / (high - low), 0) if high > low else None


def cuts_of(cut, n, through, split, closed=False):
    """Of the joints of some events: places (along x, y, z) of both DEs, (joints, 2, 3), and the area of the crack that each
    stands for, by that of its face, |a . m| (pair_style defe/joint). n, through: elements along an edge and through the pane.
    closed: with itself, along x and y."""
    nodes = (n if closed else n + 1) ** 2 * (through + 1)  # IDs of DEs follow theirs, elements are numbered along x, then y, then z
    element, k = np.divmod(cut.ids - 1 - nodes, split**3)
    place = split * np.stack([element % n, element // n % n, element // n**2], axis=-1) + places_of(split)[k]
    steps = np.abs(place[:, 1] - place[:, 0])
    if closed:
        steps[:, :2] = np.minimum(steps[:, :2], split * n - steps[:, :2])
    if not (steps.sum(axis=1) == 1).all():
        sys.exit("events.txt has joints between DEs that are no neighbours: is it of this mesh?")
    return place, np.abs((cut.n * steps).sum(axis=1))


def nuclei_of(place, time, size, closed=False):
    """Which joints, (joints, 2, 3) as from cuts_of, began to soften with no earlier one in the rings of four DEs that they are in:
    a boolean for each. size: DEs along an edge of the pane. Joints of one time are no earlier ones to each other."""
    across = np.abs(place[:, 1] - place[:, 0]).max(axis=1) > 1  # the border
    upper = place.max(axis=1)
    axis = np.argmax(np.abs(place[:, 1] - place[:, 0]), axis=1)
    upper[across, axis[across]] = 0
    rings = []  # of each joint: the edges of the face between its DEs, as (corner, direction)
    for corner, k in zip(upper.tolist(), axis.tolist()):
        p, q = (i for i in range(3) if i != k)
        mine = []
        for along, side in ((p, q), (q, p)):
            for step in (0, 1):
                at = list(corner)
                at[side] += step
                if closed:
                    at[0], at[1] = at[0] % size, at[1] % size
                mine.append((*at, along))
        rings.append(mine)
    first = {}
    for mine, t in zip(rings, time.tolist()):
        for ring in mine:
            first[ring] = min(first.get(ring, t), t)
    return np.array([all(first[ring] >= t for ring in mine) for mine, t in zip(rings, time.tolist())], bool)


def cells_of(cut, size, closed=False, left_out=None):
    """Number of its cell for each of size x size DEs, (y, x), which cut joints (joints, 2, 2) divide. closed: the last of a
    row and of a column has a joint to the first. left_out: DEs that hold nothing together, each a cell of its own."""
    parent = list(range(size * size))

    def root(k):
        while parent[k] != k:
            parent[k] = parent[parent[k]]
            k = parent[k]
        return k

    alone = np.zeros(size * size, bool) if left_out is None else left_out.ravel()
    gone = {tuple(sorted(pair)) for pair in (cut[:, :, 1] * size + cut[:, :, 0]).tolist()}
    for k in range(size * size):
        right = k + 1 if (k + 1) % size else k + 1 - size
        above = (k + size) % (size * size)
        for other in (right, above):
            if (other > k or closed) and not (alone[k] or alone[other]) and (min(k, other), max(k, other)) not in gone:
                parent[root(other)] = root(k)
    return np.unique([root(k) for k in range(size * size)], return_inverse=True)[1].reshape(size, size)


def inside_of(cut, cell):
    """Which cut joints (joints, 2, 2) have the same cell, (y, x), on both sides: they end inside of it, and part nothing."""
    return cell[cut[:, 0, 1], cut[:, 0, 0]] == cell[cut[:, 1, 1], cut[:, 1, 0]]


def near_cuts(cut, size, reach, closed=False):
    """Which of size x size DEs, (y, x), have their centre within `reach` (DEs) of the middle of one of these joints."""
    middle = cut.sum(axis=1)  # in halves of a DE; of a joint across the border it is half a DE behind the last one
    across = np.abs(cut[:, 1] - cut[:, 0]) > 1
    middle[across] = (2 * cut.max(axis=1) + 1)[across]
    near = np.zeros((size, size), bool)
    steps = range(-int(2 * reach) - 1, int(2 * reach) + 2)
    for dx, dy in ((dx, dy) for dx in steps for dy in steps if dx * dx + dy * dy <= (2 * reach) ** 2 + 1e-9):
        at = middle + (dx, dy)
        at = at[(at % 2 == 0).all(axis=1)] // 2
        at = at % size if closed else at[((at >= 0) & (at < size)).all(axis=1)]
        near[at[:, 1], at[:, 0]] = True
    return near


def draw_cells(path, cell, counted, cut, side, title):
    """The layer of DEs from above: cells that are counted in colours, smaller ones in grey, cut joints (joints, 2, 2) in black."""
    plt = plots.plotting()
    colours = plt.get_cmap("hsv")((np.arange(counted.size) * 0.61803399) % 1.0)
    colours[:, :3] = 0.35 + 0.6 * colours[:, :3]
    colours[~counted] = (0.4, 0.4, 0.4, 1.0)
    figure, axis = plt.subplots(figsize=(6, 6), constrained_layout=True)
    axis.imshow(colours[cell], origin="lower", extent=(0, 1e3 * side, 0, 1e3 * side), interpolation="nearest")
    upper = np.where(np.abs(cut[:, 1] - cut[:, 0]) > 1, 0, cut.max(axis=1))  # of both DEs, the one behind the face between them
    along = (cut[:, 0] == cut[:, 1]).astype(int)  # the face's direction
    ends = 1e3 * side / len(cell) * np.stack([upper, upper + along], axis=1)
    axis.plot(*np.stack([ends[:, 0], ends[:, 1], np.full_like(ends[:, 0], np.nan)], axis=1).reshape(-1, 2).T, "k-", linewidth=1.0)
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
    dt = float(log.value(r"Elements of \S+ m, split \d, steps of (\S+) s,", "the time step"))
    edge = float(log.value(r"Elements of (\S+) m,", "the size of elements"))
    split = int(log.value(r"Elements of \S+ m, split (\d),", "the number of DEs"))
    G_f = float(log.value(r"Elements of .*, cracks take (\S+) J/m2", "the fracture energy"))
    sides = log.value(r"Sides of the pane: (\S+)", "the sides")
    ring, closed = int(sides == "symmetric"), sides == "periodic"
    whole = pieces.mass.sum() / (2500 * THICKNESS)
    n, through = round(whole**0.5 / edge), round(THICKNESS / edge)
    side, d = (n - 2 * ring) * edge, edge / split
    area = side**2  # of what can crack
    layer = split * through // 2  # of the DEs beside the middle plane

    @functools.lru_cache(None)
    def joints(kind):
        """All of a kind: events, places and areas as from cuts_of."""
        cut = events.of(kind)
        return cut, *cuts_of(cut, n, through, split, closed)

    def cuts(kind, at):
        """In one layer: places (along x, y) of both DEs, the area of cracks that each joint stands for, by that of the pane, if all
        layers had as much, and times (s)."""
        cut, place, share = joints(kind)
        inside = np.all(place[:, :, 2] == at, axis=1)
        return place[inside][:, :, :2], d * share[inside] * THICKNESS / area, cut.time[inside]

    def cells(place, neck=None):
        """Of a layer, and which are large enough to be counted. neck (DEs): where cracks end within that of another one, they meet it."""
        place, size = place - split * ring, split * (n - 2 * ring)
        cell = cells_of(place, size, closed, None if neck is None else near_cuts(place, size, neck, closed))
        return cell, np.bincount(cell.ravel()) * d**2 >= LEAST

    def squares(cracked):
        """In 50 x 50 mm, that straight cracks through the pane of this area would shut in."""
        return 2.5e-3 * (0.5 * cracked / THICKNESS) ** 2

    place, share, time = cuts("cohesive", layer)  # and broken ones
    softening, broken = share.sum(), cuts("broken", layer)[1].sum()
    cell, counted = cells(place)
    size = np.bincount(cell.ravel()) * d**2
    ends_inside = inside_of(place - split * ring, cell)
    end = float(energies["time_us"][-1])
    over_time = {f"{t:g}": int(cells(place[time <= 1e-6 * t])[1].sum()) for t in np.arange(2.0, end + 1e-9, 2.0)}
    torn = int(cells(place, 0.5 * NECK / d)[1].sum())
    layers = [k for k in range(split * through) if abs((k + 0.5) * d - 0.5 * THICKNESS) < MIDDLE]
    of_layers = [cuts("cohesive", k)[0] for k in layers]
    closed_of_layers = float(np.mean([cells(p)[1].sum() for p in of_layers]))
    parted_of_layers = float(np.mean([cells(p, SHIELD)[1].sum() for p in of_layers]))
    faces = [cuts("cohesive", k)[1].sum() for k in (0, split * through - 1)]
    began, of_began, _ = joints("cohesive")
    away = nuclei_of(of_began, began.time, split * n, closed)
    took = (energies["fracture"][-1] + energies["released"][-1]) / area
    middle = 0.5 * n * edge
    s = {
        "surface_MPa": round(1e-6 * float(surface), 3),
        "sides": sides,
        "area_mm2": round(1e6 * area, 1),
        "stored_per_area_J_m2": round((1 - NU) / E * float(surface) ** 2 * THICKNESS / 5, 2),
        "at_rest_per_area_J_m2": round(float(log.value(r"Energy of the pane at rest: (\S+) J", "the energy at rest")) / whole, 2),
        "at_rest_J": float(log.value(r"Energy of the pane at rest: (\S+) J", "the energy at rest")),
        "first_damage_us": laminate.us(events.first("cohesive", "broken")),
        "crack_speed_m_s": speed_of_crack(events, (0.0 if sides == "free" else middle, middle), n * edge),
        "elements_converted": len(events.of("convert")),
        "joints_broken": len(events.of("broken")),
        "joints_softened": len(began),
        "nuclei": int(away.sum()),
        "pieces": len(pieces),
        "single_DEs": int(pieces.single.sum()),
        "pieces_of_the_middle": int(counted.sum()),
        "pieces_of_the_middle_in_50_x_50_mm": round(int(counted.sum()) * 2.5e-3 / area, 1),
        "pieces_without_necks_in_50_x_50_mm": round(torn * 2.5e-3 / area, 1),
        "layers": len(layers),
        "closed_cells_of_layers_in_50_x_50_mm": round(closed_of_layers * 2.5e-3 / area, 1),
        "cells_of_layers_in_50_x_50_mm": round(parted_of_layers * 2.5e-3 / area, 1),
        "pieces_of_the_middle_after_us": over_time,
        "share_of_cracks_inside_of_pieces": round(float(share[ends_inside].sum() / softening), 3) if softening else None,
        "share_of_area_in_these_pieces": round(float(size[counted].sum()) / area, 3),
        "squares_in_50_x_50_mm": round(squares(broken), 1),
        "squares_of_softening_joints_too": round(squares(softening), 1),
        "fracture_J_m2": round(took, 2),
        "crack_area_by_pane_area": round(float(energies["fracture"][-1]) / (G_f * area), 3),
        "taken_per_crack_area_J_m2": round(took * G_f * area / float(energies["fracture"][-1]), 2) if energies["fracture"][-1] > 0.0 else None,
        "crack_area_of_lower_middle_upper_layer": [round(float(a), 3) for a in (faces[0], softening, faces[1])],
        **summary.totals(log, energies),
    }
    summary.write_json(folder / "summary.json", s)
    summary.report(folder / "log.lammps", "Tempered,", [
        f"Tempered, {s['surface_MPa']:g} MPa at the faces, after {s['end_us']:.0f} us",
        f"  stored {s['stored_per_area_J_m2']:.1f} J per m2 of pane, of which cracks took {s['fracture_J_m2']:.1f}",
        f"  crack: {laminate.shown(s['crack_speed_m_s'])} m/s; {s['elements_converted']} elements converted, {s['joints_broken']} joints broken",
        f"  {s['nuclei']} of {s['joints_softened']} joints began to soften away from every crack",
        f"  pieces: {s['pieces']}; cells of the middle plane above 2 x 2 mm: {s['pieces_of_the_middle']}, which is "
        f"{s['pieces_of_the_middle_in_50_x_50_mm']:.0f} in 50 x 50 mm; after " + ", ".join(f"{t} us {k}" for t, k in over_time.items()),
        f"  mean of {s['layers']} layers within {1e3 * MIDDLE:g} mm of the middle plane: {s['closed_cells_of_layers_in_50_x_50_mm']:.0f} in 50 x 50 mm, "
        f"{s['cells_of_layers_in_50_x_50_mm']:.0f} where cracks that end within {SHIELD:g} spacings of another one meet it",
        f"  cracks that end inside of a cell: {100 * (s['share_of_cracks_inside_of_pieces'] or 0):.0f} % of their length beside the middle plane",
        f"  {s['crack_area_by_pane_area']:.2f} times the area of the pane has cracked, with {laminate.shown(s['taken_per_crack_area_J_m2'])} J/m2; as long cracks as beside the middle plane would "
        f"shut in {s['squares_in_50_x_50_mm']:.0f} squares in 50 x 50 mm, with those that soften {s['squares_of_softening_joints_too']:.0f}",
        f"  total energy: {s['energy_initial_J']:.6f} J at first, {s['energy_final_J']:.6f} J at last, "
        f"largest rise {s['energy_rise_percent']:.4f} %",
    ])
    title = f"tempered pane, {s['surface_MPa']:g} MPa"
    plots.energies(folder / "energies.png", f"{title}; dashed: first damage", energies, [s["first_damage_us"]], limit=ALLOWED_RISE)
    plots.timeline(folder / "timeline.png", title, events, s["end_us"])
    draw_cells(folder / "cells.png", cell, counted, place - split * ring, side, f"{title}, cells of the middle plane")
    cells = [(path, f"{time:.0f} us") for time, path in plots.pictures(folder, "top.*.png", dt)]
    if cells:
        plots.sheet(folder / "crack.png", title, cells, (len(cells) + 1) // 2, 480)
    summary.closing_line(folder, s)
    if s["energy_rise_percent"] > ALLOWED_RISE:
        sys.exit(f"the total energy rises by {s['energy_rise_percent']} % of its initial value")


def compare(path, folders):
    """A plot of counts over the stress at the faces."""
    runs = sorted((defe.read_summary(Path(folder) / "summary.json") for folder in folders), key=lambda s: s["surface_MPa"])
    stress = [s["surface_MPa"] for s in runs]
    plt = plots.plotting()
    figure, axis = plt.subplots(figsize=(6, 4), constrained_layout=True)
    published = np.array(list(PUBLISHED.items()), float).T
    axis.fill_between(published[0], 0.5 * published[1], 2 * published[1], color="0.9", label="half to twice of it")
    axis.plot(*published, "k-s", label="published, mean counts of fragments")
    axis.plot(stress, [s["squares_in_50_x_50_mm"] for s in runs], "o-", color="#1f4e9c", label="here, squares of as long cracks")
    axis.plot(stress, [s["cells_of_layers_in_50_x_50_mm"] for s in runs], "s--", color="#c0504d", label=f"here, cells above 4 mm2, necks of {SHIELD:g} spacings cut")
    axis.plot(stress, [s["closed_cells_of_layers_in_50_x_50_mm"] for s in runs], "^:", color="#c0504d", label="here, closed cells above 4 mm2")
    axis.set(xlabel="compression at the faces (MPa)", ylabel="in 50 x 50 mm", ylim=(0, None))
    axis.legend()
    figure.savefig(path, dpi=110)
    plt.close(figure)


if __name__ == "__main__":
    if len(sys.argv) > 3 and sys.argv[1] == "--compare":
        compare(Path(sys.argv[2]), sys.argv[3:])
    elif len(sys.argv) == 2:
        summary.main(main, Path(sys.argv[1]))
    else:
        sys.exit(__doc__)
