"""Nets for the tests of `post.mesh`: a block of unit cubes, and files that contain it."""

import pathlib
import tempfile
import unittest

import numpy as np

from post.mesh import body_of


def grid(n=(3, 3, 3)):
    """(points, hexes) of a block of unit cubes."""
    at = np.arange(np.prod(np.array(n) + 1)).reshape(np.array(n) + 1)
    points = np.argwhere(at >= 0).astype(float)
    cells = [
        at[: n[0], : n[1], : n[2]], at[1:, : n[1], : n[2]], at[1:, 1:, : n[2]], at[: n[0], 1:, : n[2]],
        at[: n[0], : n[1], 1:], at[1:, : n[1], 1:], at[1:, 1:, 1:], at[: n[0], 1:, 1:],
    ]  # fmt: skip
    return points, np.stack([c.ravel() for c in cells], axis=1)


def vtk(points, cells, kind=12):
    """The text of a legacy VTK file."""
    rows = "\n".join(f"{len(c)} " + " ".join(map(str, c)) for c in cells)
    xyz = "\n".join(" ".join(map(repr, x)) for x in points.tolist())
    size = sum(len(c) + 1 for c in cells)
    types = "\n".join([str(kind)] * len(cells))
    return (f"# vtk DataFile Version 2.0\nnet\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {len(points)} "
            f"double\n{xyz}\nCELLS {len(cells)} {size}\n{rows}\nCELL_TYPES {len(cells)}\n{types}\n")  # fmt: skip


class Folder(unittest.TestCase):
    """A test that has its own folder."""

    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name)

    def file(self, name, text):
        path = self.folder / name
        path.write_text(text)
        return str(path)

    def block(self, n=(3, 3, 3)):
        """The file of a block."""
        return self.file("block.vtk", vtk(*grid(n)))

    def body(self, **options):
        """The body of a block, with the file's hexahedra."""
        return body_of(self.block(), **({"interior": "hexes"} | options))


def rows(points):
    return "\n".join(" ".join(map(repr, x)) for x in points.tolist())
