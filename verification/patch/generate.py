"""Write the patch test of an element: a distorted body, with the exact solution.

usage: generate.py ELEMENT

ELEMENT is the name of a row in a file src/elements/elmt_*.f90. For an element of ELEMents (its row
has `deck_nodes`), the body is a box of 2 x 2 x 2 cells filled with elements, whose inner nodes are
moved at random; all nodes of the boundary are given a linear displacement. For any other element,
the body is a PATCh with `TYPE ELEMENT` on the brick of ../distorted. The decks and expect.toml are
written to verification/patch/<element>/; run them by `verify.py --case <element>`.
"""

import argparse
import itertools
import pathlib
import re
import sys

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
YOUNG, POISSON = 1.0, 0.3
LINEAR = np.array(
    [[0.1, 0.15, -0.05], [0.05, -0.05, 0.1], [-0.1, 0.05, 0.2]]
)  # gradient of the displacement
STRETCH = np.diag([0.2, -0.1, 0.15])  # the gradient of ../distorted/test.inc

# The corners of an element in a cell whose corners are 0 to 7, counter-clockwise, lower plane
# first; 8 is its centre.
SIDES = [[0, 1, 2, 3], [7, 6, 5, 4], [0, 4, 5, 1], [1, 5, 6, 2], [2, 6, 7, 3], [3, 7, 4, 0]]
FILL = {
    4: [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]],
    5: [[*side, 8] for side in SIDES],
    6: [[0, 1, 2, 4, 5, 6], [0, 2, 3, 4, 6, 7]],
    8: [[0, 1, 2, 3, 4, 5, 6, 7]],
}
EDGES = {
    4: ["01", "12", "20", "03", "13", "23"],
    6: ["01", "12", "20", "34", "45", "53", "03", "14", "25"],
    8: ["01", "12", "23", "30", "45", "56", "67", "74", "04", "15", "26", "37"],
}
FACES = {8: ["0123", "4567", "0374", "1265", "0154", "3267", "01234567"]}
# By number of nodes: the number of corners, then for each further node, in the order of the deck,
# the corners of which it is the mean.
NODES = {
    4: (4, []),
    5: (5, []),
    6: (6, []),
    8: (8, []),
    10: (4, EDGES[4]),
    15: (6, EDGES[6]),
    20: (8, EDGES[8]),
    27: (8, EDGES[8] + FACES[8]),
}

DECK = """FEAP ** Patch test of {name}
  ndm = 3
! Problem: {problem}
! Units:   modulus 1.
! Answer:  the linear displacement of the boundary everywhere and a uniform stress.

PARAmeters
  m = 2                            ! 1: small strains, 2: finite

{mesh}
END

BATCh
  PROP,,1
  DT,,1/2
  LOOP,time,2
    TIME
    LOOP,newton,25
      TANG,,1
    NEXT,newton
  NEXT,time
  PLOT
END
                                   ! a blank record: the factor is the time

STOP
"""
MATERIALS = """MATErial 1                         ! small strains
  SOLId
    ELAStic ISOTropic 1.0 0.3
    SMALl{more}

MATErial 2                         ! finite strains
  SOLId
    ELAStic NEOHook 1.0 0.3
    FINIte VOLUme 3{more}
"""
PATCH = """PATCh,body
  FILE ../distorted/distorted.xml
  ELEMents 2 3 2
  TYPE {name}{degree}
  MATErial m

INCLude ../distorted/test.inc
"""
CHECK = """
[[check]]
name   = "{name}, {strains} strains: {field}"
deck   = "{deck}"
set    = {{ m = {m} }}
field  = "{field}"
{answer}
abs    = 1e-12
"""


def main(argv=None):
    """Write the folder of one element; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("element", help="name of a row of the table of elements")
    name = parser.parse_args(argv).element.upper()
    row = find_row(name)
    if row is None:
        sys.exit(f"generate.py: no file src/elements/elmt_*.f90 has a row with name='{name}'")
    count = int((re.search(r"deck_nodes=(\d+)", row) or [0, 0])[1])
    if count and count not in NODES:
        sys.exit(
            f"generate.py: the {count} nodes of {name} need a line in NODES that describes them"
        )
    if count:
        mesh, gradient = box(count, enhanced="nmode=" in row), LINEAR
        problem = "a box of 2 x 2 x 2 cells, whose inner nodes are moved at random."
    else:
        degree = " 2" if "spline=" in row else ""
        mesh, gradient = PATCH.format(name=name, degree=degree), STRETCH
        problem = "the distorted brick of ../distorted; its faces move along their normals."
    folder = HERE / name.lower()
    folder.mkdir(exist_ok=True)
    deck = name.lower() + ".inp"
    text = DECK.format(name=name, problem=problem, mesh=mesh)
    (folder / deck).write_text(text)
    (folder / "expect.toml").write_text(expectation(name, deck, gradient))
    print(f"{folder.relative_to(HERE.parent.parent)}/: {deck}, expect.toml")
    return 0


def find_row(name):
    """The text of a row's call of element_t, taken from the sources."""
    for path in sorted((HERE.parent.parent / "src/elements").glob("elmt_*.f90")):
        found = re.search(rf"element_t\(name='{name}'.*?form=form", path.read_text(), re.S)
        if found:
            return found[0]
    return None


