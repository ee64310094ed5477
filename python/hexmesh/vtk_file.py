"""Reads .vtk and .vtu of VTK, by meshio. These files have neither IDs nor sets: parts are the values of an array of whole
numbers over the elements, node sets are arrays of 0 and 1 over the nodes."""

import contextlib
import io

import numpy as np

from .mesh import Mesh
from .output import Refused, printable

SURFACES = ("triangle", "quad", "polygon", "pixel")


def whole(array):
    return array.ndim == 1 and array.dtype.kind in "iub"


def read(path, part_array=None):
    """part_array: name of the array that has the parts; needed where there are several."""
    try:
        import meshio
    except ImportError:
        raise Refused("files of VTK need meshio: tools/install-deps.sh meshes") from None
    reader = meshio.vtu if path.suffix.lower() == ".vtu" else meshio.vtk
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):  # meshio's warnings
        try:
            found = reader.read(str(path))
        except (OSError, MemoryError):
            raise
        except Exception:  # of many kinds, mostly without words
            raise Refused("meshio cannot read it, is it broken? Unstructured grids can be read: write it as .vtu or legacy .vtk") from None
    mesh = Mesh()
    mesh.files.append(path)
    mesh.points = np.asarray(found.points, float)
    mesh.node_ids = np.arange(1, len(mesh.points) + 1)
    hexes, ids, first = [], [], 1
    for block in found.cells:
        numbers = np.arange(first, first + len(block.data))
        first += len(block.data)
        if block.type == "hexahedron":
            hexes.append(np.asarray(block.data, np.int64).reshape(-1, 8))
            ids.append(numbers)
        elif block.type == "vertex" or block.type.startswith(("line", *SURFACES)):
            mesh.ignored[block.type] = mesh.ignored.get(block.type, 0) + len(numbers)
        else:
            mesh.others[block.type] = mesh.others.get(block.type, []) + numbers.tolist()
    if hexes:
        mesh.hexes, mesh.hex_ids = np.concatenate(hexes), np.concatenate(ids)
        if mesh.hexes.min() < 0 or mesh.hexes.max() >= len(mesh.points):
            raise Refused("cannot be read, is it broken? (an element names a node that is not there)")
    read_parts(mesh, found, part_array)
    for name, values in found.point_data.items():
        if whole(values) and np.isin(values, (0, 1)).all():
            mesh.node_sets[name] = np.flatnonzero(values)
    return mesh


def read_parts(mesh, found, part_array):
    arrays = {name: np.concatenate([np.asarray(values) for values, block in zip(several, found.cells) if block.type == "hexahedron"])
              for name, several in found.cell_data.items() if len(mesh.hexes)}
    arrays = {name: values for name, values in arrays.items() if whole(values)}
    names = ", ".join(map(printable, arrays))
    if part_array is not None and part_array not in arrays:
        raise Refused(f"--part-array: there is no array of whole numbers '{printable(part_array)}' over the elements; there are: {names or 'none'}")
    if part_array is None and len(arrays) > 1:
        raise Refused(f"several arrays of whole numbers over the elements, {names}: choose that of the parts by --part-array NAME")
    mesh.parts = []
    for name in arrays if part_array is None else [part_array]:
        for value in np.unique(arrays[name]).tolist():
            mesh.parts.append(f"{name}_{value:d}")
            mesh.volume_sets[mesh.parts[-1]] = np.flatnonzero(arrays[name] == value)
