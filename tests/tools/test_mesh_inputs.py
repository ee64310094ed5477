"""tools/mesh2data: files that were once refused or read wrongly, those of inputs/ and what Gmsh itself writes."""

import json
import re
import subprocess
import sys
import unittest

from meshes import Case, SOURCE, block, inp, np, turned

INPUTS = SOURCE / "tests" / "tools" / "inputs"


def cells(n, size, part):
    """What Data.shape() is for a block of elements."""
    points, hexes = block(n, size)
    places = [tuple(x) for x in points.tolist()]
    return sorted((part, turned([places[k] for k in nodes])) for nodes in hexes)


class Inputs(Case):
    def groups(self, data):
        return {name: sorted(nodes) for name, nodes in data.groups.items()}

    def test_sections_of_internal_sets(self):
        data = self.convert(INPUTS / "cae_internal_sections.inp")
        self.assertEqual(data.part, {1: "_PickedSet3", 2: "_PickedSet4"})
        self.assertIn("part _PickedSet4 is of the material PVB", self.summary)
        data = self.convert(INPUTS / "cae_internal_sections.inp", "--rename", "_PickedSet3=glass", "--rename", "_PickedSet4=pvb")
        self.assertEqual(self.groups(data), {"glass": [1, 2, 4, 5, 7, 8, 10, 11], "pvb": [2, 3, 5, 6, 8, 9, 11, 12]})

    def test_node_set_and_element_set_of_a_face(self):
        data = self.convert(INPUTS / "cae_set_of_face.inp")
        self.assertEqual(self.groups(data), {"GLASS": list(range(1, 13)), "Support": [1, 4, 7, 10]})
        self.assertIn("'Support' is a node set and an element set: the node set is written", self.summary)
        data = self.convert(INPUTS / "cae_set_of_face.inp", "--rename", "Support=held")
        self.assertEqual(self.groups(data)["held"], [1, 4, 7, 10])

    def test_set_of_sets_that_come_later(self):
        data = self.convert(INPUTS / "elset_forward.inp")
        self.assertEqual(data.part, {1: "ALL_", 2: "ALL_"})
        self.assertEqual(self.groups(data), {"ALL_": list(range(1, 17)), "A": list(range(1, 9)), "B": list(range(9, 17))})

    def test_two_parts(self):
        data = self.convert(INPUTS / "two_parts.inp")
        self.assertEqual(data.part, {1: "A", 2: "B"})
        self.assertEqual(self.groups(data), {"A": list(range(1, 9)), "B": list(range(9, 17))})
        self.assertEqual((data.box["x"], len(data.x)), ((0.0, 2.0), 16))
        self.assertIn("4 pairs of nodes at one place", self.summary)

    def test_spring(self):
        data = self.convert(INPUTS / "spring.inp")
        self.assertEqual(self.groups(data), {"E": list(range(1, 13)), "S": [1, 12]})
        self.assertIn("elements that only name nodes: 1 line", self.summary)

    def test_hexes_only(self):
        """Hexahedra beside all that comes with them: what is left is said, with the nodes that are in no hexahedron."""
        points, hexes = block((2, 1, 1), 1.0)
        more = ["*NODE", "20, 5, 5, 5", "21, 6, 5, 5", "22, 7, 7, 7", "*ELEMENT, TYPE=C3D4, ELSET=tets", "30, 1, 2, 3, 20",
                "*ELEMENT, TYPE=COH3D8, ELSET=glue", "31, 1, 2, 3, 4,", "5, 6, 7, 8", "32, 1, 2, 3, 4, 5, 6, 7, 8", "*ELEMENT, TYPE=B31, ELSET=beams",
                "33, 20, 21", "*ELEMENT, TYPE=MASS, ELSET=masses", "34, 12", "*ELEMENT, TYPE=GAPUNI, ELSET=gaps", "35, 1, 22",
                "*ELEMENT, TYPE=S4R, ELSET=shell", "36, 1, 2, 3, 4", "*NSET, NSET=held", "1, 20", "*ELSET, ELSET=both", "1, 30, 31",
                "*SOLID SECTION, ELSET=glass, MATERIAL=m", "*SOLID SECTION, ELSET=tets, MATERIAL=m", "*COHESIVE SECTION, ELSET=glue"]
        deck = self.write("deck.inp", inp(points, [("glass", hexes)], extra="\n".join(more) + "\n"))
        self.refuse(deck, "elements of type COH3D8 are not known", "--hexes-only")
        self.refuse(self.write("tets.inp", deck.read_text().replace("COH3D8", "C3D8").replace("31, 1, 2, 3, 4,\n5, 6, 7, 8\n32, 1, 2, 3, 4, 5, 6, 7, 8\n", "").replace("30, 31", "30")),
                    "only 8-node hexahedra can be used; there are tetra elements 30 (--hexes-only")
        data = self.convert(deck, "--hexes-only")
        self.assertEqual(data.shape(), cells((2, 1, 1), 1.0, "glass"))
        self.assertEqual(self.groups(data), {"glass": list(range(1, 13)), "held": [1], "beams": [], "masses": [12], "gaps": [1],
                                             "shell": [1, 2, 3, 4], "both": sorted(hexes[0] + 1)})
        for words in ("left out: 1 element of type tetra, 30", "left out: 2 elements of type COH3D8, 31, 32", "3 orphan nodes left out: 20, 21, 22",
                      "the set 'tets' holds elements that are left out", "the set 'glue' holds elements", "2 line, 1 point, 1 surface"):
            self.assertIn(words, self.summary)

    def test_hexes_only_of_gmsh(self):
        text = (INPUTS / "parametric_41.msh").read_text()
        deck = self.write("deck.msh", re.sub(r"(\$Elements\n)(\d+) (\d+) (\d+) (\d+)\n", lambda m: f"{m[1]}{int(m[2]) + 1} {int(m[3]) + 1} {m[4]} 99\n"
                                             "3 1 4 1\n99 1 2 3 4\n", text))
        self.refuse(deck, "there are tetra elements 99 (--hexes-only")
        self.assertEqual(self.convert(deck, "--hexes-only").shape(), cells((2, 2, 2), (1.0, 0.5, 0.5), "glass"))
        self.assertIn("left out: 1 element of type tetra, 99", self.summary)

    def test_include_within_a_block(self):
        data = self.convert(INPUTS / "include_drops_nset.inp")
        self.assertEqual(self.groups(data), {"glass": list(range(1, 9)), "rim": [1, 2, 3, 7, 8]})

    def test_input_of_element(self):
        data = self.convert(INPUTS / "element_input_ignored.inp")
        self.assertEqual(data.shape(), cells((3, 1, 1), 1.0, "glass"))

    def test_partitioned_and_parametric(self):
        expected = cells((2, 2, 2), (1.0, 0.5, 0.5), "glass")
        for name in "partitioned_41", "parametric_22", "parametric_41":
            with self.subTest(name=name):
                data = self.convert(INPUTS / f"{name}.msh")
                self.assertEqual(data.shape(), expected)
                self.assertEqual(set(data.groups), {"glass", "support"})
                self.assertEqual(data.places("support"), {(0.0, y, z) for y in (0.0, 0.5, 1.0) for z in (0.0, 0.5, 1.0)})

    def test_two_groups(self):
        for name in "two_groups_22", "two_groups_41":
            with self.subTest(name=name):
                self.refuse(INPUTS / f"{name}.msh", "in parts glass and whole", "--parts")
                for part, other in (("glass", "whole"), ("whole", "glass")):
                    data = self.convert(INPUTS / f"{name}.msh", "--parts", part)
                    self.assertEqual(data.shape(), cells((2, 2, 2), (1.0, 0.5, 0.5), part))
                    self.assertEqual(data.groups[other], set(range(1, 28)))
                    self.assertEqual(len(data.groups["support"]), 9)


