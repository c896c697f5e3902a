"""Contact surfaces of a result: element faces all of whose points carry contact fields."""

from dataclasses import dataclass

import numpy as np

from post._error import Unreadable

#: This field is zero away from the contact surfaces, and nowhere zero on them.
MARK = "contact_gap"


@dataclass
class Surface:
    """Faces of one body, each sampled at a grid of n x n points. For a triangle, the last corner of
    the grid lies in the middle of an edge.

    x: (nface, n, n, 3) positions; value: (nface, n, n) the field; outward: (nface, n, n, 3)
    normals, whose length is the area of a cell of the grid.
    """

    body: int
    x: np.ndarray
    value: np.ndarray
    outward: np.ndarray


def surfaces(grid, path, values, n=None):
    """Contact surfaces of a grid, at the positions of its points: a list with one Surface per body.

    n: points per direction, by default as many as a picture needs; values: (npoint) coefficients of
    the field to show. Surfaces and field are evaluated with the (rational) functions of the faces,
    and are therefore those of the analysis.
    """
    if MARK not in grid.point_data:
        raise Unreadable(
            f"'{path}' has no contact fields; write them with OUTPut,,every n displacement contact"
        )
    marked = np.asarray(grid.point_data[MARK]) != 0
    body = np.asarray(
        grid.cell_data["body"] if "body" in grid.cell_data else np.zeros(grid.n_cells)
    )
    found, x = {}, np.asarray(grid.points, dtype=float)
    faces = list(_faces(grid, marked))
    n = n or int(np.clip(200 / max(len(faces), 1) ** 0.5, 9, 33)) | 1  # odd: a point in the middle
    for c, f in faces:
        cell = grid.GetCell(c)
        face = cell.GetFace(f)
        points, value = _evaluate(face, x, values, n)
        middle = x[[cell.GetPointId(i) for i in range(cell.GetNumberOfPoints())]].mean(axis=0)
        outward = _outward(points, middle)
        if _is_triangle(
            face
        ):  # at the last corner of the grid the two grid directions are parallel
            outward[-1, -1] = outward[-2, -2]
        found.setdefault(int(body[c]), []).append((points, value, outward))
    if not found:
        raise Unreadable(
            f"'{path}' has no contact surface: at this step no face lies near the opposite surface with all of its points"
        )
    return [Surface(b, *(np.array(a) for a in zip(*found[b]))) for b in sorted(found)]


def _faces(grid, marked):
    """Yield (cell, face) for each face whose points are all marked."""
    for c in range(grid.n_cells):
        cell = grid.GetCell(c)
        ids = [cell.GetPointId(i) for i in range(cell.GetNumberOfPoints())]
        if not marked[ids].any():
            continue
        for f in range(cell.GetNumberOfFaces()):
            face = cell.GetFace(f)
            ids = [face.GetPointId(i) for i in range(face.GetNumberOfPoints())]
            if marked[ids].all():
                yield c, f


def _evaluate(face, x, values, n):
    """Positions (n, n, 3) and values (n, n) on a face."""
    from vtkmodules.vtkCommonCore import reference

    count = face.GetNumberOfPoints()
    ids = [face.GetPointId(i) for i in range(count)]
    weights, place, sub = [0.0] * count, [0.0] * 3, reference(0)
    shape = np.empty((n, n, count))
    for i, s in enumerate(np.linspace(0.0, 1.0, n)):
        for j, t in enumerate(np.linspace(0.0, 1.0, n)):
            at = (s * (1 - t / 2), t * (1 - s / 2)) if _is_triangle(face) else (s, t)
            face.EvaluateLocation(sub, [*at, 0.0], place, weights)
            shape[i, j] = weights
    return shape @ x[ids], shape @ np.asarray(values, dtype=float)[ids]


def _is_triangle(face):
    """Whether the face is a triangle: its parameters s and t satisfy s + t <= 1, while those of a
    quadrilateral fill a square.
    """
    return face.GetNumberOfEdges() == 3


def _outward(points, inside):
    """(n, n, 3) normals of a face that point away from a point inside its element."""
    n = np.cross(np.gradient(points, axis=0), np.gradient(points, axis=1))
    middle = points.shape[0] // 2
    return n if (points[middle, middle] - inside) @ n[middle, middle] > 0 else -n
