"""Arrays of a `.vtkhdf` result file as tables, read without VTK."""

import pathlib
from dataclasses import dataclass

import numpy as np

from post._error import Unreadable
from post._table import Table

#: Names of the components of an array, by the number of components.
COMPONENTS = {3: ("1", "2", "3"), 6: ("11", "22", "33", "12", "23", "31")}
GROUPS = {"PointData": "point", "CellData": "cell"}


@dataclass
class Fields:
    """The contents of a result file.

    times: (nstep); numbers: (nstep) step numbers of the analysis, or 1, 2, ... if the file does not
    contain them; points: (npoint, 3) reference positions, or control points of spline cells;
    arrays: {name: (location, [nstep arrays of (n, ncomponent)])}, location 'point' or 'cell'.
    """

    path: pathlib.Path
    times: np.ndarray
    numbers: np.ndarray
    points: np.ndarray
    topology: dict
    arrays: dict


def read_fields(path):
    """Read the Fields of a .vtkhdf file (an unstructured grid in one partition, on a fixed mesh).

    >>> import post._fields
    >>> post._fields.read_fields("cube.vtkhdf").arrays["displacement"][1][-1].shape  # doctest: +SKIP
    (45, 3)
    """
    import h5py

    path = pathlib.Path(path)
    if not path.is_file():
        raise Unreadable(
            f"'{path}' {'is not a regular file' if path.exists() else 'does not exist'}"
        )
    try:
        with h5py.File(path, "r") as file:
            return _read(path, file)
    except OSError as error:
        raise Unreadable(
            f"'{path}' is not a readable HDF5 file (truncated?): {str(error).splitlines()[0]}"
        ) from None
    except (LookupError, ValueError, TypeError, AttributeError, RuntimeError, MemoryError) as error:
        raise Unreadable(f"'{path}' is not a complete VTKHDF file: {error}") from None


def _read(path, file):
    if "VTKHDF" not in file:
        raise Unreadable(f"'{path}' has no group VTKHDF")
    group = file["VTKHDF"]
    steps = group.get("Steps")
    nstep = int(np.ravel(steps.attrs["NSteps"])[0]) if steps is not None else 1
    times = steps["Values"][:nstep] if steps is not None else np.zeros(1)  # may be longer
    numbers = np.arange(1, nstep + 1)
    if steps is not None and "StepNumber" in steps:
        numbers = steps["StepNumber"][:nstep]
    if nstep == 0:
        raise Unreadable(f"'{path}' contains no steps")
    count = {"point": int(group["NumberOfPoints"][0]), "cell": int(group["NumberOfCells"][0])}
    arrays = {}
    for kind, location in GROUPS.items():
        for name, data in group.get(kind, {}).items():
            offsets = steps.get(f"{kind}Offsets/{name}") if steps is not None else None
            starts = offsets[()] if offsets is not None else np.zeros(len(times), int)
            arrays[name] = (location, _slices(data, starts[: len(times)], count[location], name))
    topology = {"Connectivity": group["Connectivity"][: int(group["NumberOfConnectivityIds"][0])]}
    topology["Types"] = group["Types"][: count["cell"]]
    return Fields(path, times, numbers, group["Points"][: count["point"]], topology, arrays)


def _slices(data, starts, n, name):
    """One (n, ncomponent) array per step; steps with the same offset share one array."""
    if len(data) < max(starts) + n:
        raise ValueError(f"array '{name}' has fewer values than the steps need")
    read = {int(s): data[int(s) : int(s) + n].reshape(n, -1) for s in set(starts.tolist())}
    return [read[int(s)] for s in starts]


def field_tables(path):
    """Tables of a result file for `diff`: steps, mesh, and one per array, with all steps stacked
    unless the array is the same in all steps.
    """
    fields = read_fields(path)
    mesh = lambda name, columns, label: Table(name, columns, fields.path, label=label)
    tables = [
        mesh("steps", {"step": fields.numbers.astype(float), "time": fields.times}, None),
        mesh("points", _columns("point", fields.points), lambda row: f"point {row}"),
    ]
    for name, values in fields.topology.items():
        tables.append(
            mesh(name.lower(), {name.lower(): values.astype(float)}, lambda row: f"entry {row}")
        )
    for name, (location, steps) in sorted(fields.arrays.items()):
        fixed = all(s is steps[0] for s in steps)
        values = steps[0] if fixed else np.concatenate(steps)
        tables.append(
            mesh(
                name, _columns(name, values), _label(location, len(steps[0]), fixed, fields.numbers)
            )
        )
    return tables


def _label(location, n, fixed, numbers):
    if fixed:
        return lambda row: f"{location} {row}"
    return lambda row: f"step {numbers[row // n]}, {location} {row % n}"


def _columns(name, values):
    """{name_component: (n)}: 'stress_11', or the bare name of a scalar."""
    n = values.shape[1]
    if n == 1:
        return {name: values[:, 0].astype(float)}
    names = COMPONENTS.get(n, range(1, n + 1))
    return {f"{name}_{c}": values[:, i].astype(float) for i, c in enumerate(names)}
