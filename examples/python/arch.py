#!/usr/bin/env python3
"""A glass arch hit by a block: the mesh is made of numpy arrays, LAMMPS runs in this process, and is plotted while it runs.

    examples/run.sh python        or    PYTHONPATH=build/release/python python3 arch.py FOLDER
"""

import sys
from pathlib import Path

import defe
import numpy as np


def main(folder, pieces=12, steps=200):
    folder.mkdir(parents=True, exist_ok=True)
    # a bar of 32 x 5 x 3 elements, nodes (n, 3) in m and hexes (m, 8) from 0, and its nodes moved into an arch
    bar = defe.block(np.linspace(-0.032, 0.032, 33), np.linspace(0, 0.01, 6), np.linspace(0, 0.006, 4))
    angle, radius = bar.nodes[:, 0] / 0.06, 0.06 + bar.nodes[:, 1]
    nodes = np.stack([radius * np.sin(angle), radius * np.cos(angle) - 0.06, bar.nodes[:, 2]], axis=1)
    defe.write_mesh(folder / "arch.data", defe.Mesh(nodes, bar.hexes, "glass", 1))

    lmp = defe.start("-log", folder / "log.lammps", "-screen", "none")
    lmp.commands_string(Path(__file__).with_name("in.arch").read_text().replace("FOLDER", str(folder)).replace("STEPS", str(pieces * steps)))
    history = []
    for _ in range(pieces):
        lmp.command(f"run {steps} post no")
        now = defe.entries(lmp)
        history.append([1e6 * lmp.get_thermo("time"), now["converted"], now["contact"], 1e-6 * now["s1max"]])
        print("{:6.1f} us: {:4.0f} elements converted, {:4.0f} joints broken, largest stress {:5.1f} MPa".format(*history[-1]), flush=True)
        defe.plots.live(folder / "arch.png", ("time (us)", "converted", "broken", "stress (MPa)"), history)
    lmp.close()
    events, log = defe.read_events(folder / "events.txt"), defe.read_log(folder / "log.lammps")
    if defe.plots.available():
        defe.plots.timeline(folder / "timeline.png", "glass arch", events)
    summary = {"first_damage_s": events.first("cohesive"), "elements_converted": len(events.of("convert")),
               "joints_broken": len(events.of("broken")), "loop_seconds": log.seconds, "ranks": log.ranks}
    defe.summary.write_json(folder / "summary.json", summary)
    defe.summary.closing_line(folder, summary)


if __name__ == "__main__":
    defe.summary.main(main, Path(sys.argv[1] if len(sys.argv) > 1 else "output"))
