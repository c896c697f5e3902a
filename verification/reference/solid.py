"""Bulk elements: neo-Hooke at large deformations, eqs. (32) and (33), and enhanced strains.

The enhanced deformation gradient of Simo and Armero (1992),
    F = F_u + j0/j sum_i a_i (x) xi_i J0^-T e_i,
is what three further nodes of an element would contribute, with the "displacements" a_i and the
"gradients" j0/j xi_i J0^-T e_i. The nine parameters are therefore treated as three more unknown
vectors of the whole system, and nothing is condensed.
"""

import numpy as np


class Inverted(Exception):
    """The deformation gradient has a determinant that is not positive."""


class Solid:
    """The elements of one block: gradients (E, Q, A, 3) and weights (E, Q) in the reference
    state.
    """

    def __init__(self, block, X, E, nu, first_mode):
        jacobian = np.einsum("eai,eqaj->eqij", X[block.nodes], block.derivatives)
        determinant = np.linalg.det(jacobian)
        self.nodes = block.nodes
        self.G = block.derivatives @ np.linalg.inv(jacobian)
        self.w = block.weights * abs(determinant)
        self.mu = E / (2 * (1 + nu))
        self.lam = 2 * self.mu * nu / (1 - 2 * nu)
        if block.modes:
            self._enhance(X[block.nodes], *block.modes, determinant, first_mode)
        dofs = (3 * self.nodes[:, :, None] + np.arange(3)).reshape(len(self.nodes), -1)
        self.dofs = dofs

    def _enhance(self, X, xi, centre, determinant, first):
        count = len(self.nodes)
        J0 = np.einsum("eai,eaj->eij", X, centre)
        scale = abs(np.linalg.det(J0))[:, None] / abs(determinant)
        more = np.einsum("eq,qi,eij->eqij", scale, xi, np.linalg.inv(J0))
        self.G = np.concatenate([self.G, more], axis=2)
        numbers = first + np.arange(3 * count).reshape(count, 3)
        self.nodes = np.concatenate([self.nodes, numbers], axis=1)

    def forces(self, u):
        """Nodal forces (E, A, 3) and tangents (E, 3A, 3A) at the displacements u (N, 3)."""
        F = np.eye(3) + np.einsum("eai,eqaj->eqij", u[self.nodes], self.G)
        J = np.linalg.det(F)
        if J.min() <= 0:
            raise Inverted
        log = np.log(J)
        g = self.G @ np.linalg.inv(F)  # gradients in the current state
        factor = self.lam * log - self.mu  # J sigma = mu b + factor I
        f = np.einsum("eqaj,eqij,eq->eai", self.G, F, self.mu * self.w)
        f += np.einsum("eqai,eq->eai", g, factor * self.w)
        E, Q, A, _ = g.shape
        flat = lambda a: a.reshape(E, Q, 3 * A)
        gf = flat(g)
        K = np.matmul((gf * (self.lam * self.w)[:, :, None]).transpose(0, 2, 1), gf)
        K = K.reshape(E, A, 3, A, 3)
        K -= np.einsum("eqak,eqbi,eq->eaibk", g, g, factor * self.w, optimize=True)
        both = np.einsum("eqaj,eqbj,eq->eab", self.G, self.G, self.mu * self.w, optimize=True)
        for i in range(3):
            K[:, :, i, :, i] += both
        return f, K.reshape(E, 3 * A, 3 * A)
