"""Pair the rows of two tables."""

from dataclasses import dataclass

import numpy as np

from post._error import Unreadable

SLACK = 1e-9  # round-off allowed at the ends of the interpolation, relative to the range of `over`


@dataclass
class Rows:
    """Paired rows: `got(name)` and `want(name)` have equal length; `of_b[i]` is the row in `b`."""

    a: object
    b: object
    of_a: np.ndarray | None  # (count) rows of a, or None if a is interpolated
    of_b: np.ndarray  # (count)
    over: str | None = None  # the column over which `a` is interpolated

    @property
    def count(self):
        return len(self.of_b)

    def want(self, name):
        return self.b.columns[name][self.of_b]

    def got(self, name):
        if self.of_a is not None:
            return self.a.columns[name][self.of_a]
        column = self.a.columns[name]
        if column.dtype.kind == "U":
            raise Unreadable(f"column '{name}' contains words, which cannot be interpolated")
        return np.interp(self.b.columns[self.over][self.of_b], self.a.columns[self.over], column)


def pair_rows(result, interpolate, key, names):
    """Rows to compare; rows without a partner are reported in `result.problems`."""
    if interpolate:
        return _interpolated(result, interpolate)
    if key:
        return _keyed(result, key)
    a, b = result.a, result.b
    if len(a) != len(b):
        result.problems.append(f"expected {len(b)} rows, found {len(a)}")
    both = np.arange(min(len(a), len(b)))
    return Rows(a, b, both, both)


def _interpolated(result, over):
    a, b = result.a, result.b
    x, y = _key_column(a, over), _key_column(b, over)
    for table, values in ((a, x), (b, y)):
        if values.dtype.kind == "U" or not np.isfinite(values).all():
            raise Unreadable(
                f"column '{over}' of '{table.path or table.name}' has entries that are not finite numbers"
            )
    back = np.flatnonzero(np.diff(x) <= 0)
    if len(back):
        raise Unreadable(
            f"column '{over}' of '{a.path or a.name}' does not increase at row {back[0] + 2}, so it cannot be interpolated over"
        )
    slack = SLACK * (x[-1] - x[0])
    early, late = y < x[0] - slack, y > x[-1] + slack
    if early.any():
        line = f"{early.sum()} rows lie before {over} = {x[0]:.6g}, where the other table begins"
        within_first_step = len(x) > 1 and x[0] - y.min() <= (x[1] - x[0]) * (1 + SLACK)
        (result.notes if within_first_step else result.problems).append(line)
    if late.any():
        result.problems.append(
            f"{over} ends at {x[-1]:.9g}, expected {y.max():.9g}: {late.sum()} rows have no partner"
        )
    if x[-1] > y.max() + slack:
        result.problems.append(
            f"{over} continues to {x[-1]:.9g}, but the reference ends at {y.max():.9g}"
        )
    return Rows(a, b, None, np.flatnonzero(~early & ~late), over)


def _keyed(result, key):
    a, b = result.a, result.b
    in_a, in_b = _index(a, key), _index(b, key)
    lost = [k for k in in_b if k not in in_a]
    extra = [k for k in in_a if k not in in_b]
    selects = b.path is not None and b.path.suffix.lower() == ".csv"
    for keys, where, into in (
        (lost, a, result.problems),
        (extra, b, result.notes if selects else result.problems),
    ):
        if keys:
            some = "; ".join(", ".join(map(str, k)) for k in keys[:3]) + (
                "; ..." if len(keys) > 3 else ""
            )
            into.append(f"{len(keys)} rows are missing in {where.path or where.name}: {some}")
    both = [k for k in in_b if k in in_a]
    pick = lambda index: np.array([index[k] for k in both], dtype=int)
    return Rows(a, b, pick(in_a), pick(in_b))


def _index(table, key):
    columns = [_key_column(table, name) for name in key]
    rows = {}
    for i, values in enumerate(zip(*columns)):
        values = tuple(str(v) if isinstance(v, str) else float(v) for v in values)
        if values in rows:
            raise Unreadable(
                f"rows {rows[values] + 1} and {i + 1} of '{table.path or table.name}' have the same values of {', '.join(key)}"
            )
        rows[values] = i
    return rows


def _key_column(table, name):
    if name not in table.columns:
        raise Unreadable(f"'{table.path or table.name}' has no column '{name}' to match rows by")
    return table.columns[name]
