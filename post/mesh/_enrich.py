"""Enrich only a part of the surface: one ring of elements forms the transition to plain faces.

Each corner of that ring that also belongs to a plain face gets a function of its own, with its
control point at the corner, and the edge between two such corners is made straight. The spline and
the bilinear faces then have the same points and displacements along their common edges, even where
corners hang (see _border).
"""

import numpy as np

from post.mesh import _border
from post.mesh._patches import tables
from post.mesh._surface import Surface


def make_partial(body, keep):
    """Change the body in place: elements become plain unless they are in `keep` (m) or next to
    it.
    """
    s = body.whole
    lines = _border.lines(s.hanging)
    ring = keep
    if keep.any():
        near = _border.protected(s.corners, keep, lines)
        ring = np.isin(s.corners, near).any(axis=1)
    plain = ~ring
    border = np.intersect1d(s.corners[ring], s.corners[plain]).tolist()
    flat, straight = _border.flattened(s.corners, plain, border, lines)
    x = s.corner_points()
    for h, (a, b, tau) in _border.in_order(s.hanging):
        x[h] = (1 - tau) * x[a] + tau * x[b]
    own = {v: len(s.points) + k for k, v in enumerate(sorted(flat - set(s.hanging)))}
    rows = {e: _rows(s, e) for e in np.flatnonzero(ring).tolist()}
    _straighten(s, rows, {v: _border.combination(v, own, s.hanging) for v in flat}, plain, straight)
    around = _border.users(s.corners, rows)
    for line in _border.bent(flat, straight, lines):
        _follow(s, rows, line, around)
    body.surface, own = _part(s, ring, rows, own, x)
    _add_plain(body, s, plain, x, own)


def _part(s, ring, rows, own, x):
    """(Surface of the ring and of the part inside it, {corner: its own control point, if in
    use}).
    """
    nodes, coefficients = tables(list(rows.values()))
    points = np.concatenate([s.points, x[list(own)]])
    weights = np.concatenate([s.weights, np.ones(len(own))])
    used = np.unique(np.concatenate(nodes)) if nodes else np.empty(0, dtype=int)
    place = np.full(len(points), -1)
    place[used] = np.arange(len(used))
    new = np.cumsum(ring) - 1
    sets = {name: new[ids[ring[ids]]] for name, ids in s.sets.items()}
    part = Surface(s.degree, points[used], weights[used], [place[i] for i in nodes], coefficients,
                   s.corners[ring].reshape(-1, 4), sets, s.hanging)  # fmt: skip
    return part, {v: int(place[k]) for v, k in own.items() if place[k] >= 0}


def _rows(s, e):
    ids, c = s.nodes[e].tolist(), s.coefficients[e]
    return [{i: v for i, v in zip(ids, c[:, b].tolist()) if v} for b in range(c.shape[1])]


def _straighten(s, rows, value, plain, straight):
    """Give the corners in `value` ({corner: row}) these rows, and straighten the plain edges
    between them (see _border for what is plain).
    """
    edges = _border.edges(s.corners[plain])
    of = _border.by_corner(straight)
    for e, part in rows.items():
        for v, following, points in _sides(s, e):
            if v in value:
                part[points[0]] = value[v]
            on_line = not set(of.get(v, ())).isdisjoint(of.get(following, ()))
            if on_line or frozenset((v, following)) in edges:
                for j, b in enumerate(points[1:-1], 1):
                    tau = j / (len(points) - 1)
                    part[b] = _border.combined([(1 - tau, value[v]), (tau, value[following])])


def _follow(s, rows, line, around):
    """Make the edges of small elements coincide with parts of the large element's edge `line`.

    around: {corner: elements}.
    """
    beside = {e for v in line.corners() for e in around.get(v, ())}
    sides = [(e, *side) for e in sorted(beside) for side in _sides(s, e)]
    e, v, _, points = next(x for x in sides if set(x[1:3]) == set(line.ends))
    curve = [rows[e][b] for b in (points if v == line.ends[0] else points[::-1])]
    for e, v, following, points in sides:
        t = [line.parameter(w) for w in (v, following) if w in line.corners()]
        if v in line.at and len(t) == 1:
            t, points = 2 * t, points[:1]
        if {v, following} & set(line.at) and len(t) == 2:
            for b, row in zip(points, _border.restricted(curve, *t)):
                rows[e][b] = row


def _sides(s, e):
    """(corner, next corner, Bezier points of the edge between them) for each edge of element e."""
    corners = s.corners[e].tolist()
    return zip(corners, corners[1:] + corners[:1], _lines(*s.degree))


def _lines(p, q):
    """Numbers of the Bezier points along the four edges, each from its corner to the next.

    >>> _lines(1, 1)
    [[0, 1], [1, 3], [3, 2], [2, 0]]
    """
    at = np.arange((p + 1) * (q + 1)).reshape(q + 1, p + 1)
    return [at[0].tolist(), at[:, p].tolist(), at[q, ::-1].tolist(), at[::-1, 0].tolist()]


def _add_plain(body, s, plain, x, own):
    """Hexahedra of the plain part, whose outer corners are new points of the bulk.

    A hanging corner depends on points of the bulk and on control points k, written as -1 - k.
    """
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
    body.ties = [(int(number[v]), k) for v, k in sorted(own.items()) if number[v] >= 0]
    known = {v: -1 - k for v, k in own.items()} | {int(v): int(number[v]) for v in corners}
    for h in sorted(s.hanging):
        if number[h] >= 0:
            row = _border.from_masters(h, known, s.hanging)
            body.hanging.append((int(number[h]), tuple(row), tuple(row.values())))
