"""Accuracy and cost: run the hemisphere on the block with the options of contact, and write errors
and CPU seconds to benchmark/tradeoff/results.csv. `make tradeoff` runs this.

    python3 -m verification.tradeoff --bezel PROGRAM [--only WORD] [--mesh 1 2] [--again]

A run that exists in --out is not repeated, so that an interrupted study can be continued. CPU
seconds are user and system time of the process; on mesh 1, the shorter of two runs is taken. Errors
are root mean squares over the turn and over both sides of the contact, relative to the mean of the
reference:

    force      z force, 0 to 180 degrees
    torque     120 to 180 degrees, where all points slide
    traction   largest smoothed t_x of each side, 120 to 180 degrees

They are errors relative to benchmark/tradeoff/reference.csv (which `--reference` computes anew in
half an hour), and relative to the run `beside`, which differs in one setting. The column `ratio`,
which is given only for other schemes, solvers and tangents, is the CPU seconds divided by those of
the ordinary run, made immediately afterwards.
"""

import argparse
import csv
import json
import os
import pathlib
import shutil
import subprocess
import sys

from verification import TOP, need_numpy

need_numpy()
import numpy as np  # noqa: E402

from post._error import Unreadable  # noqa: E402
from post._table import read_table  # noqa: E402
from verification.tradeoff import grid  # noqa: E402

DECKS = TOP / "verification/benchmark/tradeoff"
RESULTS, REFERENCE = DECKS / "results.csv", DECKS / "reference.csv"
#: A spline's control points are too far apart to resolve the peaks of the smoothed traction.
PEAKS = TOP / "verification/benchmark/section5_contact/runs/3_Q1E9+Q1N2.1_0.5.dat"
SIDES = {"force": "force_3", "torque": "torque", "traction": "tangential_1"}
SIGNS = {"force": (1, -1), "torque": (1, -1), "traction": (1, 1)}
FROM = {"force": 0.0, "torque": 120.0, "traction": 120.0}  # degrees
COLUMNS = (
    "group", "name", "mesh", "elements", "settings", "dofs", "code", "inertia", "steps", "cutbacks", "iterations",
    "cpu_s", "contact_share", "ratio", "force", "torque", "traction", "force_imbalance", "penetration",
    "e_force", "e_torque", "e_traction", "beside", "d_force", "d_torque", "d_traction", "command",
)  # fmt: skip


class Curve:
    """The curve of a run while the hemisphere turns.

    degree (n); force, torque, traction (2, n) of both sides, with the same sign; penetration (n).
    """

    def __init__(self, path):
        table = read_table(path).columns
        turning = table["factor_1"] >= 1 - 1e-9
        self.degree = 180 * table["factor_2"][turning]
        for name, column in SIDES.items():
            pair = [s * table[f"contact_sole_{k}_{column}"] for k, s in zip((1, 2), SIGNS[name])]
            setattr(self, name, np.array(pair)[:, turning])
        deep = [table.get(f"contact_sole_{k}_penetration", turning)[turning] for k in (1, 2)]
        self.penetration = np.max(deep, axis=0)

    def mean(self, name):
        """The mean of both sides over the angles that count for this quantity."""
        return getattr(self, name)[:, self.degree >= FROM[name] - 1e-6].mean()


def difference(curve, other, name, pooled=True):
    """Root mean square of curve - other at common angles, relative to the mean of other.

    pooled: whether the two sides of other are replaced by their mean.
    """
    mine, its = np.rint(1e3 * curve.degree), np.rint(1e3 * other.degree)
    both = [d for d in np.intersect1d(mine, its) if d >= 1e3 * FROM[name] - 1]
    if not both:
        return None
    value = getattr(curve, name)[:, np.searchsorted(mine, both)]
    wanted = getattr(other, name)[:, np.searchsorted(its, both)]
    if pooled:
        wanted = wanted.mean(axis=0)
    scale = abs(other.mean(name))
    return float(np.sqrt(np.mean((value - wanted) ** 2)) / scale) if scale > 0 else None


class Reference(Curve):
    """The curve of reference.csv, whose values are means of both sides."""

    def __init__(self, path):
        with open(path, newline="") as file:
            rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
        self.degree = np.array([float(r["degree"]) for r in rows])
        for name in SIDES:
            one = np.array([float(r[name]) for r in rows])
            setattr(self, name, np.array([one, one]))


def main(argv=None):
    """Make the missing runs, then write all rows for which there are results or old rows."""
    o = parser().parse_args(argv)
    bezel, out = pathlib.Path(o.bezel).resolve(), pathlib.Path(o.out).resolve()
    if not os.access(bezel, os.X_OK):
        sys.exit(f"tradeoff: error: '{bezel}' is not an executable program; build it with `make`")
    if o.reference:
        time_run(bezel, out, grid.REFERENCE, o.again)
        write_reference(out)
    runs = [
        r
        for r in grid.runs()
        if r.mesh in o.mesh and any(w in f"{r.group} {r.key}" for w in o.only)
    ]
    for i, run in enumerate(runs):
        if run.beside:
            time_run(bezel, out, run.beside, False)
        if not run.ratio_to or run.mesh == 1:
            time_run(bezel, out, run, o.again)
        if run.ratio_to:
            time_round(bezel, out, run, o.again)
        print(f"{i + 1} of {len(runs)}: {run.group}, {run.key}", flush=True)
    write_rows(out)
    return 0


