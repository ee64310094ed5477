"""Notched plates under a sudden traction on their long edges, or struck at one: meshes, loads, and what the event file
says about their cracks. SI units, the crack runs along x in the plane z = 0."""

import sys
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parent.parent / "cracks"), str(Path(__file__).resolve().parents[3] / "python")]
import defe  # noqa: E402
from mesh import Mesh, turned  # noqa: E402


class Nodes:
    """Points of a mesh that is made piece by piece, those at one place once."""

    def __init__(self):
        self.points, self._numbers = [], {}

    def number(self, p):
        """Of the point at p, a new one if there is none."""
        key = tuple(np.round(p, 9) + 0.0)
        if key not in self._numbers:
            self._numbers[key] = len(self.points)
            self.points.append(p)
        return self._numbers[key]


class NotchedPlate:
    """A plate of elements of edge h, one through the thickness, and what is left of it beside the notch.

    The notch is sharp, a cut along y = 0: nodes left of its end are doubled. In a turned lattice the elements that it crosses
    are left out. Elements whose centres lie within `band` of the long edges do not convert (part 'edge'): traction is put on
    their nodes, by their share of the band's volume, so that it is the same on any mesh.
    lattice: 0 or 45, its angle in degrees; moved: nodes at random by up to this share of h; below: what is below the notch, half of the
    height if it is not given."""

    def __init__(self, length, height, thickness, notch, h, lattice=0.0, moved=0.0, band=None, below=None):
        self.length, self.height, self.thickness, self.notch, self.h = length, height, thickness, notch, h
        self.band = band or 2.0 * h
        self.low = -(height / 2 if below is None else below)
        self.high = self.low + height
        tip = notch - length / 2
        turn = turned(lattice)
        crossed = 0.49 * h * (abs(turn[1, 0]) + abs(turn[1, 1]))

        def inside(c):
            plate = (np.abs(c[:, 0]) < length / 2) & (c[:, 1] > self.low) & (c[:, 1] < self.high) & (np.abs(c[:, 2]) < thickness / 2)
            return plate & ~((c[:, 0] < tip) & (np.abs(c[:, 1]) < crossed - moved * 0.2 * h))

        half = np.array([length / 2, max(-self.low, self.high)])
        reach = np.full(2, np.linalg.norm(half)) if lattice else half
        self.mesh = Mesh([h, h, thickness], turn, inside, np.append(reach + 2 * h, thickness), moved, shift=(0.5, 0.5, 0.0))
        self.cut(tip - (0.01 + moved) * h)
        self.held = (self.mesh.centre[:, 1] < self.low + self.band) | (self.mesh.centre[:, 1] > self.high - self.band)

    def cut(self, tip):
        """Doubles the nodes that elements above and below share, left of the end of the notch."""
        m = self.mesh
        lower = m.centre[:, 1] < 0.0
        both = np.intersect1d(m.hex[lower], m.hex[~lower])
        both = both[m.X[both, 0] < tip]
        copy = np.arange(len(m.X))
        copy[both] = len(m.X) + np.arange(len(both))
        m.X = np.concatenate([m.X, m.X[both]])
        m.hex[lower] = copy[m.hex[lower]]

    def volumes(self):
        """Of the elements: those of boxes, which random moves leave as they are in the mean."""
        return np.full(len(self.mesh.hex), self.h * self.h * self.thickness)

    def write(self, file):
        self.mesh.write(file, 3, np.where(self.held, "edge", "body"), self.held)

    def write_traction(self, file):
        """Per node the force along y of a traction of 1 Pa that draws the long edges apart; a LAMMPS atomfile."""
        force = np.zeros(len(self.mesh.X))
        volume = self.volumes()
        for sign in (1.0, -1.0):
            side = self.held & (sign * self.mesh.centre[:, 1] > 0.0)
            share = np.zeros(len(self.mesh.X))
            np.add.at(share, self.mesh.hex[side].ravel(), np.repeat(volume[side] / 8.0, 8))
            force += sign * self.length * self.thickness * share / share.sum()
        loaded = np.flatnonzero(force)
        with open(file, "w") as out:
            out.write(f"# force along y of a traction of 1 Pa\n{len(loaded)}\n")
            for k in loaded:
                out.write(f"{k + 1} {force[k]:.12g}\n")


