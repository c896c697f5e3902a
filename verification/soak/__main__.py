"""Make trials for some minutes, or a given number of them, and print what failed.

    python -m verification.soak [--minutes 60] [--seed 1] [--only KIND] [--trial KIND.NUMBER] [--write]
    python -m verification.soak --mutants 500 --bezel build/sanitize/bezel

A failing input is minimised and saved in build/soak/failures/. `--trial deck.17 --seed 1` repeats
trial 17 of the kind `deck`. --write puts the counts into results.csv and
doc/verification/reliability.md.
"""

import argparse
import collections
import concurrent.futures
import csv
import shutil
import signal
import sys
import tempfile
import time
from pathlib import Path

from verification import TOP, need_numpy

need_numpy()

from verification.page import put_table  # noqa: E402
from verification.soak.trials import FUZZ, KINDS, Context, schedule, trial  # noqa: E402

TABLE = Path(__file__).resolve().parent / "results.csv"
PAGE = TOP / "doc/verification/reliability.md"
COLUMNS = ("seed", "kind", "trials", "code 0", "code 1", "code 2", "code 3", "code 4", "other", "failures")  # fmt: skip


def main(argv=None):
    o = parser().parse_args(argv)
    bezel = Path(o.bezel).resolve()
    if not bezel.is_file():
        print(f"soak: error: there is no program '{bezel}'", file=sys.stderr)
        return 1
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # removes folders and mounts
    kept = Path(o.keep).resolve()
    kinds = FUZZ if o.mutants else o.only or list(KINDS)
    work = schedule(o.seed, kinds)
    if o.trial:
        name, _, number = o.trial.partition(".")
        work = iter([(name, int(number))])
    begin = time.monotonic()
    most = o.mutants or (1 if o.trial else None)
    end = None if most else begin + 60 * o.minutes
    counts = {kind: collections.Counter() for kind in KINDS}
    made = failed = 0
    with (
        tempfile.TemporaryDirectory(prefix="soak") as top,
        concurrent.futures.ThreadPoolExecutor(o.jobs) as pool,
    ):
        context = Context(bezel, top, 15.0 if o.mutants else 1.0)
        waiting, over = {}, False
        while waiting or not over:
            over = over or (end and time.monotonic() >= end) or (most and made >= most)
            while not over and len(waiting) < o.jobs:
                kind, number = next(work)
                waiting[pool.submit(trial, context, o.seed, kind, number)] = (kind, number)
                made += 1
                over = bool(most and made >= most)
            done, _ = concurrent.futures.wait(
                waiting, return_when=concurrent.futures.FIRST_COMPLETED
            )
            for future in done:
                kind, number = waiting.pop(future)
                code, failure = future.result()
                counts[kind]["trials"] += 1
                counts[kind][f"code {code}" if code in range(5) else "other"] += 1
                if failure:
                    failed += 1
                    counts[kind]["failures"] += 1
                    keep(kept / f"{kind}-{o.seed}-{number}", failure, o.seed, kind, number)
                    print(f"FAILED {kind}.{number}, seed {o.seed}: {failure.what}", flush=True)
            if sys.stderr.isatty():
                left = f", {max(0, end - time.monotonic()):.0f} s left" if end else ""
                print(
                    f"\r{made} trials, {failed} failed{left}   ",
                    end="",
                    file=sys.stderr,
                    flush=True,
                )
    if sys.stderr.isatty():
        print("\r", end="", file=sys.stderr)
    rows = [(o.seed, kind, *(n[c] for c in COLUMNS[2:])) for kind, n in counts.items() if n]
    if o.write:
        write(rows)
    parts = ", ".join(f"{n['trials']} {kind}" for kind, n in counts.items() if n)
    print(f"{made - failed} passed, {failed} failed ({parts}; {time.monotonic() - begin:.0f} s)")
    return int(failed > 0 or made == 0)


def keep(folder, failure, seed, kind, number):
    """Write the files that reproduce a failure, and the commands to repeat it."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for name, content in failure.files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    (folder / "reason.txt").write_text(
        f"{failure.what}\nbezel -o out {failure.how}\n"
        f"python -m verification.soak --trial {kind}.{number} --seed {seed}\n"
    )


def write(rows):
    """Replace the rows of these seeds in results.csv, and the table in the page."""
    old = []
    if TABLE.exists():
        with open(TABLE, newline="") as file:
            old = list(csv.reader(file))[1:]
    seeds = {str(row[0]) for row in rows}
    rows = [row for row in old if row[0] not in seeds] + [list(map(str, row)) for row in rows]
    with open(TABLE, "w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([COLUMNS, *rows])
    total = {}
    for row in rows:
        numbers = total.setdefault(row[1], [0] * (len(COLUMNS) - 2))
        total[row[1]] = [a + int(b) for a, b in zip(numbers, row[2:], strict=True)]
    lines = [COLUMNS[1:], ["---"] * (len(COLUMNS) - 1)]
    lines += [[kind, *map(str, numbers)] for kind, numbers in total.items()]
    lines.append(["all", *(str(sum(column)) for column in zip(*total.values(), strict=True))])
    table = "\n".join("| " + " | ".join(line) + " |" for line in lines)
    if PAGE.exists():
        PAGE.write_text(put_table(PAGE.read_text(), "soak", table))


def parser():
    p = argparse.ArgumentParser(
        prog="python -m verification.soak",
        description="Hostile inputs, kills, signals, limits and units, drawn from a seed.",
    )
    p.add_argument("--bezel", default=str(TOP / "build/release/bezel"), metavar="PROGRAM")
    p.add_argument("--minutes", type=float, default=1.0, metavar="N", help="(default 1)")
    p.add_argument("--mutants", type=int, metavar="N", help="make only N trials of mutated decks, meshes and splines, with generous time limits: for builds with checks")  # fmt: skip
    p.add_argument("--seed", default="1", metavar="S")
    p.add_argument("--only", action="append", choices=KINDS, metavar="KIND", help=" ".join(KINDS))
    p.add_argument("--trial", metavar="KIND.NUMBER", help="repeat one trial of this seed")
    p.add_argument("--jobs", type=int, default=1, metavar="N", help="(default 1)")
    p.add_argument("--keep", default=str(TOP / "build/soak/failures"), metavar="DIR", help="folder for failures (default build/soak/failures)")  # fmt: skip
    p.add_argument("--write", action="store_true", help="write results.csv and the table of the page")  # fmt: skip
    return p


if __name__ == "__main__":
    sys.exit(main())
