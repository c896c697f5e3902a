"""Section 5.1: the first lift of a strip that is bonded to a plate, on mesh 1 of Table 1."""

import numpy as np

from verification.reference.contact import Bond, Contact
from verification.reference.section4 import body
from verification.reference.system import System, advance

ELEMENTS = ("IGA2", "Q1E9+Q1N2")
T0, G0, PENALTY = 0.1, 0.08, 10.0
AXIS = np.array([np.cos(np.radians(43)), np.sin(np.radians(43)), 0.0])
FRONT = 0.21 * 19.5 - 9.75  # initially 21 % of the interface is debonded


def build(name):
    """The system, the nodes of the lifted edge, and those of the clamped side."""
    face = "" if name == "IGA2" else " on 3"
    strip = body(name + (face and face + "-"), (10, 2, 2))
    plate = body(name + (face and face + "+"), (10, 10, 2))
    x = strip.parameters * (19.5, 4, 1) - (9.75, 2, 0)
    x = x @ np.array([[AXIS[0], AXIS[1], 0], [-AXIS[1], AXIS[0], 0], [0, 0, 1]])
    y = plate.parameters * (20, 20, 1) - (10, 10, 1)
    edge = np.flatnonzero((strip.parameters[:, 0] == 0) & (strip.parameters[:, 2] == 1))
    clamp = len(x) + np.flatnonzero(plate.parameters[:, 0] == 0)
    system = System([strip, plate], [x, y], [(3.0, 0.3), (1.0, 0.3)])
    system.contact = Contact(
        (strip.faces[2, 0], plate.faces[2, 1]), (-1, 1), 10, PENALTY, depth=0.5
    )
    for side in system.contact.sides:
        side.bond = Bond(side, system.X, T0, G0, lambda p: p @ AXIS > FRONT)
    system.prescribe(clamp, range(3), 0.0)
    return system, edge, clamp


def run(name, lift=1.0, steps=4):
    """Yield (lift, force on the lifted edge, force on the clamped side) after each step."""
    system, edge, clamp = build(name)
    for t in advance(system, lambda t: system.prescribe(edge, [2], t * lift), steps):
        yield t * lift, system.reactions[edge, 2].sum(), system.reactions[clamp, 2].sum()
