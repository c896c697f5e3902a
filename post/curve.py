"""Plot columns of curve files: `python -m post curve FILE.dat ... -x disp -y force`.

As a library:

>>> import post
>>> post.curve.draw(["out/cube_force.dat"], "fig.png", x="time", y=["force"])  # doctest: +SKIP
"""

import pathlib

import numpy as np

from post import _options, _style
from post._error import Unreadable
from post._table import read_table


def draw(
    files,
    output,
    x=None,
    y=None,
    labels=None,
    title=None,
    x_label=None,
    y_label=None,
    log="",
    markers=None,
):
    """Plot columns `y` against column `x` of each file into the file `output`.

    x: beginning of the name of a column, by default time, or else the first column; y: a list of
    such beginnings, by default the first quantity; log: 'x', 'y' or 'xy'; markers: whether to mark
    the points, by default if there are fewer than 60.
    """
    tables = [read_table(f) for f in files]
    with _style.styled() as plt:
        figure, ax = plt.subplots(figsize=(4.6, 3.4))
        names = plot(ax, tables, x, y, _labels(files, labels), markers)
        ax.set_xlabel(x_label or names[0])
        ax.set_ylabel(y_label or (names[1] if len(set(names[1:])) == 1 else "value"))
        ax.set_title(title or "")
        for axis in log:
            getattr(ax, f"set_{axis}scale")("log")
        _style.save(figure, output)


def plot(ax, tables, x=None, y=None, labels=None, markers=None):
    """Plot tables (post._table.Table) on matplotlib axes; return the names of the x column and of
    each line's y column.
    """
    names, i = [], 0
    labels = labels or [t.name for t in tables]
    for table, label in zip(tables, labels):
        over = _x_column(table, x)
        for word in y or [None]:
            column = _y_column(table, word, over)
            style = _style.series(i)
            if not (len(table) < 60 if markers is None else markers):
                style["marker"] = ""
            several = len(y or ()) > 1
            ax.plot(
                _numbers(table, over),
                _numbers(table, column),
                label=f"{label}: {column}" if several else label,
                **style,
            )
            names += [column]
            i += 1
        names = [over, *names] if table is tables[0] else names
    if i > 1:
        ax.legend()
    return names


def _x_column(table, x):
    if x is not None:
        return table.find(x)
    return "time" if "time" in table.columns else next(iter(table.columns))


def _y_column(table, y, over):
    if y is not None:
        return table.find(y)
    found = [n for n in table.quantities() if n != over and table.columns[n].dtype.kind != "U"]
    if not found:
        raise Unreadable(
            f"{table.name} has no quantity to draw (columns: {' '.join(table.columns)})"
        )
    return found[0]


def _numbers(table, name):
    values = table.columns[name]
    if values.dtype.kind == "U":
        raise Unreadable(f"column '{name}' of {table.name} contains words, which cannot be plotted")
    return values


def _labels(files, labels):
    """The given labels, or the shortest names that distinguish the files."""
    if labels:
        if len(labels) != len(files):
            raise Unreadable(
                f"expected {len(files)} labels, one for each file, found {len(labels)}"
            )
        return labels
    paths = [pathlib.Path(f) for f in files]
    stems = [p.stem for p in paths]
    return stems if len(set(stems)) == len(stems) else [str(p.with_suffix("")) for p in paths]


def print_list(files):
    """Print the columns of each file with the range of their values."""
    for table in map(read_table, files):
        print(f"{table.path}: {len(table)} rows")
        for name, values in table.columns.items():
            what = (
                "words"
                if values.dtype.kind == "U"
                else f"{np.min(values):.6g} to {np.max(values):.6g}"
            )
            print(f"  {name}: {what}")


def main(argv):
    """Run the command; return its exit code."""
    p = _options.parser(prog="post curve", description="Plot columns of curve files.")
    p.add_argument(
        "files",
        nargs="+",
        metavar="FILE",
        help="<deck>_<curve>.dat, or a .csv file with a line of names",
    )
    p.add_argument(
        "-x", metavar="COLUMN", help="beginning of the name of the x column (default time)"
    )
    p.add_argument(
        "-y",
        metavar="COLUMN",
        action="append",
        help="beginning of the name of a y column; may be repeated (default the first quantity)",
    )
    p.add_argument(
        "-o",
        "--output",
        default="curve.png",
        metavar="FIG",
        help=".png, .pdf or .svg (default curve.png)",
    )
    p.add_argument("--label", action="append", help="name in the legend, given once for each file")
    p.add_argument("--title")
    p.add_argument("--xlabel")
    p.add_argument("--ylabel")
    p.add_argument("--log", choices=("x", "y", "xy"), default="", help="logarithmic axes")
    p.add_argument("--list", action="store_true", help="print the columns, draw nothing")
    o = p.parse_args(argv)
    if o.list:
        print_list(o.files)
    else:
        draw(o.files, o.output, o.x, o.y, o.label, o.title, o.xlabel, o.ylabel, o.log)
    return 0
