"""Check that every element and every law has a theory page, an entry in the manual, and a test.

usage: rows.py [--bezel build/release/bezel]

The rows are those of `bezel --list elements`, `materials` and `contacts`. A page of doc/theory and
a test in verification/unit or verification/patch must name the row or its source file; a page of
doc/manual must name the row. The exit code is 1 if anything is missing.
"""

import argparse
import pathlib
import re
import subprocess
import sys

TOP = pathlib.Path(__file__).resolve().parent.parent
TABLES = {"elements": "element", "materials": "material law", "contacts": "contact law"}


def main(argv=None):
    """Check all tables; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bezel", type=pathlib.Path, default=TOP / "build/release/bezel")
    o = parser.parse_args(argv)
    theory = read(TOP.glob("doc/theory/*.md"))
    manual = read(TOP.glob("doc/manual/*.md"))
    tests = read(p for d in ("unit", "patch") for p in (TOP / "verification" / d).rglob("*.*"))
    sources = {p.stem: p.read_text() for p in TOP.glob("src/*/*.f90")}
    complaints, n = [], 0
    for table, what in TABLES.items():
        for row in rows(o.bezel, table):
            n += 1
            files = [
                stem for stem, text in sources.items() if re.search(rf"name *= *'{row}'", text)
            ]
            word = word_of(row, is_law=table != "elements")
            either = "|".join([word, *(rf"\b{stem}\b" for stem in files)])
            for text, place, pattern in (
                (theory, "page of doc/theory", either),
                (manual, "page of doc/manual", word),
                (tests, "test of verification/unit or verification/patch", either),
            ):
                if not re.search(pattern, text, re.I):
                    complaints.append(f"{what} {row}: no {place} names it")
    print("\n".join([*complaints, f"{n} elements and laws, {len(complaints)} complaints"]))
    return 1 if complaints else 0


def rows(bezel, table):
    """Names of the rows of a table, as the program lists them."""
    run = subprocess.run([bezel, "--list", table], capture_output=True, text=True, check=True)
    return sorted(set(re.findall(r"^  (\w+)", run.stdout, re.M)))


def word_of(row, is_law):
    """Pattern that finds a row by name; for a law four letters suffice, and a spline may have a
    degree.
    """
    if is_law:
        return rf"\b{row[:4]}\w*"
    return rf"\b{row}(?![A-Za-z])" if row[-1] != "N" else rf"\b{row}(?:[p0-9]|\b)"


def read(paths):
    """Text of many files, without any bytes that are not text."""
    return "\n".join(p.read_text(errors="ignore") for p in paths if p.is_file())


if __name__ == "__main__":
    sys.exit(main())
