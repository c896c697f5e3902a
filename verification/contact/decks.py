"""Write the decks that differ only in elements and meshes, and the reference for the dragged block.

    python -m verification.contact.decks

sphere, cylinder: each folder gets one deck for each element type and mesh. On the curved body, mesh
n has n elements of equal width over 1.3 contact radii, then 2 n elements whose width increases
towards the edge of the body, which is 500 radii away. The elements of the block are wider by a
tenth, so the two meshes match nowhere.
mindlin: the same, for the whole width of the cylinder.
rings: two rings under an outer pressure, and two rings of which the inner one is too wide by 1e-5.
drag: reference.csv, the forces and the work of a spring in series with a slider.
"""

import numpy as np

from verification import TOP

FOLDER = TOP / "verification/contact"
TYPES = {
    "q1": ("Q1", ["TYPE Q1"]),
    "q1n2": ("Q1N2", ["TYPE Q1", "ENRIch {face} 2"]),
    "q2": ("Q2", ["TYPE Q2"]),
    "iga2": ("IGA2", ["TYPE IGA 2"]),
}
#: number of elements over 1.3 contact radii
MESHES = {
    "sphere": {"q1": (2, 4, 6), "q1n2": (2, 4, 6), "q2": (2, 3, 4), "iga2": (2, 4, 6)},
    "cylinder": {kind: (3, 6, 12) for kind in TYPES},
}
MINDLIN = {"q1n2": (4, 8, 16), "q2": (4, 8)}
FAR = 500.0  # half width of the bodies, relative to the contact radius


def knots(fine, count, outer):
    """Interior knots: `count` equal elements up to `fine`, then `outer` elements of increasing
    width up to 1.
    """
    inside = [fine * (i + 1) / count for i in range(count)]
    return inside + [fine ** (1 - (i + 1) / outer) for i in range(outer - 1)]


def record(direction, values):
    return f"  KNOTs,{direction} " + " ".join(f"{v:.6g}" for v in values)


def patch(name, geometry, face, kind, along, depth, flat, material):
    """The records of a PATCh, refined in its third direction towards the face in contact."""
    across = depth if face == "3-" else [1 - v for v in reversed(depth)]
    lines = [f"PATCh,{name}", f"  {geometry}", record(1, along)]
    lines += [f"  ELEMents {len(along) + 1} 1 {len(depth) + 1}"] if flat else [record(2, along)]
    lines += [record(3, across)]
    lines += ["  " + text.format(face=face) for text in TYPES[kind][1]]
    return [*lines, f"  MATErial {material}", ""]


