"""Patches of hexahedra with tensor products of splines, eq. (14), and the parts of which patches
consist.

A block is a batch of elements with the same number of functions. Its functions are given by their
derivatives with respect to the parameters of the patch at the integration points.
"""

from dataclasses import dataclass

import numpy as np

from verification.reference.spline import gauss


@dataclass
class Block:
    """nodes (E, A), derivatives (E, Q, A, 3), weights (E, Q); modes: see solid.enhance."""

    nodes: np.ndarray
    derivatives: np.ndarray
    weights: np.ndarray
    modes: tuple | None = None

    def some(self, chosen):
        """The block that consists of some of its elements."""
        modes = self.modes and (self.modes[0], self.modes[1][chosen])
        return Block(self.nodes[chosen], self.derivatives[chosen], self.weights[chosen], modes)


@dataclass
class Face:
    """A face as a surface: the spaces of its two directions, and the numbers of its control
    points.
    """

    spaces: tuple
    nodes: np.ndarray


@dataclass
class Patch:
    """parameters (N, 3) of all nodes, blocks, and faces {(direction, side): Face}."""

    parameters: np.ndarray
    blocks: list
    faces: dict

    def shifted(self, first):
        """The same blocks and faces, with node numbers that start from `first`."""
        for block in self.blocks:
            block.nodes = block.nodes + first
        for face in self.faces.values():
            face.nodes = face.nodes + first
        return self


def tensor(functions):
    """Values and derivatives of products of functions of 1 to 3 directions, (P, 3, A) each.

    Returns values (P, A) and first derivatives (P, A, d); the first direction varies slowest.
    """
    values, slopes = functions[0][:, 0], [functions[0][:, 1]]
    for f in functions[1:]:
        times = lambda a, b: (a[:, :, None] * b[:, None, :]).reshape(len(a), -1)
        slopes = [times(s, f[:, 0]) for s in slopes] + [times(values, f[:, 1])]
        values = times(values, f[:, 0])
    return values, np.stack(slopes, axis=2)


def grid_numbers(numbers, shape):
    """Node numbers in a grid from the numbers (P, a) in each direction, in the order of
    `tensor`.
    """
    result = numbers[0]
    for n, size in zip(numbers[1:], shape[1:]):
        result = (result[:, :, None] * size + n[:, None, :]).reshape(len(result), -1)
    return result


def rule(spaces, points):
    """Gauss points of all elements: points (E, Q, d), weights (E, Q)."""
    d, shape = len(spaces), [n for s, q in zip(spaces, points) for n in (s.n, q)]
    order = [*range(0, 2 * d, 2), *range(1, 2 * d, 2), 2 * d]  # elements first, then their points
    count = int(np.prod([s.n for s in spaces]))

    def grid(lines):
        at = np.stack(np.meshgrid(*[a.ravel() for a in lines], indexing="ij"), axis=-1)
        return at.reshape(*shape, d).transpose(order).reshape(count, -1, d)

    x, w = zip(*[gauss(s, q) for s, q in zip(spaces, points)])
    return grid(x), grid(w).prod(axis=2)


def tensor_block(spaces, points, grid):
    """The elements of a tensor-product patch whose control points have the numbers in `grid`."""
    x, w = rule(spaces, points)
    flat = x.reshape(-1, 3)
    found = [s.basis(flat[:, i]) for i, s in enumerate(spaces)]
    _, slopes = tensor([f for _, f in found])
    nodes = grid.ravel()[grid_numbers([n for n, _ in found], grid.shape)]
    per = x.shape[:2]
    return Block(nodes.reshape(*per, -1)[:, 0], slopes.reshape(*per, -1, 3), w)


def tensor_patch(spaces, points):
    """A patch whose functions are products of splines: Q1, Q2, or IGA of any degree."""
    shape = tuple(s.size for s in spaces)
    grid = np.arange(np.prod(shape)).reshape(shape)
    parameters = np.stack(np.meshgrid(*[s.greville for s in spaces], indexing="ij"), axis=-1)
    faces = {}
    for d in range(3):
        plane = tuple(spaces[i] for i in range(3) if i != d)
        faces[d, 0] = Face(plane, grid.take(0, axis=d))
        faces[d, 1] = Face(plane, grid.take(-1, axis=d))
    return Patch(parameters.reshape(-1, 3), [tensor_block(spaces, points, grid)], faces)


def q1_modes(spaces):
    """The data for the nine enhanced modes: xi at the points (Q, 3), and the derivatives at the
    centre.
    """
    line = np.polynomial.legendre.leggauss(2)[0]
    xi = np.stack(np.meshgrid(line, line, line, indexing="ij"), axis=-1).reshape(-1, 3)
    x, _ = rule(spaces, (1, 1, 1))
    return xi, tensor([s.basis(x[:, 0, i])[1] for i, s in enumerate(spaces)])[1]
