"""The body: an enriched layer below a surface, the cells inside, constraints and groups."""

from dataclasses import dataclass, field

import numpy as np

from post._error import Unreadable
from post.mesh import (
    _enrich,
    _hexes,
    _junction,
    _layer,
    _polish,
    _pyramids,
    _quality,
    _surface,
    _tets,
)

_OPTION = {"factor": "layer", "constant": "thickness"}
EMPTY = {"tets": 4, "pyramids": 5, "hexes": 8}


@dataclass
class Body:
    """The contents of the files that are written. Points are numbered from 0 here."""

    surface: object  # the enriched part, a Surface; point k of the bulk lies below corner k
    points: np.ndarray  # (n, 3) of the bulk: first the inner corners of the layer
    cells: dict  # tets (k,4), pyramids (k,5), hexes (k,8)
    #: (slave, masters, coefficients) for points of the bulk; a master -1 - k is control point k.
    hanging: list = field(default_factory=list)
    ties: list = field(default_factory=list)  # pairs (bulk point, control point) that coincide
    whole: object = None  # the Surface before a part of it was made plain
    form: object = None  # the Layer of the whole surface
    plain: np.ndarray | None = None  # (k, 4) outer points of the faces in the plain part
    plain_sets: dict = field(default_factory=dict)  # name to (k) numbers of faces in the plain part
    #: Worst shapes of the tetrahedra before any points were moved, and the number of points moved.
    mesher: dict = field(default_factory=dict)


def build(surface, net=None, interior="tets", mesher="gmsh", size=None, enrich=None, heights=None,
          junction="constraint", fine=()):  # fmt: skip
    """The Body below a surface.

    interior: tets, hexes (those of the net) or none; enrich: (m) whether an element remains a
    spline, None for all of them; heights: options of _layer.build; junction: constraint or peak;
    fine: regions with smaller tetrahedra, in the form that _tets.places takes.
    """
    given = {
        "--size": size,
        **{f"--{_OPTION[k]}": v for k, v in (heights or {}).items() if k in _OPTION},
    }
    for name, value in given.items():
        if value is not None and not 0 < value < np.inf:
            raise Unreadable(f"{name} {value:g}: expected a positive length or ratio")
    if interior == "hexes":  # hexahedra leave less room for a layer than tetrahedra
        heights = {"factor": 0.3, "thickness_share": 0.15} | (heights or {})
    form = _layer.build(surface, **(heights or {}))
    points, cells, made = fill(surface, form, net, interior, mesher, size, junction, fine)
    hanging = [(s, (a, b), (1 - tau, tau)) for s, (a, b, tau) in sorted(surface.hanging.items())]
    body = Body(surface, points, cells, hanging, whole=surface, form=form, mesher=made)
    if enrich is not None and not enrich.all():
        _enrich.make_partial(body, enrich)
    return body


def fill(surface, form, net, interior, mesher, size, junction, fine=()):
    """(points, cells, Body.mesher) of the inside.

    The layer's inner corners come first and do not move.
    """
    cells = {kind: np.empty((0, n), dtype=np.int64) for kind, n in EMPTY.items()}
    if interior == "none":
        return form.inner, cells, {}
    if interior == "hexes":
        if net is None or not len(net.hexes):
            raise Unreadable(
                "the file has no hexahedra that could fill the inside; use --interior tets"
            )
        points, cells["hexes"] = _hexes.reuse(net, surface, form)
        return points, cells, {}
    room = form.thickness[surface.corners].min(axis=1)
    room = np.maximum(room - 2 * form.height[surface.corners].max(axis=1), 0)
    splits = {(a, b): s for s, (a, b, _) in surface.hanging.items()}
    if splits and junction == "peak":
        made = _junction.common_peaks(surface, form, room)
    else:
        made = _pyramids.build(surface.corners, form.inner, room, splits)
    cells["pyramids"] = made.cells
    points, cells["tets"] = _compact(made, mesher, size, fine)
    _, angle, shape = _quality.tets(points, cells["tets"])
    moved = _polish.improve(points, cells["tets"], cells["pyramids"], len(form.inner))
    worst = {"scaled": float(shape.min()), "dihedral_least": float(angle.min()), "moved": moved}
    return points, cells, worst


def _compact(made, mesher, size, fine):
    """Mesh the space that the pyramids enclose; points that belong to no triangle are left out."""
    used = np.unique(made.triangles)
    place = np.full(len(made.points), -1)
    place[used] = np.arange(len(used))
    points, tets = _tets.mesh(made.points[used], place[made.triangles], mesher, size, fine)
    n = len(made.points)
    back = np.concatenate([used, n + np.arange(len(points) - len(used))])
    return np.concatenate([made.points, points[len(used) :]]), back[tets]


def volumes(body):
    """{part: volume [L^3]} of layer, pyramids, tets and hexes."""
    part = {
        "layer": _layer.volumes(body.surface, body.points) if len(body.surface.nodes) else [],
        "pyramids": _quality.pyramids(body.points, body.cells["pyramids"])[0],
        "tets": _quality.tets(body.points, body.cells["tets"])[0],
        "hexes": _quality.hex_volumes(body.points, body.cells["hexes"]),
    }
    return {key: float(np.sum(v)) for key, v in part.items()}


def enclosed(body):
    """Volume inside the surface [L^3], from a surface integral over its spline and plain faces."""
    centre = body.whole.points.mean(axis=0)
    total = 0.0
    if len(body.surface.nodes):
        total = _surface.measures(body.surface, centre=centre)[1]
    if body.plain is not None:
        xi, eta, w = _surface.gauss(2)
        x, a, b = _layer.bilinear(body.points[body.plain], xi, eta, derivatives=True)
        total -= (np.einsum("mkc,mkc->mk", x - centre, np.cross(a, b)) @ w).sum() / 3
    return float(total)
