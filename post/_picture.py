"""Figures of surfaces: VTK draws each body, and matplotlib arranges the pictures on a page."""

from dataclasses import dataclass

import numpy as np

from post import _style, _surface


@dataclass
class Scene:
    """One body ready to be drawn, and the caption below it."""

    surface: object  # deformed, with the array 'shown'
    edges: object
    outline: object
    caption: str

    def mirror(self, axis, odd=False):
        """Add the mirror image across the plane where a coordinate (0 1 2) is zero. If `odd`, the
        scalar changes its sign there.
        """
        self.surface = _surface.mirrored(self.surface, axis, odd)
        self.edges, self.outline = (
            part and part.n_points and _surface.mirrored(part, axis) or None
            for part in (self.edges, self.outline)
        )


def render(scenes, limits, cmap, camera, size, frame=None):
    """One image (height, width, 3) per scene, all cropped to the same frame, which is the smallest
    one that contains all of them or the projection of the box `frame`.
    """
    import pyvista

    bounds = np.array(
        [part.bounds for s in scenes for part in (s.surface, s.outline) if part and part.n_points]
    )
    box = np.ravel(np.column_stack([bounds[:, ::2].min(axis=0), bounds[:, 1::2].max(axis=0)]))
    images = []
    for scene in scenes:
        plot = pyvista.Plotter(off_screen=True, window_size=list(size))
        plot.set_background("white")
        smooth = scene.surface.compute_normals(
            split_vertices=True, feature_angle=35.0, cell_normals=False
        )
        plot.add_mesh(smooth, scalars="shown", clim=limits, cmap=cmap, show_scalar_bar=False,
                      smooth_shading=True, ambient=0.55, diffuse=0.5, specular=0.0)  # fmt: skip
        direction, up = camera
        shift = 0.003 * np.ptp(box.reshape(3, 2), axis=1).max() * unit(direction)
        for lines, colour, width in (
            (scene.edges, "#1a1a1a", 2.0),
            (scene.outline, "#777777", 1.6),
        ):
            if lines is not None and lines.n_points:
                # Lines are moved towards the camera so that the surface does not cover them. Their
                # position in the picture does not change, because the projection is parallel.
                moved = lines.translate(shift, inplace=False)
                plot.add_mesh(moved, color=colour, line_width=width, lighting=False)
        plot.enable_parallel_projection()
        plot.view_vector(direction, viewup=up, bounds=box if frame is None else frame)
        if frame is not None:
            _fill(plot, frame, direction, up, size)
        plot.enable_anti_aliasing("ssaa")
        images.append(np.asarray(plot.screenshot(return_img=True))[..., :3])
        plot.close()
    return images if frame is not None else cropped(images)


def _fill(plot, frame, direction, up, size):
    """Let the projection of a box fill a picture of the given width."""
    corners = np.array(np.meshgrid(*np.reshape(frame, (3, 2)), indexing="ij")).reshape(3, -1)
    out = unit(direction)
    right = unit(np.cross(up, out))
    width, height = (np.ptp(axis @ corners) for axis in (right, np.cross(out, right)))
    plot.window_size = [size[0], round(size[0] * height / width)]
    plot.camera.parallel_scale = height / 2


def greys(count):
    """(limits, colour map) for bodies 1 to `count`, which are told apart but show no field.

    >>> limits, colours = greys(2)
    >>> limits, colours.N
    ((0.5, 2.5), 2)
    """
    from matplotlib.colors import ListedColormap

    shades = ("#c9d3dc", "#e4ddd0", "#d2dccb", "#dccfd6")
    return (0.5, count + 0.5), ListedColormap([shades[i % len(shades)] for i in range(count)])


def unit(direction):
    """The vector (3), scaled to length one.

    >>> unit((0, 0, 2)).tolist()
    [0.0, 0.0, 1.0]
    """
    return np.asarray(direction, dtype=float) / np.linalg.norm(direction)


def cropped(images):
    """The images, all cropped to the smallest frame that contains the subject of each, with a
    margin.
    """
    ink = np.any([np.any(image < 250, axis=2) for image in images], axis=0)
    if not ink.any():
        return images
    rows, columns = np.flatnonzero(ink.any(axis=1)), np.flatnonzero(ink.any(axis=0))
    cut = tuple(slice(max(i[0] - 12, 0), i[-1] + 13) for i in (rows, columns))
    return [image[cut] for image in images]


def compose(images, scenes, limits, cmap, label, output):
    """Draw the panels, their captions and one colour bar on a page; without a label there is no
    bar.
    """
    with _style.styled() as plt:
        from matplotlib.cm import ScalarMappable
        from matplotlib.colors import Normalize

        height, width = images[0].shape[:2]
        n = len(images)
        panel = (_style.PAGE if n > 1 else 4.4) / n * 0.86
        figure, axes = plt.subplots(
            1,
            n,
            figsize=(_style.PAGE if n > 1 else 4.4, panel * height / width + 0.35),
            squeeze=False,
        )
        for ax, image, scene in zip(axes[0], images, scenes):
            ax.imshow(image, interpolation="lanczos")
            ax.set_axis_off()
            ax.set_title(scene.caption, y=-0.02, va="top", pad=0)
        if label is not None:
            bar = figure.colorbar(
                ScalarMappable(Normalize(*limits), cmap),
                ax=axes[0].tolist(),
                shrink=0.75,
                aspect=24,
                pad=0.02,
            )
            bar.set_label(label)
            bar.outline.set_linewidth(0.5)
        figure.set_dpi(200)
        _style.save(figure, output)
