"""Accuracy and cost: how errors are measured, and the tables and figures made from them."""

import unittest

import numpy as np

from post.figures import tradeoff as figures
from post.tests.samples import Scratch
from verification.page import put_table
from verification.tradeoff import __main__ as tradeoff
from verification.tradeoff import page

HEAD = (
    "group,name,mesh,elements,code,cpu_s,e_force,e_torque,e_traction,d_force,d_torque,d_traction\n"
)


class Made:
    """A curve at the given angles; the force on both sides is a function of the angle."""

    def __init__(self, degrees, one, two):
        self.degree = np.array(degrees, dtype=float)
        self.force = np.array([one(self.degree), two(self.degree)])

    mean = tradeoff.Curve.mean


class Difference(unittest.TestCase):
    def test_both_sides_and_common_degrees_count(self):
        wanted = Made(range(0, 181, 3), lambda t: 2 + 0 * t, lambda t: 4 + 0 * t)
        found = Made(range(0, 181, 9), lambda t: 3 + 0 * t, lambda t: 3.6 + 0 * t)
        error = tradeoff.difference(found, wanted, "force")
        self.assertAlmostEqual(error, np.sqrt(0.36 / 2) / 3)

    def test_degrees_of_a_cut_step_are_passed_over(self):
        wanted = Made((0, 3, 6), lambda t: 1 + t, lambda t: 1 + t)
        found = Made((0, 1.5, 3, 6), lambda t: 1 + t + (t == 1.5), lambda t: 1 + t)
        self.assertEqual(tradeoff.difference(found, wanted, "force"), 0.0)

    def test_without_common_degrees_there_is_none(self):
        wanted = Made((0, 3), lambda t: 1 + t, lambda t: 1 + t)
        found = Made((1, 2), lambda t: 1 + t, lambda t: 1 + t)
        self.assertIsNone(tradeoff.difference(found, wanted, "force"))


class Page(unittest.TestCase):
    def test_a_table_is_put_between_its_marks_only(self):
        text = "a\n<!-- table: x -->\nold\n<!-- end -->\nb <!-- table: y --><!-- end -->"
        new = put_table(text, "x", "| 1 |")
        self.assertEqual(new, text.replace("old", "| 1 |"))

    def test_a_run_that_failed_says_so(self):
        row = {"name": "Q2", "code": "2", "cpu_s": "2.5", "e_force": ""}
        line = page.row_of(row, {"name": "", "cpu_s": "", "e_force": ""})
        self.assertEqual(line, "| Q2 | 2.5 | ends with code 2 |")


class Figures(Scratch):
    def test_failed_runs_and_empty_cells_are_left_out(self):
        table = self.folder / "results.csv"
        rows = [
            "elements,Q1E9,1,Q1E9,0,0.8,0.4,0.5,0.4,,,",
            "elements,Q1E9,2,Q1E9,0,4.0,0.1,0.1,0.2,,,",
            "elements,Q2,1,Q2,2,2.6,,,,,,",
        ]
        for group in ("points", "penalty", "steps"):
            rows += [f"{group},{n},1,IGA2,0,{n},,,,{0.1 / n},{0.1 / n},{0.2 / n}" for n in (1, 3)]
        table.write_text(HEAD + "\n".join(rows) + "\n")
        figures.draw(table, self.folder)
        self.assertTrue((self.folder / "tradeoff_elements.png").exists())
        self.assertTrue((self.folder / "tradeoff_settings.png").exists())
        found = figures.Results(table)
        self.assertEqual(len(found.rows("elements", "Q2")), 0)
        self.assertTrue(np.isnan(found.number("d_force", found.rows("elements", "Q1E9"))).all())


if __name__ == "__main__":
    unittest.main()
