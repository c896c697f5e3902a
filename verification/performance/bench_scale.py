"""Time and memory of one load step against the size of the model: `make bench ARGS=--scale`.

    python -m verification.performance.bench_scale [--bezel PROGRAM] [--out DIR] [--sizes 8 16 ...]

The cube of section 4 with n x n x 2n elements takes one step with default settings (FACTor AUTO),
on one thread. A size already measured with the same program is not measured again, so that an
interrupted study can be continued. --record saves the results and writes doc/verification/scale.md
and its figure.
"""

import argparse
import datetime
import json
import pathlib
import re

import numpy as np

from post import _style
from verification.performance import bench_runs as runs

HERE = pathlib.Path(__file__).resolve().parent
DOC = HERE.parents[1] / "doc/verification"
RECORD = HERE / "scale.json"
SIZES = (8, 12, 16, 24, 32, 40, 56)
WAYS_AT = 32  # size at which the ways of storing factors are compared
#: FACTor, and the limit of the address space [MB] that makes the program choose each way at
#: WAYS_AT.
WAYS = (("FULL", None), ("AUTO", None), ("FULL", 2200), ("AUTO", 1500))
NOTE = "factors are computed "
DGEMM = "dgemm 500 [GFLOP/s]"  # the entry of record.json, in double precision
PARTS = ("assembly", "analyse", "factorise", "solve")

PAGE = """# Size of models

## Summary

- **Measured:** CPU time and memory of one load step of a cube with {small:,} to {large:,} equations, with default settings, on one thread.
- **Main result:** {main}
- **Command:** `make bench ARGS=--scale`; `--record` after it writes this page from `verification/performance/scale.json`.

## One step, by size

{machine}

The cube of section 4, n x n x 2n trilinear elements (Q1), is compressed by 5 % in one step with the default `FACTor AUTO`: factors in single
precision are made once and kept, and iterations with the tangent and the residual in double precision reach the usual tolerance. Models below about 12,000 equations are factorised in double precision in every iteration.

{sizes}

![CPU time and memory against the number of equations](figures/scale.png)

- Between the two largest models the CPU time grows as the number of equations to the power {time_power:.2f}, and the memory to the power {memory_power:.2f}.
  For nested dissection of a cube the limits are 2 for the operations and 4/3 for the entries of the factors.
- If the error of the force decreased as the square of the element size, n = {fit[0]} and n = {fit[1]} would give {predicted:.9f} for n = {fit[2]};
  the run gives {found:.9f} (relative difference {difference:.1e}). Because of the clamped edges the true power is a little smaller.

## When memory is short

One step with n = {ways_at} is solved in four ways. The limit is that of `ulimit -v`; the program chooses the way itself and names it in the log.

{ways}

## Extrapolation: ten million unknowns and a thousand ranks

This section is an estimate; nothing in it was run. Its constants are those measured above for {large:,} equations: {per_equation:.1f} KB of memory per equation in all.
`--check` of that model, which stores mesh, state, pattern and analysis but no factors, takes {state_kb:.1f} KB per equation.

- **The factors** of $10^7$ equations ($n = {n_big}$) take {factors_big:,.0f} GiB in single precision, by the power 4/3, and {hours_big:,.0f} hours on one core of the
  machine used, by the power 2. On a thousand ranks with an efficiency of 0.5, one factorisation would take {minutes_big:.1f} minutes.
- **The root front** belongs to a separator of about $3 n^2$ = {root:,.0f} unknowns and takes {root_gb:.1f} GiB in single precision. MUMPS distributes it in two
  dimensions only with ScaLAPACK, which bezel switches off because only the usual elimination counts negative pivots. At twice the measured rate of dgemm (single precision)
  one rank takes {root_minutes:.1f} minutes for it, so no number of ranks can be more than {speed_up:,.0f} times as fast as one.
- **The replicated state:** with `MPI=1` every rank stores mesh, state and pattern, which is {state_gb:.0f} GiB for $10^7$ equations. A node with 64 ranks would
  need {node_gb:,.0f} GiB for that alone, so this design is limited to a few ranks per node with several threads each. Larger models need a
  distributed mesh as well.
"""


