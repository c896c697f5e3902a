"""Runs of decks with their curves and contact surfaces, for doc/verification/contact.md."""

import dataclasses
import json
import pathlib
import resource
import subprocess

import numpy as np

from post._table import read_table
from verification import TOP

FOLDER = TOP / "verification/contact"
TIME_LIMIT = 600


@dataclasses.dataclass
class Result:
    """The results of a run. code: exit code, or None if the run took too long; seconds: CPU
    seconds.
    """

    place: pathlib.Path
    stem: str
    code: int | None
    message: str
    seconds: float

    def curve(self, name):
        """{column: its values at the steps}"""
        return read_table(self.place / f"{self.stem}_{name}.dat").columns

    def report(self):
        return json.loads((self.place / f"{self.stem}.report.json").read_text())

    def surface(self, body, field="contact_pressure", n=9, step="last"):
        """Reference positions and values at the middles of n x n cells of each face of a body, and
        the areas of the cells.

        The shapes are (m, 3), (m,) and (m,). The values of a vector are its magnitudes. Bodies are
        numbered from 0 in the order of the deck.
        """
        from post import _grid
        from post._contact_faces import surfaces

        path = self.place / f"{self.stem}.vtkhdf"
        grid, _, _ = _grid.load(path, step)
        values = np.asarray(grid.point_data[field], dtype=float)
        if values.ndim == 2:
            values = np.linalg.norm(values, axis=1)
        side = surfaces(grid, path, values, n + 1)[body]
        corner = lambda a: 0.25 * (a[:, :-1, :-1] + a[:, 1:, :-1] + a[:, :-1, 1:] + a[:, 1:, 1:])
        x = corner(side.x)
        one = 0.5 * (side.x[:, 1:, 1:] - side.x[:, :-1, :-1])
        two = 0.5 * (side.x[:, :-1, 1:] - side.x[:, 1:, :-1])
        area = 2 * np.linalg.norm(np.cross(one, two), axis=-1)
        return x.reshape(-1, 3), corner(side.value).ravel(), area.ravel()


class Runner:
    """Runs decks one after another, each in a folder of its own below `out`."""

    def __init__(self, bezel, out):
        self.bezel, self.out = pathlib.Path(bezel).resolve(), pathlib.Path(out).resolve()

    def __call__(self, deck, **settings):
        """Run verification/contact/<deck>.inp with parameters; return the Result."""
        path = FOLDER / f"{deck}.inp"
        name = "-".join([deck.replace("/", "-"), *(f"{k}={v:g}" for k, v in settings.items())])
        place = self.out / name
        place.mkdir(parents=True, exist_ok=True)
        command = [str(self.bezel), "--quiet", "--threads", "1", "-o", str(place)]
        for key, value in settings.items():
            command += ["--set", f"{key}={value:.17g}"]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        try:
            done = subprocess.run([*command, str(path)], capture_output=True, text=True,
                                  timeout=TIME_LIMIT, stdin=subprocess.DEVNULL)  # fmt: skip
            code, message = done.returncode, " ".join(done.stderr.split())
        except subprocess.TimeoutExpired:
            code, message = None, f"took longer than {TIME_LIMIT} s"
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        return Result(place, path.stem, code, message, seconds)


def order(errors, sizes):
    """Observed orders of convergence between successive meshes; sizes: their numbers of elements
    per direction, increasing.

    >>> order([0.4, 0.1], [1, 2])
    [2.0]
    """
    return [
        float(np.log(abs(a / b)) / np.log(n / m))
        for a, b, m, n in zip(errors, errors[1:], sizes, sizes[1:], strict=False)
    ]


def table(heading, rows):
    """The lines of a Markdown table."""
    lines = [heading, ["---"] * len(heading), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines)
