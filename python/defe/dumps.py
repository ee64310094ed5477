"""Text dumps of LAMMPS (dump custom, dump local), and the pieces that hold together."""

import dataclasses
import re

import numpy as np

from .errors import InputError, at, text_of
from .tables import Table, is_number


@dataclasses.dataclass
class Frame:
    """One snapshot: step, box (3, 2) in m, and a Table of its columns, each (n,) in the order of the file."""

    step: int
    box: np.ndarray
    table: Table

    def __getitem__(self, name):
        return self.table[name]


def read_dump(path):
    """All frames of a text dump of atoms, or of local entries (dump local). Columns with a word that is no number are strings.

    Raises InputError: no such file, no dump, a frame that is cut off, a line of another length."""
    lines, frames, k = text_of(path).splitlines(), [], 0

    def line():
        nonlocal k
        if k >= len(lines):
            raise InputError(at(path, k) + "the file ends within a frame: the run was stopped while it wrote; run again")
        k += 1
        return lines[k - 1]

    while k < len(lines):
        head, step, count, box = line(), None, None, []
        while not re.match(r"ITEM: (ATOMS|ENTRIES)\b", head):
            if head == "ITEM: TIMESTEP":
                step = integer(path, k + 1, line())
            elif head.startswith("ITEM: NUMBER OF"):
                count = integer(path, k + 1, line())
            elif head.startswith("ITEM: BOX BOUNDS"):
                box = [bounds(path, k + 1, line()) for _ in range(3)]
            elif head.startswith("ITEM: "):    # units, time
                line()
            else:
                raise InputError(at(path, k) + "a line ITEM: ... should stand here: is this a text dump (dump custom)?")
            head = line()
        names, first = head.split()[2:], k
        if step is None or count is None:
            raise InputError(at(path, k) + "no step or number of atoms before it: the file is damaged; run again")
        rows = [line().split() for _ in range(count)]
        for number, row in enumerate(rows, first + 1):
            if len(row) != len(names):
                raise InputError(at(path, number) + f"{len(row)} words, but there are {len(names)} columns: it is damaged; run again")
        frames.append(Frame(step, np.array(box, float), Table(dict(zip(names, columns(rows, len(names)))), path)))
    if not frames:
        raise InputError(at(path) + "it is empty: has the run reached the first step that is dumped?")
    return frames


def bounds(path, number, text):
    words = text.split()
    if len(words) not in (2, 3) or not all(map(is_number, words)):
        raise InputError(at(path, number) + f"'{text[:40]}' are no bounds of the box: the file is damaged; run again")
    return [float(word) for word in words[:2]]


def columns(rows, count):
    words = np.array(rows, dtype=object).reshape(-1, count)
    for k in range(count):
        numbers = all(map(is_number, words[:, k]))
        yield words[:, k].astype(float) if numbers else words[:, k].astype(str)


def integer(path, number, text):
    if not re.fullmatch(r"\s*\d+\s*", text):
        raise InputError(at(path, number) + f"'{text[:40]}' is no count: the file is damaged; run again")
    return int(text)


@dataclasses.dataclass
class Fragments:
    """k pieces, heaviest first: id (k,), mass (k,) in kg, atoms (k,), the number of nodes and DEs of each. A piece of one
    atom is a DE alone: nodes come by eight."""

    id: np.ndarray
    mass: np.ndarray
    atoms: np.ndarray

    def __len__(self):
        return len(self.id)

    @property
    def single(self):
        """(k,) bool: a DE alone."""
        return self.atoms == 1


def fragments(ids, mass):
    """The pieces that hold together, from what compute defe/fragment/atom says of n nodes and DEs: ids (n,), 0 where an
    atom is in no piece, and their masses (n,) in kg."""
    ids, mass = np.asarray(ids), np.asarray(mass, float)
    if ids.shape != mass.shape or ids.ndim != 1:
        raise InputError(f"fragments need as many IDs as masses, not {ids.shape} and {mass.shape}")
    inside = ids > 0
    found, place = np.unique(ids[inside].astype(np.int64), return_inverse=True)
    weight, count = np.bincount(place, mass[inside], len(found)), np.bincount(place, minlength=len(found))
    order = np.argsort(-weight, kind="stable")
    return Fragments(found[order], weight[order], count[order])
