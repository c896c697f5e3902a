"""Contact surfaces: which faces they are, their fields, and the picture."""

import contextlib
import importlib.util
import io
import unittest

import numpy as np

from post._error import Unreadable
from post.tests.samples import Scratch, place

HAS_VTK = importlib.util.find_spec("pyvista") is not None


def two_blocks():
    """A brick [0,1]^3 and above it a triquadratic Bezier cell with a lower face that is curved: the
    control point in its middle lies 0.5 higher. Contact fields are linear in x.
    """
    import pyvista

    brick = [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    cell = [None] * 27
    for i, j, k in np.ndindex(3, 3, 3):
        bulge = 1.0 if (i, j, k) == (1, 1, 0) else 0.0
        cell[place(i, j, k)] = (0.5 * i, 0.5 * j, 1 + 0.5 * k + 0.5 * bulge)
    points = np.array(brick + cell, dtype=float)
    grid = pyvista.UnstructuredGrid(
        np.array([8, *range(8), 27, *range(8, 35)]), np.array([12, 79], dtype=np.uint8), points
    )
    contact = np.r_[points[:8, 2] == 1, [False] * 27]
    for i, j in np.ndindex(3, 3):
        contact[8 + place(i, j, 0)] = True
    x = np.where(contact, points[:, 0], 0.0)
    grid.point_data["displacement"] = np.tile([0.0, 0.0, 0.25], (35, 1))
    grid.point_data["contact_gap"] = np.where(contact, -0.1, 0.0)
    grid.point_data["contact_pressure"] = x
    grid.point_data["contact_friction"] = np.column_stack([x - 0.5, 2 * x, 0 * x])
    grid.point_data["RationalWeights"] = np.ones(35)
    grid.cell_data["HigherOrderDegrees"] = np.array([[1.0, 1, 1], [2, 2, 2]])
    grid.cell_data["body"] = np.array([2, 1])
    return grid


#: Cells with triangular faces: VTK's number, corners, and edges with nodes in their middle.
SOLIDS = {
    "tetrahedron": (10, [(0, 0, 0), (2, 0, 0), (0, 1, 0), (0, 0, 1)], []),
    "quadratic tetrahedron": (
        24,
        [(0, 0, 0), (2, 0, 0), (0, 1, 0), (0, 0, 1)],
        [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)],
    ),
    "wedge": (13, [(0, 0, 0), (0, 1, 0), (2, 0, 0), (0, 0, 1), (0, 1, 1), (2, 0, 1)], []),
    "pyramid": (14, [(0, 0, 0), (2, 0, 0), (2, 0, 1), (0, 0, 1), (0, 1, 0)], []),
}


def solid(name):
    """One cell whose triangle with corners (0,0), (2,0), (0,1) in the plane z = 0 is in contact.
    The pressure is 1 at the last of its points and 0 at the others.
    """
    import pyvista

    number, corners, middles = SOLIDS[name]
    points = np.array(corners, dtype=float)
    points = np.vstack([points, *[points[[a, b]].mean(axis=0) for a, b in middles]])
    cell = np.array([len(points), *range(len(points))])
    grid = pyvista.UnstructuredGrid(cell, np.array([number], dtype=np.uint8), points)
    contact = points[:, 2] == 0
    grid.point_data["displacement"] = np.zeros((len(points), 3))
    grid.point_data["contact_gap"] = np.where(contact, -0.1, 0.0)
    pressure = np.zeros(len(points))
    pressure[np.flatnonzero(contact)[-1]] = 1.0
    grid.point_data["contact_pressure"] = pressure
    return grid


def area(polygons):
    """The sum of the areas of (n, 4, 2) polygons."""
    x, y = polygons[..., 0], polygons[..., 1]
    return 0.5 * np.abs((x * np.roll(y, -1, 1) - y * np.roll(x, -1, 1)).sum(axis=1)).sum()


