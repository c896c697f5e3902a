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


def layered_patch(counts, enriched, p=2, t=0, enhanced=False):
    """Q1 or Q1E9 elements whose layers at the faces `enriched` are Q1Np.t elements.

    Where two enriched faces meet, each element of the edge column becomes two prisms (section 4.1):
    the inner face of the enriched hexahedron collapses onto the line that both layers leave inside.
    """
    spaces = [Space(1, n) for n in counts]
    surface = [Space(p, n).elevated(t) for n in counts]
    shape = tuple(n + 1 for n in counts)
    grid = np.full(shape, -1)
    kept = np.ones(shape, dtype=bool)
    for d, side in enriched:
        kept[_at(d, -side)] = False
    grid[kept] = np.arange(kept.sum())
    place = np.stack(np.meshgrid(*[s.greville for s in spaces], indexing="ij"), axis=-1)
    parameters, known, faces = list(place[kept]), {}, {}
    for d, side in enriched:
        plane = tuple(surface[i] for i in range(3) if i != d)
        nodes = np.zeros([s.size for s in plane], dtype=int)
        for a, b in np.ndindex(nodes.shape):
            where = np.insert([plane[0].greville[a], plane[1].greville[b]], d, float(side))
            key = tuple(where.round(12))
            if key not in known:  # the control points of a common edge belong to both faces
                known[key] = len(parameters)
                parameters.append(where)
            nodes[a, b] = known[key]
        faces[d, side] = Face(plane, nodes)
    blocks = [_layer(grid, surface, d, side, enriched, faces[d, side]) for d, side in enriched]
    bulk = tensor_block(spaces, (2, 2, 2), grid)
    inside = (bulk.nodes >= 0).all(axis=1)
    if inside.any():
        core = Block(bulk.nodes[inside], bulk.derivatives[inside], bulk.weights[inside])
        core.modes = q1_modes(spaces, inside) if enhanced else None
        blocks.append(core)
    for d, side in {(d, s) for d in range(3) for s in (0, 1)} - set(enriched):
        faces[d, side] = Face(tuple(spaces[i] for i in range(3) if i != d), grid[_at(d, -side)])
    return Patch(np.array(parameters), blocks, faces)


def _at(d, index):
    """The index of a plane of a grid: number `index` of direction d."""
    return (slice(None),) * d + (index,)


def _layer(grid, surface, d, side, enriched, face):
    """The elements Q1Np at one face, eq. (15): zeta = -1 there, +1 at the four inner nodes."""
    plane = [i for i in range(3) if i != d]
    p = face.spaces[0].p
    x, w = rule(face.spaces, (p + 1, p + 1))
    flat = x.reshape(-1, 2)
    found = [s.basis(flat[:, i]) for i, s in enumerate(face.spaces)]
    outer, outer_slope = tensor([f for _, f in found])
    outer_nodes = face.nodes.ravel()[grid_numbers([n for n, _ in found], face.nodes.shape)]
    found = [Space(1, s.n).basis(flat[:, i]) for i, s in enumerate(face.spaces)]
    inner, inner_slope = tensor([f for _, f in found])
    numbers = [n for n, _ in found]
    for i, axis in enumerate(plane):  # prisms: a corner below another enriched face moves inside
        low, high = int((axis, 0) in enriched), grid.shape[axis] - 1 - int((axis, 1) in enriched)
        numbers[i] = np.clip(numbers[i], low, high)
    layer = grid.take(-2 if side else 1, axis=d)
    inner_nodes = layer.ravel()[grid_numbers(numbers, layer.shape)]
    zeta, wz = np.polynomial.legendre.leggauss(2)
    derivatives = []
    for z in zeta:
        down, up = (1 - z) / 2, (1 + z) / 2
        along = np.concatenate([outer_slope * down, inner_slope * up], axis=1)
        across = np.concatenate([-outer / 2, inner / 2], axis=1)[:, :, None]
        derivatives.append(np.concatenate([along, across], axis=2))
    per = x.shape[:2]
    nodes = np.concatenate([outer_nodes, inner_nodes], axis=1).reshape(*per, -1)[:, 0]
    slopes = np.concatenate([s.reshape(*per, -1, 3) for s in derivatives], axis=1)
    return Block(nodes, slopes, np.concatenate([w * v for v in wz], axis=1))


def q1_modes(spaces, chosen=slice(None)):
    """What the nine enhanced modes need: xi at the points (Q, 3), derivatives at the centre."""
    line = np.polynomial.legendre.leggauss(2)[0]
    xi = np.stack(np.meshgrid(line, line, line, indexing="ij"), axis=-1).reshape(-1, 3)
    x, _ = rule(spaces, (1, 1, 1))
    _, slopes = tensor([s.basis(x[:, 0, i])[1] for i, s in enumerate(spaces)])
    return xi, slopes[chosen]
