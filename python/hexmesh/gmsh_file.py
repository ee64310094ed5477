"""Reads .msh of Gmsh, formats 2 and 4.1, text and binary.

Read here since meshio keeps no IDs and reads neither parametric nodes nor partitioned meshes nor, in format 4,
elements in no group; and Gmsh's own module knows groups by geometric entity only, so that in format 2, where
every element has its own group, an element comes into the groups of its neighbours."""

import re
import struct

import numpy as np

from .mesh import Mesh, which_elements
from .output import Refused, printable

DIMENSION_NAMES = ["point", "curve", "surface", "volume"]
# Gmsh's number of the type -> (name, dimension, number of nodes); names as in meshio.
TYPES = {
    1: ("line", 1, 2), 2: ("triangle", 2, 3), 3: ("quad", 2, 4), 4: ("tetra", 3, 4), 5: ("hexahedron", 3, 8),
    6: ("wedge", 3, 6), 7: ("pyramid", 3, 5), 8: ("line3", 1, 3), 9: ("triangle6", 2, 6), 10: ("quad9", 2, 9),
    11: ("tetra10", 3, 10), 12: ("hexahedron27", 3, 27), 13: ("wedge18", 3, 18), 14: ("pyramid14", 3, 14),
    15: ("vertex", 0, 1), 16: ("quad8", 2, 8), 17: ("hexahedron20", 3, 20), 18: ("wedge15", 3, 15),
    19: ("pyramid13", 3, 13), 20: ("triangle9", 2, 9), 21: ("triangle10", 2, 10), 22: ("triangle12", 2, 12),
    23: ("triangle15", 2, 15), 24: ("triangle15", 2, 15), 25: ("triangle21", 2, 21), 26: ("line4", 1, 4),
    27: ("line5", 1, 5), 28: ("line6", 1, 6), 29: ("tetra20", 3, 20), 30: ("tetra35", 3, 35), 31: ("tetra56", 3, 56),
    36: ("quad16", 2, 16), 37: ("quad25", 2, 25), 92: ("hexahedron64", 3, 64), 93: ("hexahedron125", 3, 125),
}


def broken(section, why):
    return Refused(f"cannot be read, is it broken? (${section}: {why})")


def element_type(number):
    if number not in TYPES:
        raise Refused(f"elements of Gmsh's type {number} are not known; needed are 8-node hexahedra")
    return TYPES[number]


def to_integers(section, words):
    try:
        return np.array([int(word) for word in words], dtype=np.int64)
    except (ValueError, OverflowError):
        bad = next((word for word in words if not re.fullmatch(rb"[-+]?\d{1,18}", word)), words[0])
        raise broken(section, f"'{printable(bad.decode(errors='replace'), 40)}' is no integer") from None


def to_reals(section, words):
    try:
        return np.array([float(word) for word in words])
    except ValueError:
        raise broken(section, "a coordinate is no number") from None


class Text:
    """Numbers of a section, one after the other."""

    def __init__(self, section, data):
        self.section, self.words, self.at = section, data.split(), 0

    def take(self, count):
        if count < 0 or self.at + count > len(self.words):
            raise broken(self.section, "numbers are missing")
        self.at += count
        return self.words[self.at - count:self.at]

    def integers(self, count=1):
        return to_integers(self.section, self.take(count))

    sizes = integers

    def reals(self, count):
        return to_reals(self.section, self.take(count))

    def end(self):
        if self.at != len(self.words):
            raise broken(self.section, f"there are {len(self.words) - self.at} numbers more than it says")


class Binary:
    """The same of a binary section, which begins at an offset of the file."""

    def __init__(self, section, data, at, order, size):
        self.section, self.data, self.at, self.order, self.size = section, data, at, order, size

    def take(self, kind, count):
        kind = np.dtype(kind).newbyteorder(self.order)
        if count < 0 or self.at + count * kind.itemsize > len(self.data):
            raise broken(self.section, "the file ends within it")
        values = np.frombuffer(self.data, kind, count, self.at)
        self.at += values.nbytes
        return values

    def integers(self, count=1):
        return self.take("i4", count).astype(np.int64)

    def sizes(self, count=1):
        values = self.take(f"u{self.size}", count)
        if count and values.max() > 2**62:
            raise broken(self.section, f"a number of {values.max()}")
        return values.astype(np.int64)

    def reals(self, count):
        return self.take("f8", count).astype(float)

    def end(self):
        pass  # what follows is checked to be the mark of the end


