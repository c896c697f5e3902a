"""`make demo`: the stretched cube with enriched faces beside tri-linear elements, from run to picture.

python -m post.figures.demo --bezel build/release/bezel --out build/demo
"""

import argparse
import pathlib
import subprocess
import sys

from post import curve, field
from post._error import Unreadable
from post._table import read_table

TOP = pathlib.Path(__file__).resolve().parents[2]
RUNS = {"cube_q1": "Q1", "cube_enriched": "Q1 with Q1N2 on the faces"}
CONVERGED = 0.172838925  # force on a quarter, head of verification/benchmark/section4/reference.csv


def draw(bezel, out):
    """Run the two decks of input/ into the folder `out` and draw the stress and the force there."""
    for stem in RUNS:
        command = [str(bezel), "--quiet", "-o", str(out), str(TOP / "input" / f"{stem}.inp")]
        code = subprocess.run(command).returncode
        if code != 0:
            raise Unreadable(f"'{' '.join(command)}' ended with code {code}")
    forces = [out / f"{s}_force.dat" for s in RUNS]
    errors = [read_table(f).columns["force_3"][-1] / CONVERGED - 1 for f in forces]
    labels = [f"{name}\nforce {100 * e:.2f} % too high" for name, e in zip(RUNS.values(), errors)]
    field.draw([out / f"{s}.vtkhdf" for s in RUNS], out / "cube.png", scalar="mises", labels=labels,
               mirror="xy", say_step=False, view="-52,16")  # fmt: skip
    labels = list(RUNS.values())
    curve.draw(forces, out / "force.png", x="disp", labels=labels, title="Stretching a cube")


def main(argv=None):
    p = argparse.ArgumentParser(prog="demo", description="Run two decks and draw what they give.")
    p.add_argument("--bezel", type=pathlib.Path, default=TOP / "build/release/bezel")
    p.add_argument("--out", type=pathlib.Path, default=TOP / "build/demo", metavar="DIR")
    o = p.parse_args(argv)
    try:
        draw(o.bezel, o.out)
    except (Unreadable, OSError) as error:
        print(f"demo: error: {error}", file=sys.stderr)
        return 1
    print(f"decks in {TOP / 'input'}, results in {o.out}; look at {o.out / 'cube.png'}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
