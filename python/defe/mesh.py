"""Meshes of 8-node hexahedra as arrays, and the data file that `read_data FILE add append fix fe hexes Hexes` reads."""

import dataclasses
import re

import numpy as np
from hexmesh import checks, mesh as read_meshes
from hexmesh.data_file import data_lines
from hexmesh.output import LARGEST_ID, Refused, write_all

from .errors import InputError, at, text_of


@dataclasses.dataclass
class Mesh:
    """nodes (n, 3) in m; hexes (m, 8), indices of nodes from 0, in the order of VTK_HEXAHEDRON: four around one face,
    counter-clockwise seen from the opposite face, then the four opposite to them; parts (m,) names, or one name for
    all; types (n,) atom types of the nodes, or one for all. The ID of a node or element is its index plus 1."""

    nodes: np.ndarray
    hexes: np.ndarray
    parts: np.ndarray | str = "glass"
    types: np.ndarray | int = 1

    def __post_init__(self):
        self.nodes, self.hexes = np.asarray(self.nodes, float), np.asarray(self.hexes)
        if self.nodes.ndim != 2 or self.nodes.shape[1] != 3 or not len(self.nodes):
            raise InputError(f"nodes need an array (n, 3), not {self.nodes.shape}")
        if self.hexes.ndim != 2 or self.hexes.shape[1] != 8 or not len(self.hexes) or self.hexes.dtype.kind not in "iu":
            raise InputError(f"hexes need an array (m, 8) of integers, not {self.hexes.shape} of {self.hexes.dtype}")
        bad = np.flatnonzero(((self.hexes < 0) | (self.hexes >= len(self.nodes))).any(axis=1))
        if len(bad):
            raise InputError(f"hexes[{bad[0]}] names a node that is not there: indices run from 0 to {len(self.nodes) - 1}")
        self.parts, self.types = (np.full(n, a) if np.ndim(a) == 0 else np.asarray(a)
                                  for n, a in ((len(self.hexes), self.parts), (len(self.nodes), self.types)))
        if self.parts.shape != (len(self.hexes),) or self.types.shape != (len(self.nodes),):
            raise InputError("there must be one part for all elements or one of each, and the same of types and nodes")

    @property
    def centres(self):
        """(m, 3) m."""
        return self.nodes[self.hexes].mean(axis=1)

    def edge(self, part=None):
        """Median length (m) of the first edge of the elements, or of those of a part."""
        hexes = self.hexes if part is None else self.hexes[self.parts == part]
        if not len(hexes):
            raise InputError(f"there are no elements of part '{part}'; there are: {', '.join(np.unique(self.parts))}")
        return float(np.median(np.linalg.norm(self.nodes[hexes[:, 1]] - self.nodes[hexes[:, 0]], axis=1)))


def block(x, y, z, parts="glass", types=1):
    """A brick whose planes of nodes are at x (nx,), y (ny,), z (nz,), in m and rising: a Mesh of nx ny nz nodes, along x
    fastest, then y, then z; elements likewise."""
    lines = [np.asarray(line, float) for line in (x, y, z)]
    for axis, line in zip("xyz", lines):
        if line.ndim != 1 or len(line) < 2 or not (np.diff(line) > 0).all():
            raise InputError(f"{axis} needs two or more rising positions")
    n = [len(line) for line in lines]
    grid = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).transpose(2, 1, 0, 3).reshape(-1, 3)
    number = np.arange(len(grid)).reshape(n[::-1]).transpose(2, 1, 0)
    corners = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
    hexes = [number[a:n[0] - 1 + a, b:n[1] - 1 + b, c:n[2] - 1 + c].transpose(2, 1, 0).ravel() for a, b, c in corners]
    return Mesh(grid, np.stack(hexes, axis=1), parts, types)


