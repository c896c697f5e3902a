"""Compare two runs, or a run and a reference: `python -m post diff A B`.

A is the result, B the reference; each is a folder, a stem or a file. The exit code is 0 if they are
the same, 1 if they differ, and 2 if one of them cannot be read. As a library:

>>> import post
>>> comparison = post.diff.compare("build/a", "build/b", post.diff.parse({"rel": ["1e-6"]}))  # doctest: +SKIP
>>> comparison.same, [t.name for t in comparison.tables if not t.ok]  # doctest: +SKIP
(True, [])
"""

import sys
from dataclasses import dataclass, field

from post import _emit, _options, _runs, _update
from post._compare import TableResult, compare_tables
from post._error import Unreadable
from post._expect import read_diff
from post._table import has_rows
from post._tolerance import Tolerance, Tolerances, parse

__all__ = ["Comparison", "compare", "compare_tables", "parse", "Tolerance", "Tolerances", "main"]

SAME, DIFFERS, UNREADABLE = 0, 1, 2


@dataclass
class Comparison:
    """The result of `compare`: one TableResult per table, and notes on what was not compared."""

    tables: list = field(default_factory=list)
    notes: list = field(default_factory=list)

    @property
    def same(self):
        return bool(self.tables) and all(t.ok for t in self.tables)


def compare(a, b, tolerances=None, interpolate=None, key=None, only=None, ignore=None):
    """Compare the result at path `a` with the reference at path `b`.

    tolerances: Tolerances, by default 1e-9 relative or 1e-12 of the largest magnitude in a column;
    interpolate: name of the column over which `a` is interpolated at the rows of `b`;
    key: names of the columns by which rows are matched; only, ignore: column patterns.
    Raises Unreadable if a side is missing, truncated, empty or not made of numbers, or if a pattern
    matches no column.
    """
    tolerances = tolerances or Tolerances()
    comparison = Comparison()
    matched = _runs.matched(a, b)
    alone = len(matched) == 1
    others = _runs.not_of_a_run(matched)
    for part, file_a, file_b in matched:
        if part in others:
            comparison.notes.append(f"'{part}' is not compared: it is not the report of a run")
        elif file_a is None or file_b is None:
            there, lacks = (b, a) if file_a is None else (a, b)
            comparison.tables.append(
                TableResult(part, problems=[f"'{part}' of '{there}' is missing in '{lacks}'"])
            )
        elif interpolate and _runs.no_curve(part):
            comparison.notes.append(
                f"'{part}' is not compared: it has no {interpolate} to interpolate over"
            )
        elif not (alone or has_rows(file_a) or has_rows(file_b)):
            comparison.notes.append(f"'{part}' is not compared: it has no rows")
        elif not (alone or (has_rows(file_a) and has_rows(file_b))):
            lacks = b if has_rows(file_a) else a
            comparison.tables.append(
                TableResult(part, problems=[f"'{part}' of '{lacks}' has no rows"])
            )
        else:
            comparison.tables += _compare_files(
                part, file_a, file_b, tolerances, interpolate, key, only, ignore
            )
    if not comparison.tables:
        raise Unreadable(f"'{a}' and '{b}' have nothing in common that can be compared")
    _all_used(comparison, tolerances, only, ignore)
    return comparison


def _compare_files(part, file_a, file_b, tolerances, interpolate, key, only, ignore):
    left = {t.name: t for t in _named(part, _runs.tables(file_a))}
    right = {t.name: t for t in _named(part, _runs.tables(file_b))}
    results = []
    for name in list(right) + [n for n in left if n not in right]:
        if name in left and name in right:
            if only and not _any_chosen(right[name], only):
                continue  # no column of this table was requested
            results.append(
                compare_tables(left[name], right[name], tolerances, interpolate, key, only, ignore)
            )
        else:
            lacks = file_a if name in right else file_b
            results.append(TableResult(name, problems=[f"'{name}' is missing in '{lacks}'"]))
    return results


def _named(part, tables):
    """The tables, named after their parts so that the two sides match even if their file names
    differ.
    """
    for table in tables:
        table.name = part if len(tables) == 1 else f"{part}/{table.name}"
    return tables


