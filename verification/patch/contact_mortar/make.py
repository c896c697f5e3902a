"""Patch tests of mortar contact: uniform states of bodies whose meshes do not match.

    python -m verification.patch.contact_mortar.make [--bezel PROGRAM] [--keep DIR] [NAME ...]
    python -m verification.patch.contact_mortar.make --write

Each case presses one layer of bodies onto another and compares the result with the exact state,
which is uniform:

  flat     a flat common surface; pressure on top, a support that slides below. The blocks are free at
           their sides (uniaxial stress) or, where a layer consists of several bodies, guided there
           (uniaxial strain). Bodies of such layers partly cover some elements of the other layer.
  curved   a curved common surface that both bodies represent exactly; the same follower pressure on
           all other faces (hydrostatic stress). The penetration g = p/eps changes areas by the
           fraction g/R, where R is the radius of curvature.

It prints the largest relative errors of the forces on both sides, of the stress, and of the
smoothed pressure on both sides (at the worst point). The cases run are those whose name contains a
NAME, or all if no NAME is given. --write writes the decks and the expect.toml of this folder, for a
selection of the cases.
"""

import argparse
import math
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

from post._fields import read_fields
from post._table import read_table
from verification import TOP

MU, LAME = 0.5 / 1.3, 0.3 / (1.3 * 0.4)  # E = 1, nu = 0.3
# The maps of strongly distorted elements are not polynomials: exact results need more points.
FINE = "  QUADrature 12 12"
TYPES = {
    "q1": ["TYPE Q1"],
    "q1e9": ["TYPE Q1E9"],
    "q2": ["TYPE Q2"],
    "iga2": ["TYPE IGA 2"],
    "iga3": ["TYPE IGA 3"],
    "q1n2": ["TYPE Q1", "ENRIch {face} 2"],
    "q1n3": ["TYPE Q1", "ENRIch {face} 3"],
    "q1e9n2": ["TYPE Q1E9", "ENRIch {face} 2 EAS"],
    "q2n2": ["TYPE Q2", "ENRIch {face} 2"],
}


def root(function, low, high):
    """A zero of the function between two arguments, by bisection."""
    for _ in range(200):
        middle = 0.5 * (low + high)
        if (function(low) > 0) == (function(middle) > 0):
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def hydrostatic(p):
    """The stretch of a neo-Hookean body under the pressure p."""
    return root(lambda s: (MU * (s * s - 1) + 3 * LAME * math.log(s)) / s**3 + p, 0.5, 1.0)


def uniaxial(p):
    """The stretches across and along a bar under the axial pressure p."""

    def across(s):  # for the stretch s along the bar, from zero stress across it
        return root(lambda t: MU * (t * t - 1) + LAME * math.log(t * t * s), 0.5, 2.0)

    s = root(lambda s: MU * (s * s - 1) + LAME * math.log(across(s) ** 2 * s) + p * across(s) ** 2 * s, 0.5, 1.0)  # fmt: skip
    return across(s), s


def guided(p):
    """The stresses across and along a laterally guided bar under the axial pressure p."""
    s = root(lambda s: (MU * (s * s - 1) + LAME * math.log(s)) / s + p, 0.5, 1.0)
    return LAME * math.log(s) / s, -p


