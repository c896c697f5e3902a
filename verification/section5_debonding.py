"""Corbett and Sauer 2015, section 5.1: peel the strip off the plate with every element type.

    .venv/bin/python -m verification.section5_debonding --mesh 1 [--only NAME] [--write] [--force]
    .venv/bin/python -m verification.section5_debonding --suite all|long [--write] [--force]

The suite `all` is mesh 1. The suite `long` is mesh 2, and mesh 3 for the bodies of Q1 and IGA2 up to
a lift of 15.5. A case that is complete is not run again unless --force is given. The command prints
the dofs of Table 2, how each case ended, and a comparison with the independent results of
section5_peeling/peeling.csv. The exit code is 1 if a case ends early or if its dofs differ from
Table 2. `--write` puts summary.csv and the curves (with few digits) into
benchmark/section5_debonding/runs, from which the figures are drawn.
`--pictures` also runs the decks of Figures 13 and 14, and `--readings` runs those with other
interpretations of the problem (readings.csv). `--steps` ends runs earlier, in folders of their own.
`--apart` runs nothing; it compares committed curves with each other (apart.csv).
"""

import argparse
import csv
import json
import pathlib
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from post._error import Unreadable
from post._table import read_table
from verification import TOP

DECKS = TOP / "verification/benchmark/section5_debonding"
PEELING = TOP / "verification/benchmark/section5_peeling/peeling.csv"
TYPES = ("q1e9", "q1e9_q1n2", "q1e9_q1n3", "q1e9_q1n2.1", "q2", "q2_q2n2", "q2_q2n2.1", "iga2")
TABLE_2 = {
    "1": (1386, 1500, 1626, 2772, 8190, 7128, 8400, 2304),
    "2": (8190, 8400, 8622, 13104, 55350, 51048, 55752, 11088),
    "3": (55350, 55752, 56166, 73800, 404838, 387576, 405624, 65520),
}
REFINEMENT = {"1": 1, "2": 2, "3": 4}
LIFT = 15.5  # the lift at time 1
READ_AT = (2, 5, 10, 15.5)
COMPARED = {"IGA2": "iga2", "Q1E9+Q1N2": "q1e9_q1n2"}  # compared with the independent results
HALF_STEPS = 120  # steps of the runs with two half passes, up to the last independent result
STEPS = {"1": 180, "2": 180, "3": 100}  # steps by mesh; each is a lift of 0.155
SUITES = {
    "all": [("1", t) for t in TYPES],
    "long": [*(("2", t) for t in TYPES), *(("3", t) for t in (*TYPES[:4], "iga2"))],
}
LOST, RELEASED = (
    0.98,
    0.999,
)  # debonded fractions at which energies are compared, and at which the strip counts as released
PAIRS = (  # pairs of curves that the paper compares, each given by (mesh, elements)
    (("1", "q2_q2n2"), ("1", "iga2")),
    (("2", "q2_q2n2"), ("2", "iga2")),
    (("2", "q2"), ("2", "q2_q2n2.1")),
    *(((m, t), ("3", "iga2")) for m in ("1", "2") for t in TYPES),
    (("2", "q1e9_q1n2"), ("2", "iga2")),
    *((("3", t), ("3", "iga2")) for t in TYPES[:4]),
)
KEPT = ("time", "disp_3", "force_3", "force_3_2", "contact_glue_1_debonded", "book_work", "book_stored",
        "book_kinetic", "book_normal", "book_cohesive", "book_created", "book_inertia",
        "book_imbalance")  # fmt: skip


def main(argv=None):
    o = parser().parse_args(argv)
    if o.apart:
        return apart(o.write)
    rows, bad = [], 0
    with_halves = {("1", name) for name in COMPARED.values()} <= set(cases(o)) and not o.steps
    with ThreadPoolExecutor(o.jobs) as pool:
        late = reversed(cases(o))  # the long cases first
        runs = [pool.submit(finish, o, *case, place_of(o, *case)) for case in late]
        if with_halves:
            runs += [
                pool.submit(finish, o, "1", f"half_{name}", half_of(o, name), HALF_STEPS)
                for name in COMPARED.values()
            ]
    for run in runs:
        run.result()
    for mesh, name in cases(o):
        dofs, place = TABLE_2[mesh][TYPES.index(name)], place_of(o, mesh, name)
        row = summary(mesh, name, place)
        bad += row is None or row["status"] != "done" or row["dofs"] != dofs
        if row is None:
            print(f"{mesh} {name}: no result")
            continue
        rows.append(row)
        print(" ".join(f"{k} {v}" for k, v in row.items()), f"table_2 {dofs}", flush=True)
        if o.write:
            write(mesh, name, place)
    if o.pictures:
        for name in ("pictures_q1e9", "pictures_q1e9_q1n2"):
            finish(o, "1", name, o.out / name)
    if o.write and rows:
        write_summary(rows)
    if o.readings:
        readings(o)
    done = {(row["mesh"], row["elements"]) for row in rows}
    if with_halves and done >= {("1", name) for name in COMPARED.values()}:
        beside(o)
    print(f"{len(rows)} cases, {bad} ended early or with other dofs")
    return 1 if bad else 0


