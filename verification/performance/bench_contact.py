"""Contact in `make bench`: the hemisphere of section 5 twisted on its block, also with CalculiX.

The ratios refer to runs with two half passes, as in the paper; the default scheme is run as well.
Mesh 2 is run without and with friction, on one thread. Every run of another program or element is
made between two runs of bezel with Q1E9+Q1N2 (A B A), and ratios are taken within such a triple.
Finally the share of contact in the time of an iteration is measured for bezel on mesh 3.
"""

import json
import os
import pathlib
import shutil
import statistics

import numpy as np

from verification.performance import bench_runs as runs
from verification.performance import calculix_hemisphere as calculix

DECKS = pathlib.Path(__file__).resolve().parents[1] / "benchmark/section5_contact"
MESH_2 = {"n": 7, "m": 2, "k": 4, "eps": 250}
MESH_3 = {"n": 11, "m": 3, "k": 8, "eps": 500}
OURS, DEFAULT, LONG, Q1E9 = "q1e9_q1n2", "default", "large_steps", "q1e9"
THEIRS, SWAPPED, THEIRS_LONG = "calculix", "calculix, block as slave", "calculix, long increments"
TITLES = {
    OURS: "bezel, Q1E9+Q1N2, two half passes",
    DEFAULT: "bezel, Q1E9+Q1N2, default scheme",
    LONG: "bezel, the same, increments of 9 degrees",
    Q1E9: "bezel, Q1E9, two half passes",
    THEIRS: "CalculiX, C3D8",
    SWAPPED: "CalculiX, C3D8, block as slave",
    THEIRS_LONG: "CalculiX, C3D8, increments of 9 degrees",
}
FRICTION = (0.0, 0.5)
PARTS = ("assembly", "contact", "analyse", "factorise", "solve")
LONG_TURNS = 20  # increments of 9 degrees
ENOUGH = 180.0 - 1e-3  # degrees of a complete run


def time_contact(bezel, folder, missing):
    """Time all runs; return {"runs": {"name, mu": numbers}, "mesh_3": numbers of OURS on mesh 3,
    "mesh_3_default": those of DEFAULT, "load": load of the computer at the start}.
    """
    folder = folder / "contact"
    folder.mkdir(exist_ok=True)
    rows, load = {}, [round(x, 1) for x in os.getloadavg()]
    for mu in FRICTION:
        before = run_bezel(bezel, folder, OURS, mu, MESH_2)
        first = before
        for name in (DEFAULT, LONG, Q1E9, THEIRS, SWAPPED, THEIRS_LONG):
            if name in (LONG, SWAPPED, THEIRS_LONG) and mu == 0:
                continue
            print(f"bench: contact, mu = {mu:g}, {name}", flush=True)
            try:
                found = run_one(bezel, folder, name, mu)
            except runs.Unavailable as reason:
                if str(reason) not in missing:
                    missing.append(str(reason))
                continue
            after = run_bezel(bezel, folder, OURS, mu, MESH_2)
            ours = (each(before) + each(after)) / 2
            whole = (per_degree(before) + per_degree(after)) / 2
            ratios = {"ratio": each(found) / ours, "whole": per_degree(found) / whole}
            rows[f"{name}, {mu:g}"] = found | ratios
            before = after
        cpu = statistics.mean((first["cpu"], before["cpu"]))
        rows[f"{OURS}, {mu:g}"] = before | {"cpu": cpu, "ratio": 1.0, "whole": 1.0}
    print("bench: contact, mesh 3", flush=True)
    large = run_bezel(bezel, folder, OURS, FRICTION[-1], MESH_3)
    default = run_bezel(bezel, folder, DEFAULT, FRICTION[-1], MESH_3)
    return {"runs": rows, "mesh_3": large, "mesh_3_default": default, "load": load}


def run_one(bezel, folder, name, mu):
    """Make a run that is not the one to which the ratios refer."""
    if name in (DEFAULT, LONG, Q1E9):
        return run_bezel(bezel, folder, name, mu, MESH_2)
    place = folder / name.replace(", ", "_").replace(" ", "_")
    place.mkdir(exist_ok=True)
    return run_calculix(place, mu, name)


