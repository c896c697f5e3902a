"""Choose parts of a surface by boxes, cylinders, spheres, directions, distances or sets of the
file.
"""

import numpy as np

from post._error import Unreadable
from post.mesh import _surface

KINDS = {
    "box": (6, "box:x1,y1,z1,x2,y2,z2"),
    "cylinder": (7, "cylinder:px,py,pz,ax,ay,az,radius"),
    "sphere": (4, "sphere:x,y,z,radius"),
    "normal": (4, "normal:nx,ny,nz,degrees"),
    "distance": (4, "distance:x,y,z,d"),
}


def elements(surface, text):
    """(m, bool) whether an element is chosen by `text`: & joins conditions, + joins alternatives.

    An element belongs to a box, cylinder (inside its radius), sphere or distance if its centre
    does, and to a normal if the outward normal at its centre is within the angle.
    """
    result = np.zeros(len(surface.nodes), dtype=bool)
    for part in text.split("+"):
        both = np.ones(len(surface.nodes), dtype=bool)
        for one in part.split("&"):
            both &= _one(surface, one.strip())
        result |= both
    return result


def _one(surface, text):
    kind, _, rest = text.partition(":")
    if kind == "all":
        return np.ones(len(surface.nodes), dtype=bool)
    if kind == "set":
        if rest not in surface.sets:
            known = " ".join(sorted(surface.sets)) or "none"
            raise Unreadable(f"the file has no set '{rest}'; known sets: {known}")
        return np.isin(np.arange(len(surface.nodes)), surface.sets[rest])
    if kind not in KINDS:
        known = ", ".join(form for _, form in KINDS.values())
        raise Unreadable(
            f"'{text}' is not a choice of elements; known forms: all, set:name, {known}"
        )
    count, form = KINDS[kind]
    try:
        v = np.array([float(w) for w in rest.split(",")])
    except ValueError:
        v = np.empty(0)
    if len(v) != count or not np.isfinite(v).all():
        raise Unreadable(f"'{text}': expected {count} numbers, in the form {form}")
    zero = np.zeros(1)
    x, a, b = (y[:, 0] for y in _surface.evaluate(surface.bezier(), surface.degree, zero, zero))
    if kind == "box":
        return ((x >= np.minimum(v[:3], v[3:])) & (x <= np.maximum(v[:3], v[3:]))).all(axis=1)
    if kind == "normal":
        return _surface.unit(-np.cross(a, b)) @ _surface.unit(v[:3]) >= np.cos(np.radians(v[3]))
    away = x - v[:3]
    if kind == "cylinder":
        axis = _surface.unit(v[3:6])
        away = away - np.outer(away @ axis, axis)
    return np.linalg.norm(away, axis=1) <= v[-1]


def named(surface, texts):
    """Add the sets given as name=choice to the surface."""
    for text in texts:
        name, equals, choice = text.partition("=")
        if not equals or not name.isidentifier():
            raise Unreadable(f"'{text}' is not of the form name=choice, as in hole=box:0,0,0,1,1,1")
        if name == "plain":
            raise Unreadable(
                "the name 'plain' is reserved for the faces that --enrich leaves plain"
            )
        if name in surface.sets:
            raise Unreadable(
                f"'{text}': there is a group '{name}' already; choose another name, or join choices with + as in {name}_2=set:{name}+box:0,0,0,1,1,1"
            )
        chosen = elements(surface, choice)
        if not chosen.any():
            raise Unreadable(f"'{text}' selects no element of the surface")
        surface.sets[name] = np.flatnonzero(chosen)
