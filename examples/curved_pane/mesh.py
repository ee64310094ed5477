#!/usr/bin/env python3
"""Meshes a laminated pane, glass / PVB / glass, with Gmsh: unstructured quadrilaterals on a flat
outline, extruded to hexahedra layer by layer, then bent onto a doubly curved surface.

    mesh.py PANE.msh [options]          lengths in mm; then tools/mesh2data PANE.msh PANE.data --scale 1e-3

The outline is a trapezium with rounded corners, symmetric about x = 0, or a disc. The reference
surface, on the outside of the pane, touches the plane z = 0 at the origin and is an arc of radius
--radius-x along x that sweeps one of radius --radius-y along y (a piece of a torus); 0 means not
curved. The layers lie below it at their exact thickness, along its normals.

Parts:      outer, pvb, inner
Node sets:  outer_face, inner_face      the two faces
            edge                        the whole rim
            inner_rim                   the rim's nodes on the inner face, for a support
"""

import argparse
import os
import sys

try:
    import gmsh
    import numpy as np
except ImportError as missing:
    # A python3 of one's own may come before Debian's in PATH, without Debian's packages.
    if sys.executable != "/usr/bin/python3" and os.access("/usr/bin/python3", os.X_OK):
        os.execv("/usr/bin/python3", ["/usr/bin/python3", *sys.argv])
    sys.exit(f"mesh.py: {missing}; needed are numpy and gmsh (tools/install-deps.sh meshes)")


def trapezium(geo, bottom, top, height, radius):
    """Curves of the outline: rounded corners, counter-clockwise."""
    corner = np.array([[-bottom / 2, -height / 2], [bottom / 2, -height / 2],
                       [top / 2, height / 2], [-top / 2, height / 2]])
    starts, centres, ends = [], [], []
    for k in range(4):
        before = corner[k - 1] - corner[k]
        after = corner[(k + 1) % 4] - corner[k]
        before, after = before / np.linalg.norm(before), after / np.linalg.norm(after)
        half = np.arccos(before @ after) / 2
        middle = (before + after) / np.linalg.norm(before + after)
        starts.append(corner[k] + before * radius / np.tan(half))
        ends.append(corner[k] + after * radius / np.tan(half))
        centres.append(corner[k] + middle * radius / np.sin(half))
    point = [[geo.addPoint(*x, 0) for x in row] for row in zip(starts, centres, ends)]
    curves = []
    for k in range(4):
        curves.append(geo.addCircleArc(*point[k]))
        curves.append(geo.addLine(point[k][2], point[(k + 1) % 4][0]))
    return curves


def disc(geo, radius):
    centre = geo.addPoint(0, 0, 0)
    rim = [geo.addPoint(radius * np.cos(a), radius * np.sin(a), 0) for a in np.pi / 2 * np.arange(4)]
    return [geo.addCircleArc(rim[k], centre, rim[(k + 1) % 4]) for k in range(4)]


def bend(x, radius_x, radius_y):
    """The flat pane, u and v along its outside and w above it, put onto the curved surface."""
    u, v, w = x.T
    b = v / radius_y if radius_y else np.zeros_like(v)
    y = radius_y * np.sin(b) if radius_y else v
    drop = radius_y * (1 - np.cos(b)) if radius_y else np.zeros_like(v)
    a = u / radius_x if radius_x else np.zeros_like(u)
    if radius_x:
        point = np.stack([(radius_x - drop) * np.sin(a), y, (radius_x - drop) * np.cos(a) - radius_x], axis=1)
    else:
        point = np.stack([u, y, -drop], axis=1)
    normal = np.stack([np.cos(b) * np.sin(a), np.sin(b), np.cos(b) * np.cos(a)], axis=1)
    return point + w[:, None] * normal


def worst_corner(surface):
    """The smallest sine of an angle of the quadrilaterals; 0 if there are other elements or an angle is
    180 degrees or more."""
    kinds, _, nodes = gmsh.model.mesh.getElements(2, surface)
    if list(kinds) != [3]:
        return 0.0
    tags, x, _ = gmsh.model.mesh.getNodes()
    place = np.zeros((int(tags.max()) + 1, 2))
    place[tags.astype(np.int64)] = x.reshape(-1, 3)[:, :2]
    quad = place[nodes[0].astype(np.int64).reshape(-1, 4)]
    to_next = np.roll(quad, -1, axis=1) - quad
    to_next /= np.linalg.norm(to_next, axis=2, keepdims=True)
    to_last = -np.roll(to_next, 1, axis=1)
    sines = to_next[:, :, 0] * to_last[:, :, 1] - to_next[:, :, 1] * to_last[:, :, 0]
    if sines.sum() < 0:
        sines = -sines
    return max(0.0, float(sines.min()))


