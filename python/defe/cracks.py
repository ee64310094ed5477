"""Cracks, as the event file tells of them. Places in m, times in s, angles in degrees."""

import numpy as np

from .errors import InputError


def farthest(time, reach):
    """How far a crack has come: times (n,) in order, and the largest reach (n,) up to each (same units as reach)."""
    time, reach = np.asarray(time, float), np.asarray(reach, float)
    order = np.argsort(time, kind="stable")
    return time[order], np.maximum.accumulate(reach[order]) if len(order) else reach


def speed(time, reach, begin, end):
    """Mean speed of a crack from reach `begin` to `end`; nan if it does not come so far, inf if it comes there at once.
    time (n,), reach (n,)."""
    t, x = farthest(time, reach)
    if len(x) == 0 or x[-1] < end:
        return float("nan")
    took = t[np.searchsorted(x, end)] - t[np.searchsorted(x, begin)]
    return float((end - begin) / took) if took > 0 else float("inf")


def count_apart(values, apart, period=None):
    """Number of groups of values (n,) that are more than `apart` from the next; round the circle with a period."""
    values = np.sort(np.asarray(values, float))
    if not len(values):
        return 0
    if period is None:
        return 1 + int((np.diff(values) > apart).sum())
    return max(1, int((np.diff(np.append(values, values[0] + period)) > apart).sum()))


def arms(x, at, within, apart):
    """Cracks that cross the line x = at: groups of joints, at places x (n, 2 or 3), that are at most `within` from it and
    more than `apart` from each other along y."""
    return count_apart(x[np.abs(x[:, 0] - at) < within, 1], apart)


def polar(x, n):
    """Of joints at x (n, 3) with normals n (n, 3), seen along z: distance from the axis (n,), angle (n,) in degrees, and the
    share of the normal that points outwards (1: a crack around the axis), and around (1: along a radius)."""
    radius = np.maximum(np.hypot(x[:, 0], x[:, 1]), 1e-12)
    outwards = np.abs(x[:, 0] * n[:, 0] + x[:, 1] * n[:, 1]) / radius
    around = np.abs(x[:, 0] * n[:, 1] - x[:, 1] * n[:, 0]) / radius
    return radius, np.degrees(np.arctan2(x[:, 1], x[:, 0])), outwards, around


def count_radial(x, n, circle, within, apart):
    """Cracks along a radius that cross a circle (m) about the axis z: groups of joints, `apart` degrees from each other."""
    radius, angle, _, around = polar(x, n)
    return count_apart(angle[(np.abs(radius - circle) < within) & (around > 0.8)], apart, 360.0)


def far_from(points, others, reach):
    """(n,) bool: which of the points (n, 3) have none of the others (m, 3) within reach (m)."""
    points, others = (np.asarray(a, float).reshape(-1, 3) for a in (points, others))
    if not reach > 0:
        raise InputError(f"a reach of {reach} cannot be used: it must be above 0")
    cells = {}
    for cell, x in zip(map(tuple, np.floor(others / reach).astype(int).tolist()), others):
        cells.setdefault(cell, []).append(x)
    found = np.ones(len(points), bool)
    around = np.array(list(np.ndindex(3, 3, 3))) - 1
    for k, (cell, x) in enumerate(zip(np.floor(points / reach).astype(int), points)):
        near = [other for c in map(tuple, (cell + around).tolist()) for other in cells.get(c, ())]
        found[k] = not near or float(np.min(np.linalg.norm(np.array(near) - x, axis=1))) > reach
    return found


def counts(events, time):
    """What has happened up to the times (n,) in s: {kind: (n,) int}."""
    return {kind: np.searchsorted(np.sort(events.time[events.kind == kind]), time, "right")
            for kind in ("convert", "cohesive", "broken", "adhesive", "debonded")}
