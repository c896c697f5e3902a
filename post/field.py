"""Render a field of a result file without a screen: `python -m post field RUN.vtkhdf --scalar
mises`.

Bezier cells are drawn as smooth surfaces, deformed by the displacement, with the edges of the
elements and the outline of the undeformed body. As a library:

>>> import post
>>> post.field.draw(["a.vtkhdf", "b.vtkhdf"], "fig.png", scalar="stress", component="33")  # doctest: +SKIP
"""

import numpy as np

from post import _grid, _options, _picture, _scalar, _surface
from post._error import Unreadable
from post._screen import prepare

#: Directions from the body to the camera, and the upward direction.
VIEWS = {
    "iso": ((1.0, -1.5, 0.8), (0, 0, 1)), "back": ((-1.0, 1.5, 0.8), (0, 0, 1)), "below": ((1.0, -1.5, -0.8), (0, 0, 1)),
    "+x": ((1, 0, 0), (0, 0, 1)), "-x": ((-1, 0, 0), (0, 0, 1)), "+y": ((0, 1, 0), (0, 0, 1)),
    "-y": ((0, -1, 0), (0, 0, 1)), "+z": ((0, 0, 1), (0, 1, 0)), "-z": ((0, 0, -1), (0, 1, 0)),
}  # fmt: skip


def draw(paths, output, scalar="displacement", component=None, step="last", warp=1.0, view="iso",
         limits=None, cmap=None, labels=None, edges=True, outline=True, level=None, size=(1400, 1200),
         mirror="", say_step=True, words=None, bodies=None, frame=None):  # fmt: skip
    """Draw one result file, or several side by side with one colour scale, into the file `output`.

    step: as in post._grid.load, or a list with one step for each path; component: 1 2 3, 11 22 33
    12 23 31, magnitude or trace; view: a key of VIEWS or 'azimuth,elevation' in degrees; limits:
    (low, high) of the colours; size: pixels of one panel; mirror: letters of 'xyz' if the model is
    part of a body that is symmetric about the planes where these coordinates are zero; say_step:
    whether the caption of a labelled panel also gives the step; words: the label of the colour bar,
    by default the name of the field; bodies: numbers of the bodies to draw, by default all; frame:
    (xmin, xmax, ymin, ymax, zmin, zmax) of a box that fills the picture, for a close-up. `warp` may
    be a list, too. With the scalar 'body' the bodies are grey and there is no colour bar. Returns
    the limits of the colours.
    """
    prepare()
    steps = step if isinstance(step, list) else [step] * len(paths)
    warps = warp if isinstance(warp, list) else [warp] * len(paths)
    shown = [
        _scene(p, scalar, component, s, w, edges, outline, level, bodies)
        for p, s, w in zip(paths, steps, warps)
    ]
    for scene, label in zip(shown, labels or [None] * len(shown)):
        _mirror(scene, mirror, component)
        if label:
            scene.caption = f"{label}, {scene.caption}" if say_step else label
    plain = scalar == "body"
    values = [s.surface["shown"] for s in shown]
    if plain:
        limits, cmap = _picture.greys(int(max(v.max() for v in values)))
    else:
        limits, cmap = _scalar.colours(values, limits, cmap)
    camera = _camera(view)
    images = _picture.render(shown, limits, cmap, camera, size, frame)
    words = None if plain else words or _scalar.label(scalar, component)
    _picture.compose(images, shown, limits, cmap, words, output)
    return limits


def _scene(path, scalar, component, step, warp, edges, outline, level, bodies=None):
    grid, time, number = _grid.load(path, step)
    if bodies is not None:
        numbers, _ = _scalar.values(grid, path, "body")
        grid = grid.extract_cells(np.isin(numbers, bodies))
    values, on_points = _scalar.values(grid, path, scalar, component)
    (grid.point_data if on_points else grid.cell_data)["shown"] = values
    undeformed = _surface.outline(grid) if outline else None
    if warp:
        if "displacement" not in grid.point_data:
            raise Unreadable(
                f"'{path}' has no displacement with which to deform the body; use --warp 0"
            )
        grid.points = np.asarray(grid.points, dtype=float) + warp * grid.point_data["displacement"]
    caption = f"step {number}, time {time:.4g}" + (
        f", displacements x {warp:g}" if warp not in (0, 1) else ""
    )
    lines = _surface.edges(grid, level) if edges else None
    return _picture.Scene(_surface.surface(grid, level), lines, undeformed, caption)


def _mirror(scene, letters, component):
    for letter in letters:
        axis = "xyz".index(letter)
        scene.mirror(axis, _scalar.is_odd(component, axis))


