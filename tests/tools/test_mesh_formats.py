#!/usr/bin/env python3
"""tools/mesh2data: files of LS-DYNA, Nastran, VTK, Exodus and MED."""

import importlib.util
import sys
import unittest
from unittest import mock

from meshes import Case, block, meshio, np, turned


def cells(parts, n=(2, 1, 1)):
    """What Data.shape() is for a block of unit cubes; parts: of each."""
    points, hexes = block(n, 1.0)
    places = [tuple(x) for x in points.tolist()]
    return sorted((part, turned([places[k] for k in nodes])) for part, nodes in zip(parts, hexes))


def deck(solids=None, comma=False, two_lines=False, width=8, more=()):
    """Two cubes, parts 7 and 9, nodes from 101 on, elements from 11 on."""
    points, hexes = block((2, 1, 1), 1.0)

    def card(widths, words):
        return ", ".join(map(str, words)) if comma else "".join(str(word).rjust(w) for word, w in zip(words, widths))

    mark = {8: "", 10: "%", 20: "+"}[width]
    lines = ["$ a comment", "*KEYWORD", "*TITLE", "two cubes", "*NODE" + mark]
    lines += [card((width, *3 * [max(16, width)]), (101 + k, *map(float, x))) for k, x in enumerate(points)]
    lines += ["*PART", "glass pane", card(8 * [10], (7, 1, 1)), "pvb", card(8 * [10], (9, 1, 2)), "*ELEMENT_SOLID" + mark]
    for k, nodes in enumerate(hexes):
        head, rest = (11 + k, (7, 9)[k]), [101 + node for node in nodes]
        lines += [card(2 * [width], head), card(8 * [width], rest)] if two_lines else [card(10 * [width], (*head, *rest))]
    return "\n".join([*lines, *more, "*END", "what comes after it"]) + "\n"


