"""The second implementation against closed forms, finite differences and the program
(BEZEL=...).
"""

import contextlib
import io
import os
import unittest

import numpy as np

from post._table import read_table
from verification import TOP
from verification.reference import __main__ as tables
from verification.reference import hemisphere, section4, strip
from verification.reference.spline import Space

BEZEL = os.environ.get("BEZEL", TOP / "build/release/bezel")


def differences(scene, *words):
    """The largest difference from the program in one problem."""
    options = tables.parser().parse_args([*words, "--compare", str(BEZEL)])
    with contextlib.redirect_stdout(io.StringIO()):
        return scene(options)


class Parts(unittest.TestCase):
    def test_functions_sum_to_one_and_reproduce_the_identity(self):
        x = np.linspace(0, 1, 23)
        for space in (
            Space(1, 4),
            Space(2, 3),
            Space(2, 3, 2),
            Space(2, 3).elevated(1),
            Space(3, 5),
        ):
            M = space.matrix(x)
            np.testing.assert_allclose(M.sum(axis=1), 1, atol=1e-14)
            np.testing.assert_allclose(M @ space.greville, x, atol=1e-14)

    def test_derivatives_of_functions_are_differences(self):
        space, x, h = Space(3, 4), np.linspace(0.03, 0.96, 11), 1e-5
        at = lambda y: space.basis(y)[1]
        difference = (at(x + h) - at(x - h)) / (2 * h)
        np.testing.assert_allclose(at(x)[:, 1:], difference[:, :2], rtol=1e-6, atol=1e-6)

    def test_numbers_of_degrees_of_freedom_are_those_of_table_4(self):
        counts = {"IGA2": 417, "Q1E9+Q1N2": 225, "Q1E9+Q1N3": 285, "Q1E9+Q1N2.1": 402}
        for name, dofs in counts.items():
            self.assertEqual(hemisphere.build(name, 1, 0.0)[0].dofs, dofs)

    def test_numbers_of_degrees_of_freedom_are_those_of_table_2(self):
        self.assertEqual(strip.build("IGA2")[0].dofs, 2304)
        self.assertEqual(strip.build("Q1E9+Q1N2")[0].dofs, 1500)

    def test_tangent_is_the_derivative_of_the_forces(self):
        """The state has contact, stick, slip and enhanced strains, and is not an equilibrium."""
        system, place = hemisphere.build("Q1E9+Q1N2", 1, 0.5)
        place(0.1, 0)
        system.solve()
        place(0.3, 0)
        system.solve()
        system.contact.accept()
        place(0.3, 6)
        system.solve()
        u = system.u + np.random.default_rng(1).normal(size=system.u.shape) * 1e-3

        def at(v):
            f, K = system.bulk(v)
            system.contact.add(system.X, v, f, K)
            return f, K

        K = at(u)[1]
        slips = np.concatenate([s.slips for s in system.contact.sides])
        self.assertTrue(slips.any() and not slips.all())
        way = np.random.default_rng(2).normal(size=u.shape)
        h = 1e-6
        difference = (at(u + h * way)[0] - at(u - h * way)[0]) / (2 * h)
        np.testing.assert_allclose(K @ way.ravel(), difference, atol=1e-6 * abs(difference).max())

    def test_state_of_a_held_load_does_not_creep(self):
        """The load is steady if sliding points are moved exactly; if only to first order, it
        creeps.
        """
        creep = {}
        for exact in (True, False):
            system, place = hemisphere.build("Q1E9+Q1N2", 1, 0.5, exact)
            for down, degrees in ((0.1, 0), (0.3, 0), (0.3, 6), (0.3, 12)):
                place(down, degrees)
                system.solve()
                system.contact.accept()
            torque = system.contact.sides[0].resultant()[1][2]
            system.solve()
            creep[exact] = abs(system.contact.sides[0].resultant()[1][2] / torque - 1)
        self.assertLess(creep[True], 1e-10)
        self.assertGreater(creep[False], 1e-7)


class Stored(unittest.TestCase):
    def test_section4(self):
        """Compare with the numbers of reference.csv, for which prisms have two points along
        zeta.
        """
        rows = read_table(TOP / "verification/benchmark/section4/reference.csv").columns
        for test, name, dofs, force in zip(
            rows["test"], rows["elements"], rows["dofs"], rows["force_quarter"]
        ):
            if not name.startswith("Q2"):  # Q2 takes longer than all other elements together
                found = section4.solve(name, 2, section4.LIFTS[test], prism_points=2)
                self.assertEqual(found[1], dofs)
                self.assertAlmostEqual(found[0] / force, 1, delta=1e-9)


class Program(unittest.TestCase):
    """The program gives the same numbers, on the smallest meshes."""

    def test_section4(self):
        scene = tables.run_section4
        self.assertLess(differences(scene, "section4", "--n", "1"), 1e-10)
        some = ("--n", "2", "--elements", "Q1", "Q1E9", "Q1N2 on 1+ and 2+")
        self.assertLess(differences(scene, "section4", *some), 1e-10)

    def test_hemisphere_with_friction(self):
        some = ("--elements", "Q1E9+Q1N2", "--mu", "0.5", "--degrees", "15", "--down", "5")
        self.assertLess(differences(tables.run_hemisphere, "hemisphere", *some), 1e-8)


if __name__ == "__main__":
    unittest.main()
