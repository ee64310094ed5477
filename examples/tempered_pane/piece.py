#!/usr/bin/env python3
"""The mesh of a piece of a large pane: its outermost ring of elements, the part "frame", does not convert.

piece.py FILE SIDE EDGE    of the piece and of the elements (m)
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "python"))
import defe

THICKNESS = 8e-3


def mesh(side, edge, moved=0.0):
    """Numbered as create_hexes does. moved: inner nodes at random along the faces by up to this share of an edge, but for those
    near the blow."""
    n, through = round(side / edge), round(THICKNESS / edge)
    line = np.linspace(0.0, side, n + 1)
    pane = defe.block(line, line, np.linspace(0.0, THICKNESS, through + 1))
    inner = ((pane.nodes[:, :2] > 0.1 * edge) & (pane.nodes[:, :2] < side - 0.1 * edge)).all(axis=1)
    inner &= (np.abs(pane.nodes[:, :2] - 0.5 * side) > 1.3 * edge).any(axis=1)
    at = pane.centres[:, :2]
    ring = ((at < 0.6 * edge) | (at > side - 0.6 * edge)).any(axis=1)
    nodes = pane.nodes.copy()
    nodes[inner, :2] += moved * edge * np.random.default_rng(1).uniform(-1.0, 1.0, (inner.sum(), 2))
    return defe.Mesh(nodes, pane.hexes, np.where(ring, "frame", "glass"))


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    defe.write_mesh(Path(sys.argv[1]), mesh(float(sys.argv[2]), float(sys.argv[3])))
