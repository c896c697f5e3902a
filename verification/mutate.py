"""Run mutated decks: the program must always end in time, give a reason if it fails, and write no
NaN.

    python -m verification.mutate [--bezel BEZEL] [-n 1000] [--seed 1] [--keep FOLDER] [DECK ...]

Decks of input/ and verification/ are truncated, shuffled and filled with junk, starting from fixed
seeds; mutation k of a seed can be reproduced if the same decks are quick enough to be chosen. Each
run must end within 20 s with code 0, 1, 2 or 3, print a message unless the code is 0, write nothing
with code 1, and leave no NaN in any file. Decks that fail are saved in FOLDER.
"""

from __future__ import annotations

import argparse
import array
import collections
import math
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

try:
    import h5py
    import numpy
except ImportError:  # fields are then not checked
    h5py = None

HERE = Path(__file__).resolve().parent
SECONDS = 20.0  # CPU seconds that a mutated deck may take
QUICK = 3.0  # CPU seconds that a deck may take to be mutated at all
BUSY = 4  # largest ratio of wall-clock to CPU seconds
NUMBER = re.compile(r"(?<![\w.+-])-?\d+(?:\.\d*)?(?:[eE][+-]?\d+)?(?![\w.])")
CONTACT = re.compile(r"^\s*CONTact,", re.MULTILINE | re.IGNORECASE)
CONTACTS = 3  # every third mutant comes from a deck with contact
NOT_NUMBER = re.compile(rb"\bNaN\b|\bInfinity\b")
JUNK = (
    "0 -1 1 2 3 0.5 -0.5 1e-300 1e300 1e999 -1e999 99999999999 2147483648 nan inf 1/0 (1 1) 1+ --1 1..2 3e x "
    "PATCh END NEXT LOOP,2 BATCh STOP FEAP MATErial TANG,,1 UTAN,,1 TIME DT,,-1 * 3- 9+ SIDE ALL NODE , ,,, = "
    "\" ' ! & ( ) ^ ** \t \x00 \x7f \xff é 💥 include INCLude,. $ % @ {} [] \\ ~ pi sin(1) sqrt(-1) log(0) "
    "CONTact SURFaces NORMal PENAlty AUTO FRICtion COULomb AFTEr DEPTh QUADrature RIGId"
).split(" ")


# --- one change to a deck, given and returned as a list of lines ---------------------------------
def cut_tail(lines, chance):
    """End the file early, perhaps inside a line."""
    text = "\n".join(lines)
    return text[: chance.randrange(len(text) + 1)].split("\n")


def drop_lines(lines, chance):
    """Delete some lines."""
    for _ in range(chance.randint(1, 3)):
        if lines:
            del lines[chance.randrange(len(lines))]
    return lines


def repeat_lines(lines, chance):
    """Duplicate some lines."""
    for _ in range(chance.randint(1, 2)):
        if lines:
            at = chance.randrange(len(lines))
            lines.insert(at, lines[at])
    return lines


def swap_lines(lines, chance):
    """Exchange some lines."""
    for _ in range(chance.randint(1, 4)):
        if lines:
            a, b = chance.randrange(len(lines)), chance.randrange(len(lines))
            lines[a], lines[b] = lines[b], lines[a]
    return lines


def shuffle_part(lines, chance):
    """Shuffle the lines of one part."""
    a = chance.randrange(len(lines) + 1)
    b = min(len(lines), a + chance.randint(2, 12))
    part = lines[a:b]
    chance.shuffle(part)
    return lines[:a] + part + lines[b:]


def change_fields(lines, chance):
    """Replace fields by junk, delete some, or insert junk."""
    for _ in range(chance.randint(1, 4)):
        at = chance.randrange(len(lines)) if lines else 0
        fields = lines[at].split() if lines else []
        if not fields:
            continue
        i = chance.randrange(len(fields))
        what = chance.randrange(4)
        if what == 0:
            del fields[i]
        elif what == 1:
            fields.insert(i, chance.choice(JUNK))
        else:
            fields[i] = chance.choice(JUNK)
        lines[at] = "  " + " ".join(fields)
    return lines


