"""Result files (.vtkhdf, .pvd, .vtu) as VTK grids, one step at a time, with their Bezier cells intact."""

import pathlib
from xml.etree import ElementTree

import numpy as np

from post._error import Unreadable

#: Attributes that make VTK read a cell as a rational one of its own degrees in each direction.
BEZIER = ("RationalWeights", "HigherOrderDegrees")


def times_of(path):
    """Times of the steps in a result file: array (nstep); a .vtu file has one step at time 0."""
    return np.array([time for time, _ in _steps(pathlib.Path(path))], dtype=float)


def load(path, step="last"):
    """The grid at a step as (pyvista.UnstructuredGrid, time, number of the step, number of steps).

    step: 'last', 'first', a number counted from 1, or ('time', t) for the step nearest to t.
    """
    path = pathlib.Path(path)
    steps = _steps(path)
    i = _index(path, step, np.array([time for time, _ in steps], dtype=float))
    time, read = steps[i]
    grid = read()
    _activate(grid)
    if grid.n_cells == 0:
        raise Unreadable(f"'{path}' has no cells at step {i + 1}")
    return grid, float(time), i + 1, len(steps)


def _index(path, step, times):
    if step in ("last", "first"):
        return len(times) - 1 if step == "last" else 0
    if isinstance(step, tuple):
        return int(np.argmin(np.abs(times - step[1])))
    if not 1 <= int(step) <= len(times):
        raise Unreadable(f"'{path}' has steps 1 to {len(times)}, not {step}")
    return int(step) - 1


def _steps(path):
    """[(time, function that reads the grid)]"""
    if not path.is_file():
        raise Unreadable(f"'{path}' {'is not a regular file' if path.exists() else 'does not exist'}")
    readers = {".vtkhdf": _vtkhdf, ".pvd": _pvd, ".vtu": _vtu}
    if path.suffix not in readers:
        raise Unreadable(f"'{path}' is none of {' '.join(readers)}")
    steps = readers[path.suffix](path)
    if not steps:
        raise Unreadable(f"'{path}' holds no step")
    return steps


def _vtu(path):
    def read():
        import pyvista

        if not path.is_file():
            raise Unreadable(f"'{path}' does not exist")
        return pyvista.read(path)

    return [(0.0, read)]


def _pvd(path):
    try:
        sets = ElementTree.parse(path).getroot().iter("DataSet")
        return [(float(s.get("timestep", 0)), _vtu(path.parent / s.get("file"))[0][1]) for s in sets]
    except (ElementTree.ParseError, TypeError, ValueError):
        raise Unreadable(f"'{path}' is not a complete .pvd file") from None


def _vtkhdf(path):
    from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline as pipeline
    from vtkmodules.vtkIOHDF import vtkHDFReader

    from post._fields import read_fields

    read_fields(path)  # says in one sentence what is wrong with a broken file; VTK does not
    reader = vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    info = reader.GetOutputInformation(0)
    key = pipeline.TIME_STEPS()
    times = [info.Get(key, i) for i in range(info.Length(key))] or [0.0]

    def at(time):
        def read():
            import pyvista

            reader.UpdateTimeStep(time)
            data = reader.GetOutputDataObject(0)
            if data is not None and data.IsA("vtkPartitionedDataSet"):
                data = data.GetPartition(0)
            if data is None or not data.IsA("vtkUnstructuredGrid"):
                raise Unreadable(f"'{path}' does not hold an unstructured grid")
            return pyvista.UnstructuredGrid(data, deep=True)

        return read

    return [(time, at(time)) for time in times]


def _activate(grid):
    """Point VTK's attributes at the arrays of those names: readers before 9.7 leave that out."""
    from vtkmodules.vtkCommonDataModel import vtkDataSetAttributes as attributes

    kinds = (attributes.RATIONALWEIGHTS, attributes.HIGHERORDERDEGREES)
    for data, name, kind in zip((grid.GetPointData(), grid.GetCellData()), BEZIER, kinds):
        if data.HasArray(name):
            data.SetActiveAttribute(name, kind)
