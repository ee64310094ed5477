#!/usr/bin/env python3
"""Fuzzes tools/mesh2data and tools/layers2data with damaged meshes, options and output names.

    fuzz_tools.py [--seconds S] [--seed N] [--keep FOLDER]

Each input has a number, from which it is made; the same seed gives the same inputs. Whatever comes in, a tool
either says in one line what is wrong (status 2) and changes no file, or writes files that are right in themselves:
counts, references, finite numbers, ID and box bounds, and groups without any other command. A file of Abaqus
that is written in another way (includes, INPUT=, comments, order, case) gives the same mesh. An input that does
otherwise, or takes over 20 s or 3 GB, is kept in FOLDER and ends the run. A run of some seconds is in the suite."""

import argparse
import math
import os
import random
import re
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
from pathlib import Path

from meshes import CORNERS, Data, SOURCE, block, call, inp, layers2data, mesh2data, meshio, np

INPUTS = SOURCE / "tests" / "tools" / "inputs"
NUMBERS = [b"0", b"-1", b"1", b"2", b"7", b"12", b"27", b"1e999", b"nan", b"inf", b"-inf", b"1e200", b"1e-300", b"1.5", b"2147483647",
           b"2147483648", b"4294967296", b"9223372036854775807", b"18446744073709551615", b"1" + 400 * b"0", b"1_0", b"0x10", b"", b"-",
           b"1e", "１".encode(), b"1,", b",", b"1.", b"Part-1-1.1", b"."]
WORDS = [b"", b'"', b"''", b"$x", b"&", b"#", b"a b", b"all", b"glass", b"Glass", b"_", b"1", "é".encode(), b"\xff", b"\x00", b"\r", b"\x1b[2J",
         500 * b"n", b"A", b"B", b"Support", b"_PickedSet3", b"Part-1-1", b"I1", b"P1"]
LINES = [b"*NSET, NSET=", b"*NSET, NSET=a, GENERATE\n1, 2000000000", b"*NSET, NSET=a, GENERATE\n1, 12, 0", b"*NSET, NSET=a\nb\n*NSET, NSET=b\na",
         b"*ELSET, ELSET=e\n1, 2\n*NSET, NSET=n, ELSET=e", b"*INCLUDE, INPUT=rim.txt", b"*INCLUDE, INPUT=self.inp", b"*INCLUDE", b"*INCLUDE,",
         b"*NODE, INPUT=mid.txt", b"*ELEMENT, TYPE=C3D8, INPUT=mid.txt, ELSET=x", b"*ELEMENT, TYPE=SPRINGA\n9, 1, 2", b"*ELEMENT, TYPE=C3D4\n9, 1,2,3,4",
         b"*PART, NAME=P9", b"*END PART", b"*END INSTANCE", b"*INSTANCE, NAME=I9, PART=P1\n1,2,3\n0,0,0,0,0,1,30\n*END INSTANCE",
         b"*INSTANCE, NAME=I9, PART=Part-1\n*END INSTANCE", b"*SOLID SECTION, ELSET=A, MATERIAL=m", b"** comment", b"*ELSET, ELSET=s, INTERNAL\n1",
         b"*NSET, NSET=s, INSTANCE=I1\n1, 2", b"$EndNodes", b"$Elements\n0\n$EndElements", b"$Nodes\n0\n$EndNodes", b"$Comments\nx\n$EndComments",
         b'$PhysicalNames\n1\n3 1 ""\n$EndPhysicalNames', b"5 5 2 1 1 21 9 2 12 27 23 17 25", b"$NodeData\n1\n$EndNodeData", b"*SET_NODE_GENERATE\n1\n1,2000000000",
         b"*SET_NODE_TITLE", b"*PART", b"*ELEMENT_SOLID\n9,7\n101,102", b"*INCLUDE\nself.k", b"*KEYWORD LONG=Y", b"*END", b"$ comment",
         b"GRID,5", b"CHEXA,9,7,101", b"SET1,1,1,THRU,2000000000", b"INCLUDE 'self.bdf'", b"ENDDATA", b"BEGIN BULK", b"+", b"*"]


