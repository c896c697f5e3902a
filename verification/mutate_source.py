"""Change the Fortran source in one place at a time and count the changes that the tests notice.

    python -m verification.mutate_source [-n 200] [--seed 1] [--jobs 2] [--longest 60]
                                         [--only PATTERN ...] [--again] [--write]

A mutant is the program with one operator, constant, condition or statement of a file of AREAS
changed. It is tested by the unit tests, the comparison with the second implementation, TROUBLE, and
all quick checks of `verify`, which include those of `make patch` and `silent`; it is caught if one of
them fails. To save time,

- a build with counters of lines first finds which tests execute which lines, and a mutant is only
  given to the tests that execute its line. If there is none, its outcome is `not executed`;
- these tests are run in the order of their time, but unit tests and those that have caught mutants of
  the same file come earlier, until one fails or the tests have taken `--longest` seconds without the change. A mutant
  that passes counts as survived, although a longer test may notice it;
- only the changed file is compiled, with -O2, and linked with the objects of build/release.

A test has failed, too, if it takes LATEST times the CPU time that it takes without the change. Mutants
that do not compile, and those with the same object file, are not counted.

A seed ranks all mutants by a hash of the seed, the file and the change, and the first ones are drawn. A
change of the source therefore only replaces mutants of the statements that change; where lines merely
move, mutants, outcomes and reasons are kept. The column `ordinal` tells equal changes of a file apart.

OUT/mutants.csv is written as the run proceeds, and a run that was interrupted continues from it; --again
judges its survivors again. Changed tests are noticed. After a change of the source, remove
OUT/lines.jsonl, or all of OUT if outcomes of unchanged statements may have changed. With --write the
table is copied to verification/mutants.csv, in which the column `reason` of a survivor is kept.
"""

from __future__ import annotations

import argparse
import concurrent.futures
import csv
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import threading
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from verification import TOP, checks, studies, verify

TABLE = TOP / "verification/mutants.csv"
BUILD = TOP / "build/release"
#: Files that are changed: contact with its laws, energies, and what follows a path.
AREAS = (
    "src/contact/*.f90",
    "src/solution/energy_*.f90",
    "src/solution/continuation*.f90",
    "src/solution/step*.f90",
    "src/solution/newton.f90",
    "src/solution/line_search.f90",
    "src/solution/anderson.f90",
    "src/solution/secant_friction.f90",
    "src/solution/friction_limit.f90",
    "src/solution/stabilisation.f90",
    "src/solution/predictor.f90",
    "src/model/prescribed.f90",
)
#: Tests of `make trouble` about results.
TROUBLE = ("continued_files", "factors", "fields", "hints", "restart")
LATEST = 10  # ratio of CPU times from which on a test has failed
UNIT = 10  # unit tests come first, as if they had caught so many mutants
PATIENCE = 10  # CPU seconds that are always allowed
COLUMNS = ("file", "line", "change", "before", "after", "ordinal", "outcome", "seconds", "reason")
SURVIVED = ("survived", "not executed")

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
    """All possible mutants, as dictionaries with the first six COLUMNS, and `lines`, a number with a
    bit for each line of the statement.
    """
    found, equal = [], Counter()
    for path in sorted({p for pattern in patterns for p in TOP.glob(pattern)}):
        continued = skipped = False
        first = 0
        source = path.read_text().splitlines()
        for number, text in enumerate(source, 1):
            code = text.split("!", 1)[0].rstrip() if "'" not in text else text.rstrip()
            if not continued:
                first = number
                skipped = bool(DECLARATION.match(code) or TEXT.search(code))
            elif TEXT.search(code):
                skipped = True
            plain = not skipped and code.strip() and not code.lstrip().startswith(("!", "&"))
            continued = code.endswith("&")
            if not plain:
                continue
            changed = [
                (name, code[: match.start()] + new + code[match.end() :])
                for name, pattern, new in CHANGES
                for match in re.finditer(pattern, code)
            ]
            if DELETED.match(code) and first == number and not continued:
                changed.append(("delete", "continue"))
            last = number
            while source[last - 1].split("!")[0].rstrip().endswith("&"):
                last += 1
            lines = (1 << last + 1) - (1 << first)
            for name, after in changed:
                cells = (str(path.relative_to(TOP)), str(number), name, code.strip(), after.strip())
                mutant = dict(zip(COLUMNS[:5], cells, strict=True))
                same = (mutant["file"], mutant["before"], mutant["after"])
                equal[same] += 1
                found.append(mutant | {"ordinal": str(equal[same]), "lines": lines})
    return found