def change_numbers(lines, chance):
    """Replace numbers by others that a user might have meant, except the pass counts of loops."""
    for _ in range(chance.randint(1, 3)):
        at = chance.randrange(len(lines)) if lines else 0
        found = (
            list(NUMBER.finditer(lines[at])) if lines and "LOOP" not in lines[at].upper() else []
        )
        if not found:
            continue
        spot = chance.choice(found)
        x = float(spot[0])
        whole = spot[0].lstrip("-").isdigit()
        other = chance.choice(
            (0, -x, x + 1, x - 1)
            if whole
            else (0, -x, 2 * x, x / 2, 1000 * x, 1e-9 * x, 0.4999, -0.9)
        )
        lines[at] = lines[at][: spot.start()] + f"{other:g}" + lines[at][spot.end() :]
    return lines


def change_bytes(lines, chance):
    """Change, delete or insert single characters."""
    text = list("\n".join(lines))
    for _ in range(chance.randint(1, 8)):
        if text:
            i = chance.randrange(len(text))
            text[i : i + chance.randint(0, 1)] = chance.choice(
                [chr(chance.randrange(256)), "", chance.choice("0123456789,=-+.!&")]
            )
    return "".join(text).split("\n")


def insert_junk(lines, chance):
    """Insert lines of junk."""
    for _ in range(chance.randint(1, 3)):
        junk = " ".join(chance.choice(JUNK) for _ in range(chance.randint(1, 8)))
        lines.insert(chance.randrange(len(lines) + 1), junk)
    return lines


CHANGES = (
    cut_tail,
    drop_lines,
    repeat_lines,
    swap_lines,
    shuffle_part,
    change_fields,
    change_fields,
    change_numbers,
    change_numbers,
    change_numbers,
    change_numbers,
    change_bytes,
    insert_junk,
)


def mutate(text: str, chance: random.Random) -> str:
    """Make one to three changes."""
    lines = text.split("\n")
    for _ in range(chance.choice((1, 1, 2, 3))):
        lines = chance.choice(CHANGES)(lines, chance)
    return "\n".join(lines)


# --- runs ----------------------------------------------------------------------------------------
def run(bezel: Path, deck: Path, out: Path, seconds: float) -> tuple[int | None, bytes, float]:
    """The exit code (None if the run takes more CPU seconds than allowed), stderr, and the wall
    seconds.
    """
    start = time.monotonic()
    most = math.ceil(seconds)
    limit = lambda: resource.setrlimit(resource.RLIMIT_CPU, (most, most + 1))
    try:
        result = subprocess.run(
            [bezel, "--quiet", "-o", out, deck], capture_output=True, timeout=BUSY * seconds,
            check=False, preexec_fn=limit)  # fmt: skip
    except subprocess.TimeoutExpired:
        return None, b"", time.monotonic() - start
    late = -result.returncode in (signal.SIGXCPU, signal.SIGKILL)
    return None if late else result.returncode, result.stderr, time.monotonic() - start


def has_nan(path: Path) -> bool:
    """Whether a file contains a NaN or infinity."""
    if path.suffix in (".vtkhdf", ".h5"):
        found = []
        if h5py:
            with h5py.File(path) as file:
                file.visititems(lambda name, item: found.append(name) if bad_data(item) else None)
        return bool(found)
    content = path.read_bytes()
    text, mark, raw = content.partition(b'<AppendedData encoding="raw">')
    if mark:  # the reals follow the text as bytes, which must not be read as characters
        raw = raw[raw.index(b"_") + 1 :]
        for start in re.findall(rb'type="Float64"[^>]*offset="(\d+)"', text):
            length = int.from_bytes(raw[int(start) : int(start) + 8], "little")
            values = array.array("d", raw[int(start) + 8 : int(start) + 8 + length])
            if not all(map(math.isfinite, values)):
                return True
    return bool(NOT_NUMBER.search(text))


def bad_data(item) -> bool:
    """Whether a dataset of reals contains values that are not finite."""
    return (
        isinstance(item, h5py.Dataset)
        and item.dtype.kind == "f"
        and not numpy.isfinite(item[()]).all()
    )


