"""Write results.csv: the double cantilever beam and the peeled strip on coarse and fine meshes.

    python -m verification.benchmark.cz_beams.study [--bezel build/release/bezel]

For each bond strength and element size, a row gives the mean and the scatter of the force, relative
to theory, while the crack grows; the iterations; the cut-backs; the fraction of the bond released
at the end; and whether the run stopped early.
"""

import argparse
import csv
import json
import pathlib
import subprocess
import tempfile

import numpy as np

from verification import TOP

HERE = TOP / "verification/benchmark/cz_beams"
FIELDS = "case t0 n q zone per_element status mean scatter iterations cutbacks released".split()
RUNS = [("dcb", t0, n, 5) for t0 in (5, 10, 20) for n in ("1/3", "2/3", "1", "2")]
RUNS += [("dcb", 20, "2/3", 10), ("dcb", 20, "1", 10)]
RUNS += [("peel", t0, n, 5) for t0 in (0.1, 0.2, 0.4) for n in ("10/3", "5", "10", "20")]


def main():
    """Run all cases one after another and write results.csv."""
    parser = argparse.ArgumentParser(
        prog="python -m verification.benchmark.cz_beams.study", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--bezel", type=pathlib.Path, default=TOP / "build/release/bezel")
    bezel = parser.parse_args().bezel.resolve()
    rows = []
    for case, t0, n, q in RUNS:
        rows.append(run(bezel, case, t0, n, q))
        print(*rows[-1].values(), flush=True)
    with open(HERE / "results.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, FIELDS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def run(bezel, case, t0, n, q):
    """Run one case; return its row."""
    sets = {"t0": t0, "n": n, "q": q}
    if case == "peel":
        sets |= {"l": 5, "u": 3.6, "dt": 0.02}
    deck = HERE.parent / "cz_peel/peel.inp" if case == "peel" else HERE / "dcb.inp"
    with tempfile.TemporaryDirectory() as out:
        command = [bezel, "--quiet", "-o", out, *(f"--set={k}={v}" for k, v in sets.items()), deck]
        subprocess.run(command, capture_output=True)
        report = json.loads((pathlib.Path(out) / f"{case}.report.json").read_text())
        name = "peel" if case == "peel" else "beam"
        curve = np.genfromtxt(pathlib.Path(out) / f"{case}_{name}.dat", names=True)
    share = curve["contact_glue_1_debonded"]
    if case == "peel":
        ratio = curve["force_3"] / 0.02
        ratio = ratio[share > 0.2]
        bending, gc = 100 * 0.1**3 / 12, 0.02
    else:
        ratio = curve["force_3"] / np.sqrt(0.3**1.5 * 33750**0.5 / 3 / curve["disp_3"])
        ratio = ratio[share > 0.03]
        bending, gc = 33750.0, 0.3
    zone = (
        bending * gc / t0**2
    ) ** 0.25  # E I/b (gc/t0)/t0: the length scale of slender bodies is its fourth root
    numerator, _, denominator = n.partition("/")
    per_element = zone * float(numerator) / float(denominator or 1)
    return {
        "case": case, "t0": t0, "n": n, "q": q, "zone": f"{zone:.3g}", "per_element": f"{per_element:.2g}",
        "status": report["status"], "mean": f"{ratio.mean():.4f}" if ratio.size else "",
        "scatter": f"{ratio.std():.4f}" if ratio.size else "", "iterations": report["iterations"],
        "cutbacks": report["cutbacks"], "released": f"{share[-1]:.2f}",
    }  # fmt: skip


if __name__ == "__main__":
    main()
