"""Accuracy and cost of the integration points of bonds: section 5.1, mesh 1, up to a lift of 15.5.

    .venv/bin/python -m verification.debonding_points [--bezel PROGRAM] [--write]

It runs q1e9_q1n2.inp and iga2.inp of benchmark/section5_debonding with various numbers of points
per direction, one run at a time. Errors are those of the force on the lifted edge, relative to the
run with the most points: their root mean square over lifts from 0.5 to 15, and the error of the
largest force. `--write` puts the rows into runs/points.csv and into doc/verification/tradeoff.md.
"""

import argparse
import csv
import pathlib
import resource
import subprocess
import sys
import tempfile

import numpy as np

from post._table import read_table
from verification import TOP, section5_debonding
from verification.page import put_table
from verification.tradeoff.page import PAGE

DECKS = TOP / "verification/benchmark/section5_debonding"
POINTS = (3, 4, 5, 6, 8, 10, 16)
LABELS = {"q1e9_q1n2": "Q1E9+Q1N2", "iga2": "IGA2"}
COLUMNS = (
    "elements",
    "points",
    "steps",
    "iterations",
    "CPU s",
    "force",
    "largest force",
    "imbalance",
)
LIFT = np.linspace(0.5, 15, 400)


def main(argv=None):
    p = argparse.ArgumentParser(
        prog="python -m verification.debonding_points", description=__doc__.split("\n")[0]
    )
    p.add_argument("--bezel", default=str(TOP / "build/release/bezel"), metavar="PROGRAM")
    p.add_argument("--write", action="store_true", help="update points.csv and the page")
    o = p.parse_args(argv)
    rows = [row for name in LABELS for row in sweep(o.bezel, name)]
    lines = [" | ".join(row) for row in (COLUMNS, ("---",) * len(COLUMNS), *rows)]
    table = "\n".join(f"| {line} |" for line in lines)
    print(table)
    if o.write:
        with (DECKS / "runs/points.csv").open("w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([COLUMNS, *rows])
        page = PAGE.read_text()
        PAGE.write_text(put_table(page, "bonds", table))
    return 0


def sweep(bezel, name):
    """Run a deck with each number of points; return the rows."""
    runs = [run(bezel, name, q) for q in POINTS]
    best, most = runs[-1][1:3]
    for q, (numbers, force, largest, imbalance) in zip(POINTS, runs):
        error = np.sqrt(np.mean((force - best) ** 2) / np.mean(best**2))
        yield (
            LABELS[name],
            f"{q} x {q}",
            *numbers,
            f"{100 * error:.2f} %",
            f"{100 * (largest / most - 1):+.2f} %",
            imbalance,
        )


def run(bezel, name, q):
    """((steps, iterations, CPU seconds), forces at LIFT, largest force, imbalance relative to
    work).
    """
    with tempfile.TemporaryDirectory() as place:
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        subprocess.run([bezel, "--quiet", "-o", place, "--set", f"q={q}", "--set", "end=100",
                        str(DECKS / f"{name}.inp")], check=True)  # fmt: skip
        seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
        c = read_table(pathlib.Path(place) / f"{name}_peel.dat").columns
    force = section5_debonding.reached(LIFT, c["disp_3"], c["force_3"])
    imbalance = np.abs(c["book_imbalance"]).max() / c["book_work"][-1]
    numbers = (f"{len(c['step'])}", f"{c['iterations'].sum():.0f}", f"{seconds:.1f}")
    return numbers, force, c["force_3"].max(), f"{imbalance:.1e}"


if __name__ == "__main__":
    sys.exit(main())
