"""Make the tables of doc/verification/section3.md: meshes below surfaces, and their use in runs.

    .venv/bin/python -m verification.section3 mesh [--net FILE --name NAME]
    .venv/bin/python -m verification.section3 bend [--net FILE]
    .venv/bin/python -m verification.section3 slide
    .venv/bin/python -m verification.section3 hertz [--largest N]
    .venv/bin/python -m verification.section3 check

`mesh` meshes the bodies of VARIANTS below the net of input/rocker_arm.py or another net, and writes
verification/section3/mesh_NAME.csv. `bend` takes the hexahedra of a curved bar, or of a rocker arm
from a file, solves the bending of the body with tetrahedra and with those hexahedra, and writes
verification/section3/bend.csv. `slide` runs the deck of `make demo-rocker` with the spline on the
arm and with plain faces of the same net, and writes verification/section3/slide.csv and a figure;
it reuses runs in the work folder. `hertz` presses spheres of input/sphere_net.py between planes and
writes verification/section3/hertz.csv. `check`, a part of `make verify-all`, repeats those of the
runs above that are quick, and tries broken files.
"""

import argparse
import json
import pathlib
import re
import subprocess
import sys

import numpy as np

from post import _style
from post._table import read_table
from post.figures import rocker
from post.mesh import _report, _tets, _write, body_of
from verification import TOP
from verification.section3.bend import bend, cpu_seconds
from verification.section3.check import check
from verification.section3.hertz import hertz

HERE = TOP / "verification/section3"
VARIANTS = {
    "gmsh": {"mesher": "gmsh"},
    "tetgen": {"mesher": "tetgen"},
    "smooth": {"mesher": "gmsh", "smooth": "local"},
    "peaks": {"mesher": "gmsh", "smooth": "local", "junction": "peak"},
    "hexes": {"interior": "hexes"},
}
COLUMNS = (
    "counts.elements", "counts.dofs", "counts.tets", "counts.pyramids", "counts.hexes", "counts.hanging",
    "volume.relative_difference", "layer.det_gauss", "layer.det_corner", "layer.scaled_corner",
    "pyramids.scaled", "hexes.scaled", "tets.scaled", "tets.dihedral_least", "tets.dihedral_largest",
    "mesher.scaled", "mesher.dihedral_least", "mesher.moved",
    "normals.edges", "self_intersections",
)  # fmt: skip


def entry(report, path):
    """The number in a report with the name 'part.entry', or '' if the report does not have it."""
    value = report
    for key in path.split("."):
        value = value.get(key, "") if isinstance(value, dict) else ""
    return f"{value:.4g}" if isinstance(value, float) else value


def mesh(net, name, out):
    """Write a row for each variant that the net and the installed meshers allow."""
    rows = [",".join(["variant", *COLUMNS, "seconds"])]
    for variant, options in VARIANTS.items():
        if options.get("interior") == "hexes" and pathlib.Path(net).suffix != ".vtk":
            continue
        if "mesher" in options and not _tets.available(options["mesher"]):
            print(f"left out: {variant} ({options['mesher']} is not installed)")
            continue
        start = cpu_seconds()
        body = body_of(net, **options)
        report = _report.describe(body)
        seconds = cpu_seconds() - start
        rows.append(
            ",".join([variant, *(str(entry(report, c)) for c in COLUMNS), f"{seconds:.0f}"])
        )
        print(rows[-1], *_report.bad(report))
        if (body.points[: len(body.form.inner)] != body.form.inner).any():
            raise SystemExit("the mesher moved a point of the layer")
    (out / f"mesh_{name}.csv").write_text("\n".join(rows) + "\n")