class Body:
    """A body between two surfaces, over a quadrilateral in the plane."""

    def __init__(self, name, kind, n, corners, low, high, warp=0.0, face="3+"):
        self.name, self.kind, self.n, self.face = name, kind, n, face
        self.corners, self.low, self.high, self.warp = np.array(corners, float), low, high, warp

    def area(self):
        x, y = self.corners.T
        return 0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1))

    def xml(self):
        """The block as a spline: biquadratic in the first two directions, with inner control points
        moved by `warp`, and linear in the third.
        """
        rows = []
        for k in (0, 1):
            plane = []
            for j in range(3):
                for i in range(3):
                    u, v = 0.5 * i, 0.5 * j
                    shape = [(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v]
                    at = np.array(shape) @ self.corners
                    along = self.corners[1] - self.corners[0]
                    across = self.corners[3] - self.corners[0]
                    if i == 1:
                        at = at + self.warp * (0.6 - 0.9 * v) * along
                    if j == 1:
                        at = at + self.warp * (1.1 * u - 0.4) * across
                    plane.append(at)
            surface = self.high if k else self.low
            z = surface if callable(surface) else lambda xy, h=surface: np.full(len(xy), float(h))
            rows += [
                [*at, h] for at, h in zip(np.array(plane), control_heights(np.array(plane), z))
            ]
        knots = ["0 0 0 1 1 1", "0 0 0 1 1 1", "0 0 1 1"]
        lines = [
            '<?xml version="1.0" encoding="UTF-8"?>',
            "<xml>",
            ' <Geometry type="TensorBSpline3" id="0">',
        ]
        lines.append('  <Basis type="TensorBSplineBasis3">')
        for d, knot in enumerate(knots):
            lines.append(f'   <Basis type="BSplineBasis" index="{d}">')
            lines.append(
                f'    <KnotVector degree="{len(knot.split()) // 2 - 1}">{knot}</KnotVector>'
            )
            lines.append("   </Basis>")
        lines += ["  </Basis>", '  <coefs geoDim="3">']
        lines += ["   " + " ".join(f"{c:.17g}" for c in row) for row in rows]
        lines += ["  </coefs>", " </Geometry>", "</xml>", ""]
        return "\n".join(lines)

    def records(self, stem):
        lines = [f"PATCh,{self.name}", f"  FILE {stem}_{self.name}.xml"]
        if self.face == "3-":
            lines.append("  TRANslate 0 0 -p/(2*eps)")
        lines.append("  ELEMents {} {} {}".format(*self.n))
        lines += ["  " + line.format(face=self.face) for line in TYPES[self.kind]]
        lines += ["  QUADrature qb qb"]
        return [*lines, "  MATErial 1", ""]


def control_heights(plane, z):
    """Bezier heights that interpolate z at the parameters 0, 1/2 and 1 of each direction."""
    b = np.array([[1, 0, 0], [0.25, 0.5, 0.25], [0, 0, 1]])
    inner = np.einsum(
        "ij,kl,jlc->ikc", b, b, plane.reshape(3, 3, 2)
    )  # positions at those parameters
    h = np.asarray(z(inner.reshape(9, 2))).reshape(3, 3)
    inv = np.linalg.inv(b)
    return (inv @ h @ inv.T).ravel()


class Case:
    """Lower and upper bodies, and their exact state."""

    def __init__(self, name, lower, upper, state, p=1e-3, eps=100.0, qb=4, rule="", shape=None):
        self.name, self.lower, self.upper, self.state = name, lower, upper, state
        self.p, self.eps, self.qb, self.rule = p, eps, qb, rule
        self.shape = shape

    def pairs(self):
        return [
            (a, b)
            for a in self.upper
            for b in self.lower
            if overlap_area(a.corners, b.corners) > 1e-9
        ]

    def deck(self, stem):
        lines = [
            f"FEAP ** Patch test of contact: {self.name}",
            "  ndm = 3",
            "! Written by make.py.",
            "",
        ]
        lines += [
            "PARAmeters",
            f"  p = {self.p!r}",
            f"  eps = {self.eps!r}",
            f"  qb = {self.qb}",
            "",
        ]
        lines += ["MATErial 1", "  SOLId", "    ELAStic NEOHook 1.0 0.3", "    FINIte VOLUme 3", ""]
        for body in self.lower + self.upper:
            lines += body.records(stem)
        for body in self.lower:
            lines.append(f"FIX,{body.name},3-  0 0 1")
        for body in self.lower + self.upper:
            if self.state == "guided":
                lines += [f"FIX,{body.name},{f}  1 1 0" for f in ("1-", "1+", "2-", "2+")]
            else:
                lines += [f"FIX,{body.name},1-,2-  1 1 0", f"FIX,{body.name},1+,2-  0 1 0"]
            if self.state == "hydrostatic":
                lines += [
                    f"PRESsure,{body.name},{f}  p  FOLLower" for f in ("1-", "1+", "2-", "2+")
                ]
        for body in self.upper:
            lines.append(f"PRESsure,{body.name},3+  p  FOLLower")
        lines.append("")
        for a, b in self.pairs():
            lines += [f"CONTact,{a.name}-{b.name}", f"  SURFaces {a.name} 3-  {b.name} 3+"]
            lines += ["  NORMal PENAlty eps", *([self.rule] if self.rule else []), ""]
        lines.append("CURVe,force")
        lines += [
            f"  CONTact {a.name}-{b.name} {k} FORCe 3" for a, b in self.pairs() for k in (1, 2)
        ]
        lines += [f"  FORCe {body.name} 3- 3" for body in self.lower]
        lines += [
            "",
            "END",
            "",
            "BATCh",
            "  TOL,,1e-26",
            "  LOOP,newton,30",
            "    UTAN,,1",
            "  NEXT,newton",
            "  PLOT",
            "END",
        ]
        return "\n".join([*lines, "", "STOP", ""])

    def write(self, folder, stem):
        for body in self.lower + self.upper:
            (folder / f"{stem}_{body.name}.xml").write_text(body.xml())
        (folder / f"{stem}.inp").write_text(self.deck(stem))

    def exact(self):
        """The stress, and the force per unit of reference area."""
        if self.state == "hydrostatic":
            return [-self.p, -self.p, -self.p, 0, 0, 0], self.p * hydrostatic(self.p) ** 2
        if self.state == "free":
            return [0, 0, -self.p, 0, 0, 0], self.p * uniaxial(self.p)[0] ** 2
        across, along = guided(self.p)
        return [across, across, along, 0, 0, 0], self.p

    def run(self, bezel, folder):
        self.write(folder, "case")
        done = subprocess.run([bezel, "--quiet", "-o", str(folder), str(folder / "case.inp")], capture_output=True, text=True)  # fmt: skip
        if done.returncode:
            return None, done.stderr.strip().splitlines()[:1]
        stress, unit = self.exact()
        table = read_table(folder / "case_force.dat")
        row = {c: table.columns[table.find(c)][-1] for c in table.quantities()}
        force = 0.0
        for a, b in self.pairs():
            want = unit * overlap_area(a.corners, b.corners)
            for k, sign in ((1, 1), (2, -1)):
                force = max(force, abs(row[f"contact_{a.name}-{b.name}_{k}_force_3"] / want - sign))
        fields = read_fields(folder / "case.vtkhdf")
        got = fields.arrays["stress"][1][-1]
        worst = np.abs(got - stress).max() / self.p
        pressure = np.abs(fields.arrays["contact_pressure"][1][-1]).ravel()
        pressure = pressure[pressure > 0.01 * self.p]
        return (force, worst, np.abs(pressure / self.p - 1).max()), int(row.get("iterations", 0))


def overlap_area(a, b):
    """Area of the intersection of two convex polygons."""
    poly = [np.array(p) for p in a]
    for k in range(len(b)):
        p, q = np.array(b[k]), np.array(b[(k + 1) % len(b)])
        side = [(q - p)[0] * (x - p)[1] - (q - p)[1] * (x - p)[0] for x in poly]
        new = []
        for i, x in enumerate(poly):
            j = (i + 1) % len(poly)
            if side[i] >= 0:
                new.append(x)
            if (side[i] >= 0) != (side[j] >= 0):
                new.append(x + side[i] / (side[i] - side[j]) * (poly[j] - x))
        poly = new
        if not poly:
            return 0.0
    x, y = np.array(poly).T
    return 0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1))


