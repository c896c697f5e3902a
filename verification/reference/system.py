"""All bodies as one dense system, solved by Newton's method."""

import numpy as np

from verification.reference.solid import Inverted, Solid


class Diverged(Exception):
    """Newton's method found no solution."""


class System:
    """Several patches with one vector of unknowns: nodal displacements, then enhanced
    parameters.
    """

    def __init__(self, patches, positions, materials):
        self.patches = []
        first = 0
        for patch in patches:
            self.patches.append(patch.shifted(first))
            first += len(patch.parameters)
        self.X = np.concatenate(positions)
        self.count = first
        self.dofs = 3 * first
        self.solids = []
        self.contact = None
        for patch, material in zip(self.patches, materials):
            for block in patch.blocks:
                self.solids.append(Solid(block, self.X, *material, first))
                first += 3 * len(block.nodes) if block.modes else 0
        self.u = np.zeros((first, 3))
        self.fixed = np.zeros((first, 3), dtype=bool)
        self.value = np.zeros((first, 3))

    def prescribe(self, nodes, directions, values):
        """Prescribe values of displacements in the given directions of nodes, from the next
        solution on.
        """
        for d in directions:
            self.fixed[nodes, d] = True
            self.value[nodes, d] = np.asarray(values)[..., d] if np.ndim(values) else values

    def bulk(self, u):
        """Internal forces (N, 3) and the dense tangent."""
        size = u.size
        f, K = np.zeros(size), np.zeros((size, size))
        flat = K.reshape(-1)
        for solid in self.solids:
            fe, Ke = solid.forces(u)
            scatter(f, flat, solid.dofs, fe, solid.dofs, Ke)
        return f, K

    def solve(self, damped=False, tolerance=1e-11):
        """Newton's method; the first increment uses the tangent to apply the prescribed
        displacements.

        damped: halve each further increment until the residual is small, which ends most cycles
        between contact states.
        """
        u, free = self.u.copy(), ~self.fixed.ravel()
        step = np.where(self.fixed, self.value - u, 0.0).ravel()
        for count in range(80 if damped else 30):
            try:
                f, K = self.bulk(u)
            except Inverted:
                raise Diverged from None
            scale = abs(f).max()
            if self.contact:
                self.contact.add(self.X, u, f, K)
            error = abs(f[free]).max()
            if count and error <= tolerance * scale:
                self.u, self.reactions, self.iterations = u, f.reshape(-1, 3), count
                return self
            right = -f - (K @ step if count == 0 else 0)
            move = step * (count == 0)
            move[free] = np.linalg.solve(K[np.ix_(free, free)], right[free])
            if damped and count and error > 1e-4 * scale:
                move /= 2
            u = u + move.reshape(-1, 3)
        raise Diverged


def scatter(f, K, rows, fe, columns, Ke):
    """Add element forces and matrices to a vector and a flattened dense matrix."""
    size = len(f)
    f += np.bincount(rows.ravel(), fe.ravel(), size)
    at = rows[:, :, None] * size + columns[:, None, :]
    np.add.at(K, at.ravel(), Ke.ravel())


def advance(system, move, steps, accept=lambda: None):
    """Take steps from 0 to 1: move(t) prescribes displacements, and accept() is called after each
    step; yield the end of each step. A step is halved if even the damped Newton method does not
    solve it.
    """
    for step in range(steps):
        t, ends = step / steps, [(step + 1) / steps]
        while ends:
            old = system.value.copy()
            move(ends[0])
            if attempt(system):
                t = ends.pop(0)
                accept()
            elif ends[0] - t < 1e-4:
                raise Diverged
            else:
                system.value = old
                ends.insert(0, (t + ends[0]) / 2)
        yield t


def attempt(system):
    """Whether Newton's method, plain or damped, finds the next state."""
    for damped in (False, True):
        try:
            system.solve(damped)
            return True
        except (Diverged, np.linalg.LinAlgError):
            pass
    return False
