"""Figures 15 and 16's kin of Corbett and Sauer 2015, section 5.1: peeling force over lift, and the energies.

Drawn from the curves of verification/section5_debonding.py --write, one a mesh and element type.

    python -m post.figures.section5_debonding [--results FOLDER] [--to doc/verification/figures]
"""

import argparse
import pathlib
import sys

from post import _style
from post._error import Unreadable
from post._table import read_table

TOP = pathlib.Path(__file__).resolve().parents[2]
RESULTS = TOP / "verification/benchmark/section5_debonding/runs"
FIGURES = TOP / "doc/verification/figures"
LABELS = {
    "q1e9": "Q1E9", "q1e9_q1n2": "Q1E9+Q1N2", "q1e9_q1n3": "Q1E9+Q1N3", "q1e9_q1n2.1": "Q1E9+Q1N2.1",
    "q2": "Q2", "q2_q2n2": "Q2+Q2N2", "q2_q2n2.1": "Q2+Q2N2.1", "iga2": "IGA2",
}  # fmt: skip
GROUPS = (
    ("q1e9", "q1e9_q1n2", "q1e9_q1n3", "q1e9_q1n2.1", "iga2"),
    ("q2", "q2_q2n2", "q2_q2n2.1", "iga2"),
)
OFF = 0.999  # share of the bond from which the strip swings free: not drawn


def bonded(path):
    """Columns of a curve up to the moment at which the strip is off."""
    columns = read_table(path).columns
    off = columns["contact_glue_1_debonded"] >= OFF
    n = int(off.argmax()) + 1 if off.any() else len(off)
    return {k: v[:n] for k, v in columns.items()}


def forces(results, mesh, plt):
    """A panel a kind of body, Q1E9 and Q2, as far as there are runs; IGA2 in both."""
    there = lambda name: (results / f"{mesh}_{name}.dat").exists()
    groups = [(b, [n for n in g if there(n)]) for b, g in zip(("Q1E9", "Q2"), GROUPS)]
    groups = [(body, names) for body, names in groups if set(names) - {"iga2"}]
    size = (_style.PAGE * (0.65 if len(groups) == 1 else 1), 3.2)
    figure, axes = plt.subplots(1, len(groups), figsize=size, sharey=True, squeeze=False)
    for ax, (body, names) in zip(axes[0], groups):
        for k, name in enumerate(names):
            c = bonded(results / f"{mesh}_{name}.dat")
            colour = "#000000" if name == "iga2" else _style.COLOURS[k]
            style = {"color": colour, "marker": "", "linewidth": 1.1}
            ax.plot(c["disp_3"], c["force_3"], label=LABELS[name], **style)
        ax.set_xlabel("lift $u / L_0$")
        ax.set_title(f"bodies of {body}, mesh {mesh}", loc="left")
        ax.legend(loc="lower left")
    axes[0][0].set_ylabel("peeling force $P / E_0 L_0^2$")
    return figure


def energies(results, mesh, name, plt):
    """Where the work goes, over the lift."""
    c = bonded(results / f"{mesh}_{name}.dat")
    figure, ax = plt.subplots(figsize=(0.6 * _style.PAGE, 3.2))
    parts = ("cohesive", "bonds"), ("stored", "strain energy"), ("kinetic", "kinetic energy")
    base = 0.0 * c["disp_3"]
    for k, (part, words) in enumerate((*parts, ("inertia", "taken by inertia"))):
        ax.fill_between(
            c["disp_3"],
            base,
            base + c[f"book_{part}"],
            color=_style.COLOURS[k],
            alpha=0.6,
            label=words,
            linewidth=0,
        )
        base = base + c[f"book_{part}"]
    ax.plot(
        c["disp_3"],
        c["book_work"],
        color="#000000",
        marker="",
        linewidth=1.0,
        label="work of the lifted edge",
    )
    ax.set_xlabel("lift $u / L_0$")
    ax.set_ylabel("energy $/ E_0 L_0^3$")
    ax.set_title(f"{LABELS[name]}, mesh {mesh}", loc="left")
    ax.legend(loc="upper left")
    return figure


def main(argv=None):
    p = argparse.ArgumentParser(prog="section5_debonding", description=__doc__.split("\n")[0])
    p.add_argument("--results", type=pathlib.Path, default=RESULTS, metavar="FOLDER")
    p.add_argument("--to", type=pathlib.Path, default=FIGURES, metavar="FOLDER")
    o = p.parse_args(argv)
    if not list(o.results.glob("1_*.dat")):
        raise Unreadable(
            f"no curves in {o.results}: verification/section5_debonding.py --write makes them"
        )
    with _style.styled() as plt:
        _style.save(forces(o.results, "1", plt), o.to / "section5_figure15.png")
        _style.save(
            energies(o.results, "1", "q1e9_q1n2", plt), o.to / "section5_peeling_energy.png"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
