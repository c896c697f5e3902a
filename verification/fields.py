"""Compare a field of a result file with an exact field that is constant or linear in the reference
position.
"""

import numpy as np

from post._error import Unreadable
from post._expect import tolerance_of
from post._fields import read_fields
from verification.checks import Row


def field_row(case, quantity, path, check):
    """The row for the worst point of a field, compared with `want` (one value per component) or
    with `affine` (the rows of A, or of [A b], where the field is A x + b).

    A linear function of the position has the same form at control points as at nodes, whatever the
    weights are. A scaled tolerance refers to the largest magnitude of the exact field.
    """
    fields = read_fields(path)
    if check["field"] not in fields.arrays:
        raise Unreadable(
            f"'{path}' has no field '{check['field']}' (fields: {' '.join(fields.arrays)})"
        )
    location, steps = fields.arrays[check["field"]]
    got = steps[_step(check.get("row", "last"), fields.numbers)] * check.get("factor", 1.0)
    want = _exact(check, fields.points, len(got), location)
    if want.shape != got.shape:
        raise Unreadable(
            f"'{check['field']}': expected {want.shape[1]} components, found {got.shape[1]}"
        )
    tolerance = tolerance_of(check)
    if tolerance is None:
        raise Unreadable("a check of a field needs one of the keys abs, scaled and rel")
    difference = np.where(np.isfinite(got), np.abs(got - want), np.inf)
    allowed = tolerance.allowed(want, np.abs(want).max())
    i, j = np.unravel_index(np.argmax(difference), got.shape)
    where = f"{quantity} ({len(got)} {location}s, worst {i}, component {j + 1})"
    return Row(
        case,
        where,
        float(got[i, j]),
        float(want[i, j]),
        float(difference[i, j]),
        str(tolerance),
        bool((difference <= allowed).all()),
    )


def _exact(check, points, n, location):
    if "affine" in check:
        if location != "point":
            raise Unreadable("`affine` applies to fields on points only")
        matrix = np.array(check["affine"], dtype=float)
        offset = matrix[:, 3] if matrix.shape[1] == 4 else 0.0
        return points @ matrix[:, :3].T + offset
    if "want" not in check:
        raise Unreadable("a check of a field needs the key `want` or `affine`")
    return np.tile(np.atleast_1d(np.array(check["want"], dtype=float)), (n, 1))


def _step(row, numbers):
    if row in ("last", "first"):
        return -1 if row == "last" else 0
    found = np.flatnonzero(numbers == row)
    if len(found) == 0:
        raise Unreadable(f"the result file has no step {row}")
    return found[0]