def measure(bezel, folder, name, n, factor, limit=None):
    """The results of one step of the cube, or those measured earlier with the same program."""
    kept = folder / f"{name}.scale.json"
    stamp = pathlib.Path(bezel).stat().st_mtime
    if kept.exists():
        row = json.loads(kept.read_text())
        if row["stamp"] == stamp:
            return row
    print(f"bench: one step, n = {n}, {factor}" + (f", {limit} MB" if limit else ""), flush=True)
    row = runs.run_bezel(bezel, folder, name, n, factor=factor, steps=1, limit_mb=limit)
    if "code" in row:
        raise SystemExit(f"bench: error: bezel ended with {row['code']}: {row['message']}")
    row |= {"n": n, "factor": factor, "limit": limit, "stamp": stamp}
    row |= json.loads((folder / f"{name}.report.json").read_text())["cpu_seconds"]
    notes = [line for line in (folder / f"{name}.log").read_text().splitlines() if NOTE in line]
    row["way"] = notes[-1].split(NOTE)[1] if notes else ""
    kept.write_text(json.dumps(row, indent=1) + "\n")
    return row


def machine():
    """A line that describes the machine."""
    m = runs.machine("")
    return (
        f"Machine: {m['cpu']}, {m['cores']} cores, {m['memory_gib']} GiB; one thread; gfortran {m['gfortran']}, "
        f"MUMPS {m['mumps']}, OpenBLAS {m['openblas']}."
    )


def table(rows):
    """One row for each size."""
    lines = [
        "| n | equations | iterations | CPU s | assembly | analysis | factors | solves | wall s | peak GiB | force |",
        "|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|",
    ]
    for r in rows:
        parts = " | ".join(f"{r[part]:.2f}" for part in PARTS)
        lines.append(
            f"| {r['n']} | {r['equations']:,} | {r['iterations']} | {r['cpu']:.1f} | {parts} "
            f"| {r['wall']:.1f} | {r['memory'] / 1024:.2f} | {r['force']:.9f} |"
        )
    return "\n".join(lines)


def ways_table(rows):
    """One row for each way of storing factors."""
    lines = [
        "| FACTor | limit MB | factors | CPU s | wall s | peak GiB | force against the first |",
        "|---|--:|---|--:|--:|--:|--:|",
    ]
    for r in rows:
        plain = {"FULL": "in double precision", "AUTO": "in single precision"}[r["factor"]]
        lines.append(
            f"| {r['factor']} | {r['limit'] or '-'} | {r['way'] or plain} | {r['cpu']:.1f} | {r['wall']:.1f} "
            f"| {r['memory'] / 1024:.2f} | {r['force'] / rows[0]['force'] - 1:.0e} |"
        )
    return "\n".join(lines)


def extrapolate(rows):
    """The force at the largest n, extrapolated from the two smaller sizes for an error that
    decreases as 1/n^2.
    """
    a, b, c = rows[-3:]
    slope = (a["force"] - b["force"]) / (a["n"] ** -2 - b["n"] ** -2)
    return b["force"] + slope * (c["n"] ** -2 - b["n"] ** -2)


def on_paper(row, check, dgemm):
    """The estimates for 1e7 equations; dgemm is the rate in single precision [FLOP/s], estimated as
    twice the measured one in double precision.
    """
    growth = 1e7 / row["equations"]
    n = row["n"] * growth ** (1 / 3)
    root = 3 * n**2
    hours = row["factorise"] * growth**2 / 3600
    minutes = root**3 / 3 / dgemm / 60
    return {
        "per_equation": row["memory"] * 1024 / row["equations"],
        "n_big": round(n),
        "factors_big": check["factors"] * growth ** (4 / 3) / 1024,
        "hours_big": hours,
        "minutes_big": hours * 60 / 500,
        "root": root,
        "root_gb": 4 * root**2 / 2 / 2**30,
        "root_minutes": minutes,
        "speed_up": hours * 60 / minutes,
        "state_kb": check["peak"] * 1024 / row["equations"],
        "state_gb": check["peak"] * growth / 1024,
        "node_gb": 64 * check["peak"] * growth / 1024,
    }


