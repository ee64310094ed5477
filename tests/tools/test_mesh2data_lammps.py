"""Meshes from mesh2data in LAMMPS: masses, groups, numbers, and an elastic run.

DEFE_LMP, DEFE_PLUGIN: the lmp program and defeplugin.so (ctest sets them)."""

import os
import shutil
import subprocess
import unittest
from pathlib import Path

from meshes import Case, SOURCE, block, environment, inp, np, ready_mesh

MESHES = ["pane_3190", "pane_3195"]  # of tests/meshes: Gmsh on two processors

HEAD = """
units           si
atom_style      sphere
newton          off on
comm_modify     vel yes
boundary        f f f
plugin          load defeplugin.so
region          box block -0.02 0.04 -0.02 0.04 -0.02 0.04
create_box      4 box
pair_style      zero 1e-3
pair_coeff      * *
fix             fe all defe material glass elastic 70e9 0.2 2500 material pvb elastic 1e9 0.4 1070
fix             move all nve
timestep        1e-8
neighbor        0.0003 bin
"""


class Lammps(Case):
    def lammps(self, ranks, script, *options):
        """What `print "NAME VALUE"` printed, and whether LAMMPS was content."""
        folder = self.folder / "run"
        folder.mkdir(exist_ok=True)
        if not isinstance(script, Path):
            script = self.write("in.test", script)
        plugin = Path(environment("DEFE_PLUGIN"))
        variables = dict(os.environ, LD_LIBRARY_PATH=f"{plugin.parent}:{os.environ.get('LD_LIBRARY_PATH', '')}")
        run = subprocess.run([SOURCE / "tools/mpirun.sh", str(ranks), environment("DEFE_LMP"), "-in", str(script), "-log", "none",
                              "-nocite", *options], cwd=self.folder, env=variables, stdin=subprocess.DEVNULL,
                             stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.output = run.stdout
        values = {}
        for line in run.stdout.splitlines():
            words = line.split()
            if len(words) == 3 and words[0] == "value":
                values[words[1]] = float(words[2])
        return run.returncode == 0, values

    def values(self, ranks, commands, formulas):
        script = HEAD + commands + "run 0\n"
        script += "".join(f'print "value {name} $({formula}:%.17g)"\n' for name, formula in formulas.items())
        good, values = self.lammps(ranks, script)
        self.assertTrue(good, self.output[-3000:])
        self.assertEqual(set(values), set(formulas), self.output[-3000:])
        return values

    def volume(self, part):
        line = next(line for line in self.summary.splitlines() if line.startswith(f"  part {part}:"))
        return float(line.split("volume ")[1].split(",")[0])

    def mesh(self, name, origin=(0, 0, 0), irregular=0.1):
        """3 x 2 x 2 elements of 4 x 3 x 2 mm, the upper layer of pvb; outer nodes stay in their planes."""
        points, hexes = block((3, 2, 2), (4.0, 3.0, 2.0), irregular=irregular)
        plane, _ = block((3, 2, 2), (4.0, 3.0, 2.0))
        outside = (plane == 0) | (plane == plane.max(axis=0))
        points[outside] = plane[outside]
        points += np.asarray(origin, dtype=float)
        low = np.array([k % 2 == 0 for k in range(len(hexes))])
        left = ", ".join(str(k + 1) for k in np.flatnonzero(plane[:, 0] == 0))
        return self.write(name, inp(points, [("pvb", hexes[~low]), ("glass", hexes[low])],
                                    f"*NSET, NSET=left\n{left}\n", first_node=1, first_element=1))

    def test_masses_volumes_and_groups(self):
        self.convert(self.mesh("mesh.inp"), "--scale", "1e-3", "--type", "glass=1", "--type", "pvb=2")
        glass, pvb = self.volume("glass"), self.volume("pvb")
        self.assertAlmostEqual((glass + pvb) / (12e-3 * 6e-3 * 4e-3), 1.0, delta=1e-8)  # nine digits are printed
        self.assertNotAlmostEqual(glass / pvb, 1.0, delta=1e-4)  # the border between them is not flat
        for ranks in 1, 2:
            found = self.values(ranks, "read_data out.data add append fix fe hexes Hexes\ninclude out.data.groups\n", {
                "elements": "f_fe[1]", "nodes": "count(all)", "mass": "mass(all)", "left": "count(left)",
                "both": "count(glass)+count(pvb)-count(all)", "left_x": "bound(left,xmax)", "left_y": "bound(left,ymax)",
                "glass_z": "bound(glass,zmin)", "pvb_z": "bound(pvb,zmax)"})
            self.assertEqual((found["elements"], found["nodes"], found["left"], found["both"]), (12, 36, 9, 12))
            self.assertAlmostEqual(found["mass"] / (2500 * glass + 1070 * pvb), 1.0, delta=1e-8)
            self.assertEqual((found["left_x"], found["glass_z"]), (0.0, 0.0))
            self.assertAlmostEqual(found["left_y"], 6e-3, delta=1e-17)
            self.assertAlmostEqual(found["pvb_z"], 4e-3, delta=1e-17)

    def test_second_mesh(self):
        """Offsets keep the groups of two meshes apart."""
        self.convert(self.mesh("a.inp"), "--scale", "1e-3", "--rename", "left=left_a", "--sets", "left_a", out="a.data")
        self.convert(self.mesh("b.inp", origin=(0, 0, 10)), "--scale", "1e-3", "--rename", "left=left_b", "--sets", "left_b",
                     "--node-offset", 36, "--element-offset", 12, out="b.data")
        found = self.values(2, "read_data a.data add append fix fe hexes Hexes\nread_data b.data add merge fix fe hexes Hexes\n"
                            "include a.data.groups\ninclude b.data.groups\n", {
                                "elements": "f_fe[1]", "nodes": "count(all)", "a": "bound(left_a,zmax)",
                                "b": "bound(left_b,zmin)", "x": "bound(left_a,xmax)+bound(left_b,xmax)"})
        self.assertEqual((found["elements"], found["nodes"], found["x"]), (24, 72, 0.0))
        self.assertAlmostEqual(found["a"], 4e-3, delta=1e-17)
        self.assertAlmostEqual(found["b"], 10e-3, delta=1e-17)

    def test_renumbered_mesh_and_stiffness(self):
        """IDs with gaps, and elements that were inside out: the strain energy of a stretch of one material
        is that of the theory, E/2 eps^2 V at nu = 0."""
        points, hexes = block((3, 2, 2), (4.0, 3.0, 2.0))
        mirrored = hexes.copy()
        mirrored[::2] = mirrored[::2][:, [4, 5, 6, 7, 0, 1, 2, 3]]
        self.convert(self.write("m.inp", inp(points, [("bar", mirrored)], first_node=500, first_element=70)), "--scale", "1e-3",
                     "--fix-orientation", "--keep-ids")
        commands = ("unfix fe\nfix fe all defe material bar elastic 1e9 0.0 1000\n"
                    "read_data out.data add append fix fe hexes Hexes\nrun 0\nvariable dx atom x*1e-3\n"
                    "displace_atoms all move v_dx 0 0\n")
        found = self.values(1, commands, {"energy": "f_fe[9]"})
        # second order in the strain: bricks are corotational with the linear law
        self.assertAlmostEqual(found["energy"] / (0.5 * 1e9 * 1e-6 * 12e-3 * 6e-3 * 4e-3), 1.0, delta=1e-9)

    def test_groups_before_the_mesh(self):
        self.convert(self.mesh("mesh.inp"))
        good, _ = self.lammps(1, HEAD + "include out.data.groups\n")
        self.assertFalse(good)
        self.assertIn("ERROR: group pvb needs 24 nodes of out.data, there are 0: read it first", self.output)

    def test_elastic_pane(self):
        """The mesh of the example curved_pane, coarser, struck by a block: energy is kept, on any number of ranks.

        Most of this file's 20 s of processor time: 625 steps of 3200 hexahedra until the block has turned back, on two
        meshes, by one rank and by two."""
        for mesh in MESHES:
            with self.subTest(mesh=mesh):
                self.elastic_pane(mesh)

    def elastic_pane(self, mesh):
        self.convert(ready_mesh(mesh, self.folder), "--scale", "1e-3", out="pane.data")
        last = []
        for ranks in 1, 2:
            good, _ = self.lammps(ranks, SOURCE / "examples" / "curved_pane" / "in.elastic", "-var", "mesh", "pane.data",
                                  "-var", "out", ".", "-var", "end", "5e-5", "-var", "pictures", "no")
            self.assertTrue(good, self.output[-3000:])
            rows = np.loadtxt(self.folder / "energies.txt")
            shutil.move(self.folder / "energies.txt", self.folder / f"energies.{ranks}.txt")
            strain, contact, kinetic, total, height, middle = rows[:, 2:8].T
            self.assertAlmostEqual(kinetic[0] / (0.5 * 7850e-6 * 5.0**2), 1.0, delta=1e-9)
            # 1.4e-5 and 1.1e-5 are lost on the two meshes
            self.assertLess((total / total[0] - 1).max(), 1e-5)
            self.assertGreater((total / total[0] - 1).min(), -1e-4)
            self.assertGreater(strain.max(), 0.3 * total[0])
            self.assertGreater(contact.max(), 0.0)
            self.assertLess(middle[-1], middle[0] - 5e-5)
            last.append(rows[-1, 2:8])
        self.assertLess(abs(last[1] / last[0] - 1).max(), 1e-6)


if __name__ == "__main__":
    unittest.main()
