"""Figures 13 to 16 of Corbett and Sauer 2015, section 5.1: the strip, the peeling force, the
debonding front and the energies.

The curves, one for each mesh and element type, are written by `python -m
verification.section5_debonding --write`. Figures 13 and 14 are drawn only if that program has also
written result files, with its option `--pictures`.

    python -m post.figures.section5_debonding [--results FOLDER] [--fields build/section5_debonding]
        [--to doc/verification/figures]
"""

import argparse
import pathlib
import sys

import numpy as np

from post import _grid, _style, field
from post._error import Unreadable
from post._table import read_table

TOP = pathlib.Path(__file__).resolve().parents[2]
RESULTS = TOP / "verification/benchmark/section5_debonding/runs"
FIELDS = TOP / "build/section5_debonding"
FIGURES = TOP / "doc/verification/figures"
LABELS = {
    "q1e9": "Q1E9", "q1e9_q1n2": "Q1E9+Q1N2", "q1e9_q1n3": "Q1E9+Q1N3", "q1e9_q1n2.1": "Q1E9+Q1N2.1",
    "q2": "Q2", "q2_q2n2": "Q2+Q2N2", "q2_q2n2.1": "Q2+Q2N2.1", "iga2": "IGA2",
}  # fmt: skip
GROUPS = (
    ("q1e9", "q1e9_q1n2", "q1e9_q1n3", "q1e9_q1n2.1", "iga2"),
    ("q2", "q2_q2n2", "q2_q2n2.1", "iga2"),
)
FINER = "iga2"
CLOSE = (-9, 1, -9, 1, -0.5, 2.5)  # part of the plate below the peeling front
CLOSE_VIEW = "-75,40"
LIFT = 15.5  # up to which curves are compared with each other
ANGLE = 43  # between the strip and the x axis, in degrees
OFF = 0.999  # released fraction of the bond at which the curves end: the strip has come off


def bonded(path):
    """Columns of a curve up to and including the step in which the bond is released."""
    columns = read_table(path).columns
    off = columns["contact_glue_1_debonded"] >= OFF
    n = int(off.argmax()) + 1 if off.any() else len(off)
    return {k: v[:n] for k, v in columns.items()}


def in_equilibrium(columns):
    """The rows before inertia is active."""
    moves = abs(columns["book_inertia"]) > 0
    return {k: v[: int(moves.argmax())] for k, v in columns.items()} if moves.any() else columns


def figure_of(results, mesh, group, quantity, plt):
    """Plot a quantity against the lift for those element types of a group that were run, and beside
    it the difference from the reference, because most of the curves lie on each other.
    """
    figure, axes = plt.subplots(1, 2, figsize=(_style.PAGE, 2.9), width_ratios=(1.25, 1))
    value, words, difference, rest = QUANTITIES[quantity]
    finest = f"{results}/3_{FINER}.dat"
    reference = columns_of(
        finest if pathlib.Path(finest).exists() else f"{results}/{mesh}_{FINER}.dat"
    )
    x = np.linspace(0, LIFT, 500)
    there = reached(x, reference["disp_3"], value(reference))
    scale = 100 / max(there) if quantity == "force" else 1
    for name in sorted(group, key=lambda n: n != FINER):
        path = results / f"{mesh}_{name}.dat"
        if path.exists():
            c = columns_of(path) if quantity == "force" else bonded(path)
            axes[0].plot(c["disp_3"], value(c), label=LABELS[name], **line(name))
            here = reached(x, c["disp_3"], value(c))
            if np.abs(here - there).max() > 0:  # the reference itself has no difference
                axes[1].plot(x, scale * (here - there), **line(name))
    if mesh != "3" and pathlib.Path(finest).exists():  # grey, as in the paper's Figure 16
        grey = line(FINER) | {"color": "#bbbbbb", "zorder": 1, "linewidth": 3.0}
        axes[0].plot(
            reference["disp_3"], value(reference), label=f"{LABELS[FINER]}, mesh 3", **grey
        )
    axes[1].axhline(0.0, color="#bbbbbb", linewidth=3.0, zorder=1)
    for ax in axes:
        ax.set_xlabel("lift $u / L_0$")
    axes[1].set_xticks(range(0, 16, 5))
    axes[0].set_ylabel(words)
    axes[1].set_ylabel(difference)
    axes[0].set_title(f"a) mesh {mesh}{rest}", loc="left")
    axes[1].set_title("b) difference from IGA2, mesh 3", loc="left")
    handles, labels = axes[0].get_legend_handles_labels()
    order = [labels.index(LABELS[n]) for n in group if LABELS[n] in labels]
    order += [i for i in range(len(labels)) if i not in order]
    figure.legend(
        [handles[i] for i in order],
        [labels[i] for i in order],
        loc="outside lower center",
        ncols=6 if len(order) <= 6 else 5,
    )
    return figure


