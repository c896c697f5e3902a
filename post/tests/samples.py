"""Small files in the formats that the program writes, made for the tests."""

import json
import pathlib
import tempfile
import unittest

import numpy as np


class Scratch(unittest.TestCase):
    """A test that has its own folder, `self.folder`."""

    def setUp(self):
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        self.folder = pathlib.Path(place.name)


def write_curve(
    path,
    steps=10,
    force=lambda t: -0.3 * t + 0.05 * t**2,
    names=("disp_top_3", "force_top_3"),
    end=1.0,
):
    """A curve file with a displacement t and a force."""
    head = "#       step" + "".join(f"{n:>25}" for n in ("time", "factor_1"))
    head += "  iterations    cutbacks   converged" + "".join(f"{n:>25}" for n in names)
    lines = [head]
    for i, t in enumerate(np.linspace(end / max(steps, 1), end, steps), 1):
        values = "".join(f"{v:25.15e}" for v in (t, force(t)))
        lines.append(f"{i:12d}{t:25.15e}{t:25.15e}{3:12d}{0:12d}{1:12d}{values}")
    pathlib.Path(path).write_text("\n".join(lines) + "\n")


def write_report(path, **changes):
    """A report with two types of elements and one curve."""
    content = {
        "version": "0.1.0", "deck": "cube.inp", "status": "done", "exit_code": 0, "steps": 10, "iterations": 30,
        "cutbacks": 0, "dofs": 135, "equations": 44, "elements": {"Q1": 12, "Q1N2": 4}, "negative_pivots": 0,
        "seconds": {"assembly": 0.01}, "peak_memory_mb": 30.5, "final": {"force": {"force_top_3": -0.25}},
    } | changes  # fmt: skip
    pathlib.Path(path).write_text(json.dumps(content, indent=2))


def write_run(folder, stem="cube", **curve):
    """Write a curve and a report, as one run would; return the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    write_curve(folder / f"{stem}_force.dat", **curve)
    write_report(folder / f"{stem}.report.json")
    return folder


def quarter_ring(layers=2):
    """Control points (n, 3), weights (n) and cells (layers, 27) of a quarter of a ring, 1 < r < 2,
    in triquadratic rational Bezier hexahedra; `place` gives the order of points in VTK."""
    number, points, weights, cells = {}, [], [], []
    for c in range(layers):
        cell = [0] * 27
        for k in range(3):
            for j in range(3):
                for i in range(3):
                    key = (i, j, 2 * c + k)
                    if key not in number:
                        r = 1 + 0.5 * i
                        number[key] = len(points)
                        points.append((*[(r, 0.0), (r, r), (0.0, r)][j], 0.5 * key[2]))
                        weights.append([1.0, np.sqrt(0.5), 1.0][j])
                    cell[place(i, j, k)] = number[key]
        cells.append(cell)
    return np.array(points), np.array(weights), np.array(cells)


def place(i, j, k):
    """Where VTK puts point (i, j, k) of a triquadratic cell: corners, edges, faces, inside.

    >>> sorted(place(i, j, k) for i in range(3) for j in range(3) for k in range(3)) == list(range(27))
    True
    """
    ends = [v in (0, 2) for v in (i, j, k)]
    if all(ends):
        return (2 if j else 0) + ((1 if i else 0) if not j else (0 if i else 1)) + (4 if k else 0)
    if sum(ends) == 2:  # an edge; along 1, 2, then 3
        if not ends[0]:
            return 8 + (2 if j else 0) + (4 if k else 0)
        if not ends[1]:
            return 8 + (1 if i else 3) + (4 if k else 0)
        return 16 + ((1 if i else 0) if not j else (2 if i else 3))
    if sum(ends) == 1:  # a face
        return 20 + bool(i) if ends[0] else 22 + bool(j) if ends[1] else 24 + bool(k)
    return 26


def write_fields(path, steps=3, grow=(0.3, -0.1, 0.4), noise=0.0):
    """A .vtkhdf file of the quarter ring: displacement = time * grow * x, a stress, mises,
    material.
    """
    import h5py

    points, weights, cells = quarter_ring()
    n, times = len(points), np.linspace(0.0, 1.0, steps)
    static = np.zeros(steps, dtype="i8")
    moving = {
        "displacement": [t * np.array(grow) * points + noise * t for t in times],
        "stress": [np.tile([t, 0, 0, 0, 0, -t], (n, 1)) for t in times],
        "mises": [2.0 * t * np.ones(n) for t in times],
    }
    with h5py.File(path, "w") as file:
        g = file.create_group("VTKHDF", track_order=True)
        g.attrs["Version"] = (2, 6)
        g.attrs.create("Type", np.bytes_("UnstructuredGrid"))
        g["NumberOfPoints"], g["NumberOfCells"], g["NumberOfConnectivityIds"] = (
            [n],
            [len(cells)],
            [cells.size],
        )
        g["Points"], g["Connectivity"], g["Offsets"] = (
            points,
            cells.ravel(),
            27 * np.arange(len(cells) + 1),
        )
        g["Types"] = np.full(len(cells), 79, "u1")
        s = g.create_group("Steps")
        s.attrs["NSteps"] = np.int64(steps)
        s["Values"], s["PartOffsets"], s["NumberOfParts"], s["PointOffsets"] = (
            times,
            static,
            static + 1,
            static,
        )
        s["StepNumber"] = 10 * np.arange(
            1, steps + 3
        )  # with unused room at the end, as in the files of the program
        s["CellOffsets"], s["ConnectivityIdOffsets"] = static[:, None], static[:, None]
        for name, values in moving.items():
            g[f"PointData/{name}"] = np.concatenate(values)
            s[f"PointDataOffsets/{name}"] = np.arange(steps) * n
        for where, name, values in (
            ("Point", "RationalWeights", weights), ("Cell", "HigherOrderDegrees", np.full((len(cells), 3), 2.0)),
            ("Cell", "material", np.ones(len(cells))),
        ):  # fmt: skip
            g[f"{where}Data/{name}"] = values
            s[f"{where}DataOffsets/{name}"] = static
            if name != "material":
                g[f"{where}Data/{name}"].attrs["Attribute"] = np.bytes_(name)