def deck(shape, kind, mesh):
    flat = shape == "cylinder"
    label = TYPES[kind][0]
    depth = knots(0.5 / FAR, (mesh + 1) // 2, 3 * mesh // 2)
    lines = [
        f"FEAP ** Hertz: a {shape} pressed on a block, {label}, mesh {mesh}",
        "  ndm = 3",
        "! Written by verification/contact/decks.py; head.inc states the problem and its answer.",
        "",
        "INCLude head.inc",
        "",
    ]
    lines += patch("cap", "NPATch 1", "3-", kind, knots(1.3 / FAR, mesh, 2 * mesh), depth, flat, 1)  # fmt: skip
    box = "BOX 0 0 -reach  reach thick reach" if flat else "BOX 0 0 -reach  reach reach reach"
    lines += patch("block", box, "3+", kind, knots(1.43 / FAR, mesh, 2 * mesh), depth, flat, 2)
    return "\n".join([*lines, "INCLude scene.inc", ""])


def rings(kind, fit):
    """Two rings; with `fit` the inner one is too wide, otherwise a pressure acts on the outer one
    from outside.
    """
    label, lines = TYPES[kind]
    what = "a press fit" if fit else "an outer pressure"
    text = [
        f"FEAP ** Concentric rings, {what}, {label}",
        "  ndm = 3",
        "! Problem: " + ("the inner ring is too wide by 1e-5; a quarter of both rings." if fit
                         else "the pressure p acts on the outer ring from outside; a quarter of both rings."),
        "! Written by verification/contact/decks.py.",
        "INCLude head.inc",
        "",
    ]  # fmt: skip
    for name, file, face, n, material in (
        ("inner", "wide" if fit else "inner", "1+", "2*m 4*m 1", 1),
        ("outer", "outer", "1-", "2*m 3*m 1", 2),
    ):
        text += [f"PATCh,{name}", f"  FILE {file}.xml", f"  ELEMents {n}"]
        text += ["  " + line.format(face=face) for line in lines]
        text += [f"  MATErial {material}", ""]
    text += [] if fit else ["PRESsure,outer,1+  p", ""]
    return "\n".join([*text, "INCLude scene.inc", ""])


def full_knots(fine, count, outer):
    """Interior knots of a body from one edge to the other, fine in its middle."""
    right = knots(fine, count, outer)
    return [0.5 * (1 - v) for v in reversed(right)] + [0.5] + [0.5 * (1 + v) for v in right]


def mindlin(kind, mesh):
    """A cylinder that is pressed onto a block and pulled sideways; the mesh is fine at both edges
    of the contact area.
    """
    depth = knots(0.5 / FAR, mesh // 2, 3 * mesh // 2)
    text = [
        f"FEAP ** Cattaneo and Mindlin: a cylinder pressed and pulled, {TYPES[kind][0]}, mesh {mesh}",
        "  ndm = 3",
        "! Written by verification/contact/decks.py; head.inc states the problem and its answer.",
        "",
        "INCLude head.inc",
        "",
    ]
    cap, block = (full_knots(1.3 * f / FAR, mesh, mesh) for f in (1.0, 1.1))
    box = "BOX -reach 0 -reach  2*reach thick reach"
    text += patch("cap", "NPATch 1", "3-", kind, cap, depth, True, 1)
    text += patch("block", box, "3+", kind, block, depth, True, 1)
    return "\n".join([*text, "INCLude scene.inc", ""])


def spring_and_slider(mu=0.3, steps=112):
    """Rows (time, force on the block's top, energy of friction) of the dragged block, n = 3.

    The contact is a spring eps A with a slider of mu N in series with the block's shear stiffness.
    The energy is the sum of the work of the slider and the energy stored in the spring.
    """
    limit, eps, block = mu * 0.1, 300.0, 0.4 / 0.5
    k = 1 / (1 / eps + 1 / block)
    rows, force, work, before = [(1.0, 0.0, 0.0)], 0.0, 0.0, 0.0
    for i in range(1, steps + 1):
        t = 1 + i / 16
        u = float(np.interp(t, [1, 2, 4, 6, 8], [0, 0.16, -0.16, 0.16, 0.16]))
        trial = force + k * (u - before)
        now = min(limit, max(-limit, trial))
        work += abs(now * (trial - now) / k)
        rows.append((t, now, work + 0.5 * now**2 / eps))
        force, before = now, u
    return rows


def main():
    for shape in ("sphere", "cylinder"):
        for kind in TYPES:
            for mesh in MESHES[shape][kind]:
                path = FOLDER / shape / f"{kind}_{mesh}.inp"
                path.write_text(deck(shape, kind, mesh), encoding="utf-8")
    for kind in TYPES:
        for fit, name in ((False, "pressed"), (True, "fit")):
            path = FOLDER / "rings" / f"{name}_{kind}.inp"
            path.write_text(rings(kind, fit), encoding="utf-8")
    for kind, meshes in MINDLIN.items():
        for mesh in meshes:
            path = FOLDER / "mindlin" / f"{kind}_{mesh}.inp"
            path.write_text(mindlin(kind, mesh), encoding="utf-8")
    lines = ["# spring and slider in closed form, written by verification/contact/decks.py"]
    lines += ["time,force_1,contact_sole_1_force_1,contact_sole_1_force_3,book_friction"]
    lines += [f"{t!r},{f!r},{-f!r},0.1,{w!r}" for t, f, w in spring_and_slider()]
    (FOLDER / "drag/reference.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