def corpus():
    """Name of the suffix and content of what damage starts from."""
    found = [(path.suffix, path.read_bytes()) for path in sorted(INPUTS.glob("*.*")) if path.suffix in (".bdf", ".inp", ".k", ".msh")]
    points, hexes = block((2, 1, 1), 1.0)
    found.append((".inp", inp(points, [("glass", hexes[:1]), ("pvb", hexes[1:])], "*NSET, NSET=a b\n1, 2\n").encode()))
    with tempfile.TemporaryDirectory() as folder:
        for version in "2.2", "4.1":
            path = Path(folder) / "m.msh"
            cells = [("quad", hexes[:, [0, 3, 7, 4]]), ("hexahedron", hexes)]
            meshio.gmsh.write(str(path), meshio.Mesh(
                points, cells, point_data={"gmsh:dim_tags": np.array([(3, 1)] * (len(points) - 2) + [(2, 3)] * 2)},
                cell_data={"gmsh:physical": [np.full(2, 7), np.full(2, 5)], "gmsh:geometrical": [np.full(2, 3), np.full(2, 1)]},
                field_data={"glass": np.array([5, 3]), "left": np.array([7, 2])}, cell_sets={}), version, binary=True)
            found.append((".msh", path.read_bytes()))
        for suffix, module in ((".vtk", meshio.vtk), (".vtu", meshio.vtu)):
            path = Path(folder) / ("m" + suffix)
            module.write(str(path), meshio.Mesh(points, [("hexahedron", hexes)], cell_data={"part": [np.array([1, 2])]},
                                                point_data={"held": np.arange(len(points)) % 2}))
            found.append((suffix, path.read_bytes()))
    return found


def damage(data, dice, others):
    kind = dice.randrange(10)
    if kind == 0:  # bytes
        data = bytearray(data)
        for _ in range(dice.choice((1, 2, 8))):
            if data:
                data[dice.randrange(len(data))] = dice.choice((0, 255, 1, 10, 44, 42, 36, dice.randrange(256)))
        return bytes(data)
    if kind == 1:  # cut
        a, b = sorted(dice.randrange(len(data) + 1) for _ in range(2))
        return dice.choice((data[:a], data[a:], data[:a] + data[b:], data[:b] + data[a:]))
    if kind == 2:  # spliced
        other = dice.choice(others)
        return data[:dice.randrange(len(data) + 1)] + other[dice.randrange(len(other) + 1):]
    if kind in (3, 4, 5):  # a number or a word
        places = [m.span() for m in re.finditer(rb"[^\s,=]+" if kind < 5 else rb"(?<==)[^\s,]+|\"[^\"]*\"", data)]
        if places:
            a, b = dice.choice(places)
            other = data[slice(*dice.choice(places))]
            return data[:a] + dice.choice([*(NUMBERS if kind < 5 else WORDS), other]) + data[b:]
        return data
    lines = data.split(b"\n")
    at = dice.randrange(len(lines))
    if kind == 6:
        lines[at:at + dice.choice((1, 1, 3))] = []
    elif kind == 7:
        lines.insert(dice.randrange(len(lines)), lines[at])
    elif kind == 8:
        other = dice.randrange(len(lines))
        lines[at], lines[other] = lines[other], lines[at]
    else:
        lines.insert(at, dice.choice(LINES))
    return b"\n".join(lines)


