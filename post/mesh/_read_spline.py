"""Read extracted spline surfaces: BEXT 2.0 as JSON and as text, `.iga` files of T-splines."""

import json
import pathlib

import numpy as np

from post._error import Unreadable
from post.mesh import _split, _surface
from post.mesh._surface import Surface
from post.mesh._tokens import Tokens, text_of

HEAD = ["B", "E", "X", "T", "2.0"]
KINDS = {1: "curves", 3: "a solid"}


def is_spline(path):
    """Whether the extension of a file is that of a spline surface rather than of a net.

    >>> is_spline("a.bext.json"), is_spline("a.vtk")
    (True, False)
    """
    return pathlib.Path(path).suffix.lower() in (".json", ".iga", ".bext", ".bxt", ".bez")


def read_spline(path, closed=True):
    """The Surface in a file, turned such that x_xi x x_eta points into the body."""
    ending = pathlib.Path(path).suffix.lower()
    reader = {".json": _json, ".iga": _iga}.get(ending, _text)
    degree, points, weights, nodes, coefficients, sets = reader(path)
    _check(path, degree, points, weights, nodes, coefficients)
    for name, ids in sets.items():
        if len(ids) and not (0 <= ids.min() and ids.max() < len(nodes)):
            raise Unreadable(f"'{path}': set '{name}' refers to an element that does not exist")
    s = Surface(degree, points, weights, nodes, coefficients, None, sets)
    s.corners = _split.find_corners(nodes, coefficients, s.corner_index)
    s.hanging = _split.find_hanging(s)
    lone = _split.check_corners(s, path, closed)
    if not lone and _surface.measures(s)[1] < 0:
        return turned(s)
    return s


def turned(s):
    """The surface with its two parameters exchanged, which reverses its normals."""
    p, q = s.degree
    order = np.arange((p + 1) * (q + 1)).reshape(q + 1, p + 1).T.ravel()
    rows = [c[:, order] for c in s.coefficients]
    corners = s.corners[:, [0, 3, 2, 1]]
    return Surface((q, p), s.points, s.weights, s.nodes, rows, corners, s.sets, s.hanging)


def _check(path, degree, points, weights, nodes, coefficients):
    if not len(nodes):
        raise Unreadable(f"'{path}' has no elements")
    width = (degree[0] + 1) * (degree[1] + 1)
    if not (weights > 0).all() or not np.isfinite(weights).all() or not np.isfinite(points).all():
        raise Unreadable(
            f"'{path}' has a weight that is not positive, or a coordinate that is not finite"
        )
    for e, (ids, c) in enumerate(zip(nodes, coefficients), 1):
        if len(ids) and not (0 <= ids.min() and ids.max() < len(points)):
            raise Unreadable(f"'{path}': element {e} refers to a control point that does not exist")
        if c.shape != (len(ids), width):
            raise Unreadable(f"'{path}': element {e}: expected {width} coefficients per function")
        if not abs(c.sum(axis=0) - 1).max() <= 1e-6:
            raise Unreadable(f"'{path}': the functions of element {e} do not sum to one")


def _json(path):
    try:
        data = json.loads(text_of(path))
    except json.JSONDecodeError as error:
        raise Unreadable(f"'{path}' is not JSON, or truncated: {error}") from None
    except RecursionError:
        raise Unreadable(
            f"'{path}' is not BEXT 2.0 in JSON: its lists are nested too deeply"
        ) from None
    try:
        if data.get("dim", 2) != 2:
            raise Unreadable(_no_surface(path, data["dim"]))
        _json_counts(path, data)
        degrees = {(b["deg_s"], b["deg_t"]) for b in data["elements"]["element_block_info"]}
        if len(degrees) != 1 or min(min(degrees)) < 1:
            raise Unreadable(
                f"'{path}': expected elements of one degree, found the degrees {sorted(degrees)}"
            )
        full = np.array(data["nodes"], dtype=float).reshape(-1, 4)
        vectors = _json_vectors(data["coefficients"], degrees)
        nodes = [_whole(b["node_ids"]) for b in data["elements"]["element_blocks"]]
        rows = [vectors[b["coeff_vector_ids"]] for b in data["elements"]["element_blocks"]]
        sets = {name: _whole(ids) for name, ids in data.get("sets", {}).items()}
    except (AttributeError, KeyError, TypeError, ValueError, IndexError, OverflowError) as error:
        raise Unreadable(f"'{path}' is not BEXT 2.0 in JSON ({error!r})") from None
    return degrees.pop(), full[:, :3], full[:, 3], nodes, rows, sets


def _no_surface(path, dim):
    """The message for splines whose number of parameters is not two."""
    kind = KINDS.get(dim, f"splines of {dim} parameters") if isinstance(dim, int) else "no surface"
    return (
        f"'{path}' contains {kind}; expected a surface, whose inside the command fills: "
        "give the boundary of the body as splines of two parameters"
    )


def _whole(numbers):
    """An array of integers; raise ValueError if a value is not an integer.

    >>> _whole([0, 2]).tolist()
    [0, 2]
    """
    if not all(isinstance(n, int) for n in numbers):
        raise ValueError("a count or an index is not an integer")
    return np.array(numbers, dtype=np.int64)


