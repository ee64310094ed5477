#!/usr/bin/env python3
"""A glass arch hit by a block: a mesh of arrays, run and plotted meanwhile.

PYTHONPATH=build/release/python python3 examples/python/arch.py FOLDER
"""
import sys
from pathlib import Path

import defe
import numpy as np


def main(folder, pieces=12, steps=200):
    folder.mkdir(parents=True, exist_ok=True)
    # a bar, by its planes of nodes in m; they are bent into an arch
    bar = defe.block(np.linspace(-0.032, 0.032, 33),
                     np.linspace(0, 0.01, 6), np.linspace(0, 0.006, 4))
    x, y, z = bar.nodes.T
    angle, r = x / 0.06, 0.06 + y
    nodes = np.column_stack([r * np.sin(angle), r * np.cos(angle) - 0.06, z])
    arch = defe.Mesh(nodes, bar.hexes, "glass", 1)
    defe.write_mesh(folder / "arch.data", arch)

    lmp = defe.start("-screen", "none", "-log", folder / "log.lammps",
                     "-var", "folder", folder, "-var", "steps", pieces * steps)
    lmp.file(str(Path(__file__).with_name("in.arch")))
    names, rows = ("time (us)", "converted", "broken", "stress (MPa)"), []
    for _ in range(pieces):
        lmp.command(f"run {steps} post no")
        us, now = 1e6 * lmp.get_thermo("time"), defe.entries(lmp)
        rows.append((us, now["converted"], now["contact"], now["s1max"] / 1e6))
        print("%6.1f us: %4d elements converted, %4d joints broken, "
              "largest stress %5.1f MPa" % rows[-1], flush=True)
        defe.plots.live(folder / "arch.png", names, rows)
    lmp.close()
    defe.summary.finish(folder, "glass arch")


if __name__ == "__main__":
    defe.summary.main(main, Path((sys.argv[1:] or ["output"])[0]))
