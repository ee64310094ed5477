"""Geometry and topology of hexahedra: what fix defe would refuse is refused here, by the same criteria."""

import itertools

import numpy as np

from .mesh import plural, some, which_elements
from .output import Refused

# Local nodes of the six faces and the natural coordinates of the nodes: as in fe-module's topology.h.
FACES = np.array([[0, 4, 7, 3], [1, 2, 6, 5], [0, 1, 5, 4], [3, 7, 6, 2], [0, 3, 2, 1], [4, 5, 6, 7]])
SIGNS = np.array([[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1],
                  [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]], dtype=float)
MIRRORED = [4, 5, 6, 7, 0, 1, 2, 3]  # the same hexahedron, numbered from the other side
# All numberings of the same hexahedron: by the 24 rotations of a cube.
TURNS = [[int(np.flatnonzero((SIGNS == turned).all(axis=1))[0]) for turned in SIGNS @ R.T]
         for R in (np.eye(3)[list(order)] * np.array(flips)[:, None]
                   for order in itertools.permutations(range(3)) for flips in itertools.product((1, -1), repeat=3))
         if np.linalg.det(R) > 0]


def jacobians(X, at):
    """det(dX/dxi) of all hexahedra X[:, 8, 3] at natural coordinates `at`, and the three columns scaled
    to length one (their determinant is the scaled Jacobian)."""
    s = SIGNS
    gradient = np.stack([s[:, 0] * (1 + at[1] * s[:, 1]) * (1 + at[2] * s[:, 2]),
                         s[:, 1] * (1 + at[0] * s[:, 0]) * (1 + at[2] * s[:, 2]),
                         s[:, 2] * (1 + at[0] * s[:, 0]) * (1 + at[1] * s[:, 1])], axis=1) / 8
    J = np.einsum("eai,aj->eij", X, gradient)
    det = np.linalg.det(J)
    lengths = np.prod(np.linalg.norm(J, axis=1), axis=1)
    return det, det / np.where(lengths > 0, lengths, 1)


def edge_lengths(X):
    ends = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
    return np.stack([np.linalg.norm(X[:, a] - X[:, b], axis=1) for a, b in ends], axis=1)


def close_pairs(points, tolerance):
    """Pairs i < j of points not farther apart than the tolerance."""
    if not tolerance > 0:
        return np.zeros((0, 2), dtype=np.int64)
    offset = points - points.min(axis=0)
    cell = np.floor(offset / max(tolerance, 1e-15 * offset.max())).astype(np.int64)  # far below 2^63
    factors = np.array([73856093, 19349663, 83492791])
    # Cells of different places may share a key: the distance decides.
    keys = (cell * factors).sum(axis=1)
    order = np.argsort(keys, kind="stable")
    found = []
    for shift in np.ndindex(3, 3, 3):
        wanted = ((cell + np.array(shift) - 1) * factors).sum(axis=1)
        left = np.searchsorted(keys[order], wanted, "left")
        right = np.searchsorted(keys[order], wanted, "right")
        for k in range(int((right - left).max(initial=0))):
            i = np.flatnonzero(left + k < right)
            j = order[left[i] + k]
            near = (i < j) & (np.linalg.norm(points[i] - points[j], axis=1) <= tolerance)
            found.append(np.stack([i[near], j[near]], axis=1))
    return np.unique(np.concatenate(found), axis=0) if found else np.zeros((0, 2), dtype=np.int64)


def merge_nodes(mesh, tolerance):
    """The first of each cluster of close nodes stands for all of them."""
    bad = (edge_lengths(mesh.points[mesh.hexes]) <= tolerance).any(axis=1)
    if bad.any():
        raise Refused(f"--merge {tolerance:g} joins nodes of {which_elements(mesh.hex_names[bad])}; "
                      "it must be smaller than all edges")
    parent = np.arange(len(mesh.points))

    def root(i):
        while parent[i] != i:
            i = parent[i]
        return i

    for i, j in close_pairs(mesh.points, tolerance):
        a, b = sorted((root(i), root(j)))
        parent[b] = a
    target = np.array([root(i) for i in range(len(parent))], dtype=np.int64)
    hexes = target[mesh.hexes]
    bad = (np.diff(np.sort(hexes, axis=1), axis=1) == 0).any(axis=1)
    if bad.any():
        raise Refused(f"--merge {tolerance:g} joins nodes of {which_elements(mesh.hex_names[bad])}; "
                      "it must be smaller than all edges")
    mesh.hexes = hexes
    mesh.node_sets = {name: np.unique(target[nodes]) for name, nodes in mesh.node_sets.items()}
    return target != np.arange(len(target))


