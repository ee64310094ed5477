"""A run written by fix defe/vtk, as one wants to see it in ParaView: finite elements coloured by their largest principal
stress, spheres by damage, joints that soften as lines.

    pvpython tools/paraview_scene.py BASE [options]

BASE is the `file` of fix defe/vtk (output/pane for output/pane_elements.hdf.series). It writes BASE.pvsm, a state that
ParaView opens by File > Load State (or `paraview BASE.pvsm`), with all steps; and pictures.

    --picture FILE   a picture of the last step too
    --film PREFIX    one of every step: PREFIX.0000.png, ...
    --spheres F      size of the spheres, by their radius (default 1); 0.5 lets one see the joints between them
    --stress S       upper end of the colours of stress (default: the largest of the last step)
    --from X Y Z     direction from which one looks (default 1 -1.6 1)
    --up X Y Z       what is up in the picture (default 0 0 1)
    --size W H       of the pictures (default 1400 900)

Works with the ParaView 5.11 of Debian 12 (packages paraview and python3-paraview) and newer ones. On a machine without a
screen, with the packages xvfb and xauth: xvfb-run -a -s "-noreset -screen 0 1280x1024x24" pvpython ..."""

import argparse
import os
import sys

from paraview import simple as pv


def arguments():
    parser = argparse.ArgumentParser(usage="pvpython paraview_scene.py BASE [options]", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("base")
    parser.add_argument("--picture")
    parser.add_argument("--film")
    parser.add_argument("--spheres", type=float, default=1.0)
    parser.add_argument("--stress", type=float)
    parser.add_argument("--from", dest="view", nargs=3, type=float, default=(1.0, -1.6, 1.0))
    parser.add_argument("--up", nargs=3, type=float, default=(0.0, 0.0, 1.0))
    parser.add_argument("--size", nargs=2, type=int, default=(1400, 900))
    return parser.parse_args()


def opened(base, kind):
    """The series of a kind, None if it was not written."""
    file = os.path.abspath(f"{base}_{kind}.hdf.series")
    if not os.path.exists(file):
        return None
    source = pv.OpenDataFile(file)
    pv.RenameSource(kind, source)
    return source


def has(source, place, name):
    """Whether the last step has this array, and cells at all."""
    source.UpdatePipeline(source.TimestepValues[-1])
    data = source.CellData if place == "CELLS" else source.PointData
    return name in data.keys()


def coloured(display, place, name, colours, title, view, show_bar=True):
    """Colours: (value, red, green, blue), from the lowest on."""
    pv.ColorBy(display, (place, name))
    table = pv.GetColorTransferFunction(name)
    table.RGBPoints = [number for colour in colours for number in colour]
    table.ColorSpace = "RGB"
    table.AutomaticRescaleRangeMode = "Never"
    bar = pv.GetScalarBar(table, view)
    bar.Title, bar.ComponentTitle = title, ""
    bar.TitleColor = bar.LabelColor = (0.1, 0.1, 0.1)
    display.SetScalarBarVisibility(view, show_bar)


def show_elements(source, view, stress):
    display = pv.Show(source, view)
    display.Representation = "Surface With Edges"
    display.EdgeColor = (0.45, 0.5, 0.55)
    display.DiffuseColor = (0.84, 0.9, 0.94)
    display.Ambient, display.Diffuse = 0.35, 0.7    # faces that one looks at aslant keep their colour
    if not has(source, "CELLS", "s1"):
        return
    top = stress or max(source.CellData["s1"].GetRange()[1], 1.0)
    coloured(display, "CELLS", "s1", ((0.0, 0.84, 0.9, 0.94), (0.5 * top, 0.98, 0.85, 0.45), (top, 0.85, 0.2, 0.1)),
             "largest principal stress", view)


def show_spheres(source, view, size):
    glyphs = pv.Glyph(Input=source, GlyphType="Sphere")
    pv.RenameSource("spheres, drawn", glyphs)
    glyphs.GlyphMode = "All Points"
    glyphs.OrientationArray = ["POINTS", "No orientation array"]
    glyphs.ScaleArray = ["POINTS", "radius"]
    glyphs.ScaleFactor = 2.0 * size    # ParaView's sphere has a radius of 1/2
    display = pv.Show(glyphs, view)
    display.DiffuseColor = (0.36, 0.58, 0.85)
    if has(source, "POINTS", "damage"):
        coloured(display, "POINTS", "damage", ((0.0, 0.36, 0.58, 0.85), (0.4, 0.98, 0.85, 0.3), (0.8, 0.8, 0.05, 0.08)),
                 "joints broken or soft", view)


def show_joints(source, view):
    """Those that soften."""
    if not has(source, "CELLS", "state"):
        return
    softening = pv.Threshold(Input=source)
    pv.RenameSource("joints that soften", softening)
    softening.Scalars = ["CELLS", "state"]
    softening.LowerThreshold = softening.UpperThreshold = 1.0
    display = pv.Show(softening, view)
    display.LineWidth = 3.0
    display.DiffuseColor = display.AmbientColor = (0.35, 0.0, 0.35)


def main():
    options = arguments()
    view = pv.GetActiveViewOrCreate("RenderView")
    view.ViewSize = options.size
    view.UseColorPaletteForBackground = 0
    view.Background = (1.0, 1.0, 1.0)
    view.OrientationAxesLabelColor = (0.1, 0.1, 0.1)
    sources = {kind: opened(options.base, kind) for kind in ("elements", "spheres", "joints")}
    if not any(sources.values()):
        sys.exit(f"paraview_scene.py: there is no {options.base}_elements.hdf.series, ..._spheres... or ..._joints...: "
                 f"give the file of fix defe/vtk")
    # the first step may have no spheres, and so no range of their values
    scene = pv.GetAnimationScene()
    scene.UpdateAnimationUsingDataTimeSteps()
    scene.GoToLast()
    if sources["elements"]:
        show_elements(sources["elements"], view, options.stress)
    if sources["spheres"]:
        show_spheres(sources["spheres"], view, options.spheres)
    if sources["joints"]:
        show_joints(sources["joints"], view)

    pv.ResetCamera(view)
    focus = view.CameraFocalPoint
    view.CameraPosition = [f + d for f, d in zip(focus, options.view)]
    view.CameraViewUp = options.up
    pv.ResetCamera(view)
    state = f"{options.base}.pvsm"
    pv.SaveState(state)
    print(f"{state}: open it by ParaView, File > Load State")
    if options.picture:
        pv.SaveScreenshot(options.picture, view, ImageResolution=options.size)
        print(options.picture)
    if options.film:
        pv.SaveAnimation(f"{options.film}.png", view, ImageResolution=options.size)
        print(f"{options.film}.0000.png ...")


main()
