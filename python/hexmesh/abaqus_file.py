"""Reads .inp of Abaqus: nodes, elements and sets, in parts and instances or without.

Read here, not by meshio: meshio loses the IDs of elements, replaces the nodes of one *NODE by those of the next,
ends a block at a comment, and attaches ELSET= of an *ELEMENT to another block when a block before it has none or
the same."""

import difflib
import math
import re

import numpy as np

from .mesh import Mesh, some, which_elements
from .output import Refused, printable

# These make or move nodes and elements.
UNSUPPORTED = {"NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SYSTEM", "SUBSTRUCTURE", "ELEMENT MATRIX", "IMPORT",
               "IMPERFECTION", "SYMMETRIC MODEL GENERATION", "PARAMETER"}
# What may stand on the keywords that are read; anything else could change what they mean.
PARAMETERS = {
    "NODE": {"NSET", "INPUT", "SYSTEM"}, "ELEMENT": {"TYPE", "ELSET", "INPUT"},
    "NSET": {"NSET", "ELSET", "GENERATE", "INSTANCE", "INTERNAL", "UNSORTED"},
    "ELSET": {"ELSET", "GENERATE", "INSTANCE", "INTERNAL", "UNSORTED"},
    "PART": {"NAME"}, "INSTANCE": {"NAME", "PART"}, "INCLUDE": {"INPUT"},
}

KNOWN = {*PARAMETERS, *UNSUPPORTED}


CARRIERS = ("surface", "line", "point")  # of these only nodes and sets count


def element_type(name, hexes_only):
    """(type as in meshio, number of nodes) of an Abaqus element type; with hexes_only also of one that is not known, (its
    name, None)."""
    name = name.upper()
    match = re.match(r"C3D(4|5|6|8|10|15|20|27)[A-Z]*$", name)
    if match:
        n = int(match[1])
        kind = {4: "tetra", 5: "pyramid", 6: "wedge", 8: "hexahedron"}.get(n)
        return kind or {10: "tetra10", 15: "wedge15"}.get(n, f"hexahedron{n}"), n
    # The dimension of surfaces and lines: only their nodes and sets count.
    for pattern, kind in ((r"(?:S|M3D|SFM3D|R3D|CPS|CPE|CPEG|CAX|CGAX|DS|DC2D|STRI)(3|4|6|8|9)", "surface"),
                          (r"STRI6(5)", "surface"),
                          (r"(?:T2D|T3D|R2D|CONN2D|CONN3D)([23])", "line"), (r"B[23]([123])", "line")):
        match = re.match(pattern + r"(?!\d)[A-Z0-9]*$", name)
        if match:
            n = int(match[1])
            if name.startswith("STRI65"):
                n = 6
            if name.startswith("B"):
                n = 3 if n == 2 else 2  # B31 and B33 have two nodes, B32 three
            return kind, n
    if re.match(r"(SPRING|DASHPOT)[A2]$|GAP(UNI|CYL|SPHER)$", name):
        return "line", 2
    if re.match(r"(MASS|ROTARYI)$|(SPRING|DASHPOT)1$", name):
        return "point", 1
    if hexes_only:
        return printable(name), None
    raise Refused(f"elements of type {printable(name)} are not known; needed is C3D8 or a variant of it "
                  "(--hexes-only leaves them out)")


# --- lines and blocks ------------------------------------------------------------------------------


class Lines:
    """The lines of a file without comments, those of its *INCLUDE in their place."""

    def __init__(self):
        self.files = []

    def input(self, path, name, keyword):
        inner = path.parent / name
        if not name or not inner.is_file():
            raise Refused(f"*{keyword}: there is no file {printable(inner) if name else 'named (INPUT=)'}")
        return inner

    def read(self, path, depth=0):
        if depth > 20 or len(self.files) > 1000:
            raise Refused("*INCLUDE files include each other")
        self.files.append(path)
        with open(path, encoding="utf-8", errors="replace") as file:
            kept = (line for line in map(str.strip, file) if line and not line.startswith("**"))
            for line in kept:
                if not re.match(r"\*\s*INCLUDE\s*(,|$)", line, re.IGNORECASE):
                    yield line
                    continue
                while line.endswith(","):  # the parameters go on in the next line
                    line += next(kept, " ")
                _, parameters = keyword_of(line)
                yield from self.read(self.input(path, parameters.get("INPUT", ""), "INCLUDE"), depth + 1)

    def blocks(self, path):
        """(keyword, parameters, lines of data), those of INPUT= before those in the file."""
        head, data = None, []
        lines = self.read(path)
        for line in lines:
            if not line.startswith("*"):
                if not head:
                    raise Refused(f"'{printable(line, 80)}' stands before the first keyword")
                data.append(line)
                continue
            if head:
                yield self.block(path, head, data)
            while line.endswith(","):
                line += next(lines, " ")
            head, data = line, []
        if head:
            yield self.block(path, head, data)

    def block(self, path, head, data):
        keyword, parameters = keyword_of(head)
        if keyword in ("NODE", "ELEMENT") and "INPUT" in parameters:
            more = list(self.read(self.input(path, parameters["INPUT"], keyword), 1))
            if any(line.startswith("*") for line in more):
                raise Refused(f"*{keyword}: the file {printable(parameters['INPUT'])} of INPUT= has keywords, "
                              "it should hold data only")
            data = more + data
        return keyword, parameters, data


