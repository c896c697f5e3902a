"""A pyramid on every inner face of the layer, so that tetrahedra have triangles to start from."""

from dataclasses import dataclass

import numpy as np

from post._error import Unreadable
from post.mesh import _quality, _surface, _triangles

ROUNDS = 16
SHRINK = 0.75


@dataclass
class Pyramids:
    """The cells, and the closed surface of triangles from which the mesher starts."""

    points: np.ndarray  # (n, 3) inner corners of the layer, then peaks
    cells: np.ndarray  # (m, 5) the base, counter-clockwise seen from the peak, then the peak
    triangles: np.ndarray  # (k, 3) normals point out of the space that the tetrahedra will fill


def build(faces, points, thickness, splits=None, height_share=0.35, thickness_share=0.25):
    """Pyramids on faces (m, 4) of `points`, whose normals point into the body.

    thickness: (m) free depth behind the faces [L]; splits: {(a, b): s} with the hanging point s
    between two corners, at which the side triangle of that edge is split in two.
    """
    x = points[faces]
    normal = np.cross(x[:, 2] - x[:, 0], x[:, 3] - x[:, 1])
    area = 0.5 * np.linalg.norm(normal, axis=1)
    normal = _surface.unit(normal)
    middle = x.mean(axis=1)
    warp = abs(np.einsum("mkc,mc->mk", x - middle[:, None], normal)).max(axis=1)
    lower = 2 * warp
    height = np.minimum(height_share * np.sqrt(area), thickness_share * thickness)
    height = np.maximum(_raised(x, middle, normal, height, 0.35 * thickness), lower)
    n = len(points)
    cells = np.column_stack([faces, n + np.arange(len(faces))])
    triangles, owner = sides(cells, splits or {})
    for _ in range(ROUNDS):
        full = np.concatenate([points, middle + height[:, None] * normal])
        cut = _triangles.intersections(full, triangles)
        bad = np.unique(np.r_[owner[cut.ravel()], owner[folded(full, triangles)]])
        if not len(bad):
            return Pyramids(full, cells, triangles)
        if (height[bad] <= lower[bad]).all():
            break
        height[bad] = np.maximum(SHRINK * height[bad], lower[bad])
    place = "(" + ", ".join(f"{v:.4g}" for v in middle[bad[0]]) + ")"
    raise Unreadable(
        f"{len(bad)} pyramids below the layer intersect, the first at {place}; refine the net "
        "there (--refine) or use a thinner --layer"
    )


def _raised(x, middle, normal, height, limit, least=0.12):
    """The heights, increased where a long or skew face makes the pyramid too flat at a corner."""
    for _ in range(6):
        peak = middle + height[:, None] * normal
        cells = np.arange(5 * len(x)).reshape(-1, 5)
        points = np.concatenate([x, peak[:, None]], axis=1).reshape(-1, 3)
        flat = _quality.pyramids(points, cells)[1].min(axis=1) < least
        height = np.where(flat, np.maximum(height, np.minimum(1.2 * height, limit)), height)
    return height


def sides(cells, splits):
    """Side triangles, with normals out of the space that remains, and the pyramid of each."""
    triangles, owner = [], []
    for k, (a, b, c, d, peak) in enumerate(cells.tolist()):
        for u, v in ((a, b), (b, c), (c, d), (d, a)):
            chain = edge_chain(u, v, splits)
            for s, e in zip(chain[:-1], chain[1:]):
                triangles.append((e, s, peak))
                owner.append(k)
    return np.array(triangles), np.array(owner)


def edge_chain(u, v, splits):
    """Points along an edge from u to v, including the hanging ones.

    >>> edge_chain(1, 2, {(1, 2): 5, (1, 5): 7})
    [1, 7, 5, 2]
    """
    for pair in ((u, v), (v, u)):
        if pair in splits:
            s = splits[pair]
            return edge_chain(u, s, splits)[:-1] + edge_chain(s, v, splits)
    return [u, v]


def folded(points, triangles, least=8.0):
    """Triangles so close to a neighbour that no good tetrahedron fits in between."""
    a, b = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    n = len(points)
    key, twin = a * n + b, b * n + a
    order = np.argsort(key)
    at = np.minimum(np.searchsorted(key[order], twin), len(key) - 1)
    pair = order[at]
    found = key[pair] == twin
    t, u = np.arange(len(key))[found] // 3, pair[found] // 3
    x = points[triangles]
    normal = _surface.unit(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]))
    opposite = x.sum(axis=1)[u] - points[a[found]] - points[b[found]] - points[a[found]]
    inside = np.einsum("ij,ij->i", normal[t], opposite) < 0
    cosine = -np.einsum("ij,ij->i", normal[t], normal[u])
    angle = np.arccos(
        np.clip(cosine, -1, 1)
    )  # between the triangles, on the side of the tetrahedra
    return np.unique(t[inside & (angle < np.radians(least))])
