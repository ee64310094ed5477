"""Files of fix defe/vtk, written on two ranks, as VTK reads and draws them.

DEFE_LMP, DEFE_PLUGIN: the lmp program and defeplugin.so (ctest sets them)."""

import contextlib
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  the renderer
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkFiltersCore import vtkGlyph3D, vtkThreshold
from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter
from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkIOGeometry import vtkSTLReader
from vtkmodules.vtkIOHDF import vtkHDFReader
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkRenderingCore import vtkActor, vtkDataSetMapper, vtkRenderer, vtkRenderWindow, vtkWindowToImageFilter

SOURCE = Path(__file__).resolve().parent.parent.parent
BEAM = """
units           si
atom_style      sphere
newton          off on
comm_modify     vel yes
boundary        f f f
plugin          load {plugin}
region          box block -0.02 0.05 -0.02 0.03 -0.02 0.03
create_box      2 box
pair_style      defe/joint
pair_coeff      2 2 connective material cohesive 6e7 10.0 0.1 contact 0.9 0.2
group           particles empty
fix             fe all defe material glass elastic 74.09e9 0.2 2500 convert glass 5.6e7 type 2 group particles
create_hexes    fe glass 1 x 0 16 0.032 y 0 5 0.01 z 0 2 0.004
group           nodes type 1
fix             move1 nodes nve
fix             move2 particles nve/sphere
neighbor        5e-4 bin
neigh_modify    every 1 delay 0 check yes
timestep        5e-8
variable        vy atom "12*((x-0.016)*(x-0.016)/0.016/0.016-1/3)"
velocity        nodes set 0 v_vy 0
compute         h all defe/hex/local id sxx syy szz sxy syz sxz s1 vonmises part
dump            h all local 50 hex.*.txt index c_h[*]
dump_modify     h format float %.17g
fix             vtk all defe/vtk 50 beam
thermo          50
thermo_style    custom step f_fe[1] f_fe[3] f_fe[4] f_fe[5] f_fe[7] f_fe[27]
run             200
unfix           vtk
fix             vtk all defe/vtk 1 still elements
run             3
"""


def read(file):
    reader = vtkHDFReader()
    assert reader.CanReadFile(str(file)), file
    reader.SetFileName(str(file))
    reader.Update()
    return reader.GetOutput()


def values(data, name):
    return vtk_to_numpy(data.GetArray(name))


