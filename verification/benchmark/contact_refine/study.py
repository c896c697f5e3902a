"""Error and cost of using more integration points everywhere, and of using subcells at the contact
boundary.
    python -m verification.benchmark.contact_refine.study [PROGRAM]

It twists the hemisphere of section 5.3 on mesh 1, with and without friction: with q1e9_q1n2.inp of
section5_contact and q x q points, and with refined.inp, q x q points and subcells. It prints and
writes study.csv: the root mean square over all steps of the difference from a run with 20 x 20
points in every element, relative to the largest value of that run; the iterations; and the seconds
in total and for contact, which depend on the machine.
"""

import csv
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

from post._table import read_table
from verification import TOP

HERE = TOP / "verification/benchmark/contact_refine"
PLAIN = HERE.parent / "section5_contact/q1e9_q1n2.inp"
RUNS = [(20, 0), (10, 0), (5, 0), (3, 0), (3, 2), (3, 4), (5, 2), (5, 3)]  # points, cells
FRICTION = (0.0, 0.5)
MEASURES = {"force": "force_3", "torque": "torque", "shear": "tangential_1"}
COLUMNS = ("mu", "q", "cells", *MEASURES, "iterations", "seconds", "contact")


def main():
    bezel = sys.argv[1] if len(sys.argv) > 1 else str(TOP / "build/release/bezel")
    rows = []
    for mu in FRICTION:
        fine = None
        for q, cells in RUNS:
            curve, report = run(bezel, q, cells, mu)
            fine = fine or curve
            errors = [difference(curve, fine, name, mu) for name in MEASURES]
            seconds = report["seconds"]
            cost = (report["iterations"], f"{seconds['total']:.1f}", f"{seconds['contact']:.1f}")
            rows.append((f"{mu:g}", q, cells or "-", *errors, *cost))
            print(*rows[-1], flush=True)
    with (HERE / "study.csv").open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerows([COLUMNS, *rows])


def run(bezel, q, cells, mu):
    """The columns of the curve of a run, and its report."""
    deck = HERE / "refined.inp" if cells else PLAIN
    settings = [f"q={q}", f"mu={mu}"] + ([f"cells={cells}"] if cells else [])
    with tempfile.TemporaryDirectory() as place:
        words = [w for s in settings for w in ("--set", s)]
        subprocess.run([bezel, "--quiet", "-o", place, *words, str(deck)], check=True)
        stem = pathlib.Path(place) / deck.stem
        report = json.loads(stem.with_suffix(".report.json").read_text())
        return read_table(f"{stem}_sole.dat").columns, report


def difference(curve, fine, name, mu):
    """Root mean square of the difference at the steps of the fine run, relative to the largest value
    of that run; '-' for all measures but the force if there is no friction.
    """
    if mu == 0 and name != "force":
        return "-"
    key = "contact_sole_1_" + MEASURES[name]
    values = np.interp(fine["time"], curve["time"], curve[key])
    error = np.sqrt(np.mean((values - fine[key]) ** 2)) / np.abs(fine[key]).max()
    return f"{error:.4f}"


if __name__ == "__main__":
    main()
