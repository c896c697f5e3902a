"""Stop and restart a run, and compare it bit for bit with the uninterrupted run.

    .venv/bin/python -m verification.restart.run BEZEL [--kills N] [--deck NAME]

1. SIGTERM during the run gives exit code 4; after --restart, curves and fields are equal.
2. --time-limit does the same, with as many restarts as needed.
3. After kill -9 at random moments, every row and field written before the kill is readable, the
   last checkpoint can be restarted, and the restarted run ends like the uninterrupted one.
4. A restart from a checkpoint older than the results truncates the results to the checkpoint, even
   if it is stopped before its first step; when continued, it ends like the uninterrupted run.
5. If files cannot grow beyond a certain size, as on a full disk, the exit code is 3.

It prints one line per check, then `N passed, N failed`. It needs h5py, which is in the project's
.venv.
"""

import argparse
import json
import pathlib
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time

import h5py
import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
DECKS = [
    "full.inp",
    "reuse.inp",
    "contact.inp",
    "cells.inp",
    "peel.inp",
    "local.inp",
    "length.inp",
    "spline.inp",
    "loose.inp",
    "self.inp",
]


def run(bezel, deck, out, *options, wait=None, how=signal.SIGTERM, room=None):
    """Run a deck and return the exit code; `wait`: seconds after which to send the signal `how`;
    `room`: largest size of a file in bytes.
    """
    limit = room and (lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (room, room)))
    process = subprocess.Popen(
        [bezel, "--quiet", "-o", str(out), *options, str(HERE / deck)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        preexec_fn=limit,
    )
    if wait is not None:
        time.sleep(wait)
        process.send_signal(how)
    return process.wait()


def fields(path):
    """All datasets of a result file: {name: array}."""
    found = {}
    with h5py.File(path) as file:
        file.visititems(
            lambda name, item: (
                found.update({name: item[...]}) if isinstance(item, h5py.Dataset) else None
            )
        )
    return found


def same(a, b, stem):
    """The reason why the curves or fields in two folders differ, or None."""
    if (a / f"{stem}_force.dat").read_bytes() != (b / f"{stem}_force.dat").read_bytes():
        return "the curves differ"
    for path in [a / f"{stem}.pvd", *sorted(a.glob(f"{stem}_*.vtu"))]:
        if not (b / path.name).exists() or path.read_bytes() != (b / path.name).read_bytes():
            return f"{path.name} differs"
    left, right = fields(a / f"{stem}.vtkhdf"), fields(b / f"{stem}.vtkhdf")
    if left.keys() != right.keys():
        return "the result files contain different datasets"
    for name in left:
        one, other = left[name], right[name]
        if one.shape != other.shape:
            return f"the fields differ in the size of {name}: {one.shape} and {other.shape}"
        if one.tobytes() != other.tobytes():
            rows = np.unique(np.nonzero(one != other)[0])
            return f"the fields differ in {len(rows)} rows of {name}, of which the first are {rows[:3]}"
    return None


def whole(folder, stem):
    """After a kill, check that the rows and fields written so far are readable."""
    curve, result = folder / f"{stem}_force.dat", folder / f"{stem}.vtkhdf"
    if curve.exists() and len(curve.read_text().splitlines()) > 1:
        lines = [
            line for line in curve.read_text().splitlines(keepends=True) if line.endswith("\n")
        ]
        rows = np.loadtxt(lines, ndmin=2)
        if not np.isfinite(rows).all():
            return "a row contains a number that is not finite"
    if result.exists():
        try:
            fields(result)
        except OSError as error:
            return f"the result file cannot be read: {error}"
    return None


def stop_behind(bezel, deck, folder):
    """Restart a finished run from its second-to-last checkpoint and stop it immediately."""
    stem = pathlib.Path(deck).stem
    checkpoint = folder / f"{stem}.restart.h5"
    with h5py.File(checkpoint, "r+") as file:
        del file["last"]
        file.move("before", "last")
        step = int(file["last/step"][0])
    code = run(bezel, deck, folder, "--time-limit", "1e-9", "--restart", str(checkpoint))
    if code != 4:
        return f"exit code {code}"
    rows = np.loadtxt(folder / f"{stem}_force.dat", ndmin=2)[:, 0]
    number = fields(folder / f"{stem}.vtkhdf")["VTKHDF/Steps/StepNumber"]
    if rows[-1] != step or max(number) > step:
        return f"step {step}, a last row {rows[-1]:.0f} and last fields {max(number)}"
    return None


def go_on(bezel, deck, folder):
    """Restart from the checkpoint, or from the deck if there is no checkpoint yet."""
    checkpoint = folder / f"{pathlib.Path(deck).stem}.restart.h5"
    return run(
        bezel, deck, folder, *(["--restart", str(checkpoint)] if checkpoint.exists() else [])
    )


def main():
    parser = argparse.ArgumentParser(
        prog="python -m verification.restart.run", description=__doc__.splitlines()[0]
    )
    parser.add_argument("bezel")
    parser.add_argument("--kills", type=int, default=4)
    parser.add_argument("--deck", action="append", choices=DECKS, help="run only this deck")
    args = parser.parse_args()
    random.seed(1)
    passed = failed = 0

    def report(text, trouble):
        nonlocal passed, failed
        passed, failed = passed + (trouble is None), failed + (trouble is not None)
        print(
            f"{'ok    ' if trouble is None else 'FAILED'} {text}{'' if trouble is None else ': ' + trouble}"
        )

    with tempfile.TemporaryDirectory() as top:
        for deck in args.deck or DECKS:
            stem, top_path = pathlib.Path(deck).stem, pathlib.Path(top)
            whole_run = top_path / f"{stem}_whole"
            begin = time.time()
            code = run(args.bezel, deck, whole_run)
            seconds = time.time() - begin
            report(
                f"{stem}: uninterrupted, {seconds:.1f} s",
                None if code == 0 else f"exit code {code}",
            )
            if code != 0:
                continue
            part = top_path / f"{stem}_term"
            code = run(args.bezel, deck, part, wait=0.5 * seconds)
            report(f"{stem}: SIGTERM ends with code 4", None if code == 4 else f"exit code {code}")
            code = go_on(args.bezel, deck, part)
            report(
                f"{stem}: restarted after SIGTERM",
                same(whole_run, part, stem) if code == 0 else f"exit code {code}",
            )
            part = top_path / f"{stem}_limit"
            limit = 0.4 * seconds
            codes = [run(args.bezel, deck, part, "--time-limit", f"{limit:.3f}")]
            while codes[-1] == 4 and len(codes) < 20:
                limit *= 1.2  # other work may slow the machine down now
                codes.append(
                    run(
                        args.bezel,
                        deck,
                        part,
                        "--time-limit",
                        f"{limit:.3f}",
                        "--restart",
                        str(part / f"{stem}.restart.h5"),
                    )
                )
            trouble = (
                f"exit codes {codes}"
                if codes[0] != 4 or codes[-1] != 0
                else same(whole_run, part, stem)
            )
            report(f"{stem}: --time-limit, {len(codes)} parts", trouble)
            for kill in range(args.kills):
                part = top_path / f"{stem}_kill{kill}"
                run(
                    args.bezel,
                    deck,
                    part,
                    wait=random.uniform(0.1, 0.95) * seconds,
                    how=signal.SIGKILL,
                )
                trouble = whole(part, stem) if part.exists() else None
                if trouble is None:
                    code = go_on(args.bezel, deck, part)
                    trouble = same(whole_run, part, stem) if code == 0 else f"exit code {code}"
                report(f"{stem}: killed {kill + 1} of {args.kills}", trouble)
                shutil.rmtree(part, ignore_errors=True)
            part = top_path / f"{stem}_behind"
            shutil.copytree(whole_run, part)
            trouble = stop_behind(args.bezel, deck, part)
            if trouble is None:
                code = go_on(args.bezel, deck, part)
                trouble = same(whole_run, part, stem) if code == 0 else f"exit code {code}"
            report(f"{stem}: from a checkpoint older than the results", trouble)
            code = go_on(args.bezel, deck, part)  # no step is left
            ends = [
                json.loads((at / f"{stem}.report.json").read_text()) for at in (whole_run, part)
            ]
            trouble = None if code == 0 else f"exit code {code}"
            if trouble is None and any(
                ends[0].get(k) != ends[1].get(k) for k in ("final", "contacts")
            ):
                trouble = "the reports differ"
            report(f"{stem}: from its end", trouble or same(whole_run, part, stem))
            size = max(file.stat().st_size for file in whole_run.iterdir())
            for share in (0.01, 0.1, 0.3, 0.6, 0.9):
                code = run(args.bezel, deck, top_path / "full_disk", room=int(share * size))
                report(
                    f"{stem}: files of {share:.0%} of their size",
                    None if code == 3 else f"exit code {code}",
                )
                shutil.rmtree(top_path / "full_disk", ignore_errors=True)
    print(f"{passed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
