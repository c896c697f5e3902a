"""Times the quarter cube of section 4 (n = 16 unless set) on one core, beside FElupe and CalculiX where they are installed.

usage: bench.py [--bezel build/release/bezel] [--n 16] [--update]

Prints processor seconds of whole runs and of an iteration, forces, and the change against record.json, which --update
rewrites. FElupe: `tools/setup.sh bench` installs tools/requirements-bench.txt into .venv; CalculiX: apt install calculix-ccx.
"""

import argparse
import json
import os
import pathlib
import platform
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
TOP = HERE.parent.parent
LIFT, STEPS = -0.25, 5
ONE = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}
WAYS = {"full": "bezel", "reuse": "bezel, FACTor REUSe", "single": "bezel, FACTor SINGle"}


def main(argv=None):
    """Run everything, print the table; returns the exit code."""
    p = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    p.add_argument("--bezel", type=pathlib.Path, default=TOP / "build/release/bezel")
    p.add_argument("--n", type=int, default=16, help="elements along half an edge (default 16)")
    p.add_argument("--update", action="store_true", help="write record.json")
    o = p.parse_args(argv)
    rows = {}
    with tempfile.TemporaryDirectory() as folder:
        for way, label in WAYS.items():
            rows[label] = run_bezel(o.bezel.resolve(), way, o.n, folder)
        rows["FElupe"] = run_felupe(o.n)
        rows["CalculiX"] = run_calculix(o.n, folder)
    record_file = HERE / "record.json"
    record = json.loads(record_file.read_text()) if record_file.exists() else {}
    print_table(rows, o.n, record)
    if o.update:
        machine = {"processor": processor(), "n": o.n}
        kept = {label: row for label, row in rows.items() if row}
        record_file.write_text(json.dumps({"machine": machine, "runs": kept}, indent=2) + "\n")
    return 0


def processor_seconds(command, **options):
    """User and system seconds of a command, and its result."""
    before = os.times()
    result = subprocess.run(
        command, env=os.environ | ONE, capture_output=True, text=True, **options
    )
    after = os.times()
    seconds = (
        after.children_user + after.children_system - before.children_user - before.children_system
    )
    if result.returncode != 0:
        sys.exit(
            f"bench: {' '.join(map(str, command))} ended with code {result.returncode}\n{result.stderr}"
        )
    return seconds, result


def run_bezel(bezel, way, n, folder):
    """One of our ways to solve linear systems."""
    deck = HERE / "cube" / f"{way}.inp"
    command = [bezel, "--quiet", "--threads", "1", "--set", f"n={n}", "-o", folder, deck]
    seconds, _ = processor_seconds(command)
    report = json.loads((pathlib.Path(folder) / f"{way}.report.json").read_text())
    parts, total = report["seconds"], report["seconds"]["total"]
    return {
        "iterations": report["iterations"],
        "seconds": seconds,
        "force": report["final"]["force"]["force_3"],
        "assembly": parts["assembly"] / total,
    }


def run_felupe(n):
    """FElupe in the Python of .venv; None where it is not installed. Its import is not counted."""
    script = HERE / "cube" / "felupe_cube.py"
    if subprocess.run([sys.executable, "-c", "import felupe"], capture_output=True).returncode != 0:
        return None
    _, result = processor_seconds([sys.executable, script, str(n), str(LIFT), str(STEPS)])
    return json.loads(result.stdout)


def run_calculix(n, folder):
    """CalculiX; None where it is not installed."""
    if not shutil.which("ccx"):
        return None
    command = [sys.executable, HERE / "cube" / "calculix_cube.py", str(n), str(LIFT), str(STEPS)]
    deck = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    (pathlib.Path(folder) / "cube.inp").write_text(deck)
    seconds, _ = processor_seconds(["ccx", "-i", "cube"], cwd=folder)
    increments = (pathlib.Path(folder) / "cube.sta").read_text().splitlines()[2:]
    total = (pathlib.Path(folder) / "cube.dat").read_text().split()
    return {
        "iterations": sum(int(line.split()[3]) for line in increments),
        "seconds": seconds,
        "force": float(total[-1]),
    }


def print_table(rows, n, record):
    """What was measured, and against the record of this processor."""
    print(
        f"\ncube, {n} x {n} x {2 * n} Q1 elements, {STEPS} steps, one core of {processor()}; processor seconds"
    )
    print(
        f"{'':24}{'iterations':>11}{'seconds':>9}{'each':>9}{'of full':>9}{'force':>14}{'record':>9}"
    )
    full = rows["bezel"]
    same = record.get("machine") == {"processor": processor(), "n": n}
    for label, row in rows.items():
        if row is None:
            print(f"{label:24}not installed")
            continue
        each = row["seconds"] / row["iterations"]
        ratio = each / (full["seconds"] / full["iterations"])
        if label.startswith("bezel,"):
            ratio = row["seconds"] / full["seconds"]
        old = record.get("runs", {}).get(label) if same else None
        change = f"{100 * (row['seconds'] / old['seconds'] - 1):+8.0f}%" if old else f"{'-':>9}"
        print(
            f"{label:24}{row['iterations']:11}{row['seconds']:9.2f}{each:9.3f}{ratio:9.2f}{row['force']:14.8f}{change}"
        )
    print("of full: whole run, for our own ways; time of an iteration, for the other codes")
    print(f"assembly takes {100 * full['assembly']:.1f} % of the full run")


def processor():
    """Name of the processor."""
    try:
        lines = pathlib.Path("/proc/cpuinfo").read_text().splitlines()
        return next(
            line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")
        )
    except (OSError, StopIteration):
        return platform.processor() or "unknown"


if __name__ == "__main__":
    sys.exit(main())
