"""tools/mesh2data: what it writes, and what it refuses."""

import subprocess
import sys
import unittest

from meshes import Case, SOURCE, TOOL, block, inp, mesh2data, meshio, np, turned

LEFT_FACE = [0, 3, 7, 4]


def two_parts(irregular=0.15):
    """2 x 3 x 2 elements in two layers, glass below pvb, with the quadrilaterals of the face x = 0 and
    the nodes of an edge."""
    points, hexes = block((2, 3, 2), (3.0, 2.0, 1.1), irregular=irregular)
    low = np.array([k % 2 == 0 for k in range(len(hexes))])  # z runs fastest
    return points, hexes[low], hexes[~low], hexes[:6, LEFT_FACE]


class RoundTrip(Case):
    def gmsh(self, version, binary):
        points, glass, pvb, quads = two_parts()
        cells = [("quad", quads), ("hexahedron", glass), ("hexahedron", pvb)]
        tags = [7, 5, 6]
        entity = np.full((len(points), 2), 0)
        entity[:] = (3, 1)
        entity[:2] = (3, 2), (2, 3)  # every entity needs one node in format 4
        path = self.folder / f"mesh{version}{binary}.msh"
        meshio.gmsh.write(str(path), meshio.Mesh(
            points, cells, point_data={"gmsh:dim_tags": entity},
            cell_data={"gmsh:physical": [np.full(len(c), t) for (_, c), t in zip(cells, tags)],
                       "gmsh:geometrical": [np.full(len(c), t) for (_, c), t in zip(cells, [3, 1, 2])]},
            field_data={"glass": np.array([5, 3]), "pvb": np.array([6, 3]), "left": np.array([7, 2])},
            cell_sets={}), version, binary=binary)
        return path

    def abaqus(self):
        points, glass, pvb, quads = two_parts()
        cells = [("hexahedron", glass), ("hexahedron", pvb)]
        n = np.arange(6)
        path = self.folder / "mesh.inp"
        meshio.abaqus.write(str(path), meshio.Mesh(points, cells, point_sets={"left": np.unique(quads)},
                                                   cell_sets={"glass": [n, n[:0]], "pvb": [n[:0], n]}))
        return path

    def check(self, path):
        data = self.convert(path)
        points, glass, pvb, quads = two_parts()
        place = [tuple(x) for x in points.tolist()]
        expected = sorted([("glass", turned([place[n] for n in nodes])) for nodes in glass]
                          + [("pvb", turned([place[n] for n in nodes])) for nodes in pvb])
        self.assertEqual(data.shape(), expected)  # every coordinate to the last bit
        self.assertEqual(len(data.x), len(points))
        self.assertEqual(set(data.groups), {"glass", "pvb", "left"})
        self.assertEqual(data.places("left"), {place[n] for n in quads.ravel()})
        self.assertEqual(data.places("glass"), {place[n] for n in glass.ravel()})
        self.assertEqual(data.places("pvb"), {place[n] for n in pvb.ravel()})
        # a node of both parts has the type of the first
        for node, kind in data.type.items():
            self.assertEqual(kind, 1 if node in data.groups["glass"] else 2)
        # every element has a node that is its part's alone: it comes first
        for element, nodes in data.nodes.items():
            self.assertEqual(data.type[nodes[0]], 1 if data.part[element] == "glass" else 2)
        self.assertEqual(data.header["atom types"], "2")
        for axis, name in enumerate("xyz"):
            self.assertEqual(data.box[name], (points[:, axis].min(), points[:, axis].max()))
        first = (self.folder / "out.data").read_bytes(), (self.folder / "out.data.groups").read_bytes()
        self.convert(path)
        self.assertEqual(first, ((self.folder / "out.data").read_bytes(), (self.folder / "out.data.groups").read_bytes()))

    def test_gmsh_2_text(self):
        self.check(self.gmsh("2.2", False))

    def test_gmsh_2_binary(self):
        self.check(self.gmsh("2.2", True))

    def test_gmsh_4_text(self):
        self.check(self.gmsh("4.1", False))

    def test_gmsh_4_binary(self):
        self.check(self.gmsh("4.1", True))

    def test_abaqus(self):
        self.check(self.abaqus())

    def test_wedges_by_their_ids(self):
        points, glass, _, _ = two_parts()
        for version in "2.2", "4.1":
            for binary in False, True:
                path = self.folder / "wedges.msh"
                # meshio writes one block per entity
                cells = [("hexahedron", glass), ("wedge", glass[:2, [0, 1, 2, 4, 5, 6]]), ("tetra", glass[:1, [0, 1, 2, 4]])]
                meshio.gmsh.write(str(path), meshio.Mesh(points, cells, cell_data={
                    key: [np.full(len(c), k + 1) for k, (_, c) in enumerate(cells)]
                    for key in ("gmsh:physical", "gmsh:geometrical")},
                    point_data={"gmsh:dim_tags": np.array([(3, k % 3 + 1) for k in range(len(points))])}), version, binary=binary)
                self.refuse(path, "wedge elements 7, 8", "tetra elements 9")


GMSH = """$MeshFormat
{version} 0 8
$EndMeshFormat
{names}{entities}$Nodes
{nodes}
$EndNodes
$Elements
{elements}
$EndElements
"""


