"""The scalar that is to be drawn of a field, and its colours."""

import difflib

import numpy as np

from post import _grid
from post._error import Unreadable
from post._fields import COMPONENTS
from post._surface import GEOMETRY


def values(grid, path, name, component=None):
    """The scalar values (n) of an array of the grid, and whether they belong to points.

    component: a name in COMPONENTS, x y z, 'magnitude', or 'trace' of a tensor; None stands for the
    magnitude of a vector, or for the scalar itself.
    """
    for data, on_points in ((grid.point_data, True), (grid.cell_data, False)):
        if name in data and name not in GEOMETRY:
            return _component(np.asarray(data[name], dtype=float), path, name, component), on_points
    have = [n for d in (grid.point_data, grid.cell_data) for n in d if n not in GEOMETRY]
    raise Unreadable(f"'{path}' has no field '{name}' (fields: {' '.join(have)})")


def _component(array, path, name, component):
    if array.ndim == 1:
        if component is not None:
            raise Unreadable(f"'{name}' of '{path}' is a scalar and has no component '{component}'")
        return array
    n = array.shape[1]
    names = COMPONENTS.get(n, tuple(str(i) for i in range(1, n + 1)))
    component = _numbered(component)
    if component == "magnitude" or (component is None and n == 3):
        return np.linalg.norm(array, axis=1)
    if component == "trace" and n == 6:
        return array[:, :3].sum(axis=1)
    if component not in names:
        known = " ".join([*names, "magnitude", *(["trace"] if n == 6 else [])])
        raise Unreadable(f"choose a component of '{name}' with --component: {known}")
    return array[:, names.index(component)]


def _numbered(component):
    return {"x": "1", "y": "2", "z": "3"}.get(component, component)


def is_odd(component, axis):
    """Does a component of a vector or tensor change its sign in the mirror image across the plane
    where a coordinate (0 1 2) is zero?

    >>> [is_odd(c, 0) for c in ("x", "2", "11", "12", "23", "31", "trace", "magnitude", None)]
    [True, False, False, True, False, True, False, False, False]
    """
    return (_numbered(component) or "").count("123"[axis]) % 2 == 1


def colours(shown, limits=None, cmap=None):
    """Limits over all arrays, and a colour map: diverging, with symmetric limits, if the sign
    changes.

    >>> colours([np.array([0.0, 2.0]), np.array([1.0, 3.0])])
    ((0.0, 3.0), 'viridis')
    >>> colours([np.array([-1.0, 2.0])])
    ((-2.0, 2.0), 'RdBu_r')
    """
    if cmap is not None:
        import matplotlib

        if cmap not in matplotlib.colormaps:
            near = difflib.get_close_matches(cmap, list(matplotlib.colormaps), 1)
            hint = f"; did you mean '{near[0]}'?" if near else ""
            raise Unreadable(f"matplotlib has no colour map '{cmap}'{hint}")
    low = min(float(np.min(v)) for v in shown)
    high = max(float(np.max(v)) for v in shown)
    if not np.isfinite([low, high]).all():
        raise Unreadable("the field contains NaN or infinity")
    size = max(abs(low), abs(high))
    both_signs = low < -0.02 * size and high > 0.02 * size
    if limits is None:
        limits = (-size, size) if both_signs else (low, high)
        if limits[1] - limits[0] <= 1e-9 * size or size == 0:  # the same value everywhere
            limits = (low - (0.5 * size or 1.0), high + (0.5 * size or 1.0))
    return tuple(limits), cmap or (
        "RdBu_r" if limits[0] < 0 < limits[1] and both_signs else "viridis"
    )


def label(name, component=None):
    """The label of the colour bar.

    >>> label("displacement"), label("stress", "33"), label("mises")
    ('displacement, magnitude', 'stress 33', 'von Mises stress')
    """
    words = {"mises": "von Mises stress"}.get(name, name.replace("_", " "))
    if name == "displacement" and component in (None, "magnitude"):
        return f"{words}, magnitude"
    return f"{words} {component}" if component else words


def print_list(path, step):
    """Print the steps of a result file and the arrays at one of them."""
    grid, _, number = _grid.load(path, step)
    print(f"{path}: {grid.n_points} points, {grid.n_cells} cells")
    for i, time in _grid.steps_of(path):
        print(f"  step {i}: time {time:.6g}")
    for data, where in ((grid.point_data, "points"), (grid.cell_data, "cells")):
        for name in data:
            array = np.asarray(data[name], dtype=float)
            n = 1 if array.ndim == 1 else array.shape[1]
            print(
                f"  {name} ({where}, {n}): {array.min():.6g} to {array.max():.6g} at step {number}"
            )
