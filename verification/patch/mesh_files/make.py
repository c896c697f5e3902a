"""Write the meshes of this folder: a column of mixed elements, and a coarse block on a fine one.

python -m verification.patch.mesh_files.make
"""

import itertools
import pathlib

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
A = np.array([[0.1, 0.15, -0.05], [0.05, -0.05, 0.1], [-0.1, 0.05, 0.2]])  # displacement gradient
FACES = {
    4: [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    5: [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]],
    6: [[0, 2, 1], [3, 4, 5], [0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5]],
    7: [[0, 3, 2, 1], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]],
}
SIDES = [[0, 1, 2, 3], [7, 6, 5, 4], [0, 4, 5, 1], [1, 5, 6, 2], [2, 6, 7, 3], [3, 7, 4, 0]]


def grid(n, low, size, amount, rng):
    """The nodes of a box of n cells, with inner nodes moved at random, and the numbers of the nodes
    by (i, j, k).
    """
    x = []
    for k, j, i in itertools.product(*(range(m + 1) for m in n[::-1])):
        at = np.array([i, j, k])
        move = rng.uniform(-amount, amount, 3) * (at > 0) * (at < n)
        x.append(low + size * (at + move) / n)
    return x, lambda i, j, k: i + (n[0] + 1) * (j + (n[1] + 1) * k)


def fill(kind, x, c, rng=None):
    """Elements (Gmsh type, nodes) of the cell with the corners c; pyramids have a random apex."""
    if kind == "hexahedra":
        return [(5, c)]
    if kind == "wedges":
        return [(6, [c[a] for a in ids]) for ids in ([0, 1, 2, 4, 5, 6], [0, 2, 3, 4, 6, 7])]
    if kind == "tetrahedra":  # six of them around the diagonal
        paths = [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]]
        return [(4, [c[a] for a in ids]) for ids in paths]
    middle = len(x)  # pyramids; two tetrahedra take the place of the lowest one
    x.append(np.mean([x[a] for a in c], axis=0) + (rng.uniform(-0.02, 0.02, 3) if rng else 0))
    low, *others = ([c[a] for a in side] for side in SIDES)
    halves = [(4, [low[0], low[1], low[2], middle]), (4, [low[0], low[2], low[3], middle])]
    return halves + [(7, [*side, middle]) for side in others]


def cells(n, x, number, kinds, rng=None):
    elements = []
    for k, j, i in itertools.product(*(range(m) for m in n[::-1])):
        low = [number(i, j, k), number(i + 1, j, k), number(i + 1, j + 1, k), number(i, j + 1, k)]
        step = number(0, 0, 1)
        elements += fill(kinds[k], x, low + [a + step for a in low], rng)
    return elements


def boundary(elements):
    seen = {}
    for kind, c in elements:
        for ids in FACES[kind]:
            face = [c[a] for a in ids]
            seen.setdefault(tuple(sorted(face)), []).append(face)
    return [faces[0] for faces in seen.values() if len(faces) == 1]


def write(name, x, elements, label, hanging=(), inner=()):
    """Write a Gmsh 2.2 file with the groups body and skin, and the affine displacement of the
    skin.
    """
    skin = [face for face in boundary(elements) if not set(face) & set(inner)]
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", "2", '3 1 "body"']
    lines += ['2 2 "skin"', "$EndPhysicalNames", "$Nodes", str(len(x))]
    lines += [f"{n} {p[0]!r} {p[1]!r} {p[2]!r}" for n, p in zip(label, np.array(x).tolist())]
    rows = [(len(f) - 1, 2, f) for f in skin] + [(kind, 1, c) for kind, c in elements]
    lines += ["$EndNodes", "$Elements", str(len(rows))]
    for e, (kind, tag, c) in enumerate(rows, 1):
        lines.append(f"{e} {kind} 2 {tag} {tag} " + " ".join(str(label[a]) for a in c))
    save(HERE / f"{name}.msh", [*lines, "$EndElements"])
    place = {
        a: i for i, a in enumerate(np.argsort(label), 1)
    }  # deck nodes are numbered in the order of the labels
    held = sorted({a for f in skin for a in f}, key=place.get)
    lines = ["BOUNdary", *(f"  {place[a]} 0  1 1 1" for a in held), "", "DISPlacements"]
    lines += [
        f"  {place[a]} 0  {u[0]!r} {u[1]!r} {u[2]!r}" for a in held for u in [(A @ x[a]).tolist()]
    ]
    save(HERE / f"{name}.inc", [*lines, ""])
    if hanging:
        lines = ["# slave, number of masters, masters and coefficients"]
        for slave, masters in hanging:
            pairs = " ".join(f"{label[m]} {c!r}" for m, c in masters)
            lines.append(f"{label[slave]} {len(masters)} {pairs}")
        save(HERE / f"{name}.txt", lines)


