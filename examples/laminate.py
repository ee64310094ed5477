"""Reads what a run of a laminated example wrote, and finds out what still holds together.

Used by the analyse.py of laminated_beam, laminated_plate and curved_pane.
"""

import math
import re
import sys

import numpy as np

import results

# ---- files --------------------------------------------------------------------------------------


def read_log(path):
    """As results.read_log(), with the number of nodes and the last line of thermo output."""
    log = results.read_log(path)
    nodes = re.findall(r"^Nodes: (\d+)", log["text"], re.M)
    if not nodes:
        sys.exit(f"no number of nodes in {path}")
    return {**log, "nodes": int(nodes[0]), "last": {name: column[-1] for name, column in log["thermo"].items()}}


def read_mesh(path):
    """Nodes (m), elements (indices of nodes) and the part of each, as tools/layers2data wrote them."""
    section, nodes, hexes, parts = "", [], [], []
    for line in path.read_text().splitlines():
        words = line.split()
        if words[:1] in (["Atoms"], ["Hexes"]):
            section = words[0]
        elif words and section == "Atoms":
            nodes.append(words[4:7])
        elif words and section == "Hexes":
            parts.append(words[1])
            hexes.append(words[2:10])
    return {"x": np.array(nodes, float), "hexes": np.array(hexes, int) - 1, "parts": np.array(parts)}


def read_events(path):
    """Rows of the event file: step, time (us), kind, id, id2, position (mm), direction, value."""
    rows = []
    for line in path.read_text().splitlines():
        if line and line[0] != "#":
            w = line.split()
            rows.append((int(w[0]), 1e6 * float(w[1]), w[2], int(w[3]), int(w[4]),
                         1e3 * np.array(w[5:8], float), np.array(w[8:11], float), float(w[11])))
    return rows


# ---- what holds together ------------------------------------------------------------------------


class Sets:
    """Disjoint sets."""

    def __init__(self, n):
        self.parent = list(range(n))

    def find(self, a):
        parent = self.parent
        while parent[a] != a:
            parent[a] = parent[parent[a]]
            a = parent[a]
        return a

    def join(self, a, b):
        a, b = self.find(a), self.find(b)
        if a != b:
            self.parent[max(a, b)] = min(a, b)


# Natural coordinates of the corners, in the order of the nodes; corners that are neighbours along
# an edge; and the corners of the six faces.
CORNER = np.array([[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]])
EDGES = [(a, b) for a in range(8) for b in range(a) if np.abs(CORNER[a] - CORNER[b]).sum() == 2]
FACES = [np.flatnonzero(CORNER[:, k] == s) for k in range(3) for s in (-1, 1)]


def volumes(corner):
    """Of hexahedra with these corners, by 2 x 2 x 2 Gauss points, which is exact."""
    total = 0.0
    for point in CORNER / math.sqrt(3):
        factor = 1 + CORNER * point
        gradient = np.stack([CORNER[:, d] * np.delete(factor, d, axis=1).prod(axis=1) for d in range(3)], axis=1) / 8
        total = total + np.linalg.det(np.einsum("eac,ad->ecd", corner, gradient))
    return total