# Gmsh in a process of its own: a mesh in many forms, and what its own module says of it.
GMSH = """
import gmsh, json, sys
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
box = [gmsh.model.occ.addBox(x, 0, 0, 1, 1, 1) for x in (0, 1)]
gmsh.model.occ.fragment([(3, box[0])], [(3, box[1])])
gmsh.model.occ.synchronize()
for dim, tag in gmsh.model.getEntities(1):
    gmsh.model.mesh.setTransfiniteCurve(tag, 3)
for dim, tag in gmsh.model.getEntities(2):
    gmsh.model.mesh.setTransfiniteSurface(tag)
    gmsh.model.mesh.setRecombine(2, tag)
for dim, tag in gmsh.model.getEntities(3):
    gmsh.model.mesh.setTransfiniteVolume(tag)
gmsh.model.addPhysicalGroup(3, [box[0]], 11)
gmsh.model.setPhysicalName(3, 11, "left half")
gmsh.model.addPhysicalGroup(3, [box[1]], 12)
gmsh.model.setPhysicalName(3, 12, "right")
gmsh.model.addPhysicalGroup(2, [gmsh.model.getEntitiesInBoundingBox(-.1, -.1, -.1, .1, 1.1, 1.1, 2)[0][1]], 13)
gmsh.model.setPhysicalName(2, 13, "support")
gmsh.model.mesh.generate(3)
truth = {}
for tag, name in ((11, "left_half"), (12, "right")):
    truth[name] = []
    for entity in gmsh.model.getEntitiesForPhysicalGroup(3, tag):
        nodes = gmsh.model.mesh.getElements(3, entity)[2][0]
        places = [list(gmsh.model.mesh.getNode(n)[0]) for n in nodes]
        truth[name] += [places[k:k + 8] for k in range(0, len(places), 8)]
truth["support"] = gmsh.model.mesh.getNodesForPhysicalGroup(2, 13)[1].reshape(-1, 3).tolist()
json.dump(truth, open(sys.argv[1] + "/truth.json", "w"))
gmsh.option.setNumber("Mesh.SaveGroupsOfNodes", 1)
gmsh.write(sys.argv[1] + "/gmsh.inp")
for partitions in (1, 3):
    if partitions > 1:
        gmsh.model.mesh.partition(partitions)
    for version in (2.2, 4.1):
        for binary in (0, 1):
            for parametric in (0, 1):
                for all_elements in (0, 1):
                    gmsh.option.setNumber("Mesh.MshFileVersion", version)
                    gmsh.option.setNumber("Mesh.Binary", binary)
                    gmsh.option.setNumber("Mesh.SaveParametric", parametric)
                    gmsh.option.setNumber("Mesh.SaveAll", all_elements)
                    gmsh.write(f"{sys.argv[1]}/p{partitions}_v{version}_b{binary}_u{parametric}_a{all_elements}.msh")
"""


