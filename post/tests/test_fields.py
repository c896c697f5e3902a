"""Result files: their numbers, and pictures of them without a screen."""

import contextlib
import importlib.util
import io
import unittest

import numpy as np

from post import _scalar, _screen, diff
from post._error import Unreadable
from post.tests.samples import Scratch, write_fields

HAS_HDF5 = importlib.util.find_spec("h5py") is not None
NO_PICTURES = _screen.reason_not_ready() or (
    None if importlib.util.find_spec("pyvista") else "pyvista is not installed"
)


class Choices(unittest.TestCase):
    def test_a_colour_map_that_is_none_is_refused(self):
        with self.assertRaisesRegex(Unreadable, "no colour map 'virids'; did you mean 'viridis'"):
            _scalar.colours([np.array([0.0, 1.0])], cmap="virids")
        self.assertEqual(_scalar.colours([np.array([0.0, 1.0])], cmap="magma")[1], "magma")

    def test_all_components_are_named(self):
        with self.assertRaisesRegex(Unreadable, "11 22 33 12 23 31 magnitude trace"):
            _scalar._component(np.zeros((2, 6)), "a.vtkhdf", "stress", None)


@unittest.skipUnless(HAS_HDF5, "h5py is not installed")
class Numbers(Scratch):
    def setUp(self):
        super().setUp()
        self.a, self.b = self.folder / "a.vtkhdf", self.folder / "b.vtkhdf"
        write_fields(self.a)

    def test_a_field_file_is_the_same_as_its_copy(self):
        write_fields(self.b)
        self.assertTrue(diff.compare(self.a, self.b).same)

    def test_a_difference_names_step_and_point(self):
        write_fields(self.b, noise=1e-3)
        bad = [c for t in diff.compare(self.a, self.b).tables for c in t.columns if not c.ok]
        self.assertEqual(
            {c.name for c in bad}, {"displacement_1", "displacement_2", "displacement_3"}
        )
        self.assertRegex(bad[0].where, r"step [123]0, point \d+")

    def test_another_number_of_steps_differs(self):
        write_fields(self.b, steps=4)
        self.assertFalse(diff.compare(self.a, self.b).same)

    def test_a_cut_file_is_unreadable(self):
        self.b.write_bytes(self.a.read_bytes()[:3000])
        with self.assertRaisesRegex(Unreadable, "not a readable HDF5 file"):
            diff.compare(self.a, self.b)


