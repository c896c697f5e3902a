"""Run the verification cases and compare their results with references.

    python3 -m verification.verify [--bezel build/release/bezel] [--case NAME] [--all] [--study] [--recover]

A case is a folder of verification/patch, benchmark, contact or trouble with decks and an
expect.toml, whose keys are described in post/_expect.py. Results go into build/verify/<case>/. All
checks are made even if some fail. The result is one table, whose last line gives the numbers of
passed and failed checks. The exit code is 0 only if at least one check was made and none failed.
The program needs numpy, and h5py for checks of fields.
"""

import argparse
import concurrent.futures
import os
import pathlib
import shutil
import sys
import time

from verification import TOP, need_numpy

need_numpy()

from post import _emit  # noqa: E402
from post._error import Unreadable  # noqa: E402
from post._expect import read_expect  # noqa: E402
from verification import checks, recover, studies  # noqa: E402

ROOTS = tuple(TOP / "verification" / name for name in ("patch", "benchmark", "contact", "trouble"))


def main(argv=None):
    """Read the cases, run them in parallel, print the table; return the exit code."""
    o = parser().parse_args(argv)
    bezel = pathlib.Path(o.bezel).resolve()
    cases, rows = read_cases(o.case)
    plans = []
    for folder, expect in cases:
        wanted = [] if o.study else [c for c in expect["checks"] if o.all or not c.get("slow")]
        plans += [checks.plan_check(folder, c) for c in wanted]
        plans += studies.plan_studies(folder, expect["studies"], o.all)
    runs = {run.name: run for plan in plans for run in plan.runs}
    if runs and not os.access(bezel, os.X_OK):
        print(
            f"verify: error: '{bezel}' is not an executable program; build it with `make`, or name it with --bezel",
            file=sys.stderr,
        )
        print(f"0 passed, {len(plans)} failed")
        return 1
    out = pathlib.Path(o.out).resolve()
    if o.recover:
        rows += recover_all(bezel, out / "recover", list(runs.values()), o.jobs)
        return report(rows)
    for folder, _ in cases:
        shutil.rmtree(out / folder.name, ignore_errors=True)
    outcomes = run_all(bezel, out, list(runs.values()), o.jobs)
    for plan in plans:
        rows += plan.judge(out, outcomes)
    if o.study or o.all:
        studies.write_tables(plans)
    if o.json:
        pathlib.Path(o.json).write_text(checks.as_json(rows), encoding="utf-8")
    return report(rows)


def read_cases(names):
    """([(folder, expectation)], rows of those cases that cannot be read)"""
    known = [
        f
        for root in ROOTS
        if root.is_dir()
        for f in sorted(root.iterdir())
        if (f / "expect.toml").exists()
    ]
    cases, rows = [], []
    for name in names or []:
        if name not in [f.name for f in known]:
            have = " ".join(f.name for f in known)
            rows.append(checks.failed(name, "case", f"unknown case (cases: {have})"))
    for folder in known:
        if not names or folder.name in names:
            try:
                cases.append((folder, read_expect(folder / "expect.toml")))
            except Unreadable as error:
                rows.append(checks.failed(folder.name, "expect.toml", str(error)))
    return cases, rows


def run_all(bezel, out, runs, jobs):
    """{name of the run: Outcome}. The progress is shown in one line on a terminal; otherwise a line
    is written every ten seconds.
    """
    outcomes = {}
    said = time.monotonic()
    with concurrent.futures.ThreadPoolExecutor(max_workers=max(1, jobs)) as pool:
        waiting = {pool.submit(checks.execute, bezel, out, run): run for run in runs}
        for done in concurrent.futures.as_completed(waiting):
            outcomes[waiting[done].name] = done.result()
            if sys.stderr.isatty():
                print(f"\r{len(outcomes)} of {len(runs)} runs", end="", file=sys.stderr)
            elif time.monotonic() - said > 10:
                said = time.monotonic()
                print(f"{len(outcomes)} of {len(runs)} runs", file=sys.stderr, flush=True)
    if sys.stderr.isatty():
        print("\r", end="", file=sys.stderr)
    return outcomes


def recover_all(bezel, out, runs, jobs):
    """Rows of all runs, each stopped and restarted; on a terminal the progress is shown."""
    rows = []
    with concurrent.futures.ThreadPoolExecutor(max_workers=max(1, jobs)) as pool:
        work = [pool.submit(recover.recover, bezel, out, run) for run in runs]
        for i, one in enumerate(work):
            rows += [one.result()] if one.result() else []
            if sys.stderr.isatty():
                print(f"\r{i + 1} of {len(runs)} runs", end="", file=sys.stderr)
    if sys.stderr.isatty():
        print("\r", end="", file=sys.stderr)
    return rows


def report(rows):
    """Print the table and its last line; return 0 if at least one check passed and none failed."""
    heading = ("case", "quantity", "got", "wanted", "difference", "tolerance", "ok")
    lines = [heading] + [
        (r.case, r.quantity, *r.numbers(), "ok" if r.ok else "FAILED") for r in rows
    ]
    print("\n".join(line[2:] for line in _emit._aligned(lines)))
    for row in rows:
        if row.reason:
            print(f"{row.case}, {row.quantity}: {row.reason}")
    bad = sum(not r.ok for r in rows)
    if not rows:
        print("no check matches the options")
    print(f"{len(rows) - bad} passed, {bad} failed")
    return 0 if rows and not bad else 1


def parser():
    p = argparse.ArgumentParser(
        prog="python -m verification.verify",
        description="Run the verification cases and compare the results with their references.",
    )
    p.add_argument(
        "--bezel",
        default=str(TOP / "build/release/bezel"),
        metavar="PROGRAM",
        help="(default build/release/bezel)",
    )
    p.add_argument("--all", action="store_true", help="also make the slow checks")
    p.add_argument(
        "--case", action="append", metavar="NAME", help="run only this case; may be repeated"
    )
    p.add_argument(
        "--study",
        action="store_true",
        help="run only the refinement studies and rewrite results.csv of each case",
    )
    p.add_argument(
        "--jobs",
        type=int,
        default=min(2, os.cpu_count() or 1),
        metavar="N",
        help="number of simultaneous runs (default 2)",
    )
    p.add_argument(
        "--out",
        default=str(TOP / "build/verify"),
        metavar="DIR",
        help="folder for the runs (default build/verify)",
    )
    p.add_argument(
        "--recover",
        action="store_true",
        help="instead of making the checks, stop each of their runs in the middle and restart it: its "
        "results must equal those of the uninterrupted run bit for bit",
    )
    p.add_argument("--json", metavar="FILE", help="write the table as JSON")
    return p


if __name__ == "__main__":
    sys.exit(main())
