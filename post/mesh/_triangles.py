"""Triangles: where rays meet them, and which pairs intersect."""

import numpy as np

CHUNK = 2_000_000  # pairs treated at a time, to limit the memory


def first_hit(origins, directions, points, triangles, start):
    """(k) distance along each unit direction to the point where it leaves the body, or inf.

    Normals of the triangles point outward. Triangles nearer than `start` (k), and triangles through
    which the ray enters the body, are ignored.
    """
    x = points[triangles] - points.mean(axis=0)
    origins = origins - points.mean(axis=0)
    middle = x.mean(axis=1)
    radius2 = ((x - middle[:, None]) ** 2).sum(axis=2).max(axis=1) * (1 + 1e-9)
    hit = np.full(len(origins), np.inf)
    step = max(1, CHUNK // max(len(triangles), 1))
    for at in range(0, len(origins), step):
        o, d = origins[at : at + step], directions[at : at + step]
        along = d @ middle.T - np.einsum("ij,ij->i", o, d)[:, None]
        apart2 = (middle**2).sum(axis=1) - 2 * o @ middle.T + (o**2).sum(axis=1)[:, None]
        ray, tri = np.nonzero((apart2 - along**2 <= radius2) & (along >= -np.sqrt(radius2)))
        t = _meet(o[ray], d[ray], x[tri])
        good = t > start[at : at + step][ray]
        np.minimum.at(hit[at : at + step], ray[good], t[good])
    return hit


def _meet(o, d, x):
    """(k) distance along the line o + t d to the triangle x (k, 3, 3); NaN if the line misses it or
    crosses it against its normal.
    """
    e1, e2, r = x[:, 1] - x[:, 0], x[:, 2] - x[:, 0], o - x[:, 0]
    h, q = np.cross(d, e2), np.cross(r, e1)
    with np.errstate(divide="ignore", invalid="ignore"):
        f = 1 / np.einsum("ij,ij->i", e1, h)
        u, v = f * np.einsum("ij,ij->i", r, h), f * np.einsum("ij,ij->i", d, q)
        t = f * np.einsum("ij,ij->i", e2, q)
        inside = (
            (np.einsum("ij,ij->i", d, np.cross(e1, e2)) > 0)
            & (u >= -1e-9)
            & (v >= -1e-9)
            & (u + v <= 1 + 1e-9)
            & np.isfinite(t)
        )
    return np.where(inside, t, np.nan)


def intersections(points, triangles):
    """(k, 2) pairs of triangles that intersect elsewhere than at common points.

    Pairs with a common edge are not examined.
    """
    pairs = _near(points[triangles])
    cut = []
    for at in range(0, len(pairs), CHUNK // 8):
        part = pairs[at : at + CHUNK // 8]
        a, b = triangles[part[:, 0]], triangles[part[:, 1]]
        shared = (a[:, :, None] == b[:, None, :]).any(axis=2).sum(axis=1)
        part, a, b = (
            v[shared < 2] for v in (part, a, b)
        )  # pairs with a common edge are found by their dihedral angles
        bad = _edges_cut(points, a, b) | _edges_cut(points, b, a)
        cut.append(part[bad])
    return np.concatenate(cut) if cut else np.empty((0, 2), dtype=np.int64)


def _edges_cut(points, a, b):
    """Whether an edge of triangle a that shares no point with triangle b passes through b."""
    p0, e1, e2 = (
        points[b[:, 0]],
        points[b[:, 1]] - points[b[:, 0]],
        points[b[:, 2]] - points[b[:, 0]],
    )
    normal = np.cross(e1, e2)
    n2 = np.einsum("ij,ij->i", normal, normal)
    result = np.zeros(len(a), dtype=bool)
    with np.errstate(divide="ignore", invalid="ignore"):
        for i, j in ((0, 1), (1, 2), (2, 0)):
            free = ~((a[:, [i, j]][:, :, None] == b[:, None, :]).any(axis=(1, 2)))
            s, d = points[a[:, i]], points[a[:, j]] - points[a[:, i]]
            t = np.einsum("ij,ij->i", p0 - s, normal) / np.einsum("ij,ij->i", d, normal)
            r = s + t[:, None] * d - p0
            u = np.einsum("ij,ij->i", np.cross(r, e2), normal) / n2
            v = np.einsum("ij,ij->i", np.cross(e1, r), normal) / n2
            result |= free & (t >= 0) & (t <= 1) & (u >= 0) & (v >= 0) & (u + v <= 1)
    return result


def _near(x):
    """(k, 2) pairs of triangles (n, 3, 3), first < second, whose bounding boxes overlap."""
    low, high = x.min(axis=1), x.max(axis=1)
    size = np.maximum(
        np.median(high - low, axis=0).max(), np.ptp(x.reshape(-1, 3), axis=0).max() / 256
    )
    first = np.floor((low - low.min(axis=0)) / size).astype(np.int64)
    last = np.floor((high - low.min(axis=0)) / size).astype(np.int64)
    span = last - first + 1
    count = span.prod(axis=1)
    owner = np.repeat(np.arange(len(x)), count)
    k = np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)
    s = span[owner]
    cell = first[owner] + np.column_stack(
        [k % s[:, 0], k // s[:, 0] % s[:, 1], k // (s[:, 0] * s[:, 1])]
    )
    n = last.max(axis=0) + 1
    key = (cell[:, 2] * n[1] + cell[:, 1]) * n[0] + cell[:, 0]
    return _in_one_cell(key, owner, low, high)


def _in_one_cell(key, owner, low, high):
    """(k, 2) pairs of owners with a common key whose bounding boxes overlap."""
    order = np.argsort(key, kind="stable")
    owner, key = owner[order], key[order]
    found = []
    shift = 1
    while True:  # neighbours in the sorted list, at a distance that increases by one
        same = np.flatnonzero(key[shift:] == key[:-shift])
        if not len(same):
            break
        i, j = owner[same], owner[same + shift]
        overlap = ((low[i] <= high[j]) & (low[j] <= high[i])).all(axis=1)
        found.append(np.sort(np.column_stack([i[overlap], j[overlap]]), axis=1))
        shift += 1
    if not found:
        return np.empty((0, 2), dtype=np.int64)
    return np.unique(np.concatenate(found), axis=0)