@contextlib.contextmanager
def display():
    """VTK of Debian draws on an X server only, also off the screen."""
    if os.environ.get("DISPLAY"):
        yield
        return
    # it stays when the first window closes
    server = subprocess.Popen(["Xvfb", "-noreset", "-displayfd", "1", "-screen", "0", "800x600x24"], text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    try:
        os.environ["DISPLAY"] = ":" + server.stdout.readline().strip()
        yield
    finally:
        os.environ.pop("DISPLAY", None)
        server.kill()
        server.wait()
        server.stdout.close()


class Vtk(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Path(tempfile.mkdtemp(prefix="defe-vtk-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        (cls.folder / "in.beam").write_text(BEAM.format(plugin=os.environ["DEFE_PLUGIN"]))
        run = subprocess.run([str(SOURCE / "tools/mpirun.sh"), "2", os.environ["DEFE_LMP"], "-in", "in.beam"], cwd=cls.folder,
                             stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        assert run.returncode == 0, run.stdout[-3000:]
        # the first run
        table = re.search(r"^ +Step .*\n((?: +\d+ .*\n)+)", (cls.folder / "log.lammps").read_text(), re.MULTILINE)[1]
        cls.log = {int(row[0]): [int(float(n)) for n in row[1:]] for row in map(str.split, table.splitlines())}

    def test_cells_of_each_step_are_those_of_the_log(self):
        self.assertEqual(sorted(self.log), [0, 50, 100, 150, 200])
        for kind in ("elements", "spheres", "joints"):
            series = json.loads((self.folder / f"beam_{kind}.hdf.series").read_text())
            self.assertEqual(series["file-series-version"], "1.0")
            self.assertEqual([f["name"] for f in series["files"]], [f"beam_{kind}_{s}.hdf" for s in sorted(self.log)])
            np.testing.assert_allclose([f["time"] for f in series["files"]], [5e-8 * s for s in sorted(self.log)])
        for step, (elements, des, *joints) in self.log.items():
            with self.subTest(step):
                grid = read(self.folder / f"beam_elements_{step}.hdf")
                self.assertEqual(grid.GetNumberOfCells(), elements)
                self.assertTrue(all(grid.GetCellType(c) == 12 for c in range(elements)))
                self.assertEqual(read(self.folder / f"beam_spheres_{step}.hdf").GetNumberOfCells(), des)
                # joints and ties, that soften or not
                self.assertEqual(read(self.folder / f"beam_joints_{step}.hdf").GetNumberOfCells(), sum(joints))
        self.assertGreater(self.log[200][1], 100)

    def test_values_are_those_of_the_compute(self):
        grid = read(self.folder / "beam_elements_200.hdf")
        data = grid.GetCellData()
        lines = (self.folder / "hex.200.txt").read_text().splitlines()
        rows = {int(r[1]): [float(a) for a in r[2:]] for r in map(str.split, lines[lines.index(
            next(line for line in lines if line.startswith("ITEM: ENTRIES"))) + 1:])}
        self.assertEqual(sorted(rows), sorted(values(data, "id")))
        for cell, hexid in enumerate(values(data, "id")):
            np.testing.assert_array_equal(values(data, "stress")[cell], rows[hexid][:6])
            self.assertEqual(values(data, "s1")[cell], rows[hexid][6])
            self.assertEqual(values(data, "vonmises")[cell], rows[hexid][7])
            self.assertEqual(values(data, "part")[cell], 1)
        # cubes, as VTK numbers their corners, that share their nodes: 8 mm3 each within the strain
        x = vtk_to_numpy(grid.GetPoints().GetData())
        for cell in range(grid.GetNumberOfCells()):
            ids = grid.GetCell(cell).GetPointIds()
            c = x[[ids.GetId(k) for k in range(8)]]
            self.assertAlmostEqual(np.linalg.det([c[1] - c[0], c[3] - c[0], c[4] - c[0]]) / 8e-9, 1.0, places=2)
        self.assertEqual(len(set(values(grid.GetPointData(), "node"))), grid.GetNumberOfPoints())

    def test_what_did_not_change_is_read_from_an_earlier_file(self):
        first = read(self.folder / "still_elements_200.hdf")
        quiet = 0
        for step in (201, 202, 203):
            file = self.folder / f"still_elements_{step}.hdf"
            grid = read(file)
            for c in range(grid.GetNumberOfCells()):
                self.assertEqual(grid.GetCellType(c), 12)
            if list(values(grid.GetCellData(), "id")) != list(values(first.GetCellData(), "id")):
                break
            quiet += 1
            self.assertLess(file.stat().st_size, 0.85 * (self.folder / "still_elements_200.hdf").stat().st_size)
            np.testing.assert_array_equal(values(grid.GetPointData(), "node"), values(first.GetPointData(), "node"))
            self.assertFalse(np.array_equal(values(grid.GetPointData(), "velocity"), values(first.GetPointData(), "velocity")))
            for c in range(grid.GetNumberOfCells()):
                self.assertEqual([grid.GetCell(c).GetPointId(a) for a in range(8)], [first.GetCell(c).GetPointId(a) for a in range(8)])
        self.assertGreater(quiet, 0)

    def test_outer_faces_for_ovito(self):
        def run(base):
            return subprocess.run([str(SOURCE / "tools/elements2stl"), base], cwd=self.folder,
                                  stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)

        done = run("beam")
        self.assertEqual((done.returncode, done.stdout), (0, "beam_faces.*.stl: 5 steps\n"))
        reader = vtkSTLReader()
        reader.SetFileName(str(self.folder / "beam_faces.0.stl"))
        reader.Update()
        # all sides of 16 x 5 x 2 elements, two triangles each
        self.assertEqual(reader.GetOutput().GetNumberOfCells(), 2 * 2 * (16 * 5 + 16 * 2 + 5 * 2))
        np.testing.assert_allclose(reader.GetOutput().GetBounds(), (0, 0.032, 0, 0.01, 0, 0.004), atol=1e-8)
        self.assertGreater((self.folder / "beam_faces.200.stl").stat().st_size, 10000)
        failed = run("bim")
        self.assertNotEqual(failed.returncode, 0)
        self.assertRegex(failed.stdout, r"\Aelements2stl: cannot read bim_elements.hdf.series: No such file.*\n\Z")

    @unittest.skipUnless(os.environ.get("DISPLAY") or shutil.which("Xvfb"), "no X server and no Xvfb (tools/install-deps.sh vtk)")
    def test_picture(self):
        """Elements, spheres by their radius, joints that soften as lines: each is to be seen."""
        renderer, window = vtkRenderer(), vtkRenderWindow()
        renderer.SetBackground(0.0, 0.0, 0.0)

        def show(source, colour):
            mapper, actor = vtkDataSetMapper(), vtkActor()
            mapper.SetInputConnection(source.GetOutputPort())
            mapper.ScalarVisibilityOff()
            actor.SetMapper(mapper)
            actor.GetProperty().SetColor(*colour)
            actor.GetProperty().LightingOff()
            actor.GetProperty().SetLineWidth(4.0)
            renderer.AddActor(actor)

        readers = {}
        for kind in ("elements", "spheres", "joints"):
            readers[kind] = vtkHDFReader()
            readers[kind].SetFileName(str(self.folder / f"beam_{kind}_200.hdf"))
        surface, glyphs, ball, softening = vtkGeometryFilter(), vtkGlyph3D(), vtkSphereSource(), vtkThreshold()
        surface.SetInputConnection(readers["elements"].GetOutputPort())
        show(surface, (0.0, 0.0, 1.0))
        ball.SetRadius(0.5)
        glyphs.SetInputConnection(readers["spheres"].GetOutputPort())
        glyphs.SetSourceConnection(ball.GetOutputPort())
        glyphs.SetInputArrayToProcess(0, 0, 0, 0, "radius")
        glyphs.SetScaleFactor(1.0)
        show(glyphs, (0.0, 1.0, 0.0))
        softening.SetInputConnection(readers["joints"].GetOutputPort())
        softening.SetInputArrayToProcess(0, 0, 0, 1, "state")
        softening.SetThresholdFunction(vtkThreshold.THRESHOLD_BETWEEN)
        softening.SetLowerThreshold(1.0)
        softening.SetUpperThreshold(1.0)
        show(softening, (1.0, 0.0, 0.0))

        with display():
            window.SetOffScreenRendering(1)
            window.SetSize(600, 400)
            window.AddRenderer(renderer)
            window.Render()
            image, writer = vtkWindowToImageFilter(), vtkPNGWriter()
            image.SetInput(window)
            image.Update()
            writer.SetInputConnection(image.GetOutputPort())
            writer.SetFileName(str(self.folder / "beam.png"))
            writer.Write()
            pixels = vtk_to_numpy(image.GetOutput().GetPointData().GetScalars())
            window.Finalize()
        self.assertGreater((self.folder / "beam.png").stat().st_size, 1000)
        # elements blue, spheres green, joints red
        for channel, least in ((2, 5000), (1, 1000), (0, 50)):
            with self.subTest(channel):
                others = [c for c in range(3) if c != channel]
                alone = (pixels[:, channel] == 255) & (pixels[:, others] == 0).all(axis=1)
                self.assertGreater(np.count_nonzero(alone), least)

    @unittest.skipUnless(shutil.which("pvpython") and (os.environ.get("DISPLAY") or shutil.which("Xvfb")), "no ParaView with Python")
    def test_paraview(self):
        with display():
            run = subprocess.run(["pvpython", str(SOURCE / "tools/paraview_scene.py"), "beam", "--picture", "scene.png"],
                                 cwd=self.folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                 text=True)
        self.assertEqual(run.returncode, 0, run.stdout[-3000:])
        self.assertGreater((self.folder / "beam.pvsm").stat().st_size, 10000)
        self.assertGreater((self.folder / "scene.png").stat().st_size, 10000)


if __name__ == "__main__":
    unittest.main(argv=sys.argv)
