#!/usr/bin/env python3
"""The package python/defe, without LAMMPS: what its readers make of small files, their messages, and its measures."""

import contextlib
import io
import math
import re
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

sys.dont_write_bytecode = True
SOURCE = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(SOURCE / "python"))
import defe  # noqa: E402

EVENTS = """# DEFE events: run ca4e0b23fa7e92f1, mesh of 20 elements with checksum 52a1e33c0a4a81d5
# step time event id id2 X Y Z nx ny nz value
445 2.67e-05 convert 7 1 5.5e-18 0.001 0.005 0 0 0 2e-05
445 2.67e-05 cohesive 149 150 5.5e-18 0.0005 0.0045 1 0 0 6.044e+07
450 2.7e-05 broken 149 150 5.5e-18 0.0005 0.0045 1 0 0 1
460 2.76e-05 adhesive 151 6 0.001 0 0 0 1 0 5e+06
"""
ENERGIES = """# Time-averaged data for fix energies
# TimeStep v_us f_fe[2] f_fe[22] f_fe[14] f_other[1]
0 0 0 4 4 1
20 1.2 0 4.01 3 1
40 2.4 1 3.9 2 1
"""
LOG = """LAMMPS (4 Feb 2025)
Interlayer: 0.25 kg
   Step          Time          f_fe[2]      v_tip     Temp
         0   0              0          1e-3  0
Note: a body has no contact
Step 5 of the script
         5   3e-07          0          2e-3  0
Loop time of 0.5 on 2 procs for 5 steps with 40 atoms
   Step          Time          f_fe[2]      v_tip     Temp
         5   3e-07          0          2e-3  0
        10   6e-07          8          3e-3  0
Loop time of 1.5 on 2 procs for 5 steps with 104 atoms
"""
DUMP = """ITEM: TIMESTEP
10
ITEM: NUMBER OF ATOMS
5
ITEM: BOX BOUNDS ff ff ff
-1 1
-2 2
-3 3
ITEM: ATOMS id mass c_pieces element
1 0.5 7 Si
2 0.5 7 Si
3 3 9 O
4 0.25 7 Si
5 8 0 Fe
"""
MESH = """a mesh of one element

8 atoms
2 atom types
1 hexes

0 1 xlo xhi
0 1 ylo yhi
0 1 zlo zhi

Atoms # sphere

""" + "\n".join(f"{10 + k} {1 + k // 4} 0 1 {x} {y} {z}" for k, (z, y, x) in enumerate(np.ndindex(2, 2, 2))) + """

Hexes

1 glass 10 11 13 12 14 15 17 16
"""


class Files(unittest.TestCase):
    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))

    def file(self, text, name="file.txt"):
        path = self.folder / name
        path.write_text(text)
        return path

    def refuse(self, read, text, *words):
        """One line that names the file and all of these."""
        path = text if isinstance(text, Path) else self.file(text)
        with self.assertRaises(defe.InputError) as raised:
            read(path)
        message = str(raised.exception)
        self.assertNotIn("\n", message)
        for word in (str(path), *words):
            self.assertIn(word, message)

    def test_no_such_file(self):
        for read in (defe.read_events, defe.read_table, defe.read_log, defe.read_dump, defe.read_mesh):
            self.refuse(read, self.folder / "missing", "no such file")
            self.refuse(read, self.folder, "is a folder")
        (self.folder / "binary").write_bytes(b"\xff\xfe\x00")
        self.refuse(defe.read_events, self.folder / "binary", "not a text file")


class Names(unittest.TestCase):
    """Those of the package are those of the code."""

    def test_entries(self):
        source = (SOURCE / "coupling" / "src" / "ledger.cpp").read_text()
        table = re.findall(r'^    \{"[^"]*", "(\w+)", "\w*", -?\d,', source, re.M)
        self.assertEqual(defe.ENTRIES, table)

    def test_kinds_of_events(self):
        source = (SOURCE / "coupling" / "src" / "event_log.cpp").read_text()
        self.assertEqual(list(defe.KINDS), re.findall(r'"(\w+)"', re.search(r"names\[\] = \{(.*?)\}", source, re.S)[1]))