def save(path, lines):
    with open(path, "w") as file:
        file.write("\n".join(lines) + "\n")


def mixed():
    rng = np.random.default_rng(3)
    n = np.array([2, 2, 4])
    x, number = grid(n, np.zeros(3), np.array([1.0, 1.0, 1.5]), 0.25, rng)
    elements = cells(n, x, number, ["tetrahedra", "wedges", "pyramids", "hexahedra"], rng)
    write("mixed", x, elements, (rng.permutation(len(x)) * 3 + 5).tolist())


def hanging():
    """Two blocks. On the common face, nodes of the fine block hang on nodes of the coarse block;
    some do so by a chain, in which a master is itself a slave.
    """
    rng = np.random.default_rng(5)
    coarse, fine = np.array([1, 2, 2]), np.array([2, 4, 4])
    x, number = grid(coarse, np.zeros(3), np.ones(3), 0.0, rng)
    common = {(2 * j, 2 * k): number(1, j, k) for j in range(3) for k in range(3)}
    for a in common.values():  # a warped common face
        inside = (x[a] > 0) * (x[a] < 1) + np.array([1, 0, 0])
        x[a] = x[a] + rng.uniform(-0.1, 0.1, 3) * (inside > 0)
    elements = cells(coarse, x, number, ["hexahedra"] * 2, rng)
    y, at = grid(fine, np.array([1.0, 0, 0]), np.ones(3), 0.2, rng)
    new = {at(0, *jk): a for jk, a in common.items()}
    for a in range(len(y)):
        if a not in new:
            new[a] = len(x)
            x.append(y[a])
    slaves = []
    for j, k in itertools.product(range(5), range(5)):
        ends = [(j - 1, k), (j + 1, k)] if j % 2 else [(j, k - 1), (j, k + 1)]
        if j % 2 + k % 2 > 0:
            c = [0.6, 0.4] if j % 2 else [0.45, 0.55]
            slaves.append((new[at(0, j, k)], [(new[at(0, *e)], w) for e, w in zip(ends, c)]))
    names = {slave for slave, _ in slaves}
    slaves.sort(key=lambda pair: any(m in names for m, _ in pair[1]))
    for slave, masters in slaves:
        x[slave] = sum(c * x[m] for m, c in masters)
    shifted = cells(fine, y, at, ["hexahedra"] * 4, rng)
    elements += [(kind, [new[a] for a in c]) for kind, c in shifted]
    inner = {new[at(0, j, k)] for j in range(1, 4) for k in range(1, 4)}
    write("hanging", x, elements, list(range(11, 11 + len(x))), slaves, inner)


def tetrahedra(name, quadratic):
    """A cube of tetrahedra with 4 or 10 nodes, and the groups bottom and top."""
    rng = np.random.default_rng(1)
    n = np.array([3, 3, 2])
    x, number = grid(n, np.zeros(3), np.ones(3), 0.2, rng)
    elements = cells(n, x, number, ["tetrahedra"] * 2, rng)
    skin = boundary(elements)
    rows = [(2, 1, f) for f in skin if all(x[a][2] == 0 for a in f)]
    rows += [(2, 2, f) for f in skin if all(x[a][2] == 1 for a in f)]
    rows += [(kind, 0, c) for kind, c in elements]
    middles = {}

    def middle(a, b):
        if (min(a, b), max(a, b)) not in middles:
            middles[min(a, b), max(a, b)] = len(x)
            x.append((x[a] + x[b]) / 2)
        return middles[min(a, b), max(a, b)]

    if quadratic:  # edges in the order of Gmsh
        edges = {2: [(0, 1), (1, 2), (2, 0)]}
        edges[4] = [*edges[2], (0, 3), (2, 3), (1, 3)]
        new = {2: 9, 4: 11}
        rows = [(new[k], t, c + [middle(c[a], c[b]) for a, b in edges[k]]) for k, t, c in rows]
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", "2", '2 1 "bottom"']
    lines += ['2 2 "top"', "$EndPhysicalNames", "$Nodes", str(len(x))]
    lines += [f"{i} {p[0]!r} {p[1]!r} {p[2]!r}" for i, p in enumerate(np.array(x).tolist(), 1)]
    lines += ["$EndNodes", "$Elements", str(len(rows))]
    for e, (kind, tag, c) in enumerate(rows, 1):
        lines.append(f"{e} {kind} 2 {tag} {tag} " + " ".join(str(a + 1) for a in c))
    save(HERE / f"{name}.msh", [*lines, "$EndElements"])


if __name__ == "__main__":
    mixed()
    hanging()
    tetrahedra("tet4", False)
    tetrahedra("tet10", True)
