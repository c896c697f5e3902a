"""D-patches: a surface whose normals are continuous at its extraordinary points as well.

The elements around an extraordinary point are split into four. In the sub-elements that touch the
point, the four Bezier points nearest to it coincide. The Bezier points of the ring around these are
projected into one plane, by retaining only the first harmonic of the ring's discrete Fourier
transform, and those on common edges are the means of their neighbours, so that adjacent
sub-elements have a common derivative there (Reif 1997; splitting before smoothing as in Toshniwal,
Speleers and Hughes 2017). The parametrisation is degenerate at the extraordinary point, where det J
is zero, and nowhere else.
"""

import numpy as np

from post._error import Unreadable
from post.mesh import _split
from post.mesh._patches import tables


def smooth(surface, everywhere=False):
    """The Surface with D-patches at its extraordinary points.

    everywhere: split all elements, instead of only those around extraordinary points, so that no
    corner hangs.
    """
    if surface.degree != (3, 3):
        raise Unreadable("--smooth needs bicubic elements")
    special = extraordinary(surface)
    if not special:
        return surface
    chosen = np.isin(surface.corners, list(special)).any(axis=1)
    if everywhere:
        chosen[:] = True
    at = np.flatnonzero(chosen)
    result = _split.split(surface, chosen)
    first = len(chosen) - len(at)
    fans = _fans(surface, special, at, first)
    rows = {}
    for fan in fans.values():
        for _, _, parent in fan:
            for d in range(4):
                rows.setdefault(parent + d, _rows(result, parent + d))
    for fan in fans.values():
        _flatten(rows, fan)
    for fan in fans.values():
        _join(rows, fan)
    numbers = list(rows)
    nodes, coefficients = tables([rows[e] for e in numbers])
    for e, ids, c in zip(numbers, nodes, coefficients):
        result.nodes[e], result.coefficients[e] = ids, c
    return result


def extraordinary(surface):
    """The set of corners inside the surface where the number of elements is not four.

    These are not necessarily the corners where normals jump: where three elements meet, the
    normals agree at the corner, but not along the edges.
    """
    count = np.bincount(surface.corners.ravel())
    edges = {}
    for row in surface.corners.tolist():
        for a, b in zip(row, row[1:] + row[:1]):
            edges[frozenset((a, b))] = edges.get(frozenset((a, b)), 0) + 1
    lone = {v for pair, users in edges.items() if users == 1 for v in pair}
    return set(np.flatnonzero((count != 4) & (count > 0)).tolist()) - lone


def _rows(surface, e):
    ids, c = surface.nodes[e].tolist(), surface.coefficients[e]
    return [{i: v for i, v in zip(ids, c[:, b].tolist()) if v} for b in range(16)]


def _fans(surface, special, chosen, first):
    """{corner: [(sub-element that touches it, its corner c, first sub-element of the parent)]} in
    order.
    """
    place = {int(e): first + 4 * k for k, e in enumerate(chosen)}
    start = {}
    for e in chosen:
        row = surface.corners[e].tolist()
        for c in range(4):
            if row[c] in special:
                start[row[c], row[(c + 1) % 4]] = (int(e), c)
    fans = {}
    for (v, a), (e, c) in start.items():
        if v in fans:
            continue
        fan, here = [], (e, c)
        while True:
            e, c = here
            fan.append((place[e] + c, c, place[e]))
            here = start.get((v, int(surface.corners[e, c - 1])))
            if here is None or here == start[v, a]:
                break
        if here is not None:  # a corner at the boundary does not change
            fans[v] = fan
    return fans


def index(i, j, c):
    """Number of the Bezier point i along the edge that starts at corner c and j along the one that
    ends there.

    >>> [index(0, 0, c) for c in range(4)]
    [0, 3, 15, 12]
    """
    xi, eta = ((i, j), (3 - j, i), (3 - i, 3 - j), (j, 3 - i))[c]
    return xi + 4 * eta


def combined(pairs):
    """The sum of factor times row over (factor, row) pairs."""
    total = {}
    for factor, row in pairs:
        for v, w in row.items():
            total[v] = total.get(v, 0.0) + factor * w
    return total


def _flatten(rows, fan):
    """Make the points at the corner coincide, and put the ring around them into one plane."""
    n = len(fan)
    sector = 2 * np.pi / n
    beside = (
        sector * np.arctan(0.5) / (0.5 * np.pi)
    )  # for n = 4, the points of the ring keep their directions
    angle = np.array(
        [a for k in range(n) for a in (k * sector + beside, (k + 1) * sector - beside)]
    )
    ring = [rows[e][index(*ij, c)] for e, c, _ in fan for ij in ((2, 1), (1, 2))]
    e, c, _ = fan[0]
    centre = combined([(0.5, rows[e][index(0, 0, c)])] + [(0.25 / n, row) for row in ring])
    flat = []
    for a in angle:
        weights = np.cos(a - angle) / n
        flat.append(combined([(1.0, centre), *((w, row) for w, row in zip(weights, ring))]))
    for k, (e, c, _) in enumerate(fan):
        for ij in ((0, 0), (1, 0), (0, 1), (1, 1)):
            rows[e][index(*ij, c)] = centre
        rows[e][index(2, 1, c)], rows[e][index(1, 2, c)] = flat[2 * k], flat[2 * k + 1]
        following = flat[(2 * k + 2) % (2 * n)]
        rows[e][index(2, 0, c)] = combined([(0.5, flat[2 * k]), (0.5, flat[2 * k - 1])])
        rows[e][index(0, 2, c)] = combined([(0.5, flat[2 * k + 1]), (0.5, following)])


def _join(rows, fan):
    """Set the Bezier points between a sub-element at the corner and its siblings to means."""
    for e, c, parent in fan:
        ahead, behind = parent + (c + 1) % 4, parent + (c - 1) % 4
        for j in (0, 1):
            mean = combined([(0.5, rows[e][index(2, j, c)]), (0.5, rows[ahead][index(1, j, c)])])
            rows[e][index(3, j, c)] = rows[ahead][index(0, j, c)] = mean
            mean = combined([(0.5, rows[e][index(j, 2, c)]), (0.5, rows[behind][index(j, 1, c)])])
            rows[e][index(j, 3, c)] = rows[behind][index(j, 0, c)] = mean
