"""Figures of doc/verification/contact.md: convergence to Hertz's solution, ironing, partial slip.

They are drawn from the files curves.csv in the folders of verification/contact, which
`python -m verification.contact --write` writes:

    python -m post.figures.contact [--cases verification/contact] [--to doc/verification/figures]
"""

import argparse
import csv
import pathlib
import sys

import numpy as np

from post import _style
from post._error import Unreadable

TOP = pathlib.Path(__file__).resolve().parents[2]
CASES = TOP / "verification/contact"
FIGURES = TOP / "doc/verification/figures"
#: Published forces per mm in shallow ironing: vertical and horizontal at time 1.0, then at 1.5.
PUBLISHED = {
    "Fischer, Wriggers 2006": (297.9, 62.1, 365.1, 188.8),
    "Hartmann et al. 2009": (319.5, 67.2, 408.4, 160.2),
    "Yastrebov 2011": (289.7, 58.5, 359.5, 170.8),
    "Poulios, Renard 2015": (267.9, 55.3, 337.4, 102.1),
    "Code_Aster SSNP153": (332.0, 71.0, 421.0, 143.3),
}


def read(path):
    """Rows of a table as dictionaries."""
    try:
        with open(path, newline="", encoding="utf-8") as file:
            return list(csv.DictReader(line for line in file if not line.startswith("#")))
    except OSError as error:
        raise Unreadable(f"'{path}' cannot be read: {error.strerror}") from None


def column(rows, name):
    return np.array([float(r[name]) for r in rows])


def lines_of_types(ax, rows, name):
    """Plot the magnitude of an error against the number of elements in 1.3 contact radii, with one
    line per element type.
    """
    for kind in dict.fromkeys(r["elements"] for r in rows):
        chosen = [r for r in rows if r["elements"] == kind]
        ax.loglog(
            column(chosen, "mesh"), np.abs(column(chosen, name)), label=kind, **_style.element(kind)
        )


def slope(ax, x, y, order):
    """Draw a short line whose slope is the given order."""
    ends = np.array([x, 2 * x])
    ax.loglog(ends, y * (ends / x) ** -order, color="#666666", linewidth=0.9)
    ax.annotate(f"{order}", (1.45 * x, y * 1.45**-order), textcoords="offset points", xytext=(6, 3))


def hertz(folder, plt):
    """Plot the errors of the force on the sphere, and of the pressures on the sphere and the
    cylinder.
    """
    drawing, axes = plt.subplots(1, 3, figsize=(_style.PAGE, 2.7))
    ball, roller = read(folder / "sphere/curves.csv"), read(folder / "cylinder/curves.csv")
    lines_of_types(axes[0], ball, "force")
    slope(axes[0], 2.2, 0.012, 2)
    axes[0].set_title("a) sphere: force", loc="left")
    lines_of_types(axes[1], ball, "l2")
    slope(axes[1], 2.2, 0.08, 1)
    axes[1].set_title("b) sphere: pressure, L2", loc="left")
    lines_of_types(axes[2], roller, "l2")
    slope(axes[2], 3.3, 0.03, 1)
    axes[2].set_title("c) cylinder: pressure, L2", loc="left")
    for ax, ticks in zip(axes, ((2, 3, 4, 6), (2, 3, 4, 6), (3, 6, 12)), strict=True):
        ax.set_xticks(ticks, [str(t) for t in ticks])
        ax.minorticks_off()
        ax.set_xlabel("elements over 1.3 radii")
    for ax, ticks in zip(axes[1:], ((0.05, 0.1, 0.2, 0.4), (0.02, 0.05, 0.1)), strict=True):
        ax.set_yticks(ticks, [str(t) for t in ticks])
    axes[0].set_ylabel("relative error")
    axes[2].legend()
    return drawing


def ironing(folder, plt):
    """Plot the forces in shallow ironing, with the published ones as marks."""
    drawing, axes = plt.subplots(1, 2, figsize=(_style.PAGE, 2.9))
    rows = read(folder / "ironing/curves.csv")
    meshes = list(dict.fromkeys(r["n"] for r in rows))
    for ax, name, which, title in (
        (axes[0], "vertical", (0, 2), "a) vertical force, N/mm"),
        (axes[1], "horizontal", (1, 3), "b) horizontal force, N/mm"),
    ):
        for n, shade in zip(meshes, ("#9a9a9a", "#000000"), strict=True):
            chosen = [r for r in rows if r["n"] == n]
            ax.plot(
                column(chosen, "time"),
                column(chosen, name),
                color=shade,
                linewidth=1.0,
                label=f"bezel, {n} elements",
            )
        for i, (source, values) in enumerate(PUBLISHED.items()):
            marks = _style.series(i) | {"linestyle": "none"}
            ax.plot((1.0, 1.5), [values[k] for k in which], label=source, **marks)
        ax.set_title(title, loc="left")
        ax.set_xlabel("time: 0 to 1 pressed, 1 to 2 dragged")
    axes[0].legend(loc="lower right")
    return drawing


def mindlin(folder, plt):
    """Plot the shear traction of a partly slipping cylinder."""
    rows = read(folder / "mindlin/curves.csv")
    kinds = list(dict.fromkeys(r["elements"] for r in rows))
    drawing, axes = plt.subplots(1, len(kinds), figsize=(_style.PAGE, 2.7), sharey=True)
    for i, (ax, kind) in enumerate(zip(axes, kinds, strict=True)):
        chosen = [r for r in rows if r["elements"] == kind]
        x = column(chosen, "x")
        marks = {"markersize": 3.0, "color": _style.element(kind)["color"], "markeredgewidth": 0}
        ax.plot(x, column(chosen, "shear"), "o", label=kind, **marks)
        ax.plot(x, column(chosen, "exact"), color="black", linewidth=0.9, label="Cattaneo, Mindlin")
        ax.set_xlabel("x / b")
        ax.set_title(f"{'ab'[i]}) {kind}", loc="left")
        ax.legend(loc="lower center")
    axes[0].set_ylabel("shear / ($\\mu p_0$)")
    return drawing


def draw(cases=CASES, to=FIGURES):
    """Draw the three figures into a folder."""
    with _style.styled() as plt:
        for part in (hertz, ironing, mindlin):
            path = pathlib.Path(to) / f"contact_{part.__name__}.png"
            _style.save(part(pathlib.Path(cases), plt), path)


def main(argv=None):
    p = argparse.ArgumentParser(prog="contact", description=(__doc__ or "").splitlines()[0])
    p.add_argument("--cases", default=CASES, metavar="DIR", help="folder that contains the cases")
    p.add_argument(
        "--to", default=FIGURES, metavar="DIR", help="(default doc/verification/figures)"
    )
    o = p.parse_args(argv)
    draw(o.cases, o.to)
    return 0


if __name__ == "__main__":
    sys.exit(main())
