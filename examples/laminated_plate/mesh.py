#!/usr/bin/env python3
"""Meshes the square pane with lines that do not follow its edges: a LAMMPS data file, as tools/layers2data writes it.

    mesh.py DATA turned|free --size SIZE --layer NAME THICKNESS N TYPE [--layer ...]

turned   squares turned by 45 degrees about the pane's normal; its rim is a row of teeth, one for each square
free     quadrilaterals without a direction: points at random, triangles between them, two of these joined where that
         is a good quadrilateral, and each then divided into four (three, for a triangle left alone)

SIZE is the edge of the elements along the pane, in mm; layers as in layers2data, in m. The mesh is the same on every
processor: what decides is computed in integers, and the rest by +, -, *, / and square roots only.
"""

import argparse
import math
import sys
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent.parent.parent / "python"))
from hexmesh.data_file import data_lines
from hexmesh.output import Parser, Refused, integer, real, run, start, write_all

HALF = 50.0  # of the pane's edge, mm
UNIT = 1 << 16  # integers per mm, for triangles


# ---- squares, turned --------------------------------------------------------------------------------


def turned(size):
    """Points (mm) and quadrilaterals of a lattice along the diagonals, a point of it in the middle."""
    m = round(math.sqrt(2) * HALF / size)
    number, points, quads = {}, [], []

    def point(a, b):
        if (a, b) not in number:
            number[a, b] = len(points)
            points.append((a * HALF / m, b * HALF / m))
        return number[a, b]

    for b in range(1 - m, m):
        for a in range(1 - m, m):
            if (a + b) % 2:  # a square around each
                quads.append([point(a, b - 1), point(a + 1, b), point(a, b + 1), point(a - 1, b)])
    return points, quads


# ---- triangles between random points ----------------------------------------------------------------


class Random:
    """Knuth's MMIX generator: the same numbers everywhere."""

    def __init__(self):
        self.state = 1

    def below(self, n):
        self.state = (self.state * 6364136223846793005 + 1442695040888963407) % 2**64
        return (self.state >> 33) * n >> 31


def scattered(spacing):
    """Integer points: evenly along the rim, at random inside, none closer to another than 0.75 of the spacing."""
    n, half = round(2 * HALF / spacing), round(HALF * UNIT)
    rim = [round((2 * k / n - 1) * HALF * UNIT) for k in range(n)]
    points = [p for x in rim for p in ((x, -half), (half, x), (-x, half), (-half, -x))]
    apart = round(0.75 * spacing * UNIT)
    cells = {}
    cell = lambda p: (p[0] // apart, p[1] // apart)
    for p in points:
        cells.setdefault(cell(p), []).append(p)
    random, misses = Random(), 0
    while misses < 4000:
        p = (random.below(2 * half) - half, random.below(2 * half) - half)
        i, j = cell(p)
        near = (q for a in (i - 1, i, i + 1) for b in (j - 1, j, j + 1) for q in cells.get((a, b), ()))
        if 2 * (half - max(abs(p[0]), abs(p[1]))) < apart or \
                any((p[0] - q[0])**2 + (p[1] - q[1])**2 < apart**2 for q in near):
            misses += 1
            continue
        misses = 0
        points.append(p)
        cells.setdefault((i, j), []).append(p)
    return points, 4 * n


def left_of(p, q, r):
    return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])


def in_circle(p, q, r, s):
    """Whether s is inside the circle through p, q, r, which turn to the left: exact, in integers."""
    rows = [(x - s[0], y - s[1], (x - s[0])**2 + (y - s[1])**2) for x, y in (p, q, r)]
    (a, b, c), (d, e, f), (g, h, i) = rows
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) > 0


