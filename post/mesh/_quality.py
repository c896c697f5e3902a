"""Shapes of cells: volumes, angles, and scaled Jacobians (det J over the lengths of its
columns).
"""

import numpy as np

from post.mesh import _layer, _surface

SIGN = np.array(
    [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1],
     [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]], dtype=float
)  # fmt: skip
TET_FACES = ((1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1))


def layer(surface, inner):
    """{det_gauss, det_corner, scaled_gauss, scaled_corner}: the smallest value of each, and the
    number of degenerate_corners; empty if there is no layer.

    Where the surface is degenerate at a corner of an element, as at a smooth extraordinary point,
    det J is zero; such corners are left out.
    """
    if not len(surface.nodes):
        return {}
    xi, eta, _ = _surface.gauss(5)
    z = np.array([-1.0, 1.0]) / np.sqrt(3)
    jac = _layer.jacobians(surface, inner, np.tile(xi, 2), np.tile(eta, 2), np.repeat(z, len(xi)))
    at = _layer.jacobians(surface, inner, SIGN[:, 0], SIGN[:, 1], SIGN[:, 2])
    det = np.linalg.det(at)
    size = np.linalg.norm(at, axis=2).prod(axis=2)
    usual = size > 1e-6 * size.max(axis=1, keepdims=True)
    return {
        "det_gauss": float(np.linalg.det(jac).min()),
        "det_corner": float(det[usual].min()),
        "scaled_gauss": float(scaled(jac).min()),
        "scaled_corner": float(scaled(at)[usual].min()),
        "degenerate_corners": int((~usual).sum()),
    }


def scaled(jac):
    """(...) det J divided by the product of the lengths of its columns, for Jacobians (..., 3, 3).

    >>> float(scaled(np.diag([1.0, 2.0, 3.0])))
    1.0
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.linalg.det(jac) / np.linalg.norm(jac, axis=-2).prod(axis=-1)


def hex_jacobians(points, cells, at):
    """(m, k, 3, 3) Jacobians of trilinear hexahedra at parameters (k, 3)."""
    one = 1 + at[:, None, :] * SIGN[None]
    shape = [SIGN[:, d] * one[..., (d + 1) % 3] * one[..., (d + 2) % 3] / 8 for d in range(3)]
    return np.stack([np.einsum("kn,mnc->mkc", s, points[cells]) for s in shape], axis=-1)


def hex_volumes(points, cells):
    """(m) exact volumes of trilinear hexahedra."""
    return np.linalg.det(hex_jacobians(points, cells, SIGN / np.sqrt(3))).sum(axis=1)


def tet_shapes(x):
    """(...) scaled Jacobians of tetrahedra (..., 4, 3): the smallest of the corners; 1 if
    regular.
    """
    length = np.linalg.norm(x[..., :, None, :] - x[..., None, :, :], axis=-1)
    length[..., np.arange(4), np.arange(4)] = 1
    det = np.linalg.det(x[..., 1:, :] - x[..., :1, :])
    return np.sqrt(2) * det / length.prod(axis=-1).max(axis=-1)


def pyramid_shapes(x):
    """(...) the smallest scaled Jacobians of pyramids (..., 5, 3) at the corners of their bases."""
    return _pyramid_corners(x).min(axis=-1)


def _pyramid_corners(x):
    base, peak = x[..., :4, :], x[..., 4:, :]
    ahead, behind = np.roll(base, -1, axis=-2) - base, np.roll(base, 1, axis=-2) - base
    return scaled(np.stack([ahead, behind, peak - base], axis=-1))


def pyramids(points, cells):
    """(volumes (m), scaled Jacobians at the corners of the base (m, 4)).

    The volume is that of the rational element, whose base is bilinear.
    """
    x = points[cells]
    base, peak = x[:, :4], x[:, 4]
    xi, eta, w = _surface.gauss(2)
    y, a, b = _layer.bilinear(base, xi, eta, derivatives=True)
    volume = np.einsum("mkc,mkc->mk", peak[:, None] - y, np.cross(a, b)) @ w / 3
    return volume, _pyramid_corners(x)


def tets(points, cells):
    """(volumes (m), dihedral angles (m, 6) [degrees], scaled Jacobians (m), 1 if regular)."""
    x = points[cells]
    volume = np.einsum(
        "ij,ij->i", np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), x[:, 3] - x[:, 0]
    ) / 6  # fmt: skip
    normal = np.stack(
        [_surface.unit(np.cross(x[:, j] - x[:, i], x[:, k] - x[:, i])) for i, j, k in TET_FACES], 1
    )
    pairs = [(i, j) for i in range(4) for j in range(i)]
    cosine = np.stack([-np.einsum("mc,mc->m", normal[:, i], normal[:, j]) for i, j in pairs], 1)
    return volume, np.degrees(np.arccos(np.clip(cosine, -1, 1))), tet_shapes(x)
