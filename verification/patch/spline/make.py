"""Write the files of this case: an L-shaped body of three blocks, with a layer below a smooth
surface.

    python -m verification.patch.spline.make

The surface follows from the boundary of 24 hexahedra, a closed net of 56 quadrilaterals at whose
corners 3, 4 or 5 edges meet. With n the number of edges at a corner, the Bezier points are
combinations of the points of the net: face points with weights (n, 2, 2, 1)/(n + 5), edge points as
the mean of two face points, corners as the mean of n face points. Where n = 4, this is the uniform
bicubic B-spline.

    surface.bxt  the surface, BEXT 2.0
    layer.txt    the inner nodes of the elements of the surface
    core.inc     the 24 hexahedra
    affine.inc   an affine displacement of all control points
    split.bxt, split.txt, split.inc, hanging.txt
        the same for a surface with two elements split into four, whose inner nodes hang on the
        hexahedra below
"""

import itertools
import math
import pathlib

HERE = pathlib.Path(__file__).resolve().parent
CELLS = [(i, j, k) for i, j in ((0, 0), (1, 0), (0, 1)) for k in (0,)]
PARTS = 2  # cells of a block in each direction
SPLIT = (2, 2, 2)  # two of the five elements at this corner are split in one of the two surfaces
PUSH = 0.6  # distance of the net from the hexahedra, relative to a cell
GRADIENT = ((0.20, 0.05, -0.03), (0.04, -0.10, 0.06), (-0.02, 0.03, 0.15))
FACES = {
    (-1, 0, 0): (0, 4, 7, 3),
    (1, 0, 0): (1, 2, 6, 5),
    (0, -1, 0): (0, 1, 5, 4),
    (0, 1, 0): (3, 7, 6, 2),
    (0, 0, -1): (0, 3, 2, 1),
    (0, 0, 1): (4, 5, 6, 7),
}
CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))


def shape(x):
    """A smooth map under which no line stays straight."""
    a, b, c = (0.5 * v for v in x)
    return (
        a + 0.05 * math.sin(2 * b + c),
        b + 0.04 * math.cos(1.5 * a - c),
        c + 0.06 * math.sin(a * b + 0.5),
    )


def add(x, y):
    return tuple(a + b for a, b in zip(x, y, strict=True))


def hexahedra():
    """Lattice points of each hexahedron, and of each boundary face together with its normal."""
    small = sorted(
        tuple(PARTS * c + d for c, d in zip(cell, part, strict=True))
        for cell in CELLS
        for part in itertools.product(range(PARTS), repeat=3)
    )
    cells = [tuple(add(cell, c) for c in CORNERS) for cell in small]
    quads = [
        (tuple(points[i] for i in face), normal)
        for cell, points in zip(small, cells, strict=True)
        for normal, face in FACES.items()
        if add(cell, normal) not in small
    ]
    return cells, quads


class Net:
    """A net of quadrilaterals, whose corners are counter-clockwise seen from outside."""

    def __init__(self, quads):
        self.quads = quads
        self.round = {}  # corner of the net: the quadrilaterals around it
        for q, quad in enumerate(quads):
            for v in quad:
                self.round.setdefault(v, []).append(q)

    def face_point(self, q, v):
        quad = self.quads[q]
        i, n = quad.index(v), len(self.round[v])
        weights = ((v, n), (quad[i - 3], 2), (quad[i - 1], 2), (quad[i - 2], 1))
        return {u: w / (n + 5) for u, w in weights}

    def edge_point(self, v, u):
        """The point near v on the edge from v to u."""
        return mean([self.face_point(q, v) for q in self.round[v] if u in self.quads[q]])

    def corner(self, v):
        return mean([self.face_point(q, v) for q in self.round[v]])

    def points(self, q):
        """The 16 Bezier points of a quadrilateral, with the first direction varying fastest."""
        a, b, c, d = self.quads[q]
        return [
            self.corner(a), self.edge_point(a, b), self.edge_point(b, a), self.corner(b),
            self.edge_point(a, d), self.face_point(q, a), self.face_point(q, b),
            self.edge_point(b, c),
            self.edge_point(d, a), self.face_point(q, d), self.face_point(q, c),
            self.edge_point(c, b),
            self.corner(d), self.edge_point(d, c), self.edge_point(c, d), self.corner(c),
        ]  # fmt: skip


def mean(points):
    total = {}
    for point in points:
        for v, w in point.items():
            total[v] = total.get(v, 0.0) + w / len(points)
    return total


def bext(nodes, elements):
    """BEXT 2.0 text of elements given as (node numbers from 1, one row of coefficients each)."""
    vectors, groups = {}, {}
    for ids, rows in elements:
        groups.setdefault(len(ids), []).append((ids, rows))
    assert [e for g in groups.values() for e in g] == elements
    for _, rows in elements:
        for row in rows:
            vectors.setdefault(row, len(vectors) + 1)
    lines = ["B E X T 2.0", f"1 {len(nodes)} {len(elements)} {len(vectors)} 0"]
    lines += [" ".join(f"{v:.17g}" for v in (*x, 1.0)) for x in nodes]
    lines += [f"{len(groups)}"]
    lines += [f"1 {len(g)} {n} {n} 3 3" for n, g in groups.items()]
    for ids, rows in elements:
        for numbers in (ids, [vectors[row] for row in rows]):
            lines += [" ".join(map(str, numbers[i : i + 10])) for i in range(0, len(ids), 10)]
    lines += ["1 0", f"{len(vectors)} 16"]
    for row in vectors:
        lines += [" ".join(f"{v:.17g}" for v in row[i : i + 5]) for i in range(0, 16, 5)]
    return lines


