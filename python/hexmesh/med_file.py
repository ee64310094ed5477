"""Reads MED of Salome and Code_Aster (.med) by meshio and h5py: groups of volumes are parts, groups of faces, edges and nodes
are node sets."""

import contextlib
import io

import numpy as np

from .checks import jacobians
from .mesh import Mesh
from .output import Refused

# MED runs round the faces of a hexahedron the other way
ORDER = [0, 3, 2, 1, 4, 7, 6, 5]


def read(path):
    try:
        import h5py  # noqa: F401  meshio reads by it
        from meshio import med
    except ImportError as missing:
        raise Refused(f"files of MED need {missing.name}: tools/install-deps.sh meshes, or python3-{missing.name} of Debian") from None
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):  # meshio's warnings
        try:
            found = med.read(str(path))
        except MemoryError:
            raise
        except Exception as error:  # of many kinds, mostly without words
            raise Refused("meshio cannot read it: one mesh of volumes, faces, edges and points without polyhedra can be read "
                          f"({type(error).__name__}: {str(error).strip() or 'no reason given'})") from None
    mesh = Mesh()
    mesh.files.append(path)
    mesh.points = np.asarray(found.points, float)
    if mesh.points.ndim != 2 or mesh.points.shape[1] != 3:
        raise Refused("its coordinates are not in three dimensions")
    mesh.node_ids = np.arange(1, len(mesh.points) + 1)
    families = found.cell_data.get("cell_tags", [None] * len(found.cells))
    first = 1
    for block, family in zip(found.cells, families):
        nodes = np.asarray(block.data, np.int64)
        numbers = np.arange(first, first + len(nodes))
        first += len(nodes)
        if len(nodes) and (nodes.min() < 0 or nodes.max() >= len(mesh.points)):
            raise Refused("cannot be read, is it broken? (an element names a node that is not there)")
        if block.type == "hexahedron":
            mesh.hexes, mesh.hex_ids = in_order(mesh, nodes), numbers
            for name, members in groups(found.cell_tags, family):
                mesh.volume_sets[name] = members
        elif block.type.startswith(("vertex", "line", "triangle", "quad")):
            mesh.ignored[block.type] = mesh.ignored.get(block.type, 0) + len(nodes)
            for name, members in groups(found.cell_tags, family):
                mesh.node_sets[name] = np.union1d(mesh.node_sets.get(name, []), nodes[members].ravel()).astype(np.int64)
        else:
            mesh.others[block.type] = mesh.others.get(block.type, []) + numbers.tolist()
    for name, members in groups(found.point_tags, found.point_data.get("point_tags")):
        mesh.node_sets[name] = np.union1d(mesh.node_sets.get(name, []), members).astype(np.int64)
    return mesh


def in_order(mesh, nodes):
    """Of programs that write VTK's order into MED all elements would be inside out."""
    if len(nodes) and (jacobians(mesh.points[nodes], np.zeros(3))[0] > 0).all():
        mesh.notes.append("its hexahedra are numbered as those of VTK, not of MED: taken as such")
        return nodes
    return nodes[:, ORDER]


def groups(names_of_families, families):
    """Names and members: a family is what is in the same groups."""
    members = {}
    if families is not None:
        for family, names in names_of_families.items():
            mine = np.flatnonzero(np.asarray(families) == family)
            for name in names if len(mine) else ():
                members.setdefault(name, []).append(mine)
    return [(name, np.unique(np.concatenate(several))) for name, several in members.items()]
