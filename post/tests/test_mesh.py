"""From nets to bodies: functions, volumes, hanging corners, borders."""

import unittest

import numpy as np

from post.mesh import (
    _border,
    _choose,
    _enrich,
    _hexes,
    _layer,
    _net,
    _patches,
    _polish,
    _quality,
    _read,
    _report,
    _smooth,
    _split,
    _surface,
    _triangles,
    _write,
    body_of,
    surface_of,
)
from post.tests.net_samples import Folder, grid


class Surfaces(Folder):
    def test_functions_sum_to_one_and_are_not_negative(self):
        surface, _ = surface_of(self.block())
        for c in surface.coefficients:
            np.testing.assert_allclose(c.sum(axis=0), 1, atol=1e-15)
            self.assertGreaterEqual(c.min(), 0)

    def test_a_plane_regular_net_is_the_uniform_b_spline(self):
        points, _ = grid((5, 5, 1))
        quads = [
            (a, b, c, d)
            for a, b, c, d in _read.boundary(grid((5, 5, 1))[1])
            if points[[a, b, c, d], 2].max() == 0
        ]
        net = _net.checked(_net.Net(points, np.array(quads)), "plane", closed=False)
        surface = _patches.extract(net)
        border = net.border[np.unique(net.quads)]
        inner = [e for e, corners in enumerate(surface.corners) if not border[corners].any()]
        self.assertEqual(len(inner), 9)
        line = np.array([[1, 4, 1, 0], [0, 4, 2, 0], [0, 2, 4, 0], [0, 1, 4, 1]]) / 6
        want = np.sort(np.kron(line, line), axis=1)
        for e in inner:
            np.testing.assert_allclose(np.sort(surface.coefficients[e].T, axis=1), want, atol=1e-15)

    def test_a_refined_net_has_nearly_the_same_surface(self):
        coarse, _ = surface_of(self.block())
        fine, _ = surface_of(self.block(), refine=1)
        self.assertEqual(len(fine.nodes), 4 * len(coarse.nodes))
        areas = [_surface.measures(s)[0] for s in (coarse, fine)]
        self.assertLess(abs(areas[1] / areas[0] - 1), 5e-3)

    def test_curvature_of_a_sphere_of_nurbs_is_one_over_its_radius(self):
        # A quarter turn in both directions, rational biquadratic, radius 2.
        h = np.sqrt(0.5)
        arc = np.array([[1.0, 0], [1, 1], [0, 1]])
        w = np.array([1, h, 1.0])
        points = np.array([[2 * a[0] * b[0], 2 * a[1] * b[0], 2 * b[1]] for b in arc for a in arc])
        weights = np.array([u * v for v in w for u in w])
        bezier = np.column_stack([points * weights[:, None], weights])
        surface = _surface.Surface(
            (2, 2), points, weights, [np.arange(9)], [np.eye(9)], np.array([[0, 1, 2, 3]])
        )
        values = _surface.curvature(surface, np.array([0.1, -0.4]), np.array([0.2, 0.3]))
        np.testing.assert_allclose(abs(values), 0.5, rtol=1e-12)
        x = _surface.evaluate(bezier[None], (2, 2), np.array([0.3]), np.array([-0.2]))[0]
        self.assertAlmostEqual(np.linalg.norm(x), 2, places=14)

    def test_d_patches_have_no_jump_of_normals(self):
        for everywhere in (False, True):
            plain, _ = surface_of(self.block((4, 4, 4)))
            surface = _smooth.smooth(plain, everywhere)
            self.assertGreater(_report.normal_jumps(plain)["edges"], 1)
            self.assertLess(_report.normal_jumps(surface)["edges"], 1e-4)
            self.assertLess(_report.normal_jumps(surface)["corners"], 1e-2)
            self.assertEqual(len(surface.hanging) > 0, not everywhere)

    def test_splitting_keeps_the_surface_and_names_the_corners_that_hang(self):
        plain, _ = surface_of(self.block())
        surface = _split.split(plain, np.arange(len(plain.nodes)) == 4)
        self.assertEqual(len(surface.hanging), 4)
        volumes = [_surface.measures(s)[1] for s in (surface, plain)]
        self.assertLess(abs(volumes[0] / volumes[1] - 1), 1e-14)
        for _, (a, b, tau) in surface.hanging.items():
            self.assertNotEqual(a, b)
            self.assertEqual(tau, 0.5)

    def test_hanging_corners_are_found_again_in_a_file(self):
        plain, _ = surface_of(self.block())
        surface = _split.split(plain, np.arange(len(plain.nodes)) == 4)
        text = _write.bext_text(_write.grouped(surface))
        again, _ = surface_of(self.file("a.bext.json", text))
        self.assertEqual(len(again.hanging), 4)
        self.assertEqual({t for _, _, t in again.hanging.values()}, {0.5})
        volumes = [_surface.measures(s)[1] for s in (again, surface)]
        self.assertLess(abs(volumes[0] / volumes[1] - 1), 1e-13)

    def test_corners_hang_on_parts_of_edges_after_a_second_split(self):
        surface, _ = surface_of(self.block())
        once = _split.split(surface, np.arange(len(surface.nodes)) == 4)
        touching = np.isin(once.corners, list(once.hanging)).any(axis=1)
        twice = _split.split(once, touching)
        chains = [m for m in twice.hanging.values() if set(m[:2]) & set(twice.hanging)]
        self.assertEqual((len(twice.hanging), len(chains)), (12, 8))
        again, _ = surface_of(self.file("a.bext.json", _write.bext_text(_write.grouped(twice))))
        places = [
            sorted(sorted(x.at.values()) for x in _border.lines(s.hanging)) for s in (again, twice)
        ]
        np.testing.assert_allclose(*places, atol=1e-7)
        form = _layer.build(twice)
        for line in _border.lines(twice.hanging):
            a, b = (form.inner[v] for v in line.ends)
            self.assertEqual(sorted(line.at.values()), [0.25, 0.5, 0.75])
            for v, t in line.at.items():
                np.testing.assert_allclose(form.inner[v], (1 - t) * a + t * b, atol=1e-15)