class Events(Files):
    def test_all_fields(self):
        e = defe.read_events(self.file(EVENTS))
        self.assertEqual((len(e), e.run, e.elements), (4, "ca4e0b23fa7e92f1", 20))
        self.assertEqual((e.step.tolist(), e.kind.tolist()), ([445, 445, 450, 460], ["convert", "cohesive", "broken", "adhesive"]))
        self.assertEqual(e.ids.tolist(), [[7, 1], [149, 150], [149, 150], [151, 6]])
        np.testing.assert_allclose(e.time, [2.67e-5, 2.67e-5, 2.7e-5, 2.76e-5], rtol=1e-14)
        np.testing.assert_allclose(e.x[1], [5.5e-18, 0.0005, 0.0045], rtol=1e-14)
        np.testing.assert_allclose(e.n, [[0, 0, 0], [1, 0, 0], [1, 0, 0], [0, 1, 0]])
        np.testing.assert_allclose(e.value, [2e-5, 6.044e7, 1, 5e6])
        self.assertEqual((e.first("broken"), e.first("cohesive", "broken"), e.first("debonded")), (2.7e-5, 2.67e-5, None))
        # with 100 nodes, DEs 149 to 156 are of the seventh element
        self.assertEqual(e.elements_of(100).tolist(), [6, 6, 6, 6])
        self.assertEqual(len(e.where(e.step > 445).of("cohesive")), 0)
        self.assertEqual(e.where([2, 0]).step.tolist(), [450, 445])
        with self.assertRaisesRegex(defe.InputError, "no events of kind 'breaks'"):
            e.of("breaks")

    def test_without_events(self):
        e = defe.read_events(self.file("".join(EVENTS.splitlines(True)[:2])))
        self.assertEqual((len(e), e.x.shape, e.first("broken")), (0, (0, 3), None))

    def test_what_is_left_of_a_removed_package_is_no_package(self):
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "left_over").mkdir()
            sys.path.append(folder)
            try:
                with self.assertRaisesRegex(defe.InputError, r"^to_pandas\(\) needs left_over: install python3-left$"):
                    defe.errors.needed("left_over", "python3-left", "to_pandas()")
            finally:
                sys.path.remove(folder)

    def test_pandas(self):
        try:
            from pandas import DataFrame    # noqa: F401
        except ImportError:
            self.skipTest("no pandas")
        frame = defe.read_events(self.file(EVENTS)).to_pandas()
        self.assertEqual((list(frame.columns), frame["kind"][2], frame["id2"][3], frame["Z"][1]),
                         ("step time kind id id2 X Y Z nx ny nz value".split(), "broken", 6, 0.0045))
        self.assertEqual(defe.read_table(self.file(ENERGIES)).to_pandas()["total"].tolist(), [4, 4.01, 3.9])

    def test_while_it_is_written(self):
        path = self.file(EVENTS[:-12])
        self.assertEqual(len(defe.read_events(path, running=True)), 3)
        self.refuse(defe.read_events, path, "line 6", "the run was stopped while it wrote")
        self.assertEqual(len(defe.read_events(self.file(""), running=True)), 0)

    def test_damaged(self):
        self.refuse(defe.read_events, EVENTS.replace(" 0 0 0 2e-05", ""), "line 3", "8 words, an event has 12", "run again")
        self.refuse(defe.read_events, EVENTS.replace("broken", "brokem"), "line 5", "'brokem' is no event")
        self.refuse(defe.read_events, EVENTS.replace("0.0045 1 0 0 1", "0.0O45 1 0 0 1"), "line 5", "'0.0O45' is not a number")
        self.refuse(defe.read_events, EVENTS.replace("450 2.7", "450.5 2.7"), "line 5", "'450.5' is not a number")
        self.refuse(defe.read_events, ENERGIES, "does not begin as an event file")