class Dyna(Case):
    def dyna(self, text, *options):
        return self.convert(self.write("mesh.k", text), *options)

    def test_columns_commas_and_long_numbers(self):
        for options in ({}, {"comma": True}, {"two_lines": True}, {"width": 10}, {"width": 20}, {"width": 20, "two_lines": True}):
            with self.subTest(**options):
                self.assertEqual(self.dyna(deck(**options)).shape(), cells(["glass_pane", "pvb"]))
        text = deck(width=20).replace("*NODE+", "*NODE").replace("*ELEMENT_SOLID+", "*ELEMENT_SOLID").replace("*KEYWORD", "*KEYWORD LONG=Y")
        text = text.replace("         7         1         1", "                   7                   1")
        self.assertEqual(self.dyna(text.replace("         9         1         2", "                   9")).shape(), cells(["glass_pane", "pvb"]))

    def test_numbers_of_fortran(self):
        data = self.dyna(deck().replace("             2.0", "           2.0+0"))
        self.assertEqual(data.shape(), cells(["glass_pane", "pvb"]))

    def test_without_titles_and_ids_kept(self):
        text = deck().replace("glass pane\n", "\n").replace("pvb\n", "\n")
        data = self.dyna(text, "--keep-ids")
        self.assertEqual((data.part, sorted(data.x)), ({11: "part_7", 12: "part_9"}, list(range(101, 113))))
        same = self.dyna(deck().replace("pvb\n", "glass pane\n"))
        self.assertEqual(same.part, {1: "glass_pane_7", 2: "glass_pane_9"})

    def test_sets(self):
        more = ["*SET_NODE_LIST_TITLE", "held", "         1", "       101       102       103",
                "*SET_NODE_LIST_GENERATE", "         5", "       101       104       112       999",
                "*SET_NODE", "6, 0., 0.", "107,108",
                "*SET_SEGMENT", "         2", "       101       103       104       102", "*SET_SOLID_TITLE", "second", "         3", "        12",
                "*SET_PART_LIST_TITLE", "all parts", "         4", "         7         9", "*SET_NODE_GENERAL_TITLE", "odd", "         8", "ALL"]
        data = self.dyna(deck(more=more))
        first, second = (sorted(int(node) + 1 for node in nodes) for nodes in block((2, 1, 1), 1.0)[1])
        self.assertEqual({name: sorted(nodes) for name, nodes in data.groups.items()}, {
            "glass_pane": first, "pvb": second, "held": [1, 2, 3], "node_set_5": [1, 2, 3, 4, 12], "node_set_6": [7, 8],
            "segment_set_2": [1, 2, 3, 4], "second": second, "all_parts": list(range(1, 13))})
        self.assertIn("the set 'odd' is left out: *SET_NODE_GENERAL_TITLE is not read", self.summary)

    def test_include(self):
        head, tail = deck().split("*ELEMENT_SOLID\n")
        self.write("solids.k", "*ELEMENT_SOLID\n" + tail)
        self.assertEqual(self.dyna(head + "*INCLUDE\nsolids.k\n*SET_NODE_TITLE\nheld\n1\n101\n*END\n").groups["held"], {1})
        self.refuse(self.write("a.k", head + "*INCLUDE\nother.k\n"), "there is no file", "other.k")
        self.refuse(self.write("a.k", "*INCLUDE\na.k\n"), "include each other")

    def test_other_elements(self):
        more = ["*ELEMENT_SOLID", "      21       7     101     102     104     103     103     103     103     103",
                "      22       7     101     102     104     103     105     105     105     105",
                "      23       7     101     102     104     103     105     105     106     106",
                "*ELEMENT_SHELL", "      31       8     101     102     104     103"]
        path = self.write("mesh.k", deck(more=more))
        self.refuse(path, "tetra elements 21; pyramid elements 22; wedge elements 23 (--hexes-only")
        self.assertEqual(self.convert(path, "--hexes-only").shape(), cells(["glass_pane", "pvb"]))
        for words in ("left out: 1 element of type tetra, 21", "*ELEMENT_SHELL is left out, 1 lines"):
            self.assertIn(words, self.summary)

    def test_refused(self):
        for text, words in (
                (deck().replace("       7     101", "       7     199"), ["element 11: there is no node 199"]),
                (deck().replace("*NODE\n", "*NODE\n  101 7.0\n"), ["is not in columns of 8"]),
                (deck(comma=True).replace("*NODE\n", "*NODE\n101, 7.0\n"), ["node 101 is defined twice"]),
                (deck(comma=True).replace("11, 7,", "11, x,"), ["*ELEMENT_SOLID: 'x' is no integer"]),
                (deck(comma=True).replace("102, 0.0", "102, one"), ["*NODE: 'one' is not a number"]),
                (deck(comma=True, more=["*PARAMETER", "R x 1.0"]).replace("102, 0.0", "102, &x"), ["*NODE: '_x' is not a number"]),
                (deck(more=["*INCLUDE_TRANSFORM", "a.k"]), ["*INCLUDE_TRANSFORM is not supported"]),
                (deck(more=["*ELEMENT_SOLID_ORTHO", "1,1"]), ["*ELEMENT_SOLID_ORTHO is not supported"]),
                (deck(more=["*SET_NODE_TITLE", "pvb", "1", "101"]), ["the set 'pvb' has the name of another set or part"]),
                (deck(more=["*SET_NODE_TITLE", "held", "1", "199"]), ["the set 'held': there is no node 199"]),
                ("\n".join(deck(two_lines=True).splitlines()[:-3]) + "\n", ["element 12: the line of its nodes is missing"]),
                ("nothing\n", ["stands before the first keyword"]), ("*KEYWORD\n", ["there are no hexahedra"])):
            with self.subTest(words=words):
                self.refuse(self.write("bad.k", text), *words)


