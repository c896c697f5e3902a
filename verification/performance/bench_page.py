#!/usr/bin/env python3
"""Write doc/verification/performance.md from record.json; `bench.py --record` does it too."""

import json
import pathlib

import bench_contact as contact
import bench_peel as peel
import bench_table as table

HERE = pathlib.Path(__file__).resolve().parent
PAGE = HERE.parents[1] / "doc/verification/performance.md"
SAME_FORCE = 1e-6  # as in bench.py

INTRO = """# Performance

Written by `verification/performance/bench_page.py` from `record.json`, the run that is kept:

```
make bench ARGS="--n {n} --rounds {rounds} --record"
```

Without `--record` the run is compared with the kept one instead. Every run stands between two full Newton runs
of bezel, and the ratios are taken within such a triple; the seconds are those of one machine, the ratios carry over.
"""

MISSED = """
## What misses its target

{lines}
"""

WHY = {  # the beginning of a target's text: what there is to say about it
    "one iteration of FElupe, Pardiso on the upper": "FElupe's own way, "
    "the row above, factorises an unsymmetric matrix; here Pardiso is handed the upper triangle by a solver "
    "function that is not FElupe's.",
}


def missed(result):
    """A line for each target that is missed, with its reason where one is known."""
    lines = []
    for row in table.targets(result).splitlines():
        if "(missed)" not in row:
            continue
        text, wanted, found = (cell.strip() for cell in row.strip("|").split("|"))
        why = next((reason for start, reason in WHY.items() if text.startswith(start)), "")
        lines.append(f"- {text}: {found.removesuffix(' (missed)')} where {wanted} is wanted. {why}")
    return "\n".join(line.strip() for line in lines) or "Nothing."


def page(result):
    """The text of the page."""
    parts = [
        INTRO.format(n=result["n"], rounds=result["rounds"]),
        "## Machine\n\n" + table.head(result),
        "## One cube, three programs\n\n" + table.cube(result, SAME_FORCE),
        *(["## Contact\n\n" + contact.table(result["contact"])] if "contact" in result else []),
        *(["## Debonding\n\n" + peel.table(result["peel"])] if "peel" in result else []),
        "## Targets\n\n" + table.targets(result),
        MISSED.format(lines=missed(result)).lstrip("\n"),
        "## Kernels\n\nMicroseconds of one element (residual and tangent) or one point, the best of some runs; the rate of dgemm.\n\n"
        + table.kernels(result),
    ]
    if "large" in result:
        parts.append(
            "## A large step, and what happens without memory\n\n" + table.large(result["large"])
        )
    return "\n".join(parts)


if __name__ == "__main__":
    PAGE.write_text(page(json.loads((HERE / "record.json").read_text())))
