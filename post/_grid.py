"""Read result files (.vtkhdf, .pvd, .vtu), one step at a time, as VTK grids of Bezier cells."""

import pathlib
import re
from xml.etree import ElementTree

from post._error import Unreadable

#: Attributes from which VTK takes the weights of a rational cell and its degree in each direction.
BEZIER = ("RationalWeights", "HigherOrderDegrees")
#: Name of a .vtu file of the program: the stem and the step of the analysis.
NUMBERED = re.compile(r"(.+)_(\d+)\.vtu$")


def steps_of(path):
    """Steps of a result file: a list of (step number in the analysis, time)."""
    return [(number, time) for number, time, _ in _steps(pathlib.Path(path))]


def load(path, step="last"):
    """The grid at a step as (pyvista.UnstructuredGrid, time, number of the step).

    step: 'last', 'first', a step number of the analysis (or 1, 2, ... if the file does not contain
    step numbers), or ('time', t) for the step nearest to time t.
    """
    path = pathlib.Path(path)
    number, time, read = _choose(path, step, _steps(path))
    grid = read()
    _activate(grid)
    if grid.n_cells == 0:
        raise Unreadable(f"'{path}' has no cells at step {number}")
    return grid, time, number


def step_of(text):
    """Convert a step given on the command line to the form that `load` takes.

    >>> step_of("last"), step_of("7")
    ('last', 7)
    """
    if text in ("last", "first"):
        return text
    try:
        return int(text)
    except ValueError:
        raise Unreadable(f"'{text}' is not a step; give a step number, 'first' or 'last'") from None


def _choose(path, step, steps):
    if step in ("last", "first"):
        return steps[-1] if step == "last" else steps[0]
    if isinstance(step, tuple):
        return min(steps, key=lambda s: abs(s[1] - step[1]))
    found = [s for s in steps if s[0] == int(step)]
    if not found:
        have = ", ".join(str(s[0]) for s in steps[:8]) + (", ..." if len(steps) > 8 else "")
        raise Unreadable(f"'{path}' has no step {step} (steps: {have})")
    return found[0]


def _steps(path):
    """[(number, time, function that reads the grid)]"""
    if not path.is_file():
        raise Unreadable(
            f"'{path}' {'is not a regular file' if path.exists() else 'does not exist'}"
        )
    readers = {".vtkhdf": _vtkhdf, ".pvd": _pvd, ".vtu": _vtu}
    if path.suffix not in readers:
        raise Unreadable(f"'{path}' has an unknown ending; known endings: {' '.join(readers)}")
    steps = readers[path.suffix](path)
    if not steps:
        raise Unreadable(f"'{path}' contains no steps")
    return steps


def _vtu(path):
    return [(*_of_vtu(path), _reader(path))]


def _reader(path):
    def read():
        import pyvista

        if not path.is_file():
            raise Unreadable(f"'{path}' does not exist")
        return pyvista.read(path)

    return read


def _of_vtu(path):
    """Step and time of a .vtu file of the program: the step from its name, and the time from the
    .pvd beside it that lists it; step 1 and time 0 of any other file.
    """
    named = NUMBERED.match(path.name)
    if not named:
        return 1, 0.0
    series = path.with_name(named[1] + ".pvd")
    try:
        sets = ElementTree.parse(series).getroot().iter("DataSet")
        times = [float(s.get("timestep", 0)) for s in sets if s.get("file") == path.name]
    except (OSError, ElementTree.ParseError, TypeError, ValueError):
        times = []
    return int(named[2]), times[0] if times else 0.0


def _pvd(path):
    try:
        sets = list(ElementTree.parse(path).getroot().iter("DataSet"))
        files = [s.get("file") for s in sets]
        # the files of the program end with the step of the analysis
        named = [NUMBERED.match(file) for file in files]
        return [
            (int(named[i][2]) if all(named) else i + 1, float(s.get("timestep", 0)),
             _reader(path.parent / file))
            for i, (s, file) in enumerate(zip(sets, files))
        ]  # fmt: skip
    except (ElementTree.ParseError, TypeError, ValueError):
        raise Unreadable(f"'{path}' is not a complete .pvd file") from None


def _vtkhdf(path):
    from vtkmodules.vtkIOHDF import vtkHDFReader

    from post._fields import read_fields

    fields = read_fields(
        path
    )  # says in one sentence what is wrong with a broken file, which VTK does not
    reader = vtkHDFReader()
    reader.SetFileName(str(path))

    reader.UpdateInformation()

    def at(step):
        def read():
            import pyvista

            # not by its time: VTK would take another step where times repeat or decrease
            reader.SetStep(step)
            reader.Update()
            data = reader.GetOutputDataObject(0)
            if data is not None and data.IsA("vtkPartitionedDataSet"):
                data = data.GetPartition(0)
            if data is None or not data.IsA("vtkUnstructuredGrid"):
                raise Unreadable(f"'{path}' does not contain an unstructured grid")
            return pyvista.UnstructuredGrid(data, deep=True)

        return read

    return [(int(n), float(t), at(i)) for i, (n, t) in enumerate(zip(fields.numbers, fields.times))]


def _activate(grid):
    """Activate the arrays named in BEZIER as VTK's attributes, because readers before version 9.7 do
    not.
    """
    from vtkmodules.vtkCommonDataModel import vtkDataSetAttributes as attributes

    kinds = (attributes.RATIONALWEIGHTS, attributes.HIGHERORDERDEGREES)
    for data, name, kind in zip((grid.GetPointData(), grid.GetCellData()), BEZIER, kinds):
        if data.HasArray(name):
            data.SetActiveAttribute(name, kind)
