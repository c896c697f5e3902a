"""Print the results of this implementation and, on request, those of the program.

    .venv/bin/python -m verification.reference section4 [--n 1 2 4]
    .venv/bin/python -m verification.reference hemisphere [--mu 0 0.5] [--degrees 180] [--mesh 1]
    .venv/bin/python -m verification.reference strip [--lift 1]
    .venv/bin/python -m verification.reference all --compare build/release/bezel

With --compare, the program runs the decks of verification/benchmark, and its results are printed
below ours. Differences are relative to the largest value of the column in that run. The exit code
is 1 if a difference exceeds BOUND. --elements NAME ... selects elements.
"""

import argparse
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

from post._table import read_table
from verification import TOP
from verification.reference import hemisphere, section4, strip

DECKS = TOP / "verification/benchmark"
BOUND = 1e-8  # of the differences; the largest ones measured are on the page reference.md


def main(argv=None):
    """Run the chosen problems, print a table of each, return the exit code."""
    o = parser().parse_args(argv)
    scenes = {"section4": run_section4, "hemisphere": run_hemisphere, "strip": run_strip}
    worst = 0.0
    for name, scene in scenes.items():
        if o.scene in (name, "all"):
            worst = max(worst, scene(o))
            print(flush=True)
    if o.compare:
        print(f"largest difference {worst:.1e}, bound {BOUND:.0e}")
    return int(worst > BOUND)


def parser():
    p = argparse.ArgumentParser(prog="python -m verification.reference", description=__doc__)
    p.formatter_class = argparse.RawDescriptionHelpFormatter
    p.add_argument("scene", choices=("section4", "hemisphere", "strip", "all"))
    p.add_argument("--compare", metavar="BEZEL", help="the program to compare with")
    p.add_argument("--elements", nargs="+", metavar="NAME")
    p.add_argument("--n", nargs="+", type=int, default=[1, 2, 4], help="meshes of section 4")
    p.add_argument("--prism-points", type=int, default=3, help="points of prisms Q1E9N2 along zeta")
    p.add_argument("--mu", nargs="+", type=float, default=[0.0, 0.5], help="friction coefficients")
    p.add_argument(
        "--degrees",
        type=int,
        default=180,
        help="final rotation, a multiple of 3; every 15 degrees are printed",
    )
    p.add_argument("--down", type=int, default=20, help="number of steps of the indentation")
    p.add_argument(
        "--slide",
        default="exact",
        choices=("exact", "tangent"),
        help="update of sliding points, see contact.py",
    )
    p.add_argument("--mesh", type=int, default=1, choices=(1, 2), help="mesh of the hemisphere")
    p.add_argument(
        "--lift",
        type=float,
        default=1.0,
        help="final lift of the strip, a multiple of 0.25 up to 5",
    )
    return p


def run_section4(o):
    heading = ("test", "elements", "n", "dofs", "force")
    rows = Rows(heading, 4, o.compare)
    for test, lift in section4.LIFTS.items():
        for name in chosen(o, section4.ELEMENTS):
            for n in o.n:
                force, dofs = section4.solve(name, n, lift, prism_points=o.prism_points)
                other = None
                if o.compare:
                    deck = DECKS / "section4" / f"{deck_name(name)}.inp"
                    curve = program(o.compare, deck, "force", n=n, u=lift)
                    other = curve["force_3"][-1:, None]
                rows.add([(test, name, n, dofs)], [[force]], other)
    return rows.worst