@unittest.skipUnless(HAS_VTK, "pyvista is not installed")
class ContactMap(Scratch):
    def setUp(self):
        super().setUp()
        self.run_file = self.folder / "two.vtu"
        two_blocks().save(self.run_file)

    def found(self, n=5):
        from post import _grid
        from post._contact_faces import surfaces

        grid = _grid.load(self.run_file)[0]
        return surfaces(grid, self.run_file, grid.point_data["contact_pressure"], n)

    def test_a_body_has_the_faces_with_contact_on_all_their_points(self):
        upper, lower = self.found()
        self.assertEqual((upper.body, lower.body), (1, 2))
        self.assertEqual((len(upper.x), len(lower.x)), (1, 1))
        np.testing.assert_allclose(lower.x[..., 2], 1.0, atol=1e-14)
        self.assertTrue((lower.outward[..., 2] > 0).all())
        self.assertTrue((upper.outward[..., 2] < 0).all())

    def test_shape_and_field_are_those_of_the_cell(self):
        upper = self.found()[0]
        # the middle control point lies 1/2 higher, and its function is (1/2)^2 there
        self.assertAlmostEqual(upper.x[0, 2, 2, 2], 1 + 0.5 * 0.25, 12)
        for surface in self.found():
            np.testing.assert_allclose(surface.value, surface.x[..., 0], atol=1e-13)

    def test_the_displacement_of_a_face_is_found_at_its_material_points(self):
        from post.figures import section5_contact

        block = section5_contact.face(self.run_file, 2)  # the brick, whose upper face is in contact
        self.assertEqual(sorted(block)[:3], [(0, 0, 8), (0, 4, 8), (0, 8, 8)])
        self.assertEqual(len(block), 9)
        np.testing.assert_allclose(list(block.values()), [[0.0, 0.0, 0.25]] * 9, atol=1e-14)

    def test_the_twist_of_a_strip_is_the_inclination_of_lines_across_it(self):
        import pyvista

        from post.figures import section5_debonding

        grid = pyvista.ImageData(dimensions=(3, 2, 2)).cast_to_unstructured_grid()
        grid = grid.rotate_z(section5_debonding.ANGLE)
        along, across = (np.radians(section5_debonding.ANGLE + a) for a in (0, 90))
        points = np.asarray(grid.points, dtype=float)
        x, y = (points[:, 0] * np.cos(a) + points[:, 1] * np.sin(a) for a in (along, across))
        lift = np.zeros_like(points)
        lift[:, 2] = np.where(y > 0.5, np.tan(np.radians(3.0)) * x, 0.0)  # 0, 3 degrees and more
        grid.point_data["displacement"] = lift
        grid.cell_data["body"] = np.ones(2)
        grid.save(self.run_file)
        found = section5_debonding.twist(self.run_file, "last")
        self.assertAlmostEqual(found, np.degrees(np.arctan(2 * np.tan(np.radians(3.0)))), 4)

    def test_a_triangle_is_drawn_once_and_not_beyond_its_edges(self):
        from post import contact_map

        for name in SOLIDS:
            solid(name).save(self.run_file)
            with self.subTest(name):
                panel = contact_map._panel(self.run_file, "contact_pressure", None, "last", "z")
                (side,) = panel.sides
                seen = np.ones(side.value.shape, dtype=bool)
                _, parts = contact_map._triangles(side.x[..., :2], side.x[..., 2], seen)
                corners = np.stack([parts.x, parts.y], axis=-1)[parts.triangles]
                self.assertAlmostEqual(area(corners), 1.0, 12)
                self.assertAlmostEqual(side.value.max(), 1.0, 12)
                outward = -side.outward[..., 2]  # negative where it points into the body
                self.assertTrue((outward > 0).all())

    def test_the_picture_moves_the_upper_body_to_the_left_and_deforms_it(self):
        from post import contact_map

        panel = contact_map._panel(self.run_file, "contact_friction", "2", "last", "z")
        self.assertEqual([s.body for s in panel.sides], [1, 2])
        self.assertAlmostEqual(panel.sides[1].x[..., 2].max(), 1.25, 12)
        self.assertAlmostEqual(max(v.max() for v in panel.values()), 2.0, 12)

    def test_the_command_draws_and_uses_one_scale(self):
        from matplotlib.image import imread

        from post import contact_map
        from post.__main__ import main

        figure = self.folder / "fig.png"
        with contextlib.redirect_stdout(io.StringIO()):
            limits = contact_map.draw([self.run_file] * 3, figure, columns=2)
            code = main(["contact-map", str(self.run_file), "-o", str(figure), "--scalar",
                         "contact_pressure", "--label", "two"])  # fmt: skip
        np.testing.assert_allclose(limits, (-0.5, 0.5), atol=1e-12)
        self.assertEqual(code, 0)
        self.assertGreater(imread(figure)[..., :3].std(), 0.05)

    def test_what_cannot_be_drawn_is_said(self):
        from post import contact_map

        for words, options in (
            ("no field 'contact_heat'", {"scalar": "contact_heat"}),
            ("belongs to cells", {"scalar": "body"}),
            ("unknown axis", {"axis": "w"}),
            ("no step 4", {"step": 4}),
        ):
            with self.assertRaisesRegex(Unreadable, words):
                contact_map.draw([self.run_file], self.folder / "fig.png", **options)
        grid = two_blocks()
        grid.point_data["contact_gap"][:] = 0.0
        grid.save(self.run_file)
        with self.assertRaisesRegex(Unreadable, "no contact surface"):
            contact_map.draw([self.run_file], self.folder / "fig.png")
        del grid.point_data["contact_gap"]
        grid.save(self.run_file)
        with self.assertRaisesRegex(Unreadable, "has no contact fields"):
            contact_map.draw([self.run_file], self.folder / "fig.png")


if __name__ == "__main__":
    unittest.main()