def rewritten(data, dice, folder):
    """The same file of Abaqus in other words, and in several files."""
    lines = [line.strip() for line in data.decode().splitlines()]
    whole = lambda: [k for k in range(len(lines)) if not lines[k - 1].endswith(",") or not lines[k - 1].startswith("*")]
    if not any(line.upper().startswith(("*PART", "*INCLUDE")) for line in lines):
        # sets may stand before what they name
        starts = [k for k, line in enumerate(lines) if line.startswith("*")] + [len(lines)]
        blocks = [lines[a:b] for a, b in zip(starts, starts[1:])]
        for block in [b for b in blocks if re.match(r"\*(nset|elset)\b", b[0], re.IGNORECASE)]:
            blocks.remove(block)
            blocks.insert(dice.randrange(len(blocks) + 1), block)
        lines = lines[:starts[0]] + [line for block in blocks for line in block]
    for k, line in enumerate(lines):
        if line.startswith("*") and not line.startswith("**"):
            keyword, comma, rest = line.partition(",")
            lines[k] = "".join((dice.choice((keyword.upper(), keyword.lower(), keyword)), dice.choice(("", " ")), comma,
                                dice.choice(("\n", " ")) if rest else "", rest))
    lines = "\n".join(lines).split("\n")
    number = 0
    for _ in range(dice.randrange(4)):
        number += 1
        inner = Path(folder) / f"inner{number}.txt"
        heads = [k for k, line in enumerate(lines) if re.match(r"\*(node|element)\s*,.*[^,]$", line, re.IGNORECASE)]
        if heads and dice.random() < 0.5 and "input" not in lines[heads[0]].lower():
            at = dice.choice(heads)
            if "input" in lines[at].lower():
                continue
            end = next((k for k in range(at + 1, len(lines)) if lines[k].startswith("*") and not lines[k].startswith("**")), len(lines))
            cut = dice.randrange(at + 1, end + 1)
            inner.write_text("\n".join(lines[at + 1:cut]) + "\n")
            lines[at:cut] = [lines[at] + f", INPUT={inner.name}"]
        else:
            a, b = sorted(dice.sample([*whole(), len(lines)], 2))
            inner.write_text("\n".join(lines[a:b]) + dice.choice(("", "\n", "\n\n")))
            lines[a:b] = [dice.choice(("*INCLUDE, INPUT=", "*include,\ninput = ")) + inner.name]
    for _ in range(dice.randrange(4)):
        lines.insert(dice.randrange(len(lines) + 1), dice.choice(("** comment", "", "  ", "**")))
    return dice.choice(("\n", "\r\n")).join(lines).encode()


def value(dice):
    return os.fsdecode(dice.choice(NUMBERS + WORDS).replace(b"\0", b""))


def mesh_options(dice):
    options = []
    for _ in range(dice.choice((0, 0, 0, 1, 2))):
        name = dice.choice(("groups", "scale", "parts", "default-part", "rename", "type", "sets", "merge", "drop-orphans", "fix-orientation",
                            "keep-ids", "node-offset", "element-offset", "other"))
        options.append("--" + name)
        if name in ("rename", "type"):
            options.append(f"{dice.choice(('glass', 'A', 'set:Support', value(dice)))}={dice.choice(('1', '3', 'new', value(dice)))}")
        elif name in ("parts", "sets", "default-part"):
            options.append(dice.choice(("glass", "A,B", "none", "glass,whole", "support", value(dice))))
        elif name == "groups":
            options.append(str(dice.choice(NAMES)))
        elif name in ("scale", "merge"):
            options.append(dice.choice(("1e-3", "0.1", "10", value(dice))))
        elif "offset" in name:
            options.append(dice.choice(("100", "2147483600", value(dice))))
    return options


def layer_arguments(dice):
    number = lambda: dice.choice(("0", "1", "2", "0.5", "-1", "3", "-.5", "1e-3", value(dice) if dice.random() < 0.3 else "1.5"))
    # more than some elements, or far too many: what is between takes long, and is right
    count = lambda: dice.choice(("1", "2", "3", "5", "4") if dice.random() < 0.9 else ("2147483647", value(dice)))
    words = []
    for _ in range(dice.choice((1, 1, 2, 3))):
        words += ["--layer", dice.choice(("a", "b", "glass", value(dice) if dice.random() < 0.3 else "c")),
                  dice.choice(("1", "0.5", "1e-3", "2", number())), count(), dice.choice(("1", "2", count()))]
    axis = dice.choice("xyz")
    for name in "xyz":
        if name != axis or dice.random() < 0.05:
            words += ["--" + name, *dice.choice((["0", count(), "1"], ["-1", count(), "0", count(), "2"], [number(), count(), number()]))]
    words += ["--axis", axis]
    if dice.random() < 0.3:
        words += ["--from", number()]
    if dice.random() < 0.1:
        del words[dice.randrange(len(words))]
    return words


NAMES = [None] * 60 + ["old.data", "old.data", "folder", "folder/", "link", "pipe", "", ".", "no/x", "line\nend", "it's \"$x\" &", "é", 300 * "n", "self.inp",
                       "self.msh", "rim.txt", "old.data.groups", "out.data"]


def snapshot(folder):
    """Of each name: kind, inode, content."""
    found = {}
    for entry in os.scandir(folder):
        info = entry.stat(follow_symlinks=False)
        content = Path(entry.path).read_bytes() if entry.is_file(follow_symlinks=False) else None
        found[entry.name] = info.st_mode, info.st_ino, content
    return found


