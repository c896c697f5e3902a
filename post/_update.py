"""`diff --update`: show the old and the new value of each change, then rewrite the reference."""

import csv
import io
import json
import math
import os
import pathlib
import re
import shutil

from post._error import Unreadable
from post._report import load
from post._table import read_text

WHOLE = (".vtkhdf", ".json")  # files that are replaced as a whole
SHOWN = 40  # largest number of changes printed per table


def update(comparison, b, settings):
    """Print the changes and rewrite the files of the reference `b`; return the exit code.

    Values within tolerance keep their old digits. Nothing is written if the new result contains
    NaN or infinity or lacks a column of the reference or a row with its key, or if a whole file is
    missing on one side, or if nothing of a table was compared.
    """
    for table in comparison.tables:
        _refuse(table, settings)
    written = []
    for file, tables in _by_file(comparison).items():
        changed = [t for t in tables if not t.ok]
        if not changed:
            continue
        for table in changed:
            _show(table)
        if file.suffix == ".vtkhdf":
            _replace(file, lambda new, t=tables[0]: shutil.copyfile(t.a.path, new))
        elif file.suffix == ".json":
            _replace(file, lambda new, t=tables[0]: new.write_text(_report(t), encoding="utf-8"))
        else:
            _replace(
                file,
                lambda new, t=tables[0]: new.write_text(_rewritten(t, settings), encoding="utf-8"),
            )
        written.append(str(file))
    print("updated: " + ", ".join(written) if written else f"nothing to update: '{b}' is the same")
    return 0


def _refuse(table, settings):
    if table.a is None or table.b is None:
        raise Unreadable(f"{table.problems[0]}; nothing was written")
    if settings.get("only") and table.b.path.suffix in WHOLE and not table.ok:
        raise Unreadable(
            f"'{table.b.path}' can only be rewritten as a whole, which would change what --only leaves out; nothing was written"
        )
    if settings.get("only") and _has_other_rows(table, settings):
        raise Unreadable(
            f"'{table.name}' has other rows or columns than the reference, so that an update would change columns that --only leaves out; nothing was written"
        )
    new = {column.name: list(column.changes.values()) for column in table.columns}
    if _has_other_rows(table, settings):
        every = table.b.path.suffix.lower() != ".csv"  # which keeps its columns
        new = {n: v.tolist() for n, v in table.a.columns.items() if every or n in table.b.columns}
    for name, values in new.items():
        if any(isinstance(v, float) and not math.isfinite(v) for v in values):
            raise Unreadable(
                f"column '{name}' of {table.a.path} contains NaN or infinity, which a reference must not contain; nothing was written"
            )
    lost = [n for n in table.b.columns if n not in table.a.columns]
    if lost:
        raise Unreadable(f"{table.a.path} has no column {' '.join(lost)}; nothing was written")
    if not table.columns or settings.get("key") and table.columns[0].rows < len(table.b):
        why = [p for p in table.problems if "rows are missing" in p] + table.problems
        raise Unreadable(f"'{table.name}': {why[0]}; nothing was written")


def _by_file(comparison):
    files = {}
    for table in comparison.tables:
        files.setdefault(table.b.path, []).append(table)
    return files


def _show(table):
    print(f"{table.name}: {table.b.path}")
    for problem in table.problems:
        print(f"  {problem}")
    lines = [
        f"  {column.name}, {table.b.row_name(row)}: {_text(table.b.columns[column.name][row])} -> {_text(new)}"
        for column in table.columns
        for row, new in column.changes.items()
    ]
    print("\n".join(lines[:SHOWN]))
    if len(lines) > SHOWN:
        print(f"  ... and {len(lines) - SHOWN} more")


def _text(value):
    """The shortest text that is read back as the same number.

    >>> _text(0.1), _text(3.0), _text("Q1")
    ('0.1', '3', 'Q1')
    """
    if isinstance(value, str):
        return str(value)
    value = float(value)
    return str(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)


def _report(table):
    """The whole new report; nothing of the old one is retained, because the program always writes
    every entry.
    """
    return json.dumps(load(table.a.path), indent=2) + "\n"


def _rewritten(table, settings):
    """The reference with changed cells replaced, or with the rows of `a` if the rows do not
    match.
    """
    if _has_other_rows(table, settings):
        return _whole(table.a, table.b)
    return _cells(table.b, {column.name: column.changes for column in table.columns})


def _has_other_rows(table, settings):
    """Whether `a` has rows or columns that `b` must get, or lacks rows of `b`."""
    same_rows = settings.get("key") or len(table.a) == len(table.b)
    return not same_rows or any(" missing in " in p for p in table.problems)


def _cells(b, changes):
    """The text of the file with the cells of {column: {row: new}} replaced."""
    comma = b.path.suffix.lower() == ".csv"
    names, row, lines = list(b.columns), -1, []
    for line in read_text(b.path).splitlines():
        is_data = line.strip() and not line.lstrip().startswith("#")
        row += bool(is_data)
        at = row - comma  # the first data line of a csv file contains the names
        if is_data and at >= 0:
            cells = next(csv.reader([line])) if comma else re.findall(r"\s*\S+", line)
            for j, name in enumerate(names):
                if at in changes.get(name, {}):
                    new = _text(changes[name][at])
                    cells[j] = (
                        new if comma else cells[j][: len(cells[j]) - len(cells[j].lstrip())] + new
                    )
            line = _csv_line(cells) if comma else "".join(cells)
        lines.append(line)
    return "\n".join(lines) + "\n"


def _csv_line(cells):
    out = io.StringIO()
    csv.writer(out, lineterminator="").writerow(cells)
    return out.getvalue()


def _whole(a, b):
    """The text of a table with the rows of the run; a .csv file keeps the columns of the
    reference, and a curve file its comments, which come after its line of names.
    """
    names = list(b.columns) if b.path.suffix.lower() == ".csv" else list(a.columns)
    rows = [[_text(a.columns[n][i]) for n in names] for i in range(len(a))]
    if b.path.suffix.lower() == ".csv":
        return "\n".join([*b.comments, ",".join(names), *map(_csv_line, rows)]) + "\n"
    lines = [line for line in read_text(b.path).splitlines() if line.strip()]
    comments = [line for line in lines[1:] if line.lstrip().startswith("#")]
    return "\n".join(["# " + " ".join(names), *comments, *map(" ".join, rows)]) + "\n"


def _replace(file, write):
    """Write a new file beside the old one and rename it, so that a reference is never
    half-written.
    """
    new = file.with_name(file.name + ".new")
    try:
        write(new)
        os.replace(new, file)
    except OSError as error:
        pathlib.Path(new).unlink(missing_ok=True)
        raise Unreadable(f"'{file}' cannot be rewritten: {error.strerror}") from None
