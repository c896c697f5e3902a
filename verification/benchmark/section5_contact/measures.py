"""The tables of doc/verification/section5_contact.md, computed from runs/*.dat and
runs/summary.csv.

    .venv/bin/python -m verification.benchmark.section5_contact.measures [--write]

It prints the tables; `--write` puts them into the page, between `<!-- table: name -->` and
`<!-- end -->`.
"""

import csv
import sys

import numpy as np

from post._table import read_table
from post.figures.section5_contact import DOFS, SLIDING, Runs, read_runs, reference_force
from verification import TOP
from verification.page import put_table

HERE = TOP / "verification/benchmark/section5_contact"
PAGE = TOP / "doc/verification/section5_contact.md"
MESHES = ("1", "2", "3")
#: A side slides if a smaller fraction of its points sticks; not zero, since the pole never slides.
STICK = 0.03


def main():
    runs = {(r.mesh, r.elements, r.mu): r for r in read_runs(HERE / "runs")}
    with (HERE / "runs/summary.csv").open(newline="") as text:
        rows = {(r["mesh"], r["elements"], float(r["mu"])): r for r in csv.DictReader(text)}
    tables = {
        "runs": cost(rows),
        "tractions": tractions(rows),
        "torque": torque(runs),
        "force": force(runs),
        "friction": friction(runs),
    }
    text = PAGE.read_text() if PAGE.exists() else ""
    for name, lines in tables.items():
        print(f"{name}\n" + "\n".join(lines) + "\n")
        text = put_table(text, name, "\n".join(lines))
    if "--write" in sys.argv[1:]:
        PAGE.write_text(text)


def table(heading, rows):
    yield "| " + " | ".join(heading) + " |"
    yield "|" + "---|" * len(heading)
    for row in rows:
        yield "| " + " | ".join(row) + " |"


def over_meshes(value, have, key):
    """`value` for each mesh, with a dash for a mesh without a run."""
    return [value(have[key(m)]) if key(m) in have else "-" for m in MESHES]


def cost(rows):
    """Steps, iterations per step, seconds, and the percentage of the seconds spent on contact, for
    meshes 1 to 3.
    """
    shown = []
    for mu in (0.0, 0.5):
        for e in DOFS:
            cells = lambda f, e=e, mu=mu: ", ".join(over_meshes(f, rows, lambda m: (m, e, mu)))
            shown.append([
                e, f"{mu:g}", cells(lambda r: reached(r) + r["steps"]), cells(lambda r: r["iterations_per_step"]),
                cells(lambda r: f"{float(r['seconds']):{'.1f' if float(r['seconds']) < 10 else '.0f'}}"),
                cells(lambda r: f"{100 * float(r['contact_share']):.0f}"),
            ])  # fmt: skip
    head = (
        "elements",
        "$\\mu$",
        "steps",
        "iterations per step",
        "seconds",
        "contact, % of the seconds",
    )
    return list(table(head, shown))


def reached(row):
    return "" if float(row["degrees"]) > 180 - 1e-6 else f"to {row['degrees']} degrees: "


def tractions(rows):
    """Table 5: the values of the paper, our values, and their difference."""
    lines = (HERE / "table5.csv").read_text().splitlines()
    shown = []
    for r in csv.DictReader(line for line in lines if not line.startswith("#")):
        key = (r["mesh"], r["elements"], 0.5)
        cells = [r["elements"] + ("" if r["mesh"] == "2" else f", mesh {r['mesh']}")]
        for side, body in (1, "hemisphere"), (2, "block"):
            paper = float(r[body])
            done = key in rows and not reached(rows[key])
            got = float(rows[key][f"tangential_{side}"]) if done else None
            cells += [f"{paper:.3f}", *((f"{got:.4f}", f"{100 * (got / paper - 1):+.1f} %") if done else ("-", "-"))]  # fmt: skip
        shown.append([*cells, f"{100 * float(r['bound']):.0f} %"])
    head = ("elements", "hemisphere: paper", "ours", "difference", "block: paper", "ours", "difference", "bound")  # fmt: skip
    return list(table(head, shown))


def slopes(have, key, value):
    """Minus the slopes over the number of dofs between successive meshes, on logarithmic scales."""
    got = [have.get(key(m)) for m in MESHES]
    return [
        f"{-np.log(value(b) / value(a)) / np.log(b.dofs / a.dofs):.2f}" if a and b else "-"
        for a, b in zip(got, got[1:])
    ]


def torque(runs):
    """Without friction: the largest torque, how many times larger that of Q1E9 is, the order of
    convergence, and the errors of periodicity and antisymmetry.
    """
    shown = []
    for e in DOFS:
        key = lambda m, e=e: (m, e, 0.0)
        largest = over_meshes(lambda r: f"{r.amplitude():.2e}", runs, key)
        facets = over_meshes(lambda r: f"{runs[r.mesh, 'Q1E9', 0.0].amplitude() / r.amplitude():.1f}" if (r.mesh, "Q1E9", 0.0) in runs else "-", runs, key)  # fmt: skip
        order = slopes(runs, key, lambda r: r.amplitude())
        symmetry = [over_meshes(lambda r, k=k: defects(r)[k], runs, key) for k in (0, 1)]
        shown.append([e, *(", ".join(x) for x in (largest, facets, order, *symmetry))])
    fine = Runs(list(runs.values()), False).reference
    if fine:
        half = max(abs(t[-1]) for t in fine.torque)  # zero by antisymmetry
        words = f"{half:.0e} at {fine.degrees[-1]:.0f} degrees"
        shown.append(["IGA2, reference", f"{fine.amplitude():.2e}", "-", "-", "-", words])
    head = ("elements", "largest torque", "Q1E9 over this type", "slope over dofs", "error of period", "error of antisymmetry")  # fmt: skip
    return list(table(head, shown))


