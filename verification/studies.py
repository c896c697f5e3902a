"""Refinement studies of `verify`: errors relative to a converged value, mesh by mesh."""

import csv

from post._error import Unreadable
from post._report import read_report
from verification import checks


def plan_studies(folder, studies, everything):
    """Plans of the refinement studies: each series of a [[study]] has one plan and one row of the
    table, and each of its meshes has one row of results.csv.
    """
    plans = []
    for study in studies:
        series = {}
        for row, entry, slow in study["rows"]:
            if everything or not slow:
                names = tuple(v for k, v in row.items() if k != study["mesh"])
                series.setdefault(names, []).append((row, entry, checks.new_run(folder, entry)))
        plans += [
            _plan_series(folder, study["mesh"], names, meshes) for names, meshes in series.items()
        ]
    return plans


def _plan_series(folder, mesh, names, meshes):
    quantity = (
        " ".join(str(n) for n in names)
        + f", {mesh} = "
        + " ".join(f"{row[mesh]:g}" for row, _, _ in meshes)
    )
    plan = checks.Plan(folder, [run for _, _, run in meshes], None)

    def judge(out, outcomes):
        errors = []
        try:
            for row, entry, run in meshes:
                checks.exit_code(run, outcomes[run.name], 0)
                value = checks.value_of(out / run.name, run.deck.stem, entry)
                report = read_report(out / run.name / f"{run.deck.stem}.report.json").columns
                errors.append(value / entry["want"] - 1.0)
                # Threads of the linear algebra change the eleventh digit from run to run.
                plan.table.append(
                    {
                        **row,
                        "dofs": int(report["dofs"][0]),
                        entry["value"]: f"{value:.8g}",
                        "error": f"{errors[-1]:.4e}",
                    }
                )
        except (Unreadable, KeyError) as error:
            plan.lost = True
            return [checks.failed(folder.name, quantity, f"{error}")]
        return [_study_row(folder.name, quantity, errors, meshes[-1][1], value)]

    plan.judge = judge
    return plan


def _study_row(case, quantity, errors, entry, value):
    """Compare the finest mesh with the converged value; with `shrink`, also check that the error
    decreases.
    """
    limit, shrink = float(entry["limit"]), entry.get("shrink")
    ok, reason = abs(errors[-1]) <= limit, ""
    if shrink is not None:
        grown = [
            i for i in range(1, len(errors)) if not abs(errors[i]) <= shrink * abs(errors[i - 1])
        ]
        if grown:
            ok, reason = (
                False,
                f"the error does not decrease by the factor {shrink:g} on every mesh: "
                + " ".join(f"{e:.2e}" for e in errors),
            )
    return checks.Row(
        case,
        quantity,
        value,
        entry["want"],
        abs(errors[-1]),
        f"rel {limit:.3g}",
        ok,
        reason,
        entry.get("source", ""),
    )


def write_tables(plans):
    """Write the tables of those refinement studies that are complete, for post/figures."""
    for folder in {p.folder for p in plans if p.table}:
        table = [row for p in plans if p.folder == folder for row in p.table]
        if any(p.folder == folder and p.lost for p in plans):
            print(f"{folder.name}: a run of the study failed, so results.csv is not changed")
            continue
        path = folder / "results.csv"
        with open(path, "w", encoding="utf-8", newline="") as file:
            file.write(
                "# written by python -m verification.verify --study; error = value / converged value - 1\n"
            )
            writer = csv.DictWriter(file, list(table[0]), lineterminator="\n")
            writer.writeheader()
            writer.writerows(table)
        print(f"wrote {path}")
