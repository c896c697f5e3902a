"""A comparison as text, JSON and JUnit."""

import json
import math
import pathlib
from xml.etree import ElementTree

from post._error import Unreadable


def text(comparison, quiet=False):
    """The comparison as a readable table, whose last line is the verdict."""
    lines = []
    for t in comparison.tables:
        if quiet and t.ok:
            continue
        lines.append(f"{t.name}" + (f": {t.a.path} against {t.b.path}" if t.a is not None else ""))
        lines += [f"  differs: {p}" for p in t.problems] + [f"  note: {n}" for n in t.notes]
        shown = [c for c in t.columns if not (quiet and c.ok)]
        if shown:
            lines += _aligned([HEADINGS] + [_row(c) for c in shown])
    lines += [f"note: {n}" for n in comparison.notes]
    return "\n".join([*lines, verdict(comparison)])


HEADINGS = ("column", "rows", "got", "wanted", "difference", "tolerance", "", "worst row")


def _row(c):
    state = "same" if c.ok else f"differs in {c.failed}"
    difference = f"{c.difference:.2e}" if c.note == "" and not isinstance(c.want, str) else "-"
    where = c.where if c.difference or not c.ok else ""
    return (c.name, str(c.rows), _number(c.got), _number(c.want), difference, str(c.tolerance), state,
            where + (f", {c.note}" if c.note else ""))  # fmt: skip


def _number(value):
    return "-" if value is None else value if isinstance(value, str) else f"{value:.10g}"


def _aligned(rows):
    widths = [max(len(r[i]) for r in rows) for i in range(len(rows[0]))]
    return [
        "  " + "  ".join(cell.ljust(w) for cell, w in zip(row, widths)).rstrip() for row in rows
    ]


def verdict(comparison):
    """One line: 'same: 2 tables, 5 columns, 50 values'.

    >>> from post.diff import Comparison
    >>> verdict(Comparison())
    'differs: 0 of 0 columns, 0 problems'
    """
    columns = [c for t in comparison.tables for c in t.columns]
    if comparison.same:
        values = sum(c.rows for c in columns)
        return f"same: {_count(comparison.tables, 'table')}, {_count(columns, 'column')}, {values} values"
    problems = sum(len(t.problems) for t in comparison.tables)
    bad = sum(not c.ok for c in columns)
    return (
        f"differs: {bad} of {_count(columns, 'column')}, {problems} problem{'s' * (problems != 1)}"
    )


def _count(things, noun):
    return f"{len(things)} {noun}{'s' * (len(things) != 1)}"


def write_files(options, comparison, reason=None):
    """Write the files of --json and --junit; `reason` says why the runs could not be compared."""
    for path, make in ((options.json, as_json), (options.junit, as_junit)):
        if path:
            try:
                pathlib.Path(path).write_text(make(comparison, reason), encoding="utf-8")
            except OSError as error:
                raise Unreadable(f"'{path}' cannot be written: {error.strerror}") from None


def as_json(comparison, reason=None):
    """The result as JSON: verdict (same, differs, unreadable), reason, and each column's worst
    row.
    """
    if comparison is None:
        return json.dumps({"result": "unreadable", "reason": reason, "tables": []}, indent=1) + "\n"
    tables = [
        {
            "name": t.name, "ok": t.ok, "problems": t.problems, "notes": t.notes,
            "columns": [
                {
                    "name": c.name, "ok": c.ok, "rows": c.rows, "failed": c.failed,
                    "tolerance": {"rel": c.tolerance.rel, "abs": c.tolerance.abs, "scaled": c.tolerance.scaled},
                    "worst": {"row": c.where, "got": _plain(c.got), "want": _plain(c.want),
                              "difference": _plain(c.difference)},
                    "note": c.note,
                }
                for c in t.columns
            ],
        }
        for t in comparison.tables
    ]  # fmt: skip
    result = {"result": "same" if comparison.same else "differs", "reason": verdict(comparison)}
    return (
        json.dumps(
            result | {"notes": comparison.notes, "tables": tables}, indent=1, allow_nan=False
        )
        + "\n"
    )


def _plain(value):
    """The value in a form that JSON allows: NaN and infinity become words."""
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value


def as_junit(comparison, reason=None):
    """The result as JUnit XML: a test suite per table, a test case per column."""
    root = ElementTree.Element("testsuites", name="post diff")
    if comparison is None:
        suite = ElementTree.SubElement(
            root, "testsuite", name="read", tests="1", errors="1", failures="0"
        )
        case = ElementTree.SubElement(
            suite, "testcase", classname="read", name="both sides are readable"
        )
        ElementTree.SubElement(case, "error", message=reason)
    for t in comparison.tables if comparison else ():
        cases = [("the same columns and rows", "; ".join(t.problems))]
        cases += [(c.name, "" if c.ok else "  ".join(_row(c))) for c in t.columns]
        bad = sum(bool(message) for _, message in cases)
        suite = ElementTree.SubElement(
            root, "testsuite", name=t.name, tests=str(len(cases)), failures=str(bad), errors="0"
        )
        for name, message in cases:
            case = ElementTree.SubElement(suite, "testcase", classname=t.name, name=name)
            if message:
                ElementTree.SubElement(case, "failure", message=message)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode", xml_declaration=True) + "\n"
