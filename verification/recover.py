"""Stop runs before a given command, restart them, and compare them with the uninterrupted runs.

`verify --recover` does this for the runs of the quick checks. The environment variable BEZEL_STOP=n
stops a run before its n-th command, in the way a signal would; such a stop can be repeated exactly.
"""

import json
import os
import shutil
import subprocess

import numpy as np

from post._error import Unreadable
from verification.checks import Row

STOPPED = 4  # exit code
COUNTS = ("exit_code", "iterations", "cutbacks", "steps", "final", "contacts", "equilibrium")


def run(bezel, run, place, *options, stop=None):
    """The exit code of one call of the program, stopped before command number `stop` if given."""
    place.mkdir(parents=True, exist_ok=True)
    command = [str(bezel), "--quiet", "-o", str(place), *run.options, *options]
    for setting in run.settings:
        command += ["--set", setting]
    env = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", **os.environ}
    env.pop("BEZEL_STOP", None)
    if stop:
        env["BEZEL_STOP"] = str(stop)
    try:
        done = subprocess.run(
            [*command, str(run.deck)], cwd=place, env=env, timeout=run.time_limit,
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, check=False)  # fmt: skip
    except subprocess.TimeoutExpired as error:
        raise Unreadable(f"took longer than {run.time_limit:g} s") from error
    return done.returncode


def datasets(path):
    """All datasets of a result file: {name: array}."""
    import h5py

    found = {}
    with h5py.File(path) as file:
        file.visititems(
            lambda name, item: (
                found.update({name: item[...]}) if isinstance(item, h5py.Dataset) else None
            )
        )
    return found


def difference(one, other, stem):
    """The reason why the results in two folders are not equal bit for bit, or None."""
    if (other / f"{stem}.out").exists() and not (one / f"{stem}.out").exists():
        return f"{stem}.out is left over"
    kinds = (f"{stem}_*.dat", f"{stem}.out", f"{stem}*.pvd", "*.vtu")
    for path in sorted(path for kind in kinds for path in one.glob(kind)):
        if not (other / path.name).exists():
            return f"{path.name} is missing"
        if path.read_bytes() != (other / path.name).read_bytes():
            return f"{path.name} differs"
    for path in sorted(one.glob(f"{stem}*.vtkhdf")):
        if not (other / path.name).exists():
            return f"{path.name} is missing"
        left, right = datasets(path), datasets(other / path.name)
        if left.keys() != right.keys():
            return f"{path.name} contains other datasets"
        for name in left:
            if left[name].shape != right[name].shape:
                return f"{path.name}: {name} has a different size"
            if left[name].tobytes() != right[name].tobytes():
                rows = np.unique(np.nonzero(left[name] != right[name])[0])
                return f"{path.name}: {name} differs in {len(rows)} rows, the first is {rows[:1]}"
    left, right = (json.loads((at / f"{stem}.report.json").read_text()) for at in (one, other))
    if sorted(left["warnings"]) != sorted(right["warnings"]):
        return "the reports differ in warnings"
    for name in COUNTS:
        if left.get(name) != right.get(name):
            return f"the reports differ in {name}"
    return None


def is_current(report, bezel, folder):
    """Were a report of `verify` and all files beside it written after the program and the files of
    the case changed? The tables that `verify` itself writes there do not count.
    """
    files = [path for path in folder.rglob("*") if path.is_file() and path.name != "results.csv"]
    changed = max(path.stat().st_mtime for path in [bezel, *files])
    if not report.exists():
        return False
    made = [path for path in report.parent.iterdir() if path.is_file()]
    return min(path.stat().st_mtime for path in made) > changed


def recover(bezel, out, run_, parts=3):
    """Stop a run several times, continue it each time, and compare its results with the
    uninterrupted run, which may be one that `verify` has made. Return a row of the table, or None
    if the deck is rejected or the run stops by itself.
    """
    folder, made = out / run_.name, out.parent / run_.name
    whole, broken = folder / "whole", folder / "stopped"
    stem = run_.deck.stem
    row = Row(run_.name.split("/")[0], f"restart of {run_.name.split('/')[1]}", tolerance="equal")
    shutil.rmtree(folder, ignore_errors=True)
    try:
        if is_current(made / f"{stem}.report.json", bezel, run_.deck.parent):
            whole = made
            wanted = json.loads((made / f"{stem}.report.json").read_text())["exit_code"]
        else:
            wanted = run(bezel, run_, whole)
        if wanted in (1, STOPPED):
            return None
        report = json.loads((whole / f"{stem}.report.json").read_text())
        stop = max(1, report["iterations"] + 2 * report["steps"])  # about half of the commands
        stops = []
        code = run(bezel, run_, broken, stop=stop)
        while code == wanted and stop > 1:  # the run ended earlier, since it has fewer commands
            shutil.rmtree(broken)
            stop = stop // 2
            code = run(bezel, run_, broken, stop=stop)
        while code == STOPPED:
            stops.append(stop)
            stop = 1 + stop // 3
            checkpoint = broken / f"{stem}.restart.h5"
            code = run(
                bezel, run_, broken, "--restart", str(checkpoint),
                stop=stop if len(stops) < parts - 1 else None,
            )  # fmt: skip
        row.got, row.want = f"{len(stops)} stops", "equal"
        if not stops:
            row.reason = "the run could not be stopped"
        elif code != wanted:
            row.reason = (
                f"exit code {code} after stops at {stops}; the uninterrupted run has {wanted}"
            )
        else:
            row.reason = difference(whole, broken, stem) or ""
            row.reason = row.reason and f"stops at {stops}: {row.reason}"
    except (Unreadable, OSError, ValueError) as error:
        row.reason = str(error)
    row.ok = not row.reason
    if row.ok:
        shutil.rmtree(folder, ignore_errors=True)
    return row
