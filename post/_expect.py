"""`expect.toml`: what a verification case must give, and how `diff` compares it.

    title  = "Cook's membrane, neo-Hooke"        # one line
    source = "Simo & Armero 1992, table 1"       # of every check that names none

    [[check]]                                    # one number of one run
    name   = "tip deflection, n = 8"             # default: the quantity
    deck   = "cook.inp"
    set    = { n = 8 }                           # parameters given with --set
    curve  = "tip"                               # the file <deck>_tip.dat ...
    column = "disp"                              # ... its column (beginning of the name; default: first quantity)
    row    = "last"                              # last, first, a step's number, or { time = 0.5 }
    factor = 1.0                                 # got = factor * value
    want   = 6.937
    rel    = 1e-3                                # or abs; at least one
    slow   = true                                # with --all only

    report = "dofs"                              # instead of curve: an entry of the report (final.tip.disp, elements.Q1)

    field  = "stress"                            # instead of curve: every point of a field at a step
    want   = [0.1, 0, 0, 0, 0, 0]                # the same at all points, or
    affine = [[0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]]   # the linear function of the reference position, 3 or 4 columns

    reference = "force.csv"                      # instead of want: a whole curve; keys of [diff] below apply

    each = "reference.csv"                       # one check for each row; "{column}" stands for the row's value
    [check.map.elements]                         # optional: more values by that of a column
    "Q1" = { deck = "q1.inp", rel = 1e-6 }

    [[study]]                                    # a refinement study, see verify.py --study

    [diff]                                       # for `post diff --expect`
    rel = 1e-6                                   # general tolerance: rel abs scaled
    column.torque = { abs = 1e-3 }               # of a column
    interpolate = "time";  key = ["n"];  only = [];  ignore = ["iterations"]
"""

import pathlib
import tomllib

from post._error import Unreadable
from post._table import read_table, read_text
from post._tolerance import DEFAULT, KINDS, Tolerance, Tolerances

DIFF_KEYS = {*KINDS, "column", "interpolate", "key", "only", "ignore"}
CHECK_KEYS = {
    "name", "deck", "set", "options", "exit", "source", "slow", "row", "factor", "time_limit",
    "curve", "column", "report", "field", "affine", "want", "rel", "abs", "scaled",
    "reference", "interpolate", "key", "only", "ignore", "each", "where", "map",
}  # fmt: skip
STUDY_KEYS = {
    "name", "deck", "set", "over", "slow", "curve", "column", "factor", "want", "limit", "shrink", "source", "map",
    "series", "options", "time_limit",
}  # fmt: skip


def read_expect(path):
    """The file as {title, source, checks, studies}; checks with `each` are multiplied out."""
    path = pathlib.Path(path)
    content = _load(path)
    unknown = set(content) - {"title", "source", "check", "study", "diff"}
    if unknown:
        raise Unreadable(f"'{path}': unknown entry '{sorted(unknown)[0]}'")
    checks = []
    for i, check in enumerate(content.get("check", ()), 1):
        _known(path, f"check {i}", check, CHECK_KEYS)
        checks += _each(path, check) if "each" in check else [check]
    for i, study in enumerate(content.get("study", ()), 1):
        _known(path, f"study {i}", study, STUDY_KEYS)
    source = content.get("source", "")
    for check in checks:
        check.setdefault("source", source)
    return {"title": content.get("title", path.parent.name), "checks": checks, "studies": content.get("study", [])}


def read_diff(path):
    """Arguments of `diff.compare` from the [diff] table."""
    content = _load(path).get("diff")
    if content is None:
        raise Unreadable(f"'{path}' has no [diff] table")
    _known(path, "[diff]", content, DIFF_KEYS)
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
    return arguments | {n: content[n] for n in ("interpolate", "key", "only", "ignore") if n in content}


def tolerance_of(content):
    """The Tolerance that the keys rel, abs, scaled give, or None where there is none."""
    given = {kind: float(content[kind]) for kind in KINDS if kind in content}
    return Tolerance(**given) if given else None


def _load(path):
    try:
        return tomllib.loads(read_text(path))
    except tomllib.TOMLDecodeError as error:
        raise Unreadable(f"'{path}' is not TOML: {error}") from None


def _known(path, what, content, keys):
    unknown = sorted(set(content) - keys)
    if unknown:
        raise Unreadable(f"'{path}', {what}: unknown entry '{unknown[0]}'")


def _each(path, check):
    """One check a row of the table `each`; words in braces are the row's values."""
    table = read_table(path.parent / check["each"])
    names, rows = list(table.columns), []
    for i in range(len(table)):
        row = {n: table.columns[n][i] for n in names}
        if all(str(row.get(n)) == str(v) for n, v in check.get("where", {}).items()):
            rows.append({n: str(v) if isinstance(v, str) else float(v) for n, v in row.items()})
    if not rows:
        raise Unreadable(f"'{path}': no row of {check['each']} is chosen")
    rest = {k: v for k, v in check.items() if k not in ("each", "where", "map")}
    return [fill(rest, row, check.get("map", {}), path) for row in rows]


def fill(content, row, maps, path):
    """`content` with {name} replaced by the row's values, and with what `maps` adds for them.

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
        return row[value[1:-1]]  # the value itself, a number as a number
    for name, cell in row.items():
        value = value.replace("{" + name + "}", cell if isinstance(cell, str) else f"{cell:g}")
    return value
