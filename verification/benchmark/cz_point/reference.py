"""Write reference/<law>_<phi>.csv: the forces of cz_point from the published formulas, at each
step.

    python -m verification.benchmark.cz_point.reference

The path of the opening is that of batch.inc. The laws are those of Corbett and Sauer 2015, eq.
(31); of van den Bosch et al. 2006, with the largest openings in the factors for the damage; and of
Park, Paulino and Roesler 2009, whose tractions are the derivatives of a potential, computed here by
complex steps so that the reference does not rely on derivatives by hand.
"""

import csv
import math
import pathlib

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
T0, G0 = 0.5, 0.02
WAY = [(0, 0), (1, 1.5), (2, 0), (3, 3.0), (3.5, 1.5), (5, 12.0)]
PHI = [0, 45, 90]


def exponential(gn, gt, worst):
    """Eq. (31) at the current opening."""
    r = math.hypot(gn, gt)
    return T0 / G0 * math.exp(1 - r / G0) * np.array([gn, gt])


def irreversible(gn, gt, worst):
    """Eq. (31) at the largest opening, with linear unloading to the origin."""
    worst[0] = max(worst[0], math.hypot(gn, gt))
    return T0 / G0 * math.exp(1 - worst[0] / G0) * np.array([gn, gt])


def mixed(gn, gt, worst):
    """Van den Bosch et al., with phi_n, phi_t, delta_n, delta_t; the largest openings cause the
    damage.
    """
    dn, dt = G0, math.sqrt(2) * 0.8 * G0
    phi_n, phi_t = math.e * T0 * G0, math.sqrt(math.e) * 1.5 * T0 * 0.8 * G0
    worst[:] = np.maximum(worst, [gn, gt])
    x, y = worst[0] / dn, worst[1] / dt
    return np.array(
        [
            phi_n / dn * (gn / dn) * math.exp(-x) * math.exp(-y * y),
            2 * phi_t / dt * (gt / dt) * (1 + x) * math.exp(-x) * math.exp(-y * y),
        ]
    )


def ppr(gn, gt, worst):
    """Derivatives of the potential at the largest openings, with linear unloading to the origin."""
    worst[:] = np.maximum(worst, [gn, gt])
    tiny = 1e-30
    traction = np.zeros(2)
    for i in range(2):
        at = np.array(worst, dtype=complex)
        if at[i] == 0:
            continue
        at[i] += 1j * tiny
        traction[i] = potential(*at, normal=i == 0).imag / tiny * [gn, gt][i] / worst[i]
    return traction


def potential(gn, gt, normal):
    """Park, Paulino and Roesler 2009; constant beyond the final opening of a mode. For the normal
    traction, the potential also ends where this traction changes sign.
    """
    phi = 2 * T0 * G0, 3 * T0 * G0
    strength = T0, 0.8 * T0
    shape = 3.0, 2.5
    lam = 0.1, 0.15
    factor = []
    for i, g in enumerate((gn, gt)):
        a, ratio = shape[i], lam[i]
        m = a * (a - 1) * ratio**2 / (1 - a * ratio**2)
        last = phi[i] / strength[i] * a * ratio * (1 - ratio) ** (a - 1)
        last *= (a / m + 1) * (ratio * a / m + 1) ** (m - 1)
        rest = max(phi[i] - phi[1 - i], 0)
        # phi_t is the larger energy, so Gamma_n = (alpha/m)^m and Gamma_t = -phi_t (beta/n)^n
        gamma = (a / m) ** m * (1 if i == 0 else -phi[1])
        x = g / last
        inside = gamma * (1 - x) ** a * (m / a + x) ** m if x.real < 1 else 0
        factor.append(inside + rest)
    if (
        normal and factor[1].real > 0
    ):  # beyond the shear opening at which the normal traction vanishes
        factor[1] = 0
    return min(phi) + factor[0] * factor[1]


def main():
    """Write a file for each law and direction."""
    time = np.arange(1, 101) * 0.05
    way = np.interp(time, *zip(*WAY, strict=True)) * G0
    for law in (exponential, irreversible, mixed, ppr):
        for phi in PHI:
            worst = np.zeros(2)
            c, s = math.cos(math.radians(phi)), math.sin(math.radians(phi))
            force = np.array([law(c * d, s * d, worst) for d in way])
            with open(HERE / f"reference/{law.__name__}_{phi}.csv", "w", newline="") as file:
                writer = csv.writer(file, lineterminator="\n")
                writer.writerow(["time", "force_1", "force_3"])
                for t, (normal, shear) in zip(time, force, strict=True):
                    writer.writerow([f"{x:.10g}" for x in (t, shear, normal)])


if __name__ == "__main__":
    main()