class Source:
    """The sections of a file."""

    def __init__(self, data):
        self.data, self.sections = data, {}
        head = re.match(rb"\s*(?:\$Comments\b.*?\$EndComments\s*)?\$MeshFormat[ \t]*\r?\n"
                        rb"[ \t]*(\S+)[ \t]+([01])[ \t]+(\d)[ \t]*\r?\n", data, re.DOTALL)
        if not head:
            raise broken("MeshFormat", "no version, type and size of numbers")
        version = head[1].decode(errors="replace")
        self.old = version in ("2", "2.0", "2.1", "2.2")
        if not self.old and version != "4.1":
            raise Refused(f"format {printable(version, 20)} is not supported: "
                          "write it with Mesh.MshFileVersion = 4.1 or 2.2")
        self.binary, self.size = head[2] == b"1", int(head[3])
        at, self.order = head.end(), "="
        if self.binary:
            mark = data[at:at + 4]
            self.order = "<" if mark == struct.pack("<i", 1) else ">"
            if self.order == ">" and mark != struct.pack(">i", 1) or self.size not in (4, 8):
                raise broken("MeshFormat", "the byte order or the size of numbers is not known")
            at += 4
        self.end_of("MeshFormat", at)

    def end_of(self, section, at):
        end = re.compile(rb"\s*\$End" + section.encode() + rb"\b").match(self.data, at)
        if not end:
            raise broken(section, f"no $End{section} where it should end")
        self.at = end.end()

    def __iter__(self):
        """(name, numbers); whoever does not read a section to its end calls skip()."""
        while True:
            head = re.compile(rb"\s*\$(\w+)[ \t]*\r?\n?").match(self.data, self.at)
            if not head:
                if self.data[self.at:].strip():
                    raise broken("End", "there is something between the sections")
                return
            self.name = head[1].decode(errors="replace")
            self.start = head.end()
            yield self.name

    def text(self):
        end = self.data.find(b"$End" + self.name.encode(), self.start)
        if end < 0:
            raise broken(self.name, f"no $End{self.name}")
        return self.data[self.start:end], end

    def skip(self):
        self.end_of(self.name, self.text()[1])

    def numbers(self):
        if self.binary:
            self.reader = Binary(self.name, self.data, self.start, self.order, self.size)
        else:
            text, self.stop = self.text()
            self.reader = Text(self.name, text)
        return self.reader

    def line(self):
        """The count at the begin of a section of format 2, which is text in binary files too."""
        if not self.binary:
            return int(self.reader.integers()[0])
        head = re.compile(rb"[ \t]*(\d{1,18})[ \t]*\r?\n").match(self.data, self.start)
        if not head:
            raise broken(self.name, "no count")
        self.reader.at = head.end()
        return int(head[1])

    def done(self):
        self.reader.end()
        self.end_of(self.name, self.reader.at if self.binary else self.stop)


class Blocks:
    """Nodes, and elements in blocks of (type, IDs, IDs of nodes, groups, entities)."""

    def __init__(self):
        self.ids, self.points, self.elements = [], [], []
        self.entities = {}  # (dimension, tag) -> groups

    def add(self, kind, ids, nodes, groups, entities):
        self.elements.append((kind, ids, nodes, groups, entities))


def physical_names(text):
    """(dimension, number) -> name"""
    names, numbers = {}, {}
    count, *lines = text.decode(errors="replace").strip().splitlines() or [""]
    if count.strip() != str(sum(1 for line in lines if line.strip())):
        raise broken("PhysicalNames", "there are more or less names than it says")
    for line in lines:
        match = re.match(r'\s*([0-3])\s+(\d{1,9})\s+"(.*)"', line)
        if not match:
            if line.strip():
                raise broken("PhysicalNames", f"'{printable(line, 40)}' is no name of a group")
            continue
        key, name = (int(match[1]), int(match[2])), match[3]
        if not name:
            continue
        if name in numbers:
            raise Refused(f"the name '{printable(name)}' is given to a physical {DIMENSION_NAMES[numbers[name][0]]} "
                          f"and to a physical {DIMENSION_NAMES[key[0]]}: give them different names")
        if key in names:
            raise Refused(f"physical {DIMENSION_NAMES[key[0]]} {key[1]} has two names, "
                          f"'{printable(names[key])}' and '{printable(name)}'")
        names[key], numbers[name] = name, key
    return names


# --- format 2 --------------------------------------------------------------------------------------