def check_data(text):
    """A data file that is right in itself; the IDs of its nodes."""
    head, rest = text.split("\n", 1)
    assert "written by DEFE" in head or head.startswith("layers2data: "), head
    match = re.fullmatch(r"\n(\d+) atoms\n(\d+) atom types\n(\d+) hexes\n\n((?:\S+ \S+ [xyz]lo [xyz]hi\n){3})\nAtoms # sphere\n\n(.*\n)\nHexes\n\n(.*\n)",
                         rest, re.DOTALL)
    assert match, "sections"
    low, high = np.array([line.split()[:2] for line in match[4].splitlines()], dtype=float).T
    nodes = {}
    for line in match[5].splitlines():
        found = re.fullmatch(r"(\d+) (\d+) 0 1 (\S+) (\S+) (\S+)", line)
        assert found, line
        x = [float(word) for word in found.groups()[2:]]
        assert all(map(math.isfinite, x)) and (low <= x).all() and (x <= high).all(), line
        assert int(found[1]) not in nodes and 1 <= int(found[1]) < 2**31 and 1 <= int(found[2]) <= int(match[2]), line
        nodes[int(found[1])] = x
    elements, volume, used = set(), [], set()
    for line in match[6].splitlines():
        found = re.fullmatch(r"(\d+) ([A-Za-z_]\w*|[0-9]+\w*) ((?:\d+ ){7}\d+)", line, re.ASCII)
        assert found and 1 <= int(found[1]) < 2**31 and int(found[1]) not in elements, line
        elements.add(int(found[1]))
        mine = [int(word) for word in found[3].split()]
        assert len(set(mine)) == 8, line
        used.update(mine)
        x = np.array([nodes[n] for n in mine])
        J = np.einsum("ai,aj->ij", x - x.mean(axis=0), 2.0 * CORNERS - 1) / 8
        volume.append(np.linalg.det(J / max(np.abs(J).max(), 1e-300)))
    assert min(volume) > 0, "an element of negative volume"
    assert (len(nodes), len(elements)) == (int(match[1]), int(match[3])), "counts"
    assert used == set(nodes), "orphan nodes"
    return set(nodes)


def check_groups(text, nodes):
    counts, names = {}, set()
    for line in text.splitlines():
        match = re.fullmatch(r"group ([A-Za-z_]\w*|[0-9]+\w*) (empty|id((?: \d+(?::\d+)?)+))", line, re.ASCII)
        if match:
            names.add(match[1])
            for item in (match[3] or "").split():
                first, _, last = item.partition(":")
                ids = range(int(first), int(last or first) + 1)
                assert len(ids) <= len(nodes) and nodes.issuperset(ids), line
                counts[match[1]] = counts.get(match[1], 0) + len(ids)
            continue
        if not line or re.fullmatch(r"# node groups of [^\"'$&]*, written by DEFE's mesh2data; read the mesh first", line):
            continue
        match = re.fullmatch(r'if "\$\(count\((\w+)\)\) != (\d+)" then "print \'ERROR: group (\w+) needs (\d+) nodes of [^"\'$&]*, there are '
                             r'\$\(count\(\1\)\): read it first, into an empty box\'" "quit 1"', line)
        assert match and match[1] == match[3] and int(match[2]) == int(match[4]) == counts[match[1]], line
    assert "all" not in names and len(names) <= 31, "groups"


class Hang(Exception):
    pass


