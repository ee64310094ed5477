#!/usr/bin/env python3
"""Measures the cracks of a flat plate under a ball from the event file of a run.

cracks.py FOLDER [FOLDER ...]     events.txt and mesh.data of laminated_plate

A line per run. The analyse.py of laminated_plate puts the same into summary.json.
"""

import math
import sys
from pathlib import Path

import numpy as np

import laminate

LAYER = 0.9  # mm: what counts as the surface
CIRCLE, WIDTH = 16.0, 1.0  # mm: radial cracks are counted where they cross this circle
UNTIL = 40.0  # us: until then; later ones come from the rim
CRUSHED = 8.5  # mm: rings are looked for outside
FIRST = 6.0  # us: so long from where they begin, about the time that a ring takes to close


class Cuts:
    """Joints that began to soften in a layer: times, radii, angles (degrees), and how their normals lie."""

    def __init__(self, events, low, high):
        rows = [e for e in events if e[2] == "cohesive" and low < e[5][2] < high]
        x, n = (np.array([e[k] for e in rows]).reshape(-1, 3) for k in (5, 6))
        self.time = np.array([e[1] for e in rows])
        self.radius = np.maximum(np.hypot(x[:, 0], x[:, 1]), 1e-9)
        self.angle = np.degrees(np.arctan2(x[:, 1], x[:, 0]))
        self.outwards = np.abs(x[:, 0] * n[:, 0] + x[:, 1] * n[:, 1]) / self.radius
        self.around = np.abs(x[:, 0] * n[:, 1] - x[:, 1] * n[:, 0]) / self.radius


def radial_cracks(cuts):
    """Cracks along a radius that cross the circle: groups of joints, 8 degrees apart."""
    near = (np.abs(cuts.radius - CIRCLE) < WIDTH) & (cuts.around > 0.8) & (cuts.time < UNTIL)
    angle = np.sort(cuts.angle[near])
    if not len(angle):
        return 0
    return max(1, int((np.diff(np.append(angle, angle[0] + 360)) > 8).sum()))


def ring_radii(cuts):
    """Mean radius of the first ring cracks in eight sectors, from the axis x on: rings begin inside and follow the wave
    of bending outwards, so all sectors are compared over the same time. NaN where there is none."""
    ring = (cuts.radius > CRUSHED) & (cuts.outwards > 0.8) & (cuts.time < UNTIL)
    times = np.sort(cuts.time[ring])
    if len(times) < 20:
        return 8 * [math.nan]
    ring &= cuts.time < times[5] + FIRST
    sector = np.round(cuts.angle % 360 / 45).astype(int) % 8
    return [float(np.mean(cuts.radius[ring & (sector == k)])) if (ring & (sector == k)).any() else math.nan for k in range(8)]


def axes_to_diagonals(radii):
    """Mean of the sectors on the axes to that of the others; of those that have a ring, if three of both have."""
    axes, diagonals = (np.array(radii[k::2])[~np.isnan(radii[k::2])] for k in (0, 1))
    return np.mean(axes) / np.mean(diagonals) if min(len(axes), len(diagonals)) > 2 else math.nan


def measure(folder):
    """The ball hits at x = y = 0."""
    events, z = laminate.read_events(folder / "events.txt"), 1e3 * laminate.read_mesh(folder / "mesh.data")["x"][:, 2]
    radii = ring_radii(Cuts(events, z.max() - LAYER, z.max()))
    number = lambda x, digits: None if math.isnan(x) else round(float(x), digits)
    return {
        "radial_cracks": radial_cracks(Cuts(events, z.min(), z.min() + LAYER)),
        "ring_mm": [number(r, 2) for r in radii],
        "ring_axes_to_diagonals": number(axes_to_diagonals(radii), 3),
    }


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    for name in sys.argv[1:]:
        print(name, " ".join(f"{k} {v}" for k, v in measure(Path(name)).items()))
