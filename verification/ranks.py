"""Run decks on several ranks of `make MPI=1` and compare them with the serial program.

    .venv/bin/python -m verification.ranks --bezel build/mpi/bezel --serial build/release/bezel

1. On one rank, curves and fields must equal those of the serial program bit for bit.
2. On several ranks, steps, iterations and cut-backs must be those of the serial program, and curves
   may differ by at most 1e-9 of the largest value of their column (for exceptions see GAPS).
3. After kill -9 of one rank or of all ranks, after a signal, and after --time-limit, the run must
   continue on another number of ranks and end like an uninterrupted one.

It prints one line per check, then `N passed, N failed`. There may be more ranks than processors.
"""

import argparse
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

import numpy as np

from verification import TOP
from verification.restart.run import fields, whole

RESTART = TOP / "verification" / "restart"
#: name: (deck, further arguments); the quick decks come first
DECKS = {
    "cube": (TOP / "input" / "cube_q1.inp", []),
    "contact_patch": (TOP / "verification/patch/contact_mortar/turned_q1e9.inp", []),
    "kept_factors": (
        TOP / "verification/performance/cube.inp",
        ["--set", "n=13", "--set", "steps=2"],
    ),
    "peel": (RESTART / "peel.inp", []),
    "reuse": (RESTART / "reuse.inp", []),
    "length": (RESTART / "length.inp", []),
    "spline": (RESTART / "spline.inp", []),
    "loose": (RESTART / "loose.inp", []),
    "local": (RESTART / "local.inp", []),
    "self": (RESTART / "self.inp", []),
    "contact": (RESTART / "contact.inp", []),
    "cells": (RESTART / "cells.inp", []),
}
QUICK = 4
FAULTS = "contact"  #: the deck used for kills, signals and limits
#: Where friction is at its limit, round-off decides whether a point sticks, and the sticking area
#: changes by the area of that point.
GAPS = {"self": 1e-8}
#: Number of rows that are compared, if not all. In the last eleven steps of `local`, no
#: bond holds the strip any more, and it turns freely about the edge that is lifted, so that errors
#: of rounding move it: if the lift of the serial program changes by a part in 1e14, the force changes
#: by up to 6e-10 and the kinetic energy by 2e-8, and the number of iterations depends on rounding. In
#: the rows before, no column changes by more than 1e-12.
ROWS = {"local": 50}
CLOSE = 1e-9  #: allowed difference of a curve, relative to the largest value in the column
COUNTS = ("step", "iterations", "cutbacks", "converged")
MPIRUN = ["mpirun", "--allow-run-as-root", "--oversubscribe", "--quiet"]
MPIRUN += ["--mca", "mpi_yield_when_idle", "1"]


class Program:
    """The serial program, and the program for several ranks."""

    def __init__(self, bezel, serial):
        self.bezel, self.serial = str(bezel), str(serial)

    def start(self, nrank, deck, out, *options):
        """Start a run on the given number of ranks, where 0 means the serial program; return the
        process.
        """
        command = [*MPIRUN, "-n", str(nrank), self.bezel] if nrank else [self.serial]
        return subprocess.Popen(
            [*command, "--quiet", "-o", str(out), *options, str(deck)],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )

    def run(self, *args):
        """Return the exit code of a run."""
        return self.start(*args).wait()

    def restart(self, nrank, deck, out):
        """Continue a run from its checkpoint, or start it anew if it has none."""
        checkpoint = out / f"{deck.stem}.restart.h5"
        return self.run(
            nrank, deck, out, *(["--restart", str(checkpoint)] if checkpoint.exists() else [])
        )


def ranks_of(process):
    """The processes (one per rank) that an mpirun has started."""
    path = pathlib.Path(f"/proc/{process.pid}/task/{process.pid}/children")
    return [int(child) for child in path.read_text().split()]


def steps_in(folder):
    """Number of steps in the curves of a run; 0 if there is no curve yet."""
    return max((path.read_text().count("\n") - 1 for path in folder.glob("*.dat")), default=0)


