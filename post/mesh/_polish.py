"""Move peaks of pyramids and points of the mesher to improve the worst cells.

A mesher does not change the triangles of the pyramids, even if a pyramid is badly shaped.
Here the peaks may move like the mesher's own points; the surface and the inner corners of the layer
do not move.
"""

import numpy as np

from post.mesh import _quality

TARGET = 0.12  # points of cells with a scaled Jacobian below this are moved
ROUNDS = 20
STEPS = (0.5, 0.2, 0.07, 0.02)  # distances of a move, relative to that of the second nearest point
LEAST = 1e-4  # smallest improvement for which a point is moved
#: Directions to the corners, the edges and the faces of a cube.
DIRECTIONS = np.array([d for d in np.ndindex(3, 3, 3) if d != (1, 1, 1)], dtype=float) - 1
DIRECTIONS /= np.linalg.norm(DIRECTIONS, axis=1)[:, None]


def improve(points, tets, pyramids, fixed):
    """Move the points after the first `fixed` ones in place, one after another; return the number
    of points moved.

    A point moves to the best of several positions near it, as judged by the smallest scaled
    Jacobian of its tetrahedra and pyramids; the worst value of the body never decreases.
    """
    kinds = (tets, _quality.tet_shapes), (pyramids, _quality.pyramid_shapes)
    around = [_users(cells) for cells, _ in kinds]

    def worst(v, places):
        return np.min(
            [
                shapes(_moved(points[cells[of[v]]], cells[of[v]] == v, places)).min(axis=1)
                for (cells, shapes), of in zip(kinds, around)
                if v in of
            ],
            axis=0,
        )

    changed = set()
    for _ in range(ROUNDS):
        bad = [cells[shapes(points[cells]) < TARGET].ravel() for cells, shapes in kinds]
        bad = np.unique(np.concatenate(bad))
        free = [v for v in bad[bad >= fixed].tolist() if v in around[0]]
        moved = [v for v in free if _move(points, v, tets[around[0][v]], worst)]
        changed |= set(moved)
        if not moved:
            break
    return len(changed)


def _users(cells):
    """{point: numbers of its cells}"""
    found = {}
    for k, row in enumerate(cells.tolist()):
        for v in row:
            found.setdefault(v, []).append(k)
    return found


def _moved(x, at, places):
    """x (cells, corners, 3) with the corners marked in `at` moved to each position in turn, as an
    array (positions, cells, corners, 3).
    """
    trial = np.repeat(x[None], len(places), axis=0)
    trial[:, at] = places[:, None]
    return trial


def _move(points, v, tets, worst):
    """Move point v to a better position near it, if there is one; return whether it moved."""
    others = np.unique(tets[tets != v])
    reach = np.partition(np.linalg.norm(points[others] - points[v], axis=1), 1)[1]
    for step in STEPS:
        places = np.concatenate([points[v] + step * reach * DIRECTIONS, points[v][None]])
        value = worst(v, places)
        best = int(np.argmax(value))
        if value[best] > value[-1] + LEAST:
            points[v] = places[best]
            return True
    return False
