"""A net of quads with its edges, its fans (the quads around each point) and its orientation, which
are checked before it is used.
"""

from dataclasses import dataclass, field

import numpy as np

from post._error import Unreadable


@dataclass
class Net:
    """A control net, with the hexahedra inside it if the file contains them."""

    points: np.ndarray  # (n, 3)
    quads: np.ndarray  # (m, 4) counter-clockwise seen from outside, once `checked`
    hexes: np.ndarray = field(default_factory=lambda: np.empty((0, 8), dtype=np.int64))
    sets: dict = field(default_factory=dict)  # name to (k) numbers of quads
    border: np.ndarray | None = None  # (n) whether a point is on the boundary of an open net


def checked(net, path, closed=True, orient=False):
    """The net after all checks; with `orient`, quads are reversed so that all normals point
    outward.

    Raises Unreadable with one sentence about the first error.
    """

    def fail(text):
        raise Unreadable(f"'{path}': {text}")

    _check_quads(net, fail)
    if orient:
        net.quads = oriented(net.quads, fail)
    twin = twins(net.quads, fail)
    open_edges = np.argwhere(twin < 0)
    if closed and len(open_edges):
        q, c = open_edges[0]
        a, b = net.quads[q, c], net.quads[q, (c + 1) % 4]
        fail(
            f"the surface is not closed: {len(open_edges)} edges have a quad on one side only, the "
            f"first from point {a + 1} at {_place(net.points[a])} to point {b + 1} at "
            f"{_place(net.points[b])}{_apart(net, twin)}; --open meshes an open surface"
        )
    if len(open_edges) == 0:
        volume = quad_volume(net.points, net.quads)
        if volume < 0 and orient:
            net.quads = net.quads[:, ::-1].copy()
            twin = twins(net.quads, fail)
        elif volume < 0:
            fail(
                "the normals of the quads point inward (the volume is negative); --orient reverses the quads"
            )
    _check_fans(net, twin, fail)
    net.border = np.zeros(len(net.points), dtype=bool)
    for q, c in np.argwhere(twin < 0):
        net.border[[net.quads[q, c], net.quads[q, (c + 1) % 4]]] = True
    return net


def _apart(net, twin):
    """A hint to append to the message if points of open edges coincide."""
    q, c = np.argwhere(twin < 0).T
    ends = np.unique(np.r_[net.quads[q, c], net.quads[q, (c + 1) % 4]])
    _, first, count = np.unique(net.points[ends], axis=0, return_inverse=True, return_counts=True)
    double = ends[count[first.ravel()] > 1]
    if not len(double):
        return ""
    twins = double[(net.points[double] == net.points[double[0]]).all(axis=1)]
    return f" (points {twins[0] + 1} and {twins[1] + 1} coincide; merge them)"


def _place(x):
    return "(" + ", ".join(f"{v:.4g}" for v in x) + ")"


def _check_quads(net, fail):
    repeated = np.array([len(set(q)) < 4 for q in net.quads.tolist()])
    if repeated.any():
        fail(f"quad {np.flatnonzero(repeated)[0] + 1} is degenerate: it has a duplicate point")
    x = net.points[net.quads]
    size = np.linalg.norm(x.max(axis=1) - x.min(axis=1), axis=1)
    area = np.linalg.norm(np.cross(x[:, 2] - x[:, 0], x[:, 3] - x[:, 1]), axis=1)
    edge = np.linalg.norm(np.roll(x, -1, axis=1) - x, axis=2).min(axis=1)
    flat = np.flatnonzero((area <= 1e-8 * size**2) | (edge <= 1e-8 * size))
    if len(flat):
        fail(f"quad {flat[0] + 1} is degenerate: it has no area, or an edge without length")
    key = np.sort(net.quads, axis=1)
    _, first, count = np.unique(key, axis=0, return_index=True, return_counts=True)
    if (count > 1).any():
        fail(f"duplicate quad {first[count > 1][0] + 1}")


def twins(quads, fail=None):
    """(m, 4) for edge c of quad q: the number 4 r + d of the same edge, d, in the neighbour r, or
    -1.

    Edge c of quad q runs from corner c to corner c + 1.

    >>> twins(np.array([[0, 1, 2, 3], [1, 4, 5, 2]])).tolist()
    [[-1, 7, -1, -1], [-1, -1, -1, 1]]
    """
    start, end = quads.ravel(), np.roll(quads, -1, axis=1).ravel()
    n = int(quads.max()) + 1
    forward, backward = start * n + end, end * n + start
    order = np.argsort(forward, kind="stable")
    ordered = forward[order]
    double = np.flatnonzero(ordered[1:] == ordered[:-1])
    if len(double):
        edge, other = order[double[0]], order[double[0] + 1]
        users = np.count_nonzero((forward == forward[edge]) | (backward == forward[edge]))
        if users > 2:
            fail(f"{users} quads meet at the edge of points {start[edge] + 1} and {end[edge] + 1}")
        fail(
            f"quads {edge // 4 + 1} and {other // 4 + 1} are neighbours of opposite orientation; "
            "--orient reverses one of them"
        )
    at = np.minimum(np.searchsorted(ordered, backward), len(ordered) - 1)
    return np.where(ordered[at] == backward, order[at], -1).reshape(quads.shape)


