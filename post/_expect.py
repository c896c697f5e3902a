"""`expect.toml` says which results a verification case must give and how `diff` compares them.

title  = "Cook's membrane, neo-Hooke"        # one line
source = "Simo & Armero 1992, table 1"       # of every check without a source of its own

[[check]]                                    # one number of one run
name   = "tip deflection, n = 8"             # default: the quantity
deck   = "cook.inp"
set    = { n = 8 }                           # parameters, passed with --set
curve  = "tip"                               # the file <deck>_tip.dat ...
column = "disp"                              # ... its column (the beginning of its name suffices; default: first quantity)
row    = "last"                              # last, first, a step number, or { time = 0.5 }
factor = 1.0                                 # got = factor * value
formula = "last(force_3)/last(force_3_2)"    # instead of column, row and factor: a number computed from the columns, see verification/formula.py
want   = 6.937
rel    = 1e-3                                # allowed difference: rel or abs, at least one of them
options = ["--threads", "2"]                 # further options of the program
time_limit = 600                             # seconds after which the run has failed
slow   = true                                # run this check only with --all

warning = "lies in the same place"           # instead of curve: words that a warning must contain, in the report and in the log; "": there must be no warning
error  = "left-handed"                       # instead of curve: words of the first error message on the screen; needs exit = 1 to 3

report = "dofs"                              # instead of curve: an entry of the report (final.tip.disp, elements.Q1)

field  = "stress"                            # instead of curve: a field, compared at all points of a step
want   = [0.1, 0, 0, 0, 0, 0]                # the same at all points, or
affine = [[0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]]   # a linear function of the reference position (3 columns, or 4 with a constant)

reference = "force.csv"                      # instead of want: a whole curve, compared as the keys of [diff] below say

each = "reference.csv"                       # repeats the check for each row; "{column}" is replaced by the value in the row
vary = { n = [1, 2] }                        # or repeats it for each combination of these values
where = { test = "extension" }               # only for rows with these values
[check.map.elements]                         # further keys, chosen by the row's value in this column
"Q1" = { deck = "q1.inp", rel = 1e-6 }

[[study]]                                    # a refinement study; `verify --study` writes results.csv
vary  = { elements = ["Q1", "Q2"], n = [1, 2, 4] }   # and `each`, `where`, `map` as above
slow  = [8]                                  # further values of the last key of vary, run only with --all
value = "force"                              # the name of the result in results.csv; deck, set, curve, column and factor as above
want  = -0.314892                            # the converged value
limit = 1e-2                                 # the largest relative error allowed on the finest mesh
shrink = 0.8                                 # optional: largest ratio of the error on a mesh to that on the next coarser one

[diff]                                       # for `post diff --expect`
rel = 1e-6                                   # general tolerance: rel, abs, scaled
column.torque = { abs = 1e-3 }               # tolerance of one column
interpolate = "time";  key = ["n"];  only = [];  ignore = ["iterations"]
"""

import pathlib
import tomllib

from post._error import Unreadable
from post._table import read_table, read_text
from post._tolerance import DEFAULT, KINDS, Tolerance, Tolerances

NAMES = "a list of names of columns"
DIFF_KEYS = {*KINDS, "column", "interpolate", "key", "only", "ignore"}
CHECK_KEYS = {
    "name", "deck", "set", "options", "exit", "source", "slow", "row", "factor", "time_limit", "formula",
    "curve", "column", "report", "warning", "error", "field", "affine", "want", "rel", "abs", "scaled",
    "reference", "interpolate", "key", "only", "ignore", "each", "vary", "where", "map",
}  # fmt: skip
STUDY_KEYS = {
    "name", "deck", "set", "options", "time_limit", "source", "slow", "curve", "column", "row", "factor", "formula", "value", "want",
    "limit", "shrink", "each", "vary", "where", "map",
}  # fmt: skip


def read_expect(path):
    """The file as {title, checks, studies}; a check with `each` or `vary` becomes one per row."""
    path = pathlib.Path(path)
    content = _load(path)
    unknown = set(content) - {"title", "source", "check", "study", "diff"}
    if unknown:
        raise Unreadable(f"'{path}': unknown entry '{sorted(unknown)[0]}'")
    checks = []
    for i, check in enumerate(content.get("check", ()), 1):
        _known(path, f"check {i}", check, CHECK_KEYS)
        checks += _multiplied(path, check)
    studies = []
    for i, study in enumerate(content.get("study", ()), 1):
        _known(path, f"study {i}", study, STUDY_KEYS)
        studies.append(_study(path, study))
    source = content.get("source", "")
    for check in checks:
        check.setdefault("source", source)
    return {"title": content.get("title", path.parent.name), "checks": checks, "studies": studies}


def _study(path, study):
    """A study as {mesh, rows}: the last key of `vary`, which sets the mesh, and the list of (row,
    entries, slow).
    """
    if "vary" not in study or not {"value", "want", "limit"} <= set(study):
        raise Unreadable(f"'{path}': a study needs the keys vary, value, want and limit")
    mesh = list(study["vary"])[-1]
    more = {
        **study,
        "vary": {**study["vary"], mesh: [*study["vary"][mesh], *study.get("slow", ())]},
    }
    rest = {k: v for k, v in study.items() if k not in ("each", "vary", "where", "map", "slow")}
    rows = _rows(path, more)
    return {
        "mesh": mesh,
        "rows": [
            (row, fill(rest, row, study.get("map", {}), path), row[mesh] in study.get("slow", ()))
            for row in rows
        ],
    }