class WhatGmshWrites(Case):
    def test_all_forms(self):
        subprocess.run([sys.executable, "-c", GMSH, str(self.folder)], check=True, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
        truth = json.loads((self.folder / "truth.json").read_text())
        expected = sorted((name, turned([tuple(x) for x in nodes])) for name in ("left_half", "right") for nodes in truth[name])
        support = {tuple(x) for x in truth["support"]}
        self.assertEqual((len(expected), len(support)), (16, 9))
        files = sorted(self.folder.glob("p*.msh"))
        self.assertEqual(len(files), 32)
        for path in files:
            with self.subTest(path=path.name):
                if "v2.2" in path.name and "a1" in path.name:  # Gmsh leaves out the groups
                    self.refuse(path, "in no part")
                    continue
                data = self.convert(path)
                self.assertEqual(data.shape(), expected)
                self.assertEqual(set(data.groups), {"left_half", "right", "support"})
                self.assertEqual(data.places("support"), support)
        data = self.convert(self.folder / "gmsh.inp", "--parts", "Volume1,Volume2", "--rename", "Volume1=left_half", "--rename",
                            "Volume2=right")
        self.assertEqual(data.shape(), expected)

    def test_the_other_byte_order(self):
        points, hexes = block((1, 1, 1), 1.0)
        for order in "<", ">":
            numbers = lambda kind, *values: np.array(values, dtype=kind).astype(np.dtype(kind).newbyteorder(order)).tobytes()
            nodes = b"".join(numbers("i4", k + 1) + numbers("f8", *x) for k, x in enumerate(points))
            row = numbers("i4", 5, 1, 2, 9, 3, 1, *(n + 1 for n in hexes[0]))
            path = self.folder / "order.msh"
            path.write_bytes(b"$MeshFormat\n2.2 1 8\n" + numbers("i4", 1) + b"\n$EndMeshFormat\n$Nodes\n8\n" + nodes
                             + b"\n$EndNodes\n$Elements\n1\n" + numbers("i4", 5, 1, 2) + row[12:] + b"\n$EndElements\n")
            self.assertEqual(self.convert(path).shape(), cells((1, 1, 1), 1.0, "volume_3"))


class Instances(Case):
    """*PART, *INSTANCE and *ASSEMBLY of Abaqus."""

    def model(self, assembly, part=""):
        points, hexes = block((1, 1, 1), (1.0, 2.0, 3.0))
        return self.write("model.inp", "*PART, NAME=Brick\n" + inp(points, [("body", hexes)]).replace("*HEADING\n", "")
                          + "*NSET, NSET=low, GENERATE\n1, 7, 2\n" + part + "*END PART\n*ASSEMBLY, NAME=a\n" + assembly
                          + "*END ASSEMBLY\n")

    def instances(self, *placed):
        return "".join(f"*INSTANCE, NAME={name}, PART=brick\n{lines}*END INSTANCE\n" for name, lines in placed)

    def test_one_part_twice(self):
        two = self.instances(("One", ""), ("Two", "5., 0, 0\n5., 0., 0., 5., 0., 1., 90.\n"))
        data = self.convert(self.model(two + "*NSET, NSET=held, INSTANCE=Two\n1, 8\n*NSET, NSET=held, INSTANCE=One\n2\n"
                                       "*NSET, NSET=some\nOne.3, Two.low\n*ELSET, ELSET=both\nTwo.1, One.body\n"
                                       "*ELEMENT, TYPE=SPRINGA, ELSET=spring\n1, One.7, Two.8\n",
                                       part="*SOLID SECTION, ELSET=body, MATERIAL=m\n"))
        self.assertEqual(data.part, {1: "One_body", 2: "Two_body"})
        self.assertEqual(data.groups["held"], {2, 9, 16})
        self.assertEqual(data.groups["One_low"], {1, 3, 5, 7})
        self.assertEqual(data.groups["some"], {3, 9, 11, 13, 15})
        self.assertEqual(data.groups["spring"], {7, 16})
        self.assertEqual(data.groups["both"], set(range(1, 17)))
        points = block((1, 1, 1), (1.0, 2.0, 3.0))[0]
        for k, (x, y, z) in enumerate(points):  # first the translation, then a quarter turn about x = 5
            self.assertEqual(data.x[k + 1], (x, y, z))
            np.testing.assert_allclose(data.x[k + 9], (5 - y, x, z), atol=1e-15)
        data = self.convert(self.folder / "model.inp", "--rename", "One.body=glass", "--rename", "Two.body=glass")
        self.assertEqual(set(data.part.values()), {"glass"})
        self.refuse(self.folder / "model.inp", "is in several instances", options=["--keep-ids"])

    def test_messages_name_the_instance(self):
        both = self.instances(("One", ""), ("Two", "5.\n"))
        self.refuse(self.model(both, "*NODE\n99, 0., 0., 0.\n"), "orphan", "One.99, Two.99")
        self.refuse(self.model(both + "*NSET, NSET=s\nThree.1\n"), "Three.1")
        self.refuse(self.model(both + "*NSET, NSET=s, INSTANCE=Two\n10\n"), "node set 's'", "no node 10")
        self.refuse(self.model(self.instances(("One", "1, 2, 3, 4\n"))), "*INSTANCE", "translation")
        self.refuse(self.model(self.instances(("One", "0\n1,1,1,1,1,1,30\n"))), "One", "axis")
        self.refuse(self.model(self.instances(("One", ""), ("one", ""))), "name one is there twice")

    def test_mesh_within_the_instance(self):
        """As CAE writes independent instances: the part itself is empty."""
        points, hexes = block((2, 1, 1), 1.0)
        mesh = inp(points, [("glass", hexes)]).replace("*HEADING\n", "")
        data = self.convert(self.write("independent.inp", "*PART, NAME=p\n*END PART\n*ASSEMBLY, NAME=a\n*INSTANCE, NAME=i, PART=p\n"
                                       "0., 0., 7.\n" + mesh + "*SOLID SECTION, ELSET=glass, MATERIAL=m\n*END INSTANCE\n"
                                       "*NSET, NSET=held, INSTANCE=i\n1, 2\n*END ASSEMBLY\n"))
        self.assertEqual((len(data.nodes), data.box["z"], data.groups["held"]), (2, (7.0, 8.0), {1, 2}))

    def test_reference_point(self):
        path = self.model(self.instances(("One", "")) + "*NODE\n1, 0., 9., 0.\n*NSET, NSET=point\n1\n")
        self.refuse(path, "1 orphan node", "--drop-orphans")
        data = self.convert(path, "--drop-orphans", "--keep-ids")
        self.assertEqual((len(data.x), data.groups["point"], data.part), (8, set(), {1: "body"}))
        self.assertIn("set point is empty", self.summary)

    def test_a_part_that_is_not_placed(self):
        path = self.model(self.instances(("One", "")))
        path.write_text("*PART, NAME=spare\n*NODE\n1, 0, 0, 0\n*END PART\n" + path.read_text())
        self.assertEqual(len(self.convert(path).x), 8)
        self.assertIn("part spare has no instance, and is left out", self.summary)

    def test_one_set_in_part_and_assembly(self):
        one = self.instances(("One", ""))
        self.assertEqual(set(self.convert(self.model(one + "*NSET, NSET=low, INSTANCE=One\n1, 3, 5, 7\n")).groups), {"body", "low"})
        data = self.convert(self.model(one + "*NSET, NSET=low, INSTANCE=One\n1\n"))
        self.assertEqual((data.groups["low"], data.groups["One_low"]), ({1}, {1, 3, 5, 7}))

    def test_sets_deep_in_each_other(self):
        n = 90
        text = "".join(f"*NSET, NSET=s{k}\ns{k + 1}, s{k + 1}\n" for k in range(n)) + f"*NSET, NSET=s{n}\n1, 2\n"
        points, hexes = block((1, 1, 1), 1.0)
        path = self.write("deep.inp", inp(points, [("glass", hexes)], text))
        self.assertEqual(self.convert(path, "--sets", "s0").groups["s0"], {1, 2})
        self.refuse(self.write("deeper.inp", path.read_text() + "".join(f"*NSET, NSET=t{k}\nt{k + 1}\n" for k in range(200))
                               + "*NSET, NSET=t200\n1\n"), "over 100 deep")


if __name__ == "__main__":
    unittest.main()
