"""Plot relative errors against degrees of freedom: `python -m post convergence TABLE.csv`.

The table has one row for each mesh. Its columns are one of words that names the series (the element
type), `dofs`, and either `error` or a value to compare with `--reference`.
`--where test=compression` selects rows. As a library:

>>> import post, numpy as np
>>> s = post.convergence.Series("Q1", np.array([10.0, 80.0]), np.array([0.1, 0.025]))
>>> s.slopes().round(3).tolist()
[-0.667]
"""

from dataclasses import dataclass

import numpy as np

from post import _options, _style
from post._error import Unreadable
from post._table import read_table


@dataclass
class Series:
    """One element type: x (n) increasing degrees of freedom, error (n) non-negative relative
    errors.
    """

    name: str
    x: np.ndarray
    error: np.ndarray

    def slopes(self):
        """(n-1) slopes d log(error) / d log(x) between successive meshes; NaN where an error is
        zero.
        """
        with np.errstate(divide="ignore", invalid="ignore"):
            slopes = np.diff(np.log(self.error)) / np.diff(np.log(self.x))
        return np.where(np.isfinite(slopes), slopes, np.nan)


def read_series(path, x="dofs", y=None, reference=None, by=None, where=None):
    """Series of a .csv table.

    y: column of values (by default `error`, or with a reference the last column of numbers);
    reference: the converged value, with error = |y / reference - 1|; by: column of words that names
    the series (by default the only one not used by `where`); where: {column: value} to select rows.
    """
    table = read_table(path)
    keep = _rows(table, where or {})
    over = table.find(x)
    column = table.find(y) if y else _value_column(table, reference, over)
    if reference is not None and not (np.isfinite(reference) and reference != 0):
        raise Unreadable(f"the reference {reference} is zero or not finite")
    names = _names(table, by, where or {}, keep)
    values = table.columns[column][keep]
    error = values if reference is None else values / reference - 1.0
    dofs = table.columns[over][keep]
    if (
        error.dtype.kind == "U"
        or dofs.dtype.kind == "U"
        or not (dofs > 0).all()
        or not np.isfinite(error).all()
    ):
        raise Unreadable(
            f"columns '{over}' and '{column}' of '{path}' must contain finite numbers, and '{over}' positive ones"
        )
    series = []
    for name in dict.fromkeys(names):
        own = np.flatnonzero(names == name)
        own = own[np.argsort(dofs[own])]
        series.append(Series(str(name), dofs[own], np.abs(error[own])))
    return series


def _rows(table, where):
    keep = np.ones(len(table), dtype=bool)
    for word, value in where.items():
        column = table.columns[table.find(word)]
        try:
            keep &= column == (value if column.dtype.kind == "U" else float(value))
        except ValueError:
            raise Unreadable(
                f"column '{table.find(word)}' of {table.name} contains numbers, and '{value}' is not one"
            ) from None
    if not keep.any():
        raise Unreadable(
            f"no row of {table.name} has " + ", ".join(f"{k} = {v}" for k, v in where.items())
        )
    return keep


def _value_column(table, reference, over):
    if reference is None:
        return table.find("error")
    numbers = [
        n for n, v in table.columns.items() if v.dtype.kind != "U" and n not in (over, "error")
    ]
    if not numbers:
        raise Unreadable(f"{table.name} has no column of values; name one with -y")
    return numbers[-1]


def _names(table, by, where, keep):
    if by:
        return table.columns[table.find(by)][keep].astype(str)
    fixed = [table.find(w) for w in where]
    words = [n for n, v in table.columns.items() if v.dtype.kind == "U" and n not in fixed]
    if len(words) > 1:
        raise Unreadable(
            f"{table.name} has several columns of words ({' '.join(words)}): choose with --by or --where"
        )
    return table.columns[words[0]][keep] if words else np.full(keep.sum(), table.name)


def plot(ax, series, guides=(), style=_style.element, label=_style.element_label):
    """Plot series on log-log axes; guides: slopes of grey lines that start above the top series."""
    for s in series:
        seen = s.error > 0  # zero has no logarithm
        ax.loglog(s.x[seen], s.error[seen], label=label(s.name), **style(s.name))
    x = np.array([min(s.x.min() for s in series), max(s.x.max() for s in series)])
    top = max(s.error.max() for s in series)
    for slope in guides:
        y = 1.3 * top * (x / x[0]) ** slope
        ax.loglog(x, y, color="#999999", linewidth=0.9, zorder=0)
        ax.annotate(
            f"{slope:.2g}", (x[-1], y[-1]), color="#666666", fontsize=7, va="bottom", ha="right"
        )
    ax.set_xlabel("degrees of freedom")
    ax.set_ylabel("relative error")
    ax.legend()


def table_text(series):
    """Lines with the errors and the slopes, each slope relative to the previous mesh."""
    lines = [f"{'series':<28}{'dofs':>9}{'error':>12}{'slope':>8}"]
    for s in series:
        slopes = [np.nan, *s.slopes()]
        for x, error, slope in zip(s.x, s.error, slopes):
            lines.append(
                f"{s.name:<28}{x:>9.0f}{error:>12.3e}"
                + (f"{slope:>8.2f}" if np.isfinite(slope) else "")
            )
    return "\n".join(lines)


def draw(series, output, title=None, guides=(-2 / 3,)):
    """Plot series into the file `output`; element types have fixed colours, other names get
    others.
    """
    order = {s.name: _style.series(i) for i, s in enumerate(series)}
    known = all(_style.is_element(s.name) for s in series)
    with _style.styled() as plt:
        many = len(series) > 6
        figure, ax = plt.subplots(figsize=(6.4 if many else 4.6, 3.6))
        plot(ax, series, guides, _style.element if known else order.get, _style.element_label)
        if many:  # put the legend beside the lines instead of over them
            ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        ax.set_title(title or "")
        _style.save(figure, output)


def main(argv):
    """Run the command; return its exit code."""
    p = _options.parser(
        prog="post convergence", description="Plot relative errors against degrees of freedom."
    )
    p.add_argument("table", help="a .csv file with one row for each mesh")
    p.add_argument(
        "-x", default="dofs", metavar="COLUMN", help="column of the horizontal axis (default dofs)"
    )
    p.add_argument(
        "-y",
        metavar="COLUMN",
        help="column of values (default error, or with --reference the last column of numbers)",
    )
    p.add_argument(
        "--reference",
        type=float,
        metavar="VALUE",
        help="the converged value; error = |y / VALUE - 1|",
    )
    p.add_argument("--by", metavar="COLUMN", help="column that names the series")
    p.add_argument(
        "--where",
        action="append",
        default=[],
        metavar="COLUMN=VALUE",
        help="use only the rows with this value in the column",
    )
    p.add_argument(
        "--guide",
        action="append",
        type=float,
        metavar="SLOPE",
        help="draw a grey line of this slope (default -2/3)",
    )
    p.add_argument("--title")
    p.add_argument(
        "-o", "--output", metavar="FIG", default="convergence.png", help="(default convergence.png)"
    )
    o = p.parse_args(argv)
    if bad := [w for w in o.where if "=" not in w]:
        raise Unreadable(f"'{bad[0]}' is not COLUMN=VALUE")
    series = read_series(
        o.table, o.x, o.y, o.reference, o.by, dict(w.split("=", 1) for w in o.where)
    )
    if o.y is None and o.reference is not None:
        table = read_table(o.table)
        print(f"values of column '{_value_column(table, o.reference, table.find(o.x))}'")
    print(table_text(series))
    draw(series, o.output, o.title, (-2 / 3,) if o.guide is None else o.guide)
    return 0
