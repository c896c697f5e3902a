"""Write the files of a body: bulk (Gmsh 2.2), skin (BEXT 2.0 in JSON), layer, constraints, deck."""

import json
import pathlib

import numpy as np

from post.mesh._surface import Surface

GMSH = {"tets": 4, "pyramids": 7, "hexes": 5}
VECTOR_DIGITS = 13  # coefficient vectors that agree to so many decimals are shared

DECK = """FEAP ** {name}
! made by: python -m post mesh {arguments}
  ndm = 3

PARAmeter
  e  = 1000
  nu = 0.3

MATErial 1
  SOLId
    ELAStic NEOHook e nu

MESH,{name}_bulk FILE {name}.msh
{inside}  MATErial 1

{skin}{supports}END

BATCh
  DT,,1
  TIME
  LOOP,,30
    UTAN,,1
  NEXT
  PLOT
END

STOP
"""


SKIN = """SPLIne,{name} FILE {name}.bext.json
  LAYEr {name}.layer {name}_bulk
{constraint}  MATErial 1

"""


def write(body, stem, arguments=""):
    """Write all files with the stem `stem` (folder/name); return their paths.

    A layer alone has no deck, because the program needs elements inside.
    """
    stem = pathlib.Path(stem)
    stem.parent.mkdir(parents=True, exist_ok=True)
    body.surface = grouped(body.surface)
    files = {".msh": gmsh_text(body)}
    if len(body.surface.nodes):
        files[".bext.json"] = bext_text(body.surface)
        files[".layer"] = layer_text(body.surface)
    if body.hanging or body.ties:
        files[".con"] = constraint_text(body)
    if any(map(len, body.cells.values())):
        files[".inp"] = deck_text(body, stem.name, arguments)
    paths = []
    for ending, text in files.items():
        paths.append(stem.with_name(stem.name + ending))
        paths[-1].write_text(text)
    return paths


def grouped(s):
    """The surface with its elements sorted by number of functions, as BEXT requires."""
    order = np.argsort([len(ids) for ids in s.nodes], kind="stable")
    place = np.empty(len(order), dtype=int)
    place[order] = np.arange(len(order))
    sets = {name: np.sort(place[ids]) for name, ids in s.sets.items()}
    return Surface(s.degree, s.points, s.weights, [s.nodes[e] for e in order],
                   [s.coefficients[e] for e in order], s.corners[order], sets, s.hanging)  # fmt: skip


def gmsh_text(body):
    """Gmsh 2.2 ASCII: a physical group of all cells, and one for the bilinear faces of each set."""
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat"]
    sets = plain_sets(body)
    names = ['3 1 "bulk"'] + [f'2 {tag} "{name}"' for tag, name in enumerate(sets, 2)]
    lines += ["$PhysicalNames", str(len(names)), *names, "$EndPhysicalNames"]
    lines += ["$Nodes", str(len(body.points))]
    lines += [f"{i} {x!r} {y!r} {z!r}" for i, (x, y, z) in enumerate(body.points.tolist(), 1)]
    rows = [(GMSH[k], 1, row) for k, cells in body.cells.items() for row in (cells + 1).tolist()]
    for tag, ids in enumerate(sets.values(), 2):
        rows += [(3, tag, row) for row in (body.plain[ids] + 1).tolist()]
    lines += ["$EndNodes", "$Elements", str(len(rows))]
    for i, (kind, tag, row) in enumerate(rows, 1):
        lines.append(f"{i} {kind} 2 {tag} {tag} {' '.join(map(str, row))}")
    lines += ["$EndElements", ""]
    return "\n".join(lines)


def plain_sets(body):
    """{name: numbers of plain faces}, in which `plain` is all of them; empty without a plain
    part.
    """
    if body.plain is None:
        return {}
    named = {name: ids for name, ids in sorted(body.plain_sets.items()) if len(ids)}
    return {"plain": np.arange(len(body.plain)), **named}


