"""The cases of verification.contact: each of them runs its decks and returns (heading, rows,
curves).

A row of a table has a value, its reference and the difference; `curves` are the rows for a figure,
or None.
"""

import pathlib
import tempfile

import numpy as np

from post.figures.contact import PUBLISHED
from verification.contact.decks import MESHES, MINDLIN, TYPES, spring_and_slider
from verification.contact.runs import order
from verification.patch.contact_mortar import make

MODULUS = 1 / (0.91 + 0.91 / 2)  # E* of the moduli 1 and 2, nu = 0.3


def percent(value, digits=1):
    return f"{100 * value:+.{digits}f} %"


def times(ratio):
    return f"{ratio:.0f} times" if ratio > 10 else f"{ratio:.1f} times"


def iterations(curve):
    return int(np.sum(curve["iterations"]))


def failed(run):
    """What the table says about a run without a result; '' if there is a result."""
    if run.code == 0:
        return ""
    return f"ends with code {run.code}" if run.code is not None else run.message


def patch(runner):
    """The largest errors of the families of verification/patch/contact_mortar."""
    worst = {}
    for case in make.cases():
        family = case.name.split("-")[0].rstrip("0123456789.")
        with tempfile.TemporaryDirectory() as place:
            errors, _ = case.run(str(runner.bezel), pathlib.Path(place))
        worst.setdefault(family, []).append(errors if errors else (np.inf,) * 3)
    rows = []
    for family, errors in worst.items():
        largest = np.max(errors, axis=0)
        passed = sum(max(e[:2]) < 1e-8 for e in errors)
        rows.append([family, len(errors), passed, *(f"{e:.0e}" for e in largest)])
    heading = [
        "family",
        "cases",
        "force and stress right to 1e-8",
        "force, largest error",
        "stress",
        "smoothed pressure",
    ]
    return heading, rows, None


def hertz(runner, shape):
    """The sphere or the cylinder with every element type and mesh."""
    rows, curves = [], []
    for kind, meshes in MESHES[shape].items():
        errors = []
        for mesh in meshes:
            run = runner(f"{shape}/{kind}_{mesh}")
            if failed(run):
                rows.append([TYPES[kind][0], mesh, failed(run), *["-"] * 6])
                continue
            curve = run.curve("hertz")
            last = {name: values[-1] for name, values in curve.items()}
            force, area = abs(last["contact_hertz_1_force_3"]), last["contact_hertz_1_area"]
            if shape == "sphere":
                wanted = 4 / 3 * MODULUS * 1e-9 / 4
                a = (3 * 4 * force / (4 * MODULUS)) ** (1 / 3)
                p0, radius = 1.5 * 4 * force / (np.pi * a**2), np.sqrt(4 * area / np.pi)
            else:
                load = 2 * force / 2.5e-4
                a = np.sqrt(4 * load / (np.pi * MODULUS))
                p0, radius, wanted = np.sqrt(load * MODULUS / np.pi), area / 2.5e-4, None
            x, value, weight = run.surface(0)
            r = np.hypot(x[:, 0], x[:, 1]) if shape == "sphere" else np.abs(x[:, 0])
            exact = p0 * np.sqrt(np.maximum(0.0, 1 - (r / a) ** 2))
            norm = lambda f, w=weight: np.sqrt(np.sum(w * f**2))
            error = {
                "force": force / wanted - 1 if wanted else None,
                "radius": radius / a - 1,
                "peak": last["contact_hertz_1_pressure"] / p0 - 1,
                "l2": norm(value - exact) / norm(exact),
            }
            errors.append(error)
            curves.append({"elements": TYPES[kind][0], "mesh": mesh, **error})
            cells = [percent(error["force"])] if wanted else []
            cells += [
                percent(error["radius"]),
                percent(error["peak"]),
                f"{100 * error['l2']:.1f} %",
            ]
            rows.append([TYPES[kind][0], mesh, *cells, iterations(curve), f"{run.seconds:.0f}"])
        if len(errors) == len(meshes):

            def orders(name, e=errors, m=meshes):
                return ", ".join(f"{o:.1f}" for o in order([i[name] for i in e], m))

            names = (
                ["force", "radius", "peak", "l2"] if shape == "sphere" else ["radius", "peak", "l2"]
            )
            rows.append(["", "order", *(orders(name) for name in names), "", ""])
    heading = [
        "elements",
        "n",
        "force",
        "radius",
        "peak pressure",
        "pressure, L2",
        "iterations",
        "CPU s",
    ]
    if shape == "cylinder":
        heading.remove("force")
        heading[2] = "half width"
    return heading, rows, curves


