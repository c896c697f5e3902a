"""How close the points of the hemisphere are to sliding: |t_t|/(mu p) in rings, for
doc/verification/section5_contact.md.

    .venv/bin/python -m verification.benchmark.section5_contact.rings

It runs Q1E9+Q1N2 on mesh 2 up to rotations of 30, 57 and 93 degrees (three runs of a few seconds).
For several radii about the axis it prints the mean of the smoothed values at those points of the
hemisphere whose radius in the deformed state differs by less than 0.06.
"""

import sys
import tempfile

import h5py
import numpy as np

from verification import TOP, checks

HERE = TOP / "verification/benchmark/section5_contact"
MU = 0.5
MESH = {"n": 7, "m": 2, "k": 4, "eps": 250, "mu": MU}
STEPS = (10, 19, 31)  # of three degrees
RADII = (0.2, 0.4, 0.5, 0.7, 0.85)
WIDTH = 0.06


def main():
    print("degrees " + " ".join(f"r={r:g}" for r in RADII))
    with tempfile.TemporaryDirectory() as place:
        for turn in STEPS:
            run = checks.new_run(HERE, {"deck": "q1e9_q1n2.inp", "set": {**MESH, "turn": turn}})
            outcome = checks.execute(TOP / "build/release/bezel", TOP / place, run)
            if outcome.code != 0:
                sys.exit(
                    f"rings: error: {run.name} ended with code {outcome.code}: {outcome.reason}"
                )
            file = TOP / place / run.name / "q1e9_q1n2.vtkhdf"
            print(3 * turn, " ".join(f"{share:.2f}" for share in rings(file)))


def rings(file):
    """The means over the points of each ring."""
    with h5py.File(file) as h5:
        grid, points = h5["VTKHDF"], h5["VTKHDF/PointData"]
        body, first = grid["CellData/body"][:], grid["Offsets"][:]
        end = first[np.flatnonzero(body != body[0])[0]]  # the hemisphere is the first body
        hemisphere = np.zeros(len(grid["Points"]), bool)
        hemisphere[grid["Connectivity"][:end]] = True
        x = grid["Points"][:] + points["displacement"][:]
        pressure = points["contact_pressure"][:]
        friction = np.linalg.norm(points["contact_friction"][:], axis=1)
    pressed = hemisphere & (pressure > 1e-3 * pressure.max())
    radius = np.hypot(x[pressed, 0], x[pressed, 1])
    share = friction[pressed] / (MU * pressure[pressed])
    return [share[np.abs(radius - r) < WIDTH].mean() for r in RADII]


if __name__ == "__main__":
    main()
