"""B-splines in one direction (sections 2.2 and 2.5 of the paper), by the Cox-de Boor recursion.

The paper writes the same functions as Bernstein polynomials times extraction operators, eq. (8).
Lagrange elements are splines too: those of degree 1, and those of degree 2 with every interior knot
repeated, span the spaces of Q1 and Q2. All weights are one, so that R = N in eq. (12).
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Space:
    """Functions of degree p on n equal spans of [0, 1]; interior knots appear `repeat` times."""

    p: int
    n: int
    repeat: int = 1

    @property
    def knots(self):
        inner = np.repeat(np.arange(1, self.n) / self.n, self.repeat)
        return np.concatenate([np.zeros(self.p + 1), inner, np.ones(self.p + 1)])

    @property
    def size(self):
        """The number of control points, eq. (22)."""
        return len(self.knots) - self.p - 1

    @property
    def greville(self):
        """Means of p successive knots, which are the control points of the identity map."""
        return np.array([self.knots[i + 1 : i + self.p + 1].mean() for i in range(self.size)])

    def basis(self, x):
        """The p+1 functions that are not zero at x (P,), with their first and second derivatives.

        Return their numbers (P, p+1) and their values (P, 3, p+1).
        """
        k, p = self.knots, self.p
        span = np.clip(np.searchsorted(k, x, side="right") - 1, p, self.size - 1)
        f = np.zeros((3, len(x), len(k) - 1))  # value, first and second derivative; degree 0
        f[0, np.arange(len(x)), span] = 1.0
        for q in range(1, p + 1):
            width = k[q:] - k[:-q]
            ratio = np.divide(f, width[: f.shape[2]], where=width > 0, out=np.zeros_like(f))
            left, right = ratio[:, :, :-1], ratio[:, :, 1:]
            m = left.shape[2]
            f = np.zeros((3, len(x), m))
            f[0] = (x[:, None] - k[:m]) * left[0] + (k[q + 1 : q + 1 + m] - x[:, None]) * right[0]
            f[1:] = q * (left[:2] - right[:2])
        numbers = (span - p)[:, None] + np.arange(p + 1)
        values = np.take_along_axis(f, numbers[None].repeat(3, axis=0), axis=2)
        return numbers, values.transpose(1, 0, 2)

    def matrix(self, x):
        """The values of all functions at x, as a matrix (P, size)."""
        numbers, values = self.basis(x)
        full = np.zeros((len(x), self.size))
        np.put_along_axis(full, numbers, values[:, 0], axis=1)
        return full

    def elevated(self, t):
        """The space after t degree elevations (section 2.5, step 4): the multiplicity of knots
        grows by t.
        """
        return Space(self.p + t, self.n, self.repeat + t)


def gauss(space, q):
    """q Gauss points in each span of the space: points and weights, (n, q) each."""
    x, w = np.polynomial.legendre.leggauss(q)
    left = np.arange(space.n)[:, None] / space.n
    return left + (x + 1) / (2 * space.n), np.tile(w / (2 * space.n), (space.n, 1))