def sphere(runner):
    return hertz(runner, "sphere")


def cylinder(runner):
    return hertz(runner, "cylinder")


def ironing(runner):
    """Shallow ironing against published forces, and the oscillation of the forces."""
    rows, curves = [], []
    for name, (v1, h1, v2, h2) in PUBLISHED.items():
        rows.append([name, *(f"{v:.0f}" for v in (v1, h1, v2, h2)), f"{h2 / v2:.2f}", "-", "-"])
    for n in (32, 48):
        run = runner("ironing/shallow", n=n)
        if failed(run):
            rows.append([f"bezel, n = {n}", failed(run), *["-"] * 6])
            continue
        c = run.curve("iron")
        time, across, down = c["time"], c["force_1"] / 0.25, -c["force_3"] / 0.25
        for t, h, v in zip(time, across, down, strict=True):
            curves.append({"n": n, "time": t, "horizontal": h, "vertical": v})
        at = lambda y, t, x=time: float(np.interp(t, x, y))
        v1, h1 = at(down, 1.0), at(across, 1.0)
        inner = (time > 1.3) & (time < 1.6)
        v2, h2 = down[inner].mean(), across[inner].mean()
        balance = np.max(np.abs(c["contact_iron_1_force_3"] + c["contact_iron_2_force_3"]))
        rows.append([
            f"bezel, Q1E9+Q1N2, n = {n}", f"{v1:.0f}", f"{h1:.0f}", f"{v2:.0f}", f"{h2:.0f}",
            f"{h2 / v2:.2f}", f"{100 * np.ptp(down[inner]) / v2:.1f}; {100 * np.ptp(across[inner]) / h2:.1f} %",
            f"{balance / np.max(np.abs(c['force_3'])):.0e}",
        ])  # fmt: skip
    heading = [
        "source",
        "V at 1.0",
        "H at 1.0",
        "V at 1.5",
        "H at 1.5",
        "H/V",
        "range V; H",
        "imbalance",
    ]
    return heading, rows, curves


def rings(runner):
    """Two rings, pressed together or shrunk onto each other, against Lame's solution."""
    n, plane = 0.3 / 0.7, 1 / 0.91
    exact = {
        "pressed": 8 / 3 * 1e-5 / (5 - n),
        "fit": 1e-5 / ((5 / 3 + n) / (2 * plane) + (5 / 3 - n) / plane),
    }
    rows = []
    for load, want in exact.items():
        for kind, meshes in (
            ("q1", (2, 4)),
            ("q1n2", (2, 4, 8)),
            ("q2", (2, 4)),
            ("iga2", (1, 2, 4)),
        ):
            errors = []
            for m in meshes:
                run = runner(f"rings/{load}_{kind}", m=m)
                if failed(run):
                    rows.append([load, TYPES[kind][0], m, failed(run), *["-"] * 4])
                    continue
                c = run.curve("fit")
                mean = abs(c["contact_fit_1_force_1"][-1]) / 0.5
                peak = c["contact_fit_1_pressure"][-1]
                balance = abs(c["contact_fit_1_force_1"][-1] + c["contact_fit_2_force_1"][-1])
                errors.append(mean / want - 1)
                show = lambda e: percent(e, 2) if abs(e) < 0.5 else times(e + 1)
                rows.append([
                    "outer pressure" if load == "pressed" else "press fit", TYPES[kind][0], m,
                    f"{mean:.4e}", f"{want:.4e}", show(errors[-1]), show(peak / want - 1),
                    f"{balance / (0.5 * mean):.0e}",
                ])  # fmt: skip
    heading = [
        "load",
        "elements",
        "m",
        "pressure",
        "Lame",
        "difference",
        "largest pressure",
        "imbalance",
    ]
    return heading, rows, None