def each(row):
    """CPU seconds per iteration."""
    return row["cpu"] / row["iterations"]


def per_degree(row):
    """CPU seconds per degree of rotation."""
    return row["cpu"] / row["degrees"]


def deck_of(stem, folder):
    """The deck of a run; for the default scheme, it is the reference deck without its record
    SCHEme.
    """
    if stem != DEFAULT:
        return DECKS / f"{stem}.inp"
    place = folder / "default_deck"
    place.mkdir(exist_ok=True)
    for name in (f"{OURS}.inp", "head.inc", "scene.inc"):
        text = (DECKS / name).read_text().replace("  SCHEme HALFpass\n", "")
        (place / name.replace(OURS, DEFAULT)).write_text(text)
    return place / f"{DEFAULT}.inp"


def run_bezel(bezel, folder, stem, mu, mesh):
    """Time a whole process; also return the mean force and torque of the supports while all points
    slide.
    """
    settings = [f"--set={name}={value}" for name, value in (mesh | {"mu": mu}).items()]
    command = [bezel, "--quiet", "--threads", "1", "-o", str(folder), *settings]
    wall, cpu, _, code, _, errors = runs.measure([*command, str(deck_of(stem, folder))], folder)
    if code:
        raise SystemExit(f"bench: error: bezel ended with {code}: {errors.strip()}")
    report = json.loads((folder / f"{stem}.report.json").read_text())
    seconds = report["seconds"]
    solving = sum(seconds[part] for part in PARTS)
    row = {
        "wall": wall,
        "cpu": cpu,
        "iterations": report["iterations"],
        "steps": report["steps"],
        "equations": report["equations"],
        "share": seconds["contact"] / solving,
        "degrees": calculix.DEGREES,
    }
    return row | sliding_means(folder / f"{stem}_sole.dat")


def sliding_means(path):
    """Mean force and torque of the supports over that part of the turn in which all points
    slide.
    """
    names = path.read_text().splitlines()[0].strip("# ").split()
    data = dict(zip(names, np.loadtxt(path, unpack=True)))
    late = calculix.DEGREES * data["factor_2"] >= calculix.SLIDING - 1e-6
    columns = {"rim": ("force_3", "torque"), "base": ("force_3_2", "torque_2")}
    return {
        f"{what}_{where}": float(data[column][late].mean())
        for where, both in columns.items()
        for what, column in zip(("force", "torque"), both)
    }


def run_calculix(place, mu, name):
    """The same run with CalculiX."""
    program = shutil.which("ccx")
    if not program:
        raise runs.Unavailable("CalculiX is not installed (apt install calculix-ccx)")
    turns = LONG_TURNS if name == THEIRS_LONG else calculix.TURN
    mesh = calculix.write_input(place / "hemisphere.inp", MESH_2, mu, name == SWAPPED, turns)
    wall, cpu, _, _, output, _ = runs.measure([program, "hemisphere"], place)
    found = calculix.read_output(place, output, mesh)
    if not found["iterations"]:
        raise runs.Unavailable("CalculiX does not run the hemisphere")
    return {"wall": wall, "cpu": cpu} | found