def _camera(view):
    """(direction towards the camera, upward direction)"""
    if view in VIEWS:
        return VIEWS[view]
    try:
        azimuth, elevation = (np.radians(float(v)) for v in view.split(","))
    except ValueError:
        raise Unreadable(
            f"unknown view '{view}'; known views: {' '.join(VIEWS)}, or azimuth,elevation in degrees"
        ) from None
    direction = (
        np.cos(elevation) * np.cos(azimuth),
        np.cos(elevation) * np.sin(azimuth),
        np.sin(elevation),
    )
    return direction, ((0, 0, 1) if abs(np.cos(elevation)) > 1e-3 else (0, 1, 0))


def main(argv):
    """Run the command; return its exit code."""
    o = _parser().parse_args(_joined(argv))
    paths = [o.run] + (o.beside or [])
    if o.labels and len(o.labels) != len(paths):
        raise Unreadable(f"expected {len(paths)} labels, one for each file, found {len(o.labels)}")
    step = ("time", o.time) if o.time is not None else _grid.step_of(o.step)
    if o.list:
        _scalar.print_list(o.run, step)
        return 0
    labels = o.labels or (
        [p.rsplit("/", 1)[-1].rsplit(".", 1)[0] for p in paths] if len(paths) > 1 else None
    )
    draw(paths, o.output, o.scalar, o.component, step, o.warp, o.view, o.range, o.cmap, labels,
         not o.no_edges, not o.no_outline, o.level, tuple(o.size), o.mirror)  # fmt: skip
    return 0


def _joined(argv):
    """The arguments, with `--view -y` joined into one, because here -y and -52,16 are views, not
    options.

    >>> _joined(["a.vtkhdf", "--view", "-y"])
    ['a.vtkhdf', '--view=-y']
    """
    joined = []
    for argument in argv:
        if joined and joined[-1] == "--view":
            joined[-1] = f"--view={argument}"
        else:
            joined.append(argument)
    return joined


def _parser():
    p = _options.parser(
        prog="post field", description="Render a field of a result file without a screen."
    )
    p.add_argument("run", help="a RUN.vtkhdf, RUN.pvd or .vtu file")
    p.add_argument(
        "--beside",
        action="append",
        metavar="RUN2",
        help="another result file to draw beside it, on the same colour scale; may be repeated",
    )
    p.add_argument("--step", default="last", help="last (default), first, or a step number")
    p.add_argument("--time", type=float, help="draw the step nearest to this time")
    p.add_argument(
        "--scalar",
        default="displacement",
        metavar="ARRAY",
        help="displacement (default), mises, stress, ...",
    )
    p.add_argument(
        "--component",
        help="1 2 3 of a vector, 11 22 33 12 23 31 or trace of a tensor (default the magnitude of a vector)",
    )
    p.add_argument(
        "--warp",
        type=float,
        default=1.0,
        help="factor by which displacements are magnified (default 1)",
    )
    p.add_argument(
        "--view",
        default="iso",
        help=f"{' '.join(VIEWS)}, or azimuth,elevation in degrees (default iso)",
    )
    p.add_argument(
        "--range", type=float, nargs=2, metavar=("LOW", "HIGH"), help="limits of the colours"
    )
    p.add_argument(
        "--cmap", help="a matplotlib colour map (default viridis, or RdBu_r if the sign changes)"
    )
    p.add_argument(
        "--label",
        action="append",
        dest="labels",
        help="caption below a panel, given once for each file",
    )
    p.add_argument(
        "--mirror",
        default="",
        choices=[a + b + c for a in ("", "x") for b in ("", "y") for c in ("", "z")],
        metavar="xyz",
        help="coordinates, such as xz: add mirror images across the planes where they are zero",
    )
    p.add_argument("--no-edges", action="store_true", help="omit the edges of the elements")
    p.add_argument(
        "--no-outline", action="store_true", help="omit the outline of the undeformed body"
    )
    p.add_argument(
        "--level",
        type=int,
        choices=range(7),
        help="divide curved faces into 2^LEVEL parts per direction (default by their number, at most 4)",
    )
    p.add_argument(
        "--size",
        type=int,
        nargs=2,
        default=(1400, 1200),
        metavar=("W", "H"),
        help="size of a panel in pixels",
    )
    p.add_argument("--list", action="store_true", help="print the steps and arrays, draw nothing")
    p.add_argument(
        "-o",
        "--output",
        default="field.png",
        metavar="FIG",
        help=".png, .pdf or .svg (default field.png)",
    )
    return p
