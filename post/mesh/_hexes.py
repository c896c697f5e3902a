"""Reuse the hexahedra of the net's file: their boundary is moved to the inner corners of the
layer.
"""

import numpy as np

from post._error import Unreadable
from post.mesh import _quality

ROUNDS = 20
#: Directions from a point to the corners of a cube and the centres of its faces.
DIRECTIONS = np.array(
    [
        (a, b, c)
        for a in (-1, 0, 1)
        for b in (-1, 0, 1)
        for c in (-1, 0, 1)
        if abs(a) + abs(b) + abs(c) in (1, 3)
    ],
    dtype=float,
)


def reuse(net, surface, form):
    """(points, hexes) with the inner corners of the layer first, then the inner points, which
    follow.

    The displacement of the boundary is extended to the inner points harmonically, on a network of
    the edges in which shorter edges are stiffer. Then points of bad cells are moved wherever that
    improves the worst cell.
    """
    border = np.unique(net.quads)
    inside = np.setdiff1d(np.unique(net.hexes), border)
    if len(border) != len(form.inner):
        raise Unreadable("the hexahedra of the file do not belong to this net; use --interior tets")
    number = np.full(len(net.points), -1)
    number[border], number[inside] = np.arange(len(border)), len(border) + np.arange(len(inside))
    cells = _positive(net.points, net.hexes)
    start = net.points[np.concatenate([border, inside])]
    cells, n = number[cells], len(border)
    edges = cell_edges(cells)
    move = np.zeros_like(start)
    move[:n] = form.inner - start[:n]
    length = np.linalg.norm(start[edges[:, 0]] - start[edges[:, 1]], axis=1)
    points = start + harmonic(edges, move, n, length**2)
    points[:n] = form.inner
    _improve(points, cells, n)
    worst = corner_quality(points, cells)
    if (worst <= 0).any():
        k = np.flatnonzero(worst <= 0)
        raise Unreadable(
            f"{len(k)} of the {len(cells)} hexahedra of the file are inverted below the layer; "
            "use --interior tets, or a thinner --layer"
        )
    return points, cells


def _positive(points, cells):
    """The cells, with those renumbered whose corners are in the opposite order."""
    volume = _quality.hex_volumes(points, cells)
    return np.where((volume < 0)[:, None], cells[:, [4, 5, 6, 7, 0, 1, 2, 3]], cells)


def cell_edges(cells):
    """(k, 2) the edges of hexahedra, each edge once.

    >>> len(cell_edges(np.arange(8)[None]))
    12
    """
    pairs = [
        (0, 1),
        (1, 2),
        (2, 3),
        (3, 0),
        (4, 5),
        (5, 6),
        (6, 7),
        (7, 4),
        (0, 4),
        (1, 5),
        (2, 6),
        (3, 7),
    ]
    return np.unique(np.sort(cells[:, pairs].reshape(-1, 2), axis=1), axis=0)


def harmonic(edges, values, fixed, length, steps=2000):
    """(n, 3) values in equilibrium with the first `fixed` ones prescribed, by conjugate gradients.

    The stiffness of an edge is the reciprocal of its `length`.
    """
    weight = (1 / length)[:, None]

    def apply(v):
        flow = weight * (v[edges[:, 0]] - v[edges[:, 1]])
        out = np.zeros_like(v)
        np.add.at(out, edges[:, 0], flow)
        np.add.at(out, edges[:, 1], -flow)
        out[:fixed] = 0
        return out

    values = values.copy()
    r = -apply(values)
    d, rr = r.copy(), (r * r).sum()
    first = rr
    for _ in range(steps):
        if rr <= 1e-24 * first:
            break
        q = apply(d)
        step = rr / (d * q).sum()
        values += step * d
        r -= step * q
        new = (r * r).sum()
        d, rr = r + new / rr * d, new
    return values


def corner_quality(points, cells):
    """(m) the smallest scaled Jacobian of each hexahedron at its corners."""
    return _quality.scaled(_quality.hex_jacobians(points, cells, _quality.SIGN)).min(axis=1)


def _improve(points, cells, fixed, target=0.15):
    """Move inner points of bad cells, one after another, where that improves the worst cell around
    the point.
    """
    users = {}
    for k, row in enumerate(cells.tolist()):
        for v in row:
            users.setdefault(v, []).append(k)
    for _ in range(ROUNDS):
        quality = corner_quality(points, cells)
        bad = np.unique(cells[quality < target])
        moved = [_move(points, cells[users[v]], v) for v in bad.tolist() if v >= fixed]
        if not any(moved):
            return


def _move(points, around, v):
    """Move point v to the best of several positions near it; return whether it was moved."""
    x = points[around]
    others = x[around != v].reshape(-1, 3)
    reach = np.linalg.norm(others - points[v], axis=1).min()
    toward = others.mean(axis=0) - points[v]
    steps = np.concatenate([DIRECTIONS * 0.3 * reach, DIRECTIONS * 0.1 * reach,
                            [0.0 * toward, 0.25 * toward, 0.5 * toward]])  # fmt: skip
    trial = np.repeat(x[None], len(steps), axis=0)
    trial[:, around == v] = (points[v] + steps)[:, None]
    cells = np.arange(trial[..., 0].size).reshape(-1, 8)
    worst = corner_quality(trial.reshape(-1, 3), cells).reshape(len(steps), -1).min(axis=1)
    best, now = int(np.argmax(worst)), 2 * len(DIRECTIONS)
    if worst[best] <= worst[now] + 1e-3:
        return False
    points[v] += steps[best]
    return True
