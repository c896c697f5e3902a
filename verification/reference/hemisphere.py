"""Sections 5.2 and 5.3: a hollow hemisphere is pressed into a block and turned by 180 degrees."""

import numpy as np

from verification.reference.contact import Contact
from verification.reference.section4 import body
from verification.reference.spline import Space
from verification.reference.system import System, advance

MESHES = {1: (3, 1, 2, 125.0), 2: (7, 2, 4, 250.0)}  # n, m, k, penalty: Table 4
ELEMENTS = ("IGA2", "Q1E9+Q1N2", "Q1E9+Q1N3", "Q1E9+Q1N2.1")
DEPTH = 1.0  # depth of the indentation, in L0


def sphere(u, v):
    """Map the unit square to the lower unit hemisphere: elliptically to the disc, then
    azimuthally.
    """
    x, y = 2 * u - 1, 2 * v - 1
    a, b = x * np.sqrt(1 - y**2 / 2), y * np.sqrt(1 - x**2 / 2)
    angle = np.pi / 2 * np.hypot(a, b)
    scale = np.pi / 2 * np.sinc(angle / np.pi)  # sin(angle) divided by the radius in the disc
    return np.stack([a * scale, b * scale, -np.cos(angle)], axis=-1)


def outer_surface(p, n, t):
    """Space and control points (A, A, 3) of the spline that interpolates the map, elevated t
    times.
    """
    space = Space(p, n)
    g = space.greville
    inverse = np.linalg.inv(space.matrix(g))
    C = np.einsum("ai,bj,ijc->abc", inverse, inverse, sphere(g[:, None], g[None, :]))
    raised = space.elevated(t)
    if t:  # the elevated space contains the spline, so that interpolation is exact
        M = np.linalg.inv(raised.matrix(raised.greville)) @ space.matrix(raised.greville)
        C = np.einsum("ai,bj,ijc->abc", M, M, C)
    return raised, C


def hemisphere(name, n, m):
    """Patch and positions; direction 3 runs from the outer surface inwards to 2/3 of its radius."""
    if name == "IGA2":
        patch, (p, t) = body(name, (n, n, m)), (2, 0)
    else:
        patch = body(f"{name} on 3-", (n, n, m))
        p, _, t = name.removeprefix("Q1E9+Q1N").partition(".")
    space, C = outer_surface(int(p), n, int(t or 0))
    u, v, w = patch.parameters.T
    if name == "IGA2":
        x = np.repeat(C.reshape(-1, 3), patch.faces[0, 0].nodes.shape[1], axis=0)
    else:  # inner nodes lie on the spline; the nodes of the face are its control points
        x = np.einsum("pa,pb,abc->pc", space.matrix(u), space.matrix(v), C)
        x[patch.faces[2, 0].nodes] = C
    return patch, x * (1 - w / 3)[:, None] + (0, 0, 1)


def build(name, mesh, mu, exact=True):
    """The system, its contact, and the function that moves the rim of the hemisphere."""
    n, m, k, penalty = MESHES[mesh]
    upper, x = hemisphere(name, n, m)
    lower = body(name if name == "IGA2" else f"{name} on 3+", (k, k, k))
    y = lower.parameters * 2 - (1, 1, 2)
    u, v = upper.parameters[:, :2].T
    rim = np.flatnonzero((u == 0) | (u == 1) | (v == 0) | (v == 1))
    base = len(x) + np.flatnonzero(lower.parameters[:, 2] == 0)
    system = System([upper, lower], [x, y], [(5.0, 0.3), (1.0, 0.3)])
    faces = upper.faces[2, 0], lower.faces[2, 1]
    system.contact = Contact(faces, (-1, 1), 5, penalty, mu, 1 / 6, exact)
    system.prescribe(base, range(3), 0.0)

    def place(down, degrees):
        c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        turned = x[rim] @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
        system.prescribe(rim, range(3), turned - x[rim] - (0, 0, down * DEPTH))

    return system, place


def run(name, mu, mesh=1, degrees=180, exact=True, down=20):
    """Yield (degrees, P1, M1, P2, M2, t1, t2) at 0 and after every 3 degrees.

    P, M: force along z and torque about z on the hemisphere (1) and the block (2); t: the largest
    |t_x| of Table 5. exact: see HalfPass.
    """
    system, place = build(name, mesh, mu, exact)
    for _ in advance(system, lambda t: place(t, 0), down):
        pass

    def row(angle):
        sides = system.contact.sides
        (f1, m1), (f2, m2) = (side.resultant() for side in sides)
        return angle, f1[2], m1[2], f2[2], m2[2], sides[0].largest(0), sides[1].largest(0)

    system.contact.accept()  # all points stick at first, so each sliding point is the foot
    yield row(0.0)
    turn = advance(
        system, lambda t: place(1, t * degrees), round(degrees / 3), system.contact.accept
    )
    for t in turn:
        yield row(t * degrees)
