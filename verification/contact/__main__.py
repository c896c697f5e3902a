"""Run the decks of verification/contact and write the tables of doc/verification/contact.md.

    python -m verification.contact [--bezel PROGRAM] [--out DIR] [--write] [NAME ...]

Each NAME is a table of the page (default: all of them): patch sphere cylinder ironing rings mindlin
mindlin_sphere turn seal cord drag beams cycle own extremes. `--write` puts the tables into the
page, and the curves that the figures show into verification/contact/*/curves.csv. Every reference
is a closed form, a published value or an invariant. The decks that differ only in their elements
are written by `decks.py`.
"""

import argparse
import csv
import pathlib
import sys

from verification import TOP, need_numpy

need_numpy()

from verification.contact import cases  # noqa: E402
from verification.contact.runs import FOLDER, Runner, table  # noqa: E402
from verification.page import put_table  # noqa: E402

PAGE = TOP / "doc/verification/contact.md"


def main(argv=None):
    p = argparse.ArgumentParser(
        prog="python -m verification.contact", description=__doc__.splitlines()[0]
    )
    p.add_argument("--bezel", default=str(TOP / "build/release/bezel"), metavar="PROGRAM")
    p.add_argument("--out", default=str(TOP / "build/contact"), metavar="DIR")
    p.add_argument("--write", action="store_true", help="update the page and the results")
    p.add_argument("name", nargs="*", help=f"tables: {' '.join(cases.TABLES)}")
    o = p.parse_args(argv)
    for name in o.name:
        if name not in cases.TABLES:
            p.error(f"unknown table '{name}'; known ones: {' '.join(cases.TABLES)}")
    runner = Runner(o.bezel, o.out)
    for name in o.name or cases.TABLES:
        heading, rows, curves = cases.TABLES[name](runner)
        text = table(heading, rows)
        print(f"{name}\n{text}\n", flush=True)
        if o.write:
            page = PAGE.read_text(encoding="utf-8")
            PAGE.write_text(put_table(page, name, text), encoding="utf-8")
            if curves:
                write_curves(FOLDER / name / "curves.csv", curves)
    return 0


def write_curves(path, curves):
    """Write rows, given as dictionaries with the same keys, for post/figures/contact.py."""
    pathlib.Path(path).parent.mkdir(exist_ok=True)
    with open(path, "w", encoding="utf-8", newline="") as file:
        file.write(f"# written by python -m verification.contact --write {path.parent.name}\n")
        writer = csv.DictWriter(file, list(curves[0]), lineterminator="\n")
        writer.writeheader()
        for row in curves:  # further digits follow rounding errors
            writer.writerow({k: f"{v:.8g}" if isinstance(v, float) else v for k, v in row.items()})


if __name__ == "__main__":
    sys.exit(main())
