"""Compare the speed of bezel with FElupe and CalculiX; `make bench` runs it.

    python -m verification.performance.bench [--n 16] [--rounds 2] [--parts PROGRAM ...]

All programs solve the cube of cube.inp with one thread. Every run is made between two runs of bezel
with full Newton iteration (A B A), and the targets concern only ratios within such a triple, so
that other work on the machine hardly matters. The results, medians over the rounds, are written to
build/bench/bench.json and bench.md and compared with record.json; with `--record` they replace it.
A slow run is not an error: the exit code is 0 if bezel runs and its force agrees with that of
FElupe.
"""

import argparse
import datetime
import json
import pathlib
import re
import statistics
import sys

from verification.performance import bench_contact, bench_page, bench_peel
from verification.performance import bench_runs as runs
from verification.performance import bench_table as table

HERE = pathlib.Path(__file__).resolve().parent
RECORD = HERE / "record.json"
FULL = "full"
OURS = {  # name of a run: element, FACTor
    "default": ("Q1", "AUTO"),
    "reuse": ("Q1", "REUSe"),
    "single": ("Q1", "SINGle"),
    "reuse, Q1E9": ("Q1E9", "REUSe"),
}
OTHERS = ("felupe", "felupe, symmetric", "calculix")
PROJECTIONS = (  # the columns that bench_projection prints
    "projection, {}, from a hundredth of an element away",
    "projection, {}, from a tenth of an element away",
    "projection, {}, from the grid",
    "update of a surface, {}, an element",
)
SAME_FORCE = 1e-6  # relative difference allowed between bezel and FElupe


def main():
    """Time all programs, print the results and compare them with the record."""
    o = parser().parse_args()
    folder = pathlib.Path(o.out).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    bezel = str(pathlib.Path(o.bezel).resolve())
    parts = {}
    for program in map(pathlib.Path, o.parts):
        print(f"bench: {program.name}", flush=True)
        arguments = [str(o.n)] if "solver" in program.name else []
        for _ in range(
            1 if arguments else 3
        ):  # the kernels take only seconds, and their times vary
            found = runs.run_program(program.resolve(), folder, arguments)
            parts[program.name] = parts.get(program.name, "") + found
    if o.only:
        return add_part(o.only, bezel, folder, parts, o.record)
    result = {
        "date": datetime.date.today().isoformat(),
        "n": o.n,
        "rounds": o.rounds,
        "machine": runs.machine("".join(parts.values())),
        "missing": [],
    }
    result["runs"] = time_cube(bezel, folder, o.n, o.rounds, result["missing"])
    result["kernels"] = read_kernels(parts)
    result["contact"] = bench_contact.time_contact(bezel, folder, result["missing"])
    result["peel"] = bench_peel.time_peel(bezel, folder)
    return finish(result, folder, parts, o.record)


def add_part(name, bezel, folder, parts, keep):
    """Time contact or debonding, and the parts, anew; take everything else from the record."""
    result = json.loads(RECORD.read_text())
    result["missing"] = []
    if name == "peel":
        result["peel"] = bench_peel.time_peel(bezel, folder)
    else:
        result["contact"] = bench_contact.time_contact(bezel, folder, result["missing"])
    result["kernels"] |= read_kernels(parts)
    machine = runs.machine("".join(parts.values()))
    result.setdefault("later", {})[name] = {
        "date": datetime.date.today().isoformat(),
        "machine": machine,
    }
    return finish(result, folder, parts, keep)


def parser():
    """The options of the command line."""
    p = argparse.ArgumentParser(
        prog="python -m verification.performance.bench", description=__doc__.split("\n\n")[0]
    )
    p.add_argument("--bezel", default="build/release/bezel")
    p.add_argument("--out", default="build/bench", help="folder for all files")
    p.add_argument("--n", type=int, default=16, help="elements along half an edge (8 is quick)")
    p.add_argument("--rounds", type=int, default=2)
    p.add_argument("--parts", nargs="*", default=[], help="programs that each time a part of bezel")
    p.add_argument(
        "--only",
        choices=["contact", "peel"],
        help="time only this and the parts; take everything else from the record",
    )
    p.add_argument("--record", action="store_true", help="save this run as record.json")
    return p