def bulk(form="small", more=(), name='$HMNAME PROP                   7"glass pane"'):
    """The two cubes as bulk data."""
    points, hexes = block((2, 1, 1), 1.0)

    def card(first, *words):
        words = [str(word) for word in words]
        if form == "free":
            lines = [",".join([first, *words[:8]])] + ([",".join(["", *words[8:]])] if len(words) > 8 else [])
        elif form == "large":
            lines = [(first + "*").ljust(8) + "".join(word.ljust(16) for word in words[:4])]
            lines += ["*".ljust(8) + "".join(word.ljust(16) for word in words[k:k + 4]) for k in range(4, len(words), 4)]
        else:
            lines = [first.ljust(8) + "".join(word.rjust(8) for word in words[:8]) + ("+C1" if len(words) > 8 else "")]
            lines += ["+C1".ljust(8) + "".join(word.rjust(8) for word in words[8:])] if len(words) > 8 else []
        return lines

    lines = ["SOL 101", "SPC = 4", "BEGIN BULK", name, "$ a comment"]
    for k, x in enumerate(points):
        lines += card("GRID", 101 + k, "", *map(float, x))
    for k, nodes in enumerate(hexes):
        lines += card("CHEXA", 11 + k, (7, 9)[k], *(101 + node for node in nodes))
    return "\n".join([*lines, *more, "ENDDATA", "what comes after it"]) + "\n"


class Nastran(Case):
    def bulk(self, text, *options, name="mesh.bdf"):
        return self.convert(self.write(name, text), *options)

    def test_fields(self):
        for form in "small", "large", "free":
            with self.subTest(form):
                data = self.bulk(bulk(form), "--keep-ids")
                self.assertEqual((data.shape(), sorted(data.nodes), sorted(data.x)), (cells(["glass_pane", "part_9"]), [11, 12], list(range(101, 113))))
        femap = self.bulk(bulk(name="$ Femap Property 9 : pvb").replace("+C1", "   "), name="mesh.nas")    # without marks of continuation
        self.assertEqual(femap.shape(), cells(["part_7", "pvb"]))

    def test_numbers_of_fortran(self):
        self.assertEqual(self.bulk(bulk().replace("     2.0", "   2.0+0")).shape(), cells(["glass_pane", "part_9"]))
        self.assertEqual(self.bulk(bulk().replace("     2.0", " .02D+02")).shape(), cells(["glass_pane", "part_9"]))

    def test_sets(self):
        data = self.bulk(bulk(more=["SPC1           4     123     101    THRU     104     112", "SET1,5,107,108", "SPC1,4,3,106"]))
        self.assertEqual((data.groups["spc_4"], data.groups["set_5"]), ({1, 2, 3, 4, 6, 12}, {7, 8}))

    def test_include(self):
        head, tail = bulk().split("CHEXA", 1)
        self.write("solids.bdf", "CHEXA" + tail)
        self.assertEqual(self.bulk(head + "INCLUDE 'solids.\nbdf'\nSET1,5,101\n").groups["set_5"], {1})
        self.refuse(self.write("a.bdf", "INCLUDE 'other.bdf'\n"), "there is no file", "other.bdf")
        self.refuse(self.write("a.bdf", "INCLUDE 'a.bdf'\n"), "include each other")

    def test_other_elements(self):
        more = ["CTETRA,21,7,101,102,104,105", "CPENTA,22,7,101,102,104,105,106,108", "CQUAD4,31,8,101,102,104,103",
                "CHEXA,23,7," + ",".join(map(str, range(101, 107))), "," + ",".join(map(str, range(101, 109))), "," + ",".join(map(str, range(101, 107)))]
        path = self.write("mesh.bdf", bulk(more=more))
        self.refuse(path, "tetra elements 21; wedge elements 22; hexahedron20 elements 23 (--hexes-only")
        self.assertEqual(self.convert(path, "--hexes-only").shape(), cells(["glass_pane", "part_9"]))
        self.assertIn("CQUAD4 is left out, 1 elements", self.summary)

    def test_refused(self):
        for text, words in (
                (bulk("free").replace("CHEXA,11,7,101", "CHEXA,11,7,199"), ["element 11: there is no node 199"]),
                (bulk("free").replace("GRID,102,,", "GRID,102,3,"), ["GRID 102 is in the coordinate system 3"]),
                (bulk("free", more=["GRDSET,,3"]), ["GRDSET"]), (bulk(more=["GRID,101,,7.0"]), ["node 101 is defined twice"]),
                (bulk("free").replace("GRID,102,,0.0", "GRID,102,,x"), ["GRID: 'x' is not a number"]),
                (bulk("free").replace("CHEXA,11,7", "CHEXA,11,x"), ["CHEXA: 'x' is no integer"]),
                (bulk(more=["SET1,5,199"]), ["the set 'set_5': there is no node 199"]),
                (bulk(more=["CHEXA,11,7,101,102,103,104,105,106", ",107,108"]), ["element 11 is defined twice"]),
                ("+C1  1\n", ["continues no card"]), ("ENDDATA\n", ["there are no hexahedra"])):
            with self.subTest(words=words):
                self.refuse(self.write("bad.bdf", text), *words)


