#!/usr/bin/env python3
"""Measures the cracks of a flat plate under a ball from the event file of a run.

cracks.py FOLDER [FOLDER ...]               events.txt and mesh.data of laminated_plate
cracks.py --rings PLOT FOLDER [FOLDER ...]  draws the cracks of the upper surface, with their mean radius in eight sectors

A line per run. The analyse.py of laminated_plate puts the same into summary.json.
"""

import math
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "python"))
import defe

LAYER = 0.9e-3  # m: what counts as the surface
CIRCLE, WIDTH, APART = 16e-3, 1e-3, 8.0  # m, degrees: radial cracks are counted where they cross this circle
UNTIL = 40e-6  # s: until then; later ones come from the rim
CRUSHED = 8.5e-3  # m: rings are looked for outside
FIRST = 6e-6  # s: so long from where they begin, about the time that a ring takes to close


def cuts(events, low, high):
    """Joints that began to soften in a layer, of heights in m, until then."""
    soft = events.of("cohesive")
    return soft.where((soft.x[:, 2] > low) & (soft.x[:, 2] < high) & (soft.time < UNTIL))


def radial_cracks(soft):
    return defe.cracks.count_radial(soft.x, soft.n, CIRCLE, WIDTH, APART)


def ring_radii(soft):
    """Mean radius (m) of the first ring cracks in eight sectors, from the axis x on: rings begin inside and follow the wave
    of bending outwards, so all sectors are compared over the same time. NaN where there is none."""
    radius, angle, outwards, _ = defe.cracks.polar(soft.x, soft.n)
    ring = (radius > CRUSHED) & (outwards > 0.8)
    times = np.sort(soft.time[ring])
    if len(times) < 20:
        return 8 * [math.nan]
    ring &= soft.time < times[5] + FIRST
    sector = np.round(angle % 360 / 45).astype(int) % 8
    return [float(np.mean(radius[ring & (sector == k)])) if (ring & (sector == k)).any() else math.nan for k in range(8)]


def axes_to_diagonals(radii):
    """Mean of the sectors on the axes to that of the others; of those that have a ring, if three of both have."""
    axes, diagonals = (np.array(radii[k::2])[~np.isnan(radii[k::2])] for k in (0, 1))
    return np.mean(axes) / np.mean(diagonals) if min(len(axes), len(diagonals)) > 2 else math.nan


def measure(folder):
    """The ball hits at x = y = 0."""
    events, z = read(folder)
    radii = ring_radii(upper_surface(events, z))

    def number(x, digits):
        return None if math.isnan(x) else round(float(x), digits)

    return {
        "radial_cracks": radial_cracks(cuts(events, z.min(), z.min() + LAYER)),
        "ring_mm": [number(1e3 * r, 2) for r in radii],
        "ring_axes_to_diagonals": number(axes_to_diagonals(radii), 3),
    }


def read(folder):
    """Events of a run, and heights (m) of the nodes of its mesh."""
    return defe.read_events(folder / "events.txt"), defe.read_mesh(folder / "mesh.data").nodes[:, 2]


def upper_surface(events, z):
    return cuts(events, z.max() - LAYER, z.max())


def draw_rings(path, folders):
    plt = defe.plots.plotting()
    figure, axes = plt.subplots(1, len(folders), figsize=(4.2 * len(folders), 4.6), squeeze=False, constrained_layout=True)
    surfaces = [upper_surface(*read(Path(folder))) for folder in folders]
    times = 1e6 * np.concatenate([soft.time for soft in surfaces])
    low, high = (times.min(), times.max()) if len(times) else (None, None)    # one scale for all
    for axis, folder, soft in zip(axes[0], map(Path, folders), surfaces):
        radii = ring_radii(soft)
        points = axis.scatter(1e3 * soft.x[:, 0], 1e3 * soft.x[:, 1], c=1e6 * soft.time, s=2, linewidths=0, vmin=low, vmax=high)
        for k, radius in enumerate(radii):
            angle = np.radians(45 * k + np.linspace(-20, 20, 20))
            axis.plot(1e3 * radius * np.cos(angle), 1e3 * radius * np.sin(angle), "k:", linewidth=1)
        axis.set(aspect="equal", xlim=(-26, 26), ylim=(-26, 26), xlabel="mm", title=f"{folder.name}\naxes to diagonals {axes_to_diagonals(radii):.2f}")
    figure.colorbar(points, ax=axes[0, -1], label="begins to soften (us)")
    figure.savefig(path, dpi=100)
    plt.close(figure)


def main(folders):
    if folders[0] == "--rings":
        return draw_rings(Path(folders[1]), folders[2:])
    for name in folders:
        print(name, " ".join(f"{k} {v}" for k, v in measure(Path(name)).items()))


if __name__ == "__main__":
    if len(sys.argv) < (4 if "--rings" in sys.argv else 2):
        sys.exit(__doc__)
    defe.summary.main(main, sys.argv[1:])