def _any_chosen(table, only):
    from post._tolerance import matches

    return any(matches(p, table.name, n) for p in only for n in table.columns)


def _all_used(comparison, tolerances, only, ignore):
    """Reject a pattern that matches no column: it is probably mistyped and could hide a
    difference.
    """
    from post._tolerance import matches

    names = [
        (t.name, n) for t in comparison.tables for side in (t.a, t.b) if side for n in side.columns
    ]
    for pattern in [*tolerances.named, *(only or ()), *(ignore or ())]:
        if not any(matches(pattern, *name) for name in names):
            have = " ".join(dict.fromkeys(n for _, n in names))
            raise Unreadable(f"no column matches '{pattern}' (columns: {have})")


def main(argv):
    """Run the command; return its exit code."""
    options = _parser().parse_args(argv)
    try:
        settings = _settings(options)
        comparison = compare(options.a, options.b, **settings)
        code = _update.update(comparison, options.b, settings) if options.update else None
    except Unreadable as error:
        print(f"post diff: unreadable: {error}", file=sys.stderr)
        _emit.write_files(options, None, str(error))
        return UNREADABLE
    if code is None:
        print(_emit.text(comparison, quiet=options.quiet))
        code = SAME if comparison.same else DIFFERS
    _emit.write_files(options, comparison)
    return code


def _settings(options):
    """Arguments of `compare` from the command line, which override those of --expect; --only and
    --ignore add to them.
    """
    given = {kind: getattr(options, kind) for kind in ("rel", "abs", "scaled")}
    if options.exact:
        given = {"rel": ["0"]}
    settings = read_diff(options.expect) if options.expect else {}
    if any(given.values()) or "tolerances" not in settings:
        settings["tolerances"] = parse(given)
    if options.interpolate:
        settings["interpolate"] = options.interpolate
    if options.key:
        settings["key"] = options.key.split(",")
    for name in ("only", "ignore"):
        settings[name] = (settings.get(name) or []) + (getattr(options, name) or [])
    if settings.get("interpolate") and (settings.get("key") or options.update):
        raise Unreadable(
            "--interpolate cannot be combined with "
            + ("--key" if settings.get("key") else "--update")
        )
    return settings


def _parser():
    p = _options.parser(
        prog="post diff",
        description="Compare two runs, or a run and a reference, column by column.",
        epilog="exit code: 0 same, 1 differs, 2 unreadable (missing, truncated, or not made of numbers)",
    )
    p.add_argument(
        "a", help="the result: a folder, a stem (out/cube), or a .dat .csv .json .vtkhdf file"
    )
    p.add_argument("b", help="the reference, in the same form")
    for kind, what in (
        ("rel", "relative to the reference value"), ("abs", "in the unit of the column"), ("scaled", "relative to the largest magnitude in the column"),
    ):  # fmt: skip
        p.add_argument(
            f"--{kind}", action="append", metavar="[COLUMN=]TOL", help=f"allowed difference {what}"
        )
    p.add_argument("--exact", action="store_true", help="allow no difference at all")
    p.add_argument(
        "--expect",
        metavar="FILE",
        help="take tolerances and columns from the [diff] table of an expect.toml",
    )
    p.add_argument(
        "--interpolate",
        metavar="COLUMN",
        help="interpolate A over this column, such as time, at the rows of B",
    )
    p.add_argument("--key", metavar="COL,COL", help="match rows by the values of these columns")
    p.add_argument(
        "--only",
        action="append",
        metavar="COLUMN",
        help="compare only these columns (the beginning of a name, or a pattern with *)",
    )
    p.add_argument("--ignore", action="append", metavar="COLUMN", help="leave out these columns")
    p.add_argument("--json", metavar="FILE", help="write the result as JSON")
    p.add_argument("--junit", metavar="FILE", help="write the result as JUnit XML")
    p.add_argument(
        "--update",
        action="store_true",
        help="show the old and the new value of each change, then rewrite B",
    )
    p.add_argument(
        "--quiet", action="store_true", help="print only the differences and the verdict"
    )
    return p