# --- tables --------------------------------------------------------------------------------------
def table(contact):
    """One row per program and coefficient of friction."""
    lines = [
        "A hollow hemisphere is pressed on a block and turned by 180 degrees (mesh 2 of section 5).",
        "",
        "- The increments are 3 degrees where no others are given; they may be cut. bezel uses 5 x 5 integration points per surface element, CalculiX its own.",
        "- The times are those of whole processes. Ratios, per iteration and per degree of rotation, refer to the runs with two half passes just before and after. "
        f"The load averages were {contact['load']}.",
        "- Forces and torques are those of the supports at the rim and at the base, averaged from 120 degrees on.",
        "",
        "| run | mu | increments | iterations | CPU s | CPU ms per iteration | iteration, ratio | run, ratio "
        "| force, rim | force, base | torque, rim | torque, base |",
        "|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|",
    ]
    for mu in FRICTION:
        for name, title in TITLES.items():
            row = contact["runs"].get(f"{name}, {mu:g}")
            if row is None:
                continue
            numbers = [
                "-" if row[key] is None else f"{row[key]:.3f}"
                for key in ("force_rim", "force_base", "torque_rim", "torque_base")
            ]
            note = "" if row["degrees"] >= ENOUGH else f" (stops at {row['degrees']:.0f} degrees)"
            lines.append(
                f"| {title}{note} | {mu:g} | {row['steps']} | {row['iterations']} | {row['cpu']:.1f} "
                f"| {1e3 * each(row):.1f} | {row['ratio']:.2f} | {row['whole']:.2f} | {' | '.join(numbers)} |"
            )
    r, d = contact["mesh_3"], contact["mesh_3_default"]
    lines += [
        "",
        *beside(contact["runs"]),
        "- The neo-Hooke law of CalculiX has (J - 1)^2 where that of bezel has (ln J)^2, and its friction also acts during the descent.",
        f"- On mesh 3 ({r['equations']} equations, Q1E9+Q1N2, mu = 0.5) bezel takes {r['iterations']} iterations, {r['cpu']:.1f} s "
        f"of CPU time and {1e3 * each(r):.1f} ms per iteration, of which contact takes {100 * r['share']:.1f} %; with the default scheme {d['iterations']} iterations, {d['cpu']:.1f} s, "
        f"{1e3 * each(d):.1f} ms and {100 * d['share']:.1f} %.",
    ]
    return "\n".join(lines) + "\n"


def beside(rows):
    """A line with the torques of CalculiX divided by those of Q1E9+Q1N2."""
    mu = f", {FRICTION[-1]:g}"
    ours = rows[OURS + mu]
    lines = []
    for name in (THEIRS, SWAPPED):
        row = rows.get(name + mu)
        if row is None or row["torque_rim"] is None:
            continue
        parts = [f"{row[key] / ours[key]:.2f}" for key in ("torque_rim", "torque_base")]
        lines.append(
            f"- With friction the torques of '{TITLES[name]}' are {' and '.join(parts)} of those of Q1E9+Q1N2."
        )
    return lines


def targets(result):
    """(target, required, measured, met) for each target of contact."""
    found = []
    contact = result.get("contact")
    if contact:
        for mu in FRICTION:
            row = contact["runs"].get(f"{THEIRS}, {mu:g}")
            if row:
                text = f"CPU time per iteration in contact, mu = {mu:g}, CalculiX over Q1E9+Q1N2"
                found.append((text, "1", f"{row['ratio']:.2f}", row["ratio"] >= 1))
        mu = f", {FRICTION[-1]:g}"
        rows = contact["runs"]
        if THEIRS + mu in rows:
            longest = " (each with its best increments)" if LONG + mu in rows else ""
            theirs = min(
                rows[name + mu]["whole"] for name in (THEIRS, THEIRS_LONG) if name + mu in rows
            )
            ours = min(rows[name + mu]["whole"] for name in (DEFAULT, LONG) if name + mu in rows)
            text = f"CPU time per degree of rotation, mu = 0.5, CalculiX over the default scheme{longest}"
            found.append((text, "3", f"{theirs / ours:.2f}", theirs / ours >= 3))
        for which, key, most in (
            ("two half passes", "mesh_3", 15),
            ("default", "mesh_3_default", 20),
        ):
            share = 100 * contact[key]["share"]
            text = f"fraction of contact in an iteration, mesh 3, {which}"
            found.append((text, f"{most} %", f"{share:.1f} %", share < most))
    for key, value in result["kernels"].items():
        if key.startswith("projection, IGA degree 2") and "grid" not in key:
            found.append((key[:-5], "0.3 us", f"{value:.2f} us", value < 0.3))
    return found
