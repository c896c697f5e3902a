"""A spline surface as Bezier elements: its points, derivatives, curvature, area and volume."""

from dataclasses import dataclass, field
from math import comb

import numpy as np


@dataclass
class Surface:
    """The control points of the surface and, for each element, its functions and their Bezier
    coefficients.
    """

    degree: tuple  # (p, q)
    points: np.ndarray  # (n, 3) control points, not weighted
    weights: np.ndarray  # (n)
    nodes: list  # (m) arrays: the numbers of an element's functions
    coefficients: list  # (m) arrays (functions, (p+1)(q+1)), first direction fastest
    corners: np.ndarray  # (m, 4) numbers of the corners in the order (-,-) (+,-) (+,+) (-,+)
    sets: dict = field(default_factory=dict)  # name to numbers of elements
    hanging: dict = field(
        default_factory=dict
    )  # hanging corner to (a, b, tau): where it lies on a-b

    def bezier(self):
        """(m, (p+1)(q+1), 4) Bezier points of all elements, as w x and w."""
        full = np.column_stack([self.points * self.weights[:, None], self.weights])
        return np.array([c.T @ full[ids] for ids, c in zip(self.nodes, self.coefficients)])

    @property
    def corner_index(self):
        """Indices of the four corners among the Bezier points."""
        p, q = self.degree
        return [0, p, (p + 1) * (q + 1) - 1, (p + 1) * q]

    def corner_points(self):
        """(number of corners, 3) positions of the corners."""
        b = self.bezier()[:, self.corner_index]
        result = np.full((self.corners.max() + 1, 3), np.nan)
        result[self.corners.ravel()] = (b[..., :3] / b[..., 3:]).reshape(-1, 3)
        return result


def bernstein(p, x, derivative=0):
    """(points, p + 1) Bernstein polynomials on [-1, 1] or their first or second derivatives.

    >>> bernstein(2, [0.0]).tolist()
    [[0.25, 0.5, 0.25]]
    """
    t = 0.5 * (np.asarray(x, dtype=float)[:, None] + 1)
    if p < derivative:
        return np.zeros((len(t), p + 1))
    if derivative == 0:
        i = np.arange(p + 1)
        return np.array([comb(p, k) for k in i]) * t**i * (1 - t) ** (p - i)
    low = bernstein(p - 1, x, derivative - 1)
    zero = np.zeros((len(t), 1))
    return 0.5 * p * (np.hstack([zero, low]) - np.hstack([low, zero]))


def evaluate(bezier, degree, xi, eta, order=1):
    """Points and derivatives of all elements at the same parameters.

    bezier: (m, nb, 4); xi, eta: (k) in [-1, 1]. Returns a list of (m, k, 3): x, x_xi, x_eta, and
    for order 2 x_xixi, x_xieta, x_etaeta.
    """
    p, q = degree
    u = [bernstein(p, xi, d) for d in range(order + 1)]
    v = [bernstein(q, eta, d) for d in range(order + 1)]

    def part(a, b):
        shape = (v[b][:, :, None] * u[a][:, None, :]).reshape(len(u[a]), -1)
        return np.einsum("kn,mnc->mkc", shape, bezier)

    h = {(a, b): part(a, b) for a in range(order + 1) for b in range(order + 1 - a)}
    w = {key: value[..., 3:] for key, value in h.items()}
    x = h[0, 0][..., :3] / w[0, 0]
    if order == 0:
        return [x]
    first = {key: (h[key][..., :3] - w[key] * x) / w[0, 0] for key in ((1, 0), (0, 1))}
    result = [x, first[1, 0], first[0, 1]]
    if order == 2:
        for a, b in ((2, 0), (1, 1), (0, 2)):
            one = [(1, 0), (1, 0)] if a == 2 else [(0, 1), (0, 1)] if b == 2 else [(1, 0), (0, 1)]
            mixed = w[one[0]] * first[one[1]] + w[one[1]] * first[one[0]]
            result.append((h[a, b][..., :3] - mixed - w[a, b] * x) / w[0, 0])
    return result


def gauss(n, m=None):
    """Points and weights of the product rule on the square [-1, 1]^2: xi, eta, w, each (n m)."""
    x, wx = np.polynomial.legendre.leggauss(n)
    y, wy = np.polynomial.legendre.leggauss(m or n)
    return np.tile(x, len(y)), np.repeat(y, len(x)), np.outer(wy, wx).ravel()


