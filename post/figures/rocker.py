"""`make demo-rocker` makes a body from a net of quads, solves a contact problem with it, and draws
Figures 5 to 7 of Corbett and Sauer 2015 for this body instead of theirs.

python -m post.figures.rocker --bezel build/release/bezel --out build/rocker

It meshes the body of input/rocker_arm.py, presses a rigid pin onto its arm and slides the pin along
it with friction.
"""

import argparse
import pathlib
import shutil
import subprocess
import sys
import time

import numpy as np

from post import _style, contact_map, field
from post._error import Unreadable
from post._screen import prepare
from post._table import read_table
from post.figures.demo import run
from post.mesh import _draw, _draw_junction, _report, _tets, _write, body_of
from post.mesh._surface import Surface

TOP = pathlib.Path(__file__).resolve().parents[2]
RADIUS, HALF = 0.8, 0.6  # radius and half length of the pin
ARM = "box:-9,-9,-9,-1.2,9,9"  # the part that the pin may touch, which remains a spline
NEAR = (
    2.1,
    0.0,
    0.3,
)  # the T-junction that the third picture shows is the one nearest to this point


def pin():
    """The lower half of a cylinder about the z axis, represented exactly by two rational
    elements.
    """
    h = np.sqrt(0.5)
    arc = RADIUS * np.array([[-1.0, 0], [-1, -1], [0, -1], [1, -1], [1, 0]])
    points = [(x, y, z) for z in (-HALF, HALF) for x, y in arc]
    weights = np.tile([1, h, 1, h, 1], 2)
    nodes = [np.array([0, 1, 2, 5, 6, 7]), np.array([2, 3, 4, 7, 8, 9])]
    corners = np.array([[0, 1, 2, 3], [1, 4, 5, 2]])
    return Surface((2, 1), np.array(points), weights, nodes, [np.eye(6)] * 2, corners)


def make_body(out, mesher, refine):
    """Write the files that input/rocker.inp names; returns (Body, report)."""
    net = out / "rocker_arm.obj"
    subprocess.run([sys.executable, str(TOP / "input/rocker_arm.py"), str(net)], check=True)
    body = body_of(str(net), refine=refine, enrich=ARM, mesher=mesher)
    _write.write(body, out / "rocker")
    shutil.copy(
        TOP / "input/rocker.inp", out / "rocker.inp"
    )  # in place of the deck that the mesher writes
    (out / "pin.bext.json").write_text(_write.bext_text(pin()))
    report = _report.describe(body)
    _report.write(report, out / "rocker.mesh.json")
    return body, report


def draw_mesh(out, mesher):
    """Draw Figures 5 to 7: the surface, four panels of the cut body, and a T-junction."""
    body = body_of(str(out / "rocker_arm.obj"), mesher=mesher)
    _draw.draw(body, out / "figure")
    split = body_of(str(out / "rocker_arm.obj"), mesher=mesher, split="box:1.2,-1,0,3.0,1,1",
                    junction="peak")  # fmt: skip
    _draw_junction.draw(split, out / "figure_junction.png", near=NEAR)


def solve(bezel, out):
    """Run the deck in its folder; return the wall-clock time [s]."""
    start = time.perf_counter()
    run(bezel, out, out / "rocker.inp")
    return time.perf_counter() - start


def draw_run(out):
    """Draw the final stress in the arm, the tractions on its surface, and the forces."""
    result = out / "rocker.vtkhdf"
    # The rigid pin, the last body, would hide the arm.
    field.draw([result] * 2, out / "rocker_stress.png", scalar="mises", view="60,50", bodies=[1, 2], outline=False,
               step=[("time", 1.0), ("time", 2.0)], labels=["the pin pressed down", "the pin at its end"],
               say_step=False)  # fmt: skip
    steps = {1.05: "just sliding", 1.5: "halfway", 2.0: "at the end"}
    for name in ("pressure", "friction"):
        contact_map.draw([result] * len(steps), out / f"rocker_{name}.png", scalar=f"contact_{name}", axis="y",
                         step=[("time", t) for t in steps], labels=list(steps.values()), say_step=False, columns=3,
                         turn=True)  # fmt: skip
    table = read_table(out / "rocker_pin.dat").columns
    with _style.styled() as plt:
        figure, ax = plt.subplots(figsize=(4.6, 3.0))
        columns = {"contact_pad_2_force_2": "normal", "contact_pad_2_force_1": "tangential"}
        for i, (column, label) in enumerate(columns.items()):
            line = _style.series(i) | {"marker": None}
            ax.plot(table["time"], abs(table[column]), label=label, **line)
        ax.set(
            xlabel="time (pressed until 1, then slid along)",
            ylabel="force on the arm",
            ylim=(0, None),
        )
        ax.legend()
        _style.save(figure, out / "rocker_force.png")


def main(argv=None):
    p = argparse.ArgumentParser(prog="demo-rocker", description="From a net to a solved contact.")
    p.add_argument("--bezel", type=pathlib.Path, default=TOP / "build/release/bezel")
    p.add_argument("--out", type=pathlib.Path, default=TOP / "build/rocker", metavar="DIR")
    p.add_argument(
        "--refine", type=int, default=0, metavar="N", help="number of Catmull-Clark steps"
    )
    o = p.parse_args(argv)
    try:
        prepare()
        o.out.mkdir(parents=True, exist_ok=True)
        mesher = next((m for m in ("gmsh", "tetgen") if _tets.available(m)), "gmsh")
        _, report = make_body(o.out, mesher, o.refine)
        print(_report.text(report))
        draw_mesh(o.out, mesher)
        print(f"solved in {solve(o.bezel, o.out):.1f} s")
        draw_run(o.out)
    except (Unreadable, OSError) as error:
        print(f"demo-rocker: error: {error}", file=sys.stderr)
        return 1
    print(f"the deck, the files and the pictures are in {o.out}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