def columns_of(path):
    """The columns of a curve while the states are in equilibrium."""
    return in_equilibrium(bonded(path))


def reached(x, lift, values):
    """The values when each lift of x is reached first, since the lift decreases in snap-backs."""
    first = np.r_[True, lift[1:] > np.maximum.accumulate(lift)[:-1]]
    return np.interp(x, np.r_[0.0, lift[first]], np.r_[0.0, values[first]])


#: The value of each row, the labels of both panels, and what is added to the title.
QUANTITIES = {
    "force": (
        lambda c: c["force_3"],
        "peeling force $P / E_0 L_0^2$",
        "difference / largest force, %",
        ", in equilibrium",
    ),
    "front": (
        lambda c: 100 * c["contact_glue_1_debonded"],
        "bond released, %",
        "difference, percentage points",
        "",
    ),
}


def line(name):
    """The line properties of an element type; the line of IGA2 is wide and drawn first, so that
    curves on top of it leave its edges visible.
    """
    wide = name == FINER
    return {
        "color": _style.element(LABELS[name])["color"],
        "linewidth": 2.2 if wide else 1.0,
        "zorder": 2 if wide else 3,
    }


def strips(fields, to):
    """Draw Figures 13 and 14: the first stress invariant on the deformed bodies of mesh 1."""
    files = {n: str(fields / f"pictures_{n}/pictures_{n}.vtkhdf") for n in ("q1e9", "q1e9_q1n2")}
    if not all(pathlib.Path(f).exists() for f in files.values()):
        print(f"no result files in {fields}: Figures 13 and 14 are not drawn")
        return
    measures(files)
    look = {
        "scalar": "stress",
        "component": "trace",
        "outline": False,
        "say_step": False,
        "words": "$I_1 / E_0$",
    }
    times = [0.0, 0.5, 1.0]
    field.draw([files["q1e9_q1n2"]] * 3, str(to / "section5_figure13.png"), step=[("time", t) for t in times],
               labels=["undeformed", "lift 7.75", "lift 15.5"], view="-60,25", **look)  # fmt: skip
    field.draw(list(files.values()), str(to / "section5_figure14.png"), step=("time", 6.4 / 15.5), bodies=[2],
               labels=["Q1E9", "Q1E9+Q1N2"], view=CLOSE_VIEW, frame=CLOSE, **look)  # fmt: skip


def measures(files):
    """Print the numbers of the page that belong to Figures 13 and 14: the twist of the strip, and the
    largest first invariant of the stress in the plate near the peeling front.
    """
    for time in (0.5, 1.0):
        angle = twist(files["q1e9_q1n2"], ("time", time))
        print(f"lift {LIFT * time:g}: the strip is twisted by {angle:.1f} degrees")
    for name, path in files.items():
        scene = field._scene(
            path, "stress", "trace", ("time", 6.4 / LIFT), 1.0, False, False, None, [2]
        )
        x, value = scene.surface.points, scene.surface["shown"]
        front = (x[:, 0] > CLOSE[0] + 2) & (x[:, 0] < CLOSE[1])  # away from the clamped face
        print(f"lift 6.4, {LABELS[name]}: largest I1 of the plate {value[front].max():.3f} E0")