def square(x0, y0, x1, y1):
    return [[x0, y0], [x1, y0], [x1, y1], [x0, y1]]


def turned(degrees, half, middle):
    a = math.radians(degrees)
    turn = np.array([[math.cos(a), -math.sin(a)], [math.sin(a), math.cos(a)]])
    return np.array(square(-half, -half, half, half)) @ turn.T + middle


def flat_pair(low, high, n_low, n_high, warp_low=0.0, warp_high=0.0):
    c = square(0, 0, 1, 1)
    return [Body("a", low, n_low, c, -1, 0, warp_low)], [
        Body("b", high, n_high, c, 0, 1, warp_high, "3-")
    ]


def cases():
    """All cases."""
    out = []
    for low, high in [("q1", "q1"), ("q1e9", "iga2"), ("q2", "q2"), ("iga2", "iga2"), ("q1n2", "q1n2"),
                      ("q1n3", "q1n2"), ("q2", "q1n3"), ("q1e9n2", "q1"), ("q2n2", "iga3")]:  # fmt: skip
        for n, m in [((3, 3, 1), (3, 3, 1)), ((3, 2, 1), (4, 5, 1)), ((1, 1, 1), (10, 10, 1)), ((10, 10, 1), (1, 1, 1))]:  # fmt: skip
            a, b = flat_pair(low, high, n, m)
            out.append(Case(f"flat-{low}-{high}-{n[0]}x{n[1]}-{m[0]}x{m[1]}", a, b, "free"))
    for kind in ("q1", "q1e9", "q2", "iga2", "q1n2", "q1n3"):
        for warp in (0.1, 0.2, 0.3):
            a, b = flat_pair(kind, kind, (3, 3, 1), (4, 5, 1), warp, -warp)
            out.append(Case(f"distorted{warp}-{kind}", a, b, "free", qb=6, rule=FINE))
        a, b = flat_pair(kind, kind, (2, 2, 1), (10, 10, 1), 0.2, -0.1)
        out.append(Case(f"distorted-1:5-{kind}", a, b, "free", qb=6))
    for kind in ("q1", "q1e9", "q2", "iga2", "q1n2", "q1n3"):
        low = [Body("a1", kind, (3, 4, 1), square(0, 0, 0.9, 2), -1, 0), Body("a2", kind, (3, 3, 1), square(0.9, 0, 2, 2), -1, 0)]  # fmt: skip
        up = [Body("b1", kind, (4, 3, 1), square(0, 0, 1.3, 1.15), 0, 1, 0, "3-"), Body("b2", kind, (2, 3, 1), square(1.3, 0, 2, 1.15), 0, 1, 0, "3-"),
              Body("b3", kind, (5, 2, 1), square(0, 1.15, 2, 2), 0, 1, 0, "3-")]  # fmt: skip
        out.append(Case(f"tiles-{kind}", low, up, "guided"))
        outer, inner = np.array(square(0, 0, 2, 2)), turned(20, 0.5, [1.03, 0.96])
        low = [Body("a", kind, (5, 5, 1), outer, -1, 0)]
        up = [Body("b0", kind, (3, 3, 1), inner, 0, 1, 0, "3-")]
        for i in range(4):
            j = (i + 1) % 4
            up.append(
                Body(
                    f"b{i + 1}",
                    kind,
                    (4, 2, 1),
                    [outer[i], outer[j], inner[j], inner[i]],
                    0,
                    1,
                    0,
                    "3-",
                )
            )
        out.append(Case(f"turned-{kind}", low, up, "guided", qb=6, rule=FINE))
    surfaces = {
        "cylinder": lambda x: 0.1 * (x[:, 0] - 0.4) ** 2,
        "saddle": lambda x: 0.15 * (x[:, 0] - 0.4) * (x[:, 1] - 0.6),
        "bowl": lambda x: 0.1 * (x[:, 0] - 0.4) ** 2 + 0.08 * (x[:, 1] - 0.5) ** 2,
        "steep": lambda x: 0.5 * (x[:, 0] - 0.4) ** 2 + 0.4 * (x[:, 1] - 0.5) ** 2,
    }
    for shape, f in surfaces.items():
        for kind in ("q2", "iga2", "q1n2", "q1n3"):
            for n, m in [((1, 1, 1), (1, 1, 1)), ((3, 2, 1), (4, 5, 1)), ((1, 1, 1), (10, 10, 1))]:
                c = square(0, 0, 1, 1)
                a, b = Body("a", kind, n, c, -1, f), Body("b", kind, m, c, f, 1.5, 0, "3-")
                out.append(Case(f"curved-{shape}-{kind}-{n[0]}x{n[1]}-{m[0]}x{m[1]}", [a], [b], "hydrostatic", p=0.1, eps=1e7, qb=6))  # fmt: skip
    return out