def keyword_of(line):
    """The keyword and its parameters; commas and = in quotes are no separators."""
    words = [word.strip() for word in re.findall(r'(?:"[^"]*"|[^,])+', line)]
    keyword = " ".join(words[0][1:].split()).upper()
    parameters = {}
    for word in words[1:]:
        key, _, value = word.partition("=")
        key = " ".join(key.split()).upper()
        if not key:
            continue
        if key in parameters and keyword in PARAMETERS:
            raise Refused(f"*{printable(keyword)}: {printable(key)} is given twice")
        parameters[key] = value.strip().strip('"')
    near = difflib.get_close_matches(keyword, PARAMETERS, 1, 0.85)
    if near and keyword not in KNOWN:  # its data would be missing
        raise Refused(f"*{printable(keyword)} is not known: is *{near[0]} meant?")
    unknown = set(parameters) - PARAMETERS.get(keyword, set(parameters))
    if unknown:
        raise Refused(f"*{keyword}: the parameter {printable(sorted(unknown)[0])} is not supported")
    return keyword, parameters


# --- what a file says, before names are looked up ----------------------------------------------------


class Scope:
    """What is numbered and named on its own: a part, an instance, or the file."""

    def __init__(self, name):
        self.name = name
        self.nodes, self.elements = {}, {}  # ID -> coordinates; ID -> (type, nodes)
        self.sets = {"node": {}, "element": {}}  # NAME -> list of members: see Reader.members
        self.title, self.internal, self.sections = {}, set(), []

    def key(self, name):  # names are the same in upper and lower case
        self.title.setdefault(name.upper(), name)
        return name.upper()

    def add(self, what, name, members):
        self.sets[what].setdefault(self.key(name), []).extend(members)


class Instance(Scope):
    def __init__(self, name, part):
        super().__init__(name)
        self.part, self.shift, self.turn = part, None, None


