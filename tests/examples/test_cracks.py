"""What examples/cracks.py and laminate.used_conversions() say of cracks that are known."""

import math
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import numpy as np

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent.parent.parent / "examples"))
import cracks
import laminate
from laminate import defe


def cut(time, x, y, z, normal, ids=(1001, 1002), kind="cohesive"):
    """An event at a time in us, a place in mm."""
    return 0, 1e-6 * time, kind, ids, np.array([x, y, z]) * 1e-3, (*normal, 0.0), 6e7


def events_of(rows):
    return defe.Events(*zip(*rows)) if rows else defe.Events([], [], [], [], [], [], [])


def cuts(rows, low, high):
    return cracks.cuts(events_of(rows), 1e-3 * low, 1e-3 * high)


def radial(degrees, time=20.0, outer=30.0):
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return [cut(time, r * c, r * s, 0.5, (-s, c)) for r in np.arange(5.0, outer, 0.5)]


def ring(radius_of, time=20.0):
    angles = np.radians(np.arange(0.0, 360.0, 3.0))
    return [cut(time, radius_of(a) * math.cos(a), radius_of(a) * math.sin(a), 5.5, (math.cos(a), math.sin(a))) for a in angles]


class Cracks(unittest.TestCase):
    def test_radial(self):
        angles = [-170, -100, -30, 5, 14, 80, 130]
        events = [e for a in angles for e in radial(a)]
        # those that are too short, too late or rings do not count
        events += radial(45, outer=12.0) + radial(-65, time=60.0)
        events += [cut(20.0, 16 * math.cos(a), 16 * math.sin(a), 0.5, (math.cos(a), math.sin(a))) for a in np.arange(0, 6.28, 0.05)]
        self.assertEqual(cracks.radial_cracks(cuts(events, 0.0, 1.0)), 7)
        self.assertEqual(cracks.radial_cracks(cuts(radial(179.9) + radial(-179.9), 0.0, 1.0)), 1)
        self.assertEqual(cracks.radial_cracks(cuts([], 0.0, 1.0)), 0)

    def test_ring(self):
        circle = cracks.ring_radii(cuts(ring(lambda a: 12.0) + ring(lambda a: 18.0, 30.0) + ring(lambda a: 5.0, 1.0), 5.0, 6.0))
        for r in circle:
            self.assertAlmostEqual(r, 12e-3)
        square = cracks.ring_radii(cuts(ring(lambda a: 12.0 / max(abs(math.cos(a)), abs(math.sin(a)))), 5.0, 6.0))
        self.assertLess(cracks.axes_to_diagonals(square), 0.85)
        self.assertAlmostEqual(cracks.axes_to_diagonals(circle), 1.0)
        nan = math.nan    # sectors without a ring are left out, if there are not too many
        self.assertAlmostEqual(cracks.axes_to_diagonals([nan, 10.0, 12.0, 11.0, 14.0, 9.0, 13.0, 10.0]), 1.3)
        with tempfile.TemporaryDirectory() as folder:
            plot = Path(folder) / "rings.png"
            with mock.patch.object(cracks, "read", lambda _: (events_of(ring(lambda a: 12.0)), np.array([0.0, 6e-3]))):
                cracks.main(["--rings", str(plot), "one", "other"])
            self.assertEqual(plot.read_bytes()[:4], b"\x89PNG")
        self.assertTrue(math.isnan(cracks.axes_to_diagonals([nan, 10.0, nan, 11.0, 14.0, 9.0, 13.0, 10.0])))
        self.assertTrue(all(math.isnan(r) for r in cracks.ring_radii(cuts([], 5.0, 6.0))))

    def test_conversions(self):
        nodes = 100

        def convert(element, x):
            return cut(1.0, x, 0.0, 0.0, (0.0, 0.0), (element, 3), "convert")

        # element 2 holds both ends of a joint; 3 is near it, 9 far away
        events = [convert(2, 2.0), convert(3, 6.0), convert(9, 40.0), cut(2.0, 2.0, 0.0, 0.0, (1.0, 0.0), (nodes + 9, nodes + 10))]
        self.assertEqual(laminate.used_conversions(events_of(events), nodes, 2e-3),
                         {"converted_that_crack_percent": 33.3, "converted_far_from_cracks": 1})
        self.assertEqual(laminate.used_conversions(events_of([]), nodes, 2e-3),
                         {"converted_that_crack_percent": None, "converted_far_from_cracks": 0})


if __name__ == "__main__":
    unittest.main()
