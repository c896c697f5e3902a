"""Read nets of quads from legacy VTK, OFF and OBJ files, also as the boundary of hexahedra."""

import pathlib

import numpy as np

from post._error import Unreadable
from post.mesh import _read_gmsh
from post.mesh._net import Net
from post.mesh._tokens import Tokens

QUAD, HEX = 9, 12  # VTK's cell types
#: Corners of the faces of VTK's and Gmsh's hexahedron, counter-clockwise seen from outside.
FACES = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]


def read_net(path):
    """The net in a file, whose extension gives the format."""
    readers = {".vtk": read_vtk, ".off": read_off, ".obj": read_obj, ".msh": _read_gmsh.read_gmsh}
    ending = pathlib.Path(path).suffix.lower()
    if ending not in readers:
        known = " ".join([*readers, ".json (BEXT)", ".iga"])
        raise Unreadable(f"'{path}' has an unknown ending '{ending}'; known endings: {known}")
    points, quads, hexes, sets = readers[ending](path)
    for cells in (quads, hexes):
        if len(cells) and not (0 <= cells.min() and cells.max() < len(points)):
            k = int(np.flatnonzero(((cells < 0) | (cells >= len(points))).any(axis=1))[0])
            raise Unreadable(
                f"'{path}': cell {k + 1} refers to a point outside the {len(points)} points of the file"
            )
    if len(hexes) and not len(quads):
        quads = boundary(hexes)
        sets = {}
    if not len(quads):
        raise Unreadable(f"'{path}' has no quads and no hexahedra")
    return Net(points, quads, hexes, sets)


def boundary(hexes):
    """(m, 4) the faces that belong to only one hexahedron, counter-clockwise seen from outside.

    >>> boundary(np.arange(8)[None]).shape
    (6, 4)
    """
    faces = hexes[:, FACES].reshape(-1, 4)
    key = np.sort(faces, axis=1)
    _, first, count = np.unique(key, axis=0, return_index=True, return_counts=True)
    return faces[np.sort(first[count == 1])]


def read_vtk(path):
    """(points, quads, hexes, sets) of a legacy VTK file."""
    t = Tokens(path)
    if not t.lines or "vtk" not in t.lines[0].lower():
        t.fail("expected the first line of a VTK file, beginning with '# vtk DataFile'")
    if "ASCII" not in t.words:
        t.fail("the file is not ASCII; save it as legacy ASCII")
    t.seek("DATASET")
    kind = t.word("the type of the data set").upper()
    if kind not in ("UNSTRUCTURED_GRID", "POLYDATA"):
        t.fail(f"a data set {kind} is not a net; known data sets: UNSTRUCTURED_GRID POLYDATA")
    if not t.seek("POINTS"):
        t.fail("the file has no POINTS")
    n = t.count("the number of points")
    t.word("the type of the points")
    points = t.numbers(3 * n, "POINTS").reshape(-1, 3)
    word = t.seek("CELLS", "POLYGONS")
    if not word:
        t.fail("the file has no CELLS and no POLYGONS")
    n, size = t.count(f"the number of {word}"), t.count(f"the size of {word}")
    cells = _vtk_cells(t, n, size, word)
    if word == "POLYGONS":
        if any(len(c) != 4 for c in cells):
            t.fail("a polygon is not a quad")
        return points, _table(cells, 4), _table([], 8), {}
    t.seek("CELL_TYPES")
    if t.count("the number of CELL_TYPES") != len(cells):
        t.fail(f"the number of CELL_TYPES differs from that of CELLS, {len(cells)}")
    types = t.numbers(len(cells), "CELL_TYPES", int)
    return points, *_by_type(t, cells, types), {}


def _vtk_cells(t, n, size, word):
    if t.more() and t.words[t.at].upper() == "OFFSETS":  # the layout of version 5
        t.at += 2
        offsets = t.numbers(n, "OFFSETS", int)
        t.seek("CONNECTIVITY")
        t.word("the type of CONNECTIVITY")
        values = t.numbers(size, "CONNECTIVITY", int)
        return [values[a:b] for a, b in zip(offsets[:-1], offsets[1:])]
    values = t.numbers(size, word, int)
    cells, at = [], 0
    for _ in range(n):
        if at >= size or not 0 < values[at] < size - at + 1:
            t.fail(f"the size of {word}, {size}, does not match its {n} cells")
        cells.append(values[at + 1 : at + 1 + values[at]])
        at += 1 + int(values[at])
    if at != size:
        t.fail(f"the size of {word}, {size}, does not match its {n} cells")
    return cells


def _by_type(t, cells, types):
    kinds = {QUAD: 4, HEX: 8}
    for k, (cell, kind) in enumerate(zip(cells, types)):
        if kind not in kinds and len(cell) > 2:
            t.fail(f"cell {k + 1} has the VTK type {kind}; expected quads (9) or hexahedra (12)")
        if kind in kinds and len(cell) != kinds[kind]:
            t.fail(f"cell {k + 1} of type {kind}: expected {kinds[kind]} points, found {len(cell)}")
    return [_table([c for c, k in zip(cells, types) if k == kind], w) for kind, w in kinds.items()]


def _table(cells, width):
    return np.array(cells, dtype=np.int64).reshape(-1, width)


def read_off(path):
    """(points, quads, hexes, sets) of an OFF file."""
    t = Tokens(path, comment="#")
    if t.word("OFF").upper() != "OFF":
        t.fail("the first word is not OFF")
    n, m, _ = (t.count("the counts") for _ in range(3))
    points = t.numbers(3 * n, "points").reshape(-1, 3)
    quads = []
    for k in range(m):
        width = t.count(f"the size of face {k + 1}")
        if width != 4:
            t.fail(f"face {k + 1} has {width} corners; a net consists of quads only")
        quads.append(t.numbers(4, f"face {k + 1}", int))
    if t.more():
        t.fail(f"the file continues after the {m} faces that it announces")
    return points, _table(quads, 4), _table([], 8), {}


def read_obj(path):
    """(points, quads, hexes, sets) of a Wavefront OBJ file; groups (g, o) are sets."""
    t = Tokens(path, comment="#")
    points, quads, sets, group = [], [], {}, None
    for number, line in enumerate(t.lines, 1):
        words = line.split()
        if not words:
            continue
        place = f"line {number}"
        if words[0] == "v":
            points.append(_obj_numbers(t, words[1:4], 3, place, float))
        elif words[0] == "f":
            corners = _obj_numbers(t, [w.split("/")[0] for w in words[1:]], None, place, int)
            if len(corners) != 4:
                t.fail(
                    f"{place}: the face has {len(corners)} corners; a net consists of quads only"
                )
            if group:
                sets.setdefault(group, []).append(len(quads))
            quads.append([c - 1 if c > 0 else len(points) + c for c in corners])
        elif words[0] in ("g", "o"):
            group = words[1] if len(words) > 1 else None
    sets = {name: np.array(ids, dtype=np.int64) for name, ids in sets.items()}
    return np.array(points, dtype=float).reshape(-1, 3), _table(quads, 4), _table([], 8), sets


def _obj_numbers(t, words, n, place, kind):
    try:
        values = np.array([kind(w) for w in words], dtype=kind).tolist()
    except (ValueError, OverflowError):
        t.fail(f"{place}: expected numbers")
    if n and len(values) != n or not np.isfinite(values).all():
        t.fail(f"{place}: expected {n} finite numbers")
    return values
