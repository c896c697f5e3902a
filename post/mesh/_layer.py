"""The layer of enriched elements: inner corners on the normals, at a suitable local distance.

Upper bounds of this distance follow from the edge lengths, from the thickness of the body, and from
the points at which normals intersect. A lower bound follows from concave parts of the surface,
which sag into the body: the inner face has straight edges and must lie deeper than the surface.
"""

from dataclasses import dataclass

import numpy as np

from post._error import Unreadable
from post.mesh import _border, _surface, _triangles

SAMPLES = np.array([-1.0, 0.0, 1.0])
ROUNDS = 12


@dataclass
class Layer:
    """Inner corners, and the quantities from which they were computed."""

    inner: np.ndarray  # (corners, 3)
    height: np.ndarray  # (corners) [L]
    thickness: np.ndarray  # (corners) thickness of the body along the normal [L]
    jump: np.ndarray  # (corners) largest angle between the normals of the elements there [rad]


def build(surface, factor=0.8, thickness_share=0.2, curvature_share=0.6, constant=None):
    """The Layer of a surface.

    Upper bounds of the height are factor times the local edge length, thickness_share times the
    thickness of the body, and curvature_share times the smallest radius of curvature. With
    `constant` the height is the same everywhere [L].
    """
    x = surface.corner_points()
    normal, jump = _surface.corner_normals(surface)
    thick = thickness(surface, x, normal)
    if constant is not None:
        height = np.full(len(x), float(constant))
        return Layer(_chord(surface, x - height[:, None] * normal), height, thick, jump)
    upper = np.minimum(factor * _edge_length(surface, x), thickness_share * thick)
    with np.errstate(divide="ignore"):
        upper = np.minimum(upper, curvature_share / np.maximum(_bulge(surface, len(x)), 0))
    lower = 2 * _sag(surface, x, normal)
    height = np.clip(_smoothed(surface, upper, 5), None, upper)
    height = np.maximum(height, lower)
    for _ in range(ROUNDS):
        inner = _chord(surface, x - height[:, None] * normal)
        bad = worst(surface, inner) <= 0
        if not bad.any():
            return Layer(inner, height, thick, jump)
        corners = np.unique(surface.corners[bad])
        height[corners] = np.maximum(0.75 * height[corners], lower[corners])
    k = np.flatnonzero(bad)
    place = "(" + ", ".join(f"{v:.4g}" for v in x[surface.corners[k[0]]].mean(axis=0)) + ")"
    raise Unreadable(
        f"{len(k)} elements of the layer are inverted, the first of them element {k[0] + 1} at {place}; "
        "refine the net there (--refine) or choose another --layer"
    )


def _chord(surface, inner):
    """Move the inner points of hanging corners onto the chords between those of their masters."""
    for s, (a, b, tau) in _border.in_order(surface.hanging):
        inner[s] = (1 - tau) * inner[a] + tau * inner[b]
    return inner


def _edge_length(surface, x):
    """(corners) mean length of the edges at the corner [L]."""
    a, b = surface.corners.ravel(), np.roll(surface.corners, -1, axis=1).ravel()
    length = np.linalg.norm(x[b] - x[a], axis=1)
    total, count = np.zeros(len(x)), np.zeros(len(x))
    for end in (a, b):
        np.add.at(total, end, length)
        np.add.at(count, end, 1)
    return total / np.maximum(count, 1)


def thickness(surface, x, normal):
    """(corners) distance [L] to the other side of the body along the inward normal, or inf."""
    c = surface.corners
    triangles = np.concatenate([c[:, [2, 1, 0]], c[:, [3, 2, 0]]])
    start = 0.05 * _edge_length(surface, x)
    return _triangles.first_hit(x, -normal, x, triangles, start)


def _bulge(surface, n):
    """(corners) the largest outward curvature of the elements around the corner [1/L]."""
    xi, eta = np.meshgrid(SAMPLES, SAMPLES)
    largest = _surface.curvature(surface, xi.ravel(), eta.ravel())[..., 0].max(axis=1)
    result = np.full(n, -np.inf)
    np.maximum.at(result, surface.corners.ravel(), np.repeat(largest, 4))
    return result