@dataclass
class Test:
    """A part of the tests that is run as a whole: a command, or runs of `verify` with their checks."""

    name: str
    key: str  # changes whenever the test changes
    command: list | None = None  # its first word is the name of a script of Tree
    runs: tuple = ()
    plans: tuple = ()

    def passes(self, tree):
        tree.link("run" if self.command and self.command[0] == "run" else "bezel")
        if self.command:
            program, *words = self.command
            return tree.call([tree.script(program), *words], tree.place / "work") == 0
        out = tree.place / "verify"
        outcomes = {r.name: checks.execute(tree.script("bezel"), out, r) for r in self.runs}
        try:
            passed = all(row.ok for plan in self.plans for row in plan.judge(out, outcomes))
        except Exception:  # verify would stop
            passed = False
        shutil.rmtree(out, ignore_errors=True)
        return passed


def all_tests():
    """{name: Test}"""
    found = [Test(f"unit {p.stem}", hash_of([p]), ["run", p.stem]) for p in unit_tests()]
    discover = ["discover", "-s", "verification/reference/tests", "-t", "."]
    python = {"reference": (sorted((TOP / "verification/reference").glob("**/*.py")), discover)}
    for p in (TOP / f"verification/trouble/test_{name}.py" for name in TROUBLE):
        for name in re.findall(r"^class (\w+)", p.read_text(), re.MULTILINE):
            python[f"trouble {p.stem} {name}"] = ([p], [f"verification.trouble.{p.stem}.{name}"])
    for name, (files, words) in python.items():
        found.append(Test(name, hash_of(files), ["python", "-m", "unittest", *words]))
    for folder, expect in verify.read_cases(None)[0]:
        key = hash_of(sorted(p for p in folder.iterdir() if p.is_file()))
        quick = [checks.plan_check(folder, c) for c in expect["checks"] if not c.get("slow")]
        quick += studies.plan_studies(folder, expect["studies"], False)
        together = {}  # checks of the same runs
        for plan in quick:
            together.setdefault(tuple(r.name for r in plan.runs), []).append(plan)
        for names, plans in together.items():
            found.append(Test(" ".join(names), key, None, tuple(plans[0].runs), tuple(plans)))
    return {test.name: test for test in found}


def unit_tests():
    files = sorted((TOP / "verification/unit").glob("*/test_*.pf"))
    return [p for p in files if p.parent.name != "runner"]


def hash_of(paths):
    return hashlib.sha256(b"".join(p.read_bytes() for p in paths)).hexdigest()[:16]


class Tree:
    """A folder with the objects of the program and of the unit tests, and with scripts that run them
    with a limit of CPU time: `bezel`, `run` (unit tests), and `python` (tests written in Python).
    """

    def __init__(self, place, flags=()):
        self.place = place
        self.linked = set()  # programs that are up to date
        words = (BUILD / "flags").read_text().split()
        self.compiler = [w for w in words if w != "-g"] + list(flags)
        said = subprocess.run(["make", "-s", "settings"], cwd=TOP, capture_output=True, text=True)
        self.libraries = re.search(r" LIBS='(.*?)'", said.stdout)[1].split()
        shutil.rmtree(place, ignore_errors=True)
        for name in ("objects", "modules", "work", "counts"):
            (place / name).mkdir(parents=True)
        for name in ("verification", "input", "post"):  # unit tests read files of the tree
            os.symlink(TOP / name, place / "work" / name)
        for name in ("bezel", "run", "python"):
            program = f'"{place / name}"'
            if name == "python":
                program = f'cd "{TOP}"; BEZEL="{self.script("bezel")}" "{sys.executable}"'
            self.script(name).write_text(SCRIPT.format(place=place, program=program))
            self.script(name).chmod(0o755)

    def script(self, name):
        return self.place / f"{name}.sh"

    def call(self, command, folder=None):
        """Run a command and return its exit code."""
        with open(self.place / "log", "a") as log:
            try:
                return subprocess.run(
                    command, cwd=folder or self.place, stdout=log, stderr=log, timeout=1200
                ).returncode
            except subprocess.TimeoutExpired:
                return -1

    def compile(self, path, text):
        """The object file of a source, as bytes; None if it does not compile, or if its interface
        differs from that of the program.
        """
        source, target = self.place / path.name, self.place / "objects" / f"{path.stem}.o"
        source.write_text(text)
        module = self.place / "modules" / f"{path.stem}.mod"
        command = [*self.compiler, "-J", "modules", "-I", BUILD, "-c", source.name, "-o", target]
        if self.call(command) != 0:
            return None
        same = module.read_bytes() == (BUILD / module.name).read_bytes()
        module.unlink()
        return target.read_bytes() if same else None

    def link(self, name):
        """Link a program with the objects of this folder, unless this has been done."""
        if name in self.linked:
            return
        objects = [BUILD / "main.o"]
        if name == "run":
            objects = [BUILD / f"unit/{p.stem}.o" for p in unit_tests()]
            objects += [BUILD / "unit/driver.o", *(BUILD / "unit").glob("funit*.o")]
        objects += (self.place / "objects").glob("*.o")  # before the same objects of the library
        command = [*self.compiler, "-fopenmp", "-s", "-o", name, *objects, BUILD / "libbezel.a"]
        if self.call([*command, *self.libraries]) != 0:
            sys.exit(f"the program cannot be linked: {self.place}/log")
        self.linked.add(name)

    def run(self, test, seconds):
        """Run a test with a limit of CPU time; return whether it passes, and its CPU time."""
        (self.place / "limit").write_text(f"{seconds:.0f}")
        (self.place / "times").write_text("")
        passed = test.passes(self)
        children = (self.place / "times").read_text().splitlines()[1::2]
        words = re.findall(r"(\d+)m([\d.]+)s", " ".join(children))
        return passed, round(sum(60 * int(m) + float(s) for m, s in words), 3)


