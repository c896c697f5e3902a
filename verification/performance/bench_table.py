"""The tables of `make bench` in Markdown: measured values, targets, and changes from the record."""

from verification.performance import bench_contact, bench_peel

TITLES = {
    "full": "bezel, full Newton",
    "default": "bezel, default (FACTor AUTO)",
    "reuse": "bezel, FACTor REUSe",
    "single": "bezel, FACTor SINGle",
    "reuse, Q1E9": "bezel, Q1E9, FACTor REUSe",
    "felupe": "FElupe",
    "felupe, symmetric": "FElupe, Pardiso on the upper triangle",
    "calculix": "CalculiX, C3D8",
}


def same_force(result, tolerance):
    """Whether bezel's solvers agree with each other and with FElupe; Q1E9 and CalculiX solve
    different problems.
    """
    rows = result["runs"]
    same = [n for n in ("default", "reuse", "single", "felupe", "felupe, symmetric") if n in rows]
    return all(difference(rows, name) <= tolerance for name in same)


def difference(rows, name):
    """Relative difference of the final force from that of full Newton."""
    return abs(rows[name]["force"] / rows["full"]["force"] - 1)


def render(result, record, tolerance):
    """The whole text of bench.md."""
    parts = [head(result), cube(result, tolerance), targets(result), kernels(result)]
    if "contact" in result:
        parts.append(bench_contact.table(result["contact"]))
    if "peel" in result:
        parts.append(bench_peel.table(result["peel"]))
    if record:
        parts.append(change(result, record))
    return "\n".join(parts)


def head(result):
    """Machine and versions."""
    m = result["machine"]
    versions = {row["version"] for row in result["runs"].values() if "version" in row}
    lines = [
        f"- Date: {result['date']}",
        f"- Machine: {m['cpu']}, {m['cores']} cores, {m['memory_gib']} GiB; one thread; "
        f"load averages {m['load']} at the start",
        f"- Programs: {', '.join(sorted(versions))}",
        f"- Compiler and libraries: gfortran {m['gfortran']}, MUMPS {m['mumps']}, "
        f"OpenBLAS {m['openblas']} with its {m['blas_kernel']} kernels",
        *(
            f"- The part '{name}' and the kernels were recorded later, on {part['date']}: {part['machine']['cpu']}, "
            f"{part['machine']['cores']} cores, OpenBLAS with its {part['machine']['blas_kernel']} kernels"
            for name, part in result.get("later", {}).items()
        ),
        *(f"- Not available: {text}" for text in result["missing"]),
    ]
    return "\n".join(lines) + "\n"


def cube(result, tolerance):
    """One row per program."""
    n = result["n"]
    lines = [
        f"The cube of section 4 with {n} x {n} x {2 * n} elements is compressed by 25 % in five steps. The table "
        f"gives medians of {result['rounds']} rounds and ratios to the full Newton runs just before and after.",
        "",
        "| run | iterations | CPU s | wall s | CPU s per iteration | run over full Newton, CPU (wall) "
        "| iteration over full Newton, CPU (wall) | assembly | MB | force | difference |",
        "|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|",
    ]
    rows = result["runs"]
    for name, title in TITLES.items():
        if name not in rows:
            continue
        r = rows[name]
        whole = each = "1"
        if name != "full":
            whole = f"{r['run_cpu']:.2f} ({r['run_wall']:.2f})"
            each = f"{r['iteration_cpu']:.2f} ({r['iteration_wall']:.2f})"
        share = f"{100 * r['share']:.1f} %" if "share" in r else ""
        title += f", {r['solver']}" if "solver" in r else ""
        lines.append(
            f"| {title} | {r['iterations']} | {r['cpu']:.2f} | {r['wall']:.2f} "
            f"| {r['cpu'] / r['iterations']:.3f} | {whole} | {each} | {share} "
            f"| {r['memory']:.0f} | {r['force']:.10f} | {difference(rows, name):.1e} |"
        )
    lines += [
        "",
        "- The times of bezel and CalculiX are those of whole processes; for FElupe only the "
        "iterations are timed.",
        "- Q1E9 is a different element. The neo-Hooke law of CalculiX has (J - 1)^2 where that of bezel has "
        "(ln J)^2, so its force differs.",
        f"- Forces agree to {tolerance:.0e}: {'yes' if same_force(result, tolerance) else 'NO'}.",
    ]
    return "\n".join(lines) + "\n"


def targets(result):
    """The targets of the project, and what was measured."""
    rows, lines = result["runs"], ["| target | required | measured |", "|---|--:|--:|"]

    def line(text, wanted, found, good):
        lines.append(f"| {text} | {wanted} | {found}{'' if good else ' (missed)'} |")

    for name, wanted in (("felupe", 2.0), ("felupe, symmetric", 2.0), ("calculix", 3.5)):
        if name in rows:
            found = rows[name]["iteration_cpu"]
            text = f"CPU time per iteration, '{TITLES[name]}' over bezel"
            line(text, f"{wanted}", f"{found:.2f}", found >= wanted)
    found = 1 / rows["single"]["run_cpu"]
    line(
        "CPU time, full Newton over reused single-precision factors",
        "4",
        f"{found:.2f}",
        found >= 4,
    )
    share = rows["full"]["share"]
    line("fraction of assembly in a full Newton run", "5 %", f"{100 * share:.1f} %", share <= 0.05)
    for key, value in result["kernels"].items():
        if key.startswith("Q1, "):
            line(f"{key[:-5]}: residual and tangent", "0.5 us", f"{value:.2f} us", value <= 0.5)
    for row in bench_contact.targets(result):
        line(*row)
    return "\n".join(lines) + "\n"


def kernels(result):
    """The times of the kernels in microseconds."""
    if not result["kernels"]:
        return ""
    lines = ["| kernel | |", "|---|--:|"]
    lines += [f"| {key} | {value:g} |" for key, value in result["kernels"].items()]
    return "\n".join(lines) + "\n"


def change(result, record):
    """A table of the changes from the record."""
    if record["n"] != result["n"]:
        return f"The record of {record['date']} has n = {record['n']}, so there is no comparison.\n"
    lines = [
        f"Against the record of {record['date']} ({record['machine']['cpu']}, "
        f"{record['machine']['blas_kernel']} kernels):",
        "",
        "| | record | now | change |",
        "|---|--:|--:|--:|",
    ]

    def line(text, old, new):
        lines.append(f"| {text} | {old:.3g} | {new:.3g} | {100 * (new / old - 1):+.0f} % |")

    for name, row in result["runs"].items():
        old = record["runs"].get(name)
        if not old:
            continue
        each = [r["cpu"] / r["iterations"] for r in (old, row)]
        line(f"{TITLES[name]}, CPU s per iteration", *each)
        if name != "full":
            line(f"{TITLES[name]}, run over full Newton", old["run_cpu"], row["run_cpu"])
    for key, value in result["kernels"].items():
        if key in record["kernels"]:
            line(key, record["kernels"][key], value)
    return "\n".join(lines) + "\n"
