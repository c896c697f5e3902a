"""The quarter cube of section 4 with FElupe: felupe_cube.py N U STEPS. Prints JSON: iterations, seconds, force."""

import json
import sys
import time

import felupe as fem
import numpy as np

try:
    from pypardiso import spsolve

    solver = "pardiso"
except ImportError:
    from scipy.sparse.linalg import spsolve

    solver = "superlu"

n, lift, steps = int(sys.argv[1]), float(sys.argv[2]), int(sys.argv[3])
mu = 1.0 / (2.0 * 1.2)
start = time.process_time()
mesh = fem.Cube(b=(0.5, 0.5, 1.0), n=(n + 1, n + 1, 2 * n + 1))
field = fem.FieldContainer([fem.Field(fem.RegionHexahedron(mesh), dim=3)])
solid = fem.SolidBody(fem.NeoHookeCompressible(mu=mu, lmbda=2 * mu * 0.2 / 0.6), field)
bounds = {
    "x": fem.Boundary(field[0], fx=0.0, skip=(0, 1, 1)),
    "y": fem.Boundary(field[0], fy=0.0, skip=(1, 0, 1)),
    "base": fem.Boundary(field[0], fz=0.0),
    "top": fem.Boundary(field[0], fz=1.0, skip=(0, 0, 1)),
    "lift": fem.Boundary(field[0], fz=1.0, skip=(1, 1, 0)),
}
iterations = 0
for step in range(1, steps + 1):
    bounds["lift"].value = lift * step / steps
    dof0, dof1 = fem.dof.partition(field, bounds)
    ext0 = fem.dof.apply(field, bounds, dof0)
    result = fem.newtonraphson(
        items=[solid], dof0=dof0, dof1=dof1, ext0=ext0, solver=spsolve, verbose=0
    )
    iterations += result.iterations
force = solid.assemble.vector(field).toarray().reshape(-1, 3)[mesh.points[:, 2] == 1.0, 2].sum()
print(
    json.dumps(
        {
            "solver": solver,
            "iterations": iterations,
            "seconds": time.process_time() - start,
            "force": float(np.real(force)),
        }
    )
)