@unittest.skipIf(NO_PICTURES, NO_PICTURES)
class Pictures(Scratch):
    def setUp(self):
        super().setUp()
        _screen.prepare()
        self.run_file = self.folder / "ring.vtkhdf"
        write_fields(self.run_file)

    def test_the_surface_is_round_and_fields_follow_the_rational_functions(self):
        from post import _grid, _surface

        grid, time, number = _grid.load(self.run_file, 20)
        self.assertEqual((time, number), (0.5, 20))
        surface = _surface.surface(grid)
        radius = np.hypot(surface.points[:, 0], surface.points[:, 1])
        self.assertAlmostEqual(radius.min(), 1.0, 6)
        self.assertAlmostEqual(radius.max(), 2.0, 6)
        np.testing.assert_allclose(
            surface["displacement"][:, 0], 0.15 * surface.points[:, 0], atol=1e-6
        )
        self.assertEqual(
            surface.n_cells, 10 * 2 * 16**2
        )  # the face between the two cells is not drawn

    def test_steps_are_found_where_times_repeat_and_decrease(self):
        """VTK finds a step by its time, which ARCLength may decrease."""
        import h5py

        from post import _fields, _grid

        with h5py.File(self.run_file, "r+") as file:
            file["VTKHDF/Steps/Values"][...] = [0.5, 0.5, 0.1]
        expected = _fields.read_fields(self.run_file).arrays["displacement"][1]
        for number, wanted in zip((10, 20, 30), expected):
            found = _grid.load(self.run_file, number)[0]
            np.testing.assert_array_equal(found.point_data["displacement"], wanted)

    def test_steps_of_a_list_of_files_are_those_of_the_analysis(self):
        from post import _grid

        self.assertEqual(self.listed("ring_0002.vtu", "ring_0004.vtu"), [(2, 0.0), (4, 1.0)])
        self.assertEqual(self.listed("a.vtu", "ring_0004.vtu"), [(1, 0.0), (2, 1.0)])
        self.listed("ring_0002.vtu", "ring_0004.vtu")
        with self.assertRaisesRegex(Unreadable, "no step 1"):
            _grid.load(self.folder / "ring.pvd", 1)

    def listed(self, *names):
        """The steps of a .pvd file that lists these files at the times 0, 1, ..."""
        from post import _grid

        sets = "".join(f'<DataSet timestep="{i}" file="{n}"/>' for i, n in enumerate(names))
        path = self.folder / "ring.pvd"
        path.write_text(f'<VTKFile type="Collection"><Collection>{sets}</Collection></VTKFile>')
        return _grid.steps_of(path)

    def test_edges_are_curves_of_the_outer_faces(self):
        from post import _grid, _surface

        edges = _surface.edges(_grid.load(self.run_file)[0], level=3)
        self.assertEqual(edges.n_lines, 20)
        self.assertEqual(edges.n_points, 20 * 9)

    def test_a_mirrored_part_is_whole_and_open_in_the_plane(self):
        from post import _grid, _surface

        grid = _grid.load(self.run_file)[0]
        for part in (_surface.surface(grid), _surface.edges(grid), _surface.outline(grid)):
            whole = _surface.mirrored(part, 0)
            low, high = whole.bounds[:2]
            self.assertAlmostEqual(low, -high, 12)
            self.assertAlmostEqual(high, part.bounds[1], 12)
            self.assertEqual(whole.n_cells % 2, 0)
            self.assertLessEqual(whole.n_cells, 2 * part.n_cells)

    def test_a_mirror_image_reverses_odd_components(self):
        from post import field

        for component, sign in (("1", -1), ("2", 1), ("magnitude", 1)):
            scene = field._scene(
                self.run_file, "displacement", component, "last", 0.0, False, False, None
            )
            field._mirror(scene, "x", component)
            low = {}
            for x, v in zip(scene.surface.points.round(6), scene.surface["shown"]):
                low[tuple(x + 0.0)] = v
            for (x, y, z), v in low.items():
                self.assertAlmostEqual(low[(-x + 0.0, y, z)], v if x == 0 else sign * v, 6)

    def test_data_of_cells_are_mirrored(self):
        from post import field

        scene = field._scene(self.run_file, "material", None, "last", 0.0, False, False, None)
        n = scene.surface.n_cells
        field._mirror(scene, "x", None)
        self.assertGreater(scene.surface.n_cells, n)
        self.assertTrue((scene.surface["shown"] == 1).all())

    def test_a_picture_is_written_and_is_not_blank(self):
        from matplotlib.image import imread

        from post.field import main

        figure = self.folder / "fig.png"
        with contextlib.redirect_stdout(io.StringIO()):
            code = main([str(self.run_file), "--scalar", "stress", "--component", "23", "--beside", str(self.run_file),
                         "-o", str(figure), "--size", "300", "200"])  # fmt: skip
        self.assertEqual(code, 0)
        image = imread(figure)
        self.assertGreater(image[..., :3].std(), 0.05)

    def test_vtu_and_pvd_files_are_read(self):
        from post import _grid

        grid = _grid.load(self.run_file)[0]
        grid.save(self.folder / "ring_3.vtu")
        (self.folder / "ring.pvd").write_text(
            '<VTKFile type="Collection"><Collection><DataSet timestep="0.5" file="ring_3.vtu"/></Collection></VTKFile>'
        )
        for name in ("ring_3.vtu", "ring.pvd"):
            again, found, step = _grid.load(self.folder / name)
            self.assertEqual((found, step), (0.5, 3))
            np.testing.assert_array_equal(again.points, grid.points)

    def test_a_close_up_has_the_shape_of_its_frame(self):
        from post import _picture, field

        scene = field._scene(self.run_file, "mises", None, "last", 0.0, True, False, None)
        camera = field._camera("+z")
        (image,) = _picture.render(
            [scene], (1, 2), "viridis", camera, (300, 200), (0, 2, 0, 1, 0, 1)
        )
        self.assertEqual(image.shape[:2], (150, 300))

    def test_a_body_is_drawn_alone(self):
        from post import _grid, field

        whole, file = _grid.load(self.run_file)[0], self.folder / "two.vtu"
        with self.assertRaisesRegex(Unreadable, "no field 'body'"):
            field._scene(self.run_file, "mises", None, "last", 0.0, False, False, None, [1])
        whole.cell_data["body"] = np.arange(whole.n_cells) + 1
        whole.save(file)
        scene = field._scene(file, "body", None, "last", 0.0, False, False, None, [1])
        one = whole.extract_cells([0])
        np.testing.assert_allclose(scene.surface.bounds, one.bounds, atol=1e-6)

    def test_what_cannot_be_drawn_is_said(self):
        from post import field

        for words, options in (
            ("no field 'temperature'", {"scalar": "temperature"}),
            ("choose a component", {"scalar": "stress"}),
            ("no step 4", {"step": 4}),
            ("unknown view", {"view": "top"}),
        ):
            with self.assertRaisesRegex(Unreadable, words):
                field.draw([self.run_file], self.folder / "fig.png", **options)


if __name__ == "__main__":
    unittest.main()
