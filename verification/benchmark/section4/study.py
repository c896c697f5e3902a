"""Those studies of doc/verification/section4.md that are not about the forces of results.csv:

    python3 -m verification.benchmark.section4.study symmetry field locking hourglass

Each study runs decks of this folder and writes <study>.csv beside them. `field` needs pyvista
(.venv).
"""

import argparse
import csv
import itertools
import json
import pathlib
import re
import sys

import numpy as np

from post._table import read_table
from verification import TOP, checks

HERE = TOP / "verification/benchmark/section4"

TESTS = {"compression": -0.25, "extension": 1.0}
ELEMENTS = {
    "Q1": "q1", "Q1N2 on 1+": "q1n2_1", "Q1N2 on 1+ and 2+": "q1n2_2", "Q1E9": "q1e9",
    "Q1E9+Q1N2 on 1+": "q1e9_q1n2_1", "Q1E9+Q1N2 on 1+ and 2+": "q1e9_q1n2_2",
    "Q1E9+Q1E9N2 on 1+": "q1e9n2_1", "Q1E9+Q1E9N2 on 1+ and 2+": "q1e9n2_2",
    "Q1E9+Q1E9N2 tapered on 1+": "q1e9n2t_1", "Q1E9+Q1E9N2 tapered on 1+ and 2+": "q1e9n2t_2",
    "Q2": "q2", "Q2N2 on 1+": "q2n2_1", "Q2N2 on 1+ and 2+": "q2n2_2", "IGA2": "iga2",
}  # fmt: skip


class Runner:
    """Run decks of this folder, each in a folder of its own."""

    def __init__(self, bezel, out):
        self.bezel, self.out = bezel, out

    def run(self, deck, *wanted, **settings):
        """Run a deck and return the stem of its results; stop if the exit code is none of
        `wanted`.
        """
        run = checks.new_run(HERE, {"deck": str(deck), "set": settings, "time_limit": 3600})
        print(run.name, flush=True)
        outcome = checks.execute(self.bezel, self.out, run)
        if outcome.code not in (wanted or (0,)):
            sys.exit(f"study: error: {run.name} ended with code {outcome.code}: {outcome.reason}")
        return self.out / run.name / run.deck.stem


def force(stem):
    """The last force of the curve of a run."""
    return float(read_table(f"{stem}_force.dat").columns["force_3"][-1])


def report(stem):
    return json.loads(pathlib.Path(f"{stem}.report.json").read_text())


def symmetry(runner):
    """Section 4.1: a quarter of the cube, without C1 continuity across the symmetry planes, and the
    whole cube, which has it.
    """
    for (test, u), n in itertools.product(TESTS.items(), (1, 2, 4, 8)):
        quarter = 4 * force(runner.run("iga2.inp", n=n, u=u))
        whole = force(runner.run("iga2_full.inp", n=n, u=u))
        yield {
            "test": test, "n": n, "force_4_quarters": f"{quarter:.12g}", "force_whole": f"{whole:.12g}",
            "difference": f"{quarter / whole - 1:.4e}",
        }  # fmt: skip


def locking(runner):
    """Compression of a nearly incompressible cube by two per cent, with cubic splines as the
    reference. (Few element types can be compressed by a quarter, because the stresses at the edges
    of the clamped faces are singular.)
    """
    meshes = [(e, n, 2) for e in ELEMENTS for n in (1, 2, 4, 8)] + [
        ("IGA3", n, 3) for n in (2, 4, 8)
    ]
    for elements, n, p in meshes:
        name = ELEMENTS.get(elements, "iga2")
        more = {"p": p} if name == "iga2" else {}
        stem = runner.run(_automatic(runner, name), 0, 2, n=n, u=-0.02, nu=0.4999, **more)
        said = report(stem)
        yield {
            "elements": elements, "n": n, "dofs": said["dofs"],
            "force_quarter": f"{force(stem):.9g}" if said["exit_code"] == 0 else "",
            "negative_pivots": said["negative_pivots"],
        }  # fmt: skip


def _automatic(runner, name):
    """A deck of this folder with automatic steps, as small as a hundredth of its step size."""
    text = (HERE / f"{name}.inp").read_text()
    text = re.sub(r"  FACTor.*\n", "", text)  # the pivots of every iteration are needed
    text = text.replace("  LOOP,time", "  AUTO,,0.01/steps,1/steps\n  LOOP,time")
    return _deck(runner, f"{name}_auto", text)


