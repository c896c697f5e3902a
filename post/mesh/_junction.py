"""T-junctions below the layer, around each of which the pyramids share their peak (Corbett and
Sauer 2015, Figure 7).

All triangles that the mesher sees then share their points with their neighbours. The hanging point
remains constrained.
"""

import numpy as np

from post.mesh import _pyramids, _quality, _surface, _triangles

#: Largest number of quads that may share a peak; in larger groups each quad has a pyramid, and its
#: long side is split.
MOST = 6
GOOD = 0.2  # smallest scaled Jacobian of pyramids that may share a peak


def common_peaks(surface, form, room):
    """The Pyramids of _pyramids.build, with common peaks for quads joined by T-junctions."""
    faces, points = surface.corners, form.inner
    splits = {(a, b): s for s, (a, b, _) in surface.hanging.items()}
    single = _pyramids.build(faces, points, room, splits)
    group = _groups(surface)
    x = single.points[faces]
    peaks = single.points[len(points) :]
    height = np.einsum("mc,mc->m", peaks - x.mean(axis=1), _normals(x))
    members = [np.flatnonzero(group == g) for g in np.unique(group)]
    joined = [m for m in members if 1 < len(m) <= MOST]
    factors = np.ones(len(joined))
    for _ in range(_pyramids.ROUNDS):
        made, owner = _joined(single, faces, len(points), joined, factors, height, splits)
        cut = _triangles.intersections(made.points, made.triangles)
        cut = np.r_[owner[cut.ravel()], owner[_pyramids.folded(made.points, made.triangles)]]
        bad = [k for k, m in enumerate(joined) if np.isin(m, cut).any() or not _upright(made, m)]
        if not bad:
            break
        factors[bad] *= _pyramids.SHRINK
    else:  # the quads of unsuitable groups have a peak each
        joined = [m for k, m in enumerate(joined) if k not in bad]
        made, _ = _joined(single, faces, len(points), joined, np.ones(len(joined)), height, splits)
    return made


def _normals(x):
    return _surface.unit(np.cross(x[:, 2] - x[:, 0], x[:, 3] - x[:, 1]))


def _upright(made, members):
    """Whether the pyramids of a group are well shaped at all corners of their bases."""
    return bool((_quality.pyramids(made.points, made.cells[members])[1] > GOOD).all())


def _groups(surface):
    """(m) for each quad the number of its group; quads at the same T-junction are in one group."""
    users = {}
    for e, row in enumerate(surface.corners.tolist()):
        for a, b in zip(row, row[1:] + row[:1]):
            users[frozenset((a, b))] = [*users.get(frozenset((a, b)), []), e]
    group = np.arange(len(surface.corners))
    for s, (a, b, _) in surface.hanging.items():
        both = [users.get(frozenset(pair), []) for pair in ((a, b), (a, s), (s, b))]
        quads = sorted({e for part in both if len(part) == 1 for e in part})
        for e in quads[1:]:
            group[group == group[e]] = group[quads[0]]
    return group


def _joined(single, faces, n, joined, factors, height, splits):
    """(Pyramids, owner of each triangle) with one common peak for each group in `joined`."""
    points, cells = single.points.copy(), single.cells.copy()
    of_group = np.full(len(faces), -1)
    for k, members in enumerate(joined):
        x = points[faces[members]]
        weight = np.linalg.norm(np.cross(x[:, 2] - x[:, 0], x[:, 3] - x[:, 1]), axis=1)
        middle = np.average(x.mean(axis=1), axis=0, weights=weight)
        normal = _surface.unit(np.average(_normals(x), axis=0, weights=weight))
        points[n + members[0]] = middle + factors[k] * height[members].max() * normal
        cells[members, 4] = n + members[0]
        of_group[members] = k
    triangles, owner = _pyramids.sides(cells, splits)
    # Two triangles of one group that coincide lie between its pyramids and are dropped.
    key = np.sort(triangles, axis=1)
    _, inverse, count = np.unique(key, axis=0, return_inverse=True, return_counts=True)
    keep = count[inverse.ravel()] == 1
    return _pyramids.Pyramids(points, cells, triangles[keep]), owner[keep]
