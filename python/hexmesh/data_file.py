"""The LAMMPS data file that fix defe reads: nodes as atoms of atom_style sphere, and the section Hexes. Python's own modules
only."""


def data_lines(title, counts, box, atoms, hexes):
    """Its lines. counts: of atoms, atom types, hexes; box: (low, high) of each axis; atoms: (ID, type, "x y z"); hexes:
    (ID, part, IDs of eight nodes). Numbers come as they are to be written."""
    yield f"{title}\n"
    for count, what in zip(counts, ("atoms", "atom types", "hexes\n")):
        yield f"{count} {what}"
    for axis, (low, high) in zip("xyz", box):
        yield f"{low} {high} {axis}lo {axis}hi"
    yield "\nAtoms # sphere\n"
    for number, kind, place in atoms:
        yield f"{number} {kind} 0 1 {place}"
    yield "\nHexes\n"
    for number, part, nodes in hexes:
        yield f"{number} {part} {' '.join(map(str, nodes))}"