def read_diff(path):
    """Arguments of `diff.compare` from the [diff] table."""
    content = _load(path).get("diff")
    if content is None:
        raise Unreadable(f"'{path}' has no [diff] table")
    if not isinstance(content, dict):
        raise Unreadable(f"'{path}': diff is not a table")
    _known(path, "[diff]", content, DIFF_KEYS)
    columns = content.get("column", {})
    for name, kinds in columns.items() if isinstance(columns, dict) else [("column", columns)]:
        if not isinstance(kinds, dict):
            raise Unreadable(
                f"'{path}', [diff]: {name} is not a table; write column.NAME = {{ rel = 1e-3 }}"
            )
        _known(path, f"[diff], column.{name}", kinds, set(KINDS))
    for name, kind, what in (
        ("interpolate", str, "the name of a column"), ("key", list, NAMES), ("only", list, NAMES),
        ("ignore", list, NAMES),
    ):  # fmt: skip
        value = content.get(name, kind())
        if not isinstance(value, kind) or not all(isinstance(word, str) for word in value):
            raise Unreadable(f"'{path}', [diff]: {name} = {value!r} is not {what}")
    return diff_arguments(content)


def diff_arguments(content):
    """{tolerances, interpolate, key, only, ignore} from a table with the keys of [diff].

    >>> diff_arguments({"rel": 1e-3, "key": ["n"]})["tolerances"].of("t", "f")
    Tolerance(rel=0.001, abs=0.0, scaled=0.0)
    """
    general = tolerance_of(content)
    named = {n: Tolerance(**kinds) for n, kinds in content.get("column", {}).items()} if isinstance(
        content.get("column", {}), dict) else {}  # fmt: skip
    arguments = {"tolerances": Tolerances(general or DEFAULT, named)}
    return arguments | {
        n: content[n] for n in ("interpolate", "key", "only", "ignore") if n in content
    }


def tolerance_of(content):
    """The Tolerance given by the keys rel, abs and scaled, or None if all three are missing."""
    given = {kind: content[kind] for kind in KINDS if kind in content}
    try:
        given = {kind: float(value) for kind, value in given.items()}
    except (TypeError, ValueError):
        pass  # Tolerance says which one is not a number
    return Tolerance(**given) if given else None


def _load(path):
    try:
        return tomllib.loads(read_text(path))
    except tomllib.TOMLDecodeError as error:
        raise Unreadable(f"'{path}' is not valid TOML: {error}") from None


def _known(path, what, content, keys):
    unknown = sorted(set(content) - keys)
    if unknown:
        raise Unreadable(f"'{path}', {what}: unknown entry '{unknown[0]}'")


def _multiplied(path, check):
    """One check for each row of `each` and each combination of `vary`."""
    if "each" not in check and "vary" not in check:
        return [check]
    rest = {k: v for k, v in check.items() if k not in ("each", "vary", "where", "map")}
    return [fill(rest, row, check.get("map", {}), path) for row in _rows(path, check)]


def _rows(path, content):
    """The rows (dictionaries) that `each`, `vary` and `where` select."""
    rows = [{}]
    if "each" in content:
        table = read_table(path.parent / content["each"])
        plain = lambda v: str(v) if isinstance(v, str) else float(v)
        rows = [{n: plain(v[i]) for n, v in table.columns.items()} for i in range(len(table))]
    for name, values in content.get("vary", {}).items():
        rows = [{**row, name: value} for row in rows for value in values]
    rows = [r for r in rows if all(r.get(n) == v for n, v in content.get("where", {}).items())]
    if not rows:
        raise Unreadable(f"'{path}': `each`, `vary` and `where` select no row")
    return rows


def fill(content, row, maps, path):
    """`content` with each {name} replaced by the row's value, and with the keys added by `maps`.

    >>> fill({"name": "{t} n={n}", "want": "{f}"}, {"t": "Q1", "n": 2.0, "f": 0.5}, {"t": {"Q1": {"rel": 0.1}}}, "")
    {'name': 'Q1 n=2', 'want': 0.5, 'rel': 0.1}
    """
    row = dict(row)
    content = dict(content)
    for column, values in maps.items():
        if row.get(column) not in values:
            raise Unreadable(f"'{path}': map.{column} has no entry '{row.get(column)}'")
        added = values[row[column]]
        row.update(added)
        content.update({k: v for k, v in added.items() if k in CHECK_KEYS | STUDY_KEYS})
    return {k: _filled(v, row) for k, v in content.items()}


def _filled(value, row):
    if isinstance(value, dict):
        return {k: _filled(v, row) for k, v in value.items()}
    if not isinstance(value, str):
        return value
    if value.startswith("{") and value.endswith("}") and value[1:-1] in row:
        return row[value[1:-1]]  # the value itself, so that a number stays a number
    for name, cell in row.items():
        value = value.replace("{" + name + "}", cell if isinstance(cell, str) else f"{cell:g}")
    return value