def wait_for_steps(process, folder, steps):
    """Wait until a run has written this number of steps; return whether it is still running. How
    long this takes depends on what else the computer does.
    """
    while steps_in(folder) < steps and process.poll() is None:
        time.sleep(0.02)
    return process.poll() is None


def curves(folder):
    return sorted(path.name for path in folder.glob("*.dat"))


def same(a, b):
    """The reason why the curves or fields in two folders are not equal bit for bit, or None."""
    if curves(a) != curves(b):
        return f"curves {curves(a)} and {curves(b)}"
    for name in curves(a):
        if (a / name).read_bytes() != (b / name).read_bytes():
            return f"{name} differs"
    for path in a.glob("*.vtkhdf"):
        left, right = fields(path), fields(b / path.name)
        for name in left:
            if name not in right or left[name].tobytes() != right[name].tobytes():
                return f"{path.name} differs in {name}"
    return None


def close(a, b, tolerance=CLOSE, rows=None):
    """Compare the curves of two folders, or their first `rows`; return (reason why they are not
    close, or None; their largest difference).
    """
    if curves(a) != curves(b):
        return f"curves {curves(a)} and {curves(b)}", 0.0
    worst = 0.0
    for name in curves(a):
        head = (a / name).read_text().split("\n", 1)[0].lstrip("#").split()
        left, right = (np.loadtxt(at / name, ndmin=2)[:rows] for at in (a, b))
        if left.shape != right.shape:
            return f"{name} has {len(left)} and {len(right)} rows", worst
        for column, values, others in zip(head, left.T, right.T, strict=True):
            if column in COUNTS and (values != others).any():
                return f"{column} differ in row {np.argmax(values != others) + 1} of {name}", worst
            scale = np.abs(values).max()
            if column.startswith("book_"):  # small differences of large numbers
                scale = max(np.abs(v).max() for n, v in zip(head, left.T) if n.startswith("book_"))
            if scale > 0 and column not in COUNTS:
                worst = max(worst, np.abs(values - others).max() / scale)
    return (None if worst <= tolerance else f"curves differ by {worst:.1e}"), worst


