"""The checks of section 3 in `make verify-all`: `python -m verification.section3 check`.

For a broken file, `post mesh` must print one sentence and write nothing. Bodies below the net of
the arm must agree with the committed table, and the contact of the coarse sphere with the committed
ratios to Hertz's solution. The forces on the same body with tetrahedra and with hexahedra must
agree with each other. Checks that need Gmsh or TetGen are reported as skipped if these are not
installed.
"""

import csv
import json
import subprocess
import sys

from post.mesh import _report, _tets, body_of
from verification import TOP
from verification.section3.bend import curved_bar_rows
from verification.section3.hertz import case, make

EXACT = 1e-12  # relative difference of the sum of volumes from the surface integral
TOLERANCE = 0.01  # of ratios to Hertz's solution; other versions of Gmsh make other tetrahedra
SKIPPED = object()  # marks a skipped check
APART = 0.015  # of the bar's forces; linear tetrahedra are 1.0 % stiffer than hexahedra


def broken():
    """{what is wrong: (file, its text, words of the message)}, made from the net of a patch
    test.
    """
    folder = TOP / "verification/patch/unstructured"
    good = (folder / "net.off").read_text()
    lines = good.splitlines()
    head = lines.index("26 24 0")
    quads = [line.split() for line in lines[head + 27 :]]

    def net(rows, count=None):
        size = f"26 {count or len(rows)} 0"
        return "\n".join(
            [*lines[:head], size, *lines[head + 1 : head + 27], *map(" ".join, rows), ""]
        )

    def turned(q):
        return [q[0], *q[:0:-1]]

    def other(k, place, value):
        return [[*q[:place], value, *q[place + 1 :]] if i == k else q for i, q in enumerate(quads)]

    spline = (folder / "hanging.bext.json").read_text()
    return {
        "an open surface said to be closed": ("a.off", net(quads[:-1]), "is not closed"),
        "a surface turned inside out": (
            "a.off",
            net([turned(q) for q in quads]),
            "point inward",
        ),
        "one quad turned": ("a.off", net([turned(quads[0]), *quads[1:]]), "opposite orientation"),
        "a quad with a point twice": (
            "a.off",
            net(other(3, 2, quads[3][1])),
            "quad 4 is degenerate",
        ),
        "a quad without area": ("a.off", good.replace("-1 -1 0", "-1 -1 -1"), "degenerate"),
        "a point that is missing": ("a.off", net(other(5, 1, "99")), "outside the 26 points"),
        "more quads announced than there are": (
            "a.off",
            net(quads, 25),
            "found the end of the file",
        ),
        "fewer quads announced than there are": (
            "a.off",
            net(quads, 23),
            "continues after the 23 faces",
        ),
        "a net that is cut off": ("a.off", good[: len(good) // 2], "found the end of the file"),
        "a coordinate that is no number": (
            "a.off",
            good.replace("-1 -1 0", "-1 nan 0"),
            "is not finite",
        ),
        "a spline that is cut off": ("a.bext.json", spline[: len(spline) // 2], "truncated"),
        "a spline without its last element": ("a.bext.json", without_element(spline), "announces"),
    }


def without_element(text):
    data = json.loads(text)
    data["elements"]["element_blocks"].pop()
    return json.dumps(data)


def check_broken(work):
    """Yield (what, trouble or None) for each broken file."""
    folder = work / "broken"
    folder.mkdir(parents=True, exist_ok=True)
    for what, (name, text, words) in broken().items():
        (folder / name).write_text(text)
        command = [sys.executable, "-m", "post", "mesh", folder / name, "-o", folder / "out/body"]
        done = subprocess.run(command, cwd=TOP, capture_output=True, text=True)
        said = done.stderr.strip().splitlines()
        trouble = None
        if done.returncode != 2:
            trouble = f"exit code {done.returncode}"
        elif len(said) != 1 or words not in said[0]:
            trouble = f"{len(said)} lines: {' / '.join(said)[:200]}"
        elif (folder / "out").exists():
            trouble = "files were written"
        yield f"{what}: {said[0] if said else 'nothing said'}", trouble


def check_bodies(net, variants, table):
    """Compare bodies of the arm with the committed table: their shapes, sums, and those counts that
    do not depend on the mesher.
    """
    rows = {row["variant"]: row for row in csv.DictReader(table.open())}
    for name, options in variants.items():
        if name not in rows:
            continue
        if not _tets.available(options["mesher"]):
            yield f"body of the arm, {name}: {options['mesher']} is not installed", SKIPPED
            continue
        report = _report.describe(body_of(net, **options))
        wrong = _report.bad(report)
        for key in ("counts.elements", "counts.pyramids", "counts.hanging"):
            part, entry = key.split(".")
            if report[part][entry] != int(rows[name][key]):
                wrong.append(f"expected {rows[name][key]} for {key}, found {report[part][entry]}")
        if report["volume"]["relative_difference"] > EXACT:
            wrong.append("the volumes do not add up to round-off")
        least = report["tets"]["dihedral_least"]
        if options["mesher"] == "gmsh" and least < 4:
            wrong.append(f"least dihedral angle {least:.2f}")
        worst = min(report[kind]["scaled"] for kind in ("tets", "pyramids"))
        if options["mesher"] == "gmsh" and worst < 0.1:
            wrong.append(f"worst scaled Jacobian {worst:.3f}")
        yield f"body of the arm, {name}: least angle {least:.2f}", "; ".join(wrong) or None


def check_hertz(bezel, work, table):
    """Compare the contact of the coarsest sphere with the committed ratios."""
    if not _tets.available("gmsh"):
        yield "sphere against Hertz: gmsh is not installed", SKIPPED
        return
    want = next(csv.DictReader(table.open()))
    folder = work / "hertz_12"
    make(folder, 12)
    got = dict(zip(want, case(bezel, folder, 12, 0.1).split(",")))
    for name in ("force", "pressure", "radius"):
        away = abs(float(got[name]) / float(want[name]) - 1)
        trouble = f"{want[name]} before" if away > TOLERANCE else None
        yield f"sphere against Hertz, {name}: {got[name]}", trouble


def check_interiors(bezel, work, table):
    """Compare the bent bar with tetrahedra and with hexahedra, with each other and with the
    table.
    """
    if not _tets.available("gmsh"):
        yield "bar on tetrahedra and hexahedra: gmsh is not installed", SKIPPED
        return
    want = {
        tuple(r[k] for k in ("body", "interior")): float(r["force"])
        for r in csv.DictReader(table.open())
    }
    forces = {}
    for row in curved_bar_rows(bezel, work):
        body, interior, _, force = row.split(",")[:4]
        forces[interior] = float(force)
        before = want[body, interior]
        away = abs(forces[interior] / before - 1)
        trouble = f"{before} before" if away > TOLERANCE / 10 else None
        yield f"force of the {body} on {interior}: {force}", trouble
    apart = forces["tets"] / forces["hexes"] - 1
    yield f"the bar's forces differ by {apart:.2%}", "too much" if abs(apart) > APART else None


def check(bezel, work, net, variants):
    """Print a line for each check; return the exit code."""
    tables = TOP / "verification/section3"
    marks = []
    for part in (
        check_broken(work),
        check_bodies(net, variants, tables / "mesh_arm.csv"),
        check_hertz(bezel, work, tables / "hertz.csv"),
        check_interiors(bezel, work, tables / "bend.csv"),
    ):
        for what, trouble in part:
            mark = "skip" if trouble is SKIPPED else "FAILED" if trouble else "ok"
            print(f"{mark:<6} {what}{': ' + trouble if mark == 'FAILED' else ''}", flush=True)
            marks.append(mark)
    passed, failed, skipped = (marks.count(m) for m in ("ok", "FAILED", "skip"))
    print(f"section 3: {passed} passed, {failed} failed, {skipped} skipped")
    return 1 if failed else 0
