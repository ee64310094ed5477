#!/usr/bin/env python3
"""The verification manual without LAMMPS: meshes of its plates, verdicts, its page."""

import math
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

MANUAL = Path(__file__).resolve().parents[1] / "verification" / "manual"
sys.path.insert(0, str(MANUAL))
import manual  # noqa: E402
from plates import NotchedPlate, start_of_crack  # noqa: E402


class Plates(unittest.TestCase):
    def test_fill_the_rectangle_on_any_lattice(self):
        """A turned grid that is too small leaves out corners of the plate."""
        for lattice, moved in ((0.0, 0.0), (45.0, 0.0), (0.0, 0.2)):
            plate = NotchedPlate(0.1, 0.04, 1e-3, 0.05, 1e-3, lattice, moved, band=2e-3)
            with self.subTest(lattice=lattice, moved=moved):
                area = len(plate.mesh.hex) * 1e-6
                self.assertAlmostEqual(area / 0.004, 1.0, delta=0.03)
                for corner in ((-1, -1), (-1, 1), (1, -1), (1, 1)):
                    away = np.linalg.norm(plate.mesh.X[:, :2] - np.array(corner) * [0.05, 0.02], axis=1).min()
                    self.assertLess(away, 1e-3)

    def test_are_cut_along_the_notch(self):
        for lattice in (0.0, 45.0):
            plate = NotchedPlate(0.1, 0.04, 1e-3, 0.05, 1e-3, lattice)
            upper = set(plate.mesh.hex[plate.mesh.centre[:, 1] > 0.0].ravel())
            lower = set(plate.mesh.hex[plate.mesh.centre[:, 1] < 0.0].ravel())
            shared = plate.mesh.X[sorted(upper & lower), 0]
            self.assertGreater(shared.min(), -0.8e-3)
            self.assertLess(shared.min(), 0.8e-3)

    def test_traction_is_its_resultant(self):
        plate = NotchedPlate(0.1, 0.04, 1e-3, 0.05, 1e-3, 45.0, band=2e-3)
        file = Path(self.enterContext(tempfile.TemporaryDirectory())) / "force"
        plate.write_traction(file)
        force = np.array([float(line.split()[1]) for line in file.read_text().splitlines()[2:]])
        self.assertAlmostEqual(force[force > 0].sum(), 0.1 * 1e-3, delta=1e-12)
        self.assertAlmostEqual(force.sum(), 0.0, delta=1e-12)

    def test_start_of_crack(self):
        """Steel-like: way 0, K = 2 s sqrt(c t/pi) with nu = 0."""
        t = start_of_crack(200e9, 0.0, 8000.0, 50.0, 1e6, 0.0)
        self.assertAlmostEqual(2e6 * math.sqrt(5000.0 * t / math.pi), math.sqrt(200e9 * 50.0), delta=1.0)


class Cylinder(unittest.TestCase):
    def test_is_round_and_sound(self):
        case = manual.load("taylor_bar")
        for n in (2, 3):
            bar = case.Cylinder(n, 12)
            x = bar.X[bar.hex]
            edges = x[:, [1, 3, 4]] - x[:, :1]    # at a node; all are elements of prisms
            self.assertGreater(np.linalg.det(edges).min(), 0.0)
            plane = x[:, :4, :2]
            area = 0.5 * np.cross(plane[:, 2] - plane[:, 0], plane[:, 3] - plane[:, 1]).sum() / 12.0
            self.assertAlmostEqual(area / (math.pi * case.RADIUS**2), 1.0, delta=0.03)
            self.assertEqual(len(np.unique(bar.X.round(9), axis=0)), len(bar.X))


class Sphere(unittest.TestCase):
    def test_is_round_and_sound(self):
        balls = manual.load("contact_chung_ooi").balls
        for how in (0.0, 2.5):
            X, hexes = unit = balls.sphere(4, 4, how)
            x = X[hexes]
            corners = ((0, 1, 3, 4), (1, 2, 0, 5), (2, 3, 1, 6), (3, 0, 2, 7), (4, 7, 5, 0), (5, 4, 6, 1), (6, 5, 7, 2), (7, 6, 4, 3))
            volumes = np.array([np.linalg.det(x[:, [a, b, c]] - x[:, [o]]) for o, a, b, c in corners])
            self.assertGreater(volumes.min(), 0.0)
            self.assertAlmostEqual(volumes.mean(axis=0).sum() / (4.0 / 3.0 * math.pi), 1.0, delta=0.05)
            self.assertEqual(len(np.unique(X.round(9), axis=0)), len(X))
            self.assertGreater(balls.shortest_edge(unit), 0.01)
            self.assertAlmostEqual(np.linalg.norm(X, axis=1).max(), 1.0, delta=1e-12)

    def test_hertz_is_as_published(self):
        force, overlap, time = (case := manual.load("contact_chung_ooi")).hertz(*case.NORMAL["1, glass"])
        self.assertAlmostEqual(1e-3 * force, 10.70, delta=0.005)
        self.assertAlmostEqual(1e6 * overlap, 274.0, delta=0.5)
        self.assertAlmostEqual(1e6 * time, 40.3, delta=0.05)