def bext_text(s):
    """BEXT 2.0 in JSON; elements share coefficient vectors, and numbering starts from 0."""
    vectors, known, ids = [], {}, []
    for c in s.coefficients:
        keys = map(tuple, (np.round(c, VECTOR_DIGITS) + 0.0).tolist())
        for key, row in zip(keys, c.tolist()):
            if key not in known:
                known[key] = len(vectors)
                vectors.append(row)
        ids.append([known[k] for k in map(tuple, (np.round(c, VECTOR_DIGITS) + 0.0).tolist())])
    sizes, counts = np.unique([len(n) for n in s.nodes], return_counts=True)
    rational = bool(np.ptp(s.weights) > 0 or s.weights[0] != 1)
    full = np.column_stack([s.points, s.weights]).tolist()
    blocks = [
        {"element_type": "Cube", "num_elems": int(n), "num_nodes": int(size),
         "num_coefficient_vectors": int(size), "deg_s": s.degree[0], "deg_t": s.degree[1],
         "deg_u": -1}
        for size, n in zip(sizes, counts)
    ]  # fmt: skip
    elements = [{"node_ids": n.tolist(), "coeff_vector_ids": v} for n, v in zip(s.nodes, ids)]
    dense = {"num_coeff_vectors": len(vectors), "num_components": s.coefficients[0].shape[1]}
    # One list entry per line keeps the file readable.
    parts = [
        f'{{"patch_id": 0, "dim": 2, "num_nodes": {len(full)}, "num_elems": {len(s.nodes)}, '
        f'"num_coeff_vecs": {len(vectors)}, "is_rational": {json.dumps(rational)},',
        '"nodes": [\n' + _rows(full) + "\n],",
        f'"elements": {{"num_elem_blocks": {len(blocks)}, "element_block_info": [\n'
        + _rows(blocks) + '\n], "element_blocks": [\n' + _rows(elements) + "\n]},",
        '"coefficients": {"num_dense_coeff_blocks": 1, "num_sparse_coeff_blocks": 0,',
        f'"dense_vector_info": [{json.dumps(dense)}], "sparse_vector_info": [],',
        '"dense_coefficient_vectors": [\n' + _rows([{"components": v} for v in vectors])
        + '\n], "sparse_coefficient_vectors": []},',
        f'"sets": {json.dumps({k: v.tolist() for k, v in sorted(s.sets.items())})}}}',
    ]  # fmt: skip
    return "\n".join(parts) + "\n"


def _rows(items):
    return ",\n".join(map(json.dumps, items))


def layer_text(s):
    """One line per element of the surface: its number and the bulk points below its corners."""
    lines = ["# element of the surface, its inner nodes at (-,-) (+,-) (+,+) (-,+)"]
    lines += [f"{e} {a} {b} {c} {d}" for e, (a, b, c, d) in enumerate((s.corners + 1).tolist(), 1)]
    return "\n".join(lines) + "\n"


def constraint_text(body):
    """One line per constraint; a master -k stands for control point k of the surface."""
    lines = ["# slave, number of masters, then each with its coefficient; -k: control point k"]
    for s, masters, factors in body.hanging:
        numbers = [m + 1 if m >= 0 else m for m in masters]
        pairs = " ".join(f"{m} {float(c)!r}" for m, c in zip(numbers, factors))
        lines.append(f"{s + 1} {len(masters)} {pairs}")
    lines += [f"{s + 1} 1 {-(k + 1)} 1.0" for s, k in body.ties]
    return "\n".join(lines) + "\n"


def deck_text(body, name, arguments):
    """A deck that reads the files; the user adds supports and loads."""
    constraint = f"  CONStraint {name}.con\n" if body.hanging or body.ties else ""
    enriched = len(body.surface.nodes) > 0
    skin = SKIN.format(name=name, constraint=constraint) if enriched else ""
    places = [f"{name},{s}" for s, ids in sorted(body.surface.sets.items()) if len(ids)]
    places += [f"{name}_bulk,{s}" for s in plain_sets(body)]
    supports = "".join(f"! FIX,{place}  1 1 1\n" for place in places or [f"{name},ALL"])
    inside = "" if enriched else constraint
    return DECK.format(
        name=name, arguments=arguments, skin=skin, inside=inside, supports=supports + "\n"
    )
