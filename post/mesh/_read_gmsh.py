"""Read Gmsh's ASCII files, versions 2.2 and 4.1: points, quads, hexahedra, physical groups."""

import numpy as np

from post.mesh._tokens import Tokens

QUAD, HEX = 3, 5
#: Number of nodes of the Gmsh element types that a file may contain.
NODES = {1: 2, 2: 3, 3: 4, 4: 4, 5: 8, 6: 6, 7: 5, 8: 3, 9: 6, 10: 9, 11: 10, 12: 27, 15: 1}


def read_gmsh(path):
    """(points, quads, hexes, sets) of a file; sets are physical groups of quads."""
    points, tags, cells, names = read_all(path)
    place = {int(tag): i for i, tag in enumerate(tags)}
    t = Tokens(path)

    def table(kind):
        rows = [nodes for k, _, nodes in cells if k == kind]
        lost = next((int(n) for row in rows for n in row if int(n) not in place), None)
        if lost is not None:
            t.fail(f"an element refers to node {lost}, which is not in the file")
        return np.array([[place[int(n)] for n in row] for row in rows], dtype=np.int64).reshape(
            -1, NODES[kind]
        )

    groups = [group for k, group, _ in cells if k == QUAD]
    sets = {
        names.get((2, g), str(g)): np.flatnonzero(np.array(groups) == g) for g in set(groups) - {0}
    }
    return points, table(QUAD), table(HEX), sets


def read_all(path):
    """(points (n,3), tags (n), [(type, physical group, nodes)], {(dim, group): name})."""
    t = Tokens(path)
    if not t.seek("$MESHFORMAT"):
        t.fail("the file has no $MeshFormat")
    version = t.word("the version")
    if t.word("the type of file") != "0":
        t.fail("the file is a binary Gmsh file; save it as ASCII")
    if version not in ("2.2", "4.1"):
        t.fail(f"unknown version {version} of the Gmsh format; known versions: 2.2 4.1")
    names, groups, points, tags, cells = {}, {}, None, None, None
    seen = set()
    while True:
        section = t.seek(
            "$PHYSICALNAMES", "$ENTITIES", "$NODES", "$ELEMENTS", "$PARTITIONEDENTITIES"
        )
        if section is None:
            break
        if section == "$PARTITIONEDENTITIES":
            t.fail("the mesh is partitioned; save it as one part")
        if section in seen:
            t.fail(f"duplicate section ${section[1:].capitalize()}")
        seen.add(section)
        if section == "$PHYSICALNAMES":
            names = _names(t)
        elif section == "$ENTITIES":
            groups = _entities(t)
        elif section == "$NODES":
            points, tags = (_nodes2 if version == "2.2" else _nodes4)(t)
        else:
            cells = _elements2(t) if version == "2.2" else _elements4(t, groups)
        if t.seek("$END" + section[1:]) is None:
            t.fail(f"the file ends before $End{section[1:].capitalize()}")
    if points is None or cells is None:
        t.fail("the file has no $Nodes or no $Elements")
    unique, count = np.unique(tags, return_counts=True)
    if (count > 1).any():
        t.fail(f"duplicate node {unique[count > 1][0]}")
    return points, tags, cells, names


def _names(t):
    names = {}
    for _ in range(t.count("the number of physical names")):
        dim, tag = t.integer("a dimension"), t.integer("a physical tag")
        words = [t.word("a name")]
        while not (words[-1].endswith('"') and len(" ".join(words)) > 1):
            words.append(t.word("a name"))
        names[dim, tag] = " ".join(words).strip('"')
    return names


def _nodes2(t):
    n = t.count("the number of nodes")
    values = t.numbers(4 * n, "$Nodes").reshape(-1, 4)
    tags = values[:, 0]
    if (tags != np.rint(tags)).any():
        t.fail(f"the number of a node, {tags[tags != np.rint(tags)][0]:g}, is not an integer")
    return values[:, 1:], tags.astype(np.int64)


def _elements2(t):
    cells = []
    for _ in range(t.count("the number of elements")):
        number, kind, ntag = (t.integer("an element") for _ in range(3))
        if kind not in NODES:
            t.fail(f"element {number} has the unknown Gmsh type {kind}")
        tags = t.numbers(ntag, f"element {number}", int)
        cells.append((kind, int(tags[0]) if ntag else 0, t.numbers(NODES[kind], "$Elements", int)))
    return cells


def _entities(t):
    """{(dim, entity): physical group}"""
    groups = {}
    counts = [t.count("the number of entities") for _ in range(4)]
    for dim, count in enumerate(counts):
        for _ in range(count):
            tag = t.integer("an entity")
            t.numbers(3 if dim == 0 else 6, "an entity's box")
            physical = t.numbers(t.count("the number of groups"), "groups", int)
            if dim:
                t.numbers(t.count("the number of bounds"), "bounds", int)
            groups[dim, tag] = int(physical[0]) if len(physical) else 0
    return groups


def _nodes4(t):
    blocks, n, _, _ = (t.integer("a count of $Nodes") for _ in range(4))
    points, tags = [], []
    for _ in range(blocks):
        dim, _, parametric = t.numbers(3, "a block of $Nodes", int)
        count = t.count("the nodes of a block")
        tags.append(t.numbers(count, "$Nodes", int))
        width = 3 + (min(max(dim, 0), 3) if parametric else 0)  # parameters follow x y z
        points.append(t.numbers(width * count, "$Nodes").reshape(-1, width)[:, :3])
    if sum(map(len, tags)) != n:
        t.fail(f"$Nodes announces {n} nodes and contains {sum(map(len, tags))}")
    return np.concatenate([np.empty((0, 3)), *points]), np.concatenate([np.empty(0, int), *tags])


def _elements4(t, groups):
    blocks, n, _, _ = (t.integer("a count of $Elements") for _ in range(4))
    cells = []
    for _ in range(blocks):
        dim, tag, kind = (t.integer("a block of $Elements") for _ in range(3))
        if kind not in NODES:
            t.fail(f"a block of elements has the unknown Gmsh type {kind}")
        for _ in range(t.count("the elements of a block")):
            nodes = t.numbers(1 + NODES[kind], "$Elements", int)[1:]
            cells.append((kind, groups.get((dim, tag), 0), nodes))
    if len(cells) != n:
        t.fail(f"$Elements announces {n} elements and contains {len(cells)}")
    return cells