class Reader:
    def __init__(self, hexes_only):
        self.hexes_only = hexes_only
        self.file = Scope("")
        self.parts, self.instances = {}, {}
        self.scope = self.file

    def number(self, word, kind=int):
        try:
            value = kind(word)
            if "_" in word or kind is int and abs(value) > 2**62:
                raise ValueError
            return value
        except ValueError:
            raise Refused(f"*{self.keyword}: '{printable(word, 40)}' is not a number") from None

    def open(self, scopes, scope):
        if not scope.name or scope.name.upper() in scopes:
            raise Refused(f"*{self.keyword}: "
                          + (f"the name {printable(scope.name)} is there twice" if scope.name else "no NAME"))
        if self.scope is not self.file:
            raise Refused(f"*{self.keyword} {printable(scope.name)} begins before {printable(self.scope.name)} ends")
        scopes[scope.name.upper()] = self.scope = scope

    def read(self, lines, path):
        for self.keyword, parameters, data in lines.blocks(path):
            if self.keyword in UNSUPPORTED:
                raise Refused(f"*{self.keyword} is not supported: write all nodes and elements out")
            act = self.KEYWORDS.get(self.keyword)
            if act:
                act(self, parameters, data)
        if self.scope is not self.file:
            raise Refused(f"{printable(self.scope.name)} does not end: there is no *END PART or *END INSTANCE")

    def read_part(self, parameters, data):
        self.open(self.parts, Scope(parameters.get("NAME", "")))

    def read_instance(self, parameters, data):
        part = self.parts.get(parameters.get("PART", "").upper())
        if part is None:
            raise Refused(f"*INSTANCE: there is no part '{printable(parameters.get('PART', ''))}' before it")
        instance = Instance(parameters.get("NAME", ""), part)
        rows = [[self.number(word, float) if word.strip() else 0.0 for word in line.rstrip(",").split(",")] for line in data]
        if len(rows) > 2 or rows and len(rows[0]) > 3 or len(rows) > 1 and len(rows[1]) != 7:
            raise Refused("*INSTANCE: its lines are a translation of three numbers and a rotation of seven")
        if rows and any(rows[0]):
            instance.shift = rows[0] + [0.0] * (3 - len(rows[0]))
        if len(rows) > 1 and rows[1][6]:
            instance.turn = rows[1]
        self.open(self.instances, instance)

    def read_end_part(self, parameters, data):
        self.scope = self.file

    def read_node(self, parameters, data):
        if parameters.get("SYSTEM", "R").upper() != "R":
            raise Refused("*NODE: only rectangular coordinates are supported")
        ids, nodes = [], self.scope.nodes
        for line in data:
            words = [word.strip() for word in line.split(",")]
            if len(words) > 7 and any(words[7:]):
                raise Refused(f"*NODE: more than a node's ID, place and normal in '{printable(line, 80)}'")
            node = self.number(words[0])
            x = [self.number(word, float) if word else 0.0 for word in words[1:4]]
            x += [0.0] * (3 - len(x))
            if nodes.setdefault(node, x) != x:
                raise Refused(f"node {node} is defined twice, at different places")
            ids.append(node)
        if parameters.get("NSET"):
            self.scope.add("node", parameters["NSET"], ids)

    def read_element(self, parameters, data):
        if not parameters.get("TYPE"):
            raise Refused("*ELEMENT has no TYPE")
        kind, size = element_type(parameters["TYPE"], self.hexes_only)
        if size is None:
            ids = self.read_left(kind, data)
            data = []
        else:
            ids = []
        about = f"of type {printable(parameters['TYPE'])}"
        words, elements = [], self.scope.elements
        for line in data:
            for word in filter(None, map(str.strip, line.split(","))):
                # in the assembly, nodes of instances: Part-1-1.7
                words.append(int(word) if word.isdecimal() and len(word) < 18 else
                             self.reference(word) if words and "." in word and self.scope is self.file else
                             self.number(word))
            if len(words) > size + 1:
                raise Refused(f"element {words[0]} {about} has more than {size} nodes")
            if len(words) == size + 1:
                if elements.setdefault(words[0], (kind, words[1:])) != (kind, words[1:]):
                    raise Refused(f"element {words[0]} is defined twice")
                ids.append(words[0])
                words = []
        if words:
            raise Refused(f"element {words[0]} {about} has {len(words) - 1} nodes, not {size}")
        if parameters.get("ELSET"):
            self.scope.add("element", parameters["ELSET"], ids)

    def read_left(self, kind, data):
        """IDs of elements that are left out, of a type of unknown size: one per line, or per lines that end with a comma."""
        ids, goes_on = [], False
        for line in data:
            if not goes_on:
                ids.append(self.number(line.split(",")[0].strip()))
                if self.scope.elements.setdefault(ids[-1], (kind, [])) != (kind, []):
                    raise Refused(f"element {ids[-1]} is defined twice")
            goes_on = line.endswith(",")
        return ids

    def reference(self, word):
        """(INSTANCE, ID or name) of 'Part-1-1.7'."""
        instance, _, name = word.rpartition(".")
        if not instance or not name:
            raise Refused(f"*{self.keyword}: '{printable(word)}' is not a number")
        return instance.strip('"').upper(), self.number(name) if re.fullmatch(r"\d+", name) else name

    def members(self, parameters, data):
        """IDs, ranges of IDs, names of sets, and (INSTANCE, one of these)."""
        found = []
        for line in data:
            words = [word.strip() for word in line.rstrip(",").split(",")]
            if "GENERATE" in parameters:
                row = [self.number(word) for word in words]
                if len(row) not in (2, 3) or row[1] < row[0] or row[-1] < 1 and len(row) == 3:
                    raise Refused(f"*{self.keyword}: GENERATE needs first, last and increment, not '{printable(line, 80)}'")
                found.append(range(row[0], row[1] + 1, row[2] if len(row) == 3 else 1))
                continue
            for word in filter(None, words):
                found.append(self.number(word) if re.fullmatch(r"-?\d+", word) else word.strip('"'))
        return found

    def add_set(self, what, parameters, data):
        name = parameters.get(self.keyword, "")
        if not name:
            raise Refused(f"*{self.keyword}: it has no name ({self.keyword}=)")
        found = self.members(parameters, data)
        if what == "node" and "ELSET" in parameters:
            found.append(("of elements", parameters["ELSET"]))
        if parameters.get("INSTANCE"):
            found = [(parameters["INSTANCE"].upper(), member) for member in found]
        key = self.scope.key(name)
        if "INTERNAL" in parameters and key not in self.scope.sets[what]:
            self.scope.internal.add((what, key))
        elif "INTERNAL" not in parameters:
            self.scope.internal.discard((what, key))
        self.scope.add(what, name, found)

    def read_nset(self, parameters, data):
        self.add_set("node", parameters, data)

    def read_elset(self, parameters, data):
        self.add_set("element", parameters, data)

    def read_solid_section(self, parameters, data):
        if parameters.get("ELSET"):
            self.scope.sections.append((self.scope.key(parameters["ELSET"]), parameters.get("MATERIAL", "")))

    KEYWORDS = {"PART": read_part, "END PART": read_end_part, "INSTANCE": read_instance, "END INSTANCE": read_end_part,
                "NODE": read_node, "ELEMENT": read_element, "NSET": read_nset, "ELSET": read_elset,
                "SOLID SECTION": read_solid_section}


