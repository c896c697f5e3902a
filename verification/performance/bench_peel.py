"""Debonding in `make bench`: the strip of section 5.1, mesh 2, IGA2, peeled to its end. One
thread.
"""

import json
import pathlib

from verification.performance import bench_runs as runs
from verification.performance.bench_contact import PARTS

DECKS = pathlib.Path(__file__).resolve().parents[1] / "benchmark/section5_debonding"


def time_peel(bezel, folder):
    """Time a whole process: seconds, steps, iterations, and the share of contact."""
    print("bench: debonding, mesh 2, IGA2", flush=True)
    folder = folder / "peel"
    folder.mkdir(exist_ok=True)
    command = [bezel, "--quiet", "--threads", "1", "-o", str(folder), "--set=r=2"]
    wall, cpu, _, code, _, errors = runs.measure([*command, str(DECKS / "iga2.inp")], folder)
    if code:
        raise SystemExit(f"bench: error: bezel ended with {code}: {errors.strip()}")
    report = json.loads((folder / "iga2.report.json").read_text())
    seconds = report["seconds"]
    solving = sum(seconds[part] for part in PARTS)
    counts = {key: report[key] for key in ("steps", "iterations", "cutbacks", "equations")}
    return counts | {"wall": wall, "cpu": cpu, "share": seconds["contact"] / solving}


def table(r):
    """The table, which has one row."""
    return (
        "A strip is peeled off a plate until it is free (section 5.1, mesh 2, IGA2, 10 x 10 integration points, `BALAnced`). "
        "The times are those of the whole process.\n\n"
        "| equations | steps | cut-backs | iterations | CPU s | ms per iteration | fraction of contact |\n"
        "|--:|--:|--:|--:|--:|--:|--:|\n"
        f"| {r['equations']} | {r['steps']} | {r['cutbacks']} | {r['iterations']} | {r['cpu']:.0f} "
        f"| {1e3 * r['cpu'] / r['iterations']:.0f} | {100 * r['share']:.0f} % |\n"
    )
