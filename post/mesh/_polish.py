"""Peaks of pyramids and points of the mesher, moved where the worst cells there get better.

A mesher keeps the triangles of the pyramids as they are, and below long quads those are bad. Peaks are
our own points, so they may move with the others; the surface and the layer's inner corners stay.
"""

import numpy as np

from post.mesh import _quality

TARGET = 0.12  # scaled Jacobian of cells whose points are moved
ROUNDS = 20
STEPS = (0.5, 0.2, 0.07, 0.02)  # of the distance to the nearest point but one
LEAST = 1e-4  # a gain that is worth a step
#: Towards corners, edges and faces of a cube.
DIRECTIONS = np.array([d for d in np.ndindex(3, 3, 3) if d != (1, 1, 1)], dtype=float) - 1
DIRECTIONS /= np.linalg.norm(DIRECTIONS, axis=1)[:, None]


def improve(points, tets, pyramids, fixed):
    """Move points after the first `fixed` ones, in place, one after the other; how many moved.

    A point goes to the best of some places near it, judged by the least scaled Jacobian of its
    tetrahedra and pyramids; the worst of a body never gets worse.
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
    """(places, cells, corners, 3): the corners x (cells, corners, 3) with those `at` there."""
    trial = np.repeat(x[None], len(places), axis=0)
    trial[:, at] = places[:, None]
    return trial


def _move(points, v, tets, worst):
    """Put point v to a better place, if there is one near; whether it moved."""
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
