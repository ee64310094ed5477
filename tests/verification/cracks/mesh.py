"""Meshes of turned lattices for LAMMPS, and what the event file of fix defe says about cracks in them."""

import numpy as np

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
        with open(file, 'w') as out:
            out.write(f'lattice\n\n{len(self.X)} atoms\n{types} atom types\n{len(self.hex)} hexes\n\n')
            for k, name in enumerate('xyz'):
                out.write(f'{lo[k]:.9g} {hi[k]:.9g} {name}lo {name}hi\n')
            out.write('\nAtoms # sphere\n\n')
            for k, X in enumerate(self.X):
                out.write(f'{k + 1} {kind[k]} 0 1 {X[0]:.15g} {X[1]:.15g} {X[2]:.15g}\n')
            out.write('\nHexes\n\n')
            for k, nodes in enumerate(self.hex):
                out.write(f'{k + 1} {part[k]} ' + ' '.join(str(n + 1) for n in nodes) + '\n')

    def de(self, ids):
        """Reference positions of DEs."""
        k = np.asarray(ids) - len(self.X) - 1
        weights = np.prod(1.0 + SIGNS[:, None, :] * 0.5 * SIGNS[None, :, :], axis=2) / 8.0    # [node, DE]
        return np.einsum('eac,ae->ec', self.X[self.hex[k // 8]], weights[:, k % 8])


class Events:
    """cohesive and broken joints: time, two DEs, crack point, normal."""

    def __init__(self, file, what, after=0):
        rows = [line.split() for line in open(file) if not line.startswith('#')]
        rows = [r for r in rows if r[2] == what and int(r[0]) > after]
        self.step = np.array([int(r[0]) for r in rows], int)
        self.time = np.array([float(r[1]) for r in rows])
        self.ids = np.array([[int(r[3]), int(r[4])] for r in rows], int).reshape(-1, 2)
        self.x = np.array([[float(v) for v in r[5:8]] for r in rows]).reshape(-1, 3)
        self.n = np.array([[float(v) for v in r[8:11]] for r in rows]).reshape(-1, 3)
        self.value = np.array([float(r[11]) for r in rows])

    def __len__(self):
        return len(self.step)

    def where(self, chosen):
        few = Events.__new__(Events)
        for name, values in vars(self).items():
            setattr(few, name, values[chosen])
        return few
