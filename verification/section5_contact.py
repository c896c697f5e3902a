"""Corbett and Sauer 2015, 5.2 and 5.3: the hemisphere with all meshes, elements and frictions.

    .venv/bin/python -m verification.section5_contact --mesh 1 2 3 [--only NAME] [--jobs N] [--write]

A case that the same program has already finished with the same decks is not run again, so an
interrupted study can be continued. The command prints the result of each case, then compares the
results with Tables 4 and 5 of the paper. The exit code is 1 if a case ends early or a number
exceeds its bound. `--write` puts the curve tables and summary.csv into
benchmark/section5_contact/runs, from which the figures are drawn. The mesh `reference` is a finer
one, with IGA2 and without friction, turned by 45 degrees (half a period).
"""

import argparse
import csv
import hashlib
import json
import os
import pathlib
import sys
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from fnmatch import fnmatchcase

from post._error import Unreadable
from post._table import read_table
from verification import TOP, checks

DECKS = TOP / "verification/benchmark/section5_contact"
RUNS = DECKS / "runs"
ELEMENTS = ("Q1E9", "Q1E9+Q1N2", "Q1E9+Q1N3", "Q1E9+Q1N2.1", "IGA2")
#: The order in which cases are run: those that matter most for the figures come first.
CASES = (
    ("Q1E9+Q1N2.1", 0.5), ("IGA2", 0.5), ("IGA2", 0), ("Q1E9+Q1N2", 0), ("Q1E9+Q1N2", 0.5),
    ("Q1E9+Q1N3", 0), ("Q1E9+Q1N3", 0.5), ("Q1E9+Q1N2.1", 0), ("Q1E9", 0), ("Q1E9", 0.5),
)  # fmt: skip
MESHES = {
    "1": {"n": 3, "m": 1, "k": 2, "eps": 125},
    "2": {"n": 7, "m": 2, "k": 4, "eps": 250},
    "3": {"n": 11, "m": 3, "k": 8, "eps": 500},
    "reference": {"n": 15, "m": 4, "k": 12, "eps": 750, "down": 25, "turn": 15},
}
END = {"reference": 45}  # degrees
SUMMARY = (
    "mesh", "elements", "mu", "dofs", "degrees", "steps", "cutbacks", "iterations",
    "iterations_per_step", "seconds", "contact_share", "tangential_1", "tangential_2", "command",
)  # fmt: skip
MORE = {"time": "time", "factor_1": "factor_1", "factor_2": "factor_2", "iterations": "iterations"}
KEPT = [f"contact_sole_{s}_{q}" for q in ("force_3", "torque", "tangential_1", "stick") for s in (1, 2)]  # fmt: skip


@dataclass
class Case:
    """One run of the matrix and its results."""

    mesh: str
    elements: str
    mu: float

    @property
    def name(self):
        return f"{self.mesh}_{self.elements}_{self.mu:g}"

    def run(self, limit):
        settings = {**MESHES[self.mesh], "mu": self.mu}
        options = ["--name", self.name, "--time-limit", str(limit)]
        deck = self.elements.lower().replace("+", "_") + ".inp"
        run = checks.new_run(
            DECKS, {"deck": deck, "set": settings, "options": options, "time_limit": limit + 60}
        )
        return checks.Run(self.name, run.deck, run.settings, run.options, run.time_limit)

    def summary(self, place):
        """The row of summary.csv, from report and curve of the run, or None if these are
        missing.
        """
        try:
            report = json.loads((place / f"{self.name}.report.json").read_text())
            curve = read_table(place / f"{self.name}_sole.dat").columns
        except (OSError, ValueError, Unreadable):
            return None
        run = self.run(0)
        seconds, steps = report["seconds"], len(curve["time"])
        iterations = int(curve["iterations"].sum())
        return {
            "mesh": self.mesh, "elements": self.elements, "mu": f"{self.mu:g}",
            "dofs": report["dofs"], "degrees": f"{180 * curve['factor_2'][-1]:.6g}", "steps": steps,
            "cutbacks": report["cutbacks"], "iterations": iterations,
            "iterations_per_step": f"{iterations / steps:.2f}",
            "seconds": f"{seconds['total']:.1f}",
            "contact_share": f"{seconds['contact'] / seconds['total']:.2f}",
            "tangential_1": f"{curve['contact_sole_1_tangential_1'][-1]:.4f}",
            "tangential_2": f"{curve['contact_sole_2_tangential_1'][-1]:.4f}",
            "command": " ".join(["bezel", *(f"--set {s}" for s in run.settings), run.deck.name]),
        }  # fmt: skip


def main(argv=None):
    o = parser().parse_args(argv)
    bezel, out = pathlib.Path(o.bezel).resolve(), pathlib.Path(o.out).resolve()
    if not os.access(bezel, os.X_OK):
        sys.exit(
            f"section5_contact: error: '{bezel}' is not an executable program; build it with `make`"
        )
    cases = [c for c in all_cases(o.mesh) if any(fnmatchcase(c.name, w) for w in o.only)]
    if not cases:
        sys.exit("section5_contact: error: no case matches --mesh and --only")
    stamp = fingerprint(bezel)
    rows = {}
    with ThreadPoolExecutor(max_workers=max(1, o.jobs)) as pool:
        waiting = {pool.submit(finish, bezel, out, c, stamp, o): c for c in cases}
        for done in as_completed(waiting):
            case, (row, words) = waiting[done], done.result()
            rows[case.name] = row
            print(case.name, words, flush=True)
            if o.write and row:
                write(case, row, out / case.name)
    return report(cases, rows)


