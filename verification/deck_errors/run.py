"""Run bad decks, and compare the message of each with the expected one.

    python -m verification.deck_errors.run --bezel BEZEL [--update NAME ...]

Every <name>.inp beside this file is run as `bezel -o FOLDER <name>.inp`. It must end with code 1,
print the text of <name>.expected on standard error and write no file. A file <name>.args contains
further arguments. Inputs that cannot be committed as files (a missing file, a folder, a pipe) are
made here.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
SECONDS = 20  # time limit for one bad deck

# Inputs made here: the function that makes each, and its message; {deck} is the path given to
# bezel.
MADE = {
    "missing": (lambda path: None, "error: '{deck}' cannot be read: no such file or directory\n"),
    "folder": (lambda path: path.mkdir(), "error: '{deck}' is a folder\n"),
    "pipe": (lambda path: os.mkfifo(path), "error: '{deck}' is not a regular file\n"),
}


def run(bezel: Path, deck: str, arguments: list[str], folder: Path) -> str:
    """What the program printed, or a complaint if it did not fail as expected, or wrote into
    `folder`.
    """
    result = subprocess.run(
        [str(bezel), "-o", str(folder), *arguments, deck],
        cwd=HERE, capture_output=True, timeout=SECONDS, check=False)  # fmt: skip
    if folder.exists():
        shutil.rmtree(folder)
        return f"files were written, exit code {result.returncode}\n"
    if result.returncode != 1:
        return f"exit code {result.returncode}, not 1\n{result.stderr.decode(errors='replace')}"
    return result.stderr.decode(errors="replace")


def check(name: str, found: str, wanted: str) -> bool:
    """Compare a message with the expected one; print both if they differ."""
    if found == wanted:
        return True
    print(f"FAILED {name}\n--- wanted\n{wanted}--- found\n{found}", end="")
    return False


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="python -m verification.deck_errors.run", description=__doc__.splitlines()[0]
    )
    parser.add_argument("binary", nargs="?", type=Path)
    parser.add_argument("--bezel", type=Path)
    parser.add_argument("--update", nargs="*", metavar="NAME", help="write the messages found")
    options = parser.parse_args()
    bezel = (options.bezel or options.binary or HERE / "../../build/release/bezel").resolve()

    passed = failed = 0
    files_before = sorted(os.listdir(HERE))
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary) / "out"
        for deck in sorted(HERE.glob("*.inp")):
            arguments = deck.with_suffix(".args")
            words = arguments.read_text().split() if arguments.exists() else []
            found = run(bezel, deck.name, words, folder)
            expected = deck.with_suffix(".expected")
            if options.update is not None and deck.stem in (options.update or [deck.stem]):
                expected.write_text(found)
            wanted = expected.read_text() if expected.exists() else "(no .expected file)\n"
            good = check(deck.stem, found, wanted)
            passed, failed = passed + good, failed + (not good)
        for name, (make, wanted) in MADE.items():
            path = Path(temporary) / name
            make(path)
            good = check(name, run(bezel, str(path), [], folder), wanted.format(deck=path))
            passed, failed = passed + good, failed + (not good)
    if sorted(os.listdir(HERE)) != files_before and options.update is None:
        print("FAILED: a file was written beside the decks")
        failed += 1
    print(f"{passed} passed, {failed} failed")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
