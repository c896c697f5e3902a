"""A picture of one T-junction below the layer, like Figure 7 of Corbett and Sauer 2015."""

import numpy as np

from post._error import Unreadable
from post.mesh import _draw, _surface


def draw(body, path, near=None):
    """Draw three panels around the T-junction nearest to the point `near` (None: around the first
    one): the surface with the bases, the pyramids with their common peak, and the adjacent
    tetrahedra. Only T-junctions with a common peak are considered.
    """
    s, cells = body.whole, body.cells["pyramids"]
    quads = _quads(body, near)
    ring = np.flatnonzero(np.isin(s.corners, np.unique(s.corners[quads])).any(axis=1))
    rest = np.setdiff1d(ring, quads)
    bases = _flat(body, s.corners[quads], "#9aa7b5")
    skin = _lines(s, ring)
    peaks = np.unique(cells[quads])
    tets = body.cells["tets"]
    tets = tets[np.isin(tets, peaks).sum(axis=1) >= 3]
    pyramids = [part for k in quads for part in _cells(body, cells[k : k + 1], "pyramids")]
    scenes = [
        (
            [skin, bases, _flat(body, s.corners[rest], "#e6e6e6")],
            "(a) surface (red), bases of three quads",
        ),
        (pyramids, "(b) three pyramids, one peak"),
        (pyramids + _cells(body, tets, "tets"), "(c) with the tetrahedra on them"),
    ]
    normal, _ = _surface.corner_normals(s)
    x = body.points[np.unique(s.corners[quads])]
    along = body.points[s.corners[quads[0], 1]] - body.points[s.corners[quads[0], 0]]
    outward = normal[np.unique(s.corners[quads])].mean(axis=0)
    # Seen from inside at a slight angle, so that the pyramids point up.
    view = -outward + 0.9 * along / np.linalg.norm(along)
    size = 1.6 * np.ptp(x, axis=0).max()
    box = np.ravel(np.column_stack([x.mean(axis=0) - 0.5 * size, x.mean(axis=0) + 0.5 * size]))
    _draw.compose(scenes, view, path, columns=3, up=tuple(-outward), box=box)


def _quads(body, near):
    """The quads of three pyramids with a common peak."""
    peak = body.cells["pyramids"][:, 4]
    shared, count = np.unique(peak, return_counts=True)
    shared = shared[count == 3]
    if not len(shared):
        raise Unreadable(
            "the body has no T-junction with a common peak; mesh it with --split and --t-junction peak"
        )
    k = 0
    if near is not None:
        k = np.argmin(np.linalg.norm(body.points[shared] - near, axis=1))
    return np.flatnonzero(peak == shared[k])


def _flat(body, corners, colour):
    """Faces on the inner side of the layer."""
    import pyvista

    mesh = pyvista.PolyData(
        body.points, np.column_stack([np.full(len(corners), 4), corners]).ravel()
    )
    return mesh, mesh.extract_all_edges(), colour, "#202020"


def _lines(s, chosen):
    """Edges of the elements of the surface in red, without faces."""
    import pyvista

    _, edges, _ = _draw.surface_part(s, chosen)
    return pyvista.PolyData(edges.points[:1]), edges, "#ffffff", "#c0392b"


def _cells(body, cells, kind):
    import pyvista

    if not len(cells):
        return []
    polygons = [np.r_[len(f), row[list(f)]] for row in cells for f in _draw.FACES[kind]]
    mesh = pyvista.PolyData(body.points, np.concatenate(polygons))
    return [(mesh, mesh.extract_all_edges(), _draw.COLOURS[kind], "#202020")]
