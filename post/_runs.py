"""The parts of a run on disk: a folder, a stem (`out/cube` for out/cube.report.json and others), or
a single file.
"""

import pathlib
import re

from post._error import Unreadable
from post._fields import field_tables
from post._report import read_report
from post._table import read_table

REPORT, FIELDS = ".report.json", ".vtkhdf"
SUFFIXES = (".dat", ".csv", ".json", FIELDS)
KINDS = ("report", "fields")  # the parts that are not curves


def parts(path):
    """{part: file} of a run: 'report', 'fields', and each curve by its name, with the ending `.dat`
    if the name is one of these two.

    In a folder with several runs the parts are called 'stem/part'. Another file of a folder has its
    whole name if its part would have that of a file of a run. A single file has one part: itself.
    """
    path = pathlib.Path(path)
    if path.is_file():
        if path.suffix not in SUFFIXES:
            raise Unreadable(f"'{path}' has an unknown ending; known endings: {' '.join(SUFFIXES)}")
        return {_part(path): path}
    folder = path if path.is_dir() else path.parent
    if not folder.is_dir():
        raise Unreadable(f"'{path}' does not exist")
    if path.is_dir():
        found = _of_folder(folder)
    else:
        longer = [s for s in _stems(folder) if s.startswith(path.name + "_")]
        others = {f for s in longer for f in _of_stem(folder, s).values()}
        found = {k: f for k, f in _of_stem(folder, path.name).items() if f not in others}
    if not found:
        what = "contains no" if path.is_dir() else "is not the stem of any"
        raise Unreadable(
            f"'{path}' {what} curve (.dat), report (.report.json) or field file (.vtkhdf)"
        )
    return found


def _of_stem(folder, stem):
    found = {}
    for kind, suffix in (("report", REPORT), ("fields", FIELDS)):
        if (folder / (stem + suffix)).is_file():
            found[kind] = folder / (stem + suffix)
    for file in sorted(folder.glob("*.dat")):
        if file.name.startswith(stem + "_"):
            name = file.stem[len(stem) + 1 :]
            found[f"{name}.dat" if name in KINDS else name] = file
    return found


def _stems(folder):
    """The stems of the runs in a folder, each of which has a report or a field file."""
    return sorted({f.name[: -len(s)] for s in (REPORT, FIELDS) for f in folder.glob("*" + s)})


def _of_folder(folder):
    stems = _stems(folder)
    taken, found = set(), {}
    for stem in sorted(stems, key=len, reverse=True):  # 'cube_2' before 'cube'
        own = {k: f for k, f in _of_stem(folder, stem).items() if f not in taken}
        taken.update(own.values())
        found.update({k if len(stems) == 1 else f"{stem}/{k}": f for k, f in own.items()})
    reported = _has_report(found.values())
    for pattern in ("*.dat", "*.csv", "*.json"):
        for file in sorted(folder.glob(pattern)):
            if file not in taken:
                part = file.name if reported and file.suffix == ".json" else _part(file)
                found[file.name if part in found else part] = file
    return found


def _has_report(files):
    return any(f.name.endswith(REPORT) for f in files if f is not None)


def _part(file):
    """The part that a file is by its own name.

    >>> [_part(pathlib.Path(p)) for p in ("cube.report.json", "force.csv", "report.csv")]
    ['report', 'force', 'report.dat']
    """
    return _kind(file.name) or (f"{file.stem}.dat" if file.stem in KINDS else file.stem)


def no_curve(part):
    """Whether a part, which may be called 'stem/part', is a report or fields.

    >>> no_curve("cube/report"), no_curve("report.dat")
    (True, False)
    """
    return part.split("/")[-1] in KINDS


def not_of_a_run(matched):
    """The parts that are .json files beside the report of a run, such as that of `post mesh`."""
    files = {part: [f for f in both if f is not None] for part, *both in matched}
    if not _has_report(f for both in files.values() for f in both):
        return []
    return [n for n, both in files.items() if both[0].suffix == ".json" and not no_curve(n)]


def _kind(name):
    """'report' or 'fields' from the name of the file, None for a curve.

    >>> _kind("cube.report.json"), _kind("ref.json"), _kind("a.vtkhdf"), _kind("a_force.dat")
    ('report', 'report', 'fields', None)
    """
    suffix = pathlib.Path(name).suffix
    return {".json": "report", FIELDS: "fields"}.get(suffix)


def matched(a, b):
    """The parts of two runs side by side: [(part, file of a or None, file of b or None)].

    If `b` is a single file, the part of `a` is chosen by the type and the name of that file.
    """
    in_a, in_b = parts(a), parts(b)
    if len(in_b) == 1 and pathlib.Path(b).is_file() and list(in_a) != list(in_b):
        name, file = next(iter(in_b.items()))
        return [(name, _partner(a, in_a, file), file)]
    names = list(in_b) + [n for n in in_a if n not in in_b]
    return [(n, in_a.get(n), in_b.get(n)) for n in names]


def _partner(a, in_a, reference):
    """The part of a run to which a single reference file belongs."""
    kind = _kind(reference.name)
    pool = {n: f for n, f in in_a.items() if _kind(f.name) == kind}
    named = [f for n, f in pool.items() if f.name == reference.name]
    named = named or [
        f
        for n, f in pool.items()
        if re.search(rf"(^|_){re.escape(n.split('/')[-1])}$", reference.stem)
    ]
    named = named or [f for n, f in pool.items() if no_curve(n)]
    found = named if named else list(pool.values())
    if len(found) != 1:
        what = {"report": "report", "fields": "field file"}.get(kind, "curve")
        have = f"several could: {' '.join(pool)}" if pool else f"there is no {what}"
        raise Unreadable(f"cannot tell which {what} of '{a}' matches '{reference}': {have}")
    return found[0]


def tables(file):
    """The tables of a file of any type."""
    kind = _kind(file.name)
    if kind == "report":
        return [read_report(file)]
    if kind == "fields":
        return field_tables(file)
    return [read_table(file)]