def mindlin(runner):
    """Partial slip of a cylinder."""
    rows, curves = [], []
    for kind, meshes in MINDLIN.items():
        for mesh in meshes:
            run = runner(f"mindlin/{kind}_{mesh}")
            if failed(run):
                rows.append([TYPES[kind][0], mesh, failed(run), *["-"] * 5])
                continue
            c = run.curve("mindlin")
            force = abs(c["contact_mindlin_1_force_3"]) / 2.5e-4
            share = abs(c["contact_mindlin_1_force_1"]) / 2.5e-4 / (0.3 * force)
            for target in (0.25, 0.5, 0.75):
                pulled = np.flatnonzero(c["time"] > 1 + 1e-9)
                i = pulled[np.argmin(np.abs(share[pulled] - target))]
                b = np.sqrt(4 * force[i] * 1.82 / np.pi)
                p0 = np.sqrt(force[i] / 1.82 / np.pi)
                stuck = np.sqrt(1 - share[i])
                x, value, weight = run.surface(0, "contact_friction", step=("time", c["time"][i]))
                ball = lambda r, x=x: np.sqrt(np.maximum(0.0, 1 - (x[:, 0] / r) ** 2))
                exact = 0.3 * p0 * (ball(b) - stuck * ball(stuck * b))
                error = np.sqrt(np.sum(weight * (value - exact) ** 2) / np.sum(weight * exact**2))
                got = (
                    c["contact_mindlin_1_stick"][i]
                    * c["contact_mindlin_1_area"][i]
                    / 2.5e-4
                    / 2
                    / b
                )
                rows.append([
                    TYPES[kind][0], mesh, f"{share[i]:.3f}", f"{got:.3f}", f"{stuck:.3f}",
                    f"{got - stuck:+.3f}", f"{100 * error:.1f} %", int(c["iterations"][i]),
                ])  # fmt: skip
                if target == 0.5 and mesh == meshes[-1]:
                    keep = np.abs(x[:, 0]) < 1.3 * b
                    for s in np.argsort(x[keep, 0])[::3]:
                        curves.append({
                            "elements": TYPES[kind][0], "x": x[keep, 0][s] / b,
                            "shear": value[keep][s] / (0.3 * p0), "exact": exact[keep][s] / (0.3 * p0),
                        })  # fmt: skip
    heading = [
        "elements",
        "n",
        "Q/(mu P)",
        "c/b",
        "exact",
        "difference",
        "shear traction, L2",
        "iterations",
    ]
    return heading, rows, curves


def mindlin_sphere(runner):
    """Partial slip of a sphere: the tangential approach, and the area that sticks."""
    run = runner("mindlin/sphere")
    if failed(run):
        return ["Q/(mu P)"], [[failed(run)]], None
    c = run.curve("mindlin")
    press, pull = -2 * c["force_3"], 2 * c["force_1"]
    share = np.minimum(pull / (0.3 * press), 1.0)
    a = (30 * press * 1.82 / 4) ** (1 / 3)
    left = (1 - share) ** (2 / 3)
    exact = 3 * 0.3 * press * 1.7 * 2.6 / (8 * a) * (1 - left)
    rows = []
    for i in range(2, len(share) - 1):
        got = c["contact_mindlin_1_stick"][i]
        rows.append([
            f"{share[i]:.3f}", f"{c['disp_1'][i]:.4e}", f"{exact[i]:.4e}",
            percent(c["disp_1"][i] / exact[i] - 1), f"{got:.3f}", f"{left[i]:.3f}",
            f"{got - left[i]:+.3f}", int(c["iterations"][i]),
        ])  # fmt: skip
    heading = ["Q/(mu P)", "approach", "Mindlin", "difference", "share that sticks", "(c/a)^2", "difference", "iterations"]  # fmt: skip
    return heading, rows, None


def turn(runner):
    """Two blocks that are sheared and then turned together by 90 degrees, or merely held."""
    rows = []
    for name, settings in (
        ("turned by 90 degrees", {}),
        ("only held", {"turn": 0}),
        ("turned, without friction", {"mu": 0}),
    ):
        run = runner("turn/pair", **settings)
        if run.code not in (0, 2):
            rows.append([name, failed(run), *["-"] * 4])
            continue
        c = run.curve("pair")
        size = np.sqrt(c["force_1"] ** 2 + c["force_3"] ** 2)
        start = np.flatnonzero(c["time"] <= 1 + 1e-9)[-1]
        rows.append([
            name, f"{c['contact_sole_1_slip'][start]:.2f}",
            f"{abs(size[start + 1] / size[start] - 1):.0e}",
            f"{np.ptp(size[start:]) / size[start]:.0e}",
            f"{int(c['iterations'][start + 1])}; {int(c['iterations'][start + 2:].max())}",
            failed(run) or "converges",
        ])  # fmt: skip
    heading = ["case", "share that slips", "force, first step", "force, nine steps", "iterations, first; largest of the others", "outcome"]  # fmt: skip
    return heading, rows, None