def old_nodes(source, blocks):
    """$Nodes, and $ParametricNodes: with the place of each on its geometric entity."""
    reader = source.numbers()
    count = source.line()
    if source.name == "Nodes" and source.binary:
        table = reader.take([("id", "i4"), ("x", "f8", 3)], count)
        blocks.ids.append(table["id"].astype(np.int64))
        blocks.points.append(table["x"].astype(float))
    elif source.name == "Nodes":
        words = reader.take(4 * count)
        blocks.ids.append(to_integers(source.name, words[::4]))
        blocks.points.append(np.stack([to_reals(source.name, words[k::4]) for k in (1, 2, 3)], axis=1))
    else:
        ids, points = [], []
        for _ in range(count):
            ids.append(int(reader.integers()[0]))
            points.append(reader.reals(3))
            dimension = int(reader.integers(2)[0])
            reader.reals({1: 1, 2: 2}.get(dimension, 0))
        blocks.ids.append(np.array(ids, dtype=np.int64))
        blocks.points.append(np.array(points).reshape(-1, 3))
    source.done()


def old_elements(source, blocks):
    reader = source.numbers()
    count = source.line()
    if source.binary:
        while count > 0:
            number, n, tags = (int(value) for value in reader.integers(3))
            kind = element_type(number)
            if not 0 < n <= count or not 0 <= tags <= 1000:
                raise broken(source.name, f"a block of {n} elements with {tags} tags")
            rows = reader.integers(n * (1 + tags + kind[2])).reshape(n, -1)
            count -= n
            blocks.add(kind, rows[:, 0], rows[:, 1 + tags:], rows[:, 1] if tags > 0 else np.zeros(n, np.int64),
                       rows[:, 2] if tags > 1 else np.zeros(n, np.int64))
        source.done()
        return
    rows, last = [], None

    def flush():
        if rows:
            table = np.array(rows, dtype=np.int64)
            blocks.add(element_type(last), table[:, 0], table[:, 3:], table[:, 1], table[:, 2])
            rows.clear()

    values, at = reader.integers(len(reader.words) - reader.at).tolist(), 0
    for _ in range(count):
        if at + 3 > len(values):
            raise broken(source.name, "numbers are missing")
        number, tags = values[at + 1:at + 3]
        if number != last:
            flush()
            last = number
        size = 3 + tags + element_type(number)[2]
        if tags < 0 or at + size > len(values):
            raise broken(source.name, "numbers are missing")
        rows.append([values[at], values[at + 3] if tags > 0 else 0, values[at + 4] if tags > 1 else 0,
                     *values[at + 3 + tags:at + size]])
        at += size
    flush()
    if at != len(values):
        raise broken(source.name, f"there are {len(values) - at} numbers more than it says")
    source.done()


# --- format 4.1 ------------------------------------------------------------------------------------


def new_entities(source, blocks):
    """$Entities, and $PartitionedEntities: the groups of each."""
    reader = source.numbers()
    partitioned = source.name == "PartitionedEntities"
    if partitioned:
        reader.sizes()
        reader.integers(2 * int(reader.sizes()[0]))  # entities of ghosts
    for dimension, count in enumerate(reader.sizes(4).tolist()):
        for _ in range(count):
            tag = int(reader.integers()[0])
            parent = dimension
            if partitioned:
                parent = int(reader.integers(2)[0])  # the entity that was divided
                reader.integers(int(reader.sizes()[0]))
            reader.reals(6 if dimension else 3)
            groups = reader.integers(int(reader.sizes()[0]))
            if parent != dimension:  # between two partitions: these are groups of the parent, which has the nodes too
                groups = groups[:0]
            blocks.entities[dimension, tag] = np.unique(abs(groups)).tolist()
            if dimension:
                reader.integers(int(reader.sizes()[0]))
    source.done()


def new_nodes(source, blocks):
    reader = source.numbers()
    count, total = reader.sizes(4)[:2].tolist()
    for _ in range(count):
        dimension, _, parametric = reader.integers(3).tolist()
        n = int(reader.sizes()[0])
        ids = reader.sizes(n)
        width = 3 + (dimension if parametric else 0)
        if not 0 <= dimension <= 3:
            raise broken(source.name, f"an entity of dimension {dimension}")
        blocks.ids.append(ids)
        blocks.points.append(reader.reals(n * width).reshape(n, width)[:, :3])
    if sum(map(len, blocks.ids)) != total:
        raise broken(source.name, f"there are {sum(map(len, blocks.ids))} nodes, not {total}")
    source.done()


