"""Split elements into four, and find hanging corners, even in files that do not list the
corners.
"""

import numpy as np

from post._error import Unreadable
from post.mesh import _border, _surface
from post.mesh._surface import Surface

TOLERANCE = 1e-9  # for values of functions, which are between 0 and 1


def halves(p):
    """Two (p+1, p+1) matrices, which give the Bezier points of the lower and of the upper half.

    >>> halves(1)[0].tolist()
    [[1.0, 0.0], [0.5, 0.5]]
    """
    low = np.zeros((p + 1, p + 1))
    row = np.eye(p + 1)
    for k in range(p + 1):
        low[k] = row[0]
        row = 0.5 * (row[:-1] + row[1:])
    return low, low[::-1, ::-1]


def split(surface, chosen):
    """The surface with the chosen elements (m, bool) split into four, and its hanging corners.

    Sub-element 4 k + c of the k-th chosen element lies at its corner c. Sub-elements come last, in
    the order of `chosen`. The functions do not change.
    """
    p, q = surface.degree
    (lp, up), (lq, uq) = halves(p), halves(q)
    quarter = [np.kron(a, b).T for a, b in ((lq, lp), (lq, up), (uq, up), (uq, lp))]
    kept = np.flatnonzero(~chosen)
    corners, middles = _new_corners(surface, chosen)
    nodes = [surface.nodes[e] for e in kept]
    rows = [surface.coefficients[e] for e in kept]
    for e in np.flatnonzero(chosen):
        for c in range(4):
            part = surface.coefficients[e] @ quarter[c]
            used = abs(part).max(axis=1) > 0
            nodes.append(surface.nodes[e][used])
            rows.append(part[used])
    place = _places(chosen)
    sets = {k: np.sort(np.concatenate([place[e] for e in ids])) for k, ids in surface.sets.items()}
    corners = np.concatenate([surface.corners[kept], corners])
    hanging = surface.hanging | {s: (a, b, 0.5) for (a, b), s in middles.items()}
    hanging = _still(hanging, _border.edges(corners))
    return Surface(
        surface.degree, surface.points, surface.weights, nodes, rows, corners, sets, hanging
    )


def _places(chosen):
    """For each old element, the numbers of the elements that replace it."""
    kept = np.cumsum(~chosen) - 1
    late = np.count_nonzero(~chosen) + 4 * (np.cumsum(chosen) - 1)
    return [np.arange(late[e], late[e] + 4) if chosen[e] else [kept[e]] for e in range(len(chosen))]


def _still(hanging, edges):
    """Those hanging corners that actually hang on an edge of an element or on a part of such an
    edge.

    >>> _still({5: (1, 2, 0.5), 6: (1, 5, 0.5), 7: (3, 4, 0.5)}, {frozenset((1, 2))})
    {5: (1, 2, 0.5), 6: (1, 5, 0.5)}
    """
    result = {}
    while True:
        more = {s: m for s, m in hanging.items() if frozenset(m[:2]) in edges and s not in result}
        if not more:
            return result
        result |= more
        edges = edges.union(
            *({frozenset((a, s)), frozenset((s, b))} for s, (a, b, _) in more.items())
        )


def _new_corners(surface, chosen):
    """((4 k, 4) corners of the sub-elements, {sorted (a, b): midpoint of that edge})."""
    n = int(surface.corners.max()) + 1
    middles, result = {}, []
    known = {tuple(sorted(m[:2])): s for s, m in surface.hanging.items() if m[2] == 0.5}
    for row in surface.corners[chosen].tolist():
        mids = []
        for c in range(4):
            key = tuple(sorted((row[c], row[(c + 1) % 4])))
            if key not in middles:
                middles[key] = known.get(key, n)
                n += key not in known
            mids.append(middles[key])
        for c in range(4):
            # Rotated to the order of the parent, so that the parametric directions do not change.
            around = [row[c], mids[c], n, mids[c - 1]]
            result.append([around[(k - c) % 4] for k in range(4)])
        n += 1
    return np.array(result, dtype=np.int64).reshape(-1, 4), middles


def find_corners(nodes, coefficients, index):
    """(m, 4) numbers of the corners of elements from a file.

    Two corners are the same if their {function: value} agree.
    """
    known, corners = {}, np.empty((len(nodes), 4), dtype=np.int64)
    for e, (ids, c) in enumerate(zip(nodes, coefficients)):
        for k, b in enumerate(index):
            row = [(int(i), round(float(v), 8)) for i, v in zip(ids, c[:, b]) if abs(v) > TOLERANCE]
            corners[e, k] = known.setdefault(frozenset(row), len(known))
    return corners


