"""The hemisphere that is pressed on a block and twisted (section 5 of Corbett and Sauer 2015), with
CalculiX: write its input and read its results.

The nodes are those of bezel's Q1 mesh. Elements are C3D8 with eight integration points. Contact is
of the type surface to surface, with the hemisphere as the slave, a linear pressure-overclosure
relation and the stick slope eps. Increments are 1/20 of the downward motion, then 3 degrees, or as
given. The rim is turned by means of amplitudes, two per node. The neo-Hooke law is that of calculix_cube.py,
with (J - 1)^2 instead of the (ln J)^2 of bezel.
"""

import math
import re

DOWN, TURN = 20, 60  # usual numbers of increments
DEGREES = 180.0
SLIDING = 120.0  # angle [degrees] beyond which all points slide
HEMI, BLOCK = 5.0, 1.0  # Young's moduli of the hemisphere and of the block
NU = 0.3
INNER = 2 / 3  # radius of the inner surface


def outer_point(u, v):
    """Point of the lower unit hemisphere for (u, v), by an elliptical map to the disc and one to
    the sphere.
    """
    x, y = 2 * u - 1, 2 * v - 1
    a, b = x * math.sqrt(1 - y * y / 2), y * math.sqrt(1 - x * x / 2)
    r = math.hypot(a, b)
    scale = math.sin(math.pi / 2 * r) / r if r > 0 else 0.0
    return a * scale, b * scale, -math.cos(math.pi / 2 * r)


class Mesh:
    """Nodes (x, y, z) and hexahedra of a lattice of nx x ny x nz elements, whose numbers begin
    with first_node and first_element.
    """

    def __init__(self, size, first_node, first_element, place):
        self.size, self.first_node, self.first_element = size, first_node, first_element
        nx, ny, nz = size
        self.nodes = {
            self.node(i, j, k): place(i, j, k)
            for k in range(nz + 1)
            for j in range(ny + 1)
            for i in range(nx + 1)
        }
        self.elements = [
            [self.node(i + p, j + q, k + r) for r in (0, 1) for p, q in ((0, 0), (1, 0), (1, 1), (0, 1))]
            for k in range(nz)
            for j in range(ny)
            for i in range(nx)
        ]  # fmt: skip

    def node(self, i, j, k):
        nx, ny, _ = self.size
        return self.first_node + i + (nx + 1) * (j + (ny + 1) * k)

    def layer(self, k):
        """Numbers of the elements of a layer."""
        per = self.size[0] * self.size[1]
        return [self.first_element + per * k + i for i in range(per)]


def meshes(n, m, k):
    """The hemisphere (whose layer 0 is the inner one) and the block."""

    def shell(i, j, layer):
        radius = INNER + (1 - INNER) * layer / m
        x, y, z = outer_point(
            i / n, 1 - j / n
        )  # mirrored, so that the third direction points outward and the elements are right-handed
        return radius * x, radius * y, 1 + radius * z

    def box(i, j, layer):
        return 2 * i / k - 1, 2 * j / k - 1, 2 * layer / k - 2

    hemi = Mesh((n, n, m), 1, 1, shell)
    block = Mesh((k, k, k), len(hemi.nodes) + 1, n * n * m + 1, box)
    return hemi, block


def material(name, young):
    mu, bulk = young / 2 / (1 + NU), young / 3 / (1 - 2 * NU)
    return [
        f"*MATERIAL,NAME={name}",
        "*HYPERELASTIC,NEO HOOKE",
        f"{mu / 2:.16g},{2 / bulk:.16g}",
        f"*SOLID SECTION,ELSET={name},MATERIAL={name}",
    ]


def contact(eps, mu, swapped):
    text = ["*SURFACE,TYPE=ELEMENT,NAME=SLAVE", "HTOP,S2", "*SURFACE,TYPE=ELEMENT,NAME=MASTER"]
    text += ["BTOP,S2", "*SURFACE INTERACTION,NAME=SOLE"]
    text += ["*SURFACE BEHAVIOR,PRESSURE-OVERCLOSURE=LINEAR", f"{eps:.16g}"]
    if mu > 0:
        text += ["*FRICTION", f"{mu:.16g},{eps:.16g}"]
    return text + [
        "*CONTACT PAIR,INTERACTION=SOLE,TYPE=SURFACE TO SURFACE",
        "MASTER,SLAVE" if swapped else "SLAVE,MASTER",
    ]


