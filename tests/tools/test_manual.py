#!/usr/bin/env python3
"""The verification manual without LAMMPS: meshes of its plates, verdicts, its page."""

import math
import sys
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
        file = Path(self.enterContext(__import__("tempfile").TemporaryDirectory())) / "force"
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


class Verdicts(unittest.TestCase):
    def test_bounds(self):
        a = manual.Accept("x", "s", target=10.0, tolerance=1.0)
        self.assertEqual([a.verdict(v) for v in (9.0, 11.01, math.nan, None)], ["within", "not within", "not within", "not within"])
        self.assertEqual(manual.Accept("x", "s", high=2.0).verdict(-5.0), "within")
        self.assertEqual(manual.Accept("x", "s", low=1.0, high=2.0).published(), "1 to 2")

    def test_all_cases_are_whole(self):
        self.assertIn("branching_soda_lime", manual.cases())
        for name in manual.cases():
            module = manual.load(name)
            text = (MANUAL / name / "README.md").read_text()
            for head in ("Problem", "Model", "Comparison", "Limits"):
                self.assertIn(f"## {head}\n", text, name)
            self.assertEqual(len({a.quantity for a in module.ACCEPTANCE}), len(module.ACCEPTANCE))
            self.assertTrue(all(a.source for a in module.ACCEPTANCE))

    def test_markdown(self):
        page = manual.markdown("## A\n\none `x < y`\n\n* p\n  q\n* r\n")
        self.assertEqual(page, "<h3>A</h3>\n<p>one <code>x &lt; y</code></p>\n<ul><li>p q</li><li>r</li></ul>")


if __name__ == "__main__":
    unittest.main()