class Tables(Files):
    def test_columns_have_names(self):
        t = defe.read_table(self.file(ENERGIES))
        self.assertEqual(list(t), ["step", "us", "converted", "total", "e_kinetic", "f_other[1]"])
        self.assertEqual((len(t), t["total"].tolist(), t.total[1], "s1max" in t), (3, [4, 4.01, 3.9], 4.01, False))
        self.assertEqual(list(defe.read_table(self.file(ENERGIES), fix="other"))[2:], ["f_fe[2]", "f_fe[22]", "f_fe[14]", "elements"])
        with self.assertRaisesRegex(defe.InputError, "no column 's1max'; there are: step, us,"):
            t["s1max"]
        self.assertFalse(hasattr(t, "s1max"))
        self.assertEqual((defe.ENTRIES.index("total"), len(defe.ENTRIES)), (21, 30))

    def test_times(self):
        t = defe.read_table(self.file("# title\n# step time_us total\n0 0 1\n9 2.5 1\n"))
        np.testing.assert_allclose(t.seconds(), [0, 2.5e-6])
        with self.assertRaisesRegex(defe.InputError, "no column of times"):
            defe.read_table(self.file(ENERGIES)).seconds()

    def test_a_restarted_run(self):
        """What it wrote again counts, once."""
        t = defe.read_table(self.file(ENERGIES + "# TimeStep v_us f_fe[2] f_fe[22] f_fe[14] f_other[1]\n20 1.2 0 5 3 1\n40 2.4 1 6 2 1\n60 3.6 1 7 2 1\n"))
        self.assertEqual((t["step"].tolist(), t["total"].tolist()), ([0, 20, 40, 60], [4, 5, 6, 7]))

    def test_damaged(self):
        self.refuse(defe.read_table, ENERGIES + "60 3.6 1", "line 6", "3 words, but the titles name 6 columns")
        self.assertEqual(len(defe.read_table(self.file(ENERGIES + "60 3.6 1"), running=True)), 3)
        self.refuse(defe.read_table, ENERGIES.replace("4.01", "4.O1"), "line 4", "'4.O1' is not a number")
        self.refuse(defe.read_table, "0 1 2\n", "line 1", "no line of titles")
        self.refuse(defe.read_table, "".join(ENERGIES.splitlines(True)[:2]), "there are no rows")
        self.refuse(defe.read_table, ENERGIES + "# TimeStep v_us\n80 4.8\n", "columns change")

    def test_energies(self):
        columns = {name: np.zeros(4) for name in defe.ENTRIES}
        columns.update(total=np.array([4.0, 3.0, 3.5, 3.2]), balance=np.array([4.0, 4.1, 3.8, 4.0]), external=np.array([0, -8.0, 0, 0]))
        e = defe.Table(columns)
        self.assertAlmostEqual(defe.energy_rise(e), 12.5)
        self.assertAlmostEqual(defe.largest_rise([3, 2, 1]), 0.0)
        with self.assertRaisesRegex(defe.InputError, "not above 0 at first"):
            defe.energy_rise(defe.Table({"total": [0.0, 1.0]}))
        self.assertAlmostEqual(defe.balance_drift(e), 0.2)
        self.assertEqual(defe.energy_scale(e), 8.0)
        columns.update({name: np.full(4, 2.0**k) for k, name in enumerate(defe.STORED)})
        self.assertEqual(defe.stored(defe.Table(columns)).tolist(), 4 * [31.0])

    def test_force(self):
        t, f = defe.force_from_velocity([0, 1e-6, 3e-6], [-3, -2, 2], 0.5)
        np.testing.assert_allclose(t, [0.5e-6, 2e-6])
        np.testing.assert_allclose(f, [0.5e6, 1e6])
        with self.assertRaisesRegex(defe.InputError, "two times"):
            defe.force_from_velocity([0], [1], 1)