def make(options, size_factor):
    """Writes the mesh; returns the number of hexahedra and the worst corner, 0 if there are wedges."""
    gmsh.initialize(["mesh.py"], False)  # no configuration of the user
    try:
        for name, value in {"General.Terminal": 0, "General.NumThreads": 1, "Mesh.RandomSeed": 1,
                            "Mesh.MshFileVersion": 4.1, "Mesh.Binary": 0,
                            "Mesh.Algorithm": 6, "Mesh.RecombinationAlgorithm": 1,  # frontal-Delaunay, blossom
                            "Mesh.RecombineAll": 1, "Mesh.Smoothing": 20,
                            "Mesh.MeshSizeExtendFromBoundary": 0, "Mesh.MeshSizeFromPoints": 0}.items():
            gmsh.option.setNumber(name, value)
        gmsh.model.add("pane")
        geo = gmsh.model.geo
        if options.outline == "disc":
            curves = disc(geo, options.width / 2)
        else:
            curves = trapezium(geo, options.width, options.top, options.height, options.corner)
        surface = geo.addPlaneSurface([geo.addCurveLoop(curves)])

        # Layers downwards, inside first in none of them: the outside is z = 0.
        names = ["outer", "pvb", "inner"]
        volumes, rim, below = [], [], (2, surface)
        for thickness, count in zip(options.thickness, options.layers):
            out = geo.extrude([below], 0, 0, -thickness, numElements=[count], recombine=True)
            below = out[0]
            volumes.append(out[1][1])
            rim += [tag for _, tag in out[2:]]
        geo.synchronize()
        for k, name in enumerate(names):
            gmsh.model.setPhysicalName(3, gmsh.model.addPhysicalGroup(3, [volumes[k]], k + 1), name)
        inner_rim = [tag for _, tag in gmsh.model.getBoundary([below], oriented=False)]
        for dim, tags, number, name in ((2, [surface], 11, "outer_face"), (2, [below[1]], 12, "inner_face"),
                                        (2, rim, 13, "edge"), (1, inner_rim, 14, "inner_rim")):
            gmsh.model.setPhysicalName(dim, gmsh.model.addPhysicalGroup(dim, tags, number), name)

        # The size of elements: from the middle, where it is struck, to the rim.
        field = gmsh.model.mesh.field
        size = field.add("MathEval")
        coarse, reach = size_factor * options.size, options.reach
        fine = size_factor * options.size_middle if options.size_middle else coarse
        field.setString(size, "F", f"{fine!r} + {coarse - fine!r}*Min(1, Max(0, Sqrt(x*x + y*y)/{reach!r} - 1))"
                        if fine != coarse else repr(coarse))
        field.setAsBackgroundMesh(size)
        gmsh.model.mesh.generate(3)

        quality = worst_corner(surface)
        tags, x, _ = gmsh.model.mesh.getNodes()
        new = bend(x.reshape(-1, 3), options.radius_x, options.radius_y)
        for tag, place in zip(tags, new):
            gmsh.model.mesh.setNode(tag, list(place), [])
        gmsh.write(options.mesh)
        return sum(map(len, gmsh.model.mesh.getElements(3)[1])), quality
    finally:
        gmsh.finalize()


def main():
    head, _, details = __doc__.partition("\n\n")
    parser = argparse.ArgumentParser(description=head, epilog=details,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    add = parser.add_argument
    add("mesh", metavar="PANE.msh")
    add("--outline", choices=["trapezium", "disc"], default="trapezium")
    add("--width", type=float, default=110.0, help="lower side of the trapezium, diameter of the disc (110)")
    add("--top", type=float, default=85.0, help="upper side of the trapezium (85)")
    add("--height", type=float, default=100.0, help="of the trapezium (100)")
    add("--corner", type=float, default=15.0, help="radius of its corners (15)")
    add("--radius-x", type=float, default=400.0, help="radius of curvature along x, 0 = flat (400)")
    add("--radius-y", type=float, default=250.0, help="radius of curvature along y, 0 = flat (250)")
    add("--thickness", type=float, nargs=3, default=[2.1, 0.76, 2.1], metavar="T", help="outer, PVB, inner (2.1 0.76 2.1)")
    add("--layers", type=int, nargs=3, default=[2, 1, 2], metavar="N", help="elements through each of them (2 1 2)")
    add("--size", type=float, default=2.0, help="edge length of the elements (2)")
    add("--size-middle", type=float, default=None, help="edge length in the middle (as --size)")
    add("--reach", type=float, default=15.0, help="radius of the middle; the size goes over to --size within as much again (15)")
    options = parser.parse_args()
    if min(*options.thickness, *options.layers, options.size, options.width) <= 0:
        parser.error("lengths and numbers of layers must be positive")
    # Recombination can leave a triangle or a bad corner, by chance: another size then helps.
    for k in range(16):
        factor = 1.0 - 0.015 * ((k + 1) // 2) * (-1)**k
        count, quality = make(options, factor)
        if quality >= 0.5:
            print(f"{options.mesh}: {count} hexahedra; the smallest sine of a corner is {quality:.3f}; "
                  f"size {factor * options.size:g} mm")
            return
    os.remove(options.mesh)
    sys.exit("mesh.py: no mesh of good quadrilaterals was found: try another --size")


if __name__ == "__main__":
    main()