def layer(inner):
    lines = ["# element of the surface, and its inner nodes"]
    return lines + [f"{e} " + " ".join(map(str, nodes)) for e, nodes in enumerate(inner, 1)]


class Hanging:
    """Nodes at the centres of edges and faces, identified by their masters."""

    def __init__(self, last, chosen):
        self.last = last
        self.chosen = chosen  # inner nodes of the elements that are split
        self.node = {}

    def at(self, *masters):
        return self.node.setdefault(tuple(sorted(masters)), self.last + len(self.node) + 1)


def middle(points):
    return tuple(sum(c) / len(points) for c in zip(*points, strict=True))


def split(element, inner, hanging):
    """Four elements with the same functions, or just the element if it is not split."""
    ids, rows = element
    if inner not in hanging.chosen:
        return [(element, inner)]
    a, b, c, d = inner
    ab, bc, cd, da = (hanging.at(*m) for m in ((a, b), (b, c), (c, d), (d, a)))
    m = hanging.at(a, b, c, d)
    quads = ((a, ab, m, da), (ab, b, bc, m), (da, m, cd, d), (m, bc, c, cd))
    return [
        ((ids, [half(row, i, j) for row in rows]), quads[i + 2 * j]) for j in (0, 1) for i in (0, 1)
    ]


def half(row, i, j):
    """The Bernstein coefficients on a quarter of the element."""
    lines = [line(row[4 * k : 4 * k + 4], i) for k in range(4)]
    columns = [line([p[k] for p in lines], j) for k in range(4)]
    return tuple(columns[k][n] for n in range(4) for k in range(4))


def line(p, side):
    """The coefficients on one half, by de Casteljau's algorithm."""
    left, right = [], []
    while p:
        left.append(p[0])
        right.insert(0, p[-1])
        p = [0.5 * (a + b) for a, b in zip(p, p[1:], strict=False)]
    return (left, right)[side]


def main():
    cells, faces = hexahedra()
    core = sorted({v for cell in cells for v in cell})
    number = {v: i for i, v in enumerate(core, 1)}
    push = {}
    for quad, normal in faces:
        for v in quad:
            push.setdefault(v, set()).add(normal)
    net = Net([quad for quad, _ in faces])
    order = sorted(
        range(len(net.quads)), key=lambda q: max(len(net.round[v]) for v in net.quads[q])
    )
    order.sort(key=lambda q: len({v for p in net.points(q) for v in p}))
    points = sorted(push)
    place = {v: i for i, v in enumerate(points, 1)}
    x = {
        v: shape(add(v, tuple(PUSH * sum(n[d] for n in push[v]) for d in range(3)))) for v in points
    }
    elements = []
    for q in order:
        coefficients = net.points(q)
        keys = list(dict.fromkeys(v for p in coefficients for v in p))
        rows = [tuple(p.get(v, 0.0) for p in coefficients) for v in keys]
        elements.append(([place[v] for v in keys], rows))
    inner = [tuple(number[v] for v in net.quads[q]) for q in order]
    write("surface.bxt", bext([x[v] for v in points], elements))
    write("layer.txt", layer(inner))
    chosen = [q for q in inner if number[SPLIT] in q][:2]
    hanging = Hanging(len(core), chosen)
    halves = [split(e, i, hanging) for e, i in zip(elements, inner, strict=True)]
    elements, inner = map(list, zip(*(part for parts in halves for part in parts), strict=True))
    write("split.bxt", bext([x[v] for v in points], elements))
    write("split.txt", layer(inner))
    write("hanging.txt", ["! slave, number of masters, masters and their coefficients"] + [
        f"{node} {len(m)} " + " ".join(f"{k} {1 / len(m)}" for k in m)
        for m, node in hanging.node.items()
    ])  # fmt: skip
    place = {number[v]: shape(v) for v in core}
    lines = ["COORdinates"]
    lines += [f"  {n} 0 " + numbers(middle([place[k] for k in m])) for m, n in hanging.node.items()]
    write("split.inc", [*lines, ""])
    lines = ["COORdinates"]
    lines += [f"  {number[v]} 0 " + " ".join(f"{c:.17g}" for c in shape(v)) for v in core]
    lines += ["", "ELEMents"]
    lines += [
        f"  {e} 0 m " + " ".join(str(number[v]) for v in cell) for e, cell in enumerate(cells, 1)
    ]
    write("core.inc", [*lines, ""])
    lines = ["CBOUndary"]
    lines += ["  NODE " + numbers(x[v]) + " 1 1 1" for v in points]
    lines += ["", "CDISplacement"]
    lines += ["  NODE " + numbers(x[v]) + " " + numbers(displacement(x[v])) for v in points]
    write("affine.inc", [*lines, ""])


def displacement(x):
    return tuple(sum(g * c for g, c in zip(row, x, strict=True)) for row in GRADIENT)


def numbers(x):
    return " ".join(f"{c:.17g}" for c in x)


def write(name, lines):
    (HERE / name).write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