class Fuzz:
    def __init__(self, seed, keep):
        self.seed, self.keep, self.corpus = seed, keep, corpus()
        self.count = {0: 0, 2: 0}
        self.messages, self.rewritten = set(), 0

    def prepare(self, folder):
        for name in "rim.txt", "mid.txt":
            shutil.copy(INPUTS / name, folder)
        (folder / "folder").mkdir()
        (folder / "old.data").write_text("old\n")
        (folder / "old.data.groups").write_text("old\n")
        (folder / "link").symlink_to("old.data")
        os.mkfifo(folder / "pipe")

    def one(self, number, folder):
        dice = random.Random(f"{self.seed} {number}")
        self.prepare(folder)
        name = dice.choice(NAMES)
        out = "out.data" if name is None else name
        if dice.random() < 0.25:
            tool, arguments = layers2data, [out, *layer_arguments(dice)]
        else:
            suffix, data = dice.choice(self.corpus)
            for _ in range(dice.choice((0, 1, 1, 1, 3))):
                data = damage(data, dice, [other for end, other in self.corpus if end == suffix])
            Path("self" + suffix).write_bytes(data)
            tool, arguments = mesh2data, ["self" + suffix, out, *(str(o) if o != "None" else "g.txt" for o in mesh_options(dice))]
        before = snapshot(folder)
        self.arguments = arguments
        result = call(tool, *arguments)
        after = snapshot(folder)
        assert result.returncode in (0, 2), f"status {result.returncode}"
        self.count[result.returncode] += 1
        changed = {n for n in {*before, *after} if before.get(n) != after.get(n)}
        if result.returncode == 2:
            assert not changed, f"changed: {changed}"
            assert result.stdout == "" and re.fullmatch(r"(mesh2data|layers2data): [^\n]+\n", result.stderr), f"not one line: {result.stdout} {result.stderr}"
            assert "Error:" not in result.stderr or "cannot write" in result.stderr, f"not meant for users: {result.stderr}"
            assert not re.search(r"[\x00-\x09\x0b-\x1f\x7f]", result.stderr), f"control characters: {result.stderr!r}"
            self.messages.add(re.sub(r"[\d.]+|'.*?'", "", result.stderr)[:60])
            return
        assert result.stderr == "", f"says {result.stderr}"
        groups = next((arguments[k + 1] for k in reversed(range(len(arguments) - 1)) if arguments[k] == "--groups"), out + ".groups")
        assert changed <= {os.path.basename(out), os.path.basename(groups)}, f"changed: {changed}"
        nodes = check_data(after[os.path.basename(out)][2].decode())
        if tool is mesh2data and os.path.basename(groups) in changed:
            check_groups(after[os.path.basename(groups)][2].decode(), nodes)

    def same(self, number, folder):
        dice = random.Random(f"{self.seed} {number} same")
        for name in "rim.txt", "mid.txt":
            shutil.copy(INPUTS / name, folder)
        data = dice.choice([data for end, data in self.corpus if end == ".inp"])
        found = []
        for name, content in ("plain", data), ("rewritten", rewritten(data, dice, folder)):
            Path(name + ".inp").write_bytes(content)
            self.arguments = [name + ".inp", name + ".data"]
            result = call(mesh2data, *self.arguments)
            assert (result.returncode, result.stderr) == (0, ""), result.stderr
            written = Data(name + ".data")
            found.append((written.shape(), {group: written.places(group) for group in written.groups}))
        assert found[0] == found[1], "another mesh"
        self.rewritten += 1

    def run(self, seconds):
        def hang(*_):
            raise Hang("over 20 s")

        signal.signal(signal.SIGALRM, hang)
        end, number, home = time.monotonic() + seconds, 0, os.getcwd()
        while time.monotonic() < end:
            with tempfile.TemporaryDirectory(prefix="defe-fuzz-") as folder:
                os.chdir(folder)
                signal.alarm(20)
                try:
                    (self.same if number % 8 == 7 else self.one)(number, Path(folder))
                except BaseException as error:
                    signal.alarm(0)
                    os.chdir(home)
                    if isinstance(error, KeyboardInterrupt):
                        raise
                    traceback.print_exc(limit=-4)
                    kept = self.keep / f"{self.seed}-{number}"
                    shutil.copytree(folder, kept, symlinks=True, ignore=lambda *_: ["pipe"], dirs_exist_ok=True)
                    print(f"fuzz_tools: input {number} of seed {self.seed}, {self.arguments}, kept in {kept}", file=sys.stderr)
                    return 1
                signal.alarm(0)
                os.chdir(home)
            number += 1
        print(f"{number} inputs of seed {self.seed}: {self.count[0]} converted, {self.count[2]} refused, {self.rewritten} rewritten, {len(self.messages)} kinds of messages")
        # a fuzz that does not get through tests nothing
        return 0 if min(self.count.values()) > 0.15 * number and number > 20 else 1


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--seconds", type=float, default=1800, help="how long (1800)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=Path, default=SOURCE / "build" / "fuzz" / "found", help="folder for what fails (build/fuzz/found)")
    options = parser.parse_args()
    resource.setrlimit(resource.RLIMIT_AS, (3 << 30, 3 << 30))
    return Fuzz(options.seed, options.keep.resolve()).run(options.seconds)


if __name__ == "__main__":
    sys.exit(main())
