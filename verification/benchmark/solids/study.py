"""Tables of doc/verification/solids.md: elements of mesh files, tested in bending.

    python3 -m verification.benchmark.solids.study [--bezel build/release/bezel] [--out build/solids] [--write]

Cook's panel and a slender cantilever have n cells over the height; each cell is filled with
hexahedra, wedges, tetrahedra or pyramids. `--write` puts the tables into the page. `--small` writes
the meshes and decks of expect.toml into this folder.
"""

import argparse
import pathlib
import sys

import numpy as np

from post._table import read_table
from verification import TOP, checks
from verification.page import put_table
from verification.patch.mesh_files import make

HERE = TOP / "verification/benchmark/solids"
PAGE = TOP / "doc/verification/solids.md"
#: element: the type of cell filling, as make.py names it
FILL = {
    "TET4": "tetrahedra", "WEDGE6": "wedges", "PYRAMID5 and TET4": "pyramids", "Q1": "hexahedra",
    "Q1E9": "hexahedra", "TET10": "tetrahedra",
}  # fmt: skip
EDGES = [(0, 1), (1, 2), (2, 0), (0, 3), (2, 3), (1, 3)]  # edges of TET10, in Gmsh's order
TET10 = 11
LENGTH = 10  # ratio of the length to the height of the beam
SMALL = [
    ("cook", 4, ("TET4", "WEDGE6", "PYRAMID5 and TET4", "TET10")),
    ("beam", 2, ("TET4", "Q1E9", "TET10")),
]

COOK = """FEAP ** Cook's panel of {element}, n = {n}
! Problem: as in ../cook. m = 1: small strains, nu = 1/4, f = 1; m = 2: neo-Hooke, nu = 0.4999, f = 100 in s steps.
! Answer:  m = 1: the middle of the right edge rises by 23.96; m = 2: the upper right corner by 6.91.
  ndm = 3

PARAmeters
  m = 1
  f = 1
  s = 1

MATErial 1
  SOLId
    ELAStic ISOTropic 15/16 0.25
    SMALl

MATErial 2
  SOLId
    ELAStic NEOHook 80.1938*2*1.4999 0.4999
    FINIte VOLUme 3

MESH,body FILE {stem}.msh
{type}  MATErial m

FIX,PLANe 1 0 1 1 0
FIX,PLANe 3 0 0 0 1
FIX,PLANe 3 1 0 0 1

FORCe                              ! the consistent forces of a constant traction
{force}

CURVe,tip
  DISP POINt 48 52 0 2
  DISP POINt 48 60 0 2

END
"""
BEAM = """FEAP ** Cantilever of {element}, n = {n}
! Problem: length 10, section 1 x 1, one end clamped; a force of 1 is spread over the other end. E = 1000.
! Answer:  the end moves by f L^3/(3 E I) + f L/(k G A), k = 10 (1 + nu)/(12 + 11 nu) (Cowper 1966).
  ndm = 3

PARAmeters
  nu = 0.3
  f = 1
  s = 1

MATErial 1
  SOLId
    ELAStic ISOTropic 1000 nu
    SMALl

MESH,body FILE {stem}.msh
{type}  MATErial 1

FIX,PLANe 1 0 1 1 1

FORCe
{force}

CURVe,tip
  DISP PLANe 1 10 2

END
"""
RUN = """
BATCh
  PROP
  DT,,1/s
  LOOP,steps,s
    TIME
    LOOP,newton,25
      TANG,,1
    NEXT,newton
  NEXT,steps
END
                                   ! a blank record: the factor is the time

STOP
"""


def nodes_and_cells(problem, n):
    """Nodes of the grid, the number of node (i, j, k), and the numbers of cells per direction."""
    count = np.array([n, n, 1] if problem == "cook" else [5 * n, n, n])
    x, number = make.grid(count, np.zeros(3), np.ones(3), 0.0, np.random.default_rng(0))
    x = np.array(x)
    if problem == "beam":
        return list(x * [LENGTH, 1, 1]), number, count
    height = 44 + x[:, 0] * (16 - 44)
    return list(np.array([48 * x[:, 0], 44 * x[:, 0] + height * x[:, 1], x[:, 2]]).T), number, count


def build(problem, element, n):
    """Nodes, elements (Gmsh type, nodes), and the fraction of the end force at each node."""
    x, number, count = nodes_and_cells(problem, n)
    elements = make.cells(count, x, number, [FILL[element]] * count[2])
    end = max(p[0] for p in x)
    faces = [f for f in make.boundary(elements) if all(x[a][0] > end - 1e-9 for a in f)]
    share = {}
    total = sum(area(x, f) for f in faces)
    middles = {}

    def middle(a, b):
        key = (min(a, b), max(a, b))
        if key not in middles:
            middles[key] = len(x)
            x.append((x[a] + x[b]) / 2)
        return middles[key]

    if element == "TET10":
        elements = [(TET10, c + [middle(c[a], c[b]) for a, b in EDGES]) for _, c in elements]
    for (
        f
    ) in faces:  # the nodes share the force equally; of a quadratic triangle, the midside nodes do
        own = [middle(f[i], f[i - 1]) for i in range(3)] if element == "TET10" else f
        for a in own:
            share[a] = share.get(a, 0.0) + area(x, f) / total / len(own)
    return x, elements, share