CHOICE = ["flat-q1e9-iga2-3x2-4x5", "flat-q2-q1n3-10x10-1x1", "distorted0.3-q1", "distorted0.3-iga2",
          "distorted-1:5-q1n2", "tiles-q1n3", "turned-q1e9", "turned-q2", "curved-bowl-iga2-3x2-4x5",
          "curved-saddle-q2-3x2-4x5", "curved-cylinder-q1n3-3x2-4x5"]  # fmt: skip


def write_choice():
    """Write the decks of this folder and their expect.toml."""
    here = pathlib.Path(__file__).resolve().parent
    lines = [
        "# Written by make.py.",
        'title  = "Patch tests of contact: bodies whose meshes do not match"',
    ]
    lines += ['source = "uniform states of neo-Hooke in closed form"', ""]
    for case in (c for c in cases() if c.name in CHOICE):
        stem = case.name.replace(":", "").replace(".", "").replace("-", "_")
        case.write(here, stem)
        stress, unit = case.exact()
        lines += [
            "[[check]]",
            f'name  = "{case.name}: stress"',
            f'deck  = "{stem}.inp"',
            'field = "stress"',
        ]
        lines += [f"want  = {[float(c) for c in stress]}", f"abs   = {1e-8 * case.p:.0e}", ""]
        for a, b in case.pairs():
            for k, sign in ((1, 1), (2, -1)):
                lines += [
                    "[[check]]",
                    f'name   = "{case.name}: force of {a.name} and {b.name}, side {k}"',
                ]
                lines += [
                    f'deck   = "{stem}.inp"',
                    'curve  = "force"',
                    f'column = "contact_{a.name}-{b.name}_{k}_force_3"',
                ]
                lines += [
                    f"want   = {float(sign * unit * overlap_area(a.corners, b.corners))!r}",
                    "rel    = 1e-8",
                    "",
                ]
    (here / "expect.toml").write_text("\n".join(lines), encoding="utf-8")


