"""Pictures of a body: its surface and, cut open, its layer, the cells inside and the whole body."""

import numpy as np

from post import _style
from post._picture import cropped, unit
from post.mesh import _layer, _surface

FINE = 5  # number of points along an edge of a drawn element
COLOURS = {"outer": "#c9d7e8", "side": "#e3b778", "inner": "#9aa7b5", "pyramids": "#8fb58a",
           "tets": "#d9d2c5", "hexes": "#d9d2c5"}  # fmt: skip
FACES = {
    "tets": ((0, 1, 2), (0, 3, 1), (1, 3, 2), (0, 2, 3)),
    "pyramids": ((0, 1, 2, 3), (0, 4, 1), (1, 4, 2), (2, 4, 3), (3, 4, 0)),
    "hexes": ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
}


def draw(body, stem, direction=None, cut=None):
    """Write STEM_surface.png and STEM_cut.png (four panels, as in Figure 6 of Corbett and
    Sauer 2015); return the names of both.

    direction: from the body to the camera; cut: normal of the cutting plane through the centre, by
    default along the shortest side of the bounding box. The part to which the normal points is cut
    away.
    """
    from post._screen import prepare

    prepare()
    box = np.ptp(body.points, axis=0)
    cut = np.eye(3)[np.argmin(box)] if cut is None else np.asarray(cut, dtype=float)
    direction = unit(cut) + 0.45 * np.array([0.6, -0.8, 0.5]) if direction is None else direction
    compose([([surface_part(body.whole)], "")], direction, f"{stem}_surface.png")
    compose(panels(body, cut), direction, f"{stem}_cut.png", columns=2)
    return [f"{stem}_surface.png", f"{stem}_cut.png"]


def panels(body, cut):
    """[(parts, caption)] of the four panels of Figure 6."""
    centre = 0.5 * (body.points.min(axis=0) + body.points.max(axis=0))
    keep = lambda x: (x - centre) @ unit(cut) <= 0  # noqa: E731
    middle = body.surface.corner_points()[body.surface.corners].mean(axis=1)
    chosen = keep(middle) if len(middle) else np.empty(0, dtype=bool)
    skin = surface_part(body.surface, chosen)
    layer = layer_parts(body, chosen)
    inside = [cell_part(body, kind, keep) for kind in ("hexes", "pyramids", "tets")]
    inside = [part for part in inside if part]
    return [
        ([skin], "(a) spline surface, cut"), (layer, "(b) enriched elements below it"),
        (inside, "(c) linear elements inside"), (layer + inside, "(d) the whole model"),
    ]  # fmt: skip


def surface_part(surface, chosen=None):
    """(polygons, edges, colour) of the elements of the surface."""
    chosen = slice(None) if chosen is None else chosen
    bezier = surface.bezier()[chosen]
    t = np.linspace(-1, 1, FINE)
    xi, eta = (v.ravel() for v in np.meshgrid(t, t))
    x = _surface.evaluate(bezier, surface.degree, xi, eta, order=0)[0]
    return *patches(x), COLOURS["outer"]


def layer_parts(body, chosen):
    """(polygons, edges, colour) for the outer, inner and side faces of the elements of the
    layer.
    """
    s = body.surface
    t = np.linspace(-1, 1, FINE)
    a, b = (v.ravel() for v in np.meshgrid(t, t))
    one = np.ones_like(a)
    faces = {"outer": [(a, b, -one)], "inner": [(a, b, one)],
             "side": [(a, -one, b), (a, one, b), (-one, a, b), (one, a, b)]}  # fmt: skip
    bezier, corners = s.bezier()[chosen], body.points[s.corners[chosen]]
    result = []
    for name, sides in faces.items():
        x = [
            0.5 * (1 - z)[:, None] * _surface.evaluate(bezier, s.degree, u, v, order=0)[0]
            + 0.5 * (1 + z)[:, None] * _layer.bilinear(corners, u, v)
            for u, v, z in sides
        ]
        result.append((*patches(np.concatenate(x)), COLOURS[name]))
    return result