def find_hanging(surface):
    """{corner: (a, b, tau)} of the corners inside an edge of a larger element, at T-junctions.

    Such a corner s lies on an edge a-b that has no neighbour, while the edges a-s and s-b of
    smaller elements have none either; tau is the parameter on a-b where the functions have their
    values at s. The next corner on the same edge hangs on s-b.
    """
    count = {}
    for e, row in enumerate(surface.corners.tolist()):
        for c in range(4):
            count.setdefault(frozenset((row[c], row[(c + 1) % 4])), []).append((e, c))
    single = {key: users[0] for key, users in count.items() if len(users) == 1}
    beside = {}
    for key in single:
        for v in key:
            beside.setdefault(v, set()).update(key - {v})
    hanging = {}
    for e, c in single.values():
        a, b = surface.corners[e, c], surface.corners[e, (c + 1) % 4]
        start, low, end = int(a), 0.0, int(b)
        for s, t in _chain(surface, e, c, (start, end), beside, single):
            hanging[s] = (start, end, (t - low) / (1 - low))
            start, low = s, t
    return hanging


def _chain(surface, e, c, ends, beside, single):
    """[(corner, parameter)] on edge c of element e, from end to end; empty without such corners."""
    found, v, t = [], ends[0], 0.0
    while not found or ends[1] not in beside[v]:
        places = ((s, _parameter(surface, e, c, s, single)) for s in sorted(beside[v] - {*ends}))
        v, t = next(((s, u) for s, u in places if u is not None and u > t), (None, None))
        if v is None:
            return []
        found.append((v, t))
    return found


def _parameter(surface, e, c, s, single):
    """The parameter of edge c of element e where the functions have the values that they have at
    corner s.
    """
    other, d = next(
        (f, surface.corners[f].tolist().index(s)) for key, (f, _) in single.items() if s in key
    )
    index = surface.corner_index
    want = dict(zip(surface.nodes[other].tolist(), surface.coefficients[other][:, index[d]]))
    target = np.array([want.get(i, 0.0) for i in surface.nodes[e].tolist()])
    if abs(target.sum() - 1) > 1e-6:
        return None  # a function that is not one of the element's is non-zero at the corner
    start, end = (np.array([(-1.0, -1), (1, -1), (1, 1), (-1, 1)])[k] for k in (c, (c + 1) % 4))

    def miss(tau):
        xi, eta = start + tau * (end - start)
        p, q = surface.degree
        u, v = _surface.bernstein(p, [xi])[0], _surface.bernstein(q, [eta])[0]
        return abs(surface.coefficients[e] @ np.outer(v, u).ravel() - target).max()

    grid = np.linspace(0, 1, 33)
    k = int(np.argmin([miss(t) for t in grid]))
    low, high = grid[max(k - 1, 0)], grid[min(k + 1, 32)]
    for _ in range(90):
        third = (high - low) / 3
        low, high = (
            (low, high - third) if miss(low + third) < miss(high - third) else (low + third, high)
        )
    tau = min((grid[k], 0.5 * (low + high)), key=miss)
    return float(tau) if miss(tau) < 1e-7 and 0 < tau < 1 else None


def check_corners(surface, path, closed):
    """The edges without a neighbour, where the surface is open or its elements do not match.

    Raises Unreadable if neighbours have opposite orientations, or if there are such edges although
    the surface must be closed.
    """
    count = {}
    for row in surface.corners.tolist():
        for a, b in zip(row, row[1:] + row[:1]):
            count[a, b] = count.get((a, b), 0) + 1
    if any(v > 1 for v in count.values()):
        raise Unreadable(f"'{path}': neighbouring elements have opposite orientations")
    chained = {
        edge
        for s, (a, b, _) in surface.hanging.items()
        for edge in ((a, b), (b, a), (a, s), (s, a), (s, b), (b, s))
    }
    lone = [e for e in count if (e[1], e[0]) not in count and e not in chained]
    if lone and closed:
        raise Unreadable(
            f"'{path}': the surface is not closed: {len(lone)} edges of elements have no neighbour; "
            "--open meshes an open surface"
        )
    return lone
