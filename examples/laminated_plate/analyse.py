#!/usr/bin/env python3
"""What examples/laminated_plate/run.sh makes of a run: summary.json, energies.png, timeline.png, force.png,
crack.png.

analyse.py FOLDER VARIANT     mesh.data, events.txt, energies.txt, pieces.dump, log.lammps, *.png of one run
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import cracks
import laminate


def main(folder, single):
    laminate.pane_report(folder, "glass 6 mm" if single else "glass 3 / PVB 0.76 / glass 3 mm",
                         ["lower"] if single else ["upper", "lower"], not single, cracks.measure(folder))


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    laminate.summary.main(main, Path(sys.argv[1]), sys.argv[2] == "single")
