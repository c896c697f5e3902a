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

#: Element types by row of the figure: facets, quadratic bodies and splines; layers on Q1 or Q1E9.
ROWS = (
    ("Q1", "Q1E9", "Q2", "Q2+Q2N2.1", "IGA2", "IGA3"),
    ("Q1+Q1N2.1", "Q1E9+Q1N2", "Q1E9+Q1N3", "Q1E9+Q1N4", "Q1E9+Q1N2.1", "Q1E9+Q1N2.2", "Q1E9+Q1N3.1",
     "Q1E9+Q1E9N2.1"),
)  # fmt: skip
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


def figure_elements(results, plt):
    """Plot the element types in two rows; a line joins the meshes of each type, and the finer mesh is
    the one that takes more time. IGA2 is repeated in the lower row, thin, for comparison.
    """
    figure, axes = plt.subplots(2, 3, figsize=(_style.PAGE, 5.6), sharex=True, sharey="col")
    for row, types in zip(axes, ROWS):
        for ax, name in zip(row, QUANTITIES):
            for elements in types if "IGA2" in types else (*types, "IGA2"):
                x, y = points(results, elements, name)
                if len(x) == 0:
                    continue
                look = _style.element(elements)
                if elements not in types:
                    look |= {"linestyle": ":", "marker": ""}
                label = elements if elements in types else f"{elements}, as above"
                ax.loglog(x, y, label=label, **{"linewidth": 0.9} | look)
            plain_ticks(ax)
        row[0].set_ylabel("error [%]")
        row[2].legend(loc="upper left", bbox_to_anchor=(1, 1))
    for ax, title in zip(axes[0], QUANTITIES.values()):
        ax.set_title(title, loc="left")
    for ax in axes[1]:
        ax.set_xlabel("CPU seconds")
    return figure


def points(results, elements, name):
    """CPU seconds and errors [%] of an element type, from the coarser to the finer mesh."""
    rows = results.rows("elements", elements)
    rows = rows[np.argsort(results.number("mesh", rows))]
    return results.number("cpu_s", rows), PERCENT * results.number(f"e_{name}", rows)


def figure_settings(results, plt):
    """Plot the effects of quadrature, penalty and steps: differences from the finest setting on the
    same mesh, and CPU seconds relative to the usual setting.
    """
    shape = {"figsize": (_style.PAGE, 7.2), "sharex": "col", "sharey": "row"}
    figure, axes = plt.subplots(4, 3, **shape)
    series = [(e, m) for e in ("Q1E9+Q1N2.1", "IGA2") for m in (1, 2)]
    for column, (group, (title, prefix, usual)) in zip(axes.T, SETTINGS.items()):
        for elements, mesh in series:
            rows = results.rows(group, elements, mesh)
            names = results.column["name"][rows]
            x = np.array([float(str(n).removeprefix(prefix).removesuffix(" deg")) for n in names])
            line = {"label": f"{elements}, mesh {mesh}", **_style.element(elements)}
            line |= {"linestyle": "--" if mesh == 1 else "-"}
            line |= {"markerfacecolor": "white" if mesh == 1 else line["color"]}
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
