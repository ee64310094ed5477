"""What decks of LS-DYNA and Nastran have in common: numbers in fields, sets with ranges, parts by number."""

import re

import numpy as np

from .mesh import some
from .output import Refused, printable


def integer(about, word):
    """A blank field is 0."""
    if not re.fullmatch(r"[-+]?\d{1,18}", word or "0", re.ASCII):
        raise Refused(f"{about}: '{printable(word, 40)}' is no integer")
    return int(word or 0)


def real(about, word):
    """A blank field is 0; 1.5-3 and 1.5D-3 are 1.5e-3."""
    try:
        return float(re.sub(r"(?<=[\d.])([-+]\d)", r"e\1", word.upper().replace("D", "E"))) if word else 0.0
    except ValueError:
        raise Refused(f"{about}: '{printable(word, 40)}' is not a number") from None


def chosen(members, known, about, what):
    """Indices of the members of a set, IDs and ranges of IDs (of which only those count that are there)."""
    found, missing = [], []
    for member in members:
        if isinstance(member, range):
            found += [index for k, index in known.items() if k in member]
        elif member in known:
            found.append(known[member])
        else:
            missing.append(member)
    if missing:
        raise Refused(f"{about}: there is no {what} {some(missing)}")
    return np.unique(np.array(found, np.int64))


def set_hexes(mesh, hexes, ids, parts, titles):
    """Elements, and their parts, number -> elements, under their titles where they have one, with the number where two have
    the same."""
    mesh.hexes, mesh.hex_ids = np.array(hexes, np.int64).reshape(-1, 8), np.array(ids, np.int64)
    used = [titles.get(part) for part in parts]
    for part, elements in parts.items():
        title = titles.get(part) or f"part_{part}"
        mesh.volume_sets[title if used.count(title) < 2 else f"{title}_{part}"] = np.array(elements)
    mesh.parts = list(mesh.volume_sets)


def nodes_of(element, nodes, index):
    """Indices of the nodes of an element."""
    missing = [node for node in nodes if node not in index]
    if missing:
        raise Refused(f"element {element}: there is no node {some(missing)}")
    return [index[node] for node in nodes]