def command(description, cases, write, argv):
    """Run the cases that the arguments name and print their errors, or write a selection of them.

    A case has a `name`, a `rule` (a further record of CONTact) and `run(bezel, folder)`, which
    returns its relative errors, or None and the reason for the failure.
    """
    o = argparse.ArgumentParser(description=description.splitlines()[0])
    o.add_argument("--bezel", default=str(TOP / "build/release/bezel"))
    o.add_argument("--keep", help="folder for the decks and results")
    o.add_argument("--rule", default="", help="a further record of CONTact, such as QUADrature 8 8")
    o.add_argument("--write", action="store_true", help="write the decks of this folder")
    o.add_argument("name", nargs="*")
    o = o.parse_args(argv)
    if o.write:
        write()
        return 0
    print(f"{'case':44} {'force':>9} {'stress':>9} {'pressure':>9}")
    for case in cases:
        if o.name and not any(name in case.name for name in o.name):
            continue
        if o.rule:
            case.rule = "  " + o.rule
        with tempfile.TemporaryDirectory() as place:
            folder = pathlib.Path(o.keep or place) / (case.name if o.keep else "")
            folder.mkdir(parents=True, exist_ok=True)
            errors, why = case.run(o.bezel, folder)
        if errors is None:
            print(f"{case.name:44} failed: {why}", flush=True)
        else:
            mark = "" if max(errors) < 1e-8 else "  *"
            print(f"{case.name:44} " + " ".join(f"{e:9.1e}" for e in errors) + mark, flush=True)
    return 0


def main(argv=None):
    return command(__doc__, cases(), write_choice, argv)


if __name__ == "__main__":
    sys.exit(main())