def parser():
    p = argparse.ArgumentParser(
        prog="python -m verification.tradeoff", description=__doc__.splitlines()[0]
    )
    p.add_argument("--bezel", default=TOP / "build/release/bezel")
    p.add_argument("--out", default=TOP / "build/tradeoff", help="folder for the runs")
    p.add_argument(
        "--only",
        nargs="*",
        default=[""],
        metavar="WORD",
        help="run only groups or decks whose name contains this word",
    )
    p.add_argument("--mesh", nargs="*", type=int, default=[1, 2])
    p.add_argument("--again", action="store_true", help="repeat runs that exist")
    p.add_argument("--reference", action="store_true", help="also run the reference")
    return p


def call(bezel, place, run):
    """Make one run; return (exit code, CPU seconds)."""
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir(parents=True)
    one = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    command = [bezel, "--quiet", "-o", place, "--name", "run", "--time-limit", str(grid.LIMIT)]
    with open(place / "stderr.txt", "w") as wrong:
        child = subprocess.Popen(
            [*command, *run.options, DECKS / run.deck],
            stdout=subprocess.DEVNULL,
            stderr=wrong,
            env=one,
        )
        _, status, used = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    return child.returncode, used.ru_utime + used.ru_stime


def time_run(bezel, out, run, again):
    """Time a run (on mesh 1, the shorter of two) and write time.json."""
    place = out / run.key
    if (place / "time.json").exists() and not again:
        return
    found = [call(bezel, place, run) for _ in range(2 if run.mesh == 1 else 1)]
    told = {"code": found[-1][0], "cpu": min(cpu for _, cpu in found)}
    (place / "time.json").write_text(json.dumps(told))


def time_round(bezel, out, run, again):
    """Measure the CPU seconds of a run relative to those of the ordinary run, which is made
    directly after it.
    """
    place = out / run.key
    known = place / "time.json"
    told = json.loads(known.read_text()) if known.exists() else {"cpu": float("inf")}
    if "ratio" in told and not again:
        return
    code, changed = call(bezel, place, run)
    _, plain = call(bezel, out / "round", run.ratio_to)
    told |= {"code": code, "ratio": changed / plain, "cpu": min(told["cpu"], changed)}
    known.write_text(json.dumps(told))


def write_reference(out):
    """Write reference.csv, the means of both sides; the traction comes from another run than the
    other columns.
    """
    curve, peaks = Curve(out / grid.REFERENCE.key / "run_sole.dat"), Curve(PEAKS)
    with open(REFERENCE, "w", newline="") as file:
        file.write(f"# force, torque: {grid.REFERENCE.command}\n")
        file.write(f"# traction: {PEAKS.relative_to(TOP).as_posix()}\n")
        w = csv.writer(file, lineterminator="\n")
        w.writerow(("degree", *SIDES))
        for i, degree in enumerate(curve.degree):
            j = np.flatnonzero(np.abs(peaks.degree - degree) < 1e-3)
            if len(j) == 0:
                continue
            means = [curve.force[:, i].mean(), curve.torque[:, i].mean()]
            means.append(peaks.traction[:, j[0]].mean())
            w.writerow([f"{degree:.6g}", *(f"{m:.8g}" for m in means)])


def write_rows(out):
    """Write results.csv with one row per run of the grid; a case without a new run keeps its old
    row.
    """
    old = {}
    if RESULTS.exists():
        with open(RESULTS, newline="") as file:
            old = {(r["group"], r["command"]): r for r in csv.DictReader(file)}
    reference = Reference(REFERENCE) if REFERENCE.exists() else None
    with open(RESULTS, "w", newline="") as file:
        w = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        w.writeheader()
        for run in grid.runs():
            row = make_row(out, run, reference) or old.get((run.group, run.command))
            if row:
                w.writerow(row)


def make_row(out, run, reference):
    """The row of an existing run, or None."""
    place = out / run.key
    try:
        told = json.loads((place / "time.json").read_text())
        report = json.loads((place / "run.report.json").read_text())
    except OSError:
        return None
    row = {
        "group": run.group, "name": run.name, "mesh": run.mesh, "elements": run.elements,
        "settings": " ".join(f"{k}={v:g}" for k, v in run.settings.items()), "code": told["code"],
        "inertia": "yes" if "on with inertia" in (place / "run.log").read_text() else "",
        "dofs": report["dofs"], "steps": report["steps"], "cutbacks": report["cutbacks"],
        "iterations": report["iterations"], "cpu_s": f"{told['cpu']:.3g}", "command": run.command,
        "contact_share": f"{report['seconds']['contact'] / report['seconds']['total']:.2f}",
        "ratio": f"{told['ratio']:.3g}" if "ratio" in told else "",
    }  # fmt: skip
    if told["code"] != 0:
        return row
    curve = Curve(place / "run_sole.dat")
    pair = curve.force.mean(axis=1)
    row |= {name: f"{curve.mean(name):.6g}" for name in SIDES}
    row["force_imbalance"] = f"{abs(pair[0] - pair[1]) / pair.mean():.3g}"
    row["penetration"] = f"{curve.penetration.max():.3g}"
    for name in SIDES:
        if reference is not None and run.settings["mu"] > 0:
            row[f"e_{name}"] = text(difference(curve, reference, name))
    if run.beside:
        row["beside"] = run.beside.key
        try:
            if json.loads((out / run.beside.key / "time.json").read_text())["code"] != 0:
                return row
            other = Curve(out / run.beside.key / "run_sole.dat")
        except (OSError, Unreadable):
            return row
        for name in SIDES:
            row[f"d_{name}"] = text(difference(curve, other, name, pooled=False))
    return row


def text(value):
    return "" if value is None else f"{value:.3g}"


if __name__ == "__main__":
    sys.exit(main())
