"""Hertz contact of a sphere below a net: `python -m verification.section3 hertz`.

Bodies below nets of input/sphere_net.py are pressed between two rigid planes
(verification/section3/hertz.inp) and compared with Hertz's formulas. The approach at one pole of a
whole sphere is smaller than Hertz's a^2/R by Boussinesq's displacement due to the load at the other
pole, at depth 2 R and radius a: (F/(pi E)) (2 (1+nu) R^2/q^3 + (1-nu^2)/q) with q^2 = a^2 + 4 R^2.
"""

import json
import subprocess
import sys

import numpy as np

from post._table import read_table
from post.mesh import _report, _write, body_of
from verification import TOP

NU = 0.3
POLE = 0.16  # size of the quads at the poles, relative to a uniform net
CASES = ((12, 0.1), (16, 0.1), (16, 0.05), (16, 0.2), (24, 0.1))  # quads along an edge, a/R
FINE_RADIUS = 0.15  # within this distance of a pole, tetrahedra are as small as the quads there
NEAR = "sphere:0,0,1,0.3+sphere:0,0,-1,0.3"  # the part that remains a spline


def hertz(bezel, out, work, largest):
    """Write hertz.csv for nets of up to `largest` quads along an edge of the cube."""
    rows = ["n,a,dofs,quads_over_a,force,pressure,radius,poles_differ,iterations,solve_cpu_seconds"]
    for n, a in CASES:
        if n > largest:
            continue
        folder = work / f"hertz_{n}"
        if not (folder / "ball.msh").exists():
            make(folder, n)
        rows.append(case(bezel, folder, n, a))
        print(rows[-1], flush=True)
    (out / "hertz.csv").write_text("\n".join(rows) + "\n")


def make(folder, n):
    """Write the files of the body and the deck."""
    folder.mkdir(parents=True, exist_ok=True)
    net = folder / "ball.obj"
    command = [sys.executable, "-m", "input.sphere_net", str(n), net.resolve(), str(POLE)]
    subprocess.run(command, cwd=TOP, check=True)
    fine = [f"{0.32 / n:.4g}=sphere:0,0,{z},{FINE_RADIUS}" for z in (1, -1)]
    groups = ["top=sphere:0,0,1,0.25", "bottom=sphere:0,0,-1,0.25"]
    body = body_of(str(net), groups=groups, enrich=NEAR, fine=fine)
    _write.write(body, folder / "ball")
    _report.write(_report.describe(body), folder / "ball.mesh.json")
    (folder / "hertz.inp").write_text((TOP / "verification/section3/hertz.inp").read_text())


def case(bezel, folder, n, a):
    """A row: the force relative to Hertz's force, and the pressure and radius relative to those of
    Hertz's solution for this force.
    """
    name = f"hertz_{a:g}".replace(".", "_")
    command = [bezel, "--quiet", "-o", folder, "--name", name, "--set", f"a={a}"]
    subprocess.run([*command, folder / "hertz.inp"], check=True)
    c = {key: v[-1] for key, v in read_table(folder / f"{name}_hertz.dat").columns.items()}
    sides = [[abs(c[f"contact_{s}_1_{k}"]) for s in ("north", "south")]
             for k in ("force_3", "pressure", "area")]  # fmt: skip
    force, pressure, area = (np.mean(v) for v in sides)
    wanted = radius_of(force)
    modulus = 1 / (1 - NU**2)
    peak = (6 * force * modulus**2 / np.pi**3) ** (1 / 3)
    log = (folder / f"{name}.log").read_text().split()
    report = json.loads((folder / f"{name}.report.json").read_text())
    seconds = log[log.index("total") + 2]
    quads = a / (np.pi / 2 / n * POLE)
    numbers = [force / force_of(abs(c["disp_3"])), pressure / peak, np.sqrt(area / np.pi) / wanted]
    differ = abs(sides[0][0] / sides[0][1] - 1)
    return (
        f"{n},{a},{report['dofs']},{quads:.1f},"
        + ",".join(f"{v:.4f}" for v in numbers)
        + f",{differ:.1g},{report['iterations']},{float(seconds):.0f}"
    )


def radius_of(force):
    """Hertz's contact radius for a force, with R = E = 1.

    >>> round(float(radius_of(0.00146520146)), 6)
    0.1
    """
    return (0.75 * force * (1 - NU**2)) ** (1 / 3)


def approach_of(force):
    """Approach of a plane to the sphere's centre: that of Hertz minus the effect of the other
    pole.
    """
    a = radius_of(force)
    q = a * a + 4
    return a * a - (2 * (1 + NU) / q**1.5 + (1 - NU**2) / q**0.5) * force / np.pi


def force_of(approach):
    """The force that causes an approach: the inverse of approach_of.

    >>> abs(approach_of(force_of(0.01)) - 0.01) < 1e-12
    True
    """
    force = approach**1.5
    for _ in range(100):
        force *= (approach / approach_of(force)) ** 1.5
    return force
