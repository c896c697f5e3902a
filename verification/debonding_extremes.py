"""Debonding with extreme parameters: run benchmark/debonding_extremes and print a table.

    python -m verification.debonding_extremes [--only WORD ...] [--jobs N] [--out DIR] [--write]

The table has a row for each run, as in doc/verification/section5_debonding.md; `--write` puts the
rows into benchmark/debonding_extremes/results.csv. Forces are in units of s l^2, with s and l as in
the decks.
"""

import argparse
import csv
import json
import os
import pathlib
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

from post._error import Unreadable
from post._table import read_table
from verification import TOP

DECKS = TOP / "verification/benchmark/debonding_extremes"
TIME_LIMIT = 150

#: what is changed: the deck, and its settings
RUNS = {
    "nothing": ("peel", {}),
    **{f"g0 = {g:g} L0": ("peel", {"g0": g}) for g in (0.01, 0.03, 0.3, 1)},
    **{f"T0 = {t:g} E0": ("peel", {"t0": t}) for t in (0.001, 0.01, 1)},
    "T0 = 1 E0, penalty 100": ("peel", {"t0": 1, "eps": 100}),
    "T0 = 10 E0": ("peel", {"t0": 10}),
    "T0 = 10 E0, penalty 1000": ("peel", {"t0": 10, "eps": 1000}),
    "two half passes": ("halves", {}),
    "two half passes, T0 = 10 E0": ("halves", {"t0": 10}),
    "two half passes, T0 = 10 E0, 12 x 12 points": ("halves", {"t0": 10, "q": 12}),
    "strip ten times thinner": ("peel", {"thick": 0.1}),
    "one step to a lift of 15.5": ("peel", {"steps": 1, "most": 1}),
    "down again to 0 and into the plate by 0.2": ("peel", {"lift": 5, "back": -0.2, "n": 200}),
    "the same, irreversible": ("irreversible", {"lift": 5, "back": -0.2, "n": 200}),
    **{f"edge led at {a} degrees": ("pull", {"mix": a}) for a in (0, 30, 60, 85, 90)},
    "lengths 1e-6": ("peel", {"l": 1e-6}),
    "lengths 1e6": ("peel", {"l": 1e6}),
    "stresses 1e-6": ("peel", {"s": 1e-6}),
    "stresses 1e6": ("peel", {"s": 1e6}),
}  # fmt: skip
COLUMNS = (
    "changed", "outcome", "steps", "cuts", "snaps", "to", "released", "force",
    "penetration", "bonds", "inertia", "imbalance", "last_words",
)  # fmt: skip


def main(argv=None):
    o = parser().parse_args(argv)
    bezel = pathlib.Path(o.bezel).resolve()
    if not os.access(bezel, os.X_OK):
        sys.exit(
            f"debonding_extremes: error: '{bezel}' is not an executable program; build it with `make`"
        )
    rows = []
    print("| " + " | ".join(COLUMNS) + " |\n" + "|---" * len(COLUMNS) + "|", flush=True)
    chosen = [name for name in RUNS if any(word in name for word in o.only)]
    with ThreadPoolExecutor(o.jobs) as pool:
        for line in pool.map(lambda name: row(bezel, o.out, name, *RUNS[name]), chosen):
            rows.append(line)
            print("| " + " | ".join(line) + " |", flush=True)
            if o.write:
                write(rows)
    return 0


def write(rows):
    """Write results.csv, in which these rows replace those of the same name."""
    file, known = DECKS / "results.csv", {}
    if file.exists():
        with file.open(newline="") as text:
            known = {r[0]: r for r in csv.reader(text)}
    known.update({r[0]: r for r in rows})
    with file.open("w", newline="") as text:
        out = csv.writer(text, lineterminator="\n")
        out.writerows([COLUMNS, *(known[n] for n in RUNS if n in known)])


def row(bezel, out, name, deck, settings):
    """Run one case; return its line of the table."""
    with tempfile.TemporaryDirectory(dir=out) as place:
        return run(bezel, name, deck, settings, pathlib.Path(place))


def run(bezel, name, deck, settings, place):
    """Run a deck; return the numbers of its row."""
    command = [bezel, "--quiet", "-o", place, "--time-limit", str(TIME_LIMIT)]
    command += [f for key, x in settings.items() for f in ("--set", f"{key}={x:.16g}")]
    done = subprocess.run([*command, DECKS / f"{deck}.inp"], capture_output=True, text=True)
    outcome = {0: "runs", 2: "no solution", 4: "time limit"}.get(done.returncode, "error")
    words = done.stderr.split("error: ")[-1].split("\n")[0] if done.returncode else ""
    try:
        c = read_table(place / f"{deck}_peel.dat").columns
        report = json.loads((place / f"{deck}.report.json").read_text())
    except (OSError, Unreadable):
        return [name, outcome, *["-"] * (len(COLUMNS) - 3), words]
    log = (place / f"{deck}.log").read_text()
    length, stress = settings.get("l", 1), settings.get("s", 1)
    work = c["book_work"][abs(c["book_work"]).argmax()]
    numbers = (
        f"{c['disp_3'][-1] / length:.4g}",
        f"{c['contact_glue_1_debonded'][-1]:.4f}",
        f"{c['force_3'].max() / (stress * length**2):.5g}",
        f"{c['contact_glue_1_penetration'].max() / length:.2g}",
        *(f"{x / work:.4f}" for x in (c["book_cohesive"][-1], c["book_inertia"][-1])),
        f"{abs(c['book_imbalance']).max() / work:.1e}",
    )
    snaps = str(log.count("path: load control ends"))
    return [name, outcome, str(report["steps"]), str(report["cutbacks"]), snaps, *numbers, words]


def parser():
    p = argparse.ArgumentParser(
        prog="python -m verification.debonding_extremes",
        description=__doc__,
        formatter_class=argparse.RawTextHelpFormatter,
    )
    p.add_argument("--bezel", default=TOP / "build/release/bezel", help="the program")
    p.add_argument(
        "--only",
        nargs="+",
        default=[""],
        help="run only the rows whose first cell contains one of these words",
    )
    p.add_argument("--out", default=None, help="folder for the runs (default: a temporary one)")
    p.add_argument("--jobs", type=int, default=1, metavar="N", help="number of simultaneous runs")
    p.add_argument("--write", action="store_true", help="write results.csv")
    return p


if __name__ == "__main__":
    sys.exit(main())