def time_cube(bezel, folder, n, rounds, missing):
    """{name: {"wall", "cpu", ..., "run_cpu", "iteration_cpu", "run_wall", "iteration_wall"}}; the
    last four are ratios to the adjacent full runs, of the whole run and per iteration.
    """
    samples, pairs = {}, {}
    names = [*OURS, *OTHERS]

    def full():
        return note(samples, FULL, runs.run_bezel(bezel, folder, FULL, n, factor="FULL"))

    for turn in range(rounds):
        before = full()
        for name in list(names):
            print(f"bench: round {turn + 1} of {rounds}, {name}", flush=True)
            try:
                found = note(samples, name, run_one(bezel, folder, name, n))
            except runs.Unavailable as reason:
                missing.append(str(reason))
                names.remove(name)
                continue
            after = full()
            pairs.setdefault(name, []).append((before, found, after))
            before = after
    rows = {name: summary(list_) for name, list_ in samples.items()}
    for name, triples in pairs.items():
        for clock in ("cpu", "wall"):
            rows[name][f"run_{clock}"], rows[name][f"iteration_{clock}"] = ratios(triples, clock)
    return rows


def run_one(bezel, folder, name, n):
    """Make one run that is not the one with full Newton iteration."""
    if name in OURS:
        element, factor = OURS[name]
        return runs.run_bezel(bezel, folder, name.replace(", ", "_"), n, element, factor)
    place = folder / name.replace(", ", "_")
    place.mkdir(exist_ok=True)
    if name == "calculix":
        return runs.run_calculix(place, n)
    if name == "felupe, symmetric":
        return runs.run_felupe(place, n, "symmetric")
    try:
        return runs.run_felupe(place, n, "pardiso") | {"solver": "Pardiso"}
    except runs.Unavailable:
        return runs.run_felupe(place, n, "superlu") | {"solver": "SuperLU (no pypardiso)"}


def note(samples, name, found):
    """Record a sample; stop if a run of bezel failed."""
    if found.get("code"):
        sys.exit(f"bench: error: bezel ended with {found['code']}: {found['message']}")
    samples.setdefault(name, []).append(found)
    return found


def summary(samples):
    """Medians over the rounds, and those values that do not vary between rounds."""
    row = dict(samples[-1])
    for key in ("wall", "cpu", "share", "memory"):
        if key in row:
            row[key] = statistics.median(s[key] for s in samples)
    row["samples"] = len(samples)
    return row


def ratios(triples, clock):
    """Medians of (other run / full run), and of the same ratio per iteration."""
    whole, each = [], []
    for before, other, after in triples:
        full_run = (before[clock] + after[clock]) / 2
        whole.append(other[clock] / full_run)
        each.append(whole[-1] * before["iterations"] / other["iterations"])
    return statistics.median(whole), statistics.median(each)


def read_kernels(parts):
    """{"dgemm": GFLOP/s, element and law: us} from the output of bench_kernel; the best of its
    runs.
    """
    found = {}

    def note_value(key, value):
        found.setdefault(key, []).append(float(value))

    for line in "".join(parts.values()).splitlines():
        if m := re.match(r"\s*dgemm\s+(\d+):\s+([\d.]+)", line):
            note_value(f"dgemm {m[1]} [GFLOP/s]", m[2])
        elif m := re.match(r"\s*(\w+ degree \d+)" + r"\s+(\d+\.\d+)" * 4 + r"\s*$", line):
            for what, value in zip(PROJECTIONS, m.groups()[1:]):
                note_value(f"{what.format(m[1])} [us]", value)
        elif m := re.match(r"\s*(\w+)\s+(\d+)\s+\d+\s+(\w+)\s+(-|[\d.]+)\s+([\d.]+)\s*$", line):
            note_value(f"{m[1]}, {m[2]} nodes, {m[3]} [us]", m[5] if m[4] == "-" else m[4])
    return {key: max(list_) if "FLOP" in key else min(list_) for key, list_ in found.items()}


def finish(result, folder, parts, keep):
    """Write and print the result, compare it with the record; return the exit code."""
    record = json.loads(RECORD.read_text()) if RECORD.exists() else None
    text = table.render(result, record, SAME_FORCE)
    (folder / "bench.json").write_text(json.dumps(result, indent=1) + "\n")
    (folder / "bench.md").write_text(text)
    (folder / "parts.txt").write_text("\n".join(parts.values()))
    if keep:
        RECORD.write_text(json.dumps(result, indent=1) + "\n")
        bench_page.PAGE.write_text(bench_page.page(result))
    print(text)
    print(f"bench: written to {folder}/bench.md, bench.json, parts.txt")
    return 0 if table.same_force(result, SAME_FORCE) else 1


if __name__ == "__main__":
    sys.exit(main())