class Logs(Files):
    def test_runs(self):
        log = defe.read_log(self.file(LOG))
        self.assertEqual((len(log.runs), log.seconds, log.ranks, log.steps, log.runs[1].atoms), (2, 2.0, 2, 10, 104))
        self.assertEqual(list(log.thermo), ["step", "Time", "converted", "tip", "Temp"])
        self.assertEqual((log.thermo["step"].tolist(), log.thermo.last()["converted"]), ([0, 5, 10], 8))
        np.testing.assert_allclose(log.thermo.seconds(), [0, 3e-7, 6e-7])
        self.assertEqual(float(log.value(r"Interlayer: (\S+) kg", "the mass")), 0.25)
        with self.assertRaisesRegex(defe.InputError, "does not say the number of nodes"):
            log.value(r"Nodes: (\d+)", "the number of nodes")

    def test_other_columns_in_another_run(self):
        other = "   Step          Temp\n         0          7\nLoop time of 1 on 2 procs for 0 steps with 40 atoms\n"
        log = defe.read_log(self.file(other + LOG))
        self.assertEqual((len(log.runs), log.thermo["step"].tolist(), log.seconds), (3, [0, 5, 10], 3.0))

    def test_unfinished(self):
        part = LOG.rsplit("Loop", 1)[0]
        self.refuse(defe.read_log, part + "ERROR: Lost atoms: original 40 current 39\n", "did not end", "Lost atoms: original 40")
        self.assertEqual(defe.read_log(self.file(part), running=True).thermo["step"].tolist(), [0, 5, 10])
        self.refuse(defe.read_log, "ERROR: Unknown command\n", "no finished run", "Unknown command")
        self.refuse(defe.read_log, "------------ Step 0 ----- CPU = 0 (sec) ------\n", "line 1", "thermo_modify line one")
        self.refuse(defe.read_log, "keywords: ['Step', 'Temp']\n", "line 1", "thermo_modify line one")


class Summaries(Files):
    def test_read_and_written(self):
        path = self.folder / "summary.json"
        defe.summary.write_json(path, {"converted": np.int64(3), "energy_J": np.float64(0.1), "none": None})
        self.assertEqual(defe.read_summary(path), {"converted": 3, "energy_J": 0.1, "none": None})
        self.refuse(defe.read_summary, '{"a": 1,\n"b": }', "line 2", "run the example again")
        self.refuse(defe.read_summary, "[1]", "no summary of a run")
        self.refuse(defe.read_summary, self.folder / "missing", "no such file")

    def test_totals(self):
        """energy_rise_percent: from 3.9 J back to 4 J, of 4 J."""
        energies = defe.read_table(self.file("# title\n# step time_us total\n0 0 4\n20 1.2 3.9\n40 2.4 4\n60 3.6 3.5\n"))
        self.assertEqual(defe.summary.totals(defe.read_log(self.file(LOG)), energies), {
            "energy_initial_J": 4.0, "energy_max_J": 4.0, "energy_final_J": 3.5, "energy_rise_percent": 2.5, "end_us": 3.6,
            "loop_seconds": 2.0, "ranks": 2, "steps": 10})

    def test_report_comes_once(self):
        """An example that is analysed again has its table in the log once."""
        log = self.file(LOG)
        with contextlib.redirect_stdout(io.StringIO()) as said:
            for value in ("1", "2"):
                defe.summary.report(log, "Pane,", ["Pane, glass", "  value " + value])
        self.assertEqual(log.read_text(), LOG + "\nPane, glass\n  value 2\n")
        self.assertEqual(said.getvalue(), "\nPane, glass\n  value 1\n\nPane, glass\n  value 2\n")

    def test_failures_are_one_line(self):
        def fail(error):
            raise error

        for error in (defe.InputError("events.txt: why"), Exception("ERROR: Lost\natoms")):
            with self.assertRaises(SystemExit) as ended:
                defe.summary.main(fail, error)
            self.assertEqual(ended.exception.code, f"{Path(sys.argv[0]).name}: {' '.join(str(error).split())}")
        with self.assertRaises(KeyError):    # a fault of the program is not hidden
            defe.summary.main(fail, KeyError("x"))


