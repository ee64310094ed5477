"""Reads what a run of a laminated example wrote, and finds out what still holds together.

Used by the analyse.py of laminated_beam and laminated_plate.
"""

import json
import re
import sys

import numpy as np

# ---- files --------------------------------------------------------------------------------------


def read_log(path):
    """Loop time, ranks, steps over all pieces of the run, number of nodes, the last line of thermo output."""
    text = path.read_text()
    loops = re.findall(r"^Loop time of (\S+) on (\d+) procs for (\d+) steps", text, re.M)
    nodes = re.findall(r"^Nodes: (\d+)", text, re.M)
    if not loops or not nodes:
        sys.exit(f"no finished run in {path}")
    columns, last = [], {}
    for line in text.splitlines():
        words = line.split()
        if words[:1] == ["Step"]:
            columns = words
        elif columns and len(words) == len(columns) and words[0].isdigit():
            last = dict(zip(columns, map(float, words)))
    return {"loop_seconds": round(sum(float(l[0]) for l in loops), 3), "ranks": int(loops[0][1]),
            "steps": sum(int(l[2]) for l in loops), "nodes": int(nodes[0]), "last": last}


def read_energies(path):
    lines = path.read_text().splitlines()
    names = lines[1].lstrip("# ").split()
    table = np.array([[float(w) for w in line.split()] for line in lines[2:]], ndmin=2)
    return {name: table[:, k] for k, name in enumerate(names)}


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


def write_json(path, data):
    path.write_text(json.dumps(data, indent=2, default=lambda x: x.item()) + "\n")  # numpy's numbers


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
        edges = corner[:, 6] - corner[:, 0]
        volume = np.abs(np.prod(edges, axis=1))  # bricks along the axes
        self.mass = volume * np.array([density[p] for p in mesh["parts"]])
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


def energy_rise(energies):
    """Largest rise of the total energy above an earlier value, in percent of the initial one."""
    total = energies["total"]
    return 100 * float(np.max(total - np.minimum.accumulate(total))) / total[0]


# ---- pictures -----------------------------------------------------------------------------------


def plotting():
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    return plt


def impactor_force(energies, mass, name):
    """Force on the impactor (kN, upwards) from its velocity: the mean between two lines, at their middle."""
    t, v = energies["time_us"], energies[name]
    return 0.5 * (t[1:] + t[:-1]), 1e-3 * mass * np.diff(v) / (1e-6 * np.diff(t))


def plot_energies(path, title, e, marks):
    plt = plotting()
    t = e["time_us"]
    figure, axes = plt.subplots(2, 2, figsize=(11, 7), sharex=True, constrained_layout=True)
    (stored, dissipated), (kinetic, total) = axes
    for name, label in (("e_elements", "finite elements"), ("e_joints", "connective joints"), ("e_ties", "ties"),
                        ("e_cohesive", "cohesive joints"), ("e_contact", "contact")):
        stored.plot(t, 1e3 * e[name], label=label)
    stored.set(title="stored", ylabel="mJ")
    for name, label in (("fracture", "fracture, $G_f$"), ("released", "released at breaking"), ("damping", "damping"),
                        ("friction", "friction"), ("viscous", "interlayer, viscous"),
                        ("conv_strain", "lost at conversion: strain"), ("conv_kinetic", "lost at conversion: kinetic")):
        dissipated.plot(t, 1e3 * e[name], label=label, ls=":" if "conv" in name else "-")
    dissipated.set(title="dissipated, and lost at conversions", ylabel="mJ")
    kinetic.plot(t, 1e3 * (e["e_kinetic"] - e["e_kinetic"][0]), color="k", label="kinetic")
    kinetic.plot(t, -1e3 * sum(e[n] for n in ("e_elements", "e_joints", "e_ties", "e_cohesive", "e_contact")),
                 ls="--", label="$-$ stored")
    kinetic.set(title=f"change of the kinetic energy (initially {e['e_kinetic'][0]:.4f} J)", ylabel="mJ", xlabel="us")
    total.plot(t, 100 * (e["total"] / e["total"][0] - 1), color="k", label="kinetic + stored + dissipated $-$ external work")
    total.plot(t, 100 * (e["balance"] / e["total"][0] - 1), ls="--", label="with what conversions lose")
    total.axhline(0.1, color="#d33", lw=0.8)
    total.axhline(0, color="0.6", lw=0.8)
    total.set(title="total energy, change in % of the initial", ylabel="%", xlabel="us")
    for axis in axes.flat:
        for mark in marks:
            if mark is not None:
                axis.axvline(mark, color="#d33", lw=0.8, ls=(0, (4, 3)), zorder=0)
        axis.set_xlim(0, t[-1])
        axis.legend(fontsize=8)
    figure.suptitle(title, fontsize=10)
    figure.savefig(path, dpi=100)
    plt.close(figure)


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
