"""One check of `verify`: the runs that it needs, and the comparison of their results."""

import json
import math
import os
import pathlib
import re
import subprocess
import time
from dataclasses import dataclass, field

from post import diff
from post._error import Unreadable
from post._expect import diff_arguments, tolerance_of
from post._report import read_report
from post._table import read_table
from post._tolerance import Tolerance
from verification.formula import evaluate

TIME_LIMIT = 1200  # seconds that a run may take if the check gives no limit


@dataclass(frozen=True)
class Run:
    """One call of the program; runs that are equal are made only once."""

    name: str  # <case>/<deck>-<parameters>, its folder below build/verify
    deck: pathlib.Path
    settings: tuple = ()
    options: tuple = ()
    time_limit: float = TIME_LIMIT


@dataclass
class Outcome:
    code: int | None  # exit code; None: the run could not be started or took too long
    seconds: float = 0.0
    reason: str = ""  # first line on standard error


@dataclass
class Row:
    """One line of the table that `verify` prints: a quantity and the value that it must have."""

    case: str
    quantity: str
    got: object = None
    want: object = None
    difference: float | None = None
    tolerance: str = ""
    ok: bool = False
    reason: str = ""
    source: str = ""

    def numbers(self):
        return (
            _text(self.got),
            _text(self.want),
            "-" if self.difference is None else f"{self.difference:.1e}",
            self.tolerance,
        )


@dataclass
class Plan:
    """Runs of a check or of one series of a study; `judge` turns their outcomes into rows."""

    folder: pathlib.Path
    runs: list
    judge: object
    table: list = field(default_factory=list)  # rows for results.csv, filled by `judge`
    lost: bool = False


def failed(case, quantity, reason):
    return Row(case, quantity, reason=reason)


def new_run(folder, entry):
    """The run for a check or for one mesh of a study."""
    deck = folder / entry["deck"]
    settings = tuple(
        f"{n}={v:.16g}" if isinstance(v, (int, float)) else f"{n}={v}"
        for n, v in entry.get("set", {}).items()
    )
    options = tuple(str(word) for word in entry.get("options", ()))
    words = [deck.stem, *settings, *options]
    name = re.sub(r"[^\w=.+-]+", "_", "-".join(words))
    return Run(
        f"{folder.name}/{name}", deck, settings, options, float(entry.get("time_limit", TIME_LIMIT))
    )


def execute(bezel, out, run):
    """Run the program in a folder of its own; its output is stored there in stdout.txt and
    stderr.txt.
    """
    place = out / run.name
    place.mkdir(parents=True, exist_ok=True)
    command = [str(bezel), "--quiet", "-o", str(place), *run.options]
    for setting in run.settings:
        command += ["--set", setting]
    one_thread = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", **os.environ}
    start = time.monotonic()
    try:
        with open(place / "stdout.txt", "w") as said, open(place / "stderr.txt", "w") as wrong:
            done = subprocess.run([*command, str(run.deck)], stdout=said, stderr=wrong, cwd=place, timeout=run.time_limit,
                                  env=one_thread, stdin=subprocess.DEVNULL)  # fmt: skip
    except subprocess.TimeoutExpired:
        return Outcome(None, run.time_limit, f"took longer than {run.time_limit:g} s")
    except OSError as error:
        return Outcome(None, 0.0, f"could not be started: {error.strerror}")
    lines = (place / "stderr.txt").read_text(errors="replace").strip().splitlines()
    return Outcome(done.returncode, time.monotonic() - start, lines[0] if lines else "")


def plan_check(folder, check):
    """The Plan of a [[check]] in expect.toml."""
    quantity = check.get("name") or _quantity(check)
    try:
        run = new_run(folder, check)
    except KeyError as error:
        rows = [failed(folder.name, quantity, f"the check lacks the key {error}")]
        return Plan(folder, [], lambda out, outcomes: rows)

    def judge(out, outcomes):
        try:
            exit_code(run, outcomes[run.name], check.get("exit", 0))
            if "error" in check and check["error"] not in outcomes[run.name].reason:
                raise Unreadable(f"{run.name} said: {outcomes[run.name].reason}")
            if "warning" in check:
                warned(out / run.name, run.deck.stem, check["warning"])
            rows = _rows_of(folder, check, quantity, out / run.name, run.deck.stem)
        except (Unreadable, ModuleNotFoundError) as error:
            rows = [failed(folder.name, quantity, str(error))]
        for row in rows:
            row.source = check.get("source", "")
        return rows

    return Plan(folder, [run], judge)


def _quantity(check):
    kind = next((k for k in ("curve", "report", "field") if k in check), "exit")
    words = [str(check.get(k)) for k in (kind, "column", "formula", "reference") if k in check]
    return " ".join(words or ["exit code"]) + (f" {check['set']}" if check.get("set") else "")


