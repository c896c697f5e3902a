"""Change the Fortran source in one place at a time and count the changes that the tests notice.

    python -m verification.mutate_source [-n 200] [--seed 1] [--jobs 2] [--out build/mutate_source]
                                         [--only PATTERN ...] [--write]

A mutant is a copy of the program in which one operator, constant, condition or statement of a file
of AREAS is changed. Each is built in a copy of the tree and goes through the stages of STAGES, in
this order, until one of them fails or lasts longer than LATEST times as long as without a change.
A mutant that passes them all has survived. Mutants that do not compile, and those whose program is
the same byte for byte, are not counted.

The mutants of a seed are always the same for the same source. The table OUT/mutants.csv is written
as the run proceeds, and a run that was interrupted continues from it. With --write it is also
copied to verification/mutants.csv, in which the column `reason` of a survivor is kept.
"""

from __future__ import annotations

import argparse
import concurrent.futures
import csv
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

TOP = Path(__file__).resolve().parent.parent
TABLE = TOP / "verification/mutants.csv"
#: Files that are changed: contact with its laws, energies, and what follows a path.
AREAS = (
    "src/contact/*.f90",
    "src/solution/energy_*.f90",
    "src/solution/continuation*.f90",
    "src/solution/step*.f90",
    "src/solution/newton.f90",
    "src/solution/line_search.f90",
    "src/solution/secant_friction.f90",
    "src/solution/friction_limit.f90",
    "src/solution/stabilisation.f90",
    "src/solution/predictor.f90",
    "src/solution/prescribed.f90",
)
VERIFY = [sys.executable, "-m", "verification.verify", "--jobs", "1"]
#: Stages of tests: name, and command in the copy of the tree. All but the last belong to `make check`.
STAGES = (
    ("unit", ["make", "-s", "unit"]),
    ("patch", ["make", "-s", "patch"]),
    ("silent", [*VERIFY, "--case", "silent"]),
    ("reference", ["make", "-s", "reference"]),
    ("trouble", ["make", "-s", "trouble"]),
    ("verify", VERIFY),
)
LATEST = 4.0  # ratio of times from which on a stage has failed
PATIENCE = 30.0  # seconds that are always allowed in addition
COLUMNS = ("file", "line", "change", "before", "after", "outcome", "seconds", "reason")

#: Changes: name, pattern, replacement. Patterns match at the places that are changed one by one.
CHANGES = (
    ("plus", r"(?<=[\w)\]]) ?\+ ?(?=[\w(])", " - "),
    ("minus", r"(?<=[\w)\]]) - (?=[\w(])", " + "),
    ("times", r"(?<=[\w)\]])\*(?=[\w(])", "/"),
    ("over", r"(?<=[\w)\]])/(?=[\w(])", "*"),
    ("less", r" < ", " > "),
    ("less or equal", r" <= ", " > "),
    ("greater", r" > ", " < "),
    ("greater or equal", r" >= ", " < "),
    ("equal", r" == ", " /= "),
    ("not equal", r" /= ", " == "),
    ("and", r"\.and\.", ".or."),
    ("or", r"\.or\.", ".and."),
    ("not", r"\.not\. ?", ""),
    ("true", r"\.true\.", ".false."),
    ("false", r"\.false\.", ".true."),
    ("zero", r"\b0\.0_wp", "1.0_wp"),
    ("half", r"\b0\.5_wp", "1.0_wp"),
    ("one", r"\b1\.0_wp", "2.0_wp"),
    ("two", r"\b2\.0_wp", "1.0_wp"),
    ("smallest", r"\bmin\(", "max("),
    ("largest", r"\bmax\(", "min("),
    ("magnitude", r"\babs\(", "("),
)
DELETED = re.compile(r"^(\s*)((?:call \w+\(.*\)|[\w%]+(?:\([^=]*\))? = [^&]*))$")
DECLARATION = re.compile(
    r"^\s*(real|integer|logical|type|character|class|use|private|public|implicit|procedure|end|"
    r"subroutine|pure|elemental|recursive|function|module|interface|import|allocate|deallocate|"
    r"contains|associate|abstract|data|select|case|only|enum)\b",
    re.IGNORECASE,
)
TEXT = re.compile(r"warn|fail\(|log_line|to_text|note\(|hint|'|\"|error\b")


def find_mutants(patterns):
    """All possible mutants, as dictionaries with the first five COLUMNS."""
    found = []
    for path in sorted({p for pattern in patterns for p in TOP.glob(pattern)}):
        continued = skipped = False
        for number, text in enumerate(path.read_text().splitlines(), 1):
            code = text.split("!", 1)[0].rstrip() if "'" not in text else text.rstrip()
            if not continued:
                skipped = bool(DECLARATION.match(code) or TEXT.search(code))
            elif TEXT.search(code):
                skipped = True
            plain = not skipped and code.strip() and not code.lstrip().startswith(("!", "&"))
            begins, continued = not continued, code.endswith("&")
            if not plain:
                continue
            for name, pattern, new in CHANGES:
                for match in re.finditer(pattern, code):
                    after = code[: match.start()] + new + code[match.end() :]
                    found.append((path, number, name, code, after))
            deleted = DELETED.match(code)
            if deleted and begins and not continued:
                found.append((path, number, "delete", code, f"{deleted[1]}continue"))
    return [
        dict(
            zip(
                COLUMNS,
                (str(p.relative_to(TOP)), str(n), c, b.strip(), a.strip()),
                strict=False,
            )
        )
        for p, n, c, b, a in found
    ]