def check_finite(mesh):
    """Before anything is computed. The square of a length and a volume must be numbers, too."""
    good = (abs(mesh.points) < 1e100).all(axis=1)
    bad = ~good[mesh.hexes].all(axis=1)
    if bad.any():
        raise Refused(f"coordinates that are not finite, or above 1e100: {which_elements(mesh.hex_names[bad])}")
    if not good.all():
        raise Refused(f"coordinates that are not finite, or above 1e100: node {some(mesh.node_names[~good])}")


def check_hexes(mesh, fix_orientation):
    """Refuses what fix defe would refuse, by the same criterion; the Jacobians' extremes."""
    X = mesh.points[mesh.hexes]
    twice = (np.diff(np.sort(mesh.hexes, axis=1), axis=1) == 0).any(axis=1)
    if twice.any():
        raise Refused(f"a node is twice in {which_elements(mesh.hex_names[twice])}: "
                      "wedges and pyramids written as hexahedra are not supported")

    def gauss(X):
        return np.stack([jacobians(X, s / np.sqrt(3.0))[0] for s in SIGNS], axis=1)

    threshold = 1e-6 * (edge_lengths(X).mean(axis=1) / 2)**3
    J = gauss(X)
    inverted = (J < -threshold[:, None]).all(axis=1)
    if inverted.any():
        if not fix_orientation:
            raise Refused(f"negative volume, numbered inside out: {which_elements(mesh.hex_names[inverted])}; "
                          "--fix-orientation renumbers their nodes")
        mesh.hexes[inverted] = mesh.hexes[inverted][:, MIRRORED]
        mesh.notes.append(f"{plural(inverted.sum(), 'inverted element')} renumbered")
        X = mesh.points[mesh.hexes]
        J = gauss(X)
    flat = J.max(axis=1) <= threshold
    if flat.any():
        raise Refused(f"no volume: {which_elements(mesh.hex_names[flat])}")
    bad = (J <= threshold[:, None]).any(axis=1)
    if bad.any():
        raise Refused(f"distorted, the Jacobian is not positive at a Gauss point: {which_elements(mesh.hex_names[bad])}")
    corners = np.stack([jacobians(X, s)[1] for s in [*SIGNS, np.zeros(3)]], axis=1)
    suspicious = (corners <= 0).any(axis=1)
    if suspicious.any():
        mesh.notes.append("the Jacobian is not positive at a corner (fix defe will warn): "
                          f"{which_elements(mesh.hex_names[suspicious])}")
    return J.sum(axis=1), corners.min(axis=1)


def check_faces(mesh):
    same = np.sort(mesh.hexes, axis=1)
    order = np.lexsort(same.T[::-1])
    double = (np.diff(same[order], axis=0) == 0).all(axis=1)
    if double.any():
        k = int(np.flatnonzero(double)[0])
        raise Refused(f"{which_elements(sorted(mesh.hex_names[order[k:k + 2]]))} have the same nodes"
                      f" ({plural(int(double.sum()), 'such pair')})")
    faces = np.sort(mesh.hexes[:, FACES].reshape(-1, 4), axis=1)
    _, which, counts = np.unique(faces, axis=0, return_inverse=True, return_counts=True)
    if (counts > 2).any():
        at = np.flatnonzero(which.ravel() == np.flatnonzero(counts > 2)[0]) // 6
        raise Refused(f"{which_elements(sorted(mesh.hex_names[at]))} share one face: at most two can")
    return int((counts == 1).sum())