class Dumps(Files):
    def test_frames(self):
        frames = defe.read_dump(self.file(DUMP + DUMP.replace("\n10\n", "\n20\n", 1)))
        self.assertEqual([f.step for f in frames], [10, 20])
        self.assertEqual((frames[1]["id"].tolist(), frames[0]["element"].tolist()[2], frames[0].box.tolist()[2]), ([1, 2, 3, 4, 5], "O", [-3, 3]))

    def test_local(self):
        text = DUMP.replace("ATOMS id mass", "ENTRIES index c_joints[1]").replace("OF ATOMS", "OF ENTRIES")
        self.assertEqual(list(defe.read_dump(self.file(text))[0].table), ["index", "c_joints[1]", "c_pieces", "element"])
        empty = "".join(text.splitlines(True)[:-5]).replace("\n5\n", "\n0\n")
        self.assertEqual(defe.read_dump(self.file(empty))[0]["index"].shape, (0,))

    def test_damaged(self):
        self.refuse(defe.read_dump, DUMP.rsplit("5 8", 1)[0], "the file ends within a frame")
        self.refuse(defe.read_dump, DUMP.replace("3 3 9 O", "3 3 9"), "line 12", "3 words, but there are 4 columns")
        self.refuse(defe.read_dump, DUMP.replace("\n10\n", "\nten\n", 1), "line 2", "'ten' is no count")
        self.refuse(defe.read_dump, DUMP.replace("-2 2", "-2 x"), "line 7", "'-2 x' are no bounds")
        self.refuse(defe.read_dump, "1 2 3\n", "line 1", "is this a text dump")
        self.refuse(defe.read_dump, "", "it is empty")

    def test_fragments(self):
        frame = defe.read_dump(self.file(DUMP))[0]
        f = defe.fragments(frame["c_pieces"], frame["mass"])
        self.assertEqual((f.id.tolist(), f.mass.tolist(), f.atoms.tolist(), f.single.tolist()), ([9, 7], [3, 1.25], [1, 3], [True, False]))
        self.assertEqual(len(defe.fragments([0, 0], [1, 1])), 0)
        with self.assertRaisesRegex(defe.InputError, "as many IDs as masses"):
            defe.fragments([1, 2], [1])