def defects(run):
    """Errors of 90-degree periodicity and of antisymmetry of the torque M at angle t: the largest
    |M(t+90) - M(t)| and |M(90-t) + M(t)| over the largest |M|, for both sides, every 3 degrees.
    """
    if run.degrees[-1] < 180 - 1e-6:
        return "-", "-"
    angles = np.arange(0.0, 90.5, 3.0)
    index = lambda a: np.abs(run.degrees[:, None] - a[None, :]).argmin(axis=0)
    values = [(t[index(angles)], t[index(angles + 90)]) for t in run.torque]
    period = max(np.abs(b - a).max() for a, b in values) / run.amplitude()
    mirror = max(np.abs(a + a[::-1]).max() for a, _ in values) / run.amplitude()
    return f"{period:.0e}", f"{mirror:.0e}"


def force(runs):
    """Without friction: the mean force on the hemisphere and on the block, the error of the mean of
    both, and the variation of the force on the hemisphere during the turn.
    """
    plain = Runs(list(runs.values()), False)
    reference, words = reference_force(plain)
    shown = []
    for e in DOFS:
        key = lambda m, e=e: (m, e, 0.0)
        sides = [over_meshes(lambda r, k=k: f"{r.forces()[k]:.4f}", runs, key) for k in (0, 1)]
        errors = over_meshes(lambda r: f"{100 * (r.mean_force() / reference - 1):+.1f}", runs, key)
        swing = over_meshes(lambda r: f"{100 * np.ptp(np.abs(r.force[0])) / r.forces()[0]:.1f}", runs, key)  # fmt: skip
        shown.append([e, *(", ".join(x) for x in (*sides, errors, swing))])
    head = ("elements", "mean force on the hemisphere", "on the block",
            f"error of their mean, % (of {reference:.4f}, {words})", "variation on the hemisphere, %")  # fmt: skip
    return list(table(head, shown))


def friction(runs):
    """With friction: the torque from 120 degrees on, its deviation, and the angle of full
    sliding.
    """
    shown = []
    for e in DOFS:
        key = lambda m, e=e: (m, e, 0.5)
        columns = [over_meshes(f, runs, key) for f in (
            lambda r: f"{plateau(r)[0]:.3f}/{plateau(r)[1]:.3f}",
            lambda r: "/".join(f"{d:.3f}" for d in deviations(r)),
            lambda r: "/".join(f"{a:.0f}" for a in at_plateau(r)),
            lambda r: "/".join(f"{a:.0f}" for a in sliding_from(r)),
            lambda r: "-" if r.elements == "Q1E9" else "/".join(f"{a:.0f}" for a in all_sliding_from(r)),
        )]  # fmt: skip
        shown.append([e, *(", ".join(x) for x in columns)])
    head = ("elements", "mean torque from 120 degrees on", "largest deviation from it", "99 % of the mean at [degrees]", "full sliding from [degrees]",
            "every point but the pole slides from [degrees]")  # fmt: skip
    return list(table(head, shown))


def late(run):
    return run.degrees >= SLIDING - 1e-6


def plateau(run):
    """Mean torque from 120 degrees on, for the hemisphere and for the block; both are positive in
    the sense in which the block is turned.
    """
    x = run.degrees[late(run)]
    return [abs(np.trapezoid(t[late(run)], x)) / (x[-1] - x[0]) for t in run.torque]


def deviations(run):
    return [np.abs(np.abs(t[late(run)]) - m).max() for t, m in zip(run.torque, plateau(run))]


def at_plateau(run):
    return [run.degrees[np.argmax(np.abs(t) >= 0.99 * m)] for t, m in zip(run.torque, plateau(run))]


def sliding_from(run):
    """The angle beyond which almost no point sticks, for the hemisphere and the block."""
    return [from_angle(run, side, STICK) for side in (1, 2)]


def all_sliding_from(run):
    """The angle beyond which no point sticks, for the hemisphere (ignoring its pole) and the block.

    The share of the point at the pole is taken to be the smallest nonzero share that sticks.
    """
    shares, turned = sticking(run, 1)
    pole = shares[(shares > 0) & (turned > 0)].min()
    return [from_angle(run, 1, 1.5 * pole), from_angle(run, 2, 0.0)]


def from_angle(run, side, share):
    """The angle beyond which at most this share of the points of a side sticks: the last
    angle of the run if there is none, 0 if the share is never larger.
    """
    shares, turned = sticking(run, side)
    above = np.flatnonzero((shares > share) & (turned > 0))
    return turned[min(above[-1] + 1, len(turned) - 1)] if len(above) else 0.0


def sticking(run, side):
    """(share of the points in contact that stick, angle) for each step."""
    columns = read_table(HERE / f"runs/{run.mesh}_{run.elements}_{run.mu:g}.dat").columns
    return columns[f"contact_sole_{side}_stick"], columns["factor_2"] * 180


if __name__ == "__main__":
    main()
