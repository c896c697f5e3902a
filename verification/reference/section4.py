"""Section 4: a quarter of a cube is compressed by a quarter and stretched to twice its height."""

import numpy as np

from verification.reference.layer import layered_patch
from verification.reference.mesh import q1_modes, tensor_patch
from verification.reference.spline import Space
from verification.reference.system import System, advance

LIFTS = {"compression": -0.25, "extension": 1.0}
#: element types in the order of the paper's figures
ELEMENTS = (
    "Q1", "Q2", "IGA2", "Q1E9", "Q1N2 on 1+", "Q1N2 on 1+ and 2+",
    "Q1E9+Q1N2 on 1+", "Q1E9+Q1N2 on 1+ and 2+", "Q2N2 on 1+",
    "Q1E9+Q1E9N2 on 1+", "Q1E9+Q1E9N2 on 1+ and 2+",
)  # fmt: skip


def body(name, counts, prism_points=3):
    """A patch of n1 x n2 x n3 elements; name: Q1, Q1E9, Q2, IGA2, or of the form "Q1+Q1N2 on 1+ and
    2+".
    """
    kind, _, faces = name.partition(" on ")
    if faces:
        enriched = [
            ({"1": 0, "2": 1, "3": 2}[f[0]], int(f[1] == "+")) for f in faces.split(" and ")
        ]
        base, _, layer = kind.rpartition("+")
        points = prism_points if "E9" in layer else None  # j0/j is a rational function in prisms
        return layered_patch(counts, enriched, base or layer[:2], layer, points)
    p, repeat = {"Q1": (1, 1), "Q1E9": (1, 1), "Q2": (2, 2), "IGA2": (2, 1)}[kind]
    spaces = [Space(p, n, repeat) for n in counts]
    patch = tensor_patch(spaces, (p + 1,) * 3)
    if kind == "Q1E9":
        patch.blocks[0].modes = q1_modes(spaces)
    return patch


def solve(name, n, lift, steps=5, prism_points=3):
    """The force on the top of the quarter model and the number of degrees of freedom."""
    patch = body(name, (n, n, 2 * n), prism_points)
    x = patch.parameters * (0.5, 0.5, 1.0)
    system = System([patch], [x], [(1.0, 0.2)])
    on = lambda d, at: np.flatnonzero(abs(x[:, d] - at) < 1e-12)
    system.prescribe(on(0, 0.0), [0], 0.0)
    system.prescribe(on(1, 0.0), [1], 0.0)
    system.prescribe(on(2, 0.0), [0, 1, 2], 0.0)
    system.prescribe(on(2, 1.0), [0, 1, 2], 0.0)
    for _ in advance(system, lambda t: system.prescribe(on(2, 1.0), [2], t * lift), steps):
        pass
    return system.reactions[on(2, 1.0), 2].sum(), system.dofs
