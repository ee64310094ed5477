#!/usr/bin/env python3
"""What examples/curved_pane/run.sh makes of a run: summary.json, energies.png, timeline.png, force.png,
crack.png; of the elastic variant, the deflection of the middle in summary.json.

analyse.py FOLDER ball         mesh.data, events.txt, energies.txt, pieces.dump, log.lammps, *.png of one run
analyse.py FOLDER elastic      energies.txt, log.lammps
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import laminate
from laminate import defe, summary


def ball(folder):
    laminate.pane_report(folder, "curved, glass 2.1 / PVB 0.76 / glass 2.1 mm", ["outer", "inner"], True)


def elastic(folder):
    log, energies = defe.read_log(folder / "log.lammps"), defe.read_table(folder / "energies.txt")
    down = energies["deflection"][0] - energies["deflection"]
    s = {"deflection_max_mm": round(1e3 * float(down.max()), 4), "deflection_max_us": round(float(energies["us"][down.argmax()]), 2),
         "loop_seconds": round(log.seconds, 4), "ranks": log.ranks, "steps": log.steps}
    summary.write_json(folder / "summary.json", s)
    print(f"\nThe middle goes down by {s['deflection_max_mm']:.3f} mm, after {s['deflection_max_us']:.0f} us")
    summary.closing_line(folder, s)


if __name__ == "__main__":
    if len(sys.argv) != 3 or sys.argv[2] not in ("ball", "elastic"):
        sys.exit(__doc__)
    summary.main(ball if sys.argv[2] == "ball" else elastic, Path(sys.argv[1]))
