"""Contact with extreme parameters: run benchmark/contact_extremes and print a table.

    python -m verification.contact_extremes [--bezel PROGRAM] [--only WORD] [--out DIR]

The table has a row for each run, with outcome and reason, as in doc/verification/contact_points.md.
Penalties are multiples of the automatic one.
"""

import argparse
import json
import pathlib
import subprocess
import tempfile
import time

from post._table import read_table
from verification import TOP

DECKS = TOP / "verification/benchmark/contact_extremes"
AUTO = 125  # NORMal PENAlty AUTO: 125 E/h of the block, E = 1, h = 1
TIME_LIMIT = 100

#: what is changed: the settings, with the name of the deck if it is not the usual one
RUNS = {
    "nothing (penalty 125, the automatic one; mu 0.5)": {},
    **{f"penalty {f:g} times the automatic one": {"eps": f * AUTO} for f in
       (1e-2, 1e-1, 10, 1e2, 1e3, 1e4, 1e5, 1e6)},
    **{f"mu = {mu}": {"mu": mu} for mu in (0, 0.1, 1, 2)},
    **{f"stiffness ratio {r:g}": {"ratio": r} for r in (1e-3, 1e-2, 1, 1e2, 1e4, 1e6)},
    "contact lost and regained, d = 0.5": {"d": 0.5, "lift": 1},
    "rotation by 720 degrees": {"turn": 720, "round": 240},
    "steps ten times larger": {"down": 2, "round": 6},
    "lengths 1e-6": {"l": 1e-6},
    "lengths 1e6": {"l": 1e6},
    "stresses 1e-6": {"s": 1e-6},
    "stresses 1e6": {"s": 1e6},
    "lengths and stresses 1e-6": {"l": 1e-6, "s": 1e-6},
    "lengths and stresses 1e6": {"l": 1e6, "s": 1e6},
    "BALAnced": {"deck": "balanced"},
    **{f"BALAnced, penalty {f:g} times": {"eps": f * AUTO, "deck": "balanced"} for f in
       (10, 1e2, 1e3, 1e4, 1e5, 1e6)},
    **{f"BALAnced, stiffness ratio {r:g}": {"ratio": r, "deck": "balanced"} for r in (1e-3, 1e-2)},
}  # fmt: skip


def main():
    o = parser().parse_args()
    print("| changed | outcome | steps | cuts | force | torque | penetration | s | reason |")
    print("|---|---|---|---|---|---|---|---|---|", flush=True)
    for name, settings in RUNS.items():
        if o.only in name:
            with tempfile.TemporaryDirectory(dir=o.out) as place:
                print(row(o.bezel, name, dict(settings), pathlib.Path(place)), flush=True)


def row(bezel, name, settings, place):
    """Run one case; return its line of the table, with the results of side 1 in the units of the
    deck.
    """
    deck = settings.pop("deck", "hemisphere")
    command = [bezel, "--quiet", "-o", str(place), "--time-limit", str(TIME_LIMIT)]
    for key, value in settings.items():
        command += ["--set", f"{key}={value:.16g}"]
    command.append(str(DECKS / f"{deck}.inp"))
    start = time.monotonic()
    done = subprocess.run(command, capture_output=True, text=True, stdin=subprocess.DEVNULL)
    seconds = time.monotonic() - start

    length, stress = settings.get("l", 1), settings.get("s", 1)
    cells = ["-"] * 5
    curve = place / f"{deck}_sole.dat"
    if curve.exists():
        table = read_table(curve)
        value = lambda word: table.columns[table.find(word)][-1]
        report = json.loads((place / f"{deck}.report.json").read_text())
        cells = [str(report["steps"]), str(report["cutbacks"])] + [
            f"{x:.6g}" for x in (
                value("contact_sole_1_force_3") / (stress * length**2),
                value("contact_sole_1_torque") / (stress * length**3),
                value("contact_sole_1_penetration") / length,
            )
        ]  # fmt: skip
        if done.returncode:
            cells[0] += f" (to t = {value('time'):.3g})"
    outcome = {0: "runs", 2: "no solution", 4: "time limit"}.get(
        done.returncode, f"code {done.returncode}"
    )
    reason = " ".join(done.stderr.split()) if done.returncode else ""
    return "| " + " | ".join([name, outcome, *cells, f"{seconds:.0f}", reason]) + " |"


def parser():
    p = argparse.ArgumentParser(
        prog="python -m verification.contact_extremes", description=__doc__.splitlines()[0]
    )
    p.add_argument("--bezel", default=str(TOP / "build/release/bezel"), metavar="PROGRAM")
    p.add_argument(
        "--only", default="", metavar="WORD", help="run only the rows whose name contains this word"
    )
    p.add_argument("--out", metavar="DIR", help="folder for the runs (default: a temporary one)")
    return p


if __name__ == "__main__":
    main()
