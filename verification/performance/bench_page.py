#!/usr/bin/env python3
"""Write doc/verification/performance.md from record.json, as `bench --record` also does."""

import json
import pathlib

from verification.performance import bench_contact as contact
from verification.performance import bench_peel as peel
from verification.performance import bench_table as table

HERE = pathlib.Path(__file__).resolve().parent
PAGE = HERE.parents[1] / "doc/verification/performance.md"
SAME_FORCE = 1e-6  # as in bench

INTRO = """# Performance

## Summary

- **Measured:** run time and memory of bezel on one thread for a cube, a sliding hemisphere and a peeled strip, and the times of kernels.
- **Against:** FElupe and CalculiX on the same meshes, and the targets of the project.
- **Main result:** the CPU time per iteration of the other programs, divided by that of bezel, is {result}.
- **Targets missed:** {missed}.
- **Command:** `make bench`.

## Method

- `python -m verification.performance.bench_page` writes this page from `record.json`, the recorded run:

```
make bench ARGS="--n {n} --rounds {rounds} --record"
```

- Without `--record` the run is compared with the recorded one instead.
- Every run of the cube is made between two full Newton runs of bezel, and ratios are taken within such a triple. The seconds depend on the
  machine; the ratios depend on it far less.
"""

MISSED = """
## Missed targets

{lines}
"""

KERNELS = """## Kernels

- Times are given in microseconds for one element (residual and tangent) or for one point. Each is the best of several runs.
- The rate of dgemm is given for comparison.
- A projection starts at a point a hundredth or a tenth of an element away from the closest point, or from the search grid.

"""

WHY = {  # the beginning of a target's text: the reason why it is missed
    "CPU time per iteration, 'FElupe, Pardiso on the upper": "The recommended solver of FElupe, in the row above, factorises "
    "an unsymmetric matrix. Here a solver function that is not part of FElupe passes the upper triangle to Pardiso.",
}


def summary(result):
    """The main result: the CPU time per iteration of the other programs relative to that of
    bezel.
    """
    rows, contact = result["runs"], result.get("contact", {}).get("runs", {})
    found = [
        f"{rows[name]['iteration_cpu']:.2f} ({title})"
        for name, title in (("felupe", "FElupe, cube"), ("calculix", "CalculiX, cube"))
        if name in rows
    ]
    found += [
        f"{contact[key]['ratio']:.2f} (CalculiX, contact, mu = {key.split(', ')[1]})"
        for key in ("calculix, 0", "calculix, 0.5")
        if key in contact
    ]
    return ", ".join(found[:-1]) + " and " + found[-1] if found[1:] else "".join(found)


def missed_names(result):
    """The missed targets, joined in one phrase."""
    rows = (row for row in table.targets(result).splitlines() if "(missed)" in row)
    return "; ".join(row.strip("|").split("|")[0].strip() for row in rows) or "none"


def missed(result):
    """A line for each missed target, with the reason if one is known."""
    lines = []
    for row in table.targets(result).splitlines():
        if "(missed)" not in row:
            continue
        text, wanted, found = (cell.strip() for cell in row.strip("|").split("|"))
        why = next((reason for start, reason in WHY.items() if text.startswith(start)), "")
        lines.append(f"- {text}: {found.removesuffix(' (missed)')} instead of {wanted}. {why}")
    return "\n".join(line.strip() for line in lines) or "None."


def page(result):
    """The text of the page."""
    parts = [
        INTRO.format(
            n=result["n"],
            rounds=result["rounds"],
            result=summary(result),
            missed=missed_names(result),
        ),
        "## Machine\n\n" + table.head(result),
        "## One cube, three programs\n\n" + table.cube(result, SAME_FORCE),
        *(["## Contact\n\n" + contact.table(result["contact"])] if "contact" in result else []),
        *(["## Debonding\n\n" + peel.table(result["peel"])] if "peel" in result else []),
        "## Targets\n\n" + table.targets(result),
        MISSED.format(lines=missed(result)).lstrip("\n"),
        KERNELS + table.kernels(result),
    ]
    return "\n".join(parts)


if __name__ == "__main__":
    PAGE.write_text(page(json.loads((HERE / "record.json").read_text())))
