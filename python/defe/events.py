"""The event file of fix defe (keyword events)."""

import re

import numpy as np

from .errors import InputError, at, needed, text_of

KINDS = ("convert", "cohesive", "broken", "adhesive", "debonded")


class Events:
    """n events in the order of the file:

    step   (n,) int
    time   (n,) s
    kind   (n,) one of KINDS: an element converts, a joint begins to soften or breaks, a tie begins to soften or breaks
    ids    (n, 2) int: element and number of its part; the two DEs of a joint; the DE and the element of a tie
    x      (n, 3) m, where in the body before it moved
    n      (n, 3) normal of the crack there, 0 for conversions
    value  (n,) mass (kg) of an element; equivalent traction (Pa) of a joint that begins to soften; damage of one that breaks
    run, elements   name of the run and number of elements of its mesh, None where the file does not say
    """

    FIELDS = ("step", "time", "kind", "ids", "x", "n", "value")

    def __init__(self, step, time, kind, ids, x, n, value, run=None, elements=None):
        self.step, self.time = np.array(step, np.int64), np.array(time, float)
        self.kind, self.ids = np.array(kind, "U8"), np.array(ids, np.int64).reshape(-1, 2)
        self.x, self.n = (np.array(a, float).reshape(-1, 3) for a in (x, n))
        self.value, self.run, self.elements = np.array(value, float), run, elements
        if len({len(getattr(self, name)) for name in self.FIELDS}) > 1:
            raise InputError("events need as many times, kinds, IDs, places, normals and values as steps")

    def __len__(self):
        return len(self.step)

    def where(self, chosen):
        """Those of a mask (n,) or of indices."""
        return Events(*(getattr(self, name)[chosen] for name in self.FIELDS), self.run, self.elements)

    def of(self, *kinds):
        """Those of these kinds."""
        for kind in kinds:
            if kind not in KINDS:
                raise InputError(f"there are no events of kind '{kind}': {', '.join(KINDS)}")
        return self.where(np.isin(self.kind, kinds))

    def first(self, *kinds):
        """Time (s) of the first of these kinds, None if there is none."""
        time = self.of(*kinds).time
        return float(time.min()) if len(time) else None

    def elements_of(self, nodes):
        """Index (n,) of the element of an event, from 0: of conversions that which converts, of joints and ties that of the
        first DE. nodes: number of nodes; the IDs of DEs follow those of nodes, and those of elements begin with 1."""
        return np.where(self.kind == "convert", self.ids[:, 0] - 1, element_of(self.ids[:, 0], nodes))

    def to_pandas(self):
        """As a DataFrame with columns step time kind id id2 X Y Z nx ny nz value; needs pandas."""
        columns = {"step": self.step, "time": self.time, "kind": self.kind, "id": self.ids[:, 0], "id2": self.ids[:, 1]}
        columns.update({name: self.x[:, k] for k, name in enumerate("XYZ")})
        columns.update({name: self.n[:, k] for k, name in enumerate(("nx", "ny", "nz"))})
        return needed("pandas", "python3-pandas", "to_pandas()").DataFrame({**columns, "value": self.value})


def element_of(des, nodes):
    """Index of the element, from 0, that DEs of these IDs were made of; nodes: the largest ID before theirs."""
    return (np.asarray(des) - nodes - 1) // 8


def read_events(path, running=False):
    """The event file of a run as Events. running: a run still writes it, and an unfinished last line is left out.

    Raises InputError: no such file, no event file, a line that is cut off or damaged."""
    text = text_of(path)
    lines = text.splitlines()
    if running and not text.endswith("\n"):
        lines = lines[:-1]
    if not lines or not re.match(r"# (DEFE events:|step time event )", lines[0]):
        if running and not lines:
            return Events([], [], [], [], [], [], [])
        raise InputError(at(path) + "does not begin as an event file does: give the file of fix defe's keyword events")
    head = re.match(r"# DEFE events: run ([0-9a-f]+), mesh of (\d+) elements", lines[0])
    rows = [line.split() for line in lines if line and line[0] != "#"]
    try:
        if any(len(row) != 12 or row[2] not in KINDS for row in rows):
            raise ValueError
        numbers = np.array([row[:2] + row[3:] for row in rows], float).reshape(-1, 11)
        whole = np.array([[row[0], row[3], row[4]] for row in rows], np.int64).reshape(-1, 3)
    except ValueError:
        raise damaged(path, lines) from None
    return Events(whole[:, 0], numbers[:, 1], [row[2] for row in rows], whole[:, 1:], numbers[:, 4:7], numbers[:, 7:10],
                  numbers[:, 10], head[1] if head else None, int(head[2]) if head else None)


def damaged(path, lines):
    """The exception of the first line that is none of an event."""
    for number, line in enumerate(lines, 1):
        words = line.split()
        if not line or line[0] == "#":
            continue
        if len(words) != 12:
            last = number == len(lines)
            return InputError(at(path, number) + f"{len(words)} words, an event has 12: " + (
                "the run was stopped while it wrote; continue it from its restart file, or delete the line" if last else
                "the file is damaged; run again"))
        if words[2] not in KINDS:
            return InputError(at(path, number) + f"'{words[2]}' is no event ({', '.join(KINDS)}): the file is damaged, or of "
                              "a later version")
        for word, kind in zip(words, (int, float, str, int, int, *7 * (float,))):
            try:
                kind(word)
            except ValueError:
                return InputError(at(path, number) + f"'{word}' is not a number: the file is damaged; run again")
    return InputError(at(path) + "cannot be read")