# --- the model -------------------------------------------------------------------------------------


def moved(x, instance):
    """Places of a part in its instance: the translation comes before the rotation, a right-handed one about the axis
    from a to b."""
    if getattr(instance, "shift", None):
        x = x + np.array(instance.shift)
    if getattr(instance, "turn", None):
        a, b, angle = np.array(instance.turn[:3]), np.array(instance.turn[3:6]), math.radians(instance.turn[6])
        length = np.linalg.norm(b - a)
        if not length > 0:
            raise Refused(f"instance {printable(instance.name)}: the axis of its rotation has no length")
        axis, r = (b - a) / length, x - a
        c, s = math.cos(angle), math.sin(angle)
        x = a + (c * r + s * np.cross(axis, r) + (1 - c) * np.outer(r @ axis, axis))
    return x


class Placed:
    """An instance, or what is outside of parts, in the model: its scopes and where its nodes and elements are."""

    def __init__(self, name, scopes, instance, first_node, first_element):
        self.name, self.scopes = name, scopes
        self.nodes, self.elements, self.title, self.internal, self.sections = {}, {}, {}, set(), []
        sets = {"node": {}, "element": {}}
        for scope in scopes:
            for mine, its, what in ((self.nodes, scope.nodes, "node"), (self.elements, scope.elements, "element")):
                twice = [k for k in its if k in mine]
                if twice:
                    raise Refused(f"{what} {some(twice)} is in instance {printable(name)} and in its part")
                mine.update(its)
            for what, found in scope.sets.items():
                for key, members in found.items():
                    sets[what].setdefault(key, []).extend(members)
            self.title.update(scope.title)
            self.internal |= scope.internal
            self.sections += scope.sections
        self.sets = sets
        self.points = moved(np.array(list(self.nodes.values()), dtype=float).reshape(-1, 3), instance)
        self.index = {"node": dict(zip(self.nodes, range(first_node, first_node + len(self.nodes)))),
                      "element": dict(zip(self.elements, range(first_element, first_element + len(self.elements))))}
        self.sorted = {what: np.sort(np.array(list(index), dtype=np.int64)) for what, index in self.index.items()}


