"""Reads .bdf and .nas of Nastran: GRID, CHEXA, the nodes of SET1 and SPC1, INCLUDE; small, large and free fields.

Parts are the properties of the elements, with the names that HyperMesh and Femap write in comments. Read here since meshio
loses IDs, properties and sets."""

import re

import numpy as np

from .cards import chosen, integer, nodes_of, real, set_hexes
from .mesh import Mesh
from .output import Refused, printable

OTHERS = {"CTETRA": "tetra", "CPENTA": "wedge", "CPYRAM": "pyramid", "CPYRA": "pyramid"}
# What is not in the result: surfaces, lines, points, springs, rigid elements.
LEFT = r"C(QUAD|TRIA|SHEAR|BAR|BEAM|BUSH|ROD|ONROD|TUBE|ELAS|DAMP|GAP|FAST|WELD|VISC|ONM|MASS)\w*|RBE\d|RBAR|RROD"
NAMES = (r'\$HMNAME\s+PROP\s+(\d+)\s*"([^"]*)"', r"\$ Femap Property (\d+) : (.*)")


def fields_of(line):
    """Fields 2 to 9 of a line, and whether they are large; the first one is cut off."""
    if "," in line:
        words = [word.strip() for word in line.split(",")]
        return words[1:9] if "*" not in words[0] else words[1:5]
    wide = "*" in line[:8]
    size, count = (16, 4) if wide else (8, 8)
    line = line.expandtabs(8)
    return [line[8 + k * size:8 + (k + 1) * size].strip() for k in range(count)]


class Reader:
    def __init__(self):
        self.files, self.names = [], {}
        self.nodes, self.elements = {}, []  # ID -> place; (ID, property, nodes, card)
        self.sets, self.left = {}, {}  # name -> members; card -> number

    def lines(self, path):
        """Of the bulk data, without comments, those of INCLUDE in their place."""
        if len(self.files) > 1000 or self.files.count(path) > 20:
            raise Refused("INCLUDE files include each other")
        self.files.append(path)
        with open(path, encoding="utf-8", errors="replace") as file:
            lines = file.read().splitlines()
        begin = [k for k, line in enumerate(lines) if re.match(r"\s*BEGIN\s+BULK", line, re.IGNORECASE)]
        lines = iter(lines[begin[0] + 1 if begin else 0:])
        for line in lines:
            for pattern in NAMES:
                named = re.match(pattern, line)
                if named:
                    self.names.setdefault(int(named[1]), named[2].strip())
            line = line.split("$")[0].rstrip()
            if not line:
                continue
            if re.match(r"ENDDATA\b", line, re.IGNORECASE):
                return
            if not re.match(r"INCLUDE\b", line, re.IGNORECASE):
                yield line
                continue
            name = line[7:].strip()
            while name.count("'") == 1:  # a long name goes on in the next line
                name += next(lines, "'").strip()
            inner = path.parent / name.strip("'\" ")
            if not inner.is_file():
                raise Refused(f"INCLUDE: there is no file {printable(inner)}")
            yield from self.lines(inner)

    def cards(self, path):
        """(name, fields), continuation lines joined; at least eight fields."""
        name, fields = None, []
        for line in self.lines(path):
            first = line.split(",")[0] if "," in line else line[:8]
            if first.strip()[:1] in ("", "+", "*"):
                if name is None:
                    raise Refused(f"'{printable(line, 80)}' continues no card")
                fields += fields_of(line)
                continue
            if name:
                yield name, fields + 8 * [""]
            name, fields = first.strip().rstrip("*").upper(), fields_of(line)
        if name:
            yield name, fields + 8 * [""]

    def read(self, path):
        for name, fields in self.cards(path):
            if name == "GRID":
                self.read_node(fields)
            elif name == "GRDSET" and fields[1] not in ("", "0"):
                raise Refused("GRDSET: places in another coordinate system are not supported: write them in the basic one")
            elif name == "CHEXA" or name in OTHERS:
                element, part, *nodes = (integer(name, word) for word in fields)
                self.elements.append((element, part, [node for node in nodes if node], name))
            elif name in ("SET1", "SPC1"):
                first = 1 if name == "SET1" else 2
                key = f"{name[:3].lower()}_{integer(name, fields[0])}"
                self.sets.setdefault(key, []).extend(self.members(name, fields[first:]))
            elif re.fullmatch(LEFT, name):
                self.left[name] = self.left.get(name, 0) + 1

    def read_node(self, fields):
        node = integer("GRID", fields[0])
        if fields[1] not in ("", "0"):
            raise Refused(f"GRID {node} is in the coordinate system {printable(fields[1])}: write all places in the basic one")
        x = [real("GRID", word) for word in fields[2:5]]
        if self.nodes.setdefault(node, x) != x:
            raise Refused(f"node {node} is defined twice, at different places")

    def members(self, name, words):
        """IDs, and ranges of 'a THRU b', of which only those count that are there."""
        words, found = [word for word in words if word], []
        while words:
            if len(words) > 2 and words[1].upper() == "THRU":
                found.append(range(integer(name, words[0]), integer(name, words[2]) + 1))
                words = words[3:]
            else:
                found.append(integer(name, words.pop(0)))
        return found


def read(path):
    reader, mesh = Reader(), Mesh()
    reader.read(path)
    mesh.files += reader.files
    mesh.node_ids = np.array(list(reader.nodes), np.int64)
    mesh.points = np.array(list(reader.nodes.values()), float).reshape(-1, 3)
    index = {node: k for k, node in enumerate(reader.nodes)}
    hexes, ids, parts = [], [], {}
    for element, part, nodes, card in reader.elements:
        if card != "CHEXA" or len(nodes) != 8:
            shape = OTHERS.get(card, f"hexahedron{len(nodes)}")
            mesh.others.setdefault(shape, []).append(element)
            continue
        parts.setdefault(part or element, []).append(len(hexes))  # the property is the ID where it is blank
        hexes.append(nodes_of(element, nodes, index))
        ids.append(element)
    set_hexes(mesh, hexes, ids, parts, reader.names)
    for name, members in reader.sets.items():
        mesh.node_sets[name] = chosen(members, index, f"the set '{name}'", "node")
    mesh.notes += [f"{card} is left out, {count} elements" for card, count in reader.left.items()]
    return mesh