def judge(code: int | None, stderr: bytes, out: Path) -> str:
    """What is wrong with a run, in words; empty if nothing is."""
    if code is None:
        return f"did not end within {SECONDS:.0f} s"
    if code not in (0, 1, 2, 3):
        return f"ended with code {code}"
    if code != 0 and not stderr.strip():
        return f"ended with code {code} and no message"
    files = [f for f in out.rglob("*") if f.is_file()] if out.exists() else []
    if code == 1 and files:
        return "ended with code 1 but wrote files"
    for file in files:
        try:
            if has_nan(file):
                return f"NaN in {file.name}"
        except OSError as error:
            return f"{file.name} cannot be read: {error}"
    return ""


def processor_seconds() -> float:
    """CPU seconds of all runs so far, which do not depend on the load of the machine."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def find_decks(bezel: Path, folder: Path) -> list[Path]:
    """Decks that run quickly, in a fixed order."""
    decks = []
    for deck in sorted([*(HERE.parent / "input").rglob("*.inp"), *HERE.rglob("*.inp")]):
        if "deck_errors" in deck.parts:
            continue
        before = processor_seconds()
        code, *_ = run(bezel, deck, folder / "base", 2 * QUICK)
        seconds = processor_seconds() - before
        shutil.rmtree(folder / "base", ignore_errors=True)
        if code is not None and seconds < QUICK:
            decks.append(deck)
        else:
            print(f"not mutated, because it is too slow: {deck.relative_to(HERE.parent)}")
    return decks


def copy_parts(root: Path) -> None:
    """Copy the files that decks include into folders of the same names, where mutants will find
    them.
    """
    for part in ("input", "verification"):
        for file in (HERE.parent / part).rglob("*"):
            if (
                file.is_file()
                and file.suffix in (".inc", ".xml", ".mesh", ".dat")
                and file.stat().st_size < 1e6
            ):
                copy = root / file.relative_to(HERE.parent)
                copy.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(file, copy)


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="python -m verification.mutate", description=__doc__.splitlines()[0]
    )
    parser.add_argument(
        "deck", nargs="*", type=Path, help="decks to mutate (default: input/ and verification/)"
    )
    parser.add_argument("--bezel", type=Path, default=HERE.parent / "build/release/bezel")
    parser.add_argument("-n", type=int, default=1000, help="number of mutations")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--keep",
        type=Path,
        default=HERE.parent / "build/mutate",
        help="folder for the decks that fail",
    )
    options = parser.parse_args()
    bezel = options.bezel.resolve()

    codes: collections.Counter = collections.Counter()
    failed = 0
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        decks = options.deck or find_decks(bezel, folder)
        contacts = [deck for deck in decks if CONTACT.search(deck.read_text(errors="replace"))]
        copy_parts(folder)
        for k in range(options.n):
            chance = random.Random(f"{options.seed}.{k}")
            base = chance.choice(contacts if contacts and k % CONTACTS == 0 else decks)
            home = (
                folder / base.resolve().parent.relative_to(HERE.parent)
                if HERE.parent in base.resolve().parents
                else folder
            )
            home.mkdir(parents=True, exist_ok=True)
            deck = home / f"mutant_{options.seed}_{k:04d}.inp"
            text = mutate(base.read_text(errors="surrogateescape"), chance)
            deck.write_bytes(text.encode(errors="surrogateescape"))
            code, stderr, seconds = run(bezel, deck, folder / "out", SECONDS)
            codes[code] += 1
            wrong = judge(code, stderr, folder / "out")
            shutil.rmtree(folder / "out", ignore_errors=True)
            if wrong:
                failed += 1
                options.keep.mkdir(parents=True, exist_ok=True)
                shutil.copy(deck, options.keep)
                print(
                    f"FAILED {options.keep / deck.name} (from {base.name}, {seconds:.1f} s): {wrong}",
                    flush=True,
                )
                print(stderr.decode(errors="replace")[-800:])
            deck.unlink()
    print("codes " + ", ".join(f"{code}: {n}" for code, n in sorted(codes.items(), key=str)))
    print(f"{options.n - failed} passed, {failed} failed")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
