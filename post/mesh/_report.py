"""Report on a body: counts, volumes, shapes, self-intersections and jumps of normals."""

import json

import numpy as np

from post.mesh import _body, _pyramids, _quality, _smooth, _surface, _triangles


def describe(body):
    """{entry: value} with numbers and dictionaries, ready for JSON."""
    whole, form = body.whole, body.form
    part = _body.volumes(body)
    total, wanted = sum(part.values()), _body.enclosed(body)
    report = {
        "counts": _counts(body),
        "area": float(_surface.measures(whole)[0]),
        "volume": {**part, "sum": total, "surface_integral": wanted},
        "layer": _quality.layer(body.surface, body.points),
        "height": {"least": float(form.height.min()), "largest": float(form.height.max())},
        "normals": normal_jumps(whole),
    }
    plain = 0 if body.plain is None else len(body.plain)
    if body.cells["pyramids"].size or body.cells["tets"].size or len(body.cells["hexes"]) > plain:
        report["volume"]["relative_difference"] = abs(total - wanted) / abs(wanted)
    report["self_intersections"] = inner_cuts(body)
    report |= _cells(body)
    if body.mesher:
        report["mesher"] = body.mesher
    return report


def _counts(body):
    s = body.surface
    unknown = len(body.points) - len(body.hanging) - len(body.ties) + len(s.points)
    return {
        "elements": len(s.nodes), "control_points": len(s.points), "bulk_points": len(body.points),
        **{kind: len(cells) for kind, cells in body.cells.items()},
        "hanging": len(body.hanging), "ties": len(body.ties),
        "extraordinary": len(_smooth.extraordinary(body.whole)), "dofs": 3 * unknown,
    }  # fmt: skip


def _cells(body):
    result = {}
    x, cells = body.points, body.cells
    if len(cells["pyramids"]):
        volume, quality = _quality.pyramids(x, cells["pyramids"])
        result["pyramids"] = {"volume": float(volume.min()), "scaled": float(quality.min())}
    if len(cells["tets"]):
        volume, angle, quality = _quality.tets(x, cells["tets"])
        result["tets"] = {
            "volume": float(volume.min()), "scaled": float(quality.min()),
            "dihedral_least": float(angle.min()), "dihedral_largest": float(angle.max()),
        }  # fmt: skip
    if len(cells["hexes"]):
        jac = _quality.hex_jacobians(x, cells["hexes"], _quality.SIGN)
        result["hexes"] = {"det_corner": float(np.linalg.det(jac).min()),
                           "scaled": float(_quality.scaled(jac).min())}  # fmt: skip
    return result


def inner_cuts(body):
    """Number of intersecting pairs of triangles on the inner side of the layer."""
    splits = {(a, b): s for s, (a, b, _) in body.whole.hanging.items()}
    middle = body.points[body.whole.corners].mean(axis=1)
    n = len(body.points)
    cells = np.column_stack([body.whole.corners, n + np.arange(len(middle))])
    triangles, _ = _pyramids.sides(
        cells, splits
    )  # each face as a fan of triangles about its centre
    return len(_triangles.intersections(np.concatenate([body.points, middle]), triangles))


def normal_jumps(s):
    """Largest angles between normals across common edges and at corners [degrees], and the number of
    edges at which the angle exceeds one degree (counted from both sides).
    """
    from post.mesh._net import twins

    t = np.linspace(-0.98, 0.98, 9)
    one = np.ones_like(t)
    edges = [(t, -one), (one, t), (-t, one), (-one, -t)]
    bezier = s.bezier()
    normal = [np.cross(*_surface.evaluate(bezier, s.degree, *edge)[1:]) for edge in edges]
    normal = _surface.unit(np.stack(normal, axis=1))
    twin = twins(s.corners)
    q, c = np.nonzero(twin >= 0)
    mine, other = normal[q, c], normal[twin[q, c] // 4, twin[q, c] % 4][:, ::-1]
    sine = np.linalg.norm(np.cross(mine, other), axis=-1)
    angle = np.degrees(np.arctan2(sine, np.einsum("kpc,kpc->kp", mine, other)))
    return {
        "edges": float(angle.max(initial=0.0)),
        "corners": float(np.degrees(_surface.corner_normals(s)[1].max())),
        "edges_over_1_degree": int((angle.max(axis=1, initial=0.0) > 1).sum()),
    }


def text(report):
    """The report as readable lines."""
    lines = []
    for key, value in report.items():
        if isinstance(value, dict):
            lines += [f"{key + ' ' + name:36}{_number(v)}" for name, v in value.items()]
        else:
            lines.append(f"{key:36}{_number(value)}")
    return "\n".join(line.replace("_", " ") for line in lines)


def _number(v):
    return f"{v}" if isinstance(v, (int, str)) else f"{v:.6g}"


def bad(report):
    """Sentences that say why the body is unfit for a run; empty if it is fit."""
    found = []
    if report["layer"] and min(report["layer"]["det_gauss"], report["layer"]["det_corner"]) <= 0:
        found.append("an element of the layer is inverted")
    for kind in ("pyramids", "tets", "hexes"):
        if kind in report and report[kind]["scaled"] <= 0:
            found.append(f"one of the {kind} is inverted")
    if report["self_intersections"]:
        found.append(
            f"the inner side of the layer intersects itself {report['self_intersections']} times"
        )
    if report["volume"].get("relative_difference", 0) > 1e-10:
        found.append("the volumes of the parts do not add up to the volume inside the surface")
    return found


def write(report, path):
    """Write the report as JSON."""
    path.write_text(json.dumps(report, indent=2) + "\n")
