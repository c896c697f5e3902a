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

from post import _style, field
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


def forces(results, mesh, group, plt):
    """Plot the peeling forces of those element types of a group that were run."""
    figure, ax = plt.subplots(figsize=(0.65 * _style.PAGE, 3.2))
    for name in group:
        if (results / f"{mesh}_{name}.dat").exists():
            c = in_equilibrium(bonded(results / f"{mesh}_{name}.dat"))
            ax.plot(c["disp_3"], c["force_3"], label=LABELS[name], **line(name))
    finer = results / f"3_{FINER}.dat"
    if mesh == "2" and FINER in group and finer.exists():  # grey, as in the paper's Figure 16
        c = in_equilibrium(bonded(finer))
        grey = line(FINER) | {"color": "#bbbbbb", "zorder": 1, "linewidth": 3.0}
        ax.plot(c["disp_3"], c["force_3"], label=f"{LABELS[FINER]}, mesh 3", **grey)
    ax.set_xlabel("lift $u / L_0$")
    ax.set_ylabel("peeling force $P / E_0 L_0^2$")
    ax.set_title(f"mesh {mesh}, in equilibrium", loc="left")
    ax.legend(loc="upper left", bbox_to_anchor=(1, 1))
    return figure


def line(name):
    """The line properties of an element type, which are the same in all figures."""
    order = [n for group in GROUPS for n in group if n != "iga2"]
    black = "#000000"
    colours = [c for c in _style.COLOURS if c != black] + ["#8c564b"]  # black is IGA2's
    colour = black if name == "iga2" else colours[order.index(name)]
    return {"color": colour, "marker": "", "linewidth": 1.1}


def front(results, mesh, plt):
    """Plot the released fraction of the bond against the lift."""
    figure, ax = plt.subplots(figsize=(0.65 * _style.PAGE, 3.2))
    for name in LABELS:
        if (results / f"{mesh}_{name}.dat").exists():
            c = bonded(results / f"{mesh}_{name}.dat")
            released = 100 * c["contact_glue_1_debonded"]
            ax.plot(c["disp_3"], released, label=LABELS[name], **line(name))
    ax.set_xlabel("lift $u / L_0$")
    ax.set_ylabel("bond released, %")
    ax.set_title(f"mesh {mesh}", loc="left")
    ax.legend(loc="upper left", bbox_to_anchor=(1, 1))
    return figure


def strips(fields, to):
    """Draw Figures 13 and 14: the first stress invariant on the deformed bodies of mesh 1."""
    files = {n: str(fields / f"pictures_{n}/pictures_{n}.vtkhdf") for n in ("q1e9", "q1e9_q1n2")}
    if not all(pathlib.Path(f).exists() for f in files.values()):
        print(f"no result files in {fields}: Figures 13 and 14 are not drawn")
        return
    look = {"scalar": "stress", "component": "trace", "outline": False, "say_step": False}
    field.draw([files["q1e9_q1n2"]] * 2, str(to / "section5_figure13.png"), step=[("time", 0.5), ("time", 1.0)],
               labels=["lift 7.75", "lift 15.5"], view="-60,25", **look)  # fmt: skip
    field.draw([files["q1e9"], files["q1e9_q1n2"]], str(to / "section5_figure14.png"), step=("time", 6.4 / 15.5),
               labels=["Q1E9, lift 6.4", "Q1E9+Q1N2, lift 6.4"], view="-60,25", **look)  # fmt: skip


def energies(results, mesh, name, plt):
    """Plot the energies against the released fraction, since the lift decreases in a snap-back."""
    c = bonded(results / f"{mesh}_{name}.dat")
    figure, ax = plt.subplots(figsize=(0.6 * _style.PAGE, 3.2))
    parts = ("cohesive", "bonds"), ("stored", "strain energy"), ("kinetic", "kinetic energy")
    x = 100 * c["contact_glue_1_debonded"]
    base = 0.0 * x
    for k, (part, words) in enumerate((*parts, ("inertia", "taken by inertia"))):
        ax.fill_between(
            x,
            base,
            base + c[f"book_{part}"],
            color=_style.COLOURS[k],
            alpha=0.6,
            label=words,
            linewidth=0,
        )
        base = base + c[f"book_{part}"]
    ax.plot(
        x,
        c["book_work"],
        color="#000000",
        marker="",
        linewidth=1.0,
        label="work of the lifted edge",
    )
    ax.set_xlabel("bond released, %")
    ax.set_ylabel("energy $/ E_0 L_0^3$")
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
    with _style.styled() as plt:
        for mesh in "123":
            for figure, group in ("15", GROUPS[0]), ("16", GROUPS[1]):
                if there(mesh, set(group) - ({"iga2"} if figure == "16" else set())):
                    file = o.to / f"section5_figure{figure}_mesh{mesh}.png"
                    _style.save(forces(o.results, mesh, group, plt), file)
            if there(mesh, LABELS):
                _style.save(front(o.results, mesh, plt), o.to / f"section5_front_mesh{mesh}.png")
        _style.save(
            energies(o.results, "1", "q1e9_q1n2", plt), o.to / "section5_peeling_energy.png"
        )
    strips(o.fields, o.to)
    return 0


if __name__ == "__main__":
    sys.exit(main())
