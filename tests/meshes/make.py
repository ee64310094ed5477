#!/usr/bin/env python3
"""Makes a mesh of this folder: the pane of examples/curved_pane as its mesh.py meshes it with Gmsh, lengths in mm
rounded to 1e-7, packed.

    make.py OUT.msh.gz [options of mesh.py]

Gmsh decides by comparing numbers which edges it swaps and which triangles it joins, and the last digit of a sine is
another one on another processor: so is the mesh. The tests take the files that are here."""

import gzip
import re
import subprocess
import sys
import tempfile
from pathlib import Path

MESH = Path(__file__).resolve().parents[2] / "examples" / "curved_pane" / "mesh.py"


def rounded(text):
    """All that has a decimal point: numbers of nodes and elements have none."""
    return re.sub(r"-?\d+\.\d+(e-?\d+)?", lambda number: f"{round(float(number[0]), 7) + 0.0:.10g}", text)


def main():
    if len(sys.argv) < 2 or not sys.argv[1].endswith(".msh.gz"):
        sys.exit(__doc__)
    with tempfile.TemporaryDirectory() as folder:
        raw = Path(folder) / "mesh.msh"
        subprocess.run([MESH, raw, *sys.argv[2:]], check=True)
        head, nodes, rest = re.split(r"(?=\$Nodes|\$Elements)", raw.read_text())
        version, entities = head[:head.index("$Entities")], head[head.index("$Entities"):]
        text = version + rounded(entities) + rounded(nodes) + rest
    # no date in the file: the same mesh is the same file
    Path(sys.argv[1]).write_bytes(gzip.compress(text.encode(), 9, mtime=0))


if __name__ == "__main__":
    main()