def measures(surface, rule=None, centre=None):
    """(area [L^2], volume [L^3] as the surface integral of x . n / 3) with n = -x_xi x x_eta."""
    rule = rule or exact_rule(surface)
    xi, eta, w = gauss(rule)
    x, a, b = evaluate(surface.bezier(), surface.degree, xi, eta)
    normal = -np.cross(a, b)
    # Relative to a point of the body, since far from the origin digits would cancel.
    x = x - (surface.points.mean(axis=0) if centre is None else centre)
    area = np.linalg.norm(normal, axis=2) @ w
    return area.sum(), (np.einsum("mkc,mkc->mk", x, normal) @ w).sum() / 3


def exact_rule(surface):
    """Gauss points per direction for volumes: exact or, for rational surfaces, to round-off."""
    rational = np.ptp(surface.weights) > 0
    return 14 if rational else (3 * max(surface.degree) + 1) // 2


def unit(v):
    """Vectors along the last axis, normalised to length one; zero vectors remain zero."""
    length = np.linalg.norm(v, axis=-1, keepdims=True)
    return np.divide(v, length, out=np.zeros_like(v), where=length > 0)


def corner_normals(surface):
    """(corners, 3) outward normals, and (corners) the largest angle between elements there [rad].

    If an element is degenerate at its corner, the normal is evaluated slightly inside.
    """
    normals = element_corner_normals(surface)
    n = int(surface.corners.max()) + 1
    total = np.zeros((n, 3))
    np.add.at(total, surface.corners.ravel(), normals.reshape(-1, 3))
    mean = unit(total)
    jump = np.zeros(n)
    order = np.argsort(surface.corners.ravel(), kind="stable")
    flat, owner = normals.reshape(-1, 3)[order], surface.corners.ravel()[order]
    starts = np.r_[0, np.flatnonzero(np.diff(owner)) + 1, len(owner)]
    for a, b in zip(starts[:-1], starts[1:]):
        part = flat[a:b]
        sine = np.linalg.norm(np.cross(part[:, None], part[None]), axis=2)
        jump[owner[a]] = np.arctan2(sine, part @ part.T).max()
    return mean, jump


def element_corner_normals(surface):
    """(m, 4, 3) unit outward normals of each element at its corners."""
    bezier = surface.bezier()
    xi, eta = np.array([-1.0, 1, 1, -1]), np.array([-1.0, -1, 1, 1])
    _, a, b = evaluate(bezier, surface.degree, xi, eta)
    normal = -np.cross(a, b)
    size = np.linalg.norm(normal, axis=2)
    weak = size < 1e-6 * size.max(axis=1, keepdims=True)
    if weak.any():
        _, a, b = evaluate(bezier, surface.degree, xi * (1 - 2e-5), eta * (1 - 2e-5))
        normal = np.where(weak[..., None], -np.cross(a, b), normal)
    return unit(normal)


def curvature(surface, xi, eta):
    """(m, k, 2) principal curvatures, positive where the body bulges outward [1/L]."""
    _, a, b, aa, ab, bb = evaluate(surface.bezier(), surface.degree, xi, eta, order=2)
    n = unit(np.cross(a, b))  # inward, hence the sign below
    dot = lambda u, v: np.einsum("mkc,mkc->mk", u, v)  # noqa: E731
    e, f, g = dot(a, a), dot(a, b), dot(b, b)
    l2, m2, n2 = dot(aa, n), dot(ab, n), dot(bb, n)
    det = e * g - f * f
    flat = det <= 1e-12 * (e * g)  # the tangents are parallel, so the curvature is undefined
    det, e = np.where(flat, np.inf, det), np.where(flat, 1, e)
    # The second form in the orthonormal frame along a, to avoid differences of nearly equal
    # numbers.
    ratio = f / e
    along = np.where(flat, 0, l2 / e)
    mixed = (m2 - ratio * l2) / np.sqrt(det)
    across = (n2 - 2 * ratio * m2 + ratio**2 * l2) / (det / e)
    mean = 0.5 * (along + across)
    root = np.hypot(0.5 * (along - across), mixed)
    return np.stack([mean + root, mean - root], axis=-1)
