"""Compare two tables column by column: what differs, by how much, and where the difference is
largest.
"""

from dataclasses import dataclass, field

import numpy as np

from post._error import Unreadable
from post._pair import pair_rows
from post._tolerance import Tolerance, matches


@dataclass
class ColumnResult:
    """The result for one column: how many rows were compared and failed, and the worst row."""

    name: str
    rows: int
    failed: int
    tolerance: Tolerance
    where: str = ""  # the worst row
    got: object = None
    want: object = None
    difference: float = 0.0  # |got - want| in the worst row
    note: str = ""  # a remark where `difference` is no measure: NaN or infinity
    changes: dict = field(default_factory=dict)  # {row of b: new value} of all rows that failed

    @property
    def ok(self):
        return self.failed == 0


@dataclass
class TableResult:
    """The result for one pair of tables: one entry per column, and what only one table has."""

    name: str
    columns: list = field(default_factory=list)
    problems: list = field(default_factory=list)  # differences
    notes: list = field(default_factory=list)  # remarks that do not count as differences
    a: object = None
    b: object = None

    @property
    def ok(self):
        return not self.problems and bool(self.columns) and all(c.ok for c in self.columns)


def compare_tables(a, b, tolerances, interpolate=None, key=None, only=None, ignore=None):
    """Compare table `a` (got) with table `b` (wanted); return a TableResult.

    Columns match by name. Rows match by position or by the columns in `key`; with `interpolate`,
    the columns of `a` are interpolated linearly, as functions of that column, at the rows of `b`. A
    column that only `b` has is a difference. So is a column that only `a` has, unless `b` is a .csv
    file, which may contain a selection of the columns.
    """
    result = TableResult(b.name, a=a, b=b)
    special = set(key or ()) | ({interpolate} if interpolate else set())
    names = _common(result, special, only, ignore, interpolate)
    if not names:
        result.problems.append("the two tables have no column in common that can be compared")
        return result
    rows = pair_rows(result, interpolate, key, names)
    if rows.count == 0:
        result.problems.append("the two tables have no row in common that can be compared")
        return result
    for name in names:
        got, want = rows.got(name), rows.want(name)
        tolerance = tolerances.of(b.name, name)
        compare = _words if want.dtype.kind == "U" else _numbers
        result.columns.append(compare(name, got, want, tolerance, b, rows.of_b))
    return result


def _common(result, special, only, ignore, interpolate):
    """Names of the columns to compare, in the order of `b`; missing ones are noted in the
    result.
    """
    a, b = result.a, result.b
    chosen = lambda n: not only or any(matches(p, b.name, n) for p in only)
    dropped = lambda n: any(matches(p, b.name, n) for p in ignore or ())
    names = []
    for name in b.columns:
        if name in special or not chosen(name):
            continue
        if dropped(name):
            result.notes.append(f"'{name}' is ignored")
        elif interpolate and name in ("step", "iterations", "cutbacks", "converged"):
            result.notes.append(f"'{name}' is not compared: it has no meaning between steps")
        elif name not in a.columns:
            result.problems.append(f"column '{name}' is missing in {a.path or a.name}")
        elif (a.columns[name].dtype.kind == "U") != (b.columns[name].dtype.kind == "U"):
            raise Unreadable(
                f"column '{name}' holds numbers in one of the files '{a.path or a.name}' and '{b.path or b.name}', and words in the other"
            )
        else:
            names.append(name)
    extra = [
        n
        for n in a.columns
        if n not in b.columns and n not in special and chosen(n) and not dropped(n)
    ]
    selects = b.path is not None and b.path.suffix.lower() == ".csv"
    for name in extra:
        line = f"column '{name}' is missing in {b.path or b.name}"
        (result.notes if selects else result.problems).append(line)
    return names


def _words(name, got, want, tolerance, b, of_b):
    bad = np.flatnonzero(got != want)
    result = ColumnResult(name, len(want), len(bad), Tolerance())
    if len(bad):
        i = bad[0]
        result.where, result.got, result.want = b.row_name(of_b[i]), str(got[i]), str(want[i])
        result.changes = {int(of_b[i]): str(got[i]) for i in bad}
    return result


def _numbers(name, got, want, tolerance, b, of_b):
    finite = np.isfinite(got) & np.isfinite(want)
    sound = np.abs(want[np.isfinite(want)])
    with np.errstate(invalid="ignore", over="ignore"):
        difference = np.abs(got - want)
        allowed = np.broadcast_to(
            tolerance.allowed(want, sound.max() if len(sound) else 0.0), want.shape
        )
        failed = ~(finite & (difference <= allowed))
        excess = np.where(allowed > 0, difference / np.where(allowed > 0, allowed, 1.0), difference)
    # worst row: the first with NaN or infinity, else that with the largest difference / tolerance
    i = int(np.flatnonzero(~finite)[0]) if not finite.all() else int(np.argmax(excess))
    result = ColumnResult(name, len(want), int(failed.sum()), tolerance, b.row_name(of_b[i]))
    result.got, result.want, result.difference = float(got[i]), float(want[i]), float(difference[i])
    if not finite.all():
        sides = [
            s for s, v in (("the first", got), ("the second", want)) if not np.isfinite(v).all()
        ]
        result.note = f"NaN or infinity in {' and '.join(sides)} file (number of rows: {int((~finite).sum())})"
    result.changes = {int(of_b[i]): float(got[i]) for i in np.flatnonzero(failed)}
    return result