class Model:
    """All instances, and what their sets are."""

    def __init__(self, reader):
        self.placed, self.known, self.resolved = {}, {}, {}
        self.n_nodes = self.n_elements = 0
        if reader.instances:
            for instance in reader.instances.values():
                self.place(instance.name, [instance.part, instance], instance)
        else:  # parts alone
            for part in reader.parts.values():
                self.place(part.name, [part], None)
        self.place("", [reader.file], None)
        self.elements = [(placed, element) for placed in self.placed.values() for element in placed.elements.values()]

    def place(self, name, scopes, instance):
        placed = Placed(name, scopes, instance, self.n_nodes, self.n_elements)
        self.placed[name.upper()] = placed
        self.n_nodes += len(placed.nodes)
        self.n_elements += len(placed.elements)

    def instance(self, name):
        if name not in self.placed:
            raise Refused(f"there is no instance '{printable(name)}'")
        return self.placed[name]

    def nodes_of(self, element):
        """Indices of the nodes of an element, by its index."""
        placed, (_, nodes) = self.elements[element]
        found = []
        for node in nodes:
            where, node = (self.instance(node[0]), node[1]) if isinstance(node, tuple) else (placed, node)
            if node not in where.index["node"]:
                missing = [str(n) for n in nodes if not isinstance(n, tuple) and n not in placed.nodes] or [str(node)]
                mine = next(k for k, value in placed.index["element"].items() if value == element)
                raise Refused(f"element {mine}: there is no node {some(missing)}")
            found.append(where.index["node"][node])
        return found

    def set(self, placed, what, name, open_sets=()):
        """Indices of the members of a set; `open_sets`: those that this one is looked up for."""
        key = (placed.name.upper(), what, name.upper())
        if key in self.resolved:
            return self.resolved[key]
        if key in open_sets or len(open_sets) > 100:
            raise Refused(f"the sets {printable(name)} and {printable(open_sets[-1][2])} are in each other"
                          if key in open_sets else "sets within sets, over 100 deep")
        title = placed.title[name.upper()]
        about = f"{what} set '{printable(title)}'"
        single, found, missing = [], [], []
        for member in placed.sets[what][name.upper()]:
            where = placed
            while isinstance(member, tuple) and member[0] != "of elements":
                where, member = self.instance(member[0]), member[1]
            if isinstance(member, int):
                index = where.index[what].get(member)
                (missing if index is None else single).append(member if index is None else index)
            elif isinstance(member, range):
                found.append(self.those_of_range(where, what, member, about))
            elif isinstance(member, tuple):
                found.append(self.of_elements(where, member[1], key, open_sets, about))
            else:
                where, member, inner = self.look_up(where, what, member, about)
                if inner != key:
                    found.append(np.array([member]) if isinstance(member, int) else
                                 self.set(where, what, member, (*open_sets, key)))
        if missing:
            raise Refused(f"{about}: there is no "
                          + (which_elements(missing) if what == "element" else f"node {some(missing)}"))
        self.resolved[key] = np.unique(np.concatenate([np.array(single, dtype=np.int64), *found])).astype(np.int64)
        return self.resolved[key]

    def look_up(self, where, what, name, about):
        """A set's name; in the assembly also Part-1-1.SET, or Part-1-1.7, of which the index is given."""
        if name.upper() in where.sets[what]:
            return where, name, (where.name.upper(), what, name.upper())
        instance, _, inner = name.rpartition(".")
        if not where.name and instance.strip('"').upper() in self.placed and instance:
            where = self.placed[instance.strip('"').upper()]
            if inner.upper() in where.sets[what]:
                return where, inner, (where.name.upper(), what, inner.upper())
            if re.fullmatch(r"\d{1,18}", inner) and int(inner) in where.index[what]:
                return where, where.index[what][int(inner)], None
        raise Refused(f"{about}: there is no {what} or set '{printable(name)}'")

    def those_of_range(self, where, what, members, about):
        """IDs of a GENERATE may be billions: only those that are there are gone through."""
        ids = where.sorted[what]
        ids = ids[np.searchsorted(ids, members.start):np.searchsorted(ids, members[-1], "right")]
        ids = ids[(ids - members.start) % members.step == 0]
        if len(ids) != len(members):
            there, missing = set(ids.tolist()), []
            for k in members:
                if k not in there:
                    missing.append(k)
                    if len(missing) == 10:
                        break
            left = len(members) - len(ids)
            raise Refused(f"{about}: there is no {what} {some(missing)}" + (f" ... ({left} in all)" if left > 10 else ""))
        return np.array([where.index[what][k] for k in ids.tolist()], dtype=np.int64)

    def of_elements(self, where, name, key, open_sets, about):
        if name.upper() not in where.sets["element"]:
            raise Refused(f"{about}: there is no element set '{printable(name)}'")
        elements = self.set(where, "element", name, (*open_sets, key))
        return np.array([node for element in elements.tolist() for node in self.nodes_of(element)], dtype=np.int64)


def written_sets(model, what):
    """(where, KEY) -> name: the name alone, or with its instance if another set has it too."""
    by_key = {}
    for placed in model.placed.values():
        for key in placed.sets[what]:
            by_key.setdefault(key, []).append(placed)
    found = {}
    for placed in model.placed.values():
        for key in placed.sets[what]:
            title, others = placed.title[key], by_key[key]
            if placed.name and len(others) > 1:
                mine = model.set(placed, what, key)
                if not others[-1].name and np.array_equal(mine, model.set(others[-1], what, key)):
                    found[placed.name, key] = others[-1].title[key]  # the set of the assembly is the same
                    continue
                title = f"{placed.name}.{title}"
            found[placed.name, key] = title
    return found