def hourglass(runner):
    """Compression in steps of one per cent, until the run does not converge even with a hundredth
    of such a step; and the first unstable state.
    """
    types = ["Q1", "Q1N2 on 1+", "Q1E9", "Q1E9+Q1E9N2 on 1+", "Q1E9+Q1E9N2 on 1+ and 2+",
             "Q1E9+Q1E9N2 tapered on 1+ and 2+", "IGA2"]  # fmt: skip
    for elements, n in itertools.product(types, (1, 2, 4, 8)):
        if elements not in ("Q1", "Q1E9") and n > 4:
            continue
        deck = _automatic(runner, ELEMENTS[elements])
        stem = runner.run(deck, 0, 2, n=n, u=-0.6, steps=60)
        log = pathlib.Path(f"{stem}.log").read_text()
        found = re.search(r"step (\d+) converged to an unstable state: (\d+) negative", log)
        rows = read_table(f"{stem}_force.dat").columns
        percent = 60 * rows["time"]
        yield {
            "elements": elements, "n": n,
            "unstable_from_percent": f"{percent[rows['step'] == int(found[1])][0]:.2f}" if found else "",
            "negative_pivots": found[2] if found else "",
            "last_converged_percent": f"{percent[rows['converged'] == 1].max():.2f}",
        }  # fmt: skip


def field(runner):
    """Errors of displacement and von Mises stress against IGA2, n = 16."""
    from verification.benchmark.section4 import field_error

    for test, u in TESTS.items():
        best = field_error.Solution(runner.run(_field_deck(runner, "iga2"), n=16, u=u), exact=True)
        for elements, n in itertools.product(ELEMENTS, (1, 2, 4)):
            stem = runner.run(_field_deck(runner, ELEMENTS[elements]), n=n, u=u)
            errors = field_error.Solution(stem).errors(best)
            yield {
                "test": test, "elements": elements, "n": n, "dofs": report(stem)["dofs"],
                "force": f"{force(stem) / force(best.stem) - 1:.4e}",
                **{k: f"{v:.4e}" for k, v in errors.items()},
            }  # fmt: skip


def _field_deck(runner, name):
    """A deck of this folder that also writes its last state, and the stresses at points."""
    from verification.benchmark.section4.field_error import POINTS

    text = (HERE / f"{name}.inp").read_text()
    records = [
        f"  STREss cube {x:.15g} {y:.15g} {z:.15g}  {ij}"
        for x, y, z, _ in np.concatenate(list(POINTS.values()))
        for ij in (11, 22, 33, 12, 23, 31)
    ]
    curve = "\n".join(["", "CURVe,points", *records, "", ""])
    text = text.replace("INCLude cube.inc\n", "INCLude cube.inc\n" + curve)
    text = text.replace("  NEXT,time\n", "  NEXT,time\n  PLOT\n")
    return _deck(runner, f"{name}_field", text)


def _deck(runner, name, text):
    """The path of a deck with these records, in which included files are expanded."""
    place = runner.out / "decks"
    place.mkdir(parents=True, exist_ok=True)
    text = text.replace("INCLude cube.inc\n", (HERE / "cube.inc").read_text())
    (place / f"{name}.inp").write_text(text)
    return place / f"{name}.inp"


STUDIES = {f.__name__: f for f in (symmetry, field, locking, hourglass)}


def main():
    p = argparse.ArgumentParser(
        prog="python -m verification.benchmark.section4.study", description=__doc__.splitlines()[0]
    )
    p.add_argument("study", nargs="+", choices=list(STUDIES))
    p.add_argument("--bezel", type=pathlib.Path, default=TOP / "build/release/bezel")
    p.add_argument("--out", type=pathlib.Path, default=TOP / "build/verify/section4_study")
    o = p.parse_args()
    runner = Runner(o.bezel.resolve(), o.out.resolve())
    for study in o.study:
        rows = list(STUDIES[study](runner))
        with open(HERE / f"{study}.csv", "w", encoding="utf-8", newline="") as file:
            file.write(f"# written by python -m verification.benchmark.section4.study {study}\n")
            writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
        print(f"wrote {HERE / study}.csv")


if __name__ == "__main__":
    main()
