"""A closed net of quads whose smooth surface is nearly a sphere of radius 1: a cube, blown up.

    python3 input/sphere_net.py N FILE.obj

N quads along an edge of the cube; towards the poles (0, 0, -1) and (0, 0, 1) the quads become smaller.
The points of the net are those whose surface is nearest to the sphere, in the mean over its elements,
with the extraction that `python -m post mesh` uses.
"""

import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from post.mesh import _net, _patches, _surface  # noqa: E402

POLE = 0.6  # size of the quads at the poles over that at the equator
ROUNDS = 3


def cube(n):
    """(points, quads) of the surface of a cube [-1, 1]^3, seen from outside counter-clockwise."""
    number, points, quads = {}, [], []

    def point(x):
        if x not in number:
            number[x] = len(points)
            points.append(x)
        return number[x]

    for axis in range(3):
        for side in (0, n):
            for i in range(n):
                for j in range(n):
                    corners = []
                    for a, b in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)):
                        x = [0, 0, 0]
                        x[axis], x[(axis + 1) % 3], x[(axis + 2) % 3] = side, a, b
                        corners.append(point(tuple(x)))
                    quads.append(corners if side else corners[::-1])
    return 2 * np.array(points) / n - 1, np.array(quads)


def blown_up(x):
    """Points of the cube moved to the unit sphere at equal angles, denser at the poles."""
    pole = np.abs(x[:, 2]) == 1
    inside = (1 - x[:, :1] ** 2) * (1 - x[:, 1:2] ** 2)  # zero on the face's edges
    x = x.copy()
    x[pole, :2] *= 1 - (1 - POLE) * inside[pole]
    x = np.tan(np.pi / 4 * x)
    return x / np.linalg.norm(x, axis=1, keepdims=True)


def fitted(surface, points):
    """(n, 3) control points of the surface nearest to the sphere, by least squares."""
    t = np.linspace(-0.9, 0.9, 4)
    u, v = (k.ravel() for k in np.meshgrid(t, t))
    p, q = surface.degree
    shape = (_surface.bernstein(q, v)[:, :, None] * _surface.bernstein(p, u)[:, None]).reshape(16, 16)
    rows = np.zeros((16 * len(surface.nodes), len(points)))
    for e, (ids, c) in enumerate(zip(surface.nodes, surface.coefficients)):
        rows[16 * e : 16 * e + 16, ids] = shape @ c.T
    # Only distances from the centre count; a little of the rest keeps points from sliding about.
    free = 1e-3 * np.eye(3)
    for _ in range(ROUNDS):
        x = rows @ points
        radius = np.linalg.norm(x, axis=1, keepdims=True)
        weight = np.einsum("ki,kj->kij", x / radius, x / radius) + free
        target = np.einsum("kij,kj->ki", weight, x / radius)
        n = len(points)
        matrix = np.zeros((n, 3, n, 3))
        for i in range(3):
            for j in range(3):
                matrix[:, i, :, j] = rows.T @ (weight[:, i, j, None] * rows)
        points = np.linalg.solve(matrix.reshape(3 * n, 3 * n), (rows.T @ target).ravel()).reshape(n, 3)
    return points


def main(n, path):
    x, quads = cube(n)
    net = _net.checked(_net.Net(blown_up(x), quads), path)
    points = fitted(_patches.extract(net), net.points)
    with open(path, "w") as f:
        f.write(f"# a cube of {n} x {n} quads a side, blown up; made by input/sphere_net.py\n")
        f.writelines(f"v {a:.15g} {b:.15g} {c:.15g}\n" for a, b, c in points)
        f.writelines("f " + " ".join(str(v + 1) for v in q) + "\n" for q in quads)


if __name__ == "__main__":
    if len(sys.argv) != 3 or not sys.argv[1].isdigit() or int(sys.argv[1]) < 2:
        sys.exit("usage: python3 input/sphere_net.py N FILE.obj   (N at least 2)")
    main(int(sys.argv[1]), sys.argv[2])