class Meshes(Files):
    def test_read(self):
        mesh = defe.read_mesh(self.file(MESH))
        self.assertEqual((mesh.hexes.tolist(), mesh.parts.tolist(), mesh.types.tolist()),
                         ([[0, 1, 3, 2, 4, 5, 7, 6]], ["glass"], [1, 1, 1, 1, 2, 2, 2, 2]))
        self.assertEqual((mesh.nodes[3].tolist(), mesh.centres.tolist(), mesh.edge(), mesh.edge("glass")), ([1, 1, 0], [[0.5, 0.5, 0.5]], 1, 1))

    def test_block_is_written_and_read(self):
        x, y, z = [0, 0.1, 0.3], [0, 1 / 3], [-1, 0, 1, 2]
        mesh = defe.block(x, y, z, parts=["a", "b"] * 3, types=np.arange(1, 25))
        self.assertEqual((mesh.nodes[1].tolist(), mesh.nodes[3].tolist(), mesh.nodes[6].tolist()), ([0.1, 0, -1], [0, 1 / 3, -1], [0, 0, 0]))
        self.assertEqual(mesh.hexes[1].tolist(), [1, 2, 5, 4, 7, 8, 11, 10])
        np.testing.assert_allclose(mesh.centres[-1], [0.2, 1 / 6, 1.5])
        path = self.folder / "mesh.data"
        defe.write_mesh(path, mesh, margin=0.5)
        self.assertIn("-0.5 0.8 xlo xhi", path.read_text())
        again = defe.read_mesh(path)
        for name in ("nodes", "hexes", "parts", "types"):    # to the last bit
            np.testing.assert_array_equal(getattr(again, name), getattr(mesh, name))

    def test_damaged(self):
        self.refuse(defe.read_mesh, MESH.replace("12 14 15", "12 19 15"), "line 24", "there is no node 19")
        self.refuse(defe.read_mesh, MESH.replace("13 12 14 15 17 16", "13 12"), "line 24", "not a line of the section Hexes")
        self.refuse(defe.read_mesh, MESH.replace("11 1 0 1 1 0 0", "11 1 0 1 1"), "line 14", "not a line of the section Atoms")
        self.refuse(defe.read_mesh, MESH.replace("# sphere", "# bpm/sphere"), "line 11", "atoms of style bpm/sphere")
        self.refuse(defe.read_mesh, MESH.split("Hexes")[0], "no sections Atoms and Hexes")

    def test_what_fix_defe_would_refuse(self):
        one = defe.block([0, 1], [0, 1], [0, 1])
        path = self.folder / "mesh.data"
        for change, words in (
                ({"hexes": one.hexes[:, [4, 5, 6, 7, 0, 1, 2, 3]]}, "negative volume.*element 1; exchange their lower and upper four nodes"),
                ({"hexes": np.concatenate([one.hexes, one.hexes])}, "elements 1, 2 have the same nodes"),
                ({"nodes": np.concatenate([one.nodes, [[2, 2, 2]]])}, r"nodes\[8\] is of no element"),
                ({"nodes": one.nodes * np.nan}, "not finite"),
                ({"parts": "my glass"}, "the part 'my glass'"),
                ({"types": 0}, "atom types are integers")):
            with self.assertRaisesRegex(defe.InputError, words):
                defe.write_mesh(path, defe.Mesh(**{"nodes": one.nodes, "hexes": one.hexes, **change}))
        with self.assertRaisesRegex(defe.InputError, "there is no folder"):
            defe.write_mesh(self.folder / "none" / "mesh.data", one)
        with self.assertRaisesRegex(defe.InputError, r"hexes\[0\] names a node that is not there: indices run from 0 to 7"):
            defe.Mesh(one.nodes, one.hexes + 1)
        with self.assertRaisesRegex(defe.InputError, r"nodes need an array \(n, 3\)"):
            defe.Mesh(one.nodes[:, :2], one.hexes)
        with self.assertRaisesRegex(defe.InputError, "one part for all elements or one of each"):
            defe.Mesh(one.nodes, one.hexes, ["a", "b"])
        with self.assertRaisesRegex(defe.InputError, "y needs two or more rising positions"):
            defe.block([0, 1], [1, 0], [0, 1])
        self.assertFalse(path.exists())


class Cracks(unittest.TestCase):
    def test_speed(self):
        time, x = np.array([3e-6, 0, 1e-6, 2e-6]), np.array([0.012, 0.0, 0.004, 0.003])
        t, far = defe.cracks.farthest(time, x)
        self.assertEqual((t.tolist(), far.tolist()), ([0, 1e-6, 2e-6, 3e-6], [0, 0.004, 0.004, 0.012]))
        self.assertAlmostEqual(defe.cracks.speed(time, x, 0.004, 0.01), 3000.0)
        self.assertTrue(math.isnan(defe.cracks.speed(time, x, 0.0, 0.02)))
        self.assertTrue(math.isnan(defe.cracks.speed([], [], 0.0, 0.02)))
        self.assertEqual(defe.cracks.speed([1e-6, 1e-6], [0.0, 0.01], 0.0, 0.01), math.inf)

    def test_arms(self):
        x = np.array([[10, y, 0] for y in (-5, -4.5, 0, 1, 9)] + [[20, 30, 0]], float)
        self.assertEqual([defe.cracks.arms(x, 10.5, 1.0, apart) for apart in (1.5, 4.9, 20)], [3, 2, 1])
        self.assertEqual(defe.cracks.arms(x, 15, 1.0, 1.0), 0)

    def test_radial(self):
        """Seven rays, one of them across the seam at 180 degrees; what goes round the circle does not count."""
        x, n = [], []
        for a in np.radians([-170, -100, -30, 5, 14, 80, 130, 176, 179, -178]):
            x.append((math.cos(a), math.sin(a), 0))
            n.append((-math.sin(a), math.cos(a), 0))
        for a in np.radians([30, 50]):
            x.append((math.cos(a), math.sin(a), 0))
            n.append(x[-1])
        x, n = np.array(x) * 0.016, np.array(n)
        self.assertEqual(defe.cracks.count_radial(x, n, 0.016, 1e-3, 8.5), 7)
        self.assertEqual(defe.cracks.count_radial(x, n, 0.018, 1e-3, 8.5), 0)

    def test_far_from(self):
        points = np.array([[0.0, 0, 0], [2.9, 0, 0], [3.1, 0, 0], [-3.1, -0.1, 0]])
        self.assertEqual(defe.cracks.far_from(points, [[0, 0, 0]], 3.0).tolist(), [False, False, True, True])
        self.assertEqual(defe.cracks.far_from(points, [], 3.0).tolist(), 4 * [True])
        random = np.random.default_rng(1)
        a, b = random.uniform(-5, 5, (200, 3)), random.uniform(-5, 5, (40, 3))
        expected = np.linalg.norm(a[:, None] - b, axis=2).min(axis=1) > 1.2
        self.assertTrue(10 < expected.sum() < 190)
        np.testing.assert_array_equal(defe.cracks.far_from(a, b, 1.2), expected)


