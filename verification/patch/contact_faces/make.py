"""Patch tests of mortar contact on every type of face, with bodies from mesh files.

    python -m verification.patch.contact_faces.make [--bezel PROGRAM] [--keep DIR] [NAME ...]
    python -m verification.patch.contact_faces.make --write

A block of one element type stands on a block of another. The inner nodes of both blocks are moved
at random. On the common face z = 0 triangles are arbitrary, but quadrilaterals are rectangles of
different sizes, except in cases named `distorted`, where they are arbitrary too; since their maps
are then not polynomials, more integration points are used. Two states are exact:

  pressed  a pressure on top, a support that slides below, free sides (uniaxial stress)
  sheared  all nodes of both blocks, except those inside the common face, follow a homogeneous
           deformation with shear in two steps, at small strains; the upper block is also shifted
           by the penetration p/eps and by the elastic slip t/eps of sticking friction. Both blocks
           have a margin, so that the inner part of their faces always remains covered

It prints the largest relative errors of the normal forces on both sides, of the stress, and of the
smoothed pressure on both sides (at the worst point). The cases run are those whose name contains a
NAME, or all if no NAME is given. --write writes the decks, the meshes and the expect.toml of this
folder, for a selection of the cases.
"""

import itertools
import pathlib
import subprocess
import sys

import numpy as np

from post._fields import read_fields
from post._table import read_table
from verification.patch.contact_mortar.make import LAME, MU, command, uniaxial
from verification.patch.mesh_files.make import FACES, SIDES, save

EPS = 100.0
A = np.array([[0.02, 0.03, 0.06], [-0.01, -0.01, 0.04], [0.0, 0.0, -0.05]])  # displacement gradient
# Gmsh's types: corners, and the midpoints of edges as pairs of corners, in Gmsh's order.
EDGES = {2: [(0, 1), (1, 2), (2, 0)], 4: [(0, 1), (1, 2), (2, 0), (0, 3), (2, 3), (1, 3)]}
QUADRATIC = {2: 9, 4: 11}
# Elements that fill a cell whose lower plane has the corners 0 to 3, counter-clockwise.
FILL = {
    "hexahedra": [(5, [0, 1, 2, 3, 4, 5, 6, 7])],
    "wedges": [(6, [0, 1, 2, 4, 5, 6]), (6, [0, 2, 3, 4, 6, 7])],  # with triangles below and above
    "wedges-flat": [(6, [0, 1, 5, 3, 2, 6]), (6, [0, 5, 4, 3, 6, 7])],  # with quadrilaterals there
    "pyramids": [(7, [*side, 8]) for side in SIDES],
    # Three pyramids around corner 6: triangles at 1+, 2+ and above; every other cell is a mirror
    # image.
    "pyramids-apex": [(7, [0, 1, 2, 3, 6]), (7, [0, 4, 5, 1, 6]), (7, [0, 3, 7, 4, 6])],
    "tet4": [(4, [0, *pair, 6]) for pair in ([1, 2], [2, 3], [3, 7], [7, 4], [4, 5], [5, 1])],
}
FILL["tet10"] = FILL["tet4"]
FILL["hanging"] = FILL["hexahedra"]
QUADS = {"hexahedra", "wedges-flat", "pyramids", "hanging"}  # quadrilaterals on the common face
FINE = "  QUADrature 12 12"
AMOUNT = 0.22  # largest displacement of a node, relative to the smaller cell beside it


