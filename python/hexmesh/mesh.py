"""What the readers of meshes give."""

import numpy as np


class Mesh:
    """Nodes, elements in the order of the file, and named sets of both."""

    def __init__(self):
        self.points = np.zeros((0, 3))
        self.node_ids = np.zeros(0, dtype=np.int64)
        self.hexes = np.zeros((0, 8), dtype=np.int64)  # indices of nodes
        self.hex_ids = np.zeros(0, dtype=np.int64)
        self.node_names = None  # as messages call them, where the IDs are not unique: "Part-1-1.7"
        self.hex_names = None
        self.volume_sets = {}  # name -> indices of hexes
        self.node_sets = {}  # name -> indices of nodes
        self.parts = None  # names of the sets that are parts, where the file says so
        self.hidden = set()  # volume sets that count only where they are parts
        self.others = {}  # type of element -> IDs, of those that are refused
        self.ignored = {}  # type of element -> count, of those that only carry sets
        self.notes = []
        self.files = []  # all that were read


def some(ids, limit=10):
    """'12' or '3, 4, 9', with ' ... (25 in all)' when there are more than the limit."""
    ids = [str(i) for i in ids]
    return ", ".join(ids[:limit]) + (f" ... ({len(ids)} in all)" if len(ids) > limit else "")


def which_elements(ids):
    return ("element " if len(ids) == 1 else "elements ") + some(ids)


def plural(n, word):
    if n == 1:
        return f"1 {word}"
    return f"{n} {word[:-1] + 'ies' if word.endswith('y') else word + 's'}"
