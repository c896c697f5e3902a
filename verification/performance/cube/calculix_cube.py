"""The quarter cube of section 4 as a CalculiX deck: calculix_cube.py N U STEPS > cube.inp.

Neo-Hooke with CalculiX's volumetric energy (J-1)^2/D1: another law of the same moduli, so forces differ and costs do not.
"""

import itertools
import sys


def deck(n, lift, steps):
    """Text of the deck: C3D8 elements, `steps` increments of equal size."""
    mu = 1.0 / (2.0 * 1.2)
    bulk = 1.0 / (3.0 * (1.0 - 2.0 * 0.2))
    m = n + 1
    number = lambda i, j, k: 1 + i + m * (j + m * k)  # noqa: E731
    out = ["*NODE, NSET=all"]
    sets = {"x": [], "y": [], "base": [], "top": []}
    for k, j, i in itertools.product(range(2 * n + 1), range(m), range(m)):
        out.append(f"{number(i, j, k)}, {0.5 * i / n}, {0.5 * j / n}, {0.5 * k / n}")
        for name, on in (("x", i == 0), ("y", j == 0), ("base", k == 0), ("top", k == 2 * n)):
            if on:
                sets[name].append(number(i, j, k))
    out.append("*ELEMENT, TYPE=C3D8, ELSET=cube")
    cells = itertools.product(range(2 * n), range(n), range(n))
    corners = [
        (0, 0, 0),
        (1, 0, 0),
        (1, 1, 0),
        (0, 1, 0),
        (0, 0, 1),
        (1, 0, 1),
        (1, 1, 1),
        (0, 1, 1),
    ]
    for e, (k, j, i) in enumerate(cells, 1):
        out.append(f"{e}, " + ", ".join(str(number(i + a, j + b, k + c)) for a, b, c in corners))
    for name, nodes in sets.items():
        out += [f"*NSET, NSET={name}", *(f"{node}," for node in nodes)]
    out += ["*MATERIAL, NAME=rubber", "*HYPERELASTIC, NEO HOOKE", f"{mu / 2}, {2 / bulk}"]
    out += [
        "*SOLID SECTION, ELSET=cube, MATERIAL=rubber",
        "*BOUNDARY",
        "x, 1, 1",
        "y, 2, 2",
        "base, 1, 3",
        "top, 1, 2",
    ]
    out += [
        "*STEP, NLGEOM",
        "*STATIC, DIRECT",
        f"{1 / steps}, 1.0",
        "*BOUNDARY",
        f"top, 3, 3, {lift}",
    ]
    out += ["*NODE PRINT, NSET=top, TOTALS=ONLY, FREQUENCY=1000", "RF", "*END STEP"]
    return "\n".join(out) + "\n"


if __name__ == "__main__":
    sys.stdout.write(deck(int(sys.argv[1]), float(sys.argv[2]), int(sys.argv[3])))
