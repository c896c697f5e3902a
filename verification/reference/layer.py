"""Patches with enriched layers at some of their faces, eqs. (15) and (16)."""

import numpy as np

from verification.reference.mesh import (
    Block,
    Face,
    Patch,
    grid_numbers,
    q1_modes,
    rule,
    tensor,
    tensor_block,
)
from verification.reference.spline import Space


def layered_patch(counts, enriched, base="Q1", layer="Q1N2", prism_points=None):
    """Elements Q1, Q1E9 or Q2 whose layers at the faces `enriched` are Q1Np.t, Q2Np.t or Q1E9Np.t.

    Where two enriched faces meet, each element of the column along their edge becomes two prisms
    (section 4.1): the inner face of the enriched hexahedron collapses onto the line where both
    layers meet. prism_points: integration points of the prisms along zeta, if different from those
    of other elements.
    """
    b = int(base[1])  # degree of the Lagrange functions
    if b == 2 and len(enriched) > 1:
        raise ValueError("Q2Np on two faces is not covered")
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
            if key not in known:  # faces share the control points of their common edge
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
    """The index that selects plane number `index` of a grid in direction d."""
    return (slice(None),) * d + (index,)


def _layer(grid, b, face, d, side, enriched, enhanced, prism_points):
    """The elements at one enriched face, with zeta = -1 on the face and +1 inside; prisms form a
    separate block.
    """
    spaces = face.spaces
    p = spaces[0].p
    x, w = rule(spaces, (p + 1, p + 1))
    flat = x.reshape(-1, 2)
    outer = grid_numbers([s.basis(flat[:, i])[0] for i, s in enumerate(spaces)], face.nodes.shape)
    nodes, prism = [face.nodes.ravel()[outer]], np.zeros(len(x), dtype=bool)
    numbers = [Space(b, s.n, b).basis(flat[:, i])[0] for i, s in enumerate(spaces)]
    for i, axis in enumerate([i for i in range(3) if i != d]):
        low, high = ((axis, 0) in enriched), grid.shape[axis] - 1 - ((axis, 1) in enriched)
        moved = np.clip(numbers[i], low, high)  # corners below another enriched face move
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

    The derivatives of the surface functions come first, then one plane of Lagrange functions for
    each further node in zeta.
    """
    flat = x.reshape(-1, 2)
    lagrange = [Space(b, s.n, b) for s in spaces]
    outer, inner = (
        tensor([s.basis(flat[:, i])[1] for i, s in enumerate(c)]) for c in (spaces, lagrange)
    )
    if b == 1:  # eq. (17)
        line, slope = ((1 - zeta) / 2, (1 + zeta) / 2), (-0.5, 0.5)
    else:  # eq. (18), with the functions in the order of the nodes
        line = ((zeta**2 - zeta) / 2, 1 - zeta**2, (zeta**2 + zeta) / 2)
        slope = (zeta - 0.5, -2 * zeta, zeta + 0.5)
    parts = [outer] + [inner] * b
    along = np.concatenate([s * v for (_, s), v in zip(parts, line)], axis=1)
    across = np.concatenate([f * v for (f, _), v in zip(parts, slope)], axis=1)[:, :, None]
    return np.concatenate([along, across], axis=2).reshape(*x.shape[:2], -1, 3)
