"""Draw contact surfaces from above, side by side: `python -m post contact-map RUN.vtkhdf`.

Both surfaces are drawn side by side in their deformed shape, coloured by a contact field, with the
edges of their elements, as in Figure 21 of Corbett and Sauer 2015. The lower surface is seen from
above and the upper one through its body, so that points in contact have the same position within
both drawings. As a library:

>>> import post
>>> post.contact_map.draw(["a.vtkhdf", "b.vtkhdf"], "fig.png", labels=["a", "b"])  # doctest: +SKIP
"""

import numpy as np

from post import _grid, _options, _scalar, _style
from post._contact_faces import surfaces
from post._error import Unreadable

#: Indices of the coordinates that point right and up in the picture, for each viewing direction.
PLANE = {"z": (0, 1), "x": (1, 2), "y": (2, 0)}
APART = 0.12  # gap between the drawings of the two surfaces, relative to their width
RIM = 0.35  # edges are drawn where normal . view exceeds this; nearer to the rim they look dashed


def draw(paths, output, scalar="contact_friction", component=None, step="last", limits=None,
         cmap=None, labels=None, axis="z", columns=2, edges=True, say_step=True,
         turn=False, words=None):  # fmt: skip
    """Draw the contact surfaces of result files, with one panel per file and one colour scale.

    component: component of a vector, by default 1 (x) for friction and traction; step: as in
    post._grid.load, or a list with one step for each file; axis: the viewing direction, seen from
    its positive end; turn: whether to turn the drawings by 90 degrees clockwise, for surfaces that
    are taller than wide; words: the label of the colour bar, by default the name of the field.
    Returns the limits of the colours.
    """
    if axis not in PLANE:
        raise Unreadable(f"unknown axis '{axis}'; known axes: x y z")
    if component is None and scalar in ("contact_friction", "contact_traction"):
        component = "1"
    steps = step if isinstance(step, (list, tuple)) else [step] * len(paths)
    panels = [_panel(p, scalar, component, s, axis, turn) for p, s in zip(paths, steps)]
    for panel, label in zip(panels, labels or [None] * len(panels)):
        if label:
            panel.caption = f"{label}, {panel.caption}" if say_step else label
    limits, cmap = _scalar.colours([v for p in panels for v in p.values()], limits, cmap)
    with _style.styled() as plt:
        words = words or _words(scalar, component)
        _compose(plt, panels, limits, cmap, words, columns, edges, output)
    return limits


class _panel:
    """Surfaces of one file, ready to be drawn."""

    def __init__(self, path, scalar, component, step, axis, turn=False):
        grid, time, number = _grid.load(path, step)
        values, on_points = _scalar.values(grid, path, scalar, component)
        if not on_points:
            raise Unreadable(f"'{scalar}' of '{path}' belongs to cells, not to the surface")
        if "displacement" not in grid.point_data:
            raise Unreadable(
                f"'{path}' has no displacement, so that deformed shapes cannot be drawn"
            )
        grid.points = np.asarray(grid.points, dtype=float) + grid.point_data["displacement"]
        self.right, self.up = PLANE[axis]
        self.upward = 1.0
        if turn:
            self.right, self.up, self.upward = self.up, self.right, -1.0
        self.out = "xyz".index(axis)
        # the upper body, whose surface faces down, is drawn on the left
        self.sides = sorted(surfaces(grid, path, values), key=self.facing)
        self.caption = f"step {number}, time {time:.4g}"

    def facing(self, surface):
        """Positive where a surface faces the viewer."""
        return np.sign(surface.outward[..., self.out].sum())

    def values(self):
        return [s.value for s in self.sides]

    def draw(self, ax, norm, cmap, edges):
        """Draw all sides on one pair of axes."""
        from matplotlib.collections import LineCollection

        start = 0.0
        for side in self.sides:
            sign = self.facing(side) or 1.0
            x, y = side.x[..., self.right], self.upward * side.x[..., self.up]
            shift = start - x.min()
            start += (x.max() - x.min()) * (1 + APART)
            flat = np.stack([x + shift, y], axis=-1)
            height = sign * side.x[..., self.out]
            length = np.linalg.norm(side.outward, axis=-1)
            towards = sign * side.outward[..., self.out] / np.where(length > 0, length, 1)
            used, triangles = _triangles(flat, height, towards > 0)
            # Colours are interpolated: small quadrilaterals, each of one colour, would let a
            # pattern of thin lines appear between them.
            ax.tripcolor(
                triangles,
                side.value.ravel()[used],
                norm=norm,
                cmap=cmap,
                shading="gouraud",
                rasterized=True,
            )
            if edges:
                lines = LineCollection(
                    _borders(flat, towards > RIM), colors="#1a1a1a", linewidths=0.5
                )
                ax.add_collection(lines)
        ax.set_aspect("equal")
        ax.set_axis_off()
        ax.set_title(self.caption, y=-0.02, va="top", pad=0)


def _corners(a):
    """(..., 4) values at the corners of the small quadrilaterals of (nface, n, n) values."""
    return np.stack([a[:, :-1, :-1], a[:, 1:, :-1], a[:, 1:, 1:], a[:, :-1, 1:]], axis=-1)


