#!/usr/bin/env python3
"""What examples/curved_pane/run.sh makes of a run: summary.json, energies.png, timeline.png, force.png,
crack.png.

analyse.py FOLDER      mesh.data, events.txt, energies.txt, pieces.dump, log.lammps, *.png of one run
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import laminate

if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    laminate.summary.main(laminate.pane_report, Path(sys.argv[1]), "curved, glass 2.1 / PVB 0.76 / glass 2.1 mm", ["outer", "inner"], True)
