"""Meshes of turned lattices for LAMMPS."""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / 'python'))
from hexmesh.data_file import data_lines  # noqa: E402

SIGNS = np.array([[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1],
                  [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]])


def turned(about_z, about_x=0.0):
    """The lattice is turned about x, then about z (degrees)."""
    a, b = np.radians([about_z, about_x])
    z = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
    x = np.array([[1, 0, 0], [0, np.cos(b), -np.sin(b)], [0, np.sin(b), np.cos(b)]])
    return z @ x


def along(direction):
    """A lattice whose `direction` is along y."""
    y = np.asarray(direction, float) / np.linalg.norm(direction)
    x = np.cross(y, [0.0, 0.0, 1.0] if abs(y[2]) < 0.9 else [1.0, 0.0, 0.0])
    x /= np.linalg.norm(x)
    return np.array([x, y, np.cross(x, y)])


class Mesh:
    """Elements of edges h (3 numbers) in a turned lattice, of which keep(centres) is true."""

    def __init__(self, h, turn, keep, reach, moved=0.0, seed=1, shift=(0.0, 0.0, 0.0)):
        h = np.asarray(h, float)
        n = np.ceil(reach / h).astype(int)
        axes = [np.arange(-k, k + 2) - 0.5 for k in n]
        grid = np.stack(np.meshgrid(*axes, indexing='ij'), -1)
        random = np.random.default_rng(seed)
        grid = (grid + np.asarray(shift)) * h + moved * h * random.uniform(-1, 1, grid.shape)
        nodes = (grid @ turn.T).reshape(-1, 3)
        size = grid.shape[:3]
        first = np.stack(np.meshgrid(*[np.arange(s - 1) for s in size], indexing='ij'), -1).reshape(-1, 1, 3)
        corner = first + (SIGNS + 1) // 2
        hexes = (corner[..., 0] * size[1] + corner[..., 1]) * size[2] + corner[..., 2]
        hexes = hexes[keep(nodes[hexes].mean(axis=1))]
        used, inverse = np.unique(hexes, return_inverse=True)
        self.h, self.turn = h, turn
        self.X, self.hex = nodes[used], inverse.reshape(-1, 8)
        self.centre = self.X[self.hex].mean(axis=1)

    def reach(self, margin=0.01):
        """Corners of the box that write() gives to LAMMPS."""
        return 1.5 * self.X.min(axis=0) - margin, 1.5 * self.X.max(axis=0) + margin

    def box(self, margin=0.01):
        """The same as variables xlo to zhi."""
        return {c + e: float(v[k]) for e, v in zip(('lo', 'hi'), self.reach(margin)) for k, c in enumerate('xyz')}

    def write(self, file, types, part=None, held=None, margin=0.01):
        """part: names, of each element; nodes of elements that are held have type 2. margin: of the box."""
        part = np.full(len(self.hex), 'glass') if part is None else part
        kind = np.ones(len(self.X), int)
        if held is not None:
            kind[self.hex[held].ravel()] = 2
        lo, hi = self.reach(margin)
        lines = data_lines('lattice', (len(self.X), types, len(self.hex)), [(f'{a:.9g}', f'{b:.9g}') for a, b in zip(lo, hi)],
                           ((k + 1, kind[k], f'{X[0]:.15g} {X[1]:.15g} {X[2]:.15g}') for k, X in enumerate(self.X)),
                           ((k + 1, part[k], nodes + 1) for k, nodes in enumerate(self.hex)))
        with open(file, 'w') as out:
            out.writelines(line + '\n' for line in lines)

    def de(self, ids):
        """Reference positions of DEs."""
        k = np.asarray(ids) - len(self.X) - 1
        weights = np.prod(1.0 + SIGNS[:, None, :] * 0.5 * SIGNS[None, :, :], axis=2) / 8.0    # [node, DE]
        return np.einsum('eac,ae->ec', self.X[self.hex[k // 8]], weights[:, k % 8])
