"""Patches of hexahedra: tensor products, eq. (14), and enriched layers, eq. (15).

A block is a batch of elements with the same number of functions. Its functions are given by their
derivatives with respect to the parameters of the patch at the integration points.
"""

from dataclasses import dataclass

import numpy as np

from verification.reference.spline import Space, gauss


@dataclass
class Block:
    """nodes (E, A), derivatives (E, Q, A, 3), weights (E, Q); modes: see solid.enhance."""

    nodes: np.ndarray
    derivatives: np.ndarray
    weights: np.ndarray
    modes: tuple | None = None

    def some(self, chosen):
        """The block of some of its elements."""
        modes = self.modes and (self.modes[0], self.modes[1][chosen])
        return Block(self.nodes[chosen], self.derivatives[chosen], self.weights[chosen], modes)


@dataclass
class Face:
    """A face as a surface: spaces of its two directions and the numbers of its control points."""

    spaces: tuple
    nodes: np.ndarray


@dataclass
class Patch:
    """parameters (N, 3) of all nodes, blocks, and faces {(direction, side): Face}."""

    parameters: np.ndarray
    blocks: list
    faces: dict

    def shifted(self, first):
        """The blocks and faces with node numbers from `first` on."""
        for block in self.blocks:
            block.nodes = block.nodes + first
        for face in self.faces.values():
            face.nodes = face.nodes + first
        return self


def tensor(functions):
    """Values and derivatives of products: functions of 1 to 3 directions, (P, 3, A) each.

    Returns values (P, A) and first derivatives (P, A, d); the first direction varies slowest.
    """
    values, slopes = functions[0][:, 0], [functions[0][:, 1]]
    for f in functions[1:]:
        times = lambda a, b: (a[:, :, None] * b[:, None, :]).reshape(len(a), -1)
        slopes = [times(s, f[:, 0]) for s in slopes] + [times(values, f[:, 1])]
        values = times(values, f[:, 0])
    return values, np.stack(slopes, axis=2)


def grid_numbers(numbers, shape):
    """Numbers of a grid from the numbers (P, a) in each direction, in the order of `tensor`."""
    result = numbers[0]
    for n, size in zip(numbers[1:], shape[1:]):
        result = (result[:, :, None] * size + n[:, None, :]).reshape(len(result), -1)
    return result


def rule(spaces, points):
    """Gauss points of all elements: points (E, Q, d), weights (E, Q)."""
    lines = [gauss(s, q) for s, q in zip(spaces, points)]
    d = len(spaces)
    x = np.stack(_outer([x for x, _ in lines]), axis=-1)
    w = np.prod(np.stack(_outer([w for _, w in lines]), axis=-1), axis=-1)
    count = int(np.prod([s.n for s in spaces]))
    return x.reshape(count, -1, d), w.reshape(count, -1)


def _outer(arrays):
    """Arrays (n_i, q_i) spread over the grid (n_1, n_2, ..., q_1, q_2, ...)."""
    d = len(arrays)
    spread = []
    for i, a in enumerate(arrays):
        shape = [1] * (2 * d)
        shape[i], shape[d + i] = a.shape
        spread.append(a.reshape(shape))
    return np.broadcast_arrays(*spread)


def tensor_block(spaces, points, grid):
    """The elements of a tensor-product patch whose control points have the numbers grid."""
    x, w = rule(spaces, points)
    flat = x.reshape(-1, 3)
    found = [s.basis(flat[:, i]) for i, s in enumerate(spaces)]
    _, slopes = tensor([f for _, f in found])
    nodes = grid.ravel()[grid_numbers([n for n, _ in found], grid.shape)]
    per = x.shape[:2]
    return Block(nodes.reshape(*per, -1)[:, 0], slopes.reshape(*per, -1, 3), w)


def tensor_patch(spaces, points):
    """A patch of splines in all directions: Q1, Q2 and IGAp."""
    shape = tuple(s.size for s in spaces)
    grid = np.arange(np.prod(shape)).reshape(shape)
    parameters = np.stack(np.meshgrid(*[s.greville for s in spaces], indexing="ij"), axis=-1)
    faces = {}
    for d in range(3):
        plane = tuple(spaces[i] for i in range(3) if i != d)
        faces[d, 0] = Face(plane, grid.take(0, axis=d))
        faces[d, 1] = Face(plane, grid.take(-1, axis=d))
    return Patch(parameters.reshape(-1, 3), [tensor_block(spaces, points, grid)], faces)