def exit_code(run, outcome, wanted):
    if outcome.code != wanted:
        how = (
            outcome.reason
            if outcome.code is None
            else f"ended with code {outcome.code}, expected {wanted}: {outcome.reason}"
        )
        raise Unreadable(f"{run.name} {how}")


def warned(place, stem, wanted):
    """Require that the report and the log have a warning with the words `wanted` or, if `wanted` is
    empty, that there is no warning.
    """
    warnings = json.loads((place / f"{stem}.report.json").read_text())["warnings"]
    if not wanted and warnings:
        raise Unreadable(f"unexpected warning: {warnings[0]}")
    if wanted and not any(wanted in text for text in warnings):
        raise Unreadable(f"no warning contains the words '{wanted}': {warnings}")
    if wanted and wanted not in (place / f"{stem}.log").read_text():
        raise Unreadable(f"the log does not contain the warning '{wanted}'")


def _rows_of(folder, check, quantity, place, stem):
    if "reference" in check:
        return _curve_rows(folder, check, quantity, place / f"{stem}_{check['curve']}.dat")
    if "field" in check:
        from verification.fields import field_row

        return [field_row(folder.name, quantity, place / f"{stem}.vtkhdf", check)]
    if "curve" not in check and "report" not in check:
        return [
            Row(
                folder.name,
                quantity,
                check.get("exit", 0),
                check.get("exit", 0),
                None,
                "exact",
                True,
            )
        ]
    if "want" not in check:
        raise Unreadable("the check has neither `want` nor `reference`")
    return [
        compared(
            folder.name, quantity, value_of(place, stem, check), check["want"], tolerance_of(check)
        )
    ]


def value_of(place, stem, entry):
    """The number (or word) that an entry selects from the results of a run."""
    if "report" in entry:
        table = read_report(place / f"{stem}.report.json", everything=True)
        value = table.columns[table.find(entry["report"])][0]
        return str(value) if isinstance(value, str) else float(value) * entry.get("factor", 1.0)
    table = read_table(place / f"{stem}_{entry['curve']}.dat")
    if "formula" in entry:
        return evaluate(entry["formula"], table, entry.get("set", {}))
    column = entry.get("column") or next(iter(table.quantities()), "")
    return float(
        table.columns[table.find(column)][_row_index(table, entry.get("row", "last"))]
    ) * entry.get("factor", 1.0)


def _row_index(table, row):
    if row in ("last", "first"):
        return -1 if row == "last" else 0
    column, value = ("time", row["time"]) if isinstance(row, dict) else ("step", row)
    values = table.columns[table.find(column)]
    nearest = int(abs(values - value).argmin())
    if abs(values[nearest] - value) > 1e-9 * max(abs(value), abs(values).max()):
        raise Unreadable(f"{table.name} has no row with {column} {value}")
    return nearest


def compared(case, quantity, got, want, tolerance):
    """A row for one value: words must be equal, and numbers must agree within the tolerance."""
    if isinstance(want, str) or isinstance(got, str):
        return Row(case, quantity, got, want, None, "exact", got == want)
    want = float(want)
    difference = abs(got - want)
    if tolerance is None:
        tolerance = Tolerance()  # without a tolerance, numbers must agree exactly
    ok = (
        math.isfinite(got)
        and math.isfinite(want)
        and difference <= tolerance.allowed(want, abs(want))
    )
    relative = tolerance.rel > 0 and want != 0
    return Row(
        case,
        quantity,
        got,
        want,
        difference / abs(want) if relative else difference,
        str(tolerance),
        ok,
    )


def _curve_rows(folder, check, quantity, file):
    arguments = diff_arguments({k: v for k, v in check.items() if k not in ("column", "set")} | (
        {"column": check["column"]} if isinstance(check.get("column"), dict) else {}))  # fmt: skip
    comparison = diff.compare(file, folder / check["reference"], **arguments)
    rows = []
    for table in comparison.tables:
        for c in table.columns:
            rows.append(
                Row(
                    folder.name,
                    f"{quantity}: {c.name}, {c.rows} rows",
                    c.got,
                    c.want,
                    c.difference,
                    str(c.tolerance),
                    c.ok,
                    c.note,
                )
            )
        rows += [failed(folder.name, quantity, problem) for problem in table.problems]
    return rows


def _text(value):
    return "-" if value is None else value if isinstance(value, str) else f"{value:.10g}"


def as_json(rows):
    """The table as JSON."""
    plain = lambda v: str(v) if isinstance(v, float) and not math.isfinite(v) else v
    table = [{k: plain(v) for k, v in vars(row).items()} for row in rows]
    bad = sum(not r.ok for r in rows)
    return json.dumps({"passed": len(rows) - bad, "failed": bad, "rows": table}, indent=1) + "\n"