def slide(bezel, out, work):
    """Compare force, friction and largest pressure of the sliding pin on the spline and on plain
    faces.
    """
    table = ["surface,dofs,force_down,pressure_down,force_rms,friction_rms,pressure_rms,iterations"]
    curves = {}
    for surface in ("spline", "plain"):
        folder = work / f"slide_{surface}"
        folder.mkdir(parents=True, exist_ok=True)
        if not (folder / "rocker_pin.dat").exists():
            body, report = rocker.make_body(folder, "gmsh", 0)
            if surface == "plain":
                body = body_of(str(folder / "rocker_arm.obj"), enrich="box:90,90,90,91,91,91")
                (folder / "rocker.msh").write_text(_write.gmsh_text(body))
                deck = folder / "rocker.inp"
                text = re.sub(r"SPLIne,arm FILE.*?MATErial 1\n\n", "", deck.read_text(), flags=re.S)
                deck.write_text(text.replace("arm pad", "bulk pad"))
            rocker.solve(bezel, folder)
        c = read_table(folder / "rocker_pin.dat").columns
        values = [abs(c[f"contact_pad_2_{name}"]) for name in ("force_2", "force_1", "pressure")]
        down, along = np.flatnonzero(c["time"] <= 1)[-1], c["time"] > 1.05
        rms = [_rms(c["time"][along], v[along]) for v in values]
        dofs = json.loads((folder / "rocker.report.json").read_text())["dofs"]
        numbers = [values[0][down], values[2][down], *rms]
        table.append(
            f"{surface},{dofs},"
            + ",".join(f"{v:.4g}" for v in numbers)
            + f",{c['iterations'].sum():.0f}"
        )
        print(table[-1])
        curves[surface] = (c["time"], values)
    (out / "slide.csv").write_text("\n".join(table) + "\n")
    _draw_slide(curves, TOP / "doc/verification/figures/section3_slide.png")


def _rms(time, values):
    """Root mean square of the relative deviation from a smooth curve (a polynomial of degree 4)."""
    smooth = np.polyval(np.polyfit(time, values, 4), time)
    return np.sqrt(np.mean((values / smooth - 1) ** 2))


def _draw_slide(curves, path):
    with _style.styled() as plt:
        figure, axes = plt.subplots(1, 2, figsize=(_style.PAGE, 2.6))
        for i, (surface, (t, values)) in enumerate(curves.items()):
            line = _style.series(i) | {"marker": None}
            axes[0].plot(t, values[0], label=f"{surface}, normal", **line)
            axes[0].plot(t, values[1], label=f"{surface}, friction", **line | {"linestyle": ":"})
            axes[1].plot(t, values[2], label=surface, **line)
        axes[0].set(
            xlabel="time (pressed until 1, then slid along)",
            ylabel="force on the arm",
            ylim=(0, None),
        )
        axes[1].set(
            xlabel="time (pressed until 1, then slid along)",
            ylabel="largest pressure",
            ylim=(0, None),
        )
        for ax in axes:
            ax.legend()
        _style.save(figure, path)


def main():
    p = argparse.ArgumentParser(
        prog="python -m verification.section3",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    p.add_argument("part", choices=("mesh", "bend", "slide", "hertz", "check"))
    p.add_argument("--net", help="another net; for bend, the hexahedra of a rocker arm")
    p.add_argument("--name", default="arm", help="name of the table")
    p.add_argument(
        "--largest",
        type=int,
        default=24,
        help="hertz: largest number of quads along an edge of the cube",
    )
    p.add_argument("--bezel", default=str(TOP / "build/release/bezel"))
    p.add_argument("--work", type=pathlib.Path, default=TOP / "build/section3")
    o = p.parse_args()
    o.work.mkdir(parents=True, exist_ok=True)
    if o.part == "hertz":
        return hertz(o.bezel, HERE, o.work, o.largest)
    if o.part == "bend":
        return bend(o.bezel, HERE, o.work, o.net)
    net = o.net
    if net is None:
        net = str(o.work / "rocker_arm.obj")
        subprocess.run([sys.executable, str(TOP / "input/rocker_arm.py"), net], check=True)
    if o.part == "check":
        return check(o.bezel, o.work, net, VARIANTS)
    if o.part == "mesh":
        mesh(net, o.name, HERE)
    else:
        slide(o.bezel, HERE, o.work)


if __name__ == "__main__":
    sys.exit(main())