class Bodies(Folder):
    def check_volumes(self, body):
        report = _report.describe(body)
        self.assertLess(report["volume"]["relative_difference"], 1e-12)
        self.assertEqual(_report.bad(report), [])
        return report

    def test_volumes_add_up_over_reused_hexahedra(self):
        report = self.check_volumes(self.body())
        self.assertEqual(report["counts"]["hexes"], 27)

    def test_volumes_add_up_where_a_part_is_plain(self):
        body = self.body(enrich="normal:0,0,1,30")
        report = self.check_volumes(body)
        self.assertGreater(report["counts"]["ties"], 0)
        self.assertLess(report["counts"]["elements"], 54)

    def test_the_border_of_the_enriched_part_is_straight_and_has_the_plain_points(self):
        body = body_of(self.block((5, 5, 5)), interior="hexes", enrich="normal:0,0,1,10")
        at = {k: body.surface.points[k] for _, k in body.ties}
        for s, k in body.ties:
            np.testing.assert_array_equal(body.points[s], at[k])
        bezier = body.surface.bezier()[..., :3]
        lines = np.array([[0, 1, 2, 3], [3, 7, 11, 15], [15, 14, 13, 12], [12, 8, 4, 0]])
        edges = bezier[:, lines].reshape(-1, 4, 3)
        ends = {tuple(x) for x in at.values()}
        on_border = [e for e in edges if tuple(e[0]) in ends and tuple(e[3]) in ends]
        straight = [e for e in on_border if np.allclose(3 * e[1], 2 * e[0] + e[3], atol=1e-14)]
        self.assertGreaterEqual(len(straight), len(at))

    def test_edges_on_which_corners_hang_stay_one_at_the_border(self):
        body = self.body(interior="none", split="normal:0,0,1,30", enrich="box:1,1,1,9,9,9")
        surface = body.surface
        self.assertEqual(_report.bad(_report.describe(body)), [])
        self.assertTrue(any(min(masters) < 0 for _, masters, _ in body.hanging))
        for c in surface.coefficients:
            np.testing.assert_allclose(c.sum(axis=0), 1, atol=1e-15)
        surface.points = np.random.default_rng(1).random(surface.points.shape)  # displacements
        bezier = surface.bezier()[..., :3]
        edge = {}
        for e, row in enumerate(surface.corners.tolist()):
            for k, line in enumerate(_enrich._lines(3, 3)):
                for v, w, at in (
                    (row[k], row[(k + 1) % 4], line),
                    (row[(k + 1) % 4], row[k], line[::-1]),
                ):
                    edge.setdefault((v, w), []).append(bezier[e, at])
        pairs = [both for both in edge.values() if len(both) == 2]
        np.testing.assert_allclose(*np.swapaxes(pairs, 0, 1), atol=1e-14)
        low, high = _split.halves(3)
        hang = [(a, s, b) for s, (a, b, _) in surface.hanging.items() if (a, b) in edge]
        for a, s, b in hang:
            for half, small in ((low, (a, s)), (high, (s, b))):
                for part in edge.get(small, []):
                    np.testing.assert_allclose(half @ edge[a, b][0], part, atol=1e-14)
        self.assertGreater(len(hang), 2)

    def test_elements_that_stay_splines_keep_their_functions_beside_t_junctions(self):
        whole, _ = surface_of(self.block(), split="normal:0,0,1,30")
        keep = _choose.elements(whole, "box:1,1,1,9,9,9")
        body = self.body(interior="none", split="normal:0,0,1,30", enrich="box:1,1,1,9,9,9")
        kept = {tuple(r): b for r, b in zip(whole.corners[keep].tolist(), whole.bezier()[keep])}
        part = dict(zip(map(tuple, body.surface.corners.tolist()), body.surface.bezier()))
        for row, bezier in kept.items():
            np.testing.assert_array_equal(part[row], bezier)

    def test_a_body_without_splines_has_a_deck_without_them(self):
        body = self.body(interior="none", split="normal:0,0,1,10", enrich="box:90,90,90,91,91,91")
        text = _write.deck_text(body, "b", "")
        self.assertNotIn("SPLIne", text)
        self.assertIn("MESH,b_bulk FILE b.msh\n  CONStraint b.con\n", text)

    def test_layer_above_hanging_corners_is_conforming(self):
        body = self.body(interior="none", split="normal:0,0,1,10")
        for s, (a, b), c in body.hanging:
            np.testing.assert_allclose(
                body.points[s], c[0] * body.points[a] + c[1] * body.points[b], atol=1e-15
            )
        self.assertGreater(_layer.worst(body.surface, body.points).min(), 0)

    def test_thickness_is_what_a_ray_passes_through(self):
        surface, _ = surface_of(self.block((2, 2, 6)))
        x = surface.corner_points()
        normal, _ = _surface.corner_normals(surface)
        thick = _layer.thickness(surface, x, normal)
        top = np.argmax(x[:, 2])
        self.assertAlmostEqual(thick[top], np.ptp(x[:, 2]), places=12)

    def test_triangles_that_cut_are_found_and_those_that_touch_are_not(self):
        x = np.array(
            [
                [0, 0, 0],
                [2, 0, 0],
                [0, 2, 0],
                [0.5, 0.5, -1],
                [0.5, 0.5, 1],
                [3, 3, 0.5],
                [2, 2, 0.0],
            ]
        )
        self.assertEqual(len(_triangles.intersections(x, np.array([[0, 1, 2], [3, 4, 5]]))), 1)
        self.assertEqual(len(_triangles.intersections(x, np.array([[0, 1, 2], [1, 2, 6]]))), 0)

    def test_harmonic_values_reproduce_a_linear_field(self):
        points, cells = grid((3, 3, 3))
        edges = _hexes.cell_edges(cells)
        inner = np.all((points > 0) & (points < 3), axis=1)
        order = np.argsort(inner, kind="stable")
        number = np.argsort(order)
        values = points[order] @ np.array([[1.0, 2, 0], [0, 1, 0], [3, 0, 1]])
        start = values.copy()
        start[np.sort(inner)] = 0
        got = _hexes.harmonic(number[edges], start, int((~inner).sum()), np.ones(len(edges)))
        np.testing.assert_allclose(got, values, atol=1e-10)

    def test_free_points_move_where_the_worst_cells_get_better(self):
        # An octahedron of eight tetrahedra and a pyramid below it; the middle is near a face.
        points = np.array([[1.0, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1],
                           [0.32, 0.32, 0.32]])  # fmt: skip
        tets = np.array([[a, b, c, 6] if (a + b + c) % 2 else [b, a, c, 6]
                         for a in (0, 1) for b in (2, 3) for c in (4, 5)])  # fmt: skip
        shapes = _quality.tet_shapes(points[tets])
        tets[shapes < 0] = tets[shapes < 0][:, [1, 0, 2, 3]]
        start = points.copy()
        self.assertLess(_quality.tet_shapes(points[tets]).min(), 0.05)
        _polish.improve(points, tets, np.empty((0, 5), dtype=int), 6)
        self.assertGreater(_quality.tet_shapes(points[tets]).min(), _polish.TARGET)
        np.testing.assert_array_equal(points[:6], start[:6])
        self.assertLess(abs(_quality.tets(points, tets)[0].sum() / 4 * 3 - 1), 1e-14)
        # Nothing moves if no point may move, or if the mesh is good.
        for fixed, at in ((7, start), (6, points.copy())):
            again = at.copy()
            _polish.improve(again, tets, np.empty((0, 5), dtype=int), fixed)
            np.testing.assert_array_equal(again, at)

    def test_a_peak_stays_where_its_pyramid_would_suffer(self):
        base = [[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
        points = np.array([*base, [0.5, 0.5, 3], [0.5, 0.5, 0.1]])
        tets = np.array([[0, 1, 5, 4]])
        pyramids = np.array([[0, 1, 2, 3, 5]])
        before = _quality.pyramid_shapes(points[pyramids])[0], _quality.tet_shapes(points[tets])[0]
        _polish.improve(points, tets, pyramids, 5)
        after = _quality.pyramid_shapes(points[pyramids])[0], _quality.tet_shapes(points[tets])[0]
        self.assertGreater(min(after), min(before))

    def test_choices_are_joined_and_cut(self):
        surface, _ = surface_of(self.block())
        top, side = (_choose.elements(surface, t) for t in ("normal:0,0,1,40", "normal:1,0,0,40"))
        both = _choose.elements(surface, "normal:0,0,1,40 + normal:1,0,0,40")
        np.testing.assert_array_equal(both, top | side)
        self.assertFalse(_choose.elements(surface, "normal:0,0,1,40 & normal:1,0,0,40").any())


if __name__ == "__main__":
    unittest.main()
