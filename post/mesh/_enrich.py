"""Only a part of the surface enriched: one ring of elements leads over to plain faces.

In that ring an element's corner that a plain face has too becomes a function of its own, whose
control point lies at the corner; the edge between two such corners is made straight. The spline and
the bilinear faces then have the same points and displacements along their common edges.
"""

import numpy as np

from post._error import Unreadable
from post.mesh._patches import tables
from post.mesh._surface import Surface


def make_partial(body, keep):
    """Change the body in place: elements that are not in `keep` (m), nor beside it, become plain."""
    s = body.whole
    if not keep.any():
        ring = keep
    else:
        near = np.unique(s.corners[keep])
        ring = np.isin(s.corners, near).any(axis=1)
    plain = ~ring
    border = set(np.intersect1d(s.corners[ring], s.corners[plain]).tolist())
    caught = border & set(s.hanging) | {
        h for h, (a, b, _) in s.hanging.items() if a in border and b in border
    }
    if caught:
        raise Unreadable(
            "a T-junction lies on the border of the enriched part; choose a larger or smaller part"
        )
    x = s.corner_points()
    for h, (a, b, tau) in s.hanging.items():
        x[h] = (1 - tau) * x[a] + tau * x[b]
    body.surface, own = _part(s, ring, plain, sorted(border), x)
    _add_plain(body, s, plain, x, own)


def _part(s, ring, plain, border, x):
    """(Surface of the ring and what it surrounds, {corner of the border: its control point})."""
    n = len(s.points)
    own = {v: n + k for k, v in enumerate(border)}
    straight = _edges(s.corners[plain])
    rows, numbers = [], np.flatnonzero(ring)
    for e in numbers:
        rows.append(_rows(s, e, own, straight))
    nodes, coefficients = tables(rows)
    points = np.concatenate([s.points, x[border]])
    weights = np.concatenate([s.weights, np.ones(len(border))])
    used = np.unique(np.concatenate(nodes)) if nodes else np.empty(0, dtype=int)
    place = np.full(len(points), -1)
    place[used] = np.arange(len(used))
    new = np.cumsum(ring) - 1
    sets = {name: new[ids[ring[ids]]] for name, ids in s.sets.items()}
    part = Surface(s.degree, points[used], weights[used], [place[i] for i in nodes], coefficients,
                   s.corners[numbers].reshape(-1, 4), sets, s.hanging)  # fmt: skip
    return part, {v: int(place[k]) for v, k in own.items()}


def _rows(s, e, own, straight):
    ids, c = s.nodes[e].tolist(), s.coefficients[e]
    rows = [{i: v for i, v in zip(ids, c[:, b].tolist()) if v} for b in range(c.shape[1])]
    corners = s.corners[e].tolist()
    p, q = s.degree
    lines = _lines(p, q)
    for k, v in enumerate(corners):
        following = corners[(k + 1) % 4]
        if v in own:
            rows[s.corner_index[k]] = {own[v]: 1.0}
        if v in own and following in own and (following, v) in straight:
            line = lines[k]
            for j, b in enumerate(line[1:-1], 1):
                tau = j / (len(line) - 1)
                rows[b] = {own[v]: 1 - tau, own[following]: tau}
    return rows


def _lines(p, q):
    """Bezier points along the four edges, each from its corner to the next.

    >>> _lines(1, 1)
    [[0, 1], [1, 3], [3, 2], [2, 0]]
    """
    at = np.arange((p + 1) * (q + 1)).reshape(q + 1, p + 1)
    return [at[0].tolist(), at[:, p].tolist(), at[q, ::-1].tolist(), at[::-1, 0].tolist()]


def _edges(corners):
    return {(int(a), int(b)) for row in corners for a, b in zip(row, np.roll(row, -1))}


def _add_plain(body, s, plain, x, own):
    """Hexahedra of the plain part, whose outer corners are new points of the bulk."""
    corners = np.unique(s.corners[plain])
    number = np.full(len(x), -1)
    number[corners] = len(body.points) + np.arange(len(corners))
    body.points = np.concatenate([body.points, x[corners]])
    faces = number[s.corners[plain]]
    body.plain = faces
    hexes = np.column_stack([faces, s.corners[plain]])
    body.cells["hexes"] = np.concatenate([hexes, body.cells["hexes"]])
    new = np.cumsum(plain) - 1
    body.plain_sets = {name: new[ids[plain[ids]]] for name, ids in s.sets.items()}
    body.ties = [(int(number[v]), point) for v, point in sorted(own.items())]
    for h, (a, b, tau) in sorted(s.hanging.items()):
        if number[h] >= 0:
            body.hanging.append((int(number[h]), (int(number[a]), int(number[b])), (1 - tau, tau)))
