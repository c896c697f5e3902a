"""Write the tables of doc/verification/tradeoff.md from results.csv.

The text between the marks `<!-- table: name -->` and `<!-- end -->` is replaced; all other text is
edited in the page itself. The table `bonds` is written by debonding_points.

    python3 -m verification.tradeoff.page
"""

import csv

from verification import TOP
from verification.page import put_table

RESULTS = TOP / "verification/benchmark/tradeoff/results.csv"
PAGE = TOP / "doc/verification/tradeoff.md"

ERRORS = {"e_force": "force", "e_torque": "torque", "e_traction": "traction"}
CHANGES = {"d_force": "force", "d_torque": "torque", "d_traction": "traction"}
WORK = {"iterations": "iterations", "cpu_s": "CPU s"}
RUN = {"mesh": "mesh", "elements": "elements"}
#: group: the columns of its table with their headings
TABLES = {
    "elements": {**RUN, "dofs": "dofs", **WORK, **ERRORS, "force_imbalance": "imbalance",
                 "inertia": "inertia"},
    "points": {**RUN, "name": "points", "cpu_s": "CPU s", "contact_share": "contact time", **CHANGES,
               "inertia": "inertia"},
    "penalty": {**RUN, "name": "penalty", **WORK, "penetration": "penetration", **CHANGES,
                "inertia": "inertia"},
    "scheme": {**RUN, "name": "formulation", **WORK, "ratio": "CPU, ratio", "penetration": "penetration", **ERRORS,
               "force_imbalance": "imbalance", "inertia": "inertia"},
    "steps": {"mesh": "mesh", "name": "step", "steps": "steps", "cutbacks": "cut-backs", **WORK, **CHANGES},
    "solver": {"name": "FACTor", **WORK, "ratio": "CPU, ratio", **CHANGES},
    "tangent": {**RUN, "name": "tangent", **WORK, "ratio": "CPU, ratio"},
    "place": {"name": "elements", "dofs": "dofs", **WORK, **ERRORS},
    "augment": {"mesh": "mesh", "name": "method", **WORK, "penetration": "penetration", "force": "force",
                "torque": "torque", "force_imbalance": "imbalance"},
}  # fmt: skip
WORDS = ("elements", "name")
PERCENT = (*ERRORS, *CHANGES, "force_imbalance", "contact_share")


def main():
    with open(RESULTS, newline="") as file:
        rows = list(csv.DictReader(file))
    text = PAGE.read_text()
    for group, columns in TABLES.items():
        lines = [row_of(row, columns) for row in rows if row["group"] == group]
        text = put_table(text, group, "\n".join([*heads(columns), *lines]))
    PAGE.write_text(text)


def heads(columns):
    """The heading line of a table and the line below it."""
    rule = "|".join("---" if name in WORDS else "--:" for name in columns)
    return ["| " + " | ".join(columns.values()) + " |", f"|{rule}|"]


def row_of(row, columns):
    """One run as a line of a table; a failed run shows its exit code.

    >>> row_of({"name": "q 5", "code": "0", "d_force": "0.0123"}, {"name": "", "d_force": ""})
    '| q 5 | 1.2 % |'
    """
    cells = [cell(name, row[name]) for name in columns]
    if row["code"] != "0":
        cells = [c or "-" for c in cells]
        cells[-1] = f"ends with code {row['code']}"
    return "| " + " | ".join(cells) + " |"


def cell(name, value):
    if name not in PERCENT or not value:
        return value
    share = 100 * float(value)
    if name == "contact_share":
        return f"{share:.0f} %"
    return "0" if share == 0 else f"{share:.2g} %" if share < 9.95 else f"{share:.0f} %"


if __name__ == "__main__":
    main()