def box(count, enhanced, n=2):
    """Records of the materials, nodes, elements and the displacement of the boundary."""
    rng = np.random.default_rng(count)
    ncorner, means = NODES[count]
    size = np.array([1.0, 1.2, 0.8])
    corners = []
    for k, j, i in itertools.product(range(n + 1), repeat=3):
        at = np.array([i, j, k])
        move = rng.uniform(-0.2, 0.2, 3) * (at > 0) * (at < n)  # nodes of the boundary stay on it
        corners.append(size * (at + move) / n)
    x, number, elements = [], {}, []

    def node(ids):
        """Number of the node at the mean of some corners."""
        if ids not in number:
            number[ids] = len(x) + 1
            x.append(np.mean([corners[a] for a in ids], axis=0))
        return number[ids]

    for k, j, i in itertools.product(range(n), repeat=3):
        low = i + (n + 1) * (j + (n + 1) * k)
        cell = [low, low + 1, low + n + 2, low + n + 1]
        cell += [a + (n + 1) ** 2 for a in cell]
        cell.append(len(corners))
        corners.append(
            np.mean([corners[a] for a in cell[:8]], axis=0) + rng.uniform(-0.02, 0.02, 3)
        )
        for local in FILL[ncorner]:
            c = [cell[a] for a in local]
            groups = [(a,) for a in c] + [tuple(sorted(c[int(a)] for a in m)) for m in means]
            elements.append([node(ids) for ids in groups])
    held = [a for a, p in enumerate(x, 1) if any(p < 1e-9) or any(p > size - 1e-9)]
    more = "\n    ENHAnced" if enhanced else ""
    lines = [MATERIALS.format(more=more), "COORdinates"]
    lines += [f"  {a} 0  {numbers(p)}" for a, p in enumerate(x, 1)]
    lines += ["", "ELEMents"]
    for e, nodes in enumerate(elements, 1):
        fields = [str(e), "0", "m", *map(str, nodes)]  # FEAP reads 16 numbers per record
        lines += ["  " + " ".join(fields[a : a + 16]) for a in range(0, len(fields), 16)]
    lines += ["", "BOUNdary", *(f"  {a} 0  1 1 1" for a in held)]
    lines += ["", "DISPlacements", *(f"  {a} 0  {numbers(LINEAR @ x[a - 1])}" for a in held), ""]
    return "\n".join(lines)


def expectation(name, deck, gradient):
    """expect.toml: displacement and stress of the homogeneous state."""
    text = f'title  = "Patch tests of {name}, written by generate.py"\n'
    text += 'source = "the homogeneous state, exactly"\n'
    affine = "affine = [" + ", ".join(f"[{numbers(line, ', ')}]" for line in gradient) + "]"
    for m, strains in ((1, "small"), (2, "finite")):
        s = stress(gradient, strains == "finite")
        want = f"want   = [{numbers([s[0, 0], s[1, 1], s[2, 2], s[0, 1], s[1, 2], s[2, 0]], ', ')}]"
        for field, answer in (("displacement", affine), ("stress", want)):
            text += CHECK.format(
                name=name, strains=strains, field=field, deck=deck, m=m, answer=answer
            )
    return text


def stress(gradient, finite):
    """Cauchy stress of ISOTropic, or of NEOHook with VOLUme 3."""
    mu = YOUNG / (2 * (1 + POISSON))
    lam = 2 * mu * POISSON / (1 - 2 * POISSON)
    one = np.eye(3)
    if not finite:
        strain = (gradient + gradient.T) / 2
        return lam * np.trace(strain) * one + 2 * mu * strain
    f = one + gradient
    jac = np.linalg.det(f)
    return (mu * (f @ f.T - one) + lam * np.log(jac) * one) / jac


def numbers(values, between=" "):
    """Real numbers with all their digits."""
    return between.join(repr(float(v)) for v in values)


if __name__ == "__main__":
    sys.exit(main())