def new_elements(source, blocks):
    reader = source.numbers()
    count, total = reader.sizes(4)[:2].tolist()
    for _ in range(count):
        dimension, tag, number = reader.integers(3).tolist()
        kind = element_type(number)
        n = int(reader.sizes()[0])
        rows = reader.sizes(n * (1 + kind[2])).reshape(n, 1 + kind[2])
        total -= n
        blocks.add(kind, rows[:, 0], rows[:, 1:], None, (dimension, tag))
    if total:
        raise broken(source.name, f"it says {abs(total)} elements {'more' if total > 0 else 'less'} than there are")
    source.done()


SECTIONS = {True: {"Nodes": old_nodes, "ParametricNodes": old_nodes, "Elements": old_elements},
            False: {"Entities": new_entities, "PartitionedEntities": new_entities, "Nodes": new_nodes,
                    "Elements": new_elements}}


# --- both ------------------------------------------------------------------------------------------


def unite_doubles(ids, nodes, groups, entities):
    """Format 2 writes an element once for each of its groups, with other IDs: the first of such elements and its
    groups as (group, elements). One that is twice in a group stays twice, to be refused."""
    first, which, place = [], np.zeros(len(ids), dtype=np.int64), {}
    for k, (group, entity, row) in enumerate(zip(groups.tolist(), entities.tolist(), nodes.tolist())):
        key = (entity, *row)
        at, seen = place.get(key, (None, ()))
        if at is None or group in seen or 0 in seen or not group:
            at, seen = len(first), set()
            first.append(k)
            place[key] = at, seen
        seen.add(group)
        which[k] = at
    members = {group: np.unique(which[groups == group]) for group in np.unique(groups).tolist() if group}
    return ids[first], nodes[first], members


def read(path):
    data = path.read_bytes()
    if not re.match(rb"\s*\$(MeshFormat|Comments)", data):
        raise Refused("no file of Gmsh: it does not begin with $MeshFormat")
    source, blocks, names = Source(data), Blocks(), {}
    for section in source:
        if section == "PhysicalNames":
            names = physical_names(source.text()[0])
            source.skip()
        elif section in SECTIONS[source.old]:
            SECTIONS[source.old][section](source, blocks)
        else:
            source.skip()
    mesh = Mesh()
    mesh.files.append(path)
    if blocks.ids:
        mesh.node_ids, mesh.points = np.concatenate(blocks.ids), np.concatenate(blocks.points)
    order = np.argsort(mesh.node_ids, kind="stable")
    ordered = mesh.node_ids[order]

    # of one type: the groups of one element are sought over all blocks
    by_kind = {}
    for kind, ids, nodes, groups, entities in blocks.elements:
        by_kind.setdefault(kind, []).append((ids, nodes, groups, entities))
    found = {}  # (dimension, group) -> indices of hexes, or nodes
    for kind, several in by_kind.items():
        name, dimension, _ = kind
        ids, nodes = (np.concatenate([block[k] for block in several]) for k in (0, 1))
        if source.old:
            groups, entities = (np.concatenate([abs(block[k]) for block in several]) for k in (2, 3))
            ids, nodes, members = unite_doubles(ids, nodes, groups, entities)
        else:
            members, first = {}, 0
            for block in several:
                for group in blocks.entities.get(block[3], []):
                    members.setdefault(group, []).append(np.arange(first, first + len(block[0])))
                first += len(block[0])
            members = {group: np.concatenate(cells) for group, cells in members.items()}
        if dimension == 3 and name != "hexahedron":
            mesh.others[name] = mesh.others.get(name, []) + ids.tolist()
            continue
        at = np.searchsorted(ordered, nodes)
        at[at == len(ordered)] = 0
        there = ordered[at] == nodes if len(ordered) else np.zeros(nodes.shape, dtype=bool)
        if not there.all():
            raise Refused(f"nodes are missing of {which_elements(ids[~there.all(axis=1)])}")
        index = order[at]
        if dimension == 3:
            mesh.hexes, mesh.hex_ids = index, ids
            found.update({(3, group): cells for group, cells in members.items()})
        else:
            mesh.ignored[name] = mesh.ignored.get(name, 0) + len(ids)
            for group, cells in members.items():
                found[dimension, group] = np.union1d(found.get((dimension, group), []), index[cells]).astype(np.int64)
    # in the order of their numbers, those with a name first
    for key in sorted(found, key=lambda key: (key not in names, key)):
        name = names.get(key) or f"{DIMENSION_NAMES[key[0]]}_{key[1]}"
        if key not in names and name in names.values():
            raise Refused(f"physical {DIMENSION_NAMES[key[0]]} {key[1]} has no name, and another group is named {name}: "
                          "give it a name")
        (mesh.volume_sets if key[0] == 3 else mesh.node_sets)[name] = np.unique(found[key])
    return mesh