def delaunay(points):
    """Triangles, by adding the points one by one (Bowyer and Watson). Those of the rim must be convex."""
    far = round(20 * HALF * UNIT)
    x = points + [(-far, -far), (far, -far), (0, far)]
    n = len(points)
    across = {(n, n + 1): n + 2, (n + 1, n + 2): n, (n + 2, n): n + 1}  # of a directed edge: the third point of its triangle
    at = (n, n + 1)
    for k in sorted(range(n), key=lambda k: (x[k][1] * 8 // (far // 10), x[k])):
        edge = at if at in across else next(reversed(across))
        while True:  # walk to the triangle that holds the point
            triangle = (*edge, across[edge])
            for a, b in zip(triangle, triangle[1:] + triangle[:1]):
                if left_of(x[a], x[b], x[k]) < 0:
                    edge = (b, a)
                    break
            else:
                break
        hole, todo = [], [(a, b) for a, b in zip(triangle, triangle[1:] + triangle[:1])]
        for a, b in todo:
            del across[a, b]
        while todo:
            a, b = todo.pop()
            c = across.get((b, a))
            if c is not None and in_circle(x[b], x[a], x[c], x[k]):
                for e in ((b, a), (a, c), (c, b)):
                    del across[e]
                todo += [(a, c), (c, b)]
            else:
                hole.append((a, b))
        for a, b in hole:
            across[a, b], across[b, k], across[k, a] = k, a, b
        at = (hole[0][1], k)
    return sorted((a, b, c) for (a, b), c in across.items() if a < min(b, c) and max(a, b, c) < n)


def relax(points, fixed, triangles):
    """Inner points to the mean of their neighbours."""
    around = [set() for _ in points]
    for t in triangles:
        for k in t:
            around[k].update(t)
    out = list(points)
    for k in range(fixed, len(points)):
        near = sorted(around[k] - {k})
        out[k] = tuple(sum(points[j][c] for j in near) // len(near) for c in (0, 1))
    return out


# ---- quadrilaterals ---------------------------------------------------------------------------------


def worst_corner(x, face):
    """The smallest sine of its angles."""
    sines = []
    for k, b in enumerate(face):
        p, q, r = x[face[k - 1]], x[b], x[face[(k + 1) % len(face)]]
        lengths = math.sqrt(((p[0] - q[0])**2 + (p[1] - q[1])**2) * ((r[0] - q[0])**2 + (r[1] - q[1])**2))
        sines.append(left_of(p, q, r) / lengths if lengths > 0 else -1.0)
    return min(sines)


def joined(x, triangles):
    """Triangles joined two by two, best quadrilaterals first; and what is left."""
    side = {}
    for k, t in enumerate(triangles):
        for a, b in zip(t, t[1:] + t[:1]):
            side[a, b] = k
    pairs = []
    for (a, b), k in side.items():
        if a < b and (b, a) in side:
            other = side[b, a]
            c, d = (next(v for v in triangles[t] if v not in (a, b)) for t in (k, other))
            quad = (a, d, b, c)
            pairs.append((-worst_corner(x, quad), quad, k, other))
    faces, taken = [], set()
    for quality, quad, k, other in sorted(pairs):
        if -quality > 0.5 and not taken & {k, other}:
            taken |= {k, other}
            faces.append(quad)
    return faces + [t for k, t in enumerate(triangles) if k not in taken]


def mean(x, of):
    """Of some points. Not by sum(), which rounds in another way since Python 3.12."""
    a = b = 0.0
    for k in of:
        a += x[k][0]
        b += x[k][1]
    return a / len(of), b / len(of)


def divided(points, faces):
    """Each face divided through the middles of its edges and its own."""
    points, middle, quads = list(points), {}, []

    def new(of):
        points.append(mean(points, of))
        return len(points) - 1

    for face in faces:
        edges = list(zip(face, face[1:] + face[:1]))
        for a, b in edges:
            key = (min(a, b), max(a, b))
            if key not in middle:
                middle[key] = new(key)
        heart = new(face)
        on = [middle[min(e), max(e)] for e in edges]
        quads += [[v, on[k], heart, on[k - 1]] for k, v in enumerate(face)]
    return points, quads


def smoothed(points, quads, rounds):
    """Inner points to the mean of their neighbours along edges, where no corner suffers below what is usual."""
    near, of = [set() for _ in points], [[] for _ in points]
    for q in quads:
        for k, v in enumerate(q):
            near[v] |= {q[k - 1], q[(k + 1) % 4]}
            of[v].append(q)
    x = list(points)
    for _ in range(rounds):
        for k, p in enumerate(x):
            if max(abs(p[0]), abs(p[1])) > HALF * (1 - 1e-9):
                continue
            before = min(worst_corner(x, q) for q in of[k])
            q = mean(x, sorted(near[k]))
            x[k] = (0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1]))
            if min(worst_corner(x, q) for q in of[k]) < min(before, 0.8):
                x[k] = p
    return x


def free(size):
    spacing = 2.15 * size  # of triangles of which two make four squares of this size
    points, fixed = scattered(spacing)
    triangles = delaunay(points)
    for _ in range(3):
        points = relax(points, fixed, triangles)
        triangles = delaunay(points)
    x = [(p[0] / UNIT, p[1] / UNIT) for p in points]
    x, quads = divided(x, joined(x, triangles))
    return smoothed(x, quads, 10), quads


# ---- output -----------------------------------------------------------------------------------------


def plate_lines(points, quads, layers):
    heights, kinds, names = [0.0], [], []
    for name, thickness, n, kind in layers:
        heights += [heights[-1] + thickness * (k + 1) / n for k in range(n)]
        kinds += [kind] * n
        names += [name] * n
    kinds.append(kinds[-1])
    box = ((-HALF, HALF), (-HALF, HALF), (0.0, 1e3 * heights[-1]))

    def atoms():
        for level, (z, kind) in enumerate(zip(heights, kinds)):
            for k, (x, y) in enumerate(points):
                yield 1 + k + level * len(points), kind, f"{1e-3 * x:.16g} {1e-3 * y:.16g} {z:.16g}"

    def hexes():
        for level, name in enumerate(names):
            for k, quad in enumerate(quads):
                nodes = [1 + v + level * len(points) for v in quad]
                yield 1 + k + level * len(quads), name, nodes + [v + len(points) for v in nodes]

    return data_lines(f"mesh.py: {', '.join(dict.fromkeys(names))}",
                      (len(points) * len(heights), max(kinds), len(quads) * len(names)),
                      [(f"{1e-3 * (low - 0.1):.10g}", f"{1e-3 * (high + 0.1):.10g}") for low, high in box], atoms(), hexes())


def make(options):
    layers = [(name, real(thickness), integer(n, 1), integer(kind, 1)) for name, thickness, n, kind in options.layer]
    if not 0.5 <= options.size <= 10:
        raise Refused(f"--size {options.size:g}: from 0.5 to 10 mm")
    points, quads = (turned if options.mesh == "turned" else free)(options.size)
    worst = min(worst_corner(points, q) for q in quads)
    write_all([(options.data, plate_lines(points, quads, layers))])
    area = sum(left_of(points[q[0]], points[q[1]], points[q[2]]) + left_of(points[q[0]], points[q[2]], points[q[3]])
               for q in quads) / 2
    return [f"{options.data}: {len(quads)} quadrilaterals, edges of {math.sqrt(area / len(quads)):.3f} mm, "
            f"smallest sine of an angle {worst:.2f}"]


if __name__ == "__main__":
    parser = Parser(prog="mesh.py", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", metavar="DATA")
    parser.add_argument("mesh", choices=("turned", "free"))
    parser.add_argument("--size", type=float, default=1.0)
    parser.add_argument("--layer", nargs=4, action="append", required=True, metavar=("NAME", "THICKNESS", "N", "TYPE"))
    start(lambda arguments: run("mesh.py", "", lambda: make(parser.parse_args(arguments))))