def _json_counts(path, data):
    """Check that the file contains as many items as it announces."""
    blocks, cells = (data["elements"][key] for key in ("element_block_info", "element_blocks"))
    for what, announced, held in (
        ("control points", data["num_nodes"], data["nodes"]),
        ("elements", sum(b["num_elems"] for b in blocks), cells),
        ("elements", data.get("num_elems", len(cells)), cells),
    ):
        if announced != len(held):
            raise Unreadable(f"'{path}' announces {announced} {what} and contains {len(held)}")


def _json_vectors(data, degrees):
    p, q = next(iter(degrees))
    vectors = [v["components"] for v in data["dense_coefficient_vectors"]]
    for v in data["sparse_coefficient_vectors"]:
        full = np.zeros((p + 1) * (q + 1))
        full[v["indices"]] = v["components"]
        vectors.append(full)
    return np.array(vectors, dtype=float)


def _text(path):
    t = Tokens(path, comment="$")
    if t.words[:5] != HEAD:
        t.fail("the first words are not B E X T 2.0")
    t.at = 5
    t.integer("the patch")
    n, m, nv = (t.count(w) for w in ("the control points", "the elements", "the vectors"))
    t.integer("the flag of weights")
    full = t.numbers(4 * n, "the control points").reshape(-1, 4)
    blocks, degrees = [], set()
    # The length of a block's header tells a curve (5) from a surface (6) and a solid (7).
    for _ in range(t.count("the blocks of elements")):
        dim = t.left_in_line() - 4
        if dim in KINDS:
            raise Unreadable(_no_surface(path, dim))
        _, ne, nn, nc, p, q = t.numbers(6, "a block of elements", int)
        degrees.add((int(p), int(q)))
        blocks.append((ne, nn, nc))
    if len(degrees) != 1:
        t.fail("expected elements of one degree")
    ids = []
    for ne, nn, nc in blocks:
        if nn != nc:
            t.fail(f"an element has {nn} functions but {nc} coefficient vectors")
        table = t.numbers(int(ne * (nn + nc)), "the elements", int).reshape(ne, 2, nn) - 1
        ids.extend(table)
    degree = degrees.pop()
    vectors = _text_vectors(t, nv, (degree[0] + 1) * (degree[1] + 1))
    if len(ids) != m or any(v[1].min() < 0 or v[1].max() >= nv for v in ids):
        t.fail("the numbers of elements, or the indices of vectors, do not match")
    nodes, rows = [v[0] for v in ids], [vectors[v[1]] for v in ids]
    return degree, full[:, :3], full[:, 3], nodes, rows, {}


def _text_vectors(t, count, width):
    dense, sparse = t.count("the blocks of vectors"), t.count("the blocks of sparse vectors")
    heads = [t.numbers(2, "a block of vectors", int) for _ in range(dense + sparse)]
    vectors = np.zeros((count, width))
    at = 0
    for k, (n, length) in enumerate(heads):
        for _ in range(n):
            if at >= count or length > width:
                t.fail("the file contains more or longer vectors than it announces")
            if k < dense:
                vectors[at, :length] = t.numbers(int(length), "a vector")
            else:
                place = t.numbers(int(length), "a sparse vector", int) - 1
                vectors[at, place] = t.numbers(int(length), "a sparse vector")
            at += 1
    if at != count:
        t.fail(f"the file contains {at} vectors and announces {count}")
    return vectors


def _iga(path):
    t = Tokens(path, comment="#")
    counts = {}
    while len(counts) < 2:
        word = t.word("nodeN and elemN")
        if word == "type" and t.word("the type") not in ("surface", "plane"):
            found = t.words[t.at - 1]
            t.fail(f"expected 'type surface' or 'type plane', found 'type {found}'")
        if word in ("nodeN", "elemN"):
            counts[word] = t.count(word)
    full = np.empty((counts["nodeN"], 4))
    for k in range(len(full)):
        if t.word("node") != "node":
            t.fail(f"the file announces {len(full)} nodes and contains {k}")
        full[k] = t.numbers(4, "a node")
    nodes, rows, degrees = [], [], set()
    for k in range(counts["elemN"]):
        if t.word("belem") != "belem":
            t.fail(f"the file announces {counts['elemN']} elements and contains {k}")
        n, p, q = (t.count("the sizes of an element") for _ in range(3))
        degrees.add((p, q))
        nodes.append(t.numbers(n, "an element", int))
        rows.append(t.numbers(n * (p + 1) * (q + 1), "an element").reshape(n, -1))
    if len(degrees) != 1:
        t.fail("expected elements of one degree")
    return degrees.pop(), full[:, :3], full[:, 3], nodes, rows, _iga_sets(t)


def _iga_sets(t):
    sets = {}
    for line in t.lines:
        words = line.split()
        if words[:1] == ["set"] and len(words) > 3 and words[2] == "elem":
            if not all(w.isdigit() for w in words[4:]):
                t.fail(f"set '{words[3]}' has an element number that is not an integer")
            sets[words[3]] = np.array(words[4:], dtype=np.int64)
    return sets