def seal(runner):
    """A lubricated block squeezed by 30 %, and a rubber cord between plates."""
    nu = 0.49
    mu, lam = 0.5 / (1 + nu), nu / ((1 + nu) * (1 - 2 * nu))

    def wide_of(s):  # the stretch in the other direction, in which there is no stress
        return make.root(lambda t: mu * (t * t - 1) + lam * np.log(t * t * s), 0.5, 2.0)

    def nominal(s):
        return -(mu * (s * s - 1) + lam * np.log(wide_of(s) ** 2 * s)) / s

    want = nominal(0.7)
    rows = []
    for kind, label in (("q1", "Q1"), ("q1e9", "Q1E9"), ("q2", "Q2"), ("iga2", "IGA2")):
        run = runner(f"seal/block_{kind}")
        if failed(run):
            rows.append([label, failed(run), *["-"] * 5])
            continue
        c = run.curve("seal")
        got, wide = abs(c["contact_high_1_force_3"][-1]), 1 + c["disp_1"][-1]
        reached = 1 + c["disp_3"][-1]  # with the penetration
        rows.append([
            label, f"{got:.6f}", f"{want:.6f}", percent(got / want - 1, 2),
            f"{abs(got / nominal(reached) - 1):.0e}", f"{abs(wide / wide_of(reached) - 1):.0e}",
            iterations(c),
        ])  # fmt: skip
    heading = ["elements", "force", "closed form", "difference", "at the stretch reached", "width there", "iterations"]  # fmt: skip
    return heading, rows, None


def cord(runner):
    """A rubber cord between plates: a small squeeze, compared with Hertz, and one up to 30 %."""
    plane, rows = 1 - 0.49**2, []

    def approach(p):  # of the two plates relative to the diameter, Johnson 1985, eq. (5.57)
        b = np.sqrt(4 * p * 0.5 * plane / np.pi)
        return 2 * p * plane / np.pi * (2 * np.log(4 * 0.5 / b) - 1)

    exact = make.root(lambda p: approach(p) - 0.05, 1e-4, 0.2)
    for n in (6, 10, 14):
        run = runner("seal/ring", n=n)
        if failed(run):
            rows.append([n, failed(run), *["-"] * 6])
            continue
        c = run.curve("ring")
        force = abs(c["contact_low_1_force_3"]) / 0.1
        load = float(np.interp(0.05, 0.3 * c["time"], force))
        balance = (
            np.max(np.abs(c["contact_low_1_force_3"] + c["contact_high_1_force_3"])) / force[-1]
        )
        rows.append([n, f"{load:.5f}", f"{exact:.5f}", percent(load / exact - 1), f"{force[-1]:.4f}", f"{balance:.0e}", iterations(c)])  # fmt: skip
    heading = ["n", "force at 5 %", "Hertz, small strains", "difference", "force at 30 %", "lower against upper plate", "iterations"]  # fmt: skip
    return heading, rows, None


def drag(runner):
    """A block dragged back and forth on a plane."""
    exact = np.array(spring_and_slider())
    run = runner("drag/plane")
    c = run.curve("force")
    k = 1 / (1 / 300 + 0.5 / 0.4)
    force, work = c["force_1"], c["book_friction"]
    stick = (force[1] - force[0]) / (c["disp_1"][1] - c["disp_1"][0])
    rows = [
        ["sliding force, mu N", f"{force.max():.12g}", "0.03", f"{abs(force.max() / 0.03 - 1):.0e}"],
        ["stick stiffness", f"{stick:.12g}", f"{k:.12g}", f"{abs(stick / k - 1):.0e}"],
        ["sliding back, -mu N", f"{force.min():.12g}", "-0.03", f"{abs(force.min() / 0.03 + 1):.0e}"],
        ["all 113 steps, largest difference over mu N", "-", "-", f"{np.abs(force - exact[:, 1]).max() / 0.03:.0e}"],
        ["work of slip, mu N s, and elastic slip", f"{work[-1]:.12g}", f"{exact[-1, 2]:.12g}", f"{abs(work[-1] / exact[-1, 2] - 1):.0e}"],
    ]  # fmt: skip
    return ["quantity", "computed", "closed form", "difference"], rows, None


