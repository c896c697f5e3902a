"""Figures of doc/verification/debonding_laws.md: laws at a point, beams, and strips that are pulled
along a plate or peeled off it.

They are drawn from curves.csv and results.csv, which curves.py and study.py of cz_beams write:

    python -m post.figures.debonding_laws [--cases verification/benchmark] [--to doc/verification/figures]
"""

import argparse
import csv
import pathlib
import sys

import numpy as np

from post import _style
from post._error import Unreadable

TOP = pathlib.Path(__file__).resolve().parents[2]
CASES = TOP / "verification/benchmark"
FIGURES = TOP / "doc/verification/figures"
BLUE, RED, GREY = "#1f5fa8", "#b3362b", "#888888"


def read(path):
    """Rows of a table as dictionaries."""
    try:
        with open(path, newline="") as file:
            return list(csv.DictReader(file))
    except OSError as error:
        raise Unreadable(f"'{path}' cannot be read: {error.strerror}") from None


def curve(rows, name):
    """(opening, force) of a run."""
    return np.array([(float(r["way"]), float(r["force"])) for r in rows if r["run"] == name]).T


def point(ax, rows, folder, law, title):
    """Plot normal and shear loading at a point: the published formula as a line, and every second
    step of the run as a mark; marks of normal and shear loading alternate, because the curves may be
    the same.
    """
    for phi, column, color in ((0, "force_3", BLUE), (90, "force_1", RED)):
        way, force = curve(rows, f"{law} {phi}")
        reference = read(folder / f"cz_point/reference/{law}_{phi}.csv")
        ax.plot(way, [float(r[column]) for r in reference], color=color, linewidth=0.9)
        first, mark, label = (0, "o", "normal") if phi == 0 else (1, "s", "shear")
        ax.plot(way[first::2], force[first::2], mark, markersize=2.6, color=color, label=label)
    ax.set_xlabel("opening / $g_0$")
    ax.set_ylabel("traction / unit of stress")
    ax.set_title(title, loc="left")
    ax.legend()


def dcb(ax, rows):
    """Plot the force on the double cantilever beam and that of beam theory."""
    way, force = curve(rows, "dcb")
    opening = np.linspace(0.45, 1.0, 50)
    theory = np.sqrt(0.3**1.5 * 33750**0.5 / 3 / opening)
    ax.plot(*curve(rows, "dcb coarse"), color=GREY, linewidth=0.9, label="2 $T_0$, elements × 3")
    ax.plot(way[::2], force[::2], "o", markersize=3, color=BLUE, label="exponential")
    ax.plot(*curve(rows, "dcb ppr")[:, 1::2], "s", markersize=2.6, color=RED, label="PPR")
    ax.plot(opening, theory, color="black", linewidth=0.9, label="beams, Griffith")
    ax.set_ylim(0, 9.5)
    ax.set_xlabel("deflection of an arm, mm")
    ax.set_ylabel("force, N")
    ax.set_title("d) double cantilever beam", loc="left")
    ax.legend(loc="upper left")


def pulled(ax, rows):
    """Plot the force on a strip pulled along a plate, and the closed form for the exponential
    law.
    """
    stiffness, a, gc, g0 = 180000.0, 10.0, 0.6, 0.01 / np.e
    slip = np.linspace(0, 12 * g0, 200)
    force = np.sqrt(2 * stiffness * gc * (1 - (1 + slip / g0) * np.exp(-slip / g0)))
    end = slip + force * a / stiffness
    ax.plot(end, force, color="black", linewidth=0.9, label="closed form")
    ax.plot(*curve(rows, "lap")[:, ::2], "o", markersize=3, color=BLUE, label="exponential")
    ax.plot(*curve(rows, "lap ppr")[:, 1::2], "s", markersize=2.6, color=RED, label="PPR")
    ax.set_xlabel("displacement of the end, mm")
    ax.set_ylabel("force, N")
    ax.set_title("e) strip pulled along a plate", loc="left")
    ax.legend(loc="lower right")


def peeled(ax, rows):
    """Plot the force on the peeled strip, divided by the fracture energy and the width."""
    way, force = curve(rows, "peel")
    ax.plot(way, force / 0.02, color=BLUE, label="strip")
    ax.axhline(1.0, color="black", linewidth=0.9, label="Rivlin")
    ax.set_ylim(0, 1.3)
    ax.set_ylabel("force / (energy × width)")
    ax.set_xlabel("lift of the end / length")
    ax.set_title("f) strip peeled at 90°", loc="left")
    ax.legend(loc="lower right")


def figure(folder, plt):
    """Draw the six panels of the first figure."""
    rows = read(folder / "cz_beams/curves.csv")
    drawing, axes = plt.subplots(2, 3, figsize=(_style.PAGE, 4.6))
    point(axes[0, 0], rows, folder, "irreversible", "a) exponential, irreversible")
    point(axes[0, 1], rows, folder, "mixed", "b) MIXEd")
    point(axes[0, 2], rows, folder, "ppr", "c) PPR")
    dcb(axes[1, 0], rows)
    pulled(axes[1, 1], rows)
    peeled(axes[1, 2], rows)
    return drawing


def meshes(folder, plt):
    """Plot error and scatter of the force against the number of elements in the cohesive zone."""
    results = read(folder / "cz_beams/results.csv")
    drawing, axes = plt.subplots(1, 2, figsize=(_style.PAGE, 2.9), sharex=True)
    for case, mark, color in (("dcb", "o", BLUE), ("peel", "s", RED)):
        chosen = [
            r for r in results if r["case"] == case and r["status"] == "done" and r["q"] == "5"
        ]
        x = [float(r["per_element"]) for r in chosen if r["mean"]]
        label = "double cantilever beam" if case == "dcb" else "peeled strip"
        for ax, y in zip(axes, ("mean", "scatter"), strict=True):
            values = [abs(float(r[y]) - (y == "mean")) for r in chosen if r["mean"]]
            ax.loglog(x, np.maximum(values, 1e-5), mark, markersize=4, color=color, label=label)
    axes[0].set_title("a) mean force: relative deviation from theory", loc="left")
    axes[1].set_title("b) scatter of the force, relative to theory", loc="left")
    for ax in axes:
        ax.set_xticks((0.5, 1, 2, 5, 10), ("0.5", "1", "2", "5", "10"))
        ax.minorticks_off()
        ax.set_xlabel("length of the zone / element")
    axes[1].legend(loc="lower left")
    return drawing


def draw(cases=CASES, to=FIGURES):
    """Draw both figures into a folder."""
    with _style.styled() as plt:
        folder = pathlib.Path(cases)
        _style.save(figure(folder, plt), pathlib.Path(to) / "debonding_laws.png")
        _style.save(meshes(folder, plt), pathlib.Path(to) / "debonding_meshes.png")


def main(argv=None):
    p = argparse.ArgumentParser(prog="debonding_laws", description=(__doc__ or "").splitlines()[0])
    p.add_argument("--cases", default=CASES, metavar="DIR", help="folder that contains the cases")
    p.add_argument(
        "--to", default=FIGURES, metavar="DIR", help="(default doc/verification/figures)"
    )
    o = p.parse_args(argv)
    draw(o.cases, o.to)
    return 0


if __name__ == "__main__":
    sys.exit(main())