def write_input(path, mesh, mu, swapped=False, turns=TURN):
    """Write the mesh (n, m, k, eps), a step that moves down and a step that turns in the given
    number of increments; swapped: the block is the slave.
    """
    n, m, k = (mesh[name] for name in "nmk")
    hemi, block = meshes(n, m, k)
    text = []
    for body, name, top in ((hemi, "HEMI", "HTOP"), (block, "BLOCK", "BTOP")):
        text += ["*NODE"]
        text += [f"{a},{x:.15g},{y:.15g},{z:.15g}" for a, (x, y, z) in body.nodes.items()]
        text.append(f"*ELEMENT,TYPE=C3D8,ELSET={name}")
        text += [
            ",".join(map(str, [body.first_element + e, *nodes]))
            for e, nodes in enumerate(body.elements)
        ]
        text += [f"*ELSET,ELSET={top}", *(f"{e}," for e in body.layer(body.size[2] - 1))]
    rim = [
        hemi.node(i, j, layer)
        for layer in range(m + 1)
        for j in range(n + 1)
        for i in range(n + 1)
        if i in (0, n) or j in (0, n)
    ]
    base = [block.node(i, j, 0) for j in range(k + 1) for i in range(k + 1)]
    text += ["*NSET,NSET=RIM", *(f"{a}," for a in rim), "*NSET,NSET=BASE", *(f"{a}," for a in base)]
    text += material("HEMI", HEMI) + material("BLOCK", BLOCK) + contact(mesh["eps"], mu, swapped)
    turn, moves = rotation(hemi, rim, turns)
    text += turn + ["*BOUNDARY", "BASE,1,3"]
    text += step(DOWN, ["*BOUNDARY", "RIM,1,2", "RIM,3,3,-1."])
    text += step(turns, ["*BOUNDARY", "RIM,3,3,-1.", *moves])
    path.write_text("\n".join(text) + "\n")
    return {"rim": rim, "base": base, "nodes": hemi.nodes | block.nodes}


def rotation(hemi, rim, turns):
    """Amplitudes of the displacements of the rim nodes, and the records that apply them."""
    amplitudes, moves = [], []
    angles = [math.radians(DEGREES) * i / turns for i in range(turns + 1)]
    for a in rim:
        x, y, _ = hemi.nodes[a]
        for d in (1, 2):
            pairs = []
            for i, t in enumerate(angles):
                c, s = math.cos(t) - 1, math.sin(t)
                pairs.append(f"{i / turns:.10g},{x * c - y * s if d == 1 else y * c + x * s:.15g}")
            amplitudes.append(f"*AMPLITUDE,NAME=A{a}D{d}")
            amplitudes += [",".join(pairs[i : i + 4]) for i in range(0, len(pairs), 4)]
            moves += [f"*BOUNDARY,AMPLITUDE=A{a}D{d}", f"{a},{d},{d},1."]
    return amplitudes, moves


def step(increments, records):
    size = 1 / increments
    text = ["*STEP,NLGEOM,INC=10000", "*STATIC,SOLVER=SPOOLES"]
    text += [f"{size:.15g},1.,{1e-4 * size:.6g},{size:.15g}", *records]
    for name in ("RIM", "BASE"):
        text += [f"*NODE PRINT,NSET={name}", "U,RF"]
    return [*text, "*END STEP"]


def read_output(folder, output, mesh):
    """Iterations, final angle, and mean forces and torques of rim and base while all points
    slide.
    """
    tables = read_tables(folder / "hemisphere.dat")
    rows = [line.split() for line in (folder / "hemisphere.sta").read_text().splitlines()[2:]]
    rows = [row for row in rows if len(row) > 6]
    tries = (folder / "hemisphere.cvg").read_text()
    iterations = len(re.findall(r"^\s*\d+\s+\d+\s+\d+\s+\d+\s", tries, re.M))
    version = re.search(r"CalculiX\s+Version\s+([\d.]+)", output)
    found = {
        "version": f"CalculiX {version[1] if version else ''}".strip(),
        "iterations": iterations,
        "steps": len(rows),
        "degrees": DEGREES * max(0.0, float(rows[-1][4]) - 1) if rows else 0.0,
    }
    late = [t for t in sorted(tables) if DEGREES * (t - 1) >= SLIDING - 1e-6]
    for where in ("rim", "base"):
        sums = [resultant(tables[t][where], mesh["nodes"]) for t in late]
        for i, what in enumerate(("force", "torque")):
            found[f"{what}_{where}"] = sum(s[i] for s in sums) / len(sums) if sums else None
    return found


def read_tables(path):
    """{time: {"rim" or "base": {node: [displacements, forces]}}} from the .dat file."""
    tables, rows = {}, None
    for line in path.read_text().splitlines():
        if head := re.search(
            r"(displacements|forces).* for set (\w+) and time\s+([\dE.+-]+)", line
        ):
            rows = tables.setdefault(round(float(head[3]), 7), {}).setdefault(head[2].lower(), {})
        elif rows is not None and line.strip():
            number, *values = line.split()
            rows.setdefault(int(number), []).append([float(v) for v in values])
    return tables


def resultant(rows, nodes):
    """Force along z and torque about the axis, at the current positions."""
    force = torque = 0.0
    for a, (u, f) in rows.items():
        force += f[2]
        torque += (nodes[a][0] + u[0]) * f[1] - (nodes[a][1] + u[1]) * f[0]
    return force, torque
