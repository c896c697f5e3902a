"""Errors of one solution of the cube relative to another, over the volume and over the face x =
0.5.

Displacements come from the result file and are evaluated with the functions of the cells. Stresses
come from a curve of the program at POINTS, so that enhanced strains are included.
"""

import numpy as np

from post import _grid
from post._table import read_table

FACE = 0.5  # x of the face that is enriched first
ORDER = 4  # Gauss points per direction in each cell


def gauss(n, low, high):
    """(n) points and weights on an interval."""
    x, w = np.polynomial.legendre.leggauss(n)
    return 0.5 * (low + high) + 0.5 * (high - low) * x, 0.5 * (high - low) * w


def _product(x, y, z):
    """(npoint, 4) with x, y, z and weight; each argument is a list of (points, weights)."""
    lines = [np.concatenate([np.stack(part, 1) for part in d]) for d in (x, y, z)]
    return np.array(
        [
            [a[0], b[0], c[0], a[1] * b[1] * c[1]]
            for a in lines[0]
            for b in lines[1]
            for c in lines[2]
        ]
    )


#: Points where stresses are compared; none of them lies on an element boundary of any mesh. On the
#: face, the quarters of its height next to the clamped ends are excluded, since stresses are
#: singular there.
POINTS = {
    "volume": _product([gauss(4, 0, 0.5)], [gauss(6, 0, 0.5)], [gauss(4, 0, 0.5), gauss(4, 0.5, 1)]),
    "face": _product([(np.array([FACE]), np.ones(1))], [gauss(6, 0, 0.5)], [gauss(8, 0.25, 0.75)]),
}  # fmt: skip


class Solution:
    """The final state of a run of the cube."""

    def __init__(self, stem, exact=False):
        """stem: the stem of the run's files; exact: prepare for `at`, which needs cells of equal
        size.
        """
        self.stem = stem
        self.grid = _grid.load(f"{stem}.vtkhdf")[0]
        self.u = np.asarray(self.grid.point_data["displacement"], float)
        self.x = np.asarray(self.grid.points, float)
        self.cells = [
            np.array([c.GetPointId(i) for i in range(c.GetNumberOfPoints())])
            for c in (self.grid.GetCell(i) for i in range(self.grid.n_cells))
        ]
        if exact:
            self._prepare()

    def mises(self):
        """{place: von Mises stress at POINTS[place]}"""
        columns = read_table(f"{self.stem}_points.dat").columns
        values = [v[-1] for n, v in columns.items() if n.startswith("stress")]
        s = np.array(values).reshape(-1, 6)  # 11 22 33 12 23 31
        d = s[:, :3] - s[:, :3].mean(1, keepdims=True)
        mises = np.sqrt(1.5 * (d**2).sum(1) + 3 * (s[:, 3:] ** 2).sum(1))
        n = len(POINTS["volume"])
        return {"volume": mises[:n], "face": mises[n:]}

    def errors(self, best):
        """{column: relative L2 error}; of the displacements on the face, only the component along
        its normal is compared.
        """
        x, u, w = self.samples(on_face=False)
        found = {"displacement_volume": _norm(u - best.at(x), w) / _norm(best.at(x), w)}
        x, u, w = self.samples(on_face=True)
        normal = best.at(x)[:, :1]
        found["displacement_face"] = _norm(u[:, :1] - normal, w) / _norm(normal, w)
        mine, right = self.mises(), best.mises()
        for place, points in POINTS.items():
            w, r = points[:, 3], right[place][:, None]
            found[f"mises_{place}"] = _norm(mine[place][:, None] - r, w) / _norm(r, w)
        return found

    def samples(self, on_face):
        """Positions (n,3), displacements (n,3) and weights (n) at the Gauss points of all cells or,
        with `on_face`, of their sides on the face.
        """
        x, u, w = [], [], []
        known = {}
        for i, ids in enumerate(self.cells):
            kind = self._kind(i)
            if kind not in known:
                known[kind] = [_rule(self.grid.GetCell(i), side) for side in _sides(on_face)]
            for values, slopes, weights in known[kind]:
                where = values @ self.x[ids]
                if on_face and np.abs(where[:, 0] - FACE).max() > 1e-9:
                    continue
                tangents = [s @ self.x[ids] for s in slopes]
                size = np.cross(tangents[0], tangents[1])
                if on_face:
                    size = np.linalg.norm(size, axis=1)
                else:
                    size = np.abs((size * tangents[2]).sum(1))
                x.append(where)
                u.append(values @ self.u[ids])
                w.append(weights * size)
        return np.concatenate(x), np.concatenate(u), np.concatenate(w)

    def _kind(self, i):
        degree = self.grid.cell_data.get("HigherOrderDegrees")
        return self.grid.celltypes[i], () if degree is None else tuple(degree[i])

    def _prepare(self):
        """Bezier coefficients in the order of the lattice of cells: coefficient[cell] (p+1, p+1,
        p+1, 3).
        """
        low = np.array([self.x[ids].min(0) for ids in self.cells])
        self.h = self.x[self.cells[0]].max(0) - low[0]
        p = round(len(self.cells[0]) ** (1 / 3)) - 1
        place = np.rint(low / self.h).astype(int)
        self.shape = place.max(0) + 1
        self.coefficient = np.zeros((*self.shape, p + 1, p + 1, p + 1, 3))
        for at, lo, ids in zip(place, low, self.cells):
            i, j, k = np.rint(p * (self.x[ids] - lo) / self.h).astype(int).T
            self.coefficient[tuple(at)][i, j, k] = self.u[ids]

    def at(self, x):
        """(n,3) displacements at reference positions."""
        cell = np.clip(np.floor(x / self.h).astype(int), 0, self.shape - 1)
        t = x / self.h - cell
        p = self.coefficient.shape[3] - 1
        b = _bernstein(p, t)  # (n, 3, p+1)
        c = self.coefficient[tuple(cell.T)]
        return np.einsum("ni,nj,nk,nijkd->nd", b[:, 0], b[:, 1], b[:, 2], c)


def _bernstein(p, t):
    from math import comb

    return np.stack([comb(p, i) * t**i * (1 - t) ** (p - i) for i in range(p + 1)], -1)


def _norm(v, w):
    return np.sqrt((w[:, None] * v**2).sum())


def _sides(on_face):
    return [(d, end) for d in range(3) for end in (0.0, 1.0)] if on_face else [None]


def _rule(cell, side):
    """(values (nq, npoint), their parametric derivatives, weights (nq)) of a cell or of its
    side.
    """
    t, w = gauss(ORDER, 0.0, 1.0)
    free = [d for d in range(3) if side is None or d != side[0]]
    points, weights = [], []
    for index in np.ndindex(*(ORDER,) * len(free)):
        point = np.zeros(3)
        if side is not None:
            point[side[0]] = side[1]
        point[free] = t[list(index)]
        points.append(point)
        weights.append(np.prod(w[list(index)]))
    step = 1e-4  # the functions are at most cubic, so central differences are accurate to 1e-8
    slopes = [
        (_values(cell, points + step * np.eye(3)[d]) - _values(cell, points - step * np.eye(3)[d])) / (2 * step)
        for d in free
    ]  # fmt: skip
    return _values(cell, points), slopes, np.array(weights)


def _values(cell, points):
    from vtkmodules.vtkCommonCore import reference

    rows = []
    for point in points:
        weights, x, sub = [0.0] * cell.GetNumberOfPoints(), [0.0] * 3, reference(0)
        cell.EvaluateLocation(sub, list(point), x, weights)
        rows.append(weights)
    return np.array(rows)