def layered_patch(counts, enriched, base="Q1", layer="Q1N2", prism_points=None):
    """Elements Q1, Q1E9 or Q2 whose layers at the faces `enriched` are Q1Np.t, Q2Np.t or Q1E9Np.t.

    Where two enriched faces meet, each element of the edge column becomes two prisms (section 4.1):
    the inner face of the enriched hexahedron collapses onto the line that both layers leave inside.
    prism_points: integration points of the prisms along zeta, if not those of the other elements.
    """
    b = int(base[1])  # degree of the Lagrange functions
    p, _, t = layer.partition("N")[2].partition(".")
    spaces = [Space(b, n, b) for n in counts]
    surface = [Space(int(p), n).elevated(int(t or 0)) for n in counts]
    shape = tuple(s.size for s in spaces)
    grid = np.full(shape, -1)
    kept = np.ones(shape, dtype=bool)
    for d, side in enriched:
        kept[_at(d, -side)] = False
    grid[kept] = np.arange(kept.sum())
    place = np.stack(np.meshgrid(*[s.greville for s in spaces], indexing="ij"), axis=-1)
    parameters, known, faces, blocks = list(place[kept]), {}, {}, []
    for d, side in enriched:
        plane = tuple(surface[i] for i in range(3) if i != d)
        nodes = np.zeros([s.size for s in plane], dtype=int)
        for i, j in np.ndindex(nodes.shape):
            where = np.insert([plane[0].greville[i], plane[1].greville[j]], d, float(side))
            key = tuple(where.round(12))
            if key not in known:  # the control points of a common edge belong to both faces
                known[key] = len(parameters)
                parameters.append(where)
            nodes[i, j] = known[key]
        faces[d, side] = Face(plane, nodes)
        blocks += _layer(grid, b, faces[d, side], d, side, enriched, "E9" in layer, prism_points)
    bulk = tensor_block(spaces, (b + 1,) * 3, grid)
    inside = (bulk.nodes >= 0).all(axis=1)
    if inside.any():
        bulk.modes = q1_modes(spaces) if base == "Q1E9" else None
        blocks.append(bulk.some(inside))
    for d, side in {(d, s) for d in range(3) for s in (0, 1)} - set(enriched):
        faces[d, side] = Face(tuple(spaces[i] for i in range(3) if i != d), grid[_at(d, -side)])
    return Patch(np.array(parameters), blocks, faces)


def _at(d, index):
    """The index of a plane of a grid: number `index` of direction d."""
    return (slice(None),) * d + (index,)


def _layer(grid, b, face, d, side, enriched, enhanced, prism_points):
    """The elements at one enriched face: zeta = -1 there, +1 inside; prisms in a block of their own."""
    spaces = face.spaces
    p = spaces[0].p
    x, w = rule(spaces, (p + 1, p + 1))
    flat = x.reshape(-1, 2)
    outer = grid_numbers([s.basis(flat[:, i])[0] for i, s in enumerate(spaces)], face.nodes.shape)
    nodes, prism = [face.nodes.ravel()[outer]], np.zeros(len(x), dtype=bool)
    numbers = [Space(b, s.n, b).basis(flat[:, i])[0] for i, s in enumerate(spaces)]
    for i, axis in enumerate([i for i in range(3) if i != d]):
        low, high = ((axis, 0) in enriched), grid.shape[axis] - 1 - ((axis, 1) in enriched)
        moved = np.clip(numbers[i], low, high)  # a corner below another enriched face moves inside
        prism |= (moved != numbers[i]).any(axis=1).reshape(len(x), -1).any(axis=1)
        numbers[i] = moved
    for j in range(1, b + 1):
        plane = grid.take(-1 - j if side else j, axis=d)
        nodes.append(plane.ravel()[grid_numbers(numbers, plane.shape)])
    nodes = np.concatenate(nodes, axis=1).reshape(*x.shape[:2], -1)[:, 0]
    blocks = []
    for chosen, points in ((~prism, b + 1), (prism, prism_points or b + 1)):
        zeta, wz = np.polynomial.legendre.leggauss(points)
        slopes = np.concatenate([layer_slopes(spaces, b, x, z) for z in zeta], axis=1)
        block = Block(nodes, slopes, np.concatenate([w * v for v in wz], axis=1))
        if enhanced:
            line = np.polynomial.legendre.leggauss(p + 1)[0]
            xi = np.stack(np.meshgrid(zeta, line, line, indexing="ij"), axis=-1)[..., [1, 2, 0]]
            centre = layer_slopes(spaces, b, rule(spaces, (1, 1))[0], 0.0)[:, 0]
            block.modes = xi.reshape(-1, 3), centre
        if chosen.any():
            blocks.append(block.some(chosen))
    return blocks


def layer_slopes(spaces, b, x, zeta):
    """Derivatives (E, Q, A, 3) of the enriched functions, eqs. (15) and (16), at x (E, Q, 2).

    First those of the surface, then a plane of Lagrange functions for each further node in zeta.
    """
    flat = x.reshape(-1, 2)
    lagrange = [Space(b, s.n, b) for s in spaces]
    outer, inner = (
        tensor([s.basis(flat[:, i])[1] for i, s in enumerate(c)]) for c in (spaces, lagrange)
    )
    if b == 1:  # eq. (17)
        line, slope = ((1 - zeta) / 2, (1 + zeta) / 2), (-0.5, 0.5)
    else:  # eq. (18), in the order of the nodes
        line = ((zeta**2 - zeta) / 2, 1 - zeta**2, (zeta**2 + zeta) / 2)
        slope = (zeta - 0.5, -2 * zeta, zeta + 0.5)
    parts = [outer] + [inner] * b
    along = np.concatenate([s * v for (_, s), v in zip(parts, line)], axis=1)
    across = np.concatenate([f * v for (f, _), v in zip(parts, slope)], axis=1)[:, :, None]
    return np.concatenate([along, across], axis=2).reshape(*x.shape[:2], -1, 3)


def q1_modes(spaces):
    """What the nine enhanced modes need: xi at the points (Q, 3), derivatives at the centre."""
    line = np.polynomial.legendre.leggauss(2)[0]
    xi = np.stack(np.meshgrid(line, line, line, indexing="ij"), axis=-1).reshape(-1, 3)
    x, _ = rule(spaces, (1, 1, 1))
    return xi, tensor([s.basis(x[:, 0, i])[1] for i, s in enumerate(spaces)])[1]