def write_mesh(path, mesh, margin=0.0):
    """Writes a Mesh as a LAMMPS data file, whole or not at all. margin (m): by so much the box of the file is larger than
    the mesh.

    Raises InputError for what fix defe would refuse: elements that are inverted, flat or twice there, three at one face,
    nodes of no element, names with other characters than letters, digits and _; and for a file that cannot be written."""
    inner = read_meshes.Mesh()
    inner.points, inner.hexes = mesh.nodes, mesh.hexes.astype(np.int64)
    inner.node_ids = inner.node_names = np.arange(1, len(mesh.nodes) + 1)
    inner.hex_ids = inner.hex_names = np.arange(1, len(mesh.hexes) + 1)
    for part in np.unique(mesh.parts):
        if not re.fullmatch(r"\w+", str(part), re.ASCII):
            raise InputError(f"the part '{part}' cannot be named so: use letters, digits and _")
    if mesh.types.dtype.kind not in "iu" or mesh.types.min() < 1:
        raise InputError("atom types are integers from 1 on")
    if not (margin >= 0 and np.isfinite(margin)):
        raise InputError(f"the margin must be 0 or above, not {margin}")
    unused = np.setdiff1d(np.arange(len(mesh.nodes)), mesh.hexes)
    if len(unused):
        raise InputError(f"nodes[{unused[0]}] is of no element: leave it out")
    if max(len(mesh.nodes), len(mesh.hexes)) > LARGEST_ID:
        raise InputError(f"there are more nodes or elements than LAMMPS can number, {LARGEST_ID}")
    low, high = mesh.nodes.min(axis=0) - margin, mesh.nodes.max(axis=0) + margin
    try:
        checks.check_finite(inner)
        checks.check_hexes(inner, False)
        checks.check_faces(inner)
        write_all([(path, data_lines(
            "hexahedral mesh for fix defe, written by DEFE's Python package", (len(mesh.nodes), mesh.types.max(), len(mesh.hexes)),
            [(repr(a), repr(b)) for a, b in zip(low.tolist(), high.tolist())],
            ((k, t, f"{x[0]!r} {x[1]!r} {x[2]!r}") for k, (t, x) in enumerate(zip(mesh.types.tolist(), mesh.nodes.tolist()), 1)),
            ((k, p, n) for k, (p, n) in enumerate(zip(mesh.parts.tolist(), (mesh.hexes + 1).tolist()), 1)))) ])
    except Refused as why:
        raise InputError(str(why).replace("; --fix-orientation renumbers their nodes", "; exchange their lower and upper four nodes")
                         ) from None


def read_mesh(path):
    """A data file with the section Hexes as a Mesh, in the order of the file.

    Raises InputError: no such file, no atoms or hexes in it, a line that is damaged, a node that is not there."""
    section, nodes, hexes, numbers = "", [], [], {}
    for number, line in enumerate(text_of(path).splitlines(), 1):
        words = line.split("#")[0].split()
        if not words or number == 1:
            continue
        if words[0][0].isalpha():
            section, style = words[0], line.partition("#")[2].strip()
            if section == "Atoms" and style not in ("", "sphere"):
                raise InputError(at(path, number) + f"atoms of style {style}: only those of atom_style sphere are read")
            continue
        try:
            if section == "Atoms":
                numbers[int(words[0])] = len(nodes)
                nodes.append((int(words[1]), *map(float, words[4:7])))
                if len(nodes[-1]) != 4:
                    raise ValueError
            elif section == "Hexes":
                hexes.append((words[1], *(numbers[int(word)] for word in words[2:10])))
                if len(words) != 10:
                    raise ValueError
        except (ValueError, IndexError):
            raise InputError(at(path, number) + f"not a line of the section {section}: it is cut off or damaged; write the mesh "
                             "again") from None
        except KeyError as missing:
            raise InputError(at(path, number) + f"there is no node {missing}: the file is damaged; write the mesh again") from None
    if not nodes or not hexes:
        raise InputError(at(path) + "there are no sections Atoms and Hexes: tools/mesh2data, layers2data and write_mesh write them")
    return Mesh([n[1:] for n in nodes], np.array([h[1:] for h in hexes]), np.array([h[0] for h in hexes]),
                np.array([n[0] for n in nodes]))