def _sag(surface, x, normal):
    """(corners) largest depth [L] by which elements around the corner lie below the bilinear face
    through their corners.
    """
    t = np.linspace(-1, 1, 7)
    xi, eta = (v.ravel() for v in np.meshgrid(t, t))
    y = _surface.evaluate(surface.bezier(), surface.degree, xi, eta, order=0)[0]
    flat = bilinear(x[surface.corners], xi, eta)
    inward = -_surface.unit(normal[surface.corners].mean(axis=1))
    depth = np.maximum(np.einsum("mkc,mc->mk", y - flat, inward).max(axis=1), 0)
    result = np.zeros(len(x))
    np.maximum.at(result, surface.corners.ravel(), np.repeat(depth, 4))
    return result


def bilinear(corners, xi, eta, derivatives=False):
    """(m, k, 3) points of faces (m, 4, 3); with `derivatives`, also the derivatives by xi and
    eta.
    """
    sx, sy = np.array([-1, 1, 1, -1]), np.array([-1, -1, 1, 1])
    shape = lambda a, b: np.einsum("kn,mnc->mkc", a * b / 4, corners)  # noqa: E731
    one = 1 + np.outer(xi, sx), 1 + np.outer(eta, sy)
    value = shape(one[0], one[1])
    return (
        (value, shape(sx + 0 * one[0], one[1]), shape(one[0], sy + 0 * one[1]))
        if derivatives
        else value
    )


def _smoothed(surface, height, passes):
    a, b = surface.corners.ravel(), np.roll(surface.corners, -1, axis=1).ravel()
    for _ in range(passes):
        total, count = np.zeros(len(height)), np.zeros(len(height))
        for s, e in ((a, b), (b, a)):
            np.add.at(total, s, height[e])
            np.add.at(count, s, 1)
        height = 0.5 * (height + total / np.maximum(count, 1))
    return height


def jacobians(surface, inner, xi, eta, zeta):
    """(m, k, 3, 3) columns x_xi x_eta x_zeta of the elements; the surface is at zeta = -1."""
    top = _surface.evaluate(surface.bezier(), surface.degree, xi, eta)
    low = bilinear(inner[surface.corners], xi, eta, derivatives=True)
    a, b = ((1 - zeta) / 2)[:, None], ((1 + zeta) / 2)[:, None]
    return np.stack(
        [a * top[1] + b * low[1], a * top[2] + b * low[2], (low[0] - top[0]) / 2], axis=-1
    )


def determinants(surface, inner):
    """(m, k) det J at 5 x 5 x 2 Gauss points, then at the eight corners [L^3]."""
    xi, eta, _ = _surface.gauss(5)
    z = np.array([-1.0, 1.0]) / np.sqrt(3)
    points = [np.tile(xi, 2), np.tile(eta, 2), np.repeat(z, 25)]
    corner = [np.tile([-1.0, 1, 1, -1], 2), np.tile([-1.0, -1, 1, 1], 2), np.repeat([-1.0, 1], 4)]
    return np.linalg.det(
        jacobians(surface, inner, *(np.concatenate(v) for v in zip(points, corner)))
    )


def worst(surface, inner):
    """(m) the smallest det J, without corners where the surface is degenerate and det J is zero."""
    det = determinants(surface, inner)
    _, a, b = _surface.evaluate(
        surface.bezier(), surface.degree, np.array([-1.0, 1, 1, -1]), np.array([-1.0, -1, 1, 1])
    )
    size = np.linalg.norm(np.cross(a, b), axis=2)
    weak = size < 1e-6 * size.max(axis=1, keepdims=True)
    det[:, -8:-4][weak] = np.inf
    return det.min(axis=1)


def volumes(surface, inner):
    """(m) volumes of the elements, exact except for rational surfaces [L^3]."""
    n = _surface.exact_rule(surface)
    xi, eta, w = _surface.gauss(n)
    z = np.array([-1.0, 1.0]) / np.sqrt(3)
    det = np.linalg.det(
        jacobians(surface, inner, np.tile(xi, 2), np.tile(eta, 2), np.repeat(z, n * n))
    )
    return det @ np.tile(w, 2)
