"""Tables with named columns: curve files (a `#` line of names, then numbers) and .csv files."""

import csv
import difflib
import pathlib
import re
from dataclasses import dataclass, field

import numpy as np

from post._error import Unreadable

#: The columns that the program writes before the quantities of a curve file.
LEADING = re.compile(r"step|time|factor(_\d+)?|iterations|cutbacks|converged")
#: A Fortran exponent without its letter (three digits) or with a D.
FORTRAN = re.compile(r"^([+-]?\d*\.?\d+)(?:[dD]|(?=[+-]\d{3}$))([+-]?\d+)$")


@dataclass
class Table:
    """Named columns of equal length.

    name: the name used in messages; path: the file it came from, or None;
    columns: {name: (nrow) array of float, or of str if the column contains words};
    comments: the `#` lines of a csv file, preserved when the file is rewritten.
    """

    name: str
    columns: dict
    path: pathlib.Path | None = None
    comments: list = field(default_factory=list)
    label: object = None  # function from a row to its name in messages; by default, its number

    def __len__(self):
        return len(next(iter(self.columns.values()), ()))

    def row_name(self, row):
        """The name of a row in messages: 'row 3 (time 0.3)'.

        >>> Table("t", {"time": np.array([0.1, 0.2]), "f": np.array([1.0, 2.0])}).row_name(1)
        'row 2 (time 0.2)'
        """
        if self.label is not None:
            return self.label(row)
        time = self.columns.get("time")
        return f"row {row + 1}" + (f" (time {time[row]:.6g})" if time is not None else "")

    def find(self, word):
        """The column whose name is `word` or begins with it, ignoring case.

        >>> Table("t", {"time": np.zeros(1), "force_top_3": np.zeros(1)}).find("force")
        'force_top_3'
        """
        names = list(self.columns)
        same = [n for n in names if n.lower() == word.lower()]
        found = same or [n for n in names if n.lower().startswith(word.lower())]
        if len(found) == 1:
            return found[0]
        if found:
            raise Unreadable(f"'{word}' matches several columns of {self.name}: {' '.join(found)}")
        near = difflib.get_close_matches(word, names, 1)
        hint = f"; did you mean '{near[0]}'?" if near else ""
        raise Unreadable(f"{self.name} has no column '{word}'{hint} (columns: {' '.join(names)})")

    def quantities(self):
        """Names of the columns after `step time factor_1 ... converged`.

        >>> Table("t", {"step": [1], "time": [1], "factor_1": [1], "force": [2]}).quantities()
        ['force']
        """
        return [n for n in self.columns if not LEADING.fullmatch(n)]


def number(text):
    """The value of a number printed by C or Fortran; raise ValueError for anything else.

    >>> number("1.5D-3"), number("2.0-105")
    (0.0015, 2e-105)
    """
    try:
        if "_" in text:
            raise ValueError(text)  # Python would accept 1_000
        return float(text)
    except ValueError:
        match = FORTRAN.match(text)
        if not match:
            raise
        return float(f"{match[1]}e{match[2]}")


def read_text(path):
    """The text of a regular file that exists and is not binary."""
    path = pathlib.Path(path)
    if not path.exists():
        raise Unreadable(f"'{path}' does not exist")
    if not path.is_file():
        raise Unreadable(f"'{path}' is not a regular file")
    try:
        text = path.read_text(encoding="utf-8-sig")  # without the mark that Excel writes
    except UnicodeDecodeError:
        raise Unreadable(f"'{path}' is not a text file") from None
    except OSError as error:
        raise Unreadable(f"'{path}' cannot be read: {error.strerror}") from None
    if not text.strip():
        raise Unreadable(f"'{path}' is empty")
    return text


def read_table(path):
    """A table from a curve file (.dat) or from a .csv file with a line of names.

    A column of a .csv file is read as words if any of its cells is not a number; a curve file must
    contain numbers only.
    """
    path = pathlib.Path(path)
    text = read_text(path)
    table = _read_csv(path, text) if path.suffix.lower() == ".csv" else _read_curve(path, text)
    if len(table) == 0:
        raise Unreadable(f"'{path}' has column names but no rows")
    return table


def has_rows(path):
    """Does a file have rows? Only a curve file may have none: that of a run that closed no step, or
    of TPLOt whose interval is longer than the run.
    """
    path = pathlib.Path(path)
    return path.suffix != ".dat" or len(_read_curve(path, read_text(path))) > 0


def _read_curve(path, text):
    lines = text.splitlines()
    first = next((i for i, line in enumerate(lines) if line.strip()), 0)
    if not lines[first].lstrip().startswith("#"):
        raise Unreadable(f"'{path}' does not begin with a line of column names after '#'")
    names = lines[first].lstrip().lstrip("#").split()
    _check_names(path, names)
    rows = []
    for i, line in enumerate(lines[first + 1 :], first + 2):
        fields = line.split()
        if not fields or fields[0].startswith("#"):
            continue
        if len(fields) != len(names):
            cut = ": the file is truncated" if i == len(lines) and len(fields) < len(names) else ""
            raise Unreadable(
                f"line {i} of '{path}': expected {len(names)} numbers, found {len(fields)}{cut}"
            )
        rows.append([_cell(path, i, text) for text in fields])
    if rows and not text.endswith("\n"):
        raise Unreadable(f"line {len(lines)} of '{path}' is incomplete: the file is truncated")
    values = np.array(rows, dtype=float).reshape(len(rows), len(names))
    return Table(path.name, {n: values[:, j] for j, n in enumerate(names)}, path)


def _read_csv(path, text):
    lines = text.splitlines()
    comments = [line for line in lines if line.lstrip().startswith("#")]
    numbered = [
        (i, line)
        for i, line in enumerate(lines, 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not numbered:
        raise Unreadable(f"'{path}' has no line of column names")
    rows = list(csv.reader([line for _, line in numbered], skipinitialspace=True))
    names = [n.strip() for n in rows[0]]
    _check_names(path, names)
    for (i, _), row in zip(numbered[1:], rows[1:]):
        if len(row) != len(names):
            raise Unreadable(
                f"line {i} of '{path}': expected {len(names)} fields, found {len(row)}"
            )
    cells = {n: [row[j].strip() for row in rows[1:]] for j, n in enumerate(names)}
    return Table(path.name, {n: _numbers_or_words(c) for n, c in cells.items()}, path, comments)


def _check_names(path, names):
    if not names or not all(names):
        raise Unreadable(f"'{path}' has a column without a name")
    twice = next((n for n in names if names.count(n) > 1), None)
    if twice:
        raise Unreadable(f"'{path}' has a duplicate column '{twice}'")


def _cell(path, line, text):
    try:
        return number(text)
    except ValueError:
        raise Unreadable(f"line {line} of '{path}': '{text}' is not a number") from None


def _numbers_or_words(cells):
    try:
        return np.array([number(c) for c in cells], dtype=float)
    except ValueError:
        return np.array(cells, dtype=str)
