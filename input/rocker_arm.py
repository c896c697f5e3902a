"""A rocker arm as a closed net of quads: a link with two bosses, and an arm that carries a load.

    python3 input/rocker_arm.py rocker_arm.obj

The net is a plane arrangement of quads with a top, a bottom and sides. It is meant as the control net
of a smooth surface (`python -m post mesh`). Its groups are bore_left, bore_right and pad (the upper
side of the arm). The bosses are at a distance of 4, and the plate has the thickness 0.8.
"""

import sys

import numpy as np

AROUND = 16  # quads around a boss
ACROSS = 4  # quads across link and arm, which share as many quads with a boss
LINK, ARM = 6, 8  # quads along
LEVELS = 3  # quads from bottom to top
LEFT = {"centre": (0.0, 0.0), "radii": (0.5, 0.75, 1.0), "half": (0.52, 0.5, 0.42)}
RIGHT = {"centre": (4.0, 0.0), "radii": (0.4, 0.6, 0.8), "half": (0.48, 0.46, 0.4)}


class Plan:
    """Points (x, y, half thickness) and quads, counter-clockwise seen from above."""

    def __init__(self):
        self.points, self.quads = [], []

    def add(self, x, y, half):
        self.points.append((x, y, half))
        return len(self.points) - 1

    def strip(self, rows):
        """Quads between consecutive rows of points; the next row lies to the left of a row."""
        for low, high in zip(rows[:-1], rows[1:]):
            for k in range(len(low) - 1):
                self.quads.append((low[k], low[k + 1], high[k + 1], high[k]))


def boss(plan, centre, radii, half):
    """Rings of points about a centre, from the bore outward; return the outer one."""
    angle = 2 * np.pi * np.arange(AROUND) / AROUND
    rings = [
        [plan.add(centre[0] + r * np.cos(a), centre[1] + r * np.sin(a), h) for a in angle]
        for r, h in zip(radii, half)
    ]
    plan.strip([[*ring, ring[0]] for ring in rings[::-1]])
    return rings[-1]


def bar(plan, start, end, along, waist):
    """Quads from a row of points to the places `end`; `waist` narrows it in the middle."""
    first = np.array([plan.points[i] for i in start])
    rows = [list(start)]
    for k in range(1, along + (end[1] is None)):
        t = k / along
        x = (1 - t) * first + t * end[0]
        middle = x.mean(axis=0)
        x[:, :2] = middle[:2] + (x[:, :2] - middle[:2]) * (1 - waist * np.sin(np.pi * t))
        rows.append([plan.add(*row) for row in x])
    if end[1] is not None:
        rows.append(end[1])
    plan.strip(rows)
    return rows


def make_plan():
    """(Plan, points of the upper side of the arm)"""
    plan = Plan()
    left, right = boss(plan, **LEFT), boss(plan, **RIGHT)
    half = ACROSS // 2
    sector = lambda ring, middle: [ring[(middle + k) % AROUND] for k in range(-half, half + 1)]  # noqa: E731
    to_right = sector(right, AROUND // 2)
    goal = np.array([plan.points[i] for i in to_right])
    bar(plan, sector(left, 0)[::-1], (goal, to_right), LINK, waist=0.2)
    start = sector(left, AROUND // 2)[::-1]
    tip = np.column_stack(
        [np.full(ACROSS + 1, -3.6), np.linspace(0.1, 0.75, ACROSS + 1), np.full(ACROSS + 1, 0.4)]
    )
    rows = bar(plan, start, (tip, None), ARM, waist=0.0)
    return plan, [row[-1] for row in rows]


def border(quads):
    """Edges (a, b) of the plan that belong to one quad, in the direction of that quad."""
    edges = {(q[k], q[(k + 1) % 4]) for q in quads for k in range(4)}
    return [e for e in sorted(edges) if (e[1], e[0]) not in edges]


def body(plan, pad):
    """(points (n, 3), quads by group) of the closed net."""
    n = len(plan.points)
    edges = border(plan.quads)
    rim = sorted({v for e in edges for v in e})
    points = [(x, y, -h) for x, y, h in plan.points] + [(x, y, h) for x, y, h in plan.points]
    column = {v: [v] for v in rim}
    for k in range(1, LEVELS):
        for v in rim:
            x, y, h = plan.points[v]
            column[v].append(len(points))
            points.append((x, y, h * (2 * k / LEVELS - 1)))
    for v in rim:
        column[v].append(n + v)
    groups = {"faces": [tuple(n + v for v in q) for q in plan.quads]}
    groups["faces"] += [q[::-1] for q in plan.quads]
    on_pad = set(pad[2:])
    for a, b in edges:
        middle = 0.5 * (np.array(plan.points[a][:2]) + plan.points[b][:2])
        name = "sides"
        for boss_name, boss_of in (("bore_left", LEFT), ("bore_right", RIGHT)):
            if np.linalg.norm(middle - boss_of["centre"]) < boss_of["radii"][1]:
                name = boss_name
        if a in on_pad and b in on_pad:
            name = "pad"
        for k in range(LEVELS):
            side = (column[a][k], column[b][k], column[b][k + 1], column[a][k + 1])
            groups.setdefault(name, []).append(side)
    return np.array(points), groups


def main(path):
    points, groups = body(*make_plan())
    with open(path, "w") as f:
        f.write("# a rocker arm, made by input/rocker_arm.py\n")
        f.writelines(f"v {x:.12g} {y:.12g} {z:.12g}\n" for x, y, z in points)
        for name, quads in sorted(groups.items()):
            f.write(f"g {name}\n")
            f.writelines("f " + " ".join(str(v + 1) for v in q) + "\n" for q in quads)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: python3 input/rocker_arm.py FILE.obj")
    main(sys.argv[1])
