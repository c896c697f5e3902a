"""Contact in two half passes: penalty (26), Coulomb friction (27)-(29), debonding (30)-(31).

Each side is integrated separately: the traction at a point of side k depends on its foot on side l,
and loads side k only. The traction is differentiated by complex steps in the vectors on which it
depends. For this purpose, it includes one Newton step from the foot, which does not move the foot but
has its exact first derivative.
"""

import numpy as np

from verification.reference.surface import Surface, metric, newton_step, orthogonality
from verification.reference.system import scatter

STEP = 1e-30  # length of the complex step


def dot(a, b):
    return (a * b).sum(axis=-1, keepdims=True)


def norm(a):
    """The length of vectors, without conjugation so that complex steps can differentiate it."""
    return np.sqrt(dot(a, a))


class HalfPass:
    """The points of side k (own) against the surface of side l (other), with their history.

    exact: update the sliding point of a slipping point exactly instead of to first order; see
    _behind.
    """

    def __init__(self, own, other, penalty, mu=0.0, depth=np.inf, exact=True):
        self.exact = exact
        self.own, self.other, self.penalty, self.mu, self.depth = own, other, penalty, mu, depth
        self.sliding = None  # parameters of the sliding points; set when a step is first accepted
        self.bond = None

    def traction(self, y, fixed):
        """Traction times current area at the active points.

        y: the position x and a_1, a_2 of side k; x_p, a_1, a_2 of side l; the sliding point; (P, 3)
        each. fixed: a_11, a_12, a_22 and H of the projection, and the weights.
        """
        x, k1, k2, s, l1, l2, stuck = y
        second, H, w = fixed
        r = np.concatenate([dot(x - s, l1), dot(x - s, l2)], axis=1)
        d = np.linalg.solve(H, r[:, :, None])  # increment of the foot's parameters
        s = s + l1 * d[:, 0] + l2 * d[:, 1]
        l1 = l1 + second[:, 0] * d[:, 0] + second[:, 1] * d[:, 1]
        l2 = l2 + second[:, 1] * d[:, 0] + second[:, 2] * d[:, 1]
        n = self.other.sign * np.cross(l1, l2)
        n = n / norm(n)
        p = -self.penalty * dot(x - s, n)
        t = p * n  # eq. (26)
        if self.friction:
            D = (x - stuck) - dot(x - stuck, n) * n  # the reversible slip of eq. (27)
            length = norm(D)
            # eq. (29); a point that has slipped starts a step at the limit, and counts as slipping
            slips = self.penalty * length.real > self.mu * p.real * (1 - 1e-9)
            ratio = np.where(slips, self.mu * p / np.where(slips, length, 1), self.penalty)
            t = t - ratio * D  # stick, or eq. (28)
            self.slips, self.ahead = slips[:, 0], (p * D / np.where(slips, length, 1)).real
        return t * norm(np.cross(k1, k2)) * w[:, None]

    def add(self, X, u, f, K):
        """Add the forces on side k and their derivatives."""
        own, other, x = self.own, self.other, X + u[: len(X)]
        points = np.einsum("pa,pai->pi", own.functions[:, 0], x[own.nodes])
        self.foot, inside = other.project(x, points)
        nodes, functions = other.at(self.foot)
        s = np.einsum("pva,pai->pvi", functions, x[nodes])
        n = other.sign * np.cross(s[:, 1], s[:, 2])
        gap = dot(points - s[:, 0], n)[:, 0] / np.maximum(norm(n)[:, 0], 1e-300)  # eq. (25)
        on = self.active = np.flatnonzero(inside & (gap < 0) & (gap > -self.depth))
        self.place, self.force = points[on], np.zeros((len(on), 3))
        self.friction = self.mu > 0 and self.sliding is not None
        self.x, self.normal = x, n[on] / norm(n[on])
        if self.bond:
            self.bond.add(self, x, points, f, K)
        if not len(on):
            return
        mine = np.einsum("pva,pai->vpi", own.functions[on, :3], x[own.nodes[on]])
        y = [*mine, *s[on, :3].transpose(1, 0, 2), s[on, 0]]
        parts = [(own.nodes[on], own.functions[on, :3]), (nodes[on], functions[on, :3])]
        if self.friction:
            stuck = other.at(self.sliding[on])
            y[6] = np.einsum("pa,pai->pi", stuck[1][:, 0], x[stuck[0]])
            parts.append((stuck[0], stuck[1][:, :1]))
        fixed = s[on, 3:], orthogonality(points[on], s[on])[1], own.weights[on]
        slope = np.zeros((len(on), 3, 7, 3))
        for v in range(7 if self.friction else 6):
            for i in range(3):
                moved = [a.astype(complex) for a in y]
                moved[v][:, i] += 1j * STEP
                slope[:, :, v, i] = self.traction(moved, fixed).imag / STEP
        self.force = self.traction(y, fixed)
        first = np.cumsum([0] + [p[1].shape[1] for p in parts])
        load(
            f, K, own.nodes[on], own.functions[on, 0], self.force,
            [(m, np.einsum("pcvj,pva->pcaj", slope[:, :, i:j], g))
             for (m, g), i, j in zip(parts, first, first[1:])],
        )  # fmt: skip

    def accept(self):
        """Store the history of a converged step; sticking points keep their sliding points."""
        if not self.mu:
            return
        old, self.sliding = self.sliding, self.foot.copy()
        if self.friction and len(self.active):
            stays, moves = self.active[~self.slips], self.slips
            self.sliding[stays] = old[stays]
            if moves.any():
                self.sliding[self.active[moves]] = self._behind(moves)

    def _behind(self, moves):
        """Move the sliding points to where the reversible slip D is mu p / eps_t along the old D.

        This takes one step in the tangent plane at the foot, as in Sauer and De Lorenzis; with
        `exact`, the step is repeated until D has that value.
        """
        x, n, xi = self.place[moves], self.normal[moves], self.foot[self.active[moves]]
        way = self.mu / self.penalty * self.ahead[moves]
        for _ in range(20 if self.exact else 1):
            nodes, f = self.other.at(xi)
            s = np.einsum("pva,pai->pvi", f[:, :3], self.x[nodes])
            s[:, 0] -= x
            s -= dot(s, n[:, None]) * n[:, None]  # tangential parts
            r = np.einsum("pai,pi->pa", s[:, 1:3], s[:, 0] + way)
            xi = np.clip(xi - newton_step(r, metric(s)), 0, 1)
        return xi

    def largest(self, direction):
        """The largest component of the smoothed tangential traction (Sauer 2013), Table 5.

        T_A = int R_A t da / int R_A da at the control points; the maximum is sought at 10 x 10
        points per element.
        """
        own = self.own
        tangents = np.einsum("pva,pai->vpi", own.functions[:, 1:3], self.x[own.nodes])
        area = own.weights * norm(np.cross(*tangents))[:, 0]
        shear = self.force - dot(self.force, self.normal) * self.normal
        values = own.functions[:, 0]
        on = self.active
        total = np.bincount(own.nodes.ravel(), (values * area[:, None]).ravel(), len(self.x))
        part = values[on] * shear[:, direction, None]
        part = np.bincount(own.nodes[on].ravel(), part.ravel(), len(self.x))
        T = part / np.where(total > 0, total, 1)
        line = [
            np.linspace(0, 1, 10)[None] / s.n + np.arange(s.n)[:, None] / s.n
            for s in own.face.spaces
        ]
        grid = np.stack(np.meshgrid(line[0].ravel(), line[1].ravel(), indexing="ij"), axis=-1)
        nodes, functions = own.at(grid.reshape(-1, 2))
        return abs(np.einsum("pa,pa->p", functions[:, 0], T[nodes])).max()

    def resultant(self):
        """The force of the contact tractions on side k, and their moment about the origin."""
        return self.force.sum(axis=0), np.cross(self.place, self.force).sum(axis=0)


