"""Imbalance of the contact forces where a small block partly covers elements of a large block.

    python -m verification.benchmark.contact_patch.imbalance [PROGRAM]

It runs partial_q1n2.inp with the small block at 12 positions, for several numbers q of integration
points and n of elements of the large block. It writes imbalance.csv: root mean square and largest
magnitude of 1 - (force on the large block)/(force on the small block).
"""

import pathlib
import subprocess
import sys
import tempfile

import numpy as np

from verification import TOP

HERE = TOP / "verification/benchmark/contact_patch"


def main():
    bezel = sys.argv[1] if len(sys.argv) > 1 else str(TOP / "build/release/bezel")
    lines = ["# written by imbalance.py", "n,q,rms,largest,failed"]
    for n, q in [(5, q) for q in (2, 3, 5, 8, 12, 16)] + [(10, 5), (20, 5)]:
        errors, failed = [], 0
        for i in range(12):
            value = run(bezel, {"n": n, "q": q, "x": -0.43 - 0.013 * i})
            failed += value is None
            errors += [] if value is None else [value]
        rms = np.sqrt(np.mean(np.square(errors)))
        lines.append(f"{n},{q},{rms:.4f},{np.max(np.abs(errors)):.4f},{failed}")
        print(lines[-1], flush=True)
    (HERE / "imbalance.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


def run(bezel, settings):
    """The imbalance in one run; None if the run found no equilibrium."""
    with tempfile.TemporaryDirectory() as place:
        words = [w for k, v in settings.items() for w in ("--set", f"{k}={v:.12g}")]
        command = [bezel, "--quiet", "-o", place, *words, str(HERE / "partial_q1n2.inp")]
        if subprocess.run(command, capture_output=True).returncode:
            return None
        row = np.loadtxt(pathlib.Path(place) / "partial_q1n2_force.dat", ndmin=2)[-1]
        return 1 + row[6] / row[5]


if __name__ == "__main__":
    main()