#: `times` prints two lines: the CPU times of the shell, and those of its children.
SCRIPT = """#!/bin/sh
ulimit -t $(cat "{place}/limit")
export GCOV_PREFIX="{place}/counts" GCOV_PREFIX_STRIP=99 OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
({program} "$@")
code=$?
times >> "{place}/times"
exit $code
"""


class Counted(Tree):
    """The program with counters of the lines of all files of AREAS. These files are compiled without
    OpenMP, because gcov leaves out the functions that the compiler makes of parallel regions.
    """

    def __init__(self, place, first=None):
        super().__init__(place, ["-O0", "-g", "--coverage", "-fno-openmp", "-Wno-uninitialized"])
        if first is None:
            for path in {p for pattern in AREAS for p in TOP.glob(pattern)}:
                self.compile(path, path.read_text())
            first = self
        for built in (first.place / "objects").iterdir():
            folder = "objects" if built.suffix == ".o" else "counts"
            if not (place / folder / built.name).exists():
                os.symlink(built, place / folder / built.name)

    def measure(self, test, longest):
        """A record of one test: its CPU time, and for each file that it executes a number whose bit n
        is set if line n is executed.
        """
        passed, seconds = self.run(test, longest + PATIENCE)
        counts, lines = self.place / "counts", Counter()
        files = sorted(p.name for p in counts.glob("*.gcda"))
        if files:
            said = subprocess.run(["gcov", "-t", "-j", *files], cwd=counts, capture_output=True)
            for part in said.stdout.splitlines():
                for file in json.loads(part)["files"]:
                    for line in file["lines"]:
                        if line["count"]:
                            lines[Path(file["file"]).stem] |= 1 << line["line_number"]
        for name in files:
            (counts / name).unlink()
        masks = {stem: hex(mask) for stem, mask in lines.items()}
        return dict(name=test.name, key=test.key, passed=passed, seconds=seconds, lines=masks)


def measure_all(tests, o):
    """{name of the test: record of Counted.measure}, of which the file OUT/lines.jsonl keeps a copy."""
    path = o.out / "lines.jsonl"
    records = {}
    if path.exists():
        for record in map(json.loads, path.read_text().splitlines()):
            records[record["name"]] = record
    left = [t for t in tests.values() if records.get(t.name, {}).get("key") != t.key]
    lock = threading.Lock()

    def work(k):
        tree = Counted(o.out / f"counted{k}", first)
        while True:
            with lock:
                if not left:
                    return
                test = left.pop(0)
            record = tree.measure(test, o.longest)
            with lock, path.open("a") as file:
                records[test.name] = record
                file.write(json.dumps(record) + "\n")

    if left:
        first = Counted(o.out / "counted")
        in_parallel(work, o.jobs)
    return {name: records[name] for name in tests}


def in_parallel(work, jobs):
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        for done in [pool.submit(work, k) for k in range(jobs)]:
            done.result()