class Bond:
    """The exponential law (31) between the points of side k and their reference feet on side l."""

    def __init__(self, half, X, T0, g0, bonded):
        side, other = half.own, half.other
        place = np.einsum("pva,pai->pvi", side.functions[:, :3], X[side.nodes])
        foot, inside = other.project(X, place[:, 0])
        on = self.on = np.flatnonzero(inside & bonded(place[:, 0]))
        self.nodes, functions = other.at(foot[on])
        self.functions = functions[:, 0]
        self.area = side.weights[on] * norm(np.cross(place[on, 1], place[on, 2]))[:, 0]
        self.T0, self.g0 = T0, g0

    def add(self, half, x, points, f, K):
        """Add T_c dA and its derivative, in which nothing but the gap vector g^0 varies."""
        side, on = half.own, self.on
        g = points[on] - np.einsum("pa,pai->pi", self.functions, x[self.nodes])
        r = norm(g)
        size = -self.T0 / self.g0 * np.exp(1 - r / self.g0) * self.area[:, None]
        e = g / np.maximum(r, 1e-300)
        slope = np.eye(3) - (r / self.g0)[:, :, None] * e[:, :, None] * e[:, None, :]
        slope = size[:, :, None] * slope
        own, mine = side.functions[on, 0], side.nodes[on]
        parts = [(mine, own), (self.nodes, -self.functions)]
        load(
            f, K, mine, own, size * g,
            [(m, np.einsum("pcj,pa->pcaj", slope, h)) for m, h in parts],
        )  # fmt: skip


def load(f, K, nodes, functions, force, slopes):
    """Assemble the forces (P, 3) at points to nodes, with their derivatives [(nodes, (P, 3, A,
    3))].
    """
    dofs = lambda m: (3 * m[:, :, None] + np.arange(3)).reshape(len(m), -1)
    P, A = nodes.shape
    fe = -functions[:, :, None] * force[:, None, :]
    columns = np.concatenate([dofs(m) for m, _ in slopes], axis=1)
    inner = np.concatenate([s.reshape(P, 3, -1) for _, s in slopes], axis=2)
    Ke = -(functions[:, :, None, None] * inner[:, None]).reshape(P, 3 * A, -1)
    scatter(f, K.reshape(-1), dofs(nodes), fe, columns, Ke)


class Contact:
    """Both half passes of the contact between two faces."""

    def __init__(self, faces, signs, q, *law, **options):
        one, two = (Surface(face, sign, q) for face, sign in zip(faces, signs))
        self.sides = [
            HalfPass(one, two, *law, **options),
            HalfPass(two, one, *law, **options),
        ]

    def add(self, X, u, f, K):
        for side in self.sides:
            side.add(X, u, f, K)

    def accept(self):
        for side in self.sides:
            side.accept()
