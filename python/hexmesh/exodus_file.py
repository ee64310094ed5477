"""Reads Exodus II (.exo, .e, .g, .ex2) by netCDF4: element blocks are parts, node sets and the nodes of side sets are sets."""

import numpy as np

from .mesh import Mesh
from .output import Refused

# nodes of the sides of a HEX, in the order of the format
SIDES = np.array([[0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [0, 4, 7, 3], [0, 3, 2, 1], [4, 5, 6, 7]])
MORE_NODES = {20: "hexahedron20", 27: "hexahedron27"}


class File:
    """What is asked of the variables of a file; those that are not there are empty."""

    def __init__(self, data):
        self.data = data

    def has(self, name):
        return name in self.data.variables

    def array(self, name, kind=np.int64):
        return np.asarray(self.data.variables[name][:], kind) if self.has(name) else np.zeros(0, kind)

    def count(self, dimension):
        return len(self.data.dimensions[dimension]) if dimension in self.data.dimensions else 0

    def names(self, what, word, count):
        """Of blocks or sets: as given, else by their number."""
        given = [b"".join(row).split(b"\0")[0].decode("utf-8", "replace").strip() for row in self.data.variables[what + "_names"][:]] \
            if self.has(what + "_names") else []
        numbers = self.array(what + "_prop1")
        names = []
        for k in range(count):
            number = numbers[k] if k < len(numbers) else k + 1
            name = given[k] if k < len(given) and given[k] else f"{word}_{number}"
            names.append(name if name not in names else f"{name}_{number}")
        return names

    def points(self):
        if self.has("coord"):
            return self.array("coord", float).T
        axes = [self.array("coord" + axis, float) for axis in "xyz" if self.has("coord" + axis)]
        return np.stack(axes, axis=1) if axes else np.zeros((0, 0))


def read(path):
    try:
        import netCDF4
    except ImportError:
        raise Refused("files of Exodus need netCDF4: tools/install-deps.sh meshes, or python3-netcdf4 of Debian") from None
    try:
        data = netCDF4.Dataset(str(path))
    except OSError:
        raise Refused("netCDF4 cannot read it, is it broken, or no file of Exodus II?") from None
    with data:
        data.set_auto_mask(False)
        file = File(data)
        mesh = Mesh()
        mesh.files.append(path)
        mesh.points = file.points()
        if mesh.points.ndim != 2 or mesh.points.shape[1] != 3:
            raise Refused("there are no coordinates in three dimensions: is it a file of Exodus II?")
        mesh.node_ids = file.array("node_num_map") if file.has("node_num_map") else np.arange(1, len(mesh.points) + 1)
        # of each element of the file its index among the hexahedra, or -1
        index = read_blocks(file, mesh)
        read_sets(file, mesh, index)
    return mesh


def checked(nodes, mesh, what):
    if len(nodes) and (nodes.min() < 0 or nodes.max() >= len(mesh.points)):
        raise Refused(f"cannot be read, is it broken? ({what} names a node that is not there)")
    return nodes


def read_blocks(file, mesh):
    count = file.count("num_el_blk")
    connect = [file.array(f"connect{k + 1}") for k in range(count)]
    total = sum(map(len, connect))
    ids = next((file.array(name) for name in ("elem_num_map", "elem_map") if file.has(name)), np.arange(1, total + 1))
    if len(ids) != total:
        raise Refused("cannot be read, is it broken? (the numbers of elements do not fit the blocks)")
    mesh.parts = []
    hexes, hex_ids, index, first = [], [], [], 0
    for k, name in enumerate(file.names("eb", "block", count)):
        mine = ids[first:first + len(connect[k])]
        first += len(connect[k])
        if not len(mine):
            continue
        kind = str(getattr(file.data.variables[f"connect{k + 1}"], "elem_type", "")).strip("\0 ").lower()
        width = connect[k].shape[1] if connect[k].ndim == 2 else 1
        if kind.startswith("hex") and width == 8:
            before = sum(map(len, hexes))
            index.append(np.arange(before, before + len(mine)))
            hexes.append(checked(connect[k] - 1, mesh, f"block {name}"))
            hex_ids.append(mine)
            mesh.parts.append(name)
            mesh.volume_sets[name] = index[-1]
        else:
            kind = MORE_NODES.get(width, kind) if kind.startswith("hex") else kind or f"with {width} nodes"
            mesh.others[kind] = mesh.others.get(kind, []) + mine.tolist()
            index.append(np.full(len(mine), -1))
    if hexes:
        mesh.hexes, mesh.hex_ids = np.concatenate(hexes), np.concatenate(hex_ids)
    return np.concatenate(index) if index else np.zeros(0, np.int64)


def read_sets(file, mesh, index):
    def add(name, nodes):
        if name in mesh.node_sets or name in mesh.volume_sets:
            raise Refused(f"the set '{name}' has the name of another set or part")
        mesh.node_sets[name] = np.unique(nodes)

    for k, name in enumerate(file.names("ns", "node_set", file.count("num_node_sets"))):
        add(name, checked(file.array(f"node_ns{k + 1}") - 1, mesh, f"node set {name}"))
    for k, name in enumerate(file.names("ss", "side_set", file.count("num_side_sets"))):
        elements, sides = file.array(f"elem_ss{k + 1}") - 1, file.array(f"side_ss{k + 1}") - 1
        if len(elements) != len(sides) or len(elements) and (elements.min() < 0 or elements.max() >= len(index)):
            raise Refused(f"cannot be read, is it broken? (side set {name} names an element that is not there)")
        mine = index[elements] >= 0
        if len(sides[mine]) and (sides[mine].min() < 0 or sides[mine].max() > 5):
            raise Refused(f"cannot be read, is it broken? (side set {name} names a side that a hexahedron has not)")
        add(name, mesh.hexes[index[elements[mine]][:, None], SIDES[sides[mine]]])
        if not mine.all():
            mesh.notes.append(f"side set {name}: {np.count_nonzero(~mine)} sides of elements that are no hexahedra are left out")