def all_cases(meshes):
    for mesh in meshes:
        for elements, mu in [("IGA2", 0)] if mesh == "reference" else CASES:
            yield Case(mesh, elements, mu)


def fingerprint(bezel):
    """Hash of the program and the decks: a run is reused as long as neither has changed."""
    text = hashlib.sha256(bezel.read_bytes())
    for deck in sorted(DECKS.glob("*.in[cp]")):
        text.update(deck.read_bytes())
    return text.hexdigest()


def finish(bezel, out, case, stamp, o):
    """(row of the summary or None, remark), from the existing run or from a new one."""
    place, run = out / case.name, case.run(o.time_limit)
    made_by = place / "made_by.txt"
    kept = made_by.exists() and made_by.read_text() == stamp
    if not kept:
        outcome = checks.execute(bezel, out, run)
        if outcome.code == 0:
            made_by.write_text(stamp)
    row = case.summary(place)
    if row is None:
        return None, f"gave no result: {outcome.reason}" if not kept else "has no result"
    words = (
        f"{row['degrees']} degrees, {row['steps']} steps, {row['iterations_per_step']} iterations a"
        f" step, {row['cutbacks']} cuts, {row['seconds']} s, contact {row['contact_share']}"
    )
    if not kept and outcome.code != 0:
        words += f"; ended with code {outcome.code}: {outcome.reason}"
    return row, words + (" (made before)" if kept else "")


def write(case, row, place):
    """Write the curve with few digits, and the case's line in summary.csv."""
    RUNS.mkdir(exist_ok=True)
    curve = read_table(place / f"{case.name}_sole.dat").columns
    names = [*MORE, *KEPT]
    lines = ["# " + " ".join(names)]
    lines += [" ".join(f"{x:.12g}" for x in line) for line in zip(*(curve[n] for n in names))]
    (RUNS / f"{case.name}.dat").write_text("\n".join(lines) + "\n")
    file, rows = RUNS / "summary.csv", {}
    if file.exists():
        with file.open(newline="") as text:
            rows = {(r["mesh"], r["elements"], r["mu"]): r for r in csv.DictReader(text)}
    rows[row["mesh"], row["elements"], row["mu"]] = row
    order = lambda k: (k[0], ELEMENTS.index(k[1]), float(k[2]))
    with file.open("w", newline="") as text:
        table = csv.DictWriter(text, SUMMARY, lineterminator="\n")
        table.writeheader()
        table.writerows(rows[k] for k in sorted(rows, key=order))


def report(cases, rows):
    """Compare the results with Tables 4 and 5; return 1 if a case ended early or a number exceeds
    its bound.
    """
    lines, bad = [], 0
    for case in cases:
        row = rows[case.name]
        if row is None or float(row["degrees"]) < END.get(case.mesh, 180) - 1e-6:
            print(f"{case.name} did not reach its end")
            bad += 1
        else:
            lines += compared(case, row)
    print(f"{'case':<22} {'quantity':<22} {'paper':>8} {'ours':>8} {'difference':>10}")
    for what, paper, ours, bound in lines:
        ok = abs(ours / paper - 1) <= bound
        bad += not ok
        verdict = "ok" if ok else f"more than {bound:.0%}: FAILED"
        print(f"{what} {paper:>8g} {ours:>8g} {ours / paper - 1:>10.1%}  {verdict}")
    print(f"{len(cases)} cases, {bad} not finished or out of bounds")
    return 1 if bad else 0


def compared(case, row):
    """(quantity, value of the paper, our value, bound) for those entries of Tables 4 and 5 that
    belong to this case.
    """
    same = lambda r: (r["mesh"], r["elements"]) == (case.mesh, case.elements)
    for r in filter(same, paper_table("table4.csv")):
        yield f"{case.name:<22} {'dofs':<22}", int(r["dofs"]), int(row["dofs"]), 0.0
    for r in filter(same, paper_table("table5.csv")):
        for side, body in (1, "hemisphere"), (2, "block"):
            if case.mu > 0:
                got = float(row[f"tangential_{side}"])
                what = f"{case.name:<22} {'largest t_x, ' + body:<22}"
                yield what, float(r[body]), got, float(r["bound"])


def paper_table(name):
    """Rows of a table of the paper."""
    lines = (DECKS / name).read_text().splitlines()
    return list(csv.DictReader(line for line in lines if not line.startswith("#")))


def parser():
    p = argparse.ArgumentParser(
        prog="python -m verification.section5_contact", description=__doc__.split("\n")[0]
    )
    p.add_argument("--bezel", default=TOP / "build/release/bezel", metavar="PROGRAM")
    p.add_argument("--mesh", nargs="+", choices=list(MESHES), default=["1"])
    p.add_argument(
        "--only",
        nargs="+",
        default=["*"],
        metavar="NAME",
        help="cases, such as 3_IGA2_0 or 3_*_0.5",
    )
    p.add_argument(
        "--jobs", type=int, default=1, metavar="N", help="number of simultaneous runs (default 1)"
    )
    p.add_argument(
        "--time-limit", type=int, default=7200, metavar="S", help="seconds that a run may take"
    )
    p.add_argument("--out", default=TOP / "build/section5_contact", metavar="DIR")
    p.add_argument("--write", action="store_true", help="update the committed tables")
    return p


if __name__ == "__main__":
    sys.exit(main())
