"""A closed net of quads whose smooth surface is nearly a sphere of radius 1: an inflated cube.

    python3 -m input.sphere_net N FILE.obj [POLE]

The cube has N quads along an edge. Towards the poles (0, 0, -1) and (0, 0, 1) the quads become
smaller, down to POLE times (default 0.6) their size in a uniform net. The points of the net minimise
the mean distance of its surface from the sphere, with the extraction that `python -m post mesh` uses.
"""

import sys

import numpy as np

from post.mesh import _net, _patches, _surface

POLE = 0.6
ROUNDS = 3
ANGLES = np.linspace(0, np.pi, 20001)


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


def blown_up(x, pole):
    """Points of the cube moved to the unit sphere at equal angles, then towards the poles.

    An angle t from a pole becomes the integral of `slope` divided by the mean of `slope`. It is
    smooth everywhere and flat at the poles, so that many quads there have the same size.
    """
    x = np.tan(np.pi / 4 * x)
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    rate = slope(ANGLES, strength(pole))
    angle = np.r_[0, np.cumsum(0.5 * (rate[1:] + rate[:-1]))]
    angle = np.interp(np.arccos(x[:, 2]), ANGLES, np.pi * angle / angle[-1])
    around = np.arctan2(x[:, 1], x[:, 0])
    ring = np.sin(angle)
    return np.column_stack([ring * np.cos(around), ring * np.sin(around), np.cos(angle)])


def slope(t, k):
    """Size of the quads at the angle t from a pole relative to that at the pole."""
    return np.exp(k * np.sin(t) ** 4)


def strength(pole):
    """k for which quads at the poles are `pole` times as large as without it.

    >>> round(1 / float(slope(ANGLES[1:], strength(0.3)).mean()), 9)
    0.3
    """
    low, high = 0.0, 40.0
    for _ in range(60):
        k = 0.5 * (low + high)
        low, high = (k, high) if slope(ANGLES[1:], k).mean() < 1 / pole else (low, k)
    return low


def fitted(surface, points):
    """(n, 3) control points of the surface nearest to the sphere, by least squares of its radii.

    A control point moves along its direction from the centre.
    """
    t = np.linspace(-0.9, 0.9, 4)
    u, v = (k.ravel() for k in np.meshgrid(t, t))
    p, q = surface.degree
    shape = (_surface.bernstein(q, v)[:, :, None] * _surface.bernstein(p, u)[:, None]).reshape(
        16, 16
    )
    elements = [(ids, shape @ c.T) for ids, c in zip(surface.nodes, surface.coefficients)]
    way = _surface.unit(points)
    for _ in range(ROUNDS):
        matrix, right = np.zeros((len(points), len(points))), np.zeros(len(points))
        for ids, rows in elements:
            radii = rows * (_surface.unit(rows @ points[ids]) @ way[ids].T)
            matrix[np.ix_(ids, ids)] += radii.T @ radii
            right[ids] += radii.sum(axis=0)
        points = way * np.linalg.solve(matrix, right)[:, None]
    return points


def main(n, path, pole=POLE):
    x, quads = cube(n)
    net = _net.checked(_net.Net(blown_up(x, pole), quads), path)
    points = fitted(_patches.extract(net), net.points)
    with open(path, "w") as f:
        f.write(f"# a cube of {n} x {n} quads a side, blown up; made by input/sphere_net.py\n")
        f.writelines(f"v {a:.15g} {b:.15g} {c:.15g}\n" for a, b, c in points)
        f.writelines("f " + " ".join(str(v + 1) for v in q) + "\n" for q in quads)


def arguments(words):
    """(N, FILE, POLE) of the command line; None if they cannot be used."""
    if len(words) not in (2, 3) or not words[0].isdigit() or int(words[0]) < 2:
        return None
    try:
        pole = float(words[2]) if words[2:] else POLE
    except ValueError:
        return None
    return (int(words[0]), words[1], pole) if 0 < pole < 1 else None


if __name__ == "__main__":
    given = arguments(sys.argv[1:])
    if given is None:
        sys.exit(
            "usage: python3 -m input.sphere_net N FILE.obj [POLE]   (N at least 2, POLE in 0 to 1)"
        )
    main(*given)
