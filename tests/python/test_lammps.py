#!/usr/bin/env python3
"""defe with LAMMPS' own Python module: examples/python/arch.py, and what is said where something is missing.

DEFE_PLUGIN: defeplugin.so in its build folder (ctest sets it)."""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import textwrap
import unittest
from pathlib import Path

import numpy as np

SOURCE = Path(__file__).resolve().parents[2]
PLUGIN = Path(os.environ["DEFE_PLUGIN"])
MODULES = PLUGIN.parent / "python"


class Lammps(unittest.TestCase):
    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))

    def python(self, *arguments, path=MODULES, fails=False, **environment):
        """What it prints; where it fails, its one line."""
        variables = {key: value for key, value in os.environ.items() if key not in ("DEFE_PLUGIN", "LD_LIBRARY_PATH")}
        run = subprocess.run([sys.executable, *map(str, arguments)], cwd=self.folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                             stderr=subprocess.PIPE, text=True, env={**variables, "PYTHONPATH": str(path), "OMP_NUM_THREADS": "1", **environment})
        self.assertEqual(run.returncode != 0, fails, run.stdout + run.stderr)
        if fails:
            self.assertEqual(len(run.stderr.strip().splitlines()), 1, run.stderr)
        return run.stderr if fails else run.stdout

    def code(self, *lines, **options):
        return self.python("-c", "import defe\ndef go():\n    " + "\n    ".join(lines) + "\ndefe.summary.main(go)", **options)

    def arch(self, script="arch.py", **options):
        return self.python(SOURCE / "examples" / "python" / script, self.folder / "out", **options)

    def test_arch(self):
        """It cracks in the middle, and both ways of asking how far say the same."""
        sys.path.insert(0, str(SOURCE / "python"))
        import defe
        said = self.arch().strip().splitlines()
        out = self.folder / "out"
        summary, events = json.loads((out / "summary.json").read_text()), defe.read_events(out / "events.txt")
        self.assertTrue(10e-6 < summary["first_damage_s"] < 40e-6, summary)
        self.assertTrue(20 <= summary["elements_converted"] <= 60, summary)
        self.assertIn(f"{summary['elements_converted']:4d} elements converted, {summary['joints_broken']:4d} joints broken", said[11])
        self.assertRegex(said[-1], r"^\d+ elements converted, \d+ joints broken; .*; summary\.json, arch\.png, timeline\.png in ")
        self.assertLess(abs(events.of("broken").x[:, 0]).max(), 0.01)
        log = defe.read_log(out / "log.lammps")
        self.assertEqual((len(log.runs), log.steps, log.thermo.last()["converted"]), (12, 2400, summary["elements_converted"]))
        mesh = defe.read_mesh(out / "arch.data")
        self.assertEqual((mesh.nodes.shape, mesh.hexes.shape), ((33 * 6 * 4, 3), (32 * 5 * 3, 8)))
        np.testing.assert_allclose(np.hypot(mesh.nodes[:33, 0], mesh.nodes[:33, 1] + 0.06), 0.06, rtol=1e-14)

    def test_without_matplotlib(self):
        """The numbers are printed all the same."""
        text = (SOURCE / "examples" / "python" / "arch.py").read_text()
        hidden = 'defe.plots.available = lambda: False\n\n\ndef main('
        self.assertEqual(text.count("def main("), 1)
        self.assertLessEqual(len(text.splitlines()), 40)    # so says Howto_defe
        self.assertLess(max(map(len, text.splitlines())), 80)
        (self.folder / "short.py").write_text(text.replace("def main(", hidden).replace("pieces=12, steps=200", "pieces=2, steps=5"))
        shutil.copy(SOURCE / "examples" / "python" / "in.arch", self.folder)
        said = self.python("short.py", "out").strip().splitlines()
        self.assertRegex(said[1], r"^ +0\.5 us: +0 elements converted, +0 joints broken, largest stress")
        self.assertRegex(said[-1], r"; summary\.json in out$")
        self.assertEqual(sorted(p.name for p in (self.folder / "out").iterdir()), ["arch.data", "events.txt", "log.lammps", "summary.json"])

    def test_howto(self):
        """Both pieces of Python on the page Howto_defe, with its first script, of which the mesh now comes from Python."""
        page = (SOURCE / "lammps-package" / "doc" / "Howto_defe.rst").read_text()
        section = page[page.index("\nWith Python\n"):page.index("\nRestarts and processors\n")]
        after, before = (textwrap.dedent(block) for block in re.findall(r"\.\. parsed-literal::\n\n((?:   .*\n|\n)+)", section))
        script = textwrap.dedent(re.search(r"\.\. script in\.bar\n\n.*\n\n((?:   .*\n|\n)+)", page)[1])
        mesh = "read_data bar.data add append fix fe hexes Hexes"
        script, count = re.subn(r"create_hexes +fe glass 1 .*", mesh, script)
        self.assertEqual(count, 1)
        self.assertIn(mesh, before)
        (self.folder / "in.bar").write_text(script.replace("run             1000", "variable t equal time\n"
                                                           "fix energies all ave/time 50 1 50 v_t f_fe[*30] file energies.txt").replace("plugin ", "#"))
        planes = "import defe\nimport numpy as np\nx, y, z = (np.linspace(a, b, n) for a, b, n in ((-.031, .031, 32), (0, .01, 6), (0, .006, 4)))\n"
        dump = "lmp.command('write_dump all custom pieces.dump id mass c_pieces')\nlmp.close()\n"
        (self.folder / "all.py").write_text(planes + before + dump + after)
        said = self.python("all.py").split("\n")
        self.assertGreater(float(said[9]), 10)    # elements converted
        self.assertRegex(said[10], r"^\d\.\d+e-05 \d+$")
        self.assertEqual(int(said[10].split()[1]), float(said[9]))
        self.assertRegex(said[11], r"^0\.0\d* % of the initial energy$")
        self.assertRegex(said[12], r"^\[.*\] kg: the heaviest pieces$")
        self.assertTrue((self.folder / "timeline.png").exists())

    def test_on_two_ranks(self):
        """Under mpirun the script runs on both, in one LAMMPS."""
        code = ("import defe, os; lmp = defe.start('-screen', 'none', '-log', 'none')\n"
                "os.write(1, b'%d %d\\n' % (lmp.extract_setting('world_size'), lmp.extract_setting('world_rank')))")    # in one piece
        run = subprocess.run([SOURCE / "tools" / "mpirun.sh", "2", sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": str(MODULES)},
                             stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True, check=True)
        self.assertEqual(sorted(run.stdout.split("\n")), ["", "2 0", "2 1"])

    def test_what_is_missing(self):
        self.assertIn("no defeplugin.so on Python's path", self.code("defe.start()", path=SOURCE / "python", fails=True))
        self.assertIn("LAMMPS' Python module is not on Python's path",
                      self.code("defe.start()", path=SOURCE / "python", fails=True, DEFE_PLUGIN=str(PLUGIN)))
        (self.folder / "lammps").mkdir()    # a folder of that name is no module
        self.assertIn("LAMMPS' Python module is not on Python's path",
                      self.code("defe.start()", path=f"{self.folder}:{SOURCE / 'python'}", fails=True, DEFE_PLUGIN=str(PLUGIN)))
        (self.folder / "lammps").rmdir()
        self.assertIn("there is no such plugin", self.code("defe.start()", fails=True, DEFE_PLUGIN="/none.so"))
        (self.folder / "empty.so").write_text("")
        self.assertIn("empty.so: LAMMPS does not take it",
                      self.code("defe.start('-screen', 'none', '-log', 'none')", fails=True, DEFE_PLUGIN=str(self.folder / "empty.so")))
        quiet = "lmp = defe.start('-screen', 'none', '-log', 'none')"
        self.assertIn("there is no fix fe", self.code(quiet, "defe.entries(lmp)", fails=True))
        self.assertIn("ERROR: Unknown command: nonsense", self.code(quiet, "lmp.command('nonsense')", fails=True))


if __name__ == "__main__":
    unittest.main()