def beams(runner):
    """Crossing beams against Timoshenko's theory."""
    rows = []
    for length in (20, 40):
        want = 0.1 / 2 / (length**3 / 16 + length / (4 * 5 / 6 * 0.5))
        for n in (20, 40):
            run = runner("beams/beams", l=length, n=n)
            c = run.curve("beams")
            got = abs(c["contact_cross_1_force_3"][-1])
            balance = abs(c["contact_cross_1_force_3"][-1] + c["contact_cross_2_force_3"][-1]) / got
            support = abs(got - abs(c["force_3"][-1] + c["force_3_2"][-1])) / got
            rows.append([length, n, f"{got:.5e}", f"{want:.5e}", percent(got / want - 1, 2), f"{balance:.0e}", f"{support:.0e}"])  # fmt: skip
    heading = ["length over width", "elements", "force", "beam theory", "difference", "imbalance", "against supports"]  # fmt: skip
    return heading, rows, None


def cycle(runner):
    """A closed cycle without friction: the work that is not recovered."""
    rows = []
    for steps in (6, 12, 24):
        run = runner("cycle/cycle", steps=steps)
        if failed(run):
            rows.append([4 * steps, failed(run), *["-"] * 2])
            continue
        c = run.curve("cycle")
        work, force = c["book_work"], c["force_3"]
        back = [(i, len(force) - 2 - i) for i in range(len(force) // 2 - 1)]
        differ = max(abs(force[i] - force[j]) for i, j in back) / np.abs(force).max()
        rows.append([4 * steps, f"{work[-1] / work.max():+.0e}", f"{differ:.0e}", iterations(c)])
    heading = ["steps", "work left, of the largest", "force on the way back, largest difference", "iterations"]  # fmt: skip
    return heading, rows, None


def own(runner):
    """Surfaces in contact with themselves, and a face in two contacts: pairs of values that must be
    equal.
    """

    def differ(c, a, b, angle=0.0, rows=slice(None)):
        """The largest difference of the forces on copy b, turned back, from those on copy a,
        divided by the largest force.
        """
        x, z = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        one, two = c["force_1" + b][rows], c["force_3" + b][rows]
        off = np.hypot(
            x * one + z * two - c["force_1" + a][rows], x * two - z * one - c["force_3" + a][rows]
        )
        return np.max(off) / np.max(np.abs(c["force_3" + a]))

    rows = []
    for mu in (0, 0.1):
        for deck, what in (("slit", "slit with ends"), ("cut", "blocks of one mesh")):
            c = runner(f"slit/{deck}", mu=mu).curve("slit")
            rows.append(
                [f"{what}: self-contact and pair", mu, f"{differ(c, '', '_2'):.0e}", iterations(c)]
            )
    c = runner("slit/patch").curve("patch")
    rows.append(
        [
            "patch test: pressure",
            0,
            f"{abs(c['contact_slit_1_pressure'][-1] / 0.1 - 1):.0e}",
            iterations(c),
        ]
    )
    for mu in (0, 0.3):
        c = runner("fin/fin", mu=mu).curve("fin")
        rows.append(
            [
                "fin, turned by 37 degrees: all steps",
                mu,
                f"{differ(c, '', '_2', 37):.0e}",
                iterations(c),
            ]
        )
        rows.append(
            [
                "fin, turned by 37 degrees: last step",
                mu,
                f"{differ(c, '', '_2', 37, slice(-1, None)):.0e}",
                "-",
            ]
        )
        rows.append(
            [
                "fin: sum of the forces on its ends along the table",
                mu,
                f"{np.max(np.abs(c['force_1'] + c['force_1_3'])) / np.max(np.abs(c['force_3'])):.0e}",
                "-",
            ]
        )
    c = runner("fin/fin", turn=0, n2=40, m2=4).curve("fin")
    rows.append(
        [
            "fin: mesh twice as fine, last step",
            0,
            f"{abs(c['force_3_2'][-1] / c['force_3'][-1] - 1):.0e}",
            iterations(c),
        ]
    )
    for mu in (0, 0.2):
        c = runner("shared/shared", mu=mu).curve("shared")
        rows.append(
            ["face in two contacts: other order", mu, f"{differ(c, '', '_2'):.0e}", iterations(c)]
        )
        rows.append(
            ["face in two contacts: one contact instead", mu, f"{differ(c, '', '_3'):.0e}", "-"]
        )
    return (
        ["what is compared", "friction", "difference over the largest force", "iterations"],
        rows,
        None,
    )


def verdict(error, bound):
    return "right" if abs(error) <= bound else "wrong"


def extremes(runner):
    """Contact with extreme parameters, each case against a closed form."""
    rows = []

    def show(what, test, run, error, bound):
        if failed(run):
            rows.append([what, test, "no result", "-", failed(run)])
        else:
            size = f"{abs(error):.0e}" if bound < 1e-3 else percent(error)
            rows.append([what, test, verdict(error, bound), size, f"{run.seconds:.0f}"])

    def patch_row(what, **settings):
        run = runner("extremes/patch", **settings)
        error = np.inf
        if not failed(run):
            from post._fields import read_fields

            s, ratio, nu = (settings.get(k, v) for k, v in (("s", 1), ("ratio", 1), ("nu", 0.3)))
            p = 1e-3 * s * min(1, ratio) * min(1, settings.get("f", 100))
            stress = read_fields(run.place / "patch.vtkhdf").arrays["stress"][1][-1]
            side = -p * nu / (1 - nu)
            error = np.abs(stress - [side, side, -p, 0, 0, 0]).max() / p
        show(what, "patch", run, error, 1e-6)

    def hertz_row(what, bound=0.12, deck="hertz", **settings):
        run = runner(f"extremes/{deck}", **settings)
        error = np.inf
        if not failed(run):
            length, s, ratio, nu = (
                settings.get(k, v) for k, v in (("l", 1), ("s", 1), ("ratio", 1), ("nu", 0.3))
            )
            e = s / ((1 - nu**2) * (1 + 1 / ratio))
            force = abs(run.curve("hertz")["contact_hertz_1_force_3"][-1])
            error = force / (e / 3 * 1e-9 * length**2) - 1
        show(what, "Hertz", run, error, bound)

    def drag_row(what, mu):
        run = runner("drag/plane", mu=mu)
        error = np.inf
        if not failed(run):
            got = run.curve("force")["force_1"]
            want = np.array(spring_and_slider(mu))[:, 1]
            error = np.abs(got - want).max() / max(np.abs(want).max(), 1e-30 if mu else 1.0)
        show(what, "drag", run, error, 1e-8)

    hertz_row("nothing (mesh 4 of the sphere)")
    for f in (1e-2, 1e-1, 1e1, 1e3, 1e4, 1e5):
        patch_row(f"penalty {f:g} E/h", f=f)
    for f in (1e-2, 1e-1, 1e1, 1e3, 1e4, 1e5):
        hertz_row(f"penalty {f:g} E/h", f=f / 100)
    for ratio in (1e-3, 1e-2, 1e2, 1e4, 1e6):
        patch_row(f"stiffness ratio {ratio:g}", ratio=ratio)
    for ratio in (1e-3, 1e-2, 1e2, 1e4, 1e6):
        hertz_row(f"stiffness ratio {ratio:g}", ratio=ratio)
    for mu in (0, 0.1, 1, 2):
        drag_row(f"mu = {mu:g}", mu)
    hertz_row("mu = 2, pressed with friction", mu=2)
    for length, s in ((1e-6, 1), (1e6, 1), (1, 1e-6), (1, 1e12), (1e-6, 1e12)):
        patch_row(f"lengths {length:g}, stresses {s:g}", l=length, s=s)
    for length, s in ((1e-6, 1), (1e6, 1), (1, 1e-6), (1, 1e12), (1e-6, 1e12)):
        hertz_row(f"lengths {length:g}, stresses {s:g}", l=length, s=s)
    for nu in (0, 0.49, 0.499, 0.4999):
        patch_row(f"nu = {nu:g}, Q1E9", nu=nu)
    for nu in (0, 0.49, 0.499, 0.4999):
        hertz_row(f"nu = {nu:g}, Q1E9", deck="hertz_q1e9", nu=nu)
    for nu in (0, 0.49, 0.499, 0.4999):
        hertz_row(f"nu = {nu:g}, Q1E9+Q1N2", nu=nu)
    return ["changed", "test", "right or wrong", "by", "CPU s"], rows, None


TABLES = {f.__name__: f for f in (
    patch, sphere, cylinder, ironing, rings, mindlin, mindlin_sphere, turn, seal, cord, drag, beams, cycle, own, extremes)}  # fmt: skip
