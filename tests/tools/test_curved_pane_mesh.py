"""Gmsh itself, with mesh.py of the example curved_pane: counts, quality, volumes. Its mesh is another one on another
processor, so nothing here asks for more than a range; what depends on the mesh takes one of tests/meshes."""

import subprocess
import unittest

from meshes import Case, SOURCE, np


class CurvedPane(Case):
    def mesh(self, *options):
        """What mesh.py says, and what mesh2data makes of its mesh."""
        run = subprocess.run([SOURCE / "examples" / "curved_pane" / "mesh.py", self.folder / "pane.msh", *options], text=True,
                             stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.assertEqual(run.returncode, 0, run.stdout)
        return run.stdout, self.convert(self.folder / "pane.msh", "--scale", "1e-3")

    def check(self, area, count, *options):
        """Layers of 2, 1, 2 elements of 2.1, 0.76 and 2.1 mm below an outside of this area (mm2), bent."""
        said, data = self.mesh(*options)
        parts = {name: [e for e, part in data.part.items() if part == name] for name in ("outer", "pvb", "inner")}
        n = len(parts["pvb"])
        self.assertTrue(count[0] <= n <= count[1], n)
        self.assertEqual([len(parts["outer"]), len(parts["inner"]), len(data.part)], [2 * n, 2 * n, 5 * n])
        self.assertIn(f": {5 * n} hexahedra; the smallest sine of a corner is ", said)
        self.assertGreaterEqual(float(said.split("corner is ")[1].split(";")[0]), 0.5)

        # The Jacobian at every corner, over the lengths of the edges there: 1 in a brick. Bending tilts a little.
        x = np.array([[data.x[node] for node in data.nodes[e]] for e in data.nodes])
        neighbours = ((1, 3, 4), (2, 0, 5), (3, 1, 6), (0, 2, 7), (7, 5, 0), (4, 6, 1), (5, 7, 2), (6, 4, 3))
        for corner, ends in enumerate(neighbours):
            edges = x[:, ends, :] - x[:, [corner], :]
            edges /= np.linalg.norm(edges, axis=2, keepdims=True)
            self.assertGreater(np.linalg.det(edges).min(), 0.45)

        # Volume: area times thickness, but for the curvature (250 and 400 mm against 5 mm, and the pane is bent
        # from a flat outline: some percent).
        for name, thickness in ("outer", 2.1), ("pvb", 0.76), ("inner", 2.1):
            line = next(line for line in self.summary.splitlines() if line.startswith(f"  part {name}:"))
            volume = float(line.split("volume ")[1].split(",")[0])
            self.assertTrue(0.94 < volume / (area * thickness * 1e-9) < 1.0, f"{name}: {volume}")

        # node sets: both faces have all columns of nodes, and the rim's nodes are on all levels
        self.assertEqual(len(data.groups["outer_face"]), len(data.groups["inner_face"]))
        self.assertEqual(len(data.x), 6 * len(data.groups["outer_face"]))
        self.assertEqual(len(data.groups["edge"]), 6 * len(data.groups["inner_rim"]))
        self.assertEqual(data.groups["inner_rim"], data.groups["inner_face"] & data.groups["edge"])

    def test_trapezium(self):
        """4 mm elements, or a little more where Gmsh leaves a bad corner."""
        corners = 4 * 15.0**2 * (1 - np.pi / 4)
        self.check(0.5 * (110 + 85) * 100 - corners, (480, 700), "--size", "4")

    def test_disc_with_fine_middle(self):
        """201 of them, if all were of 5 mm."""
        self.check(np.pi * 40**2, (320, 520), "--outline", "disc", "--width", "80", "--size", "5", "--size-middle", "2",
                   "--reach", "10")


if __name__ == "__main__":
    unittest.main()
