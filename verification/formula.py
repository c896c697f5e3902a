"""A number computed from columns of a curve file, as given by `formula` in a check of
expect.toml.
"""

import ast
import re

import numpy as np

from post._error import Unreadable


def last(x):
    """The value of the last row."""
    return np.asarray(x)[-1]


def span(x):
    """The largest minus the smallest value."""
    return np.ptp(x)


def work(force, u):
    """(rows) work of a force along a displacement from the first row to each row, by the trapezoidal
    rule.
    """
    force, u = np.asarray(force), np.asarray(u)
    return np.append(0.0, np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(u)))


FUNCTIONS = {
    "abs": np.abs, "sqrt": np.sqrt, "arcsin": np.arcsin, "log": np.log, "exp": np.exp, "sum": np.sum, "min": np.min,
    "max": np.max, "mean": np.mean, "diff": np.diff, "minimum": np.minimum, "maximum": np.maximum,
    "where": np.where, "interp": np.interp, "last": last, "span": span, "work": work, "pi": np.pi,
}  # fmt: skip


def evaluate(text, table, values):
    """The value of the formula `text`. Its names are those of columns or prefixes of them, of
    FUNCTIONS, and of `values`, the parameters that the check sets.

    A column is an array over the rows, so the formula must choose a row or reduce all rows to one
    number.

    >>> from post._table import Table
    >>> evaluate("last(f)/n", Table("t", {"f_1": np.array([1.0, 3.0])}), {"n": 2})
    1.5
    """
    names = dict(FUNCTIONS)
    try:
        tree = ast.parse(text, mode="eval")
    except SyntaxError:
        raise Unreadable(f"'{text}' is not a valid formula") from None
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) or (isinstance(node, ast.Name) and "__" in node.id):
            raise Unreadable(f"'{text}' is not a valid formula")
        if isinstance(node, ast.Name) and node.id not in names:
            known = node.id in values
            names[node.id] = values[node.id] if known else table.columns[table.find(node.id)]
    result = np.asarray(eval(compile(tree, "formula", "eval"), {"__builtins__": {}}, names))
    if result.size != 1:
        raise Unreadable(f"'{re.sub(chr(10), ' ', text)}': expected one value, found {result.size}")
    return float(result.reshape(()))