def memory_of_check(bezel, folder, n):
    """The memory that --check estimates for factors in single precision, and the peak memory of
    --check itself [MB].
    """
    command = [bezel, "--check", "--set", f"n={n}", str(HERE / "cube.inp")]
    _, _, peak, _, output, _ = runs.measure(command, folder)
    found = re.search(r"about (\S+) MB in single precision\n", output)
    return {"factors": float(found[1]), "peak": peak}


def draw(rows, path):
    """Plot CPU time and memory against the number of equations, with the powers of nested
    dissection.
    """
    with _style.styled() as plt:
        figure, axes = plt.subplots(1, 2, figsize=(_style.PAGE, 2.9))
        neq = np.array([r["equations"] for r in rows])
        time = np.array([r["cpu"] for r in rows])
        memory = np.array([r["memory"] / 1024 for r in rows])
        for axis, value, power, label, slope in (
            (axes[0], time, 2.0, "CPU time of a step [s]", "power 2 (operations)"),
            (axes[1], memory, 4 / 3, "peak memory [GiB]", "power 4/3 (entries of factors)"),
        ):
            axis.loglog(neq, value, "o-", color=_style.COLOURS[0], label="measured")
            axis.loglog(neq[-3:], value[-1] * (neq[-3:] / neq[-1]) ** power, "--",
                        color=_style.COLOURS[1], label=slope)  # fmt: skip
            axis.set(xlabel="equations", ylabel=label)
            axis.legend()
        figure.savefig(path)


def page(record):
    """The text of the page."""
    rows, ways = record["sizes"], record["ways"]
    a, b = rows[-2:]
    grow = np.log(b["equations"] / a["equations"])
    predicted = extrapolate(rows)
    return PAGE.format(
        small=rows[0]["equations"],
        large=b["equations"],
        main=f"{b['equations']:,} equations take {b['cpu']:.0f} s of CPU time, {b['wall']:.0f} s of wall-clock time and "
        f"{b['memory'] / 1024:.1f} GiB.",
        machine=record["machine"],
        sizes=table(rows),
        time_power=np.log(b["cpu"] / a["cpu"]) / grow,
        memory_power=np.log(b["memory"] / a["memory"]) / grow,
        fit=[r["n"] for r in rows[-3:]],
        predicted=predicted,
        found=b["force"],
        difference=abs(predicted / b["force"] - 1),
        ways_at=WAYS_AT,
        ways=ways_table(ways),
        **on_paper(b, record["check"], record["dgemm"]),
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n", maxsplit=1)[0])
    parser.add_argument("--bezel", default="build/release/bezel")
    parser.add_argument("--out", default="build/bench/scale", help="folder for all files")
    parser.add_argument("--sizes", type=int, nargs="+", default=SIZES)
    parser.add_argument("--record", action="store_true", help="save the results and write the page")
    o = parser.parse_args()
    bezel, folder = str(pathlib.Path(o.bezel).resolve()), pathlib.Path(o.out).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    record = {"date": datetime.date.today().isoformat()}
    record["sizes"] = [measure(bezel, folder, f"cube_{n}", n, "AUTO") for n in o.sizes]
    record["ways"] = [
        measure(bezel, folder, f"way_{i}", WAYS_AT, factor, limit)
        for i, (factor, limit) in enumerate(WAYS)
    ]
    record["check"] = memory_of_check(bezel, folder, o.sizes[-1])
    record["dgemm"] = 2e9 * json.loads((HERE / "record.json").read_text())["kernels"][DGEMM]
    record["machine"] = machine()
    print(table(record["sizes"]), ways_table(record["ways"]), sep="\n\n")
    if o.record:
        RECORD.write_text(json.dumps(record, indent=1) + "\n")
        (DOC / "scale.md").write_text(page(record))
        draw(record["sizes"], DOC / "figures/scale.png")


if __name__ == "__main__":
    main()