class Vtk(Case):
    def vtk(self, suffix, others=(), points=None, **cell_data):
        found, hexes = block((2, 1, 1), 1.0)
        path = self.folder / f"mesh{suffix}"
        blocks = [("hexahedron", hexes), *others]
        module = meshio.vtu if suffix == ".vtu" else meshio.vtk
        module.write(str(path), meshio.Mesh(found, blocks, point_data=points or {}, cell_data={
            key: [np.asarray(value), *(np.zeros(len(o[1]), np.asarray(value).dtype) for o in others)] for key, value in cell_data.items()}))
        return path

    def test_parts_and_sets(self):
        held = np.arange(12) % 2
        for suffix in ".vtk", ".vtu":
            with self.subTest(suffix):
                path = self.vtk(suffix, points={"held": held, "height": np.linspace(0, 1, 12), "level": np.arange(12)}, material=[4, 2], stress=[0.5, 1.5])
                data = self.convert(path, "--rename", "material_4=glass")
                self.assertEqual(data.shape(), cells(["glass", "material_2"]))
                self.assertEqual((set(data.groups), data.groups["held"]), ({"glass", "material_2", "held"}, {2, 4, 6, 8, 10, 12}))

    def test_several_arrays(self):
        path = self.vtk(".vtu", material=[4, 2], rank=[0, 1])
        self.refuse(path, "several arrays of whole numbers over the elements, material, rank: choose", "--part-array")
        self.assertEqual(self.convert(path, "--part-array", "rank").shape(), cells(["rank_0", "rank_1"]))
        self.refuse(path, "no array of whole numbers 'x'", "there are: material, rank", options=["--part-array", "x"])
        self.refuse(self.vtk(".vtk"), "in no part", "--default-part")
        self.assertEqual(self.convert(self.vtk(".vtk"), "--default-part", "glass").shape(), cells(["glass", "glass"]))
        self.refuse(self.write("a.k", deck()), "--part-array is for files of VTK", options=["--part-array", "x"])

    def test_other_elements(self):
        _, hexes = block((2, 1, 1), 1.0)
        path = self.vtk(".vtu", others=[("quad", hexes[:1, :4]), ("tetra", hexes[:1, [0, 1, 3, 4]])], material=[4, 2])
        self.refuse(path, "tetra elements 4 (--hexes-only")
        self.assertEqual(self.convert(path, "--hexes-only").shape(), cells(["material_4", "material_2"]))
        self.assertIn("elements that only name nodes: 1 quad", self.summary)

    def test_broken(self):
        for suffix in ".vtk", ".vtu":
            data = self.vtk(suffix, material=[4, 2]).read_bytes()
            for text in (data[:len(data) // 2], b"", b"nonsense\n" * 20):
                path = self.folder / f"broken{suffix}"
                path.write_bytes(text)
                self.refuse(path, "")


def there(module):
    return unittest.skipUnless(importlib.util.find_spec(module), f"no {module} (tools/install-deps.sh meshes)")


class Exodus(Case):
    def exodus(self, name="mesh.exo", blocks=None, titled=True, joint_coordinates=False):
        """Two cubes, blocks 7 and 9, nodes from 101 on, elements from 11 on; and a set of each kind."""
        import netCDF4

        points, hexes = block((2, 1, 1), 1.0)
        blocks = blocks or [("HEX8", hexes[:1]), ("HEX", hexes[1:])]
        path = self.folder / name
        with netCDF4.Dataset(str(path), "w", format="NETCDF3_64BIT_OFFSET") as data:
            for dimension, size in {"len_name": 33, "num_dim": 3, "num_nodes": 12, "num_el_blk": len(blocks), "num_node_sets": 1,
                                    "num_side_sets": 1, "num_nod_ns1": 2, "num_side_ss1": 2,
                                    "num_elem": sum(len(cells) for _, cells in blocks)}.items():
                data.createDimension(dimension, size)

            def put(name, values, dimensions, kind="i4"):
                data.createVariable(name, kind, dimensions)[:] = values

            if joint_coordinates:
                put("coord", points.T, ("num_dim", "num_nodes"), "f8")
            else:
                for axis, x in zip("xyz", points.T):
                    put("coord" + axis, x, ("num_nodes",), "f8")
            put("node_num_map", 101 + np.arange(12), ("num_nodes",))
            put("elem_num_map", 11 + np.arange(sum(len(cells) for _, cells in blocks)), ("num_elem",))
            put("eb_prop1", [7, 9, 4][:len(blocks)], ("num_el_blk",))
            if titled:
                names = netCDF4.stringtochar(np.array(["glass pane", "", ""][:len(blocks)], "S33"))
                put("eb_names", names, ("num_el_blk", "len_name"), "S1")
            for k, (kind, cells) in enumerate(blocks, 1):
                data.createDimension(f"num_el_in_blk{k}", len(cells))
                data.createDimension(f"num_nod_per_el{k}", np.shape(cells)[1])
                put(f"connect{k}", np.asarray(cells) + 1, (f"num_el_in_blk{k}", f"num_nod_per_el{k}"))
                data.variables[f"connect{k}"].elem_type = kind
            put("ns_prop1", [5], ("num_node_sets",))
            put("node_ns1", [1, 12], ("num_nod_ns1",))
            put("ss_prop1", [3], ("num_side_sets",))
            put("elem_ss1", [1, 2], ("num_side_ss1",))
            put("side_ss1", [5, 5], ("num_side_ss1",))  # below: the nodes 1, 4, 3, 2 of each
        return path

    @there("netCDF4")
    def test_blocks_and_sets(self):
        points, _ = block((2, 1, 1), 1.0)
        for name, options in (("mesh.exo", {}), ("mesh.e", {"titled": False}), ("mesh.g", {"joint_coordinates": True})):
            with self.subTest(name):
                data = self.convert(self.exodus(name, **options), "--keep-ids")
                parts = ["glass_pane" if options.get("titled", True) else "block_7", "block_9"]
                self.assertEqual((data.shape(), sorted(data.nodes), sorted(data.x)), (cells(parts), [11, 12], list(range(101, 113))))
                self.assertEqual((data.groups["node_set_5"], data.groups["side_set_3"]),
                                 ({101, 112}, {101 + k for k, x in enumerate(points) if x[2] == 0}))

    @there("netCDF4")
    def test_other_elements(self):
        _, hexes = block((2, 1, 1), 1.0)
        path = self.exodus(blocks=[("HEX8", hexes[:1]), ("TETRA", hexes[:1, [0, 1, 3, 4]]), ("HEX8", hexes[1:])])
        self.refuse(path, "tetra elements 12 (--hexes-only")
        self.assertEqual(self.convert(path, "--hexes-only").shape(), cells(["glass_pane", "block_4"]))
        for words in ("left out: 1 element of type tetra, 12", "side set side_set_3: 1 sides of elements that are no hexahedra"):
            self.assertIn(words, self.summary)
        self.refuse(self.exodus(blocks=[("HEX20", np.tile(hexes, 3)[:, :20])]), "hexahedron20 elements 11, 12")

    @there("netCDF4")
    def test_broken(self):
        _, hexes = block((2, 1, 1), 1.0)
        self.refuse(self.exodus(blocks=[("HEX8", hexes + 1)]), "names a node that is not there")
        for text in (self.exodus().read_bytes()[:40], b"", b"nonsense\n" * 20):
            path = self.folder / "broken.exo"
            path.write_bytes(text)
            self.refuse(path, "")

    def test_without_its_library(self):
        with mock.patch.dict(sys.modules, {"netCDF4": None}):
            self.refuse(self.write("mesh.exo", "x"), "files of Exodus need netCDF4", "python3-netcdf4")


class Med(Case):
    ORDER = [0, 3, 2, 1, 4, 7, 6, 5]  # of the format

    def med(self, order=ORDER, more=(), families=(-1, -2)):
        """Two cubes in two families, the second one in two groups; a quad and two nodes in groups."""
        points, hexes = block((2, 1, 1), 1.0)
        path = self.folder / "mesh.med"
        blocks = [("hexahedron", hexes[:, order]), ("quad", hexes[:1, :4]), *more]
        mesh = meshio.Mesh(points, blocks, point_data={"point_tags": np.array([0, 2, 2, *9 * [0]])},
                           cell_data={"cell_tags": [np.array(families), np.array([-3]), *(np.zeros(len(b[1]), int) for b in more)]})
        mesh.point_tags = {2: ["corner"]}
        mesh.cell_tags = {-1: ["glass"], -2: ["pvb", "second"], -3: ["held"]}
        meshio.med.write(str(path), mesh)
        return path

    @there("h5py")
    def test_groups(self):
        _, hexes = block((2, 1, 1), 1.0)
        path = self.med()
        self.refuse(path, "in parts pvb and second", "--parts")
        data = self.convert(path, "--parts", "glass,pvb")
        self.assertEqual(data.shape(), cells(["glass", "pvb"]))
        self.assertEqual((data.groups["held"], data.groups["corner"], data.groups["second"]),
                         ({int(k) + 1 for k in hexes[0, :4]}, {2, 3}, {int(k) + 1 for k in hexes[1]}))
        self.assertIn("elements that only name nodes: 1 quad", self.summary)
        self.refuse(self.med(families=(-1, 0)), "in no part", "element 2")

    @there("h5py")
    def test_order_of_vtk(self):
        self.assertEqual(self.convert(self.med(order=list(range(8))), "--parts", "glass,pvb").shape(), cells(["glass", "pvb"]))
        self.assertIn("numbered as those of VTK, not of MED", self.summary)

    @there("h5py")
    def test_other_elements_and_broken_files(self):
        _, hexes = block((2, 1, 1), 1.0)
        path = self.med(more=[("tetra", hexes[:1, [0, 1, 3, 4]])])
        self.refuse(path, "tetra elements 4 (--hexes-only")
        self.assertEqual(self.convert(path, "--hexes-only", "--parts", "glass,pvb").shape(), cells(["glass", "pvb"]))
        for text in (path.read_bytes()[:400], b"", b"nonsense\n" * 20):
            broken = self.folder / "broken.med"
            broken.write_bytes(text)
            self.refuse(broken, "meshio cannot read it")

    def test_without_its_library(self):
        with mock.patch.dict(sys.modules, {"h5py": None}):
            self.refuse(self.write("mesh.med", "x"), "files of MED need h5py", "python3-h5py")


if __name__ == "__main__":
    unittest.main()
