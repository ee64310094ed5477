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


def mesh(side, edge):
    """Numbered as create_hexes does."""
    n, through = round(side / edge), round(THICKNESS / edge)
    line = np.linspace(0.0, side, n + 1)
    pane = defe.block(line, line, np.linspace(0.0, THICKNESS, through + 1))
    at = pane.centres[:, :2]
    ring = ((at < 0.6 * edge) | (at > side - 0.6 * edge)).any(axis=1)
    return defe.Mesh(pane.nodes, pane.hexes, np.where(ring, "frame", "glass"))


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    defe.write_mesh(Path(sys.argv[1]), mesh(float(sys.argv[2]), float(sys.argv[3])))