class Block:
    """A block below or above z = 0, over the unit square and a margin around it, with its mesh."""

    def __init__(self, name, kind, n, upper, seed, margin=0.0, distorted=False):
        self.name, self.kind, self.upper, self.margin = name, kind, upper, margin
        self.straight = kind in QUADS and not distorted  # then grid lines remain straight
        rng = np.random.default_rng(seed)
        self.x, self.elements, self.hanging = [], [], []
        lines = [np.linspace(0, 1, m + 1) for m in n]
        if kind == "hanging" and n[0] == 1:
            lines[0] = np.array([0, 0.5, 1])
        lines[2] = lines[2] - (not upper)
        for x in lines[:2] if self.straight else []:
            inner = np.minimum(x[1:-1] - x[:-2], x[2:] - x[1:-1])
            x[1:-1] += rng.uniform(-AMOUNT, AMOUNT, len(x) - 2) * inner
        if margin > 0:
            lines[:2] = [np.concatenate([[-margin], x, [1 + margin]]) for x in lines[:2]]
        if kind == "hanging":
            self._two_grids(lines, rng)
        else:
            self._grid(lines, rng)
        self._orient()
        if kind == "tet10":
            self._quadratic()
        self.x = np.array(self.x)

    def _grid(self, lines, rng):
        """Fill the cells between the coordinates in `lines`; return the number of each node."""
        corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]  # fmt: skip
        n = [len(x) - 1 for x in lines]
        number = {}
        for k, j, i in itertools.product(*(range(m + 1) for m in n[::-1])):
            at = [x[a] for x, a in zip(lines, (i, j, k))]
            for d, a in enumerate((i, j, k)):
                move = rng.uniform(-AMOUNT, AMOUNT)
                border = min(abs(at[d]), abs(at[d] - 1)) < 1e-12
                if 0 < a < n[d] and not border and not (self.straight and d < 2):
                    at[d] += move * min(np.diff(lines[d])[a - 1 : a + 1])
            number[i, j, k] = len(self.x)
            self.x.append(at)
        for k, j, i in itertools.product(*(range(m) for m in n[::-1])):
            corner = [number[i + a, j + b, k + c] for a, b, c in corners]
            if self.kind == "pyramids":
                self.x.append(list(np.mean([self.x[a] for a in corner], axis=0)))
                corner.append(len(self.x) - 1)
            if self.kind == "pyramids-apex":  # with the apex, above or below, on the common face
                mirror = [i % 2, j % 2, k % 2 if not self.upper else 1 - k % 2]
                if not self.upper:
                    mirror[2] = (n[2] - 1 - k) % 2
                where = dict(zip(corners, corner))
                corner = [where[tuple(abs(p - q) for p, q in zip(c, mirror))] for c in corners]
            self.elements += [(g, [corner[a] for a in c]) for g, c in FILL[self.kind]]
        return number

    def _two_grids(self, lines, rng):
        """A coarse grid beside one that is twice as fine; on their common plane, the nodes that
        only the fine grid has are hanging nodes.
        """
        middle = len(lines[0]) // 2
        coarse = self._grid([lines[0][: middle + 1], *lines[1:]], rng)
        n = [middle, len(lines[1]) - 1, len(lines[2]) - 1]
        halves = [np.sort(np.concatenate([x, (x[1:] + x[:-1]) / 2])) for x in lines[1:]]
        rest = lines[0][middle:]
        a = self._grid([rest, *halves], rng)
        new = {}
        for j, k in itertools.product(range(2 * n[1] + 1), range(2 * n[2] + 1)):
            if j % 2 == 0 and k % 2 == 0:
                new[a[0, j, k]] = coarse[n[0], j // 2, k // 2]
                continue
            ends = itertools.product({j - j % 2, j + j % 2}, {k - k % 2, k + k % 2})
            masters = [coarse[n[0], p // 2, q // 2] for p, q in ends]
            self.hanging.append((a[0, j, k], [(m, 1 / len(masters)) for m in masters]))
            self.x[a[0, j, k]] = list(np.mean([self.x[m] for m in masters], axis=0))
        self.elements = [(g, [new.get(c, c) for c in e]) for g, e in self.elements]
        used = sorted({c for _, e in self.elements for c in e})
        number = {c: i for i, c in enumerate(used)}
        self.x = [self.x[c] for c in used]
        self.elements = [(g, [number[c] for c in e]) for g, e in self.elements]
        self.hanging = [(number[s], [(number[m], w) for m, w in ms]) for s, ms in self.hanging]

    def _orient(self):
        """Reverse the elements that are mirror images."""
        for e, (g, c) in enumerate(self.elements):
            x = np.array([self.x[a] for a in c])
            ends = {4: (1, 2, 3), 5: (1, 3, 4), 6: (1, 2, 3), 7: (1, 3, 4)}[g]
            if np.linalg.det(x[list(ends)] - x[0]) < 0:
                order = {4: [0, 2, 1, 3], 5: [0, 3, 2, 1, 4, 7, 6, 5], 6: [0, 2, 1, 3, 5, 4], 7: [0, 3, 2, 1, 4]}[g]  # fmt: skip
                self.elements[e] = (g, [c[a] for a in order])

    def _quadratic(self):
        middles = {}

        def middle(a, b):
            if (min(a, b), max(a, b)) not in middles:
                middles[min(a, b), max(a, b)] = len(self.x)
                self.x.append([(p + q) / 2 for p, q in zip(self.x[a], self.x[b])])
            return middles[min(a, b), max(a, b)]

        self.corners = list(self.elements)
        self.middle = middle
        self.elements = [(11, c + [middle(c[a], c[b]) for a, b in EDGES[4]]) for _, c in self.elements]  # fmt: skip

    def faces(self):
        """Faces at the bottom and at the top, each as (Gmsh's type, group, nodes)."""
        seen = {}
        for g, c in self.corners if self.kind == "tet10" else self.elements:
            for ids in FACES[g]:
                face = [c[a] for a in ids]
                seen.setdefault(tuple(sorted(face)), []).append(face)
        rows = []
        for face in (f[0] for f in seen.values() if len(f) == 1):
            for group, height in ((1, 0.0), (2, 1.0)):
                if all(abs(self.x[a][2] - (height - (not self.upper))) < 1e-12 for a in face):
                    g = len(face) - 1
                    if self.kind == "tet10":
                        g, face = 9, face + [self.middle(face[a], face[b]) for a, b in EDGES[2]]
                    rows.append((g, group, face))
        return rows

    def edges(self):
        """Nodes on the vertical edges at x = 0 and at x = 1 of the side y = 0."""
        near = np.abs(self.x[:, 1]) < 1e-12
        return [np.flatnonzero(near & (np.abs(self.x[:, 0] - x) < 1e-12)) for x in (0, 1)]

    def held(self):
        """Nodes of the boundary that are not inside the common face."""
        x = self.x
        side = ((x[:, :2] < 1e-12) | (x[:, :2] > 1 - 1e-12)).any(1)  # or in the margin
        far = x[:, 2] > 1 - 1e-12 if self.upper else x[:, 2] < -1 + 1e-12
        slaves = [s for s, _ in self.hanging]
        return [a for a in np.flatnonzero(side | far) if a not in slaves]

    def write(self, folder, stem):
        names = ["bottom", "top", "edge0", "edge1"]
        lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", "4"]
        lines += [f'{2 if i < 3 else 0} {i} "{name}"' for i, name in enumerate(names, 1)]
        lines += ["$EndPhysicalNames", "$Nodes", str(len(self.x))]
        lines += [f"{i} {p[0]!r} {p[1]!r} {p[2]!r}" for i, p in enumerate(self.x.tolist(), 1)]
        rows = [(15, 3 + i, [a]) for i, edge in enumerate(self.edges()) for a in edge]
        rows += self.faces() + [(g, 0, c) for g, c in self.elements]
        lines += ["$EndNodes", "$Elements", str(len(rows))]
        for e, (g, tag, c) in enumerate(rows, 1):
            lines.append(f"{e} {g} 2 {tag} {tag} " + " ".join(str(a + 1) for a in c))
        save(folder / f"{stem}_{self.name}.msh", [*lines, "$EndElements"])
        if self.hanging:
            lines = ["# slave, number of masters, masters and coefficients"]
            for s, masters in self.hanging:
                pairs = " ".join(f"{m + 1} {w!r}" for m, w in masters)
                lines.append(f"{s + 1} {len(masters)} {pairs}")
            save(folder / f"{stem}_{self.name}.txt", lines)

    def records(self, stem):
        lines = [f"MESH,{self.name} FILE {stem}_{self.name}.msh"]
        if self.hanging:
            lines.append(f"  CONStraint {stem}_{self.name}.txt")
        return [*lines, "  MATErial 1", ""]


def linear_stress():
    """The stress caused by the displacement gradient A."""
    return MU * (A + A.T) + LAME * np.trace(A) * np.eye(3)


def voigt(s):
    return [float(s[i, j]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))]


class Case:
    """A lower and an upper block in a state that the contact must reproduce exactly."""

    def __init__(self, low, high, n, m, state, p=1e-3, distorted=False):
        self.name = f"{state}-{low}-{n[0]}x{n[1]}-{high}-{m[0]}x{m[1]}"
        self.name += "-distorted" * distorted
        self.rule = FINE if distorted else ""
        margin = [0.2, 0.1] if state == "sheared" else [0.0, 0.0]
        self.a = Block("a", low, n, False, 1, margin[0], distorted)
        self.b = Block("b", high, m, True, 2, margin[1], distorted)
        self.state, self.p = state, p

    def deck(self, stem):
        lines = [f"FEAP ** Patch test of contact: {self.name}", "  ndm = 3", "! Written by make.py.", ""]  # fmt: skip
        law = ["NEOHook 1.0 0.3", "FINIte VOLUme 3"]
        if self.state == "sheared":
            law = ["ISOTropic 1.0 0.3", "SMALl"]
        lines += ["MATErial 1", "  SOLId", f"    ELAStic {law[0]}", f"    {law[1]}", ""]
        lines += self.a.records(stem) + self.b.records(stem)
        if self.state == "pressed":
            for body in "ab":
                lines += [f"FIX,{body},edge0  1 1 0", f"FIX,{body},edge1  0 1 0"]
            lines += ["FIX,a,bottom  0 0 1", f"PRESsure,b,top  {self.p!r}  FOLLower", ""]
        lines += ["CONTact,joint", "  SURFaces b bottom  a top"]
        lines += [f"  NORMal PENAlty {EPS!r}"]
        lines += [f"  FRICtion COULomb 2 PENAlty {EPS!r}"] if self.state == "sheared" else []
        lines += [*([self.rule] if self.rule else []), ""]
        if self.state == "sheared":
            lines.append(f"INCLude {stem}.inc")
        lines += ["CURVe,force"]
        lines += [f"  CONTact joint {k} FORCe 3" for k in (1, 2)]
        if self.state == "pressed":
            lines += [f"  CONTact joint {k} PRESsure" for k in (1, 2)]
        lines += ["", "END", "", "BATCh"]
        steps = ["  DT,,0.5", "  LOOP,time,2", "    TIME"] if self.state == "sheared" else []
        lines += ["  PROP,,1", *steps] if steps else []
        lines += ["  TOL,,1e-26", "  LOOP,newton,30", "    UTAN,,1", "  NEXT,newton"]
        lines += ["  NEXT,time"] if steps else []
        lines += ["  PLOT", "END"]
        return "\n".join([*lines, *([""] if steps else []), "", "STOP", ""])

    def shift(self):
        """The displacement of the upper block: penetration, and elastic slip."""
        return linear_stress()[:, 2] / EPS

    def write(self, folder, stem):
        self.a.write(folder, stem)
        self.b.write(folder, stem)
        (folder / f"{stem}.inp").write_text(self.deck(stem))
        if self.state != "sheared":
            return
        held = [(a, A @ self.a.x[a]) for a in self.a.held()]
        held += [(len(self.a.x) + a, A @ self.b.x[a] + self.shift()) for a in self.b.held()]  # fmt: skip
        lines = ["BOUNdary", *(f"  {a + 1} 0  1 1 1" for a, _ in held), "", "DISPlacements"]
        lines += [f"  {a + 1} 0  {u[0]!r} {u[1]!r} {u[2]!r}" for a, w in held for u in [w.tolist()]]
        save(folder / f"{stem}.inc", [*lines, ""])

    def exact(self):
        """Stress (6), and the normal force on the upper block."""
        if self.state == "pressed":
            return [0, 0, -self.p, 0, 0, 0], self.p * uniaxial(self.p)[0] ** 2
        s = linear_stress()
        return voigt(s), float(-s[2, 2] * (1 + 2 * self.b.margin) ** 2)

    def run(self, bezel, folder):
        self.write(folder, "case")
        done = subprocess.run([bezel, "--quiet", "-o", str(folder), str(folder / "case.inp")], capture_output=True, text=True)  # fmt: skip
        if done.returncode or done.stderr.strip():
            return None, done.stderr.strip().splitlines()[:3]
        stress, want = self.exact()
        table = read_table(folder / "case_force.dat")
        row = {c: table.columns[table.find(c)][-1] for c in table.quantities()}
        force = 0.0
        for k, sign in ((1, 1), (2, -1)):
            force = max(force, abs(sign * row[f"contact_joint_{k}_force_3"] / want - 1))
        fields = read_fields(folder / "case.vtkhdf")
        arrays = fields.arrays
        worst = np.abs(arrays["stress"][1][-1] - stress).max() / abs(stress[2])
        pressure = np.abs(arrays["contact_pressure"][1][-1]).ravel()
        x = fields.points
        inside = ((x[:, :2] > 1e-12) & (x[:, :2] < 1 - 1e-12)).all(1) | (self.state == "pressed")
        pressure = pressure[(np.abs(x[:, 2]) < 1e-12) & inside]
        true = (
            self.p if self.state == "pressed" else -stress[2] / np.linalg.det(np.eye(2) + A[:2, :2])
        )
        return (force, worst, np.abs(pressure / true - 1).max()), 0


def cases():
    """All cases."""
    out = []
    pairs = [("tet4", "hexahedra"), ("tet4", "tet4"), ("tet10", "hexahedra"), ("tet10", "tet10"), ("tet10", "tet4"),
             ("wedges", "hexahedra"), ("wedges", "wedges"), ("wedges-flat", "hexahedra"), ("wedges-flat", "wedges"),
             ("pyramids", "hexahedra"), ("pyramids", "pyramids"), ("pyramids-apex", "hexahedra"),
             ("pyramids-apex", "pyramids-apex"), ("pyramids-apex", "wedges-flat"), ("pyramids", "tet4"), ("wedges", "tet10"),
             ("hexahedra", "hexahedra"), ("hanging", "hexahedra"), ("hanging", "hanging"), ("hanging", "tet10")]  # fmt: skip
    for state in ("pressed", "sheared"):
        for low, high in pairs:
            for n, m in [
                ((3, 2, 2), (4, 5, 1)),
                ((1, 1, 1), (10, 10, 1)),
                ((10, 10, 1), (1, 1, 1)),
            ]:
                out.append(Case(low, high, n, m, state))
            if QUADS & {low, high}:
                out.append(Case(low, high, (3, 2, 2), (4, 5, 1), state, distorted=True))
    return out


CHOICE = ["pressed-tet4-1x1-hexahedra-10x10", "pressed-tet10-3x2-tet10-4x5", "pressed-wedges-3x2-wedges-4x5",
          "pressed-wedges-flat-3x2-wedges-4x5", "pressed-pyramids-3x2-tet4-4x5", "pressed-pyramids-3x2-hexahedra-4x5",
          "pressed-pyramids-apex-3x2-hexahedra-4x5", "pressed-hanging-3x2-hanging-4x5", "pressed-hanging-3x2-tet10-4x5-distorted",
          "sheared-tet4-3x2-tet4-4x5", "sheared-tet10-3x2-hexahedra-4x5", "sheared-wedges-3x2-hexahedra-4x5",
          "sheared-wedges-flat-3x2-wedges-4x5", "sheared-pyramids-apex-3x2-pyramids-apex-4x5",
          "sheared-pyramids-3x2-tet4-4x5", "sheared-hanging-3x2-hexahedra-4x5"]  # fmt: skip


def write_choice():
    """Write the decks of this folder and their expect.toml."""
    here = pathlib.Path(__file__).resolve().parent
    lines = ["# Written by make.py.", 'title  = "Patch tests of contact on every type of face"']
    lines += ['source = "uniform states of neo-Hooke and of Hooke in closed form"', ""]
    for case in (c for c in cases() if c.name in CHOICE):
        stem = case.name.replace("-", "_")
        case.write(here, stem)
        stress, force = case.exact()
        lines += ["[[check]]", f'name  = "{case.name}: stress"', f'deck  = "{stem}.inp"']
        lines += ['field = "stress"', f"want  = {[float(c) for c in stress]}"]
        lines += [f"abs   = {1e-8 * abs(stress[2]):.1e}", ""]
        wants = [(f"force, side {k}", f"contact_joint_{k}_force_3", sign * force) for k, sign in ((1, 1), (2, -1))]  # fmt: skip
        if case.state == "pressed":  # the largest pressure, per current area
            wants += [(f"pressure, side {k}", f"contact_joint_{k}_pressure", case.p) for k in (1, 2)]  # fmt: skip
        for what, column, want in wants:
            lines += ["[[check]]", f'name   = "{case.name}: {what}"', f'deck   = "{stem}.inp"']
            lines += ['curve  = "force"', f'column = "{column}"', f"want   = {float(want)!r}"]
            lines += ["rel    = 1e-8", ""]
    (here / "expect.toml").write_text("\n".join(lines), encoding="utf-8")


def main(argv=None):
    return command(__doc__, cases(), write_choice, argv)


if __name__ == "__main__":
    sys.exit(main())