class Gmsh(Case):
    """Files as Gmsh writes them: numbers with gaps, elements of lower dimensions."""

    def old(self, elements, names='2\n3 5 "glass"\n2 7 "the left"'):
        nodes = "\n".join(f"{10 * k + 3} {x[0]} {x[1]} {x[2]}" for k, x in enumerate(block((2, 1, 1), 1.0)[0]))
        rows = "\n".join(elements)
        return self.write("old.msh", GMSH.format(version="2.2", entities="", nodes=f"12\n{nodes}",
                                                 names=f"$PhysicalNames\n{names}\n$EndPhysicalNames\n" if names else "",
                                                 elements=f"{len(elements)}\n{rows}"))

    @staticmethod
    def row(number, kind, physical, nodes):
        return f"{number} {kind} 2 {physical} 1 " + " ".join(str(10 * n + 3) for n in nodes)

    def test_numbers_with_gaps(self):
        hexes = block((2, 1, 1), 1.0)[1]
        data = self.convert(self.old([self.row(4, 3, 7, hexes[0][LEFT_FACE]), self.row(90, 5, 5, hexes[0]),
                                      self.row(70, 5, 5, hexes[1])]))
        self.assertEqual(sorted(data.nodes), [1, 2])
        self.assertEqual(data.places("the_left"), {(0, y, z) for y in (0, 1) for z in (0, 1)})
        self.assertIn("set 'the left' is written as the_left", self.summary)
        self.assertIn("1 quad", self.summary)
        data = self.convert(self.folder / "old.msh", "--keep-ids", "--node-offset", 1000, "--element-offset", 500)
        self.assertEqual(sorted(data.nodes), [570, 590])
        self.assertEqual(sorted(data.x), [10 * k + 1003 for k in range(12)])
        self.assertEqual(data.groups["the_left"], {1003, 1013, 1023, 1033})
        self.assertEqual([data.x[n] for n in data.nodes[590]], [tuple(x) for x in block((2, 1, 1), 1.0)[0][hexes[0]].tolist()])

    def test_turned_is_no_mirror(self):
        nodes = [tuple(x) for x in block((1, 1, 1), 1.0, irregular=0.1)[0].tolist()]
        hexes = block((1, 1, 1), 1.0)[1][0]
        nodes = [nodes[n] for n in hexes]
        self.assertEqual(turned(nodes), turned([nodes[k] for k in (1, 2, 3, 0, 5, 6, 7, 4)]))
        self.assertEqual(turned(nodes), turned([nodes[k] for k in (3, 2, 6, 7, 0, 1, 5, 4)]))
        self.assertNotEqual(turned(nodes), turned([nodes[k] for k in (4, 5, 6, 7, 0, 1, 2, 3)]))

    def test_group_without_a_name(self):
        hexes = block((2, 1, 1), 1.0)[1]
        data = self.convert(self.old([self.row(1, 5, 5, hexes[0]), self.row(2, 5, 8, hexes[1])]))
        self.assertEqual(data.part, {1: "glass", 2: "volume_8"})

    def test_no_group(self):
        hexes = block((2, 1, 1), 1.0)[1]
        path = self.old([self.row(7, 5, 5, hexes[0]), self.row(13, 5, 0, hexes[1])])
        self.refuse(path, "in no part", "element 13;", "--default-part")
        self.assertEqual(self.convert(path, "--default-part", "rest").part, {1: "glass", 2: "rest"})
        path = self.old([self.row(7, 5, 0, hexes[0]), self.row(13, 5, 0, hexes[1])], names="")
        self.refuse(path, "elements 7, 13")
        self.assertEqual(self.convert(path, "--default-part", "all_of_it").part, {1: "all_of_it", 2: "all_of_it"})

    def test_a_name_for_two_dimensions(self):
        hexes = block((2, 1, 1), 1.0)[1]
        path = self.old([self.row(1, 5, 5, hexes[0])], names='2\n2 7 "glass"\n3 5 "glass"')
        self.refuse(path, "'glass'", "surface", "volume", "different names")

    def test_element_in_two_groups(self):
        hexes = block((2, 1, 1), 1.0)[1]  # format 2 writes it twice
        path = self.old([self.row(4, 5, 5, hexes[0]), self.row(5, 5, 6, hexes[0]), self.row(6, 5, 6, hexes[1])])
        self.refuse(path, "element 4 in parts glass and volume_6", "--parts")
        data = self.convert(path, "--parts", "volume_6", "--keep-ids")
        self.assertEqual(data.part, {4: "volume_6", 6: "volume_6"})
        self.assertEqual(data.places("glass"), {tuple(x) for x in block((2, 1, 1), 1.0)[0][hexes[0]].tolist()})
        # that is another thing than two elements in one group
        path = self.old([self.row(4, 5, 5, hexes[0]), self.row(5, 5, 5, hexes[0]), self.row(6, 5, 6, hexes[1])])
        self.refuse(path, "elements 4, 5 have the same nodes")

    def test_a_name_like_that_of_a_group_without(self):
        hexes = block((2, 1, 1), 1.0)[1]
        path = self.old([self.row(4, 5, 5, hexes[0]), self.row(5, 5, 6, hexes[1])], names='2\n3 5 "volume_6"\n2 7 ""')
        self.refuse(path, "physical volume 6 has no name", "volume_6")
        path = self.old([self.row(4, 5, 5, hexes[0]), self.row(5, 5, 5, hexes[1]), self.row(6, 3, 7, hexes[0][LEFT_FACE])],
                        names='2\n3 5 ""\n2 7 ""')
        self.assertEqual(set(self.convert(path).groups), {"volume_5", "surface_7"})

    def test_missing_node(self):
        hexes = block((2, 1, 1), 1.0)[1]
        self.refuse(self.old([self.row(4, 5, 5, hexes[0]), self.row(5, 5, 5, [0, 1, 2, 3, 4, 5, 6, 6.1])]).rename(
            self.folder / "bad.msh"), "cannot be read")
        text = self.old([self.row(4, 5, 5, hexes[0])]).read_text().replace("\n33 ", "\n34 ")
        self.refuse(self.write("gap.msh", text), "nodes are missing of element 4")

    def test_no_file_of_gmsh(self):
        self.refuse(self.write("text.msh", "hello\n"), "$MeshFormat")
        self.refuse(self.write("empty.msh", ""), "$MeshFormat")
        hexes = block((2, 1, 1), 1.0)[1]
        text = self.old([self.row(4, 5, 5, hexes[0])]).read_text()
        self.refuse(self.write("half.msh", text[:len(text) // 2]), "cannot be read")
        self.refuse(self.write("names.msh", text.replace("Names\n2\n", "Names\n3\n")), "$PhysicalNames", "names than it says")
        self.refuse(self.write("v4.msh", text.replace("2.2 0 8", "4 0 8")), "format 4 ", "MshFileVersion")

    def test_format_4_with_elements_in_no_group(self):
        points, hexes = block((2, 1, 1), 1.0)
        nodes = "\n".join(["1 12 1 12", "3 1 0 12", *map(str, range(1, 13)), *(f"{x[0]} {x[1]} {x[2]}" for x in points)])
        rows = "\n".join(["2 2 1 2"] + [f"3 {k + 1} 5 1\n{k + 1} " + " ".join(str(n + 1) for n in h)
                                        for k, h in enumerate(hexes)])
        entities = "$Entities\n0 0 0 2\n1 0 0 0 1 1 1 1 5 0\n2 1 0 0 2 1 1 {}0\n$EndEntities\n"
        names = '$PhysicalNames\n1\n3 5 "glass"\n$EndPhysicalNames\n'
        for physical, good in (("1 5 ", True), ("0 ", False)):
            path = self.write("new.msh", GMSH.format(version="4.1", names=names, entities=entities.format(physical),
                                                     nodes=nodes, elements=rows))
            if good:
                self.assertEqual(self.convert(path).part, {1: "glass", 2: "glass"})
            else:
                self.refuse(path, "in no part", "element 2;")
                self.assertEqual(self.convert(path, "--default-part", "rest").part, {1: "glass", 2: "rest"})


class Abaqus(Case):
    """What meshio's own reader gets wrong, and the rest of the language; parts and instances are in test_mesh_inputs.py."""

    def test_one_set_in_two_blocks(self):
        points, hexes = block((5, 1, 1), 1.0)
        data = self.convert(self.write("a.inp", inp(points, [("GLASS", hexes[:3]), ("pvb", hexes[3:4]), ("Glass", hexes[4:])])))
        self.assertEqual(data.part, {1: "GLASS", 2: "GLASS", 3: "GLASS", 4: "pvb", 5: "GLASS"})

    def test_comments_continued_lines_and_several_node_blocks(self):
        points, hexes = block((2, 1, 1), 1.0, irregular=0.1)
        text = inp(points, [("glass", hexes)])
        expected = self.convert(self.write("plain.inp", text)).shape()
        lines = text.splitlines()
        lines[6:6] = ["** a comment", "*NODE, NSET=later"]
        at = next(k for k, line in enumerate(lines) if line.startswith("*ELEMENT"))
        lines[at] = "*Element,\n type = c3d8r ,\n elset = glass"
        words = lines[at + 1].split(",")
        lines[at + 1] = ",".join(words[:4]) + ",\n** in the middle\n" + ",".join(words[4:])
        data = self.convert(self.write("odd.inp", "\n".join(lines) + "\n"))
        self.assertEqual(data.shape(), expected)
        self.assertEqual(len(data.groups["later"]), 8)

    def test_sets_of_sets_and_generate(self):
        points, hexes = block((4, 1, 1), 1.0)
        extra = ("*ELSET, ELSET=ends\n1, 4\n*ELSET, ELSET=middle, GENERATE\n2, 3, 1\n*ELSET, ELSET=everything\nENDS, middle\n"
                 "*NSET, NSET=odd, GENERATE\n1, 19, 2\n*NSET, NSET=few\n1, 2,\n3\n*NSET, NSET=both\nodd\nfew, 20\n"
                 "*NSET, NSET=of_ends, ELSET=ends\n*NSET, NSET=_hidden, INTERNAL\n5\n")
        path = self.write("sets.inp", inp(points, [(None, hexes)], extra))
        self.refuse(path, "elements 1, 4 in", "ends", "everything", "--parts")
        data = self.convert(path, "--parts", "middle,ends")
        self.assertEqual(data.part, {1: "ends", 2: "middle", 3: "middle", 4: "ends"})
        self.assertEqual(data.groups["odd"], set(range(1, 20, 2)))
        self.assertEqual(data.groups["both"], set(range(1, 20, 2)) | {2, 20})
        self.assertEqual(data.groups["of_ends"], set(range(1, 9)) | set(range(13, 21)))
        self.assertEqual(data.groups["everything"], set(range(1, 21)))
        self.assertNotIn("_hidden", data.groups)
        # middle comes first: the nodes it shares have its type
        self.assertEqual({n for n, t in data.type.items() if t == 1}, data.groups["middle"])

    def test_sections_name_the_parts(self):
        points, hexes = block((2, 1, 1), 1.0)
        extra = ("*ELSET, ELSET=a\n1\n*ELSET, ELSET=b\n2\n*ELSET, ELSET=loaded\n1, 2\n"
                 "*SOLID SECTION, ELSET=a, MATERIAL=m\n,\n*SOLID SECTION, ELSET=b, MATERIAL=n\n")
        data = self.convert(self.write("sections.inp", inp(points, [(None, hexes)], extra)))
        self.assertEqual(data.part, {1: "a", 2: "b"})
        self.assertEqual(data.groups["loaded"], set(range(1, 13)))

    def test_shells_give_node_sets(self):
        points, hexes = block((1, 1, 1), 1.0)
        extra = "*ELEMENT, TYPE=S4R, ELSET=skin\n10, 1, 2, 4, 3\n*ELEMENT, TYPE=T3D2, ELSET=wire\n11, 1, 5\n"
        data = self.convert(self.write("shells.inp", inp(points, [("glass", hexes)], extra)))
        self.assertEqual(data.groups["skin"], {1, 2, 3, 4})
        self.assertEqual(data.groups["wire"], {1, 5})
        self.assertEqual(len(data.nodes), 1)

    def test_include(self):
        points, hexes = block((1, 1, 1), 1.0)
        head, tail = inp(points, [("glass", hexes)]).split("*ELEMENT")
        self.write("nodes.txt", head)
        data = self.convert(self.write("top.inp", "*INCLUDE, INPUT=nodes.txt\n*ELEMENT" + tail))
        self.assertEqual(len(data.x), 8)
        self.refuse(self.write("none.inp", "*INCLUDE, INPUT=elsewhere.txt\n"), "elsewhere.txt")

    def test_refused(self):
        points, hexes = block((2, 1, 1), 1.0)
        good = inp(points, [("glass", hexes)], first_element=40)
        for change, words in (
                (lambda t: t.replace("C3D8", "C3D8X9"), ["C3D8X9"]),
                (lambda t: t.replace("C3D8", "COH3D8"), ["COH3D8", "not known"]),
                (lambda t: t + "*ELEMENT, TYPE=C3D6\n77, 1, 2, 3, 4, 5, 6\n78, 1, 2, 3, 4, 5, 7\n", ["wedge elements 77, 78"]),
                (lambda t: t + "*ELEMENT, TYPE=C3D4\n5, 1, 2, 3, 4\n", ["tetra elements 5"]),
                (lambda t: t + "*ELEMENT, TYPE=C3D5\n6, 1, 2, 3, 4, 5\n", ["pyramid elements 6"]),
                (lambda t: t + "*ELEMENT, TYPE=C3D20R\n7, 1,2,3,4,5,6,7,8,9,10,11,12,1,2,3,\n4,5,6,7,8\n", ["hexahedron20 elements 7"]),
                (lambda t: t.replace("40, 1,", "40, 99,"), ["element 40", "no node 99"]),
                (lambda t: t.replace("41, ", "41, 1, "), ["element 41", "more than 8"]),
                (lambda t: t + "*ELEMENT, TYPE=C3D8\n50, 1, 2, 3\n", ["element 50", "has 3 nodes, not 8"]),
                (lambda t: t + "*ELEMENT, TYPE=C3D8\n40, 8,7,6,5,4,3,2,1\n", ["element 40 is defined twice"]),
                (lambda t: t + "*NODE\n3, 5.0, 5.0, 5.0\n", ["node 3 is defined twice"]),
                (lambda t: t.replace("*NODE", "*NODE, SYSTEM=C"), ["rectangular"]),
                (lambda t: t + "*NGEN\n1, 5\n", ["*NGEN"]),
                (lambda t: "*PART, NAME=a\n" + t + "*PART, NAME=b\n", ["*PART b begins before a ends"]),
                (lambda t: "*PART, NAME=a\n" + t, ["a does not end"]),
                (lambda t: t + "*INSTANCE, NAME=i, PART=a\n0., 0., 5.\n", ["*INSTANCE", "no part 'a'"]),
                (lambda t: t + "*NSET, NSET=s, INSTANCE=i\n1\n", ["no instance 'I'"]),
                (lambda t: t + "*NSET\n1\n", ["*NSET", "no name"]),
                (lambda t: t + "*ELSET, ELSET=\n40\n", ["*ELSET", "no name"]),
                (lambda t: t + "*NSET, NSET=s, GENERATE\n1, 2000000000\n", ["node set 's'", "13, 14", "1999999988 in all"]),
                (lambda t: t + "*NSET, NSET=s, GENERATE\n1, 2, 0\n", ["GENERATE needs"]),
                (lambda t: t + "*NSET, NSET=a\nb\n*NSET, NSET=b\na\n", ["in each other"]),
                (lambda t: t.replace("TYPE=C3D8", "TYPE=C3D8, OFFSET=3"), ["*ELEMENT", "OFFSET", "not supported"]),
                (lambda t: "1, 2, 3\n" + t, ["'1, 2, 3' stands before the first keyword"]),
                (lambda t: t + "*ELEMENTS, TYPE=C3D8\n", ["*ELEMENTS is not known", "*ELEMENT meant"]),
                (lambda t: t.replace("TYPE=C3D8", "TYPE=C3D8, TYPE=C3D8R"), ["*ELEMENT", "TYPE is given twice"]),
                (lambda t: t + "*IMPERFECTION, FILE=f\n", ["*IMPERFECTION"]),
                (lambda t: t + "*SOLID SECTION, ELSET=s, MATERIAL=m\n", ["no element set 's'"]),
                (lambda t: t + "*NSET, NSET=s\n1, 200\n", ["node set 's'", "no node 200"]),
                (lambda t: t + "*ELSET, ELSET=s\n40, 200\n", ["element set 's'", "no element 200"]),
                (lambda t: t + "*NSET, NSET=s, ELSET=later\n", ["no element set 'later'"]),
                (lambda t: t + "*NSET, NSET=s\nother\n", ["node set 's'", "set 'other'"]),
                (lambda t: t.replace("*NODE\n1,", "*NODE\nx,"), ["'x' is not a number"]),
                (lambda t: t.replace("*NODE\n1, 0.0", "*NODE\n1, nan"), ["not finite", "element 40"]),
                (lambda t: t.replace("*NODE\n1, 0.0", "*NODE\n1, 1e200"), ["above 1e100", "element 40"]),
                (lambda t: t.replace("*NODE\n1, 0.0", "*NODE\n1, 1_0"), ["'1_0' is not a number"]),
                (lambda t: t.split("*ELEMENT")[0], ["no hexahedra"]),
                (lambda t: "", ["no hexahedra"])):
            text = change(good)
            self.assertNotEqual(text, good)
            with self.subTest(words=words):
                self.refuse(self.write("bad.inp", text), "bad.inp", *words)
        self.convert(self.write("good.inp", good))


class Checks(Case):
    def test_orphans(self):
        points, hexes = block((2, 1, 1), 1.0)
        more = np.vstack([points[:4], [[9.0, 9, 9]], points[4:], [[8.0, 8, 8]]])
        hexes = hexes + (hexes >= 4)
        path = self.write("orphans.inp", inp(more, [("glass", hexes)], "*NSET, NSET=s\n4, 5, 6\n"))
        self.refuse(path, "2 orphan nodes", "5, 14", "--drop-orphans")
        data = self.convert(path, "--drop-orphans")
        self.assertEqual(list(data.x.values()), [tuple(x) for x in points.tolist()])
        self.assertEqual(data.places("s"), {tuple(x) for x in points[3:5].tolist()})
        self.assertIn("2 orphan nodes left out: 5, 14", self.summary)
        data = self.convert(path, "--drop-orphans", "--keep-ids")
        self.assertEqual(sorted(data.x), [1, 2, 3, 4, *range(6, 14)])
        many = np.vstack([points, np.random.default_rng(2).uniform(0, 1, (25, 3))])
        self.refuse(self.write("many.inp", inp(many, [("glass", block((2, 1, 1), 1.0)[1])])),
                    "25 orphan nodes", "13, 14, 15, 16, 17, 18, 19, 20, 21, 22 ... (25 in all)")

    def test_orientation(self):
        points, hexes = block((3, 1, 1), 1.0, irregular=0.1)
        bad = hexes.copy()
        bad[1] = bad[1][[4, 5, 6, 7, 0, 1, 2, 3]]
        path = self.write("inverted.inp", inp(points, [("glass", bad)], first_element=7))
        self.refuse(path, "element 8;", "--fix-orientation")
        fixed = self.convert(path, "--fix-orientation").shape()
        self.assertEqual(fixed, self.convert(self.write("good.inp", inp(points, [("glass", hexes)]))).shape())
        # two nodes changed places: neither inside out nor valid
        bad = hexes.copy()
        bad[2][[0, 1]] = bad[2][[1, 0]]
        path = self.write("tangled.inp", inp(points, [("glass", bad)], first_element=7))
        self.refuse(path, "distorted", "element 9")
        self.refuse(path, "element 9", options=["--fix-orientation"])

    def test_flat(self):
        points, hexes = block((1, 1, 1), (1.0, 1.0, 1e-9))
        self.refuse(self.write("flat.inp", inp(points, [("glass", hexes)], first_element=3)), "no volume: element 3")
        points, hexes = block((1, 1, 1), 1.0)
        hexes[0][7] = hexes[0][6]
        self.refuse(self.write("wedge.inp", inp(np.delete(points, 3, axis=0), [("glass", hexes - (hexes > 3))], first_element=3)),
                    "a node is twice in element 3")

    def test_bad_corner_is_only_a_note(self):
        points, hexes = block((1, 1, 1), 1.0)
        points[7] = [0.6, 0.6, 0.6]  # the corner at (1, 1, 1) pushed in
        data = self.convert(self.write("corner.inp", inp(points, [("glass", hexes)], first_element=3)))
        self.assertEqual(len(data.nodes), 1)
        self.assertIn("not positive at a corner", self.summary)
        self.assertIn("element 3", self.summary)

    def test_three_at_one_face(self):
        points, hexes = block((2, 1, 1), 1.0)
        points = np.vstack([points, points[-4:] + [1.0, 0.3, 0]])
        third = hexes[1].copy()
        third[[1, 2, 6, 5]] = [12, 14, 15, 13]
        self.refuse(self.write("three.inp", inp(points, [("glass", [*hexes, third])], first_element=20)),
                    "elements 20, 21, 22 share one face")

    def test_same_element_twice(self):
        points, hexes = block((1, 1, 1), 1.0)
        self.refuse(self.write("twice.inp", inp(points, [("glass", [*hexes, *hexes])])), "elements 1, 2 have the same nodes")


class Options(Case):
    def two_bodies(self, gap):
        a, hexes = block((2, 1, 1), 1.0)
        b, _ = block((2, 1, 1), 1.0, origin=(0, 0, 1 + gap))
        return self.write("bodies.inp", inp(np.vstack([a, b]), [("low", hexes), ("high", hexes + len(a))],
                                            "*NSET, NSET=all_low\n" + ", ".join(map(str, range(1, 13))) + "\n"
                                            "*NSET, NSET=bottom_of_high\n13, 15, 17, 19, 21, 23\n"))

    def test_merge(self):
        path = self.two_bodies(1e-4)
        self.assertEqual(len(self.convert(path).x), 24)
        self.assertEqual(len(self.convert(path, "--merge", 9e-5).x), 24)
        data = self.convert(path, "--merge", 2e-4)
        self.assertEqual(len(data.x), 18)
        self.assertIn("6 nodes merged", self.summary)
        self.assertEqual(data.groups["low"] & data.groups["high"], data.groups["bottom_of_high"])
        self.assertEqual(data.places("bottom_of_high"), {(x, y, 1.0) for x in (0, 1, 2) for y in (0, 1)})
        self.refuse(path, "joins nodes of elements 1, 2", options=["--merge", 1.5])
        # the tolerance is meant in the units of the data file
        self.assertEqual(len(self.convert(path, "--scale", 1e-3, "--merge", 2e-7).x), 18)

    def test_close_pairs(self):
        points = np.random.default_rng(3).uniform(-1, 1, (400, 3))
        distance = np.linalg.norm(points[:, None] - points[None], axis=2)
        for tolerance in 0.06, 0.1, 0.3:
            expected = [(i, j) for i, j in zip(*np.nonzero(distance <= tolerance)) if i < j]
            self.assertGreater(len(expected), 0)
            self.assertEqual([tuple(pair) for pair in mesh2data.close_pairs(points, tolerance)], expected)

    def test_touching_parts_are_told(self):
        self.convert(self.two_bodies(0.0))
        self.assertIn("6 pairs of nodes at one place", self.summary)
        self.convert(self.two_bodies(0.1))
        self.assertNotIn("at one place", self.summary)

    def test_scale(self):
        points, hexes = block((2, 2, 1), (3.0, 2.0, 1.1), irregular=0.2)
        path = self.write("mm.inp", inp(points, [("glass", hexes)]))
        data = self.convert(path, "--scale", "1e-3")
        self.assertEqual(list(data.x.values()), [tuple(x) for x in (1e-3 * points).tolist()])
        self.assertAlmostEqual(data.box["x"][1], 1e-3 * points[:, 0].max(), places=18)

    def test_summary_volumes(self):
        points, hexes = block((2, 3, 4), (1.0, 2.0, 3.0))
        self.convert(self.write("box.inp", inp(points, [("a", hexes[:12]), ("b", hexes[12:])])))
        self.assertIn("24 hexahedra, 60 nodes, volume 144", self.summary)
        self.assertIn("part a: 12 elements, 40 nodes, volume 72, atom type 1", self.summary)
        self.assertIn("edges from 1 to 3, scaled Jacobian 1.0000 at worst", self.summary)
        self.assertIn("52 outer faces", self.summary)

    def test_rename_types_and_sets(self):
        path = self.two_bodies(0.5)
        data = self.convert(path, "--rename", "low=glass", "--rename", "bottom_of_high=face", "--type", "glass=3", "--type", "high=1")
        self.assertEqual(set(data.part.values()), {"glass", "high"})
        self.assertEqual(set(data.groups), {"glass", "high", "all_low", "face"})
        self.assertEqual([data.type[1], data.type[24], data.header["atom types"]], [3, 1, "3"])
        data = self.convert(path, "--rename", "low=body", "--rename", "high=body")
        self.assertEqual(set(data.part.values()), {"body"})
        self.assertEqual(set(self.convert(path, "--sets", "low,bottom_of_high").groups), {"low", "bottom_of_high"})
        self.convert(path, "--sets", "none")
        self.assertIn("out.data.groups was there before, and is not of this mesh", self.summary)
        (self.folder / "out.data.groups").unlink()
        self.convert(path, "--sets", "none")
        self.assertFalse((self.folder / "out.data.groups").exists())
        self.convert(path, "--groups", self.folder / "g.inc")
        self.assertIn("group low id 1:12\n", (self.folder / "g.inc").read_text())
        self.refuse(path, "no set or part x", "low, high", options=["--sets", "x"])
        self.refuse(path, "no part x", options=["--type", "x=2"])
        self.refuse(path, "no hexahedra in a set 'x'", "low, high", options=["--parts", "x"])
        self.refuse(path, "two different sets", "low", options=["--rename", "bottom_of_high=low"])

    def test_a_part_and_a_set_of_one_name(self):
        points, hexes = block((1, 1, 1), 1.0)
        path = self.write("one_name.inp", inp(points, [("glass", hexes)], "*NSET, NSET=glass\n1, 2\n"))
        self.refuse(path, "two different sets", "--rename 'set:glass=OTHER'")
        self.assertEqual(self.convert(path, "--rename", "set:glass=held").groups, {"glass": set(range(1, 9)), "held": {1, 2}})
        self.assertEqual(self.convert(path, "--rename", "part:glass=pane").groups, {"pane": set(range(1, 9)), "glass": {1, 2}})

    def test_a_set_without_nodes_is_told(self):
        points, hexes = block((1, 1, 1), 1.0)
        self.convert(self.write("empty.inp", inp(points, [("glass", hexes)], "*NSET, NSET=rim\n")))
        self.assertIn("note: set rim is empty", self.summary)

    def test_numbers_for_a_second_mesh(self):
        data = self.convert(self.two_bodies(0.5), "--node-offset", 100, "--element-offset", 50)
        self.assertEqual(sorted(data.x), list(range(101, 125)))
        self.assertEqual(sorted(data.nodes), [51, 52, 53, 54])
        self.assertEqual(data.groups["low"], set(range(101, 113)))
        self.assertIn("add merge", self.summary)

    def test_names_that_lammps_cannot_have(self):
        points, hexes = block((3, 1, 1), 1.0)
        extra = "*NSET, NSET=all\n1\n*NSET, NSET=7\n1, 2\n*NSET, NSET=Set-1\n3\n"
        data = self.convert(self.write("names.inp", inp(points, [("12", hexes[:1]), ("a.b", hexes[1:])], extra)))
        self.assertEqual(data.part, {1: "part_12", 2: "a_b", 3: "a_b"})
        self.assertEqual(set(data.groups), {"part_12", "a_b", "set_7", "Set_1"})
        self.refuse(self.write("long.inp", inp(points, [("n" * 81, hexes)])), "has 81 characters, at most 80")
        self.assertEqual(self.convert(self.write("long.inp", inp(points, [("n" * 80, hexes)]))).groups, {"n" * 80: set(range(1, 17))})
        self.refuse(self.write("clash.inp", inp(points, [("a-b", hexes[:1]), ("a.b", hexes[1:])])), "'a-b' and 'a.b'", "a_b", "--rename")

    def test_too_many_groups(self):
        points, hexes = block((1, 1, 1), 1.0)
        for n in 30, 31:
            text = inp(points, [("glass", hexes)], "".join(f"*NSET, NSET=s{k}\n1\n" for k in range(n)))
            path = self.write("many.inp", text)
            if n == 30:
                self.assertEqual(len(self.convert(path).groups), 31)
        self.refuse(path, "32 sets and parts", "31 groups", "--sets")

    def test_long_sets_are_split(self):
        points, hexes = block((20, 20, 1), 1.0)
        path = self.write("long.inp", inp(points, [("glass", hexes)], "*NSET, NSET=odd, GENERATE\n1, 881, 2\n"))
        self.assertEqual(self.convert(path).groups["odd"], set(range(1, 882, 2)))
        self.assertGreater((self.folder / "out.data.groups").read_text().count("group odd id"), 10)

    def test_command_line(self):
        path = self.two_bodies(0.5)
        for options, word in ((["--scale", "0"], "positive"), (["--scale", "nan"], "positive"), (["--merge", "-1"], "positive"),
                              (["--type", "low"], "PART=TYPE"), (["--type", "low=0"], "positive integer"),
                              (["--node-offset", "-3"], "from 0 to"), (["--node-offset", "1_0"], "from 0 to"),
                              (["--element-offset", "2147483646"], "above 2147483647"), (["--type", "low=2147483648"], "positive integer"),
                              (["--type", "low=1", "--type", "low=2"], "twice"), (["--rename", "lower=a"], "no set or part 'lower'"),
                               (["--colour"], "--colour")):
            with self.subTest(options=options):
                self.refuse(path, word, options=options)
        self.refuse(self.folder / "absent.inp", "no such file")
        self.refuse(self.write("mesh.stl", ""), ".msh", ".inp")
        result = self.run_tool(path, out="no/folder.data")
        self.assertEqual((result.returncode, result.stderr.count("\n")), (2, 1))
        self.assertIn("no folder", result.stderr)
        result = self.run_tool(path, out=path.name)
        self.assertEqual((result.returncode, result.stderr.count("\n")), (2, 1))
        self.assertIn("overwritten", result.stderr)

    def test_the_program(self):
        path = self.two_bodies(0.5)
        run = subprocess.run([TOOL, path, self.folder / "by.data"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        self.convert(path)
        self.assertEqual((self.folder / "by.data").read_bytes(), (self.folder / "out.data").read_bytes())
        run = subprocess.run([TOOL, self.folder / "no.inp", self.folder / "no.data"], stderr=subprocess.PIPE, text=True)
        self.assertEqual((run.returncode, run.stderr.count("\n")), (2, 1))

    def test_another_python_comes_first(self):
        # One without meshio: the program goes on with Debian's.
        (self.folder / "bare").symlink_to(sys.executable)
        bare = self.write("python3", f"#!/bin/sh\nexec {self.folder}/bare -S \"$@\"\n")
        bare.chmod(0o755)
        run = subprocess.run([TOOL, "--help"], env={"PATH": f"{self.folder}:/usr/bin:/bin"}, stdout=subprocess.PIPE,
                             stderr=subprocess.PIPE, text=True)
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        self.assertIn("usage: mesh2data", run.stdout)

    def test_help_names_every_option(self):
        text = self.run_tool("--help").stdout
        for option in ("groups", "scale", "parts", "default-part", "rename", "type", "sets", "merge", "drop-orphans",
                       "fix-orientation", "keep-ids", "node-offset", "element-offset"):
            self.assertIn("--" + option, text)


class Pane(Case):
    """Gmsh itself, by examples/curved_pane/mesh.py: its mesh is another one on another processor, so nothing here asks
    for more of it than a range. What depends on the mesh takes one of tests/meshes. Starting Gmsh and meshing is
    nearly all of this file's 10 s of processor time."""

    def pane(self, name, *options):
        path = self.folder / name
        subprocess.run([str(SOURCE / "examples/curved_pane/mesh.py"), str(path), *map(str, options)], check=True,
                       stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
        return path

    def volumes(self):
        return {line.split()[1].rstrip(":"): float(line.split("volume ")[1].split(",")[0])
                for line in self.summary.splitlines() if line.startswith("  part")}

    def test_volumes_and_sets(self):
        # A cylinder: a fibre at depth w below the outside is shorter by w/R, and the chord of a facet than
        # its arc by (length/R)^2/24: with its diagonal at most.
        size, t, radius = 4, (2.1, 0.76, 2.1), 400.0
        flat = self.convert(self.pane("flat.msh", "--radius-x", 0, "--radius-y", 0, "--size", size))
        flat_volumes = self.volumes()
        area = sum(flat_volumes.values()) / sum(t)
        # the trapezium with its corners of radius 15 mm rounded off; the mesh has straight edges there
        lean = np.arctan2(12.5, 100)
        corners = sum(15**2 * (1 / np.tan(a / 2) - (np.pi - a) / 2) for a in (np.pi / 2 - lean, np.pi / 2 + lean) * 2)
        self.assertAlmostEqual(area / (0.5 * (110 + 85) * 100 - corners), 1.0, delta=1e-3)
        bent = self.convert(self.pane("bent.msh", "--radius-x", radius, "--radius-y", 0, "--size", size))
        depth = 0.0
        for name, thickness in zip(("outer", "pvb", "inner"), t):
            self.assertAlmostEqual(flat_volumes[name] / (area * thickness), 1.0, delta=1e-8)
            expected = 1 - (depth + thickness / 2) / radius
            longest = np.sqrt(2) * float(self.summary.split("edges from ")[1].split()[2].rstrip(","))
            self.assertAlmostEqual(self.volumes()[name] / flat_volumes[name] / expected, 1.0,
                                   delta=(longest / radius)**2 / 24)
            depth += thickness
        for data in flat, bent:
            self.assertEqual(set(data.groups), {"outer", "pvb", "inner", "outer_face", "inner_face", "edge", "inner_rim"})
            self.assertEqual(data.groups["inner_rim"], data.groups["inner_face"] & data.groups["edge"])
            self.assertEqual(len(data.groups["edge"]), 6 * len(data.groups["inner_rim"]))  # five layers
            self.assertEqual(len(data.groups["outer"] & data.groups["pvb"]), len(data.groups["inner_face"]))
        self.assertEqual({z for _, _, z in flat.places("outer_face")}, {0.0})

    def test_flat_disc(self):
        data = self.convert(self.pane("disc.msh", "--outline", "disc", "--width", 60, "--radius-x", 0, "--radius-y", 0, "--size", 3,
                                      "--thickness", 3, 1, 2, "--layers", 3, 1, 1))
        self.assertEqual({z for _, _, z in data.x.values()}, {0.0, -1.0, -2.0, -3.0, -4.0, -6.0})
        x, y, _ = np.array(sorted(data.places("edge"))).T
        self.assertLess(abs(np.hypot(x, y) - 30).max(), 1e-10)
        n = len(data.groups["inner_rim"])  # the rim is a polygon of n sides, nearly a regular one
        for name, thickness in (("outer", 3), ("pvb", 1), ("inner", 2)):
            self.assertAlmostEqual(self.volumes()[name] / (thickness * n / 2 * 30**2 * np.sin(2 * np.pi / n)), 1.0, delta=1e-4)

    def check_counts(self, data, least, most):
        """Hexahedra of the layers of two, one and two elements; `least` to `most` in one of them."""
        count = [sum(part == name for part in data.part.values()) for name in ("outer", "pvb", "inner")]
        self.assertEqual(count, [2 * count[1], count[1], 2 * count[1]])
        self.assertTrue(least <= count[1] <= most, count)

    def test_fine_middle(self):
        data = self.convert(self.pane("disc.msh", "--outline", "disc", "--width", 80, "--size", 5, "--size-middle", 2, "--reach", 10))
        self.check_counts(data, 320, 520)  # 201, if all were of 5 mm

    def test_curvature_and_quality(self):
        data = self.convert(self.pane("pane.msh", "--size", 4))
        self.check_counts(data, 520, 700)  # 638 and 639 have been seen; 600 squares of 4 mm
        quality = float(self.summary.split("scaled Jacobian ")[1].split()[0])
        self.assertGreater(quality, 0.5)
        # The outside is the torus of radii 400 and 250 mm, the inside 4.96 mm below it.
        for group, depth in (("outer_face", 0.0), ("inner_face", 4.96)):
            x, y, z = np.array(sorted(data.places(group))).T
            swept = np.hypot(x, z + 400) - (400 - 250)
            self.assertLess(abs(np.hypot(swept, y) - (250 - depth)).max(), 1e-10)
        again = self.pane("again.msh", "--size", 4)
        self.assertEqual(again.read_bytes(), (self.folder / "pane.msh").read_bytes())


if __name__ == "__main__":
    unittest.main()
