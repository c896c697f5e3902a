"""Accuracy and cost of contact: errors against CPU seconds, drawn from the file results.csv of
verification/benchmark/tradeoff, which `make tradeoff` writes.

    python -m post.figures.tradeoff [--results FILE] [--to doc/verification/figures]
"""

import argparse
import pathlib
import sys

import numpy as np

from post import _style
from post._error import Unreadable
from post._table import read_table

TOP = pathlib.Path(__file__).resolve().parents[2]
RESULTS = TOP / "verification/benchmark/tradeoff/results.csv"
FIGURES = TOP / "doc/verification/figures"
QUANTITIES = {
    "force": "force",
    "torque": "torque, sliding",
    "traction": "largest traction, sliding",
}
PERCENT = 100.0

#: Colour and marker of an element type; open markers stand for enriched elements.
TYPES = {
    "Q1": (0, "o", True), "Q1+Q1N2.1": (0, "s", False),
    "Q1E9": (1, "o", True), "Q1E9+Q1N2": (1, "s", False), "Q1E9+Q1N3": (1, "^", False),
    "Q1E9+Q1N4": (1, "v", False), "Q1E9+Q1N2.1": (3, "s", False), "Q1E9+Q1N2.2": (3, "D", False),
    "Q1E9+Q1N3.1": (3, "^", False), "Q1E9+Q1E9N2.1": (5, "s", False),
    "Q2": (2, "o", True), "Q2+Q2N2.1": (2, "s", False),
    "IGA2": (6, "D", True), "IGA3": (6, "P", True),
}  # fmt: skip
#: Settings: title of the panel, prefix of the values in the column of names, the usual value.
SETTINGS = {
    "points": ("points per direction", "q ", 5),
    "penalty": ("penalty, times the paper's", "x ", 1),
    "steps": ("degrees of a step", "", 3),
}


class Results:
    """Rows of results.csv."""

    def __init__(self, path):
        self.path, self.column = path, read_table(path).columns

    def rows(self, group, elements, mesh=None):
        """The rows of the runs that succeeded."""
        c = self.column
        pick = (c["group"] == group) & (c["elements"] == elements) & (c["code"] == 0)
        return np.flatnonzero(pick & (c["mesh"] == mesh) if mesh else pick)

    def number(self, name, rows):
        """(n) numbers in a column; NaN for an empty cell."""
        value = self.column[name][rows]
        return np.array([float(v) if str(v).strip() else np.nan for v in value])


def look(elements):
    colour, marker, full = TYPES[elements]
    colour = _style.COLOURS[colour]
    face = colour if full else "white"
    return {"color": colour, "marker": marker, "markerfacecolor": face, "markeredgecolor": colour}


def figure_elements(results, plt):
    """Plot the element types; a line joins the meshes of each type."""
    figure, axes = plt.subplots(1, 3, figsize=(_style.PAGE, 3.9), sharex=True)
    for ax, (name, title) in zip(axes, QUANTITIES.items()):
        for elements in TYPES:
            rows = results.rows("elements", elements)
            if len(rows) == 0:
                continue
            rows = rows[np.argsort(results.number("mesh", rows))]
            x, y = results.number("cpu_s", rows), PERCENT * results.number(f"e_{name}", rows)
            ax.loglog(x, y, label=elements, linewidth=0.8, **look(elements))
            for i, row in enumerate(rows):
                if elements in ("Q1E9", "IGA2", "Q1E9+Q1N2.1"):
                    label = f"{int(results.column['mesh'][row])}"
                    ax.annotate(label, (x[i], y[i]), xytext=(4, 3), textcoords="offset points",
                                fontsize=6.5, color=look(elements)["color"])  # fmt: skip
        ax.set_title(title, loc="left")
        ax.set_xlabel("CPU seconds")
        plain_ticks(ax)
    axes[0].set_ylabel("error [%]")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=5)
    return figure


def figure_settings(results, plt):
    """Plot the effects of quadrature, penalty and steps: differences from the finest setting on the
    same mesh, and CPU seconds relative to the usual setting.
    """
    shape = {"figsize": (_style.PAGE, 7.2), "sharex": "col", "sharey": "row"}
    figure, axes = plt.subplots(4, 3, **shape)
    series = [(e, m) for e in ("Q1E9+Q1N2.1", "IGA2") for m in (1, 2)]
    for column, (group, (title, prefix, usual)) in zip(axes.T, SETTINGS.items()):
        for i, (elements, mesh) in enumerate(series):
            rows = results.rows(group, elements, mesh)
            names = results.column["name"][rows]
            x = np.array([float(str(n).removeprefix(prefix).removesuffix(" deg")) for n in names])
            line = {"label": f"{elements}, mesh {mesh}", **_style.series(i)}
            for ax, name in zip(column, QUANTITIES):
                y = PERCENT * results.number(f"d_{name}", rows)
                ax.loglog(x[y > 0.0], y[y > 0.0], **line)
            cpu = results.number("cpu_s", rows)
            if (x == usual).any():
                column[-1].loglog(x, cpu / cpu[x == usual][0], **line)
        for ax in column:
            ax.axvline(usual, color="#999999", linewidth=0.9, zorder=0)
            plain_ticks(ax)
        column[0].set_title(title, loc="left")
    for ax, name in zip(axes[:, 0], QUANTITIES.values()):
        ax.set_ylabel(f"{name}:\ndifference [%]")
    axes[-1, 0].set_ylabel("CPU seconds,\nrelative")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4)
    return figure


def plain_ticks(ax):
    from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

    for axis in (ax.xaxis, ax.yaxis):
        low, high = axis.get_view_interval()
        close = (1, 1.5, 2, 3, 5, 7) if high < 10 * low else (1, 2, 5)
        axis.set_major_locator(LogLocator(subs=close if high < 60 * low else (1,)))
        axis.set_major_formatter(StrMethodFormatter("{x:g}"))
        axis.set_minor_formatter(NullFormatter())


def draw(results=RESULTS, to=FIGURES):
    """Draw both figures into a folder."""
    found = Results(results)
    with _style.styled() as plt:
        for name, figure in (
            ("tradeoff_elements", figure_elements(found, plt)),
            ("tradeoff_settings", figure_settings(found, plt)),
        ):
            _style.save(figure, pathlib.Path(to) / f"{name}.png")


def main(argv=None):
    p = argparse.ArgumentParser(prog="tradeoff", description=__doc__.splitlines()[0])
    p.add_argument("--results", default=RESULTS, metavar="FILE")
    p.add_argument("--to", default=FIGURES, metavar="DIR")
    o = p.parse_args(argv)
    try:
        draw(o.results, o.to)
    except Unreadable as error:
        print(f"tradeoff: error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
