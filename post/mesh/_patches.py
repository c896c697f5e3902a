"""Bicubic elements from a net of quads: approximate Catmull-Clark patches.

Each vertex P of a quad has a face point: the mean of P with weight n, its two neighbours in the quad
with weight 2 and the opposite vertex with weight 1, where n is the valence of P and n + 5 the sum of
the weights. An edge point near P is the mean of the two face points of P beside the edge, and the
corner at P is the mean of the face points around P (Loop and Schaefer 2008). On a boundary, the edge
point is (2 P + neighbour) / 3, and the corner is the mean of two edge points. The rows of
coefficients sum to one and have no negative entries. If all four vertices of a quad have valence 4,
its rows are those of the uniform cubic B-spline.
"""

import numpy as np

from post.mesh._net import fans, twins
from post.mesh._surface import Surface

#: Positions i + 4 j among the 16 Bezier points: of the corners, and of the points next to them.
CORNER = (0, 3, 15, 12)
FACE = (5, 6, 10, 9)
AHEAD = (1, 7, 14, 8)  # on the edge that starts at the corner, near it
BEHIND = (4, 2, 11, 13)  # on the edge that ends at the corner, near it


def extract(net):
    """The Surface of a net that was `checked`; x_xi x x_eta points into the body."""
    quads = net.quads[:, ::-1].copy()  # the enriched face is zeta = -1 of a hexahedron
    used, inverse = np.unique(quads, return_inverse=True)
    quads = inverse.reshape(quads.shape)
    border = net.border[used]
    twin = twins(quads)
    around, _ = fans(quads, twin)
    rows = [[None] * 16 for _ in quads]
    face = _face_points(quads, around, border)
    for v, fan in around.items():
        edges = [_ahead(quads, twin, face, q, c) for q, c in fan]
        if border[v]:
            edges.append(_thirds(quads, *fan[-1], behind=True))
            corner = {v: 1.0} if len(fan) == 1 else _mean([edges[0], edges[-1]])
        else:
            edges.append(edges[0])
            corner = _mean([face[q][c] for q, c in fan])
        for k, (q, c) in enumerate(fan):
            rows[q][CORNER[c]], rows[q][FACE[c]] = corner, face[q][c]
            rows[q][AHEAD[c]], rows[q][BEHIND[c]] = edges[k], edges[k + 1]
    nodes, coefficients = tables(rows)
    sets = {name: np.array(ids) for name, ids in net.sets.items()}
    points = net.points[used]
    weights = np.ones(len(points))
    return Surface((3, 3), points, weights, nodes, coefficients, quads, sets)


def tables(rows):
    """([node numbers], [(n, 16) coefficients]) of elements given as 16 rows {node: coefficient}."""
    nodes, coefficients = [], []
    for element in rows:
        ids = sorted(set().union(*element))
        place = {v: k for k, v in enumerate(ids)}
        c = np.zeros((len(ids), len(element)))
        for b, row in enumerate(element):
            for v, value in row.items():
                c[place[v], b] = value
        nodes.append(np.array(ids))
        coefficients.append(c)
    return nodes, coefficients


def _face_points(quads, around, border):
    """[q][c] the face point of quad q near its corner c, as {vertex: weight}."""
    face = [[None] * 4 for _ in quads]
    for v, fan in around.items():
        n = len(fan)
        if border[v]:
            n = max(2 * n, 4)
        for q, c in fan:
            row = quads[q]
            weights = (n, 2, 1, 2)
            face[q][c] = {int(row[(c + k) % 4]): w / (n + 5) for k, w in enumerate(weights)}
    return face


def _ahead(quads, twin, face, q, c):
    other = int(twin[q, c])
    if other < 0:
        return _thirds(quads, q, c)
    r, d = divmod(other, 4)
    return _mean([face[q][c], face[r][(d + 1) % 4]])


def _thirds(quads, q, c, behind=False):
    return {int(quads[q, c]): 2 / 3, int(quads[q, c - 1 if behind else (c + 1) % 4]): 1 / 3}


def _mean(rows):
    """
    >>> _mean([{1: 1.0}, {1: 0.5, 2: 0.5}])
    {1: 0.75, 2: 0.25}
    """
    total = {}
    for row in rows:
        for v, w in row.items():
            total[v] = total.get(v, 0.0) + w
    return {v: w / len(rows) for v, w in total.items()}