def oriented(quads, fail):
    """The quads, reversed where they do not have the orientation of the first quad of their
    part.
    """
    users = {}
    for q, row in enumerate(quads.tolist()):
        for c in range(4):
            users.setdefault(frozenset((row[c], row[(c + 1) % 4])), []).append((q, c))
    for edge, both in users.items():
        if len(both) > 2:
            a, b = sorted(edge)
            fail(f"{len(both)} quads meet at the edge of points {a + 1} and {b + 1}")
    turned = np.zeros(len(quads), dtype=int)  # 0 unknown, 1 as in the file, -1 reversed
    for seed in range(len(quads)):
        stack = [] if turned[seed] else [seed]
        turned[seed] = turned[seed] or 1
        while stack:
            q = stack.pop()
            for c in range(4):
                a, b = quads[q, c], quads[q, (c + 1) % 4]
                for r, d in users[frozenset((int(a), int(b)))]:
                    sign = turned[q] * (-1 if quads[r, d] == a else 1)
                    if r != q and turned[r] == 0:
                        turned[r] = sign
                        stack.append(r)
                    elif r != q and turned[r] != sign:
                        fail("the surface has one side only (a Moebius strip) and encloses no body")
    return np.where((turned < 0)[:, None], quads[:, ::-1], quads)


def quad_volume(points, quads):
    """The enclosed volume, with two triangles per quad, positive if normals point outward [L^3]."""
    a, b, c, d = (points[quads[:, k]] for k in range(4))
    return (np.einsum("ij,ij", a, np.cross(b, c)) + np.einsum("ij,ij", a, np.cross(c, d))) / 6


def fans(quads, twin):
    """The corners (q, c) around each point in order, starting at a boundary edge if there is one.

    The corner after (q, c) belongs to the quad across the edge that ends at (q, c).
    Returns (fans by point, points with more than one fan).
    """
    seen = np.zeros(quads.shape, dtype=bool)
    result, pinched = {}, set()
    start_at_border = np.argwhere(twin < 0)  # the edge that starts at (q, c) has no neighbour
    for q, c in [*start_at_border.tolist(), *np.argwhere(twin >= 0).tolist()]:
        if seen[q, c]:
            continue
        fan = []
        while not seen[q, c]:
            seen[q, c] = True
            fan.append((q, c))
            other = int(twin[q, c - 1])
            if other < 0:
                break
            q, c = divmod(other, 4)
        vertex = int(quads[fan[0]])
        if vertex in result:
            pinched.add(vertex)
        result[vertex] = fan
    return result, pinched


def _check_fans(net, twin, fail):
    around, pinched = fans(net.quads, twin)
    if pinched:
        v = min(pinched)
        fail(f"the surface touches itself at the single point {v + 1}, {_place(net.points[v])}")
    for v, fan in around.items():
        if len(fan) < 3 and all(twin[q, c] >= 0 and twin[q, c - 1] >= 0 for q, c in fan):
            fail(
                f"point {v + 1} has {len(fan)} quads around it; an interior point needs at least three"
            )
    parts = components(net.quads)
    if parts > 1:
        fail(f"the surface has {parts} separate parts; mesh one body at a time")


def components(quads):
    """Number of parts of a net that are not connected to each other.

    >>> components(np.array([[0, 1, 2, 3], [4, 5, 6, 7]]))
    2
    """
    label = np.arange(quads.max() + 1)
    while True:
        low = label[quads].min(axis=1)
        new = label.copy()
        np.minimum.at(new, quads.ravel(), np.repeat(low, 4))
        new = new[new]
        if (new == label).all():
            return len(np.unique(label[quads]))
        label = new


def refined(net):
    """The net after one Catmull-Clark step, which makes four quads of each; open boundaries become
    cubic B-splines.
    """
    quads, x = net.quads, net.points
    twin = twins(quads)
    n, m = len(x), len(quads)
    middle = x[quads].mean(axis=1)
    first = np.where(
        twin < 0, np.arange(4 * m).reshape(m, 4), np.minimum(np.arange(4 * m).reshape(m, 4), twin)
    )  # the number of an edge is the same on both sides
    edges, number = np.unique(first, return_inverse=True)
    number = number.reshape(m, 4)
    q, c = edges // 4, edges % 4
    ends = 0.5 * (x[quads[q, c]] + x[quads[q, (c + 1) % 4]])
    other = twin[q, c]
    inner = other >= 0
    middles = ends.copy()
    middles[inner] = 0.5 * ends[inner] + 0.25 * (middle[q[inner]] + middle[other[inner] // 4])
    corners = _moved(net, twin, middle, ends, number, x)
    fine = [
        np.column_stack(
            [quads[:, k], n + m + number[:, k], n + np.arange(m), n + m + number[:, k - 1]]
        )
        for k in range(4)
    ]
    sets = {name: np.concatenate([4 * ids + k for k in range(4)]) for name, ids in net.sets.items()}
    order = np.arange(4 * m).reshape(4, m).T.ravel()
    border = np.concatenate([net.border, np.zeros(m, dtype=bool), ~inner])
    return Net(np.concatenate([corners, middle, middles]), np.concatenate(fine)[order], sets=sets,
               border=border)  # fmt: skip


def _moved(net, twin, middle, ends, number, x):
    """The old points P after the step: (F + 2 R + (n - 3) P)/n inside, where F and R are the means
    of the middles of the n quads and n edges around P, and (a + 6 P + b)/8 at a boundary, where a
    and b are the neighbours of P on the boundary. A point of the boundary with one quad does not move.
    """
    result = x.copy()
    for v, fan in fans(net.quads, twin)[0].items():
        n = len(fan)
        if net.border[v]:
            first, last = fan[0], fan[-1]
            a, b = ends[number[first]], ends[number[last[0], last[1] - 1]]
            result[v] = x[v] if n == 1 else 0.25 * (a + b) + 0.5 * x[v]
        else:
            f = np.mean([middle[q] for q, _ in fan], axis=0)
            r = np.mean([ends[number[q, c]] for q, c in fan], axis=0)
            result[v] = (f + 2 * r + (n - 3) * x[v]) / n
    return result
