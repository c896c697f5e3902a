"""Smooth surfaces and curved element edges of a grid of Bezier and Lagrange cells."""

import numpy as np

#: Arrays that define a cell and are not results.
GEOMETRY = ("RationalWeights", "HigherOrderDegrees")


def surface(grid, level=None):
    """The outer surface as triangles (pyvista.PolyData); each curved face is divided into 2^level
    parts per direction.

    Positions and point data are evaluated with the (rational) functions of the cell, so that a
    sphere remains a sphere. By default the level, at most 4, is chosen to give about 200,000
    triangles.
    """
    import pyvista
    from vtkmodules.vtkFiltersGeometry import vtkDataSetSurfaceFilter

    filter_ = vtkDataSetSurfaceFilter()
    filter_.SetInputData(grid)
    filter_.PassThroughCellIdsOn()
    filter_.SetNonlinearSubdivisionLevel(default_level(grid) if level is None else level)
    filter_.Update()
    return pyvista.PolyData(filter_.GetOutput()).triangulate()


def default_level(grid):
    """Subdivision level for the number of visible faces.

    >>> import types
    >>> default_level(types.SimpleNamespace(n_cells=8)), default_level(types.SimpleNamespace(n_cells=100000))
    (4, 1)
    """
    faces = 6.0 * grid.n_cells ** (2 / 3)
    return int(np.clip(np.log2(200000 / (2 * faces)) // 2, 1, 4))


def edges(grid, level=None):
    """Element edges on the outer surface as curves (pyvista.PolyData of lines)."""
    import pyvista

    level = default_level(grid) if level is None else level
    points, lines, n = [], [], 0
    for cell, edge in _outer_edges(grid):
        curve = _curve(grid.GetCell(cell).GetEdge(edge), level)
        points.append(curve)
        lines.append(np.r_[len(curve), np.arange(n, n + len(curve))])
        n += len(curve)
    return pyvista.PolyData(np.concatenate(points), lines=np.concatenate(lines))


def outline(grid, angle=25.0):
    """Sharp edges of the undeformed outer surface (pyvista.PolyData of lines)."""
    return (
        surface(grid)
        .clean()
        .extract_feature_edges(
            angle, boundary_edges=True, non_manifold_edges=False, manifold_edges=False
        )
    )


def mirrored(part, axis, odd=False):
    """A surface or lines together with their mirror image across the plane where a coordinate
    (0 1 2) is zero; parts that lie in the plane are omitted. If `odd`, the data of points have the
    opposite sign in the image.
    """
    import pyvista

    cells = part.regular_faces if part.n_lines == 0 else None
    lines = [] if cells is not None else [part.get_cell(i).point_ids for i in range(part.n_cells)]
    away = np.abs(part.points[:, axis]) > 1e-6 * max(part.length, 1e-300)
    if cells is not None:
        kept = away[cells].any(axis=1)
        half = pyvista.PolyData.from_regular_faces(part.points, cells[kept])
        for name in part.cell_data:
            half.cell_data[name] = part.cell_data[name][kept]
    else:
        kept = [ids for ids in lines if away[ids].any()]
        half = pyvista.PolyData(part.points, lines=[n for ids in kept for n in (len(ids), *ids)])
    for name in part.point_data:
        half.point_data[name] = part.point_data[name]
    other = half.copy()
    other.points[:, axis] *= -1.0
    if odd:
        for name in part.point_data:
            other.point_data[name] = -part.point_data[name]
    if cells is not None:
        other = other.flip_faces()
    return half.append_polydata(other)


def _outer_edges(grid):
    """(cell, edge of the cell) for each edge of the faces that belong to one cell only."""
    faces = {}
    for c in range(grid.n_cells):
        cell = grid.GetCell(c)
        for f in range(cell.GetNumberOfFaces()):
            corners = _corners(cell.GetFace(f))
            if len(set(corners)) > 2:
                faces.setdefault(frozenset(corners), []).append((c, corners))
    wanted = {}
    for owners in faces.values():
        if len(owners) == 1:
            c, corners = owners[0]
            for pair in zip(corners, corners[1:] + corners[:1]):
                wanted.setdefault(frozenset(pair), c)
    for c in sorted(set(wanted.values())):
        cell = grid.GetCell(c)
        ends = [frozenset(_corners(cell.GetEdge(e))) for e in range(cell.GetNumberOfEdges())]
        for e, pair in enumerate(ends):
            if len(pair) == 2 and wanted.get(pair) == c:
                del wanted[pair]
                yield c, e


def _corners(part):
    """Indices of the corner points of a face or an edge, which VTK lists first."""
    n = 2 if part.GetCellDimension() == 1 else part.GetNumberOfEdges()
    ids = part.GetPointIds()
    return [ids.GetId(i) for i in range(n)]


def _curve(edge, level):
    """(npoint, 3) points along an edge of a cell."""
    if edge.IsLinear():
        return np.array([edge.GetPoints().GetPoint(i) for i in range(2)])
    from vtkmodules.vtkCommonCore import reference

    weights, x, sub = [0.0] * edge.GetNumberOfPoints(), [0.0] * 3, reference(0)
    curve = []
    for t in np.linspace(0.0, 1.0, 2**level + 1):
        edge.EvaluateLocation(sub, [t, 0.0, 0.0], x, weights)
        curve.append(list(x))
    return np.array(curve)