class Pieces:
    """The pieces of a body at the end of a run: finite elements that share nodes, DEs that are joined or
    tied. Rebuilt from the mesh and the events, without the solver's own records; check() compares the
    number of joints of each kind with the solver's.

    Units are the elements, 0 to n - 1, and the DEs of converted elements: n + 8 e + corner.
    """

    def __init__(self, mesh, events, first_de, density):
        self.mesh, self.n = mesh, len(mesh["hexes"])
        hexes = mesh["hexes"]
        corner = mesh["x"][hexes]
        self.mass = volumes(corner) * np.array([density[p] for p in mesh["parts"]])
        self.centre = corner.mean(axis=1)
        self.converted = np.zeros(self.n, bool)
        self.broken = {}  # (unit, unit) -> time
        de = lambda i: self.n + i - first_de - 1
        for _, time, kind, a, b, *_ in events:
            if kind == "convert":
                self.converted[a - 1] = True
            elif kind == "broken":
                self.broken[tuple(sorted((de(a), de(b))))] = time
            elif kind == "debonded":  # a tie: a DE and an element
                self.broken[(de(a), b - 1)] = time
        # joints and ties: pairs of units
        faces = {}
        for e, nodes in enumerate(hexes):
            for k, face in enumerate(FACES):
                faces.setdefault(tuple(sorted(nodes[face])), []).append((e, k))
        self.joints, self.ties = [], []
        for e in np.flatnonzero(self.converted):
            self.joints += [(self.n + 8 * e + a, self.n + 8 * e + b) for a, b in EDGES]
        for pair in faces.values():
            if len(pair) < 2:
                continue
            (e, ke), (f, kf) = pair
            if self.converted[e] and self.converted[f]:
                at = {hexes[f][b]: b for b in FACES[kf]}
                self.joints += [(self.n + 8 * e + a, self.n + 8 * f + at[hexes[e][a]]) for a in FACES[ke]]
            elif self.converted[e] or self.converted[f]:
                e, ke, f = (e, ke, f) if self.converted[e] else (f, kf, e)
                self.ties += [(self.n + 8 * e + a, f) for a in FACES[ke]]
        self.joints = [tuple(sorted(j)) for j in self.joints]

    def units(self, parts=None):
        """Elements and DEs there are, of some parts or of all."""
        some = np.ones(self.n, bool) if parts is None else np.isin(self.mesh["parts"], parts)
        dead = np.flatnonzero(self.converted & some)
        return np.concatenate([np.flatnonzero(some & ~self.converted), (self.n + 8 * dead[:, None] + np.arange(8)).ravel()])

    def element(self, unit):
        unit = np.asarray(unit)
        return np.where(unit < self.n, unit, (unit - self.n) // 8)

    def unit_mass(self, unit):
        return self.mass[self.element(unit)] / np.where(np.asarray(unit) < self.n, 1, 8)

    def connect(self, parts=None):
        """Sets of the units that hold together, within some parts or in all."""
        sets = Sets(9 * self.n)
        inside = np.ones(self.n, bool) if parts is None else np.isin(self.mesh["parts"], parts)
        first = {}
        for e in np.flatnonzero(inside & ~self.converted):
            for node in self.mesh["hexes"][e]:
                sets.join(first.setdefault(node, e), e)
        element = lambda u: u if u < self.n else (u - self.n) // 8
        for a, b in self.joints + self.ties:
            if inside[element(a)] and inside[element(b)] and (a, b) not in self.broken:
                sets.join(a, b)
        return sets

    def severed(self, part, axis=0):
        """When (us) the part alone was first in two: its ends along the axis not connected within it any
        more. None if they still are. From the end of the run backwards: joints are put back in the order
        in which they broke last."""
        sets, inside = self.connect([part]), self.mesh["parts"] == part
        x = self.centre[:, axis]
        ends = [np.flatnonzero(inside & (np.abs(x - x[inside].min()) < 1e-6)),
                np.flatnonzero(inside & (np.abs(x - x[inside].max()) < 1e-6))]
        roots = lambda end: {sets.find(u) for e in end for u in
                             ([e] if not self.converted[e] else range(self.n + 8 * e, self.n + 8 * e + 8))}
        if roots(ends[0]) & roots(ends[1]):
            return None
        for (a, b), time in sorted(self.broken.items(), key=lambda j: -j[1]):
            if inside[(a - self.n) // 8] and inside[(b - self.n) // 8]:
                sets.join(a, b)
                if roots(ends[0]) & roots(ends[1]):
                    return time
        return 0.0

    def check(self, last):
        """The numbers of joints and ties must be those of the fix in the last line of thermo output."""
        intact = sum(j not in self.broken for j in self.joints)
        mine = (intact, len(self.joints) - intact, sum(t not in self.broken for t in self.ties))
        fix = (last["connective"] + last["cohesive"], last["contact"], last["ties"] + last["softening"])
        if mine != fix:
            sys.exit(f"joints, broken joints and ties by the events: {mine}, by fix defe: {fix}")

    def summary(self, interlayer=None):
        """Pieces at the end, heaviest first, and the share of the brittle mass that holds on the interlayer."""
        sets, units = self.connect(), self.units()
        root = np.array([sets.find(u) for u in units])
        mass = self.unit_mass(units)
        heads, place = np.unique(root, return_inverse=True)
        weight = np.bincount(place, mass)
        count = np.bincount(place)
        order = np.argsort(-weight)
        single = (count == 1) & (heads >= self.n)
        result = {
            "pieces": len(heads),
            "pieces_of_one_DE": int(single.sum()),
            "pieces_of_more": int((~single).sum()),
            "heaviest_pieces_g": [round(1e3 * w, 4) for w in weight[order][:5]],
            "mass_of_loose_DEs_g": round(1e3 * weight[single].sum(), 4),
        }
        brittle = np.ones(len(units), bool)
        if interlayer:
            soft = self.mesh["parts"][self.element(units)] == interlayer
            brittle = ~soft
            on = np.isin(root, np.unique(root[soft]))
            result["glass_on_interlayer_percent"] = round(100 * mass[on & brittle].sum() / mass[brittle].sum(), 3)
            result["glass_off_interlayer_g"] = round(1e3 * mass[~on & brittle].sum(), 4)
        result["heaviest_piece_percent"] = round(100 * weight.max() / weight.sum(), 3)
        return result


# ---- pictures -----------------------------------------------------------------------------------


def impactor_force(energies, mass, name):
    """Force on the impactor (kN, upwards) from its velocity: the mean between two lines, at their middle."""
    t, v = energies["time_us"], energies[name]
    return 0.5 * (t[1:] + t[:-1]), 1e-3 * mass * np.diff(v) / (1e-6 * np.diff(t))


def sheet(path, title, cells, columns, width=720):
    """Pictures (file, caption) side by side and under each other."""
    import matplotlib.font_manager as fonts
    from PIL import Image, ImageDraw, ImageFont

    font = lambda size: ImageFont.truetype(fonts.findfont("DejaVu Sans"), size)
    head, bar, gap = 44, 34, 8
    images = []
    for file, caption in cells:
        image = Image.open(file).convert("RGB")
        images.append((image.resize((width, round(image.height * width / image.width)), Image.LANCZOS), caption))
    rows = [images[k:k + columns] for k in range(0, len(images), columns)]
    heights = [max(i.height for i, _ in row) + bar for row in rows]
    out = Image.new("RGB", (columns * (width + gap) + gap, head + sum(heights) + len(rows) * gap), "#d8d8d8")
    draw = ImageDraw.Draw(out)
    draw.text((gap + 4, 8), title, fill="black", font=font(24))
    top = head
    for row, height in zip(rows, heights):
        for k, (image, caption) in enumerate(row):
            left = gap + k * (width + gap)
            draw.rectangle((left, top, left + width - 1, top + height - 1), fill="white")
            out.paste(image, (left, top + (height - bar - image.height) // 2))
            draw.text((left + 12, top + height - bar + 4), caption, fill="black", font=font(20))
        top += height + gap
    out.quantize(256).save(path, optimize=True)  # few colours: small files


# ---- a pane under a ball --------------------------------------------------------------------------

ALLOWED_RISE = 0.1  # percent


def pane_report(folder, title, plies, interlayer, density):
    """All that laminated_plate and curved_pane make of a run in the folder: summary.json, energies.png,
    force.png, crack.png, and a table at the end of log.lammps. Fails if the total energy rises.

    plies: the parts of glass, from above; interlayer: a part or None; density: of each part, kg/m3.
    """
    log = read_log(folder / "log.lammps")
    energies = results.read_energies(folder / "energies.txt")
    mesh = read_mesh(folder / "mesh.data")
    events = read_events(folder / "events.txt")
    pieces = Pieces(mesh, events, log["nodes"], density)
    pieces.check(log["last"])

    # the ball's mass is 2 E/v^2 of the first line
    speed = energies["vz"]
    ball = 2 * energies["e_kinetic"][0] / speed[0]**2
    middle, force = impactor_force(energies, ball, "vz")
    part_of = lambda row: mesh["parts"][row[3] - 1 if row[2] == "convert" else (row[3] - log["nodes"] - 1) // 8]
    found = {}
    for ply in plies:
        rows = [r for r in events if part_of(r) == ply]
        times = {kind: [r[1] for r in rows if r[2] == kind] for kind in ("convert", "cohesive", "broken")}
        first = lambda t: round(min(t), 3) if t else None
        broken = [r for r in rows if r[2] == "broken"]
        found[ply] = {
            "first_conversion_us": first(times["convert"]),
            "first_damage_us": first(times["cohesive"] + times["broken"]),
            "first_broken_us": first(times["broken"]),
            "first_broken_at_mm": [round(float(c), 2) for c in min(broken, key=lambda r: r[1])[5]] if broken else None,
            "crack_radius_mm": round(float(max(math.hypot(*r[5][:2]) for r in broken)), 2) if broken else 0.0,
            "elements_converted": len(times["convert"]),
            "joints_broken": len(broken),
        }
    cracked = {p: s["first_damage_us"] for p, s in found.items() if s["first_damage_us"] is not None}
    held = pieces.summary(interlayer)
    brittle = np.flatnonzero(mesh["parts"] == plies[0])
    s = {
        "variant": folder.name,
        "element_mm": round(1e3 * float(np.median(np.linalg.norm(np.diff(
            mesh["x"][mesh["hexes"][brittle][:, :2]], axis=1), axis=2))), 3),
        "elements": len(mesh["hexes"]),
        "speed_m_s": round(-float(speed[0]), 6),
        "cracks_first": min(cracked, key=cracked.get) if cracked else None,
        "first_damage_us": min(cracked.values()) if cracked else None,
        "plies": found,
        "ball_g": round(1e3 * ball, 3),
        "ball_force_max_kN": round(float(force.max()), 3),
        "ball_force_max_us": round(float(middle[force.argmax()]), 2),
        "ball_energy_lost_J": round(0.5 * ball * (speed[0]**2 - speed[-1]**2), 4),
        "ball_speed_final_m_s": round(-float(speed[-1]), 4),
        "elements_converted": int(log["last"]["converted"]),
        "joints_broken": int(log["last"]["contact"]),
        "ties_broken": int(log["last"]["debonded"]),
        "held_together": held,
        "fracture_energy_mJ": round(1e3 * energies["fracture"][-1], 3),
        **results.totals(log, energies),
    }
    results.write_json(folder / "summary.json", s)

    us = lambda t: "-" if t is None else f"{t:.1f}"
    lines = [f"Pane, {title}, elements of {s['element_mm']:g} mm, after {s['end_us']:.0f} us",
             "  ply      first damage   first broken (us)   crack out to (mm)   elements converted   joints broken"]
    for ply, p in found.items():
        lines.append(f"  {ply:<8} {us(p['first_damage_us']):>12} {us(p['first_broken_us']):>19} {p['crack_radius_mm']:>19.1f}"
                     f" {p['elements_converted']:>20} {p['joints_broken']:>15}")
    lines += [
        f"  ball: force up to {s['ball_force_max_kN']:.2f} kN at {s['ball_force_max_us']:.1f} us, "
        f"{s['ball_energy_lost_J']:.3f} J lost, now {s['ball_speed_final_m_s']:.2f} m/s",
        f"  pieces: {held['pieces_of_more']}, and {held['pieces_of_one_DE']} single DEs of {held['mass_of_loose_DEs_g']:.3f} g; "
        f"the heaviest has {held['heaviest_piece_percent']:.2f} % of the mass",
    ]
    if interlayer:
        lines.append(f"  glass that holds on the interlayer: {held['glass_on_interlayer_percent']:.3f} %; "
                     f"ties broken: {s['ties_broken']}")
    lines.append(f"  total energy: {s['energy_initial_J']:.6f} J at first, {s['energy_final_J']:.6f} J at last, "
                 f"largest rise {s['energy_rise_percent']:.4f} % of the initial")
    results.report(folder / "log.lammps", "Pane,", lines)

    damage = [p["first_damage_us"] for p in found.values()]
    results.plot_energies(folder / "energies.png", f"{title}; dashed: first damage of the plies", energies, damage,
                          limit=ALLOWED_RISE)
    plt = results.plotting()
    figure, axis = plt.subplots(figsize=(8, 4), constrained_layout=True)
    axis.plot(middle, force, color="k")
    for time in damage:
        if time is not None:
            axis.axvline(time, color="#d33", lw=0.8, ls=(0, (4, 3)), zorder=0)
    axis.set(xlabel="us", ylabel="kN", xlim=(0, s["end_us"]), title=f"force on the ball, {title}; dashed: first damage")
    figure.savefig(folder / "force.png", dpi=100)

    time = lambda p: int(p.name.split(".")[1]) * s["end_us"] / s["steps"]
    cells = [(p, f"{time(p):.0f} us, from {view}") for view, glob in (("above", "top.*.png"), ("below", "bottom.*.png"))
             for p in sorted(folder.glob(glob), key=time)]
    if cells:
        sheet(folder / "crack.png", f"{title}, ball with {s['speed_m_s']:.0f} m/s", cells, len(cells) // 2, 480)
    if s["energy_rise_percent"] > ALLOWED_RISE:
        sys.exit(f"the total energy rises by {s['energy_rise_percent']} % of its initial value")