def area(x, face):
    """The area of a plane triangle or parallelogram."""
    a, b, c = (x[face[i]] for i in (0, 1, 2))
    return np.linalg.norm(np.cross(b - a, c - a)) * (1 if len(face) == 4 else 0.5)


def write(folder, problem, element, n):
    """Write the mesh and the deck; return the deck and the number of nodes."""
    x, elements, share = build(problem, element, n)
    stem = f"{problem}_{element.split()[0].lower()}" + ("" if folder == HERE else f"_{n}")
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$Nodes", str(len(x))]
    lines += [f"{i} {p[0]:.12g} {p[1]:.12g} {p[2]:.12g}" for i, p in enumerate(x, 1)]
    lines += ["$EndNodes", "$Elements", str(len(elements))]
    for e, (kind, c) in enumerate(elements, 1):
        lines.append(f"{e} {kind} 0 " + " ".join(str(a + 1) for a in c))
    make.save(folder / f"{stem}.msh", [*lines, "$EndElements"])
    force = "\n".join(f"  {a + 1} 0  0 f*{w:.12g} 0" for a, w in sorted(share.items()))
    text = (COOK if problem == "cook" else BEAM) + RUN
    kind = "  TYPE Q1E9\n" if element == "Q1E9" else ""
    deck = folder / f"{stem}.inp"
    deck.write_text(text.format(element=element, n=n, stem=stem, type=kind, force=force))
    return deck, len(x)


def solve(o, problem, element, n, column, **settings):
    """(tip displacement, dofs)."""
    o.out.mkdir(parents=True, exist_ok=True)
    deck, nodes = write(o.out, problem, element, n)
    run = checks.new_run(o.out, {"deck": deck.name, "set": settings, "time_limit": 3600})
    outcome = checks.execute(o.bezel.resolve(), o.out / "runs", run)
    if outcome.code != 0:
        sys.exit(f"study: error: {run.name} ended with code {outcome.code}: {outcome.reason}")
    tip = read_table(o.out / "runs" / run.name / f"{deck.stem}_tip.dat").columns[column][-1]
    print(f"{problem}, {element}, n = {n}, {settings}: {tip:.6g}", flush=True)
    return tip, 3 * nodes


def timoshenko(nu, e=1000, force=1, length=LENGTH):
    """Tip displacement of a cantilever of section 1 x 1.

    >>> round(timoshenko(0.3), 5)
    4.03059
    """
    k = 10 * (1 + nu) / (12 + 11 * nu)
    return force * length**3 / (3 * e / 12) + force * length * 2 * (1 + nu) / (k * e)


def tables(o):
    """{name of a table of the page: its lines}"""
    found = {"cook": table((4, 8, 16), lambda *at: cook_small(o, *at))}
    found["locked"] = table((4, 8, 16), lambda *at: cook_finite(o, *at))
    for name, nu in (("beam", 0.3), ("beam_locked", 0.4999)):
        found[name] = table((1, 2, 4, 8), lambda *at, nu=nu: beam(o, nu, *at))
    return found


def cook_small(o, element, n):
    tip, dofs = solve(o, "cook", element, n, "disp_2")
    return f"{tip:.2f} ({dofs})"


def cook_finite(o, element, n):
    return f"{solve(o, 'cook', element, n, 'disp_2_2', m=2, f=100, s=20)[0]:.2f}"


def beam(o, nu, element, n):
    tip, dofs = solve(o, "beam", element, n, "disp_2", nu=nu)
    return f"{tip / timoshenko(nu):.3f} ({dofs})"


def table(meshes, value):
    """One row per element, one column per mesh."""
    lines = [
        "| element | " + " | ".join(f"n = {n}" for n in meshes) + " |",
        "|---" * (len(meshes) + 1) + "|",
    ]
    return lines + [f"| {e} | " + " | ".join(value(e, n) for n in meshes) + " |" for e in FILL]


def main():
    p = argparse.ArgumentParser(
        prog="python -m verification.benchmark.solids.study", description=__doc__.splitlines()[0]
    )
    p.add_argument("--bezel", type=pathlib.Path, default=TOP / "build/release/bezel")
    p.add_argument("--out", type=pathlib.Path, default=TOP / "build/solids")
    p.add_argument("--write", action="store_true", help="put the tables into the page")
    p.add_argument(
        "--small", action="store_true", help="write the files of expect.toml, run nothing"
    )
    o = p.parse_args()
    if o.small:
        for problem, n, elements in SMALL:
            for element in elements:
                write(HERE, problem, element, n)
        return
    text = PAGE.read_text()
    for name, lines in tables(o).items():
        print(f"\n{name}", *lines, sep="\n")
        text = put_table(text, name, "\n".join(lines))
    if o.write:
        PAGE.write_text(text)


if __name__ == "__main__":
    main()
