"""The cube of cube.inp with CalculiX: write its input and read its results.

The neo-Hooke law of CalculiX is W = C10 (I1 J^(-2/3) - 3) + (J - 1)^2/D1. With C10 = mu/2 and D1 =
2/K it is the same material at small strains; at 25 % compression the force differs by some per
cent. Elements are C3D8 with eight integration points. Debian's CalculiX solves with SPOOLES.
"""

import re

E, NU = 1.0, 0.2
STEPS = 5
LIFT = -0.25


def write_input(path, n):
    """Write the mesh, the material, the supports and one step of five increments."""
    row, layer = n + 1, (n + 1) ** 2

    def node(i, j, k):
        return 1 + i + row * j + layer * k

    def plane(name, nodes):
        return [f"*NSET,NSET={name}", *(f"{a}," for a in nodes)]

    edge, height = range(row), range(2 * n + 1)
    text = ["*NODE"]
    for k in height:
        for j in edge:
            text += [
                f"{node(i, j, k)},{0.5 * i / n:.15g},{0.5 * j / n:.15g},{k / (2 * n):.15g}"
                for i in edge
            ]
    text.append("*ELEMENT,TYPE=C3D8,ELSET=CUBE")
    number = 0
    for k in height[:-1]:
        for j in edge[:-1]:
            for i in edge[:-1]:
                number += 1
                base = [node(i, j, k), node(i + 1, j, k), node(i + 1, j + 1, k), node(i, j + 1, k)]
                text.append(",".join(map(str, [number, *base, *(a + layer for a in base)])))
    text += plane("SIDEX", (node(0, j, k) for k in height for j in edge))
    text += plane("SIDEY", (node(i, 0, k) for k in height for i in edge))
    text += plane("BASE", (node(i, j, 0) for j in edge for i in edge))
    text += plane("TOP", (node(i, j, 2 * n) for j in edge for i in edge))
    mu, bulk = E / 2 / (1 + NU), E / 3 / (1 - 2 * NU)
    text += ["*MATERIAL,NAME=RUBBER", "*HYPERELASTIC,NEO HOOKE", f"{mu / 2:.16g},{2 / bulk:.16g}"]
    text += ["*SOLID SECTION,ELSET=CUBE,MATERIAL=RUBBER"]
    text += ["*BOUNDARY", "SIDEX,1,1", "SIDEY,2,2", "BASE,1,3", "TOP,1,2"]
    text += ["*STEP,NLGEOM,INC=5", "*STATIC,DIRECT,SOLVER=SPOOLES", f"{1 / STEPS:.15g},1.0"]
    text += ["*CONTROLS,PARAMETERS=FIELD", "1e-8,1e-6", "*BOUNDARY", f"TOP,3,3,{LIFT}"]
    text += ["*NODE PRINT,NSET=TOP,TOTALS=ONLY", "RF", "*END STEP"]
    path.write_text("\n".join(text) + "\n")


def read_output(folder, output):
    """{"force": force on the top, "iterations": their number, "version": CalculiX's version}."""
    forces = re.findall(r"total force.*?\n\s*\n(.*)\n", (folder / "cube.dat").read_text())
    rows = [line.split() for line in (folder / "cube.sta").read_text().splitlines()[2:]]
    version = re.search(r"CalculiX\s+Version\s+([\d.]+)", output)
    return {
        "force": float(forces[-1].split()[-1]),
        "iterations": sum(int(row[3]) for row in rows if len(row) > 3),
        "version": f"CalculiX {version[1] if version else ''}".strip(),
    }