class Driver:
    def __init__(self, program, top):
        self.program, self.top = program, top
        self.passed = self.failed = 0

    def report(self, text, trouble):
        self.passed, self.failed = (
            self.passed + (trouble is None),
            self.failed + (trouble is not None),
        )
        print(
            f"{'ok    ' if trouble is None else 'FAILED'} {text}{': ' + trouble if trouble else ''}"
        )
        sys.stdout.flush()

    def compare(self, name, ranks):
        """Compare runs on several numbers of ranks with the serial program."""
        deck, options = DECKS[name]
        serial = self.top / f"{name}_serial"
        code = self.program.run(0, deck, serial, *options)
        if code:
            return self.report(f"{name}: serial", f"exit code {code}")
        for nrank in ranks:
            out = self.top / f"{name}_{nrank}"
            begin = time.time()
            code = self.program.run(nrank, deck, out, *options)
            text = f"{name}: {nrank} rank{'s' * (nrank > 1)}, {time.time() - begin:.1f} s"
            if code:
                trouble = f"exit code {code}"
            elif nrank == 1:
                trouble = same(serial, out)
            else:
                trouble, worst = close(serial, out, GAPS.get(name, CLOSE), ROWS.get(name))
                text += f", differs by {worst:.0e}"
            self.report(text, trouble)
            shutil.rmtree(out, ignore_errors=True)
        return None

    def check_faults(self):
        """Interrupt runs on three ranks by kills, signals and limits; continue them on other
        numbers of ranks.
        """
        deck, _ = DECKS[FAULTS]
        serial = self.top / f"{FAULTS}_faults"
        self.program.run(0, deck, serial)
        steps = steps_in(serial)
        begin = time.time()
        self.report("faults: 3 ranks", self.ends(self.program.run(3, deck, self.top / "f3"), 0))
        seconds = time.time() - begin
        for text, nrank, hit in (
            ("kill -9 of the first rank", 2, lambda pids: [(pids[0], signal.SIGKILL)]),
            ("kill -9 of the last rank", 1, lambda pids: [(pids[-1], signal.SIGKILL)]),
            ("kill -9 of all ranks", 2, lambda pids: [(pid, signal.SIGKILL) for pid in pids]),
            ("SIGTERM of the last rank", 2, lambda pids: [(pids[-1], signal.SIGTERM)]),
            ("SIGUSR1 of mpirun", 2, lambda pids: []),
        ):
            out = self.top / text.replace(" ", "_")
            process = self.program.start(3, deck, out)
            if not wait_for_steps(process, out, int(random.uniform(0.4, 0.7) * steps)):
                self.report(f"faults: {text}", f"ended too early with exit code {process.wait()}")
                continue
            try:
                for pid, number in hit(ranks_of(process)) or [(process.pid, signal.SIGUSR1)]:
                    os.kill(pid, number)
                code = process.wait(timeout=120)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)
                self.report(f"faults: {text}", "the run does not end")
                continue
            trouble = whole(out, deck.stem)
            if "SIG" in text and code != 4:
                trouble = f"exit code {code}"
            self.report(f"faults: {text}", trouble)
            self.finish(f"{text}, then {nrank} ranks", nrank, deck, out, serial)
        out = self.top / "limit"
        self.report("faults: --time-limit", self.ends(self.stop_by_limit(deck, out, seconds), 4))
        self.finish("--time-limit, then 2 ranks", 2, deck, out, serial)
        out = self.top / "serial_first"
        self.program.run(0, deck, out, "--time-limit", "1")
        self.finish("serial, then 3 ranks", 3, deck, out, serial)
        out = self.top / "serial_last"
        self.stop_by_limit(deck, out, seconds)
        self.finish("3 ranks, then serial", 0, deck, out, serial)

    def stop_by_limit(self, deck, out, seconds):
        """Stop a run on three ranks by --time-limit, and return its exit code. An earlier run took
        `seconds`. If the run ends before a quarter of this time, because the computer has less else
        to do now, the limit is halved until it stops the run.
        """
        limit = 0.25 * seconds
        for _ in range(5):
            code = self.program.run(3, deck, out, "--time-limit", f"{limit:.2f}")
            if code != 0:
                break
            limit /= 2
        return code

    def ends(self, code, expected):
        return None if code == expected else f"exit code {code}"

    def finish(self, text, nrank, deck, out, serial):
        """Continue a run, and compare its end with that of an uninterrupted one."""
        code = self.program.restart(nrank, deck, out)
        trouble, _ = close(serial, out) if code == 0 else (f"exit code {code}", 0)
        self.report(f"faults: {text}", trouble)


def main():
    parser = argparse.ArgumentParser(
        prog="python -m verification.ranks", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--bezel", type=pathlib.Path, default=TOP / "build/mpi/bezel")
    parser.add_argument("--serial", type=pathlib.Path, default=TOP / "build/release/bezel")
    parser.add_argument("--ranks", type=int, nargs="+", default=[1, 2, 3])
    parser.add_argument("--deck", action="append", choices=DECKS, help="run only this deck")
    parser.add_argument(
        "--quick", action="store_true", help=f"run the first {QUICK} decks, no faults"
    )
    parser.add_argument("--faults", action="store_true", help="run only the faults")
    args = parser.parse_args()
    random.seed(1)
    with tempfile.TemporaryDirectory() as top:
        driver = Driver(Program(args.bezel, args.serial), pathlib.Path(top))
        if not args.faults:
            for name in args.deck or list(DECKS)[: QUICK if args.quick else None]:
                driver.compare(name, args.ranks)
        if not (args.quick or args.deck):
            driver.check_faults()
    print(f"{driver.passed} passed, {driver.failed} failed")
    return 1 if driver.failed else 0


if __name__ == "__main__":
    sys.exit(main())