def cell_part(body, kind, keep):
    """(polygons, edges, colour) of those cells of a type that are not cut away; None if there are
    none.
    """
    import pyvista

    cells = body.cells[kind]
    if len(cells):
        cells = cells[keep(body.points[cells].mean(axis=1))]
    if not len(cells):
        return None
    polygons = [np.r_[len(f), row[list(f)]] for row in cells for f in FACES[kind]]
    mesh = pyvista.PolyData(body.points, np.concatenate(polygons))
    return mesh, mesh.extract_all_edges(), COLOURS[kind]


def patches(x):
    """(polygons, outlines) of faces given by (m, FINE^2, 3) points."""
    import pyvista

    n = FINE
    at = np.arange(n * n).reshape(n, n)
    quads = np.stack([at[:-1, :-1], at[:-1, 1:], at[1:, 1:], at[1:, :-1]], axis=-1).reshape(-1, 4)
    loop = np.r_[at[0], at[1:, -1], at[-1, -2::-1], at[-2::-1, 0]]
    first = n * n * np.arange(len(x))[:, None, None]
    polygons = (first + quads).reshape(-1, 4)
    lines = (first[:, :, 0] + loop).reshape(len(x), -1)
    points = x.reshape(-1, 3)
    width = np.full((len(polygons), 1), 4)
    edges = pyvista.PolyData(
        points, lines=np.column_stack([np.full(len(x), len(loop)), lines]).ravel()
    )
    return pyvista.PolyData(points, np.hstack([width, polygons]).ravel()), edges


def compose(scenes, direction, path, columns=1, up=(0, 1, 0), size=(1500, 1100), box=None):
    """Render scenes [(parts, caption)] with one camera and arrange them on a page.

    A part is (polygons, edges, colour), followed by the colour of its edges if that is not black.
    """
    import pyvista

    bounds = np.array([part[0].bounds for parts, _ in scenes for part in parts])
    if box is None:
        box = np.ravel(np.column_stack([bounds[:, ::2].min(axis=0), bounds[:, 1::2].max(axis=0)]))
    shift = 0.002 * np.ptp(np.reshape(box, (3, 2)), axis=1).max() * unit(direction)
    images = []
    for parts, _ in scenes:
        plot = pyvista.Plotter(off_screen=True, window_size=list(size))
        plot.set_background("white")
        for polygons, edges, colour, *pen in parts:
            if polygons.n_cells > 1 or polygons.n_points > 1:
                plot.add_mesh(polygons, color=colour, ambient=0.4, diffuse=0.6, specular=0.0)
            moved = edges.translate(shift, inplace=False)
            width = 3.0 if pen and pen[0] != "#202020" else 1.4
            plot.add_mesh(
                moved, color=pen[0] if pen else "#202020", line_width=width, lighting=False
            )
        plot.enable_parallel_projection()
        plot.view_vector(direction, viewup=up, bounds=box)
        plot.enable_anti_aliasing("ssaa")
        images.append(np.asarray(plot.screenshot(return_img=True))[..., :3])
        plot.close()
    _page(cropped(images), [caption for _, caption in scenes], path, columns)


def _page(images, captions, path, columns):
    with _style.styled() as plt:
        rows = -(-len(images) // columns)
        height, width = images[0].shape[:2]
        panel = _style.PAGE / columns
        figure, axes = plt.subplots(
            rows,
            columns,
            figsize=(_style.PAGE, rows * (panel * height / width + 0.25)),
            squeeze=False,
        )
        for ax, image, caption in zip(axes.ravel(), images, captions):
            ax.imshow(image, interpolation="lanczos")
            ax.set_title(caption, y=-0.04, va="top", pad=0, fontsize=7.5)
        for ax in axes.ravel():
            ax.set_axis_off()
        figure.set_dpi(200)
        _style.save(figure, path)