def cases(o):
    """(mesh, elements) of all requested cases."""
    chosen = SUITES[o.suite] if o.suite else [(m, t) for m in o.mesh for t in TYPES]
    return [(m, t) for m, t in chosen if t in o.only or not o.only]


def place_of(o, mesh, name):
    """The folder of a case; a run with a given number of steps has a folder of its own."""
    return o.out / (f"{mesh}_{name}" + (f"_{o.steps}_steps" if o.steps else ""))


def half_of(o, name):
    """The folder of the run of mesh 1 with two half passes."""
    return o.out / f"1_half_{name}"


def finish(o, mesh, name, place, steps=None):
    """Run a case unless it is complete."""
    report = place / f"{name}.report.json"
    if not o.force and report.exists() and json.loads(report.read_text())["status"] == "done":
        return
    options = ["--quiet", "-o", str(place), "--time-limit", str(o.time_limit)]
    end = steps or o.steps or STEPS[mesh]
    settings = ["--set", f"r={REFINEMENT[mesh]}", "--set", f"end={end}"]
    subprocess.run([o.bezel, *options, *settings, str(DECKS / f"{name}.inp")], check=False)


def summary(mesh, name, place):
    """The results of a case, or None if there are none."""
    try:
        report = json.loads((place / f"{name}.report.json").read_text())
        c = read_table(place / f"{name}_peel.dat").columns
    except (OSError, ValueError, Unreadable):
        return None
    lift, force, lost = c["disp_3"], c["force_3"], c["contact_glue_1_debonded"]
    bonded = np.maximum.accumulate(lost) < RELEASED  # until the strip is released
    taken = "-"  # inertia as a fraction of the work when LOST is debonded, if the run reaches that
    if lost.max() >= LOST:
        share = reached(LOST, lost, c["book_inertia"]) / reached(LOST, lost, c["book_work"])
        taken = f"{share:.4f}"
    log = (place / f"{name}.log").read_text()
    ends = [LIFT * float(t) for t in re.findall("path: load control ends at time ([^:]*):", log)]
    moves = np.maximum.accumulate(c["book_inertia"] != 0)
    work = c["book_work"][bonded][-1]
    created, imbalance = c["book_created"][bonded] / work, c["book_imbalance"][bonded] / work
    return {
        "mesh": mesh,
        "elements": name,
        "dofs": report["dofs"],
        "status": report["status"],
        "lift": f"{lift[-1]:.2f}",
        "off_at": f"{lift[np.argmax(~bonded)]:.2f}" if (~bonded).any() else "-",
        "largest_force": f"{force[bonded].max():.5f}",
        "oscillation": f"{roughness(lift[bonded], force[bonded]):.5f}",
        "load_control_to": f"{ends[0]:.2f}" if ends else "-",
        "equilibrium_to": f"{lost[~moves].max():.4f}",
        "snaps": len(ends),
        "steps": report["steps"],
        "iterations": report["iterations"],
        "seconds": f"{report['seconds']['total']:.0f}",
        "inertia_at_98": taken,
        "released": f"{lost[-1]:.4f}",
        "least_created": f"{created.min():.4f}",
        "most_created": f"{created.max():.4f}",
        "imbalance": f"{np.abs(imbalance).max():.1e}",
        "bodies": f"{np.abs(imbalance + created).max():.1e}",  # the imbalance of the bodies alone
    }


def readings(o):
    """Run other interpretations of the problem (mesh 1, Q1E9+Q1N2); print forces and the lift at
    release.
    """
    rows = [("reading", "largest_force", *(f"force_at_{u:g}" for u in READ_AT), "off_at")]
    for name in ("q1e9_q1n2", *sorted(p.stem for p in DECKS.glob("reading_*.inp"))):
        place = o.out / ("1_" + name)
        finish(o, "1", name, place)
        row = summary("1", name, place)
        c = read_table(place / f"{name}_peel.dat").columns
        forces = (reached(u, c["disp_3"], c["force_3"]) for u in READ_AT)
        rows.append((name, row["largest_force"], *(f"{f:.5f}" for f in forces), row["off_at"]))
    print("\n".join(" ".join(row) for row in rows))
    if o.write:
        write_rows("readings.csv", rows)


def reached(at, x, y):
    """y where x first reaches `at`; x may also decrease, as the lift does in a snap-back."""
    ahead = np.append(True, x[1:] > np.maximum.accumulate(x)[:-1])
    return np.interp(at, x[ahead], y[ahead])