class Crack:
    """What the event file of a plate says. Lengths in m from the end of the notch, times in s."""

    def __init__(self, events, tip, spacing):
        self.d = spacing
        events = defe.read_events(events)
        self.broken, self.converted = events.of("broken"), events.of("convert")
        self.started = events.of("cohesive")
        self.x = self.broken.x - [tip, 0.0, 0.0]

    def start(self):
        """Time of the first joint that breaks."""
        return float(self.broken.time.min()) if len(self.broken) else np.nan

    def farthest(self):
        return defe.cracks.farthest(self.broken.time, self.x[:, 0])

    def speed(self, x1, x2):
        """Mean over this way, m/s."""
        return defe.cracks.speed(self.broken.time, self.x[:, 0], x1, x2)

    def arms(self, at, apart=4.0):
        """Cracks that cross the line x = at: broken joints that are `apart` spacings from each other along y."""
        return defe.cracks.arms(self.x, at, 2.0 * self.d, apart * self.d)

    def branching(self, until, apart=4.0):
        """Where (x, time) two arms stay apart from then on over 8 spacings; nan if nowhere up to `until`."""
        step = 2.0 * self.d
        at = np.arange(step, until, step)
        two = [self.arms(x, apart) >= 2 for x in at]
        for k in range(len(at) - 4):
            if all(two[k:k + 4]):
                near = np.abs(self.x[:, 0] - at[k]) < 2.0 * self.d
                return float(at[k]), float(self.broken.time[near].min())
        return np.nan, np.nan

    def angle(self, x1, x2):
        """Mean direction in degrees of the broken joints with x1 < x < x2 (straight line through them)."""
        inside = (self.x[:, 0] > x1) & (self.x[:, 0] < x2)
        if inside.sum() < 5:
            return np.nan
        k = np.polyfit(self.x[inside, 0], self.x[inside, 1], 1)[0]
        return float(np.degrees(np.arctan(k)))


def stable_step(young, nu, rho, h):
    """Half of that of the DEs of cubes of edge h (fix defe, Time step): d/sqrt((lambda + 4 mu)/rho)."""
    lam, mu = young * nu / ((1 + nu) * (1 - 2 * nu)), young / (2 * (1 + nu))
    return 0.5 * 0.5 * h / np.sqrt((lam + 4 * mu) / rho)


def start_of_crack(young, nu, rho, gf, pull, way):
    """When a long crack starts under a plane wave of tension that comes from `way` above and below: the closed form of
    Freund (Dynamic Fracture Mechanics, 1990, ch. 2.4), K = 2 pull sqrt((1 - 2 nu') c t/pi)/(1 - nu'), in plane stress."""
    flat = nu / (1 + nu)
    c = np.sqrt(young / (rho * (1 - nu * nu)))
    k = np.sqrt(young * gf)
    return way / c + (k * (1 - flat) / (2 * pull)) ** 2 * np.pi / ((1 - 2 * flat) * c)


def draw(ax, plate, crack, title, colour="#1f4e9c"):
    """Converted elements grey, broken joints in colour, mm."""
    c = crack.converted.x * 1e3
    ax.scatter(c[:, 0], c[:, 1], s=4, marker="s", color="0.85", zorder=0, linewidths=0)
    x = crack.broken.x * 1e3
    ax.scatter(x[:, 0], x[:, 1], s=1.5, color=colour, linewidths=0)
    left = -plate.length * 500
    ax.plot([left, left + plate.notch * 1e3], [0, 0], color="k", lw=1.5)
    ax.set(xlim=(left, -left), ylim=(plate.low * 1e3, plate.high * 1e3), aspect="equal")
    ax.set_title(title, fontsize=8)
    ax.tick_params(labelsize=7)
