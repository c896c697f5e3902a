"""Compare whole runs of the serial program, of one rank and of two ranks.

    .venv/bin/python -m verification.performance.bench_ranks [--n 24] [--rounds 2] [--deck DECK ...]

The runs of a round follow each other directly, and they are compared by the ratios of their times,
as medians over the rounds, so that other work on the machine hardly matters. Without DECK, two steps of the cube of
cube.inp are solved, once with factors that are kept and once with a factorisation in every
iteration. Below the ratios, the times of the parts of a run (from the logs) show what a second rank
does not speed up.
"""

import argparse
import pathlib
import re
import statistics
import subprocess
import tempfile
import time

from verification import TOP

CUBE = TOP / "verification" / "performance" / "cube.inp"
MPIRUN = ["mpirun", "--allow-run-as-root", "--oversubscribe", "--quiet"]
MPIRUN += ["--mca", "mpi_yield_when_idle", "1"]
PARTS = ("assembly", "contact", "analyse", "factorise", "solve", "krylov", "output")


def run(command, out, deck, options):
    """Make one run; return its seconds in all and by part."""
    begin = time.perf_counter()
    subprocess.run([*command, "--quiet", "-o", str(out), *options, str(deck)], check=True)
    seconds = time.perf_counter() - begin
    log = (out / f"{deck.stem}.log").read_text()
    found = {part: re.search(rf"^{part} +\d+ +([\d.]+)", log, re.MULTILINE) for part in PARTS}
    return seconds, {part: float(match[1]) for part, match in found.items() if match}


def compare(name, programs, deck, options, rounds, top):
    """Print the ratios for a deck."""
    times = {kind: [] for kind in programs}
    parts = {}
    for _ in range(rounds):
        for kind, command in programs.items():
            seconds, parts[kind] = run(command, top / "out", deck, options)
            times[kind].append(seconds)
    one, two = (
        statistics.median(b / a for a, b in zip(times[x], times[y], strict=True))
        for x, y in (("serial", "1 rank"), ("2 ranks", "1 rank"))
    )
    print(f"{name}: 1 rank / serial {one:.2f}, 1 rank / 2 ranks {two:.2f}")
    for kind, found in parts.items():
        print(f"  {kind:8}" + ", ".join(f"{part} {s:.1f} s" for part, s in found.items()))


def main():
    parser = argparse.ArgumentParser(
        prog="python -m verification.performance.bench_ranks", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--bezel", type=pathlib.Path, default=TOP / "build/mpi/bezel")
    parser.add_argument("--serial", type=pathlib.Path, default=TOP / "build/release/bezel")
    parser.add_argument("--n", type=int, default=24, help="elements along half an edge of the cube")
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--deck", type=pathlib.Path, nargs="+", default=[])
    args = parser.parse_args()
    programs = {"serial": [str(args.serial)]}
    programs["1 rank"] = [*MPIRUN, "-n", "1", str(args.bezel)]
    programs["2 ranks"] = [*MPIRUN, "-n", "2", str(args.bezel)]
    with tempfile.TemporaryDirectory() as folder:
        top = pathlib.Path(folder)
        for deck in args.deck:
            compare(deck.stem, programs, deck, [], args.rounds, top)
        if args.deck:
            return
        for mode in ("AUTO", "FULL"):
            deck = top / f"cube_{mode.lower()}.inp"
            deck.write_text(CUBE.read_text().replace("BATCh\n", f"BATCh\n  FACTor {mode}\n", 1))
            options = ["--set", f"n={args.n}", "--set", "steps=2"]
            compare(f"cube, FACTor {mode}", programs, deck, options, args.rounds, top)


if __name__ == "__main__":
    main()