def roughness(lift, force):
    """Root mean square of the force about its moving average over a lift of 4, for lifts of 4 to
    20.
    """
    x = np.linspace(4, min(20, lift.max()), 400)
    f = reached(x, lift, force)
    width = max(1, int(4 / (x[1] - x[0])))
    mean = np.convolve(f, np.ones(width) / width, mode="valid")
    inner = f[width // 2 : width // 2 + len(mean)]
    return np.sqrt(np.mean((inner - mean) ** 2))


def apart(write):
    """Compare committed curves up to a lift of 15.5, relative to the largest force of the second
    curve.
    """
    rows = [("mesh", "elements", "of_mesh", "of_elements", "rms", "largest", "of_the_peaks")]
    x = np.linspace(0, LIFT, 500)
    for pair in PAIRS:
        files = [DECKS / f"runs/{'_'.join(case)}.dat" for case in pair]
        if not all(f.exists() for f in files):
            continue
        a, b = (
            reached(x, c["disp_3"], c["force_3"]) for c in (read_table(f).columns for f in files)
        )
        off, peak = np.abs(a - b) / b.max(), a.max() / b.max() - 1
        numbers = (f"{v:.1%}" for v in (np.sqrt(np.mean(off**2)), off.max(), peak))
        rows.append((*pair[0], *pair[1], *numbers))
    print("\n".join(" ".join(row) for row in rows))
    if write:
        write_rows("apart.csv", rows)
    return 0


def write_rows(name, rows):
    with (DECKS / "runs" / name).open("w", newline="") as text:
        csv.writer(text, lineterminator="\n").writerows(rows)


def beside(o):
    """Compare the forces of mesh 1 with the independent ones, which are computed with two half
    passes; ours are computed both with points that load both surfaces and with two half passes.
    """
    with PEELING.open(newline="") as text:
        theirs = list(csv.DictReader(line for line in text if not line.startswith("#")))
    rows = [
        ("elements", "lift", "independent", "ours", "difference", "half_passes", "half_difference")
    ]
    for column, name in COMPARED.items():
        places = [place_of(o, "1", name) / f"{name}_peel.dat"]
        places += [half_of(o, name) / f"half_{name}_peel.dat"]
        curves = [read_table(p).columns for p in places]
        for row in theirs:
            lift, other = float(row["u"]), float(row[column])
            ours = [reached(lift, c["disp_3"], c["force_3"]) for c in curves]
            cells = [x for f in ours for x in (f"{f:.5f}", f"{f / other - 1:.1%}")]
            rows.append((column, f"{lift:g}", f"{other:.5f}", *cells))
    print("\n".join(" ".join(row) for row in rows))
    if o.write:
        write_rows("beside.csv", rows)


def write(mesh, name, place):
    """Write the curve of a case with few digits."""
    runs = DECKS / "runs"
    runs.mkdir(exist_ok=True)
    c = read_table(place / f"{name}_peel.dat").columns
    lines = ["# " + " ".join(KEPT)]
    lines += [" ".join(f"{x:.8g}" for x in line) for line in zip(*(c[k] for k in KEPT))]
    (runs / f"{mesh}_{name}.dat").write_text("\n".join(lines) + "\n")


def write_summary(rows):
    """Write summary.csv, in which these rows replace those of the same cases."""
    file, known = DECKS / "runs/summary.csv", {}
    if file.exists():
        with file.open(newline="") as text:
            known = {(r["mesh"], r["elements"]): r for r in csv.DictReader(text)}
    known.update({(r["mesh"], r["elements"]): r for r in rows})
    with file.open("w", newline="") as text:
        table = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
        table.writeheader()
        table.writerows(known[k] for k in sorted(known, key=lambda k: (k[0], TYPES.index(k[1]))))


def parser():
    p = argparse.ArgumentParser(
        prog="python -m verification.section5_debonding", description=__doc__.split("\n")[0]
    )
    p.add_argument("--bezel", default=str(TOP / "build/release/bezel"), metavar="PROGRAM")
    p.add_argument("--mesh", nargs="+", choices=list(TABLE_2), default=["1"])
    p.add_argument("--suite", choices=list(SUITES), help="run a suite of cases instead of --mesh")
    p.add_argument(
        "--pictures", action="store_true", help="also run the decks of Figures 13 and 14"
    )
    p.add_argument(
        "--readings", action="store_true", help="also run other interpretations of the problem"
    )
    p.add_argument("--apart", action="store_true", help="only compare committed curves")
    p.add_argument("--only", nargs="+", default=[], choices=TYPES, metavar="NAME")
    p.add_argument("--jobs", type=int, default=1, metavar="N", help="number of simultaneous runs")
    p.add_argument(
        "--steps",
        type=int,
        metavar="N",
        help="stop after N steps, each of which is a lift of 0.155",
    )
    p.add_argument(
        "--time-limit", type=int, default=7200, metavar="S", help="seconds that a run may take"
    )
    p.add_argument(
        "--out", type=pathlib.Path, default=TOP / "build/section5_debonding", metavar="DIR"
    )
    p.add_argument("--force", action="store_true", help="run complete cases again")
    p.add_argument("--write", action="store_true", help="update the committed tables")
    return p


if __name__ == "__main__":
    sys.exit(main())
