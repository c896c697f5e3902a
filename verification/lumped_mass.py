"""The table of doc/manual/MASS.md: errors of lumped masses in a bar, by theory in one dimension.

    .venv/bin/python -m verification.lumped_mass

The longest period of a bar that is fixed at one end is compared with 4 L/c, and the moment of inertia
of the free bar about its middle with m L^2/12. Length, mass and stiffness are 1. The program's own
runs are in the case `transient`.
"""

import numpy as np
from scipy.linalg import eigh

from verification.reference.spline import Space, gauss

ELEMENTS = (1, 2, 4, 8, 16)
TYPES = {"IGA 2": (2, 1), "IGA 3": (3, 1), "Q1": (1, 1), "Q2": (2, 2)}  # degree, repeated knots


def matrices(p, n, repeat):
    """Stiffness, consistent mass (size, size) and positions of the nodes (size,) of a bar."""
    space = Space(p, n, repeat)
    x, w = gauss(space, p + 1)
    numbers, values = space.basis(x.ravel())
    k, m = np.zeros((2, space.size, space.size))
    for at, f, weight in zip(numbers, values, w.ravel(), strict=True):
        m[np.ix_(at, at)] += weight * np.outer(f[0], f[0])
        k[np.ix_(at, at)] += weight * np.outer(f[1], f[1])
    nodes = space.greville
    if repeat == p:  # Lagrange functions of equally spaced nodes
        nodes = np.linspace(0, 1, space.size)
        to = np.linalg.inv(space.matrix(nodes))
        k, m = to.T @ k @ to, to.T @ m @ to
    return k, m, nodes


def percent(error):
    """Two digits of an error in percent, and three from 10 % on; nothing below 1e-4 % or so."""
    if abs(error) < 0.8e-4:
        return ""
    return f"{error:.{3 if abs(error) > 10 else 2 if abs(error) > 1e-3 else 1}g} %"


def main():
    print("| elements along the bar |", " | ".join(map(str, ELEMENTS)), "|")
    print("|" + "---|" * (len(ELEMENTS) + 1))
    periods, inertias = [], []
    for name, (p, repeat) in TYPES.items():
        rows = {"LUMPed": [], "CONSistent": []}
        inertia = []
        for n in ELEMENTS:
            k, m, x = matrices(p, n, repeat)
            lumped = np.diag(m.sum(axis=1))
            for row, mass in ((rows["LUMPed"], lumped), (rows["CONSistent"], m)):
                least = eigh(k[1:, 1:], mass[1:, 1:], eigvals_only=True)[0]
                error = np.pi / 2 / np.sqrt(least) - 1
                row.append(percent(100 * error))
            inertia.append(f"{12 * (x - 0.5) @ lumped @ (x - 0.5):.3g}")
        periods += [
            f"| `{name}`, period, `{word}` | {' | '.join(row)} |" for word, row in rows.items()
        ]
        inertias.append(f"| `{name}`, moment of inertia, `LUMPed` | {' | '.join(inertia)} |")
    print("\n".join(periods + inertias))


if __name__ == "__main__":
    main()