class Judge(Tree):
    """Builds one mutant at a time and gives it to the tests."""

    def __init__(self, place, tests, records, caught, longest):
        super().__init__(place)
        self.tests, self.records, self.caught, self.longest = tests, records, caught, longest
        self.plain = {}  # {file: its object without a change}

    def tests_of(self, mutant):
        """The tests that execute the line of the mutant, in the order in which they are run."""
        stem = Path(mutant["file"]).stem
        names = [
            name
            for name, record in self.records.items()
            if record["passed"] and int(record["lines"].get(stem, "0"), 16) & mutant["lines"]
        ]
        known = lambda n: UNIT * n.startswith("unit") + self.caught[mutant["file"], n]
        return sorted(names, key=lambda n: self.records[n]["seconds"] / (1 + known(n)))

    def judge(self, mutant):
        """The outcome: the name of the test that fails, or another word."""
        path = TOP / mutant["file"]
        text = path.read_text()
        if path.stem not in self.plain:
            self.plain[path.stem] = self.compile(path, text)
        lines = text.splitlines(keepends=True)
        index = int(mutant["line"]) - 1
        indent = lines[index][: len(lines[index]) - len(lines[index].lstrip())]
        lines[index] = f"{indent}{mutant['after']}\n"
        for built in (self.place / "objects").iterdir():
            built.unlink()
        changed = self.compile(path, "".join(lines))
        if changed is None:
            return "does not compile"
        if changed == self.plain[path.stem]:
            return "same object"
        self.linked.clear()
        names = self.tests_of(mutant)
        spent = 0.0
        for name in names:
            seconds = self.records[name]["seconds"]
            spent += seconds
            if spent <= self.longest:
                passed, _ = self.run(self.tests[name], PATIENCE + LATEST * seconds)
                if not passed:
                    return name
        return "survived" if names else "not executed"


def main(argv=None):
    p = argparse.ArgumentParser(prog="mutate_source", description=(__doc__ or "").splitlines()[0])
    p.add_argument("-n", type=int, default=200, help="number of mutants that are counted")
    p.add_argument("--seed", type=int, default=1)
    p.add_argument("--jobs", type=int, default=2, help="number of mutants that are tested at once")
    p.add_argument("--longest", type=float, default=60.0, help="CPU seconds of tests of a mutant")
    p.add_argument("--out", type=Path, default=TOP / "build/mutate_source")
    p.add_argument("--only", nargs="+", default=AREAS, help="patterns of files to change")
    p.add_argument("--again", action="store_true", help="judge the survivors again")
    p.add_argument("--write", action="store_true", help="write verification/mutants.csv")
    o = p.parse_args(argv)
    o.out = o.out.resolve()
    o.out.mkdir(parents=True, exist_ok=True)
    subprocess.run(["make", "-s", "build/release/bezel"], cwd=TOP, check=True)
    subprocess.run(["make", "-s", "build/release/unit/run"], cwd=TOP, check=True)
    tests = all_tests()
    records = measure_all(tests, o)
    table = o.out / "mutants.csv"
    chosen = {identity(m): m for m in choose(find_mutants(o.only), 2 * o.n, o.seed)}
    rows = list(csv.DictReader(table.open())) if table.exists() else []
    rows = [r | chosen[identity(r)] for r in rows if identity(r) in chosen]
    if o.again:
        rows = [r for r in rows if r["outcome"] not in SURVIVED]
    known = {identity(r) for r in rows}
    waiting = [m for name, m in chosen.items() if name not in known]
    caught = Counter((r["file"], r["outcome"]) for r in rows)  # mutants by file and test
    lock = threading.Lock()

    def counted():
        return [r for r in rows if r["outcome"] not in ("does not compile", "same object")]

    def work(k):
        tree = Judge(o.out / f"judge{k}", tests, records, caught, o.longest)
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
                caught[mutant["file"], outcome] += 1
                write(table, rows)
                print(
                    f"{mutant['file']}:{mutant['line']}: {mutant['change']}: {outcome}", flush=True
                )

    in_parallel(work, o.jobs)
    if o.write:
        reasons = {}
        if TABLE.exists():
            reasons = {identity(r): r["reason"] for r in csv.DictReader(TABLE.open())}
        for r in rows:
            r["reason"] = reasons.get(identity(r), r["reason"])
        write(TABLE, sorted(counted(), key=lambda r: (r["file"], int(r["line"]), r["after"])))
    n, survived = len(counted()), sum(r["outcome"] in SURVIVED for r in counted())
    print(f"{n} mutants, {n - survived} caught, {survived} survived")
    return 0


def identity(row):
    """What stays the same if other statements change and lines move."""
    return row["file"], row["before"], row["after"], row["ordinal"]


def choose(mutants, n, seed):
    """The n mutants of lowest rank; each file is drawn in proportion to the number of its mutants."""

    def rank(mutant):
        return hashlib.sha256(repr((seed, *identity(mutant))).encode()).digest()

    return sorted(mutants, key=rank)[:n]


def write(path, rows):
    """Write the table in one move, so that an interrupted run leaves a complete one."""
    part = path.with_suffix(".new")
    with part.open("w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, extrasaction="ignore", lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    part.replace(path)


if __name__ == "__main__":
    sys.exit(main())