class Logs(unittest.TestCase):
    def test_processor_time_is_that_of_all_runs(self):
        run = "Loop time of {} on 1 procs for 10 steps with 8 atoms\n\nPerformance: 1 ns/day\n{}% CPU use with 1 MPI tasks x 1 OpenMP threads\n"
        self.assertAlmostEqual(manual.processor_seconds("Step\n" + run.format("8.0", "50.0") + "text\n" + run.format("2", "99.5")), 5.99)
        self.assertEqual(manual.processor_seconds("nothing"), 0.0)


class Verdicts(unittest.TestCase):
    def test_bounds(self):
        a = manual.Accept("x", "s", target=10.0, tolerance=1.0)
        self.assertEqual([a.verdict(v) for v in (9.0, 11.01, math.nan, None)], ["within", "not within", "not within", "not within"])
        self.assertEqual(manual.Accept("x", "s", high=2.0).verdict(-5.0), "within")
        self.assertEqual(manual.Accept("x", "s", low=1.0, high=2.0).published(), "1 to 2")

    def test_page_is_not_of_coarse_meshes(self):
        with tempfile.TemporaryDirectory() as out:
            command = [sys.executable, MANUAL / "manual.py", "--quick", "--page", "--lmp", "lmp", "--plugin", out, "--out", out]
            done = subprocess.run(command, capture_output=True, text=True, stdin=subprocess.DEVNULL, check=False)
        self.assertEqual(done.returncode, 2)
        self.assertIn("--quick leaves out the finest meshes", done.stderr)

    def test_all_cases_are_whole(self):
        self.assertIn("branching_soda_lime", manual.cases())
        for name in manual.cases():
            module = manual.load(name)
            text = (MANUAL / name / "README.md").read_text()
            for head in ("Problem", "Model", "Comparison", "Limits"):
                self.assertIn(f"## {head}\n", text, name)
            self.assertEqual(len({a.quantity for a in module.ACCEPTANCE}), len(module.ACCEPTANCE))
            self.assertTrue(all(a.source for a in module.ACCEPTANCE))

    def test_overview_counts_what_is_met(self):
        rows = [{"certain": c, "verdict": v, "quantity": q} for c, v, q in
                ((True, "within", "a"), (True, "not within, known", "b"), (False, "not within", "c"))]
        table = manual.overview({"x": {"title": "X", "rows": rows}, "y": {"title": "Y", "rows": rows[:1]}})
        self.assertEqual(table[1:], [["X", "1 of 2", "0 of 1", "b; c"], ["Y", "1 of 1", "-", "-"]])

    def test_page_keeps_sections_of_cases_that_were_not_run(self):
        folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        doc, out = folder / "doc", folder / "out"
        names = ["polar", "taylor_bar"]
        doc.mkdir()
        results = {}
        for name in names:
            (out / name).mkdir(parents=True)
            (out / name / "a.png").write_bytes(b"first " + name.encode())
            results[name] = {"title": name + ", its title", "shown": [("figure", name + "/a.png", "what it shows")], "date": "2026-01-01", "fine": False,
                             "processor_seconds": 1.0, "rows": [{"quantity": "q", "unit": "", "here": 1.0, "published": "1 to 2", "verdict": "within",
                                                                 "source": "s", "certain": True, "digits": 3}]}
        titles = {name: results[name]["title"] for name in names}
        self.assertEqual(manual.rst_page({"polar": results["polar"]}, out, doc, titles), ["taylor_bar"])
        self.assertEqual(manual.rst_page(results, out, doc, titles), [])
        page = doc / "Howto_defe_verification.rst"
        first = page.read_text()
        self.assertEqual(manual.rst_page({"polar": results["polar"]}, out, doc, titles), [])
        self.assertEqual(page.read_text(), first)
        results["polar"]["date"] = "2026-02-02"
        results["polar"]["rows"][0]["verdict"] = "not within"
        (out / "polar" / "a.png").write_bytes(b"second")
        manual.rst_page({"polar": results["polar"]}, out, doc, titles)
        self.assertEqual(page.read_text().count("2026-02-02"), 1)
        self.assertEqual(page.read_text().count("2026-01-01"), 1)
        self.assertIn('"polar, its title", "0 of 1"', page.read_text())
        self.assertEqual((doc / "Howto_defe_verification_polar_a.png").read_bytes(), b"second")
        self.assertEqual((doc / "Howto_defe_verification_taylor_bar_a.png").read_bytes(), b"first taylor_bar")

    def test_markdown(self):
        page = manual.markdown("## A\n\none `x < y`\n\n* p\n  q\n* r\n")
        self.assertEqual(page, "<h3>A</h3>\n<p>one <code>x &lt; y</code></p>\n<ul><li>p q</li><li>r</li></ul>")


if __name__ == "__main__":
    unittest.main()
