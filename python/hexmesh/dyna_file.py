"""Reads .k of LS-DYNA: *NODE, *ELEMENT_SOLID, *PART, sets of nodes, segments, solids and parts, *INCLUDE.

Parts are those of the elements, named by the titles of *PART. Read here since meshio does not know the format."""

import re

import numpy as np

from .cards import chosen, integer, nodes_of, real, set_hexes
from .mesh import Mesh
from .output import Refused, printable

# What makes, moves or counts nodes and elements in ways that are not read.
UNSUPPORTED = r"NODE_\w+|INCLUDE_\w+|ELEMENT_SOLID_\w+|ELEMENT_GENERATE\w*|INITIAL_FOAM_REFERENCE\w*"
SHAPES = {4: "tetra", 5: "pyramid", 6: "wedge", 8: "hexahedron"}  # by the number of different nodes


class Card:
    """A line of data, in fields of fixed width or separated by commas."""

    def __init__(self, keyword, line):
        self.keyword, self.line = keyword, line

    def fields(self, *widths):
        if "," in self.line:
            return [word.strip() for word in self.line.split(",")]
        found, at = [], 0
        for width in widths:
            found.append(self.line[at:at + width].strip())
            at += width
        if any(re.search(r"\s", word) for word in found):
            raise Refused(f"*{self.keyword}: '{printable(self.line, 80)}' is not in columns of {widths[0]}: separate the fields by commas")
        return found

    def integers(self, *widths):
        """Of the fields that are not blank at the end; blank ones before them are 0."""
        words = self.fields(*widths)
        while words and not words[-1]:
            words.pop()
        return [self.integer(word) for word in words]

    def integer(self, word):
        return integer(f"*{self.keyword}", word)

    def real(self, word):
        return real(f"*{self.keyword}", word)


class Deck:
    """The blocks of a file: (keyword, width of integers, cards), those of *INCLUDE in their place."""

    def __init__(self):
        self.files, self.long, self.wide = [], False, False

    def lines(self, path):
        if len(self.files) > 1000 or self.files.count(path) > 20:
            raise Refused("*INCLUDE files include each other")
        self.files.append(path)
        with open(path, encoding="utf-8", errors="replace") as file:
            lines = (line.rstrip() for line in file if not line.startswith("$"))
            for line in lines:
                if not re.match(r"\*INCLUDE\s*$", line, re.IGNORECASE):
                    yield line
                    continue
                name = next(lines, "").strip()
                while name.endswith(" +"):  # a long name goes on in the next line
                    name = name[:-2] + next(lines, "").strip()
                inner = path.parent / name
                if not name or not inner.is_file():
                    raise Refused(f"*INCLUDE: there is no file {printable(inner) if name else 'named'}")
                # *END ends the file that is included, not this one
                for text in self.lines(inner):
                    if text.upper() == "*END":
                        break
                    yield text

    def blocks(self, path):
        keyword, width, cards = "", 8, []
        for line in self.lines(path):
            if not line.startswith("*"):
                if not keyword and line.strip():
                    raise Refused(f"'{printable(line, 80)}' stands before the first keyword")
                cards.append(Card(keyword, line))
                continue
            if keyword:
                yield keyword, width, cards
            words = line[1:].upper().split() or [""]
            keyword, cards = words[0].rstrip("%+-"), []
            if keyword == "END":
                return
            if keyword == "KEYWORD":
                self.long, self.wide = "LONG=Y" in line.upper(), "I10=Y" in line.upper()
            mark = line.rstrip()[-1]
            width = 20 if mark == "+" or self.long and mark != "-" else 10 if mark == "%" or self.wide and mark != "-" else 8
        if keyword:
            yield keyword, width, cards