def read(path, hexes_only=False):
    """hexes_only: types of elements that are not known are left out, too."""
    reader, lines = Reader(hexes_only), Lines()
    reader.read(lines, path)
    model = Model(reader)
    mesh = Mesh()
    mesh.files += lines.files
    populated = [placed for placed in model.placed.values() if placed.nodes or placed.elements]
    mesh.points = np.concatenate([placed.points for placed in model.placed.values()])
    mesh.node_ids = np.array([k for placed in model.placed.values() for k in placed.nodes], dtype=np.int64)
    many = len(populated) > 1

    def names(placed, ids):
        return [f"{placed.name}.{k}" if placed.name and many else str(k) for k in ids]

    hexes, hex_ids, hex_names, hex_index = [], [], [], {}
    for placed in model.placed.values():
        for element, (kind, _) in placed.elements.items():
            index = placed.index["element"][element]
            if kind in CARRIERS:
                mesh.ignored[kind] = mesh.ignored.get(kind, 0) + 1
            elif kind == "hexahedron":
                hex_index[index] = len(hexes)
                hexes.append(model.nodes_of(index))
                hex_ids.append(element)
                hex_names += names(placed, [element])
            else:
                mesh.others.setdefault(kind, []).extend(names(placed, [element]))
    mesh.hexes, mesh.hex_ids = np.array(hexes, dtype=np.int64).reshape(-1, 8), np.array(hex_ids, dtype=np.int64)
    if many:
        mesh.hex_names = np.array(hex_names)
        mesh.node_names = np.array([name for placed in populated for name in names(placed, placed.nodes)])
    read_sets(model, mesh, hex_index)
    if reader.instances:
        used = {id(instance.part) for instance in reader.instances.values()}
        mesh.notes += [f"part {printable(part.name)} has no instance, and is left out"
                       for part in reader.parts.values() if id(part) not in used]
    return mesh


def read_sets(model, mesh, hex_index):
    for (where, key), name in written_sets(model, "node").items():
        placed = model.placed[where.upper()]
        nodes = model.set(placed, "node", key)
        if ("node", key) not in placed.internal:
            mesh.node_sets[name] = nodes
    names = written_sets(model, "element")
    for (where, key), name in names.items():
        placed = model.placed[where.upper()]
        elements = model.set(placed, "element", key)
        internal = ("element", key) in placed.internal
        found = [hex_index[element] for element in elements.tolist() if element in hex_index]
        if found:
            mesh.volume_sets[name] = np.unique(found)
            if internal:
                mesh.hidden.add(name)
        elif not internal:
            carriers = [element for element in elements.tolist() if model.elements[element][1][0] in CARRIERS]
            if not carriers and len(elements):
                mesh.notes.append(f"the set '{printable(name)}' holds elements that are left out, and is left out")
                continue
            nodes = [node for element in carriers for node in model.nodes_of(element)]
            nodes = np.unique(np.array(nodes, dtype=np.int64))
            same = mesh.node_sets.get(name)
            if same is None:
                mesh.node_sets[name] = nodes
            elif not np.array_equal(same, nodes):
                mesh.notes.append(f"'{printable(name)}' is a node set and an element set: the node set is written")
    read_parts(model, mesh, names)


def read_parts(model, mesh, names):
    """The sets of *SOLID SECTION."""
    parts = {}
    for placed in model.placed.values():
        for key, material in placed.sections:
            name = names.get((placed.name, key))
            if name is None and not placed.name and "." in placed.title[key]:  # a section outside of parts
                where, inner, _ = model.look_up(placed, "element", placed.title[key], "*SOLID SECTION")
                name = names.get((where.name, inner.upper()))
            if name is None and key not in placed.sets["element"]:
                raise Refused(f"*SOLID SECTION: there is no element set '{printable(placed.title[key])}'")
            if name in mesh.volume_sets:
                parts[name] = None
                if name in mesh.hidden and material:
                    mesh.notes.append(f"part {printable(name)} is of the material {printable(material)} "
                                      f"(--rename {printable(name)}=...)")
    if parts or any(placed.sections for placed in model.placed.values()):
        mesh.parts = list(parts)