def run_hemisphere(o):
    heading = ("elements", "mu", "degrees", "P1", "M1", "P2", "M2", "t1", "t2")
    rows = Rows(heading, 3, o.compare)
    for name in chosen(o, hemisphere.ELEMENTS):
        for mu in o.mu:
            table = np.array(
                list(hemisphere.run(name, mu, o.mesh, o.degrees, o.slide == "exact", o.down))
            )
            other = None
            if o.compare:
                n, m, k, eps = hemisphere.MESHES[o.mesh]
                values = {"n": n, "m": m, "k": k, "eps": eps, "mu": mu}
                values |= {"down": o.down, "turn": o.degrees // 3}
                deck = DECKS / "section5_contact" / f"{deck_name(name)}.inp"
                curve = program(o.compare, deck, "sole", **values)
                words = [f"contact_sole_{s}_{w}" for s in (1, 2) for w in ("force_3", "torque")]
                words += [f"contact_sole_{s}_tangential_1" for s in (1, 2)]
                at = pick(curve["time"], 1 + table[:, 0] / 180)
                other = np.stack([curve[w][at] for w in words], axis=1)
            labels = [(name, f"{mu:g}", f"{angle:.0f}") for angle in table[:, 0]]
            rows.add(labels, table[:, 1:], other, shown=slice(None, None, 5))
    return rows.worst


def run_strip(o):
    heading = ("elements", "lift", "lifted edge", "clamped side")
    rows = Rows(heading, 2, o.compare)
    for name in chosen(o, strip.ELEMENTS):
        table = np.array(list(strip.run(name, o.lift, round(o.lift / 0.25))))
        other = None
        if o.compare:
            deck = DECKS / "section5_peeling" / f"{deck_name(name)}.inp"
            curve = program(o.compare, deck, "peel")
            at = pick(curve["disp_3"], table[:, 0])
            other = np.stack([curve["force_3"][at], curve["force_3_2"][at]], axis=1)
        rows.add([(name, f"{lift:.2f}") for lift in table[:, 0]], table[:, 1:], other)
    return rows.worst


def chosen(o, names):
    return [n for n in names if not o.elements or n in o.elements]


def deck_name(elements):
    """The name of the deck of an element type.

    >>> deck_name("Q1E9+Q1N2.1"), deck_name("Q1N2 on 1+ and 2+")
    ('q1e9_q1n2.1', 'q1n2_2')
    """
    kind, _, faces = elements.lower().partition(" on ")
    kind = kind.removeprefix("q1e9+") if kind.endswith("+q1e9n2") else kind.removeprefix("q2+")
    return kind.replace("+", "_") + (f"_{faces.count('and') + 1}" if faces else "")


def program(bezel, deck, curve, **values):
    """The columns of a curve of the program, for a deck run with these parameters."""
    sets = [w for k, v in values.items() for w in ("--set", f"{k}={v:g}")]
    with tempfile.TemporaryDirectory() as folder:
        command = [
            pathlib.Path(bezel).resolve(),
            "--quiet",
            "-o",
            folder,
            "--name",
            "run",
            *sets,
            deck,
        ]
        subprocess.run(command, check=True)
        return read_table(pathlib.Path(folder) / f"run_{curve}.dat").columns


def pick(column, wanted):
    """The rows in which a column has the wanted values."""
    at = abs(column[:, None] - wanted).argmin(axis=0)
    if (abs(column[at] - wanted) > 1e-9).any():
        sys.exit("reference: error: the program has no row at one of the steps")
    return at


class Rows:
    """A table that is printed as it grows: a row of our numbers, and below it those of the
    program.
    """

    def __init__(self, heading, labels, compare):
        self.compare, self.worst = compare, 0.0
        self.widths = [max(13, len(h)) for h in heading]
        self.widths[:labels] = [max(8, len(h)) for h in heading[:labels]]
        if "elements" in heading:
            self.widths[heading.index("elements")] = 25
        self.write([*heading, *(["difference"] if compare else [])])

    def write(self, words):
        last = words[len(self.widths) :]
        print("  ".join([w.rjust(n) for w, n in zip(words, self.widths)] + last), flush=True)

    def add(self, labels, numbers, other=None, shown=slice(None)):
        """Add the rows of one run; only those in the slice `shown` are printed, but all are
        compared.
        """
        numbers = np.asarray(numbers)
        values = lambda row: [f"{v:.9f}" if abs(v) > 5e-10 else "0" for v in row]
        if other is not None:
            scale = abs(other).max(axis=0)
            off = abs(numbers - other) / np.where(scale > 0, scale, 1)
            self.worst = max(self.worst, off.max())
        for i in range(len(labels))[shown]:
            words = [str(w) for w in labels[i]]
            if other is None:
                self.write(words + values(numbers[i]))
            else:
                self.write(words + values(numbers[i]) + [f"{off[i].max():.1e}"])
                self.write([""] * (len(words) - 1) + ["program"] + values(other[i]))


if __name__ == "__main__":
    sys.exit(main())
