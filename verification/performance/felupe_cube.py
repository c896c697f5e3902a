"""Solve the cube of cube.inp with FElupe and print JSON: `felupe_cube.py n SOLVER`.

SOLVER is pardiso, which the documentation of FElupe recommends; symmetric, which is Pardiso for a
symmetric matrix given by its upper triangle; or superlu, the default of FElupe (from scipy). The
seconds are those of the Newton iterations, without imports and without the construction of the
mesh.
"""

import json
import sys
import time

import felupe as fem
import numpy as np
import scipy.sparse

STEPS = 5
LIFT = -0.25
E, NU = 1.0, 0.2
TOLERANCE = 1e-9  # norm of the residual relative to that of the reactions


def linear_solver(name):
    """A function (A, b) -> x to pass to FElupe."""
    if name == "superlu":
        return scipy.sparse.linalg.spsolve
    import pypardiso

    if name == "pardiso":
        return pypardiso.spsolve
    pardiso = pypardiso.PyPardisoSolver(mtype=-2)
    return lambda a, b: pardiso.solve(scipy.sparse.triu(a, format="csr"), b)


def main(n, name):
    """Solve the cube and print the results."""
    mesh = fem.Cube(a=(0, 0, 0), b=(0.5, 0.5, 1), n=(n + 1, n + 1, 2 * n + 1))
    field = fem.FieldContainer([fem.Field(fem.RegionHexahedron(mesh), dim=3)])
    law = fem.NeoHookeCompressible(mu=E / 2 / (1 + NU), lmbda=E * NU / (1 + NU) / (1 - 2 * NU))
    solid = fem.SolidBody(law, field)
    u = field[0]
    top = fem.Boundary(u, fz=1, skip=(1, 1, 0))
    bounds = {
        "x": fem.Boundary(u, fx=0, skip=(0, 1, 1)),
        "y": fem.Boundary(u, fy=0, skip=(1, 0, 1)),
        "base": fem.Boundary(u, fz=0),
        "sides of the top": fem.Boundary(u, fz=1, skip=(0, 0, 1)),
        "top": top,
    }
    dof0, dof1 = fem.dof.partition(field, bounds)
    solver = linear_solver(name)
    iterations = 0
    wall, cpu = time.perf_counter(), time.process_time()
    for step in range(1, STEPS + 1):
        top.value = LIFT * step / STEPS
        result = fem.newtonraphson(
            items=[solid],
            dof0=dof0,
            dof1=dof1,
            ext0=fem.dof.apply(field, bounds, dof0),
            solver=solver,
            tol=TOLERANCE,
            verbose=0,
        )
        iterations += result.iterations
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    force = result.fun.reshape(-1, 3)[np.isclose(mesh.points[:, 2], 1.0), 2].sum()
    report = {"wall": wall, "cpu": cpu, "iterations": iterations, "force": force}
    report["version"] = f"FElupe {fem.__version__}"
    print(json.dumps(report))


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2])