def twist(path, step):
    """The largest inclination [degrees] of the lines across the strip on its upper face. The lifted
    edge is one of these lines, and remains horizontal.
    """
    grid = _grid.load(path, step)[0]
    grid = grid.extract_cells(grid.cell_data["body"] == 1)
    x = np.asarray(grid.points, dtype=float)
    moved = x + grid.point_data["displacement"]
    axis = np.radians(ANGLE)
    along = x[:, 0] * np.cos(axis) + x[:, 1] * np.sin(axis)
    across = x[:, 1] * np.cos(axis) - x[:, 0] * np.sin(axis)
    top = np.isclose(x[:, 2], x[:, 2].max(), atol=1e-6)
    sides = []
    for edge in (across.min(), across.max()):
        rim = np.flatnonzero(top & np.isclose(across, edge, atol=1e-4))
        _, first = np.unique(np.round(along[rim], 4), return_index=True)
        sides.append(moved[rim[first]])
    line = sides[1] - sides[0]
    return np.degrees(np.abs(np.arcsin(line[:, 2] / np.linalg.norm(line, axis=1))).max())


def energies(results, mesh, name, plt):
    """Plot the energies against the released fraction, since the lift decreases in a snap-back."""
    c = bonded(results / f"{mesh}_{name}.dat")
    figure, ax = plt.subplots(figsize=(0.6 * _style.PAGE, 3.2))
    parts = ("cohesive", "bonds"), ("stored", "strain energy"), ("kinetic", "kinetic energy")
    x = 100 * c["contact_glue_1_debonded"]
    base = 0.0 * x
    for k, (part, words) in enumerate((*parts, ("inertia", "taken by inertia"))):
        top = base + c[f"book_{part}"]
        if np.abs(top - base).max() > 1e-3 * c["book_work"].max():  # else it cannot be seen
            ax.fill_between(x, base, top, color=_style.COLOURS[k], alpha=0.6, label=words, lw=0)
        base = top
    ax.plot(
        x,
        c["book_work"],
        color="#000000",
        marker="",
        linewidth=1.0,
        label="work of the lifted edge",
    )
    ax.set_xlabel("bond released, %")
    ax.set_ylabel("energy / $E_0 L_0^3$")
    ax.set_title(f"{LABELS[name]}, mesh {mesh}", loc="left")
    ax.legend(loc="upper left")
    return figure


def main(argv=None):
    p = argparse.ArgumentParser(prog="section5_debonding", description=__doc__.split("\n")[0])
    p.add_argument("--results", type=pathlib.Path, default=RESULTS, metavar="FOLDER")
    p.add_argument("--fields", type=pathlib.Path, default=FIELDS, metavar="FOLDER")
    p.add_argument("--to", type=pathlib.Path, default=FIGURES, metavar="FOLDER")
    o = p.parse_args(argv)
    if not list(o.results.glob("1_*.dat")):
        raise Unreadable(
            f"no curves in {o.results}: python -m verification.section5_debonding --write makes them"
        )
    there = lambda mesh, names: any((o.results / f"{mesh}_{n}.dat").exists() for n in names)
    shown = [("figure15", GROUPS[0], "force"), ("figure16", GROUPS[1], "force"), ("front", tuple(LABELS), "front")]  # fmt: skip
    with _style.styled() as plt:
        for mesh in "123":
            for figure, group, quantity in shown:
                if there(mesh, set(group) - ({FINER} if figure == "figure16" else set())):
                    file = o.to / f"section5_{figure}_mesh{mesh}.png"
                    _style.save(figure_of(o.results, mesh, group, quantity, plt), file)
        _style.save(
            energies(o.results, "1", "q1e9_q1n2", plt), o.to / "section5_peeling_energy.png"
        )
    strips(o.fields, o.to)
    return 0


if __name__ == "__main__":
    sys.exit(main())