class Plots(Files):
    def test_unfold(self):
        angle, value = defe.plots.unfold([0, 30, 90], [1, 2, 3])
        self.assertEqual(angle.tolist(), [0, 30, 90, 150, 180, 210, 270, 330, 360])
        self.assertEqual(value.tolist(), [1, 2, 3, 2, 1, 2, 3, 2, 1])
        angle, value = defe.plots.unfold([0, 20, 45], [1, 2, 3], (45, 90, 180))
        self.assertEqual(dict(zip(angle, value))[70], 2)
        self.assertEqual((len(angle), value[angle == 90].tolist(), value[angle == 225].tolist(), value[angle == 340].tolist()), (17, [1], [3], [2]))

    def test_files(self):
        try:
            import PIL.Image
            plt = defe.plots.plotting()
        except (ImportError, defe.InputError):
            self.skipTest("no matplotlib or PIL")
        columns = {name: np.linspace(1, 2, 5) for name in defe.ENTRIES}
        e = defe.Table({"step": np.arange(5.0), "time_us": np.arange(5.0), **columns})
        events = defe.read_events(self.file(EVENTS))
        out = {name: self.folder / (name + ".png") for name in ("energies", "loaded", "timeline", "none", "force", "polar", "sheet")}
        defe.plots.energies(out["energies"], "title", e, [2.0, None], limit=0.1, large_elements=True)
        e.columns["total"] = e["total"] - 1.0    # of a body that is loaded
        defe.plots.energies(out["loaded"], "title", e)
        defe.plots.timeline(out["timeline"], "title", events, 30.0)
        defe.plots.timeline(out["none"], "title", events.of("debonded"))
        defe.plots.force(out["force"], "title", {"a": ([0, 1e-6], [0, 1e3]), "b": ([0, 1e-6], [1e3, 0])}, 1.0, [0.5])
        figure, axes = defe.plots.polar_pair()
        for axis in axes:
            defe.plots.polar(axis, "title", [1, 2], 3, {"a": ([0, 90], [1, 2], {"color": "k"})})
        defe.plots.polar_legend(figure, "title")
        figure.savefig(out["polar"])
        plt.close("all")
        defe.plots.sheet(out["sheet"], "title", [(out["energies"], "(a)"), (out["force"], "(b)"), None, (out["polar"], "(c)")], 2, 100)
        for name, path in out.items():
            image = np.asarray(PIL.Image.open(path).convert("L"))
            self.assertTrue(image.std() > 5, name)    # something is drawn
        self.assertEqual(image.shape[1], 2 * 108 + 8)    # of the sheet, the last one

    def test_pictures(self):
        for name in ("front.00200.png", "front.00100.png", "side.00000.png"):
            self.file("", name)
        found = defe.plots.pictures(self.folder, "front.*.png", 1e-7)
        self.assertEqual([(round(t, 9), p.name) for t, p in found], [(10.0, "front.00100.png"), (20.0, "front.00200.png")])
        self.assertEqual(defe.plots.letters(["x", "y"]), ["(a)  x", "(b)  y"])


if __name__ == "__main__":
    unittest.main()