def _triangles(flat, height, seen):
    """(indices of the points used, triangles between them) of all faces that face the viewer, the
    farthest first.
    """
    from matplotlib.tri import Triangulation

    number = np.arange(height.size).reshape(height.shape)
    quads = _corners(number).reshape(-1, 4)[_corners(seen).any(axis=-1).ravel()]
    quads = quads[np.argsort(height.ravel()[quads].mean(axis=-1), kind="stable")]
    parts = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]], axis=1).reshape(-1, 3)
    used, parts = np.unique(parts, return_inverse=True)
    return used, Triangulation(*flat.reshape(-1, 2)[used].T, parts.reshape(-1, 3))


def _borders(flat, seen):
    """Segments of the edges of the faces that face the viewer."""
    pieces = []
    for f, s in zip(flat, seen):
        for line, visible in (
            (f[0], s[0]),
            (f[-1], s[-1]),
            (f[:, 0], s[:, 0]),
            (f[:, -1], s[:, -1]),
        ):
            both = _long_runs(visible[:-1] | visible[1:])
            pieces += [
                piece for piece, ok in zip(np.stack([line[:-1], line[1:]], axis=1), both) if ok
            ]
    return pieces


def _long_runs(seen):
    """(n) the mask without runs that are shorter than a quarter of the edge: at the rim of a round
    body they would look like stray strokes.

    >>> _long_runs(np.array([True, False, False, False, True, True, True, False])).astype(int).tolist()
    [0, 0, 0, 0, 1, 1, 1, 0]
    """
    ends = np.flatnonzero(np.diff(np.r_[False, seen, False]))
    kept = np.zeros_like(seen)
    for start, stop in ends.reshape(-1, 2):
        kept[start:stop] = 4 * (stop - start) >= len(seen)
    return kept


def _words(scalar, component):
    known = {
        "contact_friction": "tangential contact traction",
        "contact_traction": "contact traction",
    }
    words = known.get(scalar, scalar.replace("_", " "))
    if component in ("1", "2", "3"):
        return f"{words} $t_{'xyz'[int(component) - 1]}$"
    return _scalar.label(words, component)


def _compose(plt, panels, limits, cmap, words, columns, edges, output):
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    norm, columns = Normalize(*limits), min(columns, len(panels))
    rows = -(-len(panels) // columns)
    width = _style.PAGE if columns > 1 else 4.6
    figure, axes = plt.subplots(rows, columns, squeeze=False)
    for ax in axes.ravel()[len(panels) :]:
        ax.set_axis_off()
    for ax, panel in zip(axes.ravel(), panels):
        panel.draw(ax, norm, cmap, edges)
    sizes = _same_size(axes.ravel()[: len(panels)])
    height = 0.86 * width / columns * sizes[1] / sizes[0]
    figure.set_size_inches(width, rows * (height + 0.35))
    bar = figure.colorbar(ScalarMappable(norm, cmap), ax=axes.ravel().tolist(), aspect=24, pad=0.02)
    bar.set_label(words)
    bar.outline.set_linewidth(0.5)
    figure.set_dpi(200)
    _style.save(figure, output)


def _same_size(axes):
    """Give all panels one size, which is returned, in data: then they have one scale, and the captions
    of a row are at the same height.
    """
    boxes = [ax.dataLim for ax in axes]
    size = 1.02 * np.max([box.size for box in boxes], axis=0)
    for ax, box in zip(axes, boxes):
        middle = 0.5 * (box.min + box.max)
        ax.set_xlim(middle[0] - 0.5 * size[0], middle[0] + 0.5 * size[0])
        ax.set_ylim(middle[1] - 0.5 * size[1], middle[1] + 0.5 * size[1])
    return size


def main(argv):
    """Run the command; return its exit code."""
    p = _options.parser(
        prog="post contact-map", description="Draw contact surfaces from above, side by side."
    )
    p.add_argument("runs", nargs="+", metavar="RUN", help="RUN.vtkhdf, RUN.pvd or a .vtu file")
    p.add_argument("--step", default="last", help="last (default), first, or a step's number")
    p.add_argument(
        "--scalar",
        default="contact_friction",
        metavar="ARRAY",
        help="contact_friction (default), contact_traction, contact_pressure, contact_state, ...",
    )
    p.add_argument(
        "--component",
        help="1 2 3 or magnitude (default 1 of tractions, magnitude of other vectors)",
    )
    p.add_argument("--axis", default="z", help="viewing direction (default z)")
    p.add_argument(
        "--range", type=float, nargs=2, metavar=("LOW", "HIGH"), help="limits of the colours"
    )
    p.add_argument("--cmap", help="a colour map of matplotlib")
    p.add_argument(
        "--label", action="append", dest="labels", help="caption below a panel, one for each file"
    )
    p.add_argument(
        "--columns", type=int, default=2, help="number of panels side by side (default 2)"
    )
    p.add_argument("--no-edges", action="store_true", help="omit the edges of the elements")
    p.add_argument("-o", "--output", "--out", default="contact.png", metavar="FIG")
    o = p.parse_args(argv)
    if o.labels and len(o.labels) != len(o.runs):
        raise Unreadable(f"expected {len(o.runs)} labels, one for each file, found {len(o.labels)}")
    if o.columns < 1:
        raise Unreadable("--columns must be at least 1")
    step = _grid.step_of(o.step)
    draw(o.runs, o.output, o.scalar, o.component, step, o.range, o.cmap, o.labels, o.axis,
         o.columns, not o.no_edges)  # fmt: skip
    return 0
