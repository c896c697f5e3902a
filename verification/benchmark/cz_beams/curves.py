"""Write curves.csv: forces against openings for the quick decks of cz_point, cz_beams and cz_peel.

python -m verification.benchmark.cz_beams.curves [--bezel build/release/bezel]
"""

import argparse
import csv
import pathlib
import subprocess
import tempfile

import numpy as np

from verification import TOP

HERE = TOP / "verification/benchmark/cz_beams"
PULL = {"a": 10, "t0": 60, "gc": 0.6, "u": 0.08, "first": 0.2}
RUNS = [
    *((f"{law} {phi}", f"cz_point/{law}.inp", "bond", {"phi": phi})
      for law in ("exponential", "irreversible", "mixed", "ppr") for phi in (0, 90)),
    ("dcb", "cz_beams/dcb.inp", "beam", {}),
    ("dcb ppr", "cz_beams/dcb_ppr.inp", "beam", {}),
    ("dcb coarse", "cz_beams/dcb.inp", "beam", {"n": "1/3", "t0": 20, "dt": 0.02}),
    ("frmm", "cz_beams/frmm.inp", "beam", {}),
    ("lap", "cz_beams/lap.inp", "beam", PULL),
    ("lap ppr", "cz_beams/lap_ppr.inp", "beam", PULL),
    ("peel", "cz_peel/peel.inp", "peel", {"l": 6, "u": 4, "dt": 0.02}),
]  # fmt: skip


def main():
    """Write one row for each step of each run."""
    parser = argparse.ArgumentParser(
        prog="python -m verification.benchmark.cz_beams.curves", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--bezel", type=pathlib.Path, default=TOP / "build/release/bezel")
    bezel = parser.parse_args().bezel.resolve()
    with open(HERE / "curves.csv", "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["run", "way", "force"])
        for name, deck, curve, sets in RUNS:
            for way, force in run(bezel, HERE.parent / deck, curve, sets):
                writer.writerow([name, f"{way:.6g}", f"{force:.6g}"])


def run(bezel, deck, curve, sets):
    """(steps, 2) opening and force."""
    with tempfile.TemporaryDirectory() as out:
        settings = [f"--set={key}={value}" for key, value in sets.items()]
        subprocess.run([bezel, "--quiet", "-o", out, *settings, deck], capture_output=True)
        table = np.genfromtxt(pathlib.Path(out) / f"{deck.stem}_{curve}.dat", names=True)
    if curve == "bond":  # prescribed: 0, 1.5, 0, 3, 1.5, 12 g0
        way = np.interp(table["time"], [0, 1, 2, 3, 3.5, 5], [0, 1.5, 0, 3, 1.5, 12])
        return np.column_stack([way, table["force_1"] + table["force_3"]])
    way = table["disp_1"] if "disp_1" in table.dtype.names else table["disp_3"]
    force = table["force_1"] if "force_1" in table.dtype.names else table["force_3"]
    return np.abs(np.column_stack([way, force]))


if __name__ == "__main__":
    main()
