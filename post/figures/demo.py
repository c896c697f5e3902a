"""`make demo` runs two problems and draws them: the stretching of a cube with enriched faces,
beside one with trilinear elements only, and the twisting of a hemisphere on a block with friction.

python -m post.figures.demo --bezel build/release/bezel --out build/demo
"""

import argparse
import pathlib
import subprocess
import sys

from post import _style, contact_map, curve, field
from post._error import Unreadable
from post._table import read_table

TOP = pathlib.Path(__file__).resolve().parents[2]
RUNS = {"cube_q1": "Q1", "cube_enriched": "Q1 with Q1N2 on the faces"}
TWIST = "twist"
STEPS = {
    25: "turned by 15 degrees: most of it sticks",
    80: "turned by 180 degrees: all of it slides",
}
#: Force on a quarter, from the header of verification/benchmark/section4/reference.csv.
CONVERGED = 0.172838925


def run(bezel, out, deck):
    """Run a deck into the folder `out`."""
    command = [str(bezel), "--quiet", "-o", str(out), str(deck)]
    code = subprocess.run(command).returncode
    if code != 0:
        raise Unreadable(f"'{' '.join(command)}' ended with code {code}")


def draw_cubes(bezel, out):
    """Draw the stress in both cubes, and give their forces."""
    for stem in RUNS:
        run(bezel, out, TOP / "input" / f"{stem}.inp")
    forces = [out / f"{s}_force.dat" for s in RUNS]
    errors = [read_table(f).columns["force_3"][-1] / CONVERGED - 1 for f in forces]
    labels = [f"{name}\nforce {100 * e:.2f} % too high" for name, e in zip(RUNS.values(), errors)]
    field.draw([out / f"{s}.vtkhdf" for s in RUNS], out / "cube.png", scalar="mises", labels=labels,
               mirror="xy", say_step=False, view="-52,16", words="von Mises stress / $E$")  # fmt: skip
    labels = list(RUNS.values())
    curve.draw(forces, out / "force.png", x="disp", labels=labels, title="Stretching a cube")


def draw_twist(bezel, out):
    """Plot the torque, and draw the tractions on both surfaces while they stick and while they
    slide.
    """
    run(bezel, out, TOP / "input" / f"{TWIST}.inp")
    files = [out / f"{TWIST}.vtkhdf"] * len(STEPS)
    contact_map.draw(files, out / "twist.png", step=list(STEPS), labels=list(STEPS.values()), say_step=False,
                     words="contact shear $t_x$ / $E$ of the block")  # fmt: skip
    table = read_table(out / f"{TWIST}_sole.dat").columns
    turning = table["factor_1"] >= 1.0
    with _style.styled() as plt:
        figure, ax = plt.subplots(figsize=(4.6, 3.0))
        for i, body in enumerate(("hemisphere", "block")):
            torque = abs(table[f"contact_sole_{i + 1}_torque"][turning])
            line = _style.series(i) | {"marker": None}
            ax.plot(180 * table["factor_2"][turning], torque, label=body, **line)
        ax.set(xlabel="turned by [degrees]", ylabel="torque of the tractions", ylim=(0, None))
        ax.legend()
        _style.save(figure, out / "torque.png")


def main(argv=None):
    p = argparse.ArgumentParser(prog="demo", description="Run three decks and draw their results.")
    p.add_argument("--bezel", type=pathlib.Path, default=TOP / "build/release/bezel")
    p.add_argument("--out", type=pathlib.Path, default=TOP / "build/demo", metavar="DIR")
    o = p.parse_args(argv)
    try:
        draw_cubes(o.bezel, o.out)
        draw_twist(o.bezel, o.out)
    except (Unreadable, OSError) as error:
        print(f"demo: error: {error}", file=sys.stderr)
        return 1
    print(f"decks are in {TOP / 'input'}, results in {o.out}; see cube.png and twist.png there")
    return 0


if __name__ == "__main__":
    sys.exit(main())