def choose(mutants, n, seed):
    """n mutants in random order; each file is drawn in proportion to the number of its mutants."""
    chance = random.Random(seed)
    return chance.sample(mutants, min(n, len(mutants)))


class Tree:
    """A copy of the source, the tests and the objects, in which one mutant at a time is built."""

    def __init__(self, place):
        self.place = place
        self.limits = {}
        files = subprocess.run(
            ["git", "ls-files"], cwd=TOP, capture_output=True, text=True, check=True
        ).stdout.splitlines()
        for name in files:  # an interrupted run may have left a changed file
            own = place / name
            if own.exists() and own.read_bytes() == (TOP / name).read_bytes():
                continue
            own.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(TOP / name, own)
            own.touch()
        (place / "build").mkdir(exist_ok=True)
        if not (place / "build/release").exists():
            shutil.copytree(TOP / "build/release", place / "build/release", symlinks=True)
        if not (place / ".venv").exists():
            os.symlink(TOP / ".venv", place / ".venv")

    def run(self, command, limit=None):
        """Run a command in the tree; return its exit code, or -1 if it lasts too long."""
        with open(self.place / "stage.log", "w") as log:
            process = subprocess.Popen(
                command, cwd=self.place, stdout=log, stderr=log, start_new_session=True
            )
            try:
                return process.wait(limit)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()
                return -1

    def measure(self):
        """Run all stages without a change; they must pass. Their times become the limits."""
        if self.run(["make", "-s", "build/release/bezel"]) != 0:
            sys.exit(f"the program does not build: {self.place}/stage.log")
        self.program = (self.place / "build/release/bezel").read_bytes()
        for name, command in STAGES:
            begin = time.monotonic()
            if self.run(command) != 0:
                sys.exit(f"{name} fails without a change: {self.place}/stage.log")
            self.limits[name] = PATIENCE + LATEST * (time.monotonic() - begin)

    def judge(self, mutant):
        """Build a mutant, test it, and restore the source; return the outcome."""
        path = self.place / mutant["file"]
        source = path.read_text()
        lines = source.splitlines(keepends=True)
        index = int(mutant["line"]) - 1
        indent = lines[index][: len(lines[index]) - len(lines[index].lstrip())]
        lines[index] = f"{indent}{mutant['after']}\n"
        path.write_text("".join(lines))
        try:
            if self.run(["make", "-s", "build/release/bezel"], 600) != 0:
                return "does not compile"
            if (self.place / "build/release/bezel").read_bytes() == self.program:
                return "same program"
            for name, command in STAGES:
                code = self.run(command, self.limits[name])
                if code != 0:
                    return f"{name}: too long" if code < 0 else name
            return "survived"
        finally:
            path.write_text(source)


def main(argv=None):
    p = argparse.ArgumentParser(prog="mutate_source", description=(__doc__ or "").splitlines()[0])
    p.add_argument("-n", type=int, default=200, help="number of mutants that are counted")
    p.add_argument("--seed", type=int, default=1)
    p.add_argument("--jobs", type=int, default=2, help="number of copies that work at once")
    p.add_argument("--out", type=Path, default=TOP / "build/mutate_source")
    p.add_argument("--only", nargs="+", default=AREAS, help="patterns of files to change")
    p.add_argument("--write", action="store_true", help="write verification/mutants.csv")
    o = p.parse_args(argv)
    o.out.mkdir(parents=True, exist_ok=True)
    table = o.out / "mutants.csv"
    rows = list(csv.DictReader(table.open())) if table.exists() else []
    known = {(r["file"], r["line"], r["after"]) for r in rows}
    waiting = [
        m
        for m in choose(find_mutants(o.only), 2 * o.n, o.seed)
        if (m["file"], m["line"], m["after"]) not in known
    ]
    lock = threading.Lock()

    def counted():
        return [r for r in rows if r["outcome"] not in ("does not compile", "same program")]

    def report():
        n, caught = len(counted()), sum(r["outcome"] != "survived" for r in counted())
        return f"{n} mutants, {caught} caught, {n - caught} survived"

    def work(k):
        tree = Tree(o.out / f"tree{k}")
        tree.measure()
        while True:
            with lock:
                if len(counted()) >= o.n or not waiting:
                    return
                mutant = waiting.pop(0)
            begin = time.monotonic()
            outcome = tree.judge(mutant)
            seconds = f"{time.monotonic() - begin:.0f}"
            with lock:
                rows.append(mutant | {"outcome": outcome, "seconds": seconds, "reason": ""})
                write(table, rows)
                print(f"{mutant['file']}:{mutant['line']}: {mutant['change']}: {outcome}")
                if sys.stdout.isatty():
                    print(report())

    with concurrent.futures.ThreadPoolExecutor(o.jobs) as pool:
        for done in [pool.submit(work, k) for k in range(o.jobs)]:
            done.result()
    if o.write:
        reasons = {}
        if TABLE.exists():
            reasons = {
                (r["file"], r["before"], r["after"]): r["reason"]
                for r in csv.DictReader(TABLE.open())
            }
        for r in rows:
            r["reason"] = reasons.get((r["file"], r["before"], r["after"]), r["reason"])
        write(TABLE, sorted(counted(), key=lambda r: (r["file"], int(r["line"]), r["after"])))
    print(report())
    return 0


def write(path, rows):
    """Write the table in one move, so that an interrupted run leaves a complete one."""
    part = path.with_suffix(".new")
    with part.open("w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    part.replace(path)


if __name__ == "__main__":
    sys.exit(main())
