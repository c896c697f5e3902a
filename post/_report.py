"""A run's `report.json` as a table of one row: `dofs`, `elements.Q1`, `final.force.disp_3`, ..."""

import json
import pathlib

import numpy as np

from post._error import Unreadable
from post._table import Table, read_text

#: Entries about the circumstances of a run, which are not results.
NOT_RESULTS = ("format", "version", "deck", "seconds", "cpu_seconds", "peak_memory_mb")

#: The report format that can be read; a report without an entry `format` has this one.
FORMAT = 1


def read_report(path, everything=False):
    """The report as a Table of one row; nested names are joined by dots.

    `everything` keeps the entries of NOT_RESULTS.
    """
    path = pathlib.Path(path)
    content = load(path)
    columns = {}
    for name, value in _flat(content):
        if everything or name.split(".")[0] not in NOT_RESULTS:
            columns[name] = np.array([_cell(value)])
    if not columns:
        raise Unreadable(f"'{path}' contains no results")
    return Table(path.name, columns, path, label=lambda row: "the report")


def load(path):
    """The report as a dictionary."""
    try:
        content = json.loads(read_text(path))
    except json.JSONDecodeError as error:
        raise Unreadable(
            f"'{path}' is not JSON at line {error.lineno} ({error.msg}): truncated?"
        ) from None
    if not isinstance(content, dict):
        raise Unreadable(f"'{path}' is not a report: its top level is not a JSON object")
    if content.get("format", FORMAT) != FORMAT:
        raise Unreadable(
            f"'{path}' has report format {content['format']}, and this program reads format {FORMAT}"
        )
    return content


def _flat(content, prefix=""):
    """(name, value) of every leaf.

    >>> list(_flat({"a": 1, "b": {"c": 2, "d": [3]}}))
    [('a', 1), ('b.c', 2), ('b.d.1', 3)]
    """
    for name, value in content.items():
        if isinstance(value, list):
            value = {str(i): v for i, v in enumerate(value, 1)}
        if isinstance(value, dict):
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value


def _cell(value):
    return str(value) if value is None or isinstance(value, str) else float(value)
