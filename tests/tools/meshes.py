"""Meshes for the tests of mesh2data, and what reads its results."""

import contextlib
import gzip
import importlib.machinery
import importlib.util
import io
import os
import re
import sys
import tempfile
import types
import unittest
from pathlib import Path

import meshio
import numpy as np

SOURCE = Path(__file__).resolve().parents[2]
TOOL = SOURCE / "tools" / "mesh2data"


def load(path):
    """A script as a module: it is called in this process, since starting Python and meshio takes longer
    than the work of most tests."""
    loader = importlib.machinery.SourceFileLoader(path.stem, str(path))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(path.stem, loader))
    loader.exec_module(module)
    return module


sys.dont_write_bytecode = True
mesh2data = load(TOOL)
layers2data = load(SOURCE / "tools" / "layers2data")
CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]])


def block(n, size, origin=(0, 0, 0), irregular=0.0):
    """Nodes and hexahedra of n[0] x n[1] x n[2] elements; nodes are moved by up to `irregular` edges."""
    grid = np.stack(np.meshgrid(*(np.arange(k + 1) for k in n), indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(len(grid)).reshape([k + 1 for k in n])
    hexes = [[number[tuple(np.array(at) + corner)] for corner in CORNERS] for at in np.ndindex(*n)]
    points = (grid + irregular * np.random.default_rng(1).uniform(-1, 1, grid.shape)) * np.asarray(size)
    return points + np.asarray(origin), np.array(hexes)


def turned(nodes):
    """The same for all 24 numberings of a hexahedron, and for none that is inside out: the nodes along an edge
    from the smallest corner, and so on."""
    edges = {0: (1, 3, 4), 1: (2, 0, 5), 2: (3, 1, 6), 3: (0, 2, 7), 4: (7, 5, 0), 5: (4, 6, 1), 6: (5, 7, 2), 7: (6, 4, 3)}
    first = min(range(8), key=lambda k: nodes[k])
    cycle = edges[first]  # right-handed in this order
    k = min(range(3), key=lambda k: nodes[cycle[k]])
    a, b, c = cycle[k:] + cycle[:k]
    far = {frozenset(edges[n]): n for n in range(8)}
    corner = {pair: next(n for n in range(8) if n != first and set(pair) <= set(edges[n])) for pair in ((a, b), (b, c), (a, c))}
    return tuple(nodes[n] for n in (first, a, b, c, corner[a, b], corner[b, c], corner[a, c], far[frozenset(corner.values())]))


def inp(points, elements, extra="", kind="C3D8", first_node=1, first_element=1):
    """An Abaqus file: elements is a list of (ELSET or None, hexahedra)."""
    lines = ["*HEADING", "*NODE"]
    lines += [f"{first_node + k}, " + ", ".join(repr(float(c)) for c in x) for k, x in enumerate(points)]
    number = first_element
    for name, cells in elements:
        lines.append(f"*ELEMENT, TYPE={kind}" + (f", ELSET={name}" if name else ""))
        for cell in cells:
            lines.append(f"{number}, " + ", ".join(str(first_node + node) for node in cell))
            number += 1
    return "\n".join(lines) + "\n" + extra


def call(tool, *arguments):
    """What the program does, in this process."""
    output, errors = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(output), contextlib.redirect_stderr(errors):
        try:
            status = tool.main([str(a) for a in arguments])
        except SystemExit as stop:
            status = stop.code
    return types.SimpleNamespace(returncode=status, stdout=output.getvalue(), stderr=errors.getvalue())


class Data:
    """A data file, and its groups, as they were written."""

    def __init__(self, path):
        text = Path(path).read_text()
        self.text = text
        head, rest = text.split("Atoms # sphere\n")
        atoms, hexes = rest.split("Hexes\n")
        self.header = dict(reversed(line.split(None, 1)) for line in head.splitlines()[1:] if re.match(r"\d+ \D", line))
        self.box = {line.split()[2][0]: tuple(map(float, line.split()[:2])) for line in head.splitlines() if "lo " in line}
        self.type, self.x, self.part, self.nodes = {}, {}, {}, {}
        for line in filter(None, atoms.splitlines()):
            words = line.split()
            assert words[2:4] == ["0", "1"], line  # a point, of any density
            self.type[int(words[0])] = int(words[1])
            self.x[int(words[0])] = tuple(float(word) for word in words[4:])
            assert len(words) == 7
        for line in filter(None, hexes.splitlines()):
            words = line.split()
            assert len(words) == 10, line
            self.part[int(words[0])] = words[1]
            self.nodes[int(words[0])] = [int(word) for word in words[2:]]
        assert int(self.header["atoms"]) == len(self.x) and int(self.header["hexes"]) == len(self.nodes)
        self.groups = {}
        groups = Path(str(path) + ".groups")
        if groups.exists():
            for line in groups.read_text().splitlines():
                words = line.split()
                if words[:1] != ["group"]:
                    continue
                assert len(line) <= 110, line
                ids = self.groups.setdefault(words[1], set())
                for item in words[3:] if words[2] == "id" else []:
                    first, _, last = item.partition(":")
                    ids |= set(range(int(first), int(last or first) + 1))

    def shape(self):
        """Every element by its part and the places of its nodes, whatever the numbers are and whichever node
        comes first."""
        return sorted((self.part[e], turned(tuple(self.x[node] for node in nodes))) for e, nodes in self.nodes.items())

    def places(self, group):
        return {self.x[node] for node in self.groups[group]}


class Case(unittest.TestCase):
    maxDiff = 2000

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def write(self, name, text):
        path = self.folder / name
        path.write_text(text)
        return path

    def run_tool(self, mesh, *options, out="out.data"):
        return call(mesh2data, mesh, self.folder / out, *options)

    def convert(self, mesh, *options, out="out.data"):
        result = self.run_tool(mesh, *options, out=out)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(result.stderr, "")
        self.summary = result.stdout
        return Data(self.folder / out)

    def refuse(self, mesh, *words, options=()):
        """One line, exit status 2, no file; all words are in the line."""
        result = self.run_tool(mesh, *options, out="refused.data")
        self.assertEqual(result.returncode, 2, result.stdout + result.stderr)
        self.assertEqual(result.stdout, "")
        self.assertEqual(result.stderr.count("\n"), 1, result.stderr)
        for word in words:
            self.assertIn(word, result.stderr)
        self.assertNotIn("Traceback", result.stderr)
        self.assertEqual([p.name for p in self.folder.glob("refused*")], [])


def ready_mesh(name, folder):
    """A mesh of tests/meshes, unpacked: Gmsh itself makes another one on another processor."""
    path = Path(folder) / f"{name}.msh"
    path.write_bytes(gzip.decompress((SOURCE / "tests" / "meshes" / f"{name}.msh.gz").read_bytes()))
    return path


def environment(name):
    value = os.environ.get(name)
    if not value:
        raise RuntimeError(f"environment variable {name} is not set: run this test by ctest")
    return value


__all__ = ["CORNERS", "Case", "Data", "SOURCE", "TOOL", "block", "call", "environment", "inp", "layers2data", "mesh2data", "meshio", "np", "ready_mesh",
           "turned"]
