"""Bending of bodies from a file of hexahedra: `python -m verification.section3 bend`.

The same surface and layer are combined with tetrahedra and with the hexahedra of the file, and the
forces at the tip are compared. This is done for a rocker arm, whose mesh comes from another
program, and for a curved bar, which `check` also runs.
"""

import subprocess
import time
from resource import RUSAGE_CHILDREN, getrusage

import numpy as np

from post._table import read_table
from post.mesh import _report, _write, body_of
from post.tests.net_samples import grid, vtk

BENDING = """
FIX,{name},foot    1 1 1
MOVE,{name},tip    TRANslate 0 0.05 0  PROP 1

CURVe,force
  FORCe {name} tip 2
"""
INTERIORS = ("tets", "hexes")
ARM = ["foot=box:-9,-9,-9,9,9,-0.45", "tip=box:-9,-9,0.45,9,9,9"]
BAR = ["foot=box:-9,-9,-9,9,0.15,9", "tip=box:-9,-9,-9,0.15,9,9"]
BAR_ELEMENTS = (8, 30, 8)  # through the thickness, along the arc, across the width


def bend(bezel, out, work, net=None):
    """Write new rows of bend.csv, for the arm in the file `net` or for the bar; retain the other
    rows.
    """
    table = out / "bend.csv"
    rows = table.read_text().splitlines()
    if net is None:
        new = list(curved_bar_rows(bezel, work))
    else:
        new = [row("arm", net, ARM, interior, bezel, work) for interior in INTERIORS]
    kept = [r for r in rows[1:] if r.split(",")[0] != new[0].split(",")[0]]
    table.write_text("\n".join([rows[0], *sorted([*kept, *new])]) + "\n")
    print("\n".join(new))


def curved_bar_rows(bezel, work):
    """One row for each type of interior."""
    net = curved_bar(work / "bar.vtk")
    for interior in INTERIORS:
        yield row("bar", net, BAR, interior, bezel, work)


def row(name, net, groups, interior, bezel, work):
    """The row body,interior,dofs,force,mesh_cpu_seconds,solve_cpu_seconds,iterations."""
    start = cpu_seconds()
    body = body_of(net, interior=interior, groups=groups)
    place = work / f"bend_{name}_{interior}"
    _write.write(body, place)
    middle = cpu_seconds()
    c = solved(bezel, place)
    end = cpu_seconds()
    dofs = _report.describe(body)["counts"]["dofs"]
    force = next(v for key, v in c.items() if key.startswith("force"))[-1]
    seconds = f"{middle - start:.0f},{end - middle:.0f}"
    return f"{name},{interior},{dofs},{force:.6g},{seconds},{c['iterations'][-1]:.0f}"


def solved(bezel, place):
    """The columns of the curve for a body whose foot is fixed and whose tip is moved."""
    deck = place.with_suffix(".inp")
    lines = [line for line in deck.read_text().splitlines() if not line.startswith("! FIX")]
    supports = BENDING.format(name=place.name)
    text = "\n".join(lines).replace("\nEND\n\nBATCh", supports + "\nEND\n\nBATCh\n  PROP,,1", 1)
    deck.write_text(text.replace("END\n\nSTOP", "END\n2 1\n0 0\n1 1\n\nSTOP") + "\n")
    subprocess.run([bezel, "--quiet", "-o", place.parent, deck], check=True)
    return read_table(place.parent / f"{place.name}_force.dat").columns


def curved_bar(path):
    """Write a VTK file with hexahedra in a quarter of a ring of mean radius 3 and section 1 x 1."""
    x, cells = grid(BAR_ELEMENTS)
    radius, angle, z = (x / BAR_ELEMENTS + [-0.5, 0, -0.5]).T * [[1], [np.pi / 2], [1]]
    radius = radius + 3
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle), z], -1)
    path.write_text(vtk(points, cells))
    return str(path)


def cpu_seconds():
    """CPU seconds of this process and of the programs that it has started."""
    children = getrusage(RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime
