"""Contact surfaces: functions, integration points and the closest-point projection (section
2.6).
"""

import numpy as np

from verification.reference.mesh import grid_numbers, rule


class Surface:
    """A face of a patch with q x q points per element; `sign` makes a_1 x a_2 point outwards.

    For the points: nodes (P, A), functions (P, 6, A) as in `at`, weights (P,) in the parameters.
    """

    def __init__(self, face, sign, q):
        self.face, self.sign = face, sign
        xi, w = rule(face.spaces, (q, q))
        self.xi, self.weights = xi.reshape(-1, 2), w.ravel()
        self.nodes, self.functions = self.at(self.xi)
        lines = [np.linspace(0, 1, 4 * s.n + 1) for s in face.spaces]
        self.samples = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 2)
        self.sampled = self.at(self.samples)

    def at(self, xi):
        """Nodes (P, A) and functions (P, 6, A) at xi (P, 2): R, R_1, R_2, R_11, R_12, R_22."""
        (na, a), (nb, b) = [s.basis(xi[:, i]) for i, s in enumerate(self.face.spaces)]
        orders = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
        f = [np.einsum("pa,pb->pab", a[:, i], b[:, j]).reshape(len(xi), -1) for i, j in orders]
        nodes = self.face.nodes.ravel()[grid_numbers([na, nb], self.face.nodes.shape)]
        return nodes, np.stack(f, axis=1)

    def project(self, X, points, steps=60):
        """Parameters of the closest points, where (x - x_p) . a_alpha = 0, and whether the foot is
        inside.

        Newton's method starts from the nearest of the sampled points and stays within the patch. A
        foot on the border counts as inside only if the orthogonality holds there too.
        """
        nodes, functions = self.sampled
        sampled = np.einsum("pa,pai->pi", functions[:, 0], X[nodes])
        away = (sampled**2).sum(1) - 2 * points @ sampled.T
        xi = self.samples[away.argmin(axis=1)].copy()
        longest = np.array([0.5 / s.n for s in self.face.spaces])
        inside, todo = np.zeros(len(xi), dtype=bool), np.arange(len(xi))
        for _ in range(steps):
            nodes, f = self.at(xi[todo])
            s = np.einsum("pva,pai->pvi", f, X[nodes])
            r, H = orthogonality(points[todo], s)
            walls = ((xi[todo] <= 0) & (r < 0)) | ((xi[todo] >= 1) & (r > 0))
            full = newton_step(r, H)
            off = np.einsum("pij,pj->pi", metric(s), np.where(walls, full, 0))
            inside[todo] = (abs(off) <= 1e-12 * np.einsum("pii->p", metric(s))[:, None]).all(axis=1)
            H = np.where(walls[:, :, None] | walls[:, None, :], np.eye(2) * H, H)
            move = np.clip(newton_step(np.where(walls, 0, r), H), -longest, longest)
            new = np.clip(xi[todo] + move, 0, 1)
            moved = abs(new - xi[todo]).max(axis=1) > 1e-13
            xi[todo] = new
            todo = todo[moved]
            if not len(todo):
                break
        inside[todo] = False
        return xi, inside


def metric(s):
    """a_alpha . a_beta, (P, 2, 2), from the position and its derivatives s (P, 6, 3)."""
    return np.einsum("pai,pbi->pab", s[:, 1:3], s[:, 1:3])


def orthogonality(x, s):
    """r_alpha = (x - s) . a_alpha and its derivative -H with H = a_alpha . a_beta - g .
    a_alphabeta.
    """
    g = x - s[:, 0]
    r = np.einsum("pi,pai->pa", g, s[:, 1:3])
    bend = np.einsum("pi,pai->pa", g, s[:, 3:6].real)
    return r, metric(s) - bend[:, [[0, 1], [1, 2]]]


def newton_step(r, H):
    """H^-1 r or, where H is not positive definite, a step along r."""
    trace = abs(H[:, 0, 0]) + abs(H[:, 1, 1])
    det = H[:, 0, 0] * H[:, 1, 1] - H[:, 0, 1] * H[:, 1, 0]
    good = (det > 1e-10 * trace**2) & (H[:, 0, 0] > 0)
    safe = np.where(good[:, None, None], H, np.eye(2) * np.maximum(trace, 1e-300)[:, None, None])
    return np.linalg.solve(safe, r[:, :, None])[:, :, 0]