class Reader:
    def __init__(self):
        self.nodes, self.elements = {}, []  # ID -> place; (ID, part, nodes)
        self.titles, self.sets = {}, []  # part -> name; (what, name, members)
        self.left, self.notes = {}, []  # keyword -> number of cards

    def read(self, deck, path):
        for keyword, width, cards in deck.blocks(path):
            if re.fullmatch(UNSUPPORTED, keyword):
                raise Refused(f"*{printable(keyword)} is not supported: write all nodes and 8-node solids out")
            if keyword == "NODE":
                self.read_nodes(cards, width)
            elif keyword == "ELEMENT_SOLID":
                self.read_solids(cards, width)
            elif keyword.startswith("ELEMENT_"):
                self.left[keyword] = self.left.get(keyword, 0) + len(cards)
            elif keyword == "PART" or keyword.startswith("PART_"):
                self.read_parts(cards if keyword == "PART" else cards[:2], max(width, 10))
            elif re.match(r"SET_(NODE|SEGMENT|SOLID|PART)(_|$)", keyword):
                self.read_set(keyword, cards, max(width, 10))

    def read_nodes(self, cards, width):
        for card in cards:
            if not card.line.strip():
                continue
            words = card.fields(width, *3 * [max(width, 16)])
            node, x = card.integer(words[0]), [card.real(word) for word in (words[1:4] + 3 * [""])[:3]]
            if self.nodes.setdefault(node, x) != x:
                raise Refused(f"node {node} is defined twice, at different places")

    def read_solids(self, cards, width):
        cards = [card for card in cards if card.line.strip()]
        while cards:
            card = cards.pop(0)
            row = card.integers(*10 * [width])
            if len(row) == 2:  # nodes, up to ten of them, in a line of their own
                if not cards:
                    raise Refused(f"element {row[0]}: the line of its nodes is missing")
                row += cards.pop(0).integers(*10 * [width])
            if len(row) < 6:
                raise Refused(f"*{card.keyword}: '{printable(card.line, 80)}' has no part and eight nodes")
            self.elements.append((row[0], row[1], row[2:]))

    def read_parts(self, cards, width):
        for title, card in zip(cards[::2], cards[1::2]):
            self.titles[card.integer(card.fields(width)[0])] = title.line.strip()

    def read_set(self, keyword, cards, width):
        words = keyword.split("_")
        options = [word for word in words[2:] if word not in ("LIST", "TITLE")]
        what, name = words[1], cards.pop(0).line.strip() if "TITLE" in words and cards else ""
        if not cards:
            raise Refused(f"*{keyword}: it has no number")
        name = name or f"{what.lower()}_set_{cards[0].integer(cards[0].fields(width)[0])}"
        if options not in ([], ["GENERATE"]):
            self.notes.append(f"the set '{printable(name)}' is left out: *{printable(keyword)} is not read, write *SET_{what}_LIST")
            return
        members = []
        for card in cards[1:]:
            row = card.integers(*(4 if what == "SEGMENT" else 8) * [width])
            if options and len(row) % 2:
                raise Refused(f"*{keyword}: ranges need first and last, not '{printable(card.line, 80)}'")
            members += [range(a, b + 1) for a, b in zip(row[::2], row[1::2]) if a] if options else \
                [k for k in row[:4 if what == "SEGMENT" else 8] if k]
        self.sets.append((what, name, members))


def shape_of(nodes):
    if len([node for node in nodes if node]) > 8:
        return "tetra10"
    return SHAPES.get(len({node for node in nodes[:8] if node}), "degenerate solid")


def read(path):
    reader, deck, mesh = Reader(), Deck(), Mesh()
    reader.read(deck, path)
    mesh.files += deck.files
    mesh.node_ids = np.array(list(reader.nodes), np.int64)
    mesh.points = np.array(list(reader.nodes.values()), float).reshape(-1, 3)
    index = {node: k for k, node in enumerate(reader.nodes)}
    hexes, ids, parts, solids = [], [], {}, {}
    for element, part, nodes in reader.elements:
        shape = shape_of(nodes)
        if shape != "hexahedron":
            mesh.others.setdefault(shape, []).append(element)
            solids[element] = None
            continue
        solids[element] = len(hexes)
        parts.setdefault(part, []).append(len(hexes))
        hexes.append(nodes_of(element, nodes[:8], index))
        ids.append(element)
    set_hexes(mesh, hexes, ids, parts, reader.titles)
    read_sets(mesh, reader, index, solids, parts)
    mesh.notes += reader.notes
    mesh.notes += [f"*{printable(keyword)} is left out, {count} lines" for keyword, count in reader.left.items()]
    return mesh


def read_sets(mesh, reader, index, solids, parts):
    for what, name, members in reader.sets:
        about = f"the set '{printable(name)}'"
        if name in mesh.node_sets or name in mesh.volume_sets:
            raise Refused(f"{about} has the name of another set or part: give it another title")
        if what in ("NODE", "SEGMENT"):
            mesh.node_sets[name] = chosen(members, index, about, "node")
            continue
        if what == "SOLID":
            there = {element: k for element, k in solids.items() if k is not None}
            known = [k for k in members if isinstance(k, range) or solids.get(k, 0) is not None]  # not those that are left out
            found = chosen(known, there, about, "element")
        else:
            known = [k for part, elements in parts.items() if any(part == m or isinstance(m, range) and part in m for m in members)
                     for k in elements]
            found = np.unique(np.array(known, np.int64))
        if len(found):
            mesh.volume_sets[name] = found
        else:
            mesh.notes.append(f"{about} holds no hexahedra, and is left out")
