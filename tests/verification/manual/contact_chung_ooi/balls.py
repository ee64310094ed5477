"""Meshes of spheres: a bulged cube in the middle and six blocks around it, fine near both poles."""

import numpy as np
from plates import Nodes

HALF, BULGE = 0.45, 0.35    # of the cube in the middle: its half edge, and how far its faces are bent towards a sphere


def graded(n, how):
    """2n + 1 numbers from -1 to 1, dense about 0; how = 0: evenly."""
    t = np.linspace(-1.0, 1.0, 2 * n + 1)
    return np.sinh(how * t) / np.sinh(how) if how else t


def sphere(n, layers, how):
    """Nodes and elements of a unit sphere: 2n elements along the edges of the cube in the middle, `layers` around it."""
    xy, z = graded(n, how), graded(n, 0.0)
    nodes, elements = Nodes(), []

    def core(u):
        r, side = np.linalg.norm(u), np.abs(u).max()
        return HALF * u if r == 0.0 else HALF * u * (1.0 - BULGE + BULGE * 1.25 * side / r)

    def shell(u, s):
        """u on the surface of the cube; s from 0 at the cube in the middle to 1 at the sphere."""
        angle = np.tan(0.25 * np.pi * u)    # even angles where u is even
        return (1.0 - s) * core(u) + s * angle / np.linalg.norm(angle)

    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    axis = (xy, xy, z)
    grid = {}
    for i in range(2 * n + 1):
        for j in range(2 * n + 1):
            for k in range(2 * n + 1):
                grid[i, j, k] = nodes.number(core(np.array([xy[i], xy[j], z[k]])))
    for i in range(2 * n):
        for j in range(2 * n):
            for k in range(2 * n):
                elements.append([grid[i + a, j + b, k + c] for a, b, c in corners])
    height = np.linspace(0.0, 1.0, layers + 1)
    height = 1.0 - (1.0 - height) ** 1.5 if how else height    # thinner towards the surface
    for d in range(3):
        e, f = (d + 1) % 3, (d + 2) % 3
        for side in (-1.0, 1.0):
            skin = {}
            for i in range(2 * n + 1):
                for j in range(2 * n + 1):
                    u = np.empty(3)
                    u[d], u[e], u[f] = side, axis[e][i], axis[f][j]
                    for m in range(layers + 1):
                        skin[i, j, m] = nodes.number(shell(u, height[m]))
            for i in range(2 * n):
                for j in range(2 * n):
                    for m in range(layers):
                        h = [skin[i + a, j + b, m + c] for a, b, c in corners]
                        elements.append(h if side > 0.0 else h[4:] + h[:4])
    return np.array(nodes.points), np.array(elements)


def write_pair(file, radius, unit, gap, turn):
    """Two spheres one above the other along z, the upper one turned about z: a data file of parts lower and upper."""
    X, hexes = unit
    c, s = np.cos(turn), np.sin(turn)
    turned = X @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    offset = np.array([0.0, 0.0, radius + 0.5 * gap])
    nodes = np.concatenate([radius * X - offset, radius * turned + offset])
    elements = np.concatenate([hexes, hexes + len(X)])
    part = ["lower"] * len(hexes) + ["upper"] * len(hexes)
    with open(file, "w") as out:
        out.write(f"two spheres\n\n{len(nodes)} atoms\n2 atom types\n{len(elements)} hexes\n\n")
        for axis, reach in zip("xyz", (1.5, 1.5, 2.5)):
            out.write(f"{-reach * radius} {reach * radius} {axis}lo {axis}hi\n")
        out.write("\nAtoms # sphere\n\n")
        out.writelines(f"{k + 1} 1 0 1 {p[0]:.12g} {p[1]:.12g} {p[2]:.12g}\n" for k, p in enumerate(nodes))
        out.write("\nHexes\n\n")
        out.writelines(f"{k + 1} {name} " + " ".join(str(a + 1) for a in h) + "\n" for k, (name, h) in enumerate(zip(part, elements)))


def shortest_edge(unit):
    X, hexes = unit
    x = X[hexes]
    pairs = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
    return min(np.linalg.norm(x[:, a] - x[:, b], axis=1).min() for a, b in pairs)
