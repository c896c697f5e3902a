"""Curves and convergence: what is drawn, and the figure files."""

import contextlib
import io
import unittest

import numpy as np

from post import _style, convergence, curve
from post.__main__ import main
from post._error import Unreadable
from post.figures import contact, section4, section5_debonding
from post.tests.samples import Scratch, write_curve

TABLE = """# made up
test,elements,n,dofs,force
compression,Q1,1,36,1.04
compression,Q1,2,135,1.01
compression,Q2,2,675,1.001
extension,Q1,2,135,2.5
"""


class Style(unittest.TestCase):
    def test_element_types_differ_in_colour_and_the_same_type_does_not(self):
        colours = {name: colour for name, (colour, _) in _style.ELEMENTS.items()}
        self.assertEqual(colours.pop("Q2N2"), colours["Q2+Q2N2"])  # two names of one type
        self.assertEqual(len(set(colours.values())), len(colours))

    def test_an_unknown_type_is_grey(self):
        self.assertFalse(_style.is_element("Q7"))
        self.assertEqual(_style.element("Q7")["color"], "#666666")


class Debonding(Scratch):
    def test_a_lift_that_decreases_counts_where_it_is_reached_first(self):
        lift, force = np.array([1.0, 2.0, 1.5, 3.0]), np.array([1.0, 2.0, 9.0, 3.0])
        found = section5_debonding.reached(np.array([0.5, 1.5, 2.5]), lift, force)
        np.testing.assert_allclose(found, [0.5, 1.5, 2.5], rtol=1e-14)

    def test_the_committed_curves_are_drawn(self):
        with contextlib.redirect_stdout(io.StringIO()) as said:
            options = ["--fields", str(self.folder), "--to", str(self.folder)]
            self.assertEqual(section5_debonding.main(options), 0)
        self.assertIn("Figures 13 and 14 are not drawn", said.getvalue())
        names = {path.name for path in self.folder.glob("*.png")}
        self.assertIn("section5_figure16_mesh2.png", names)
        self.assertEqual(len(names), 9)


class Curve(Scratch):
    def test_a_figure_without_an_ending_is_named_as_it_is_written(self):
        write_curve(self.folder / "a.dat")
        for given, written in (("fig", "fig.png"), ("fig.PDF", "fig.PDF")):
            said = io.StringIO()
            with contextlib.redirect_stdout(said):
                main(["curve", str(self.folder / "a.dat"), "-o", str(self.folder / given)])
            self.assertIn(f"wrote {self.folder / written}\n", said.getvalue())
            self.assertTrue((self.folder / written).is_file())

    def test_columns_of_two_files_are_drawn_over_each_other(self):
        files = [self.folder / "a.dat", self.folder / "b.dat"]
        write_curve(files[0])
        write_curve(files[1], steps=100)
        from post._table import read_table

        with _style.styled() as plt:
            _, ax = plt.subplots()
            names = curve.plot(ax, [read_table(f) for f in files], "disp", ["force"])
            self.assertEqual(names, ["disp_top_3", "force_top_3", "force_top_3"])
            self.assertEqual([len(line.get_xdata()) for line in ax.lines], [10, 100])
            self.assertEqual(len({line.get_color() for line in ax.lines}), 2)

    def test_the_same_data_give_the_same_file(self):
        write_curve(self.folder / "a.dat")
        for name in ("1.png", "2.png"):
            with contextlib.redirect_stdout(io.StringIO()):
                curve.draw([self.folder / "a.dat"], self.folder / name)
        self.assertEqual((self.folder / "1.png").read_bytes(), (self.folder / "2.png").read_bytes())

    def test_the_command_lists_columns_and_names_a_missing_one(self):
        write_curve(self.folder / "a.dat")
        said = io.StringIO()
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            self.assertEqual(main(["curve", str(self.folder / "a.dat"), "--list"]), 0)
            self.assertEqual(main(["curve", str(self.folder / "a.dat"), "-y", "torque"]), 2)
            self.assertEqual(main(["curv"]), 2)
        self.assertIn("force_top_3: -0.25 to -0.0295", said.getvalue())
        self.assertIn("no column 'torque'", said.getvalue())
        self.assertIn("did you mean 'curve'", said.getvalue())


class Convergence(Scratch):
    def setUp(self):
        super().setUp()
        self.table = self.folder / "t.csv"
        self.table.write_text(TABLE)

    def test_errors_and_slopes_are_those_of_the_table(self):
        series = convergence.read_series(self.table, reference=1.0, where={"test": "compression"})
        self.assertEqual([s.name for s in series], ["Q1", "Q2"])
        np.testing.assert_allclose(series[0].error, [0.04, 0.01], rtol=1e-12)
        self.assertAlmostEqual(series[0].slopes()[0], np.log(0.25) / np.log(135 / 36), 12)

    def test_what_is_not_said_is_asked_for(self):
        for words, options in (
            ("several columns of words", {"reference": 1.0}),
            ("no row", {"reference": 1.0, "where": {"test": "torsion"}}),
            ("no column 'error'", {}),
            ("zero or not finite", {"reference": 0.0, "where": {"test": "extension"}}),
            ("'n' of t.csv contains numbers, and 'x' is not one", {"where": {"n": "x"}}),
        ):
            with self.assertRaisesRegex(Unreadable, words):
                convergence.read_series(self.table, **options)

    def test_the_column_that_is_taken_is_named(self):
        self.table.write_text("n,dofs,force,seconds\n1,36,1.04,3\n2,135,1.01,9\n")
        words = ["--reference", "1", "-o", str(self.folder / "c.png")]
        for more, found in (([], True), (["-y", "force"], False)):
            with contextlib.redirect_stdout(io.StringIO()) as said:
                self.assertEqual(main(["convergence", str(self.table), *words, *more]), 0)
            line = "values of column 'seconds'"
            self.assertEqual(line in said.getvalue(), found)

    def test_a_negative_reference_may_have_an_exponent(self):
        self.table.write_text("n,dofs,force\n1,36,-1.04e-3\n2,135,-1.01e-3\n")
        words = ["-y", "force", "--reference", "-1e-3", "-o", str(self.folder / "c.png")]
        with contextlib.redirect_stdout(io.StringIO()) as said:
            self.assertEqual(main(["convergence", str(self.table), *words]), 0)
        self.assertIn("4.000e-02", said.getvalue())

    def test_the_command_draws(self):
        with contextlib.redirect_stdout(io.StringIO()) as said:
            words = [
                "--where",
                "test=compression",
                "--reference",
                "1",
                "-o",
                str(self.folder / "c.png"),
            ]
            self.assertEqual(main(["convergence", str(self.table), *words]), 0)
        self.assertTrue((self.folder / "c.png").stat().st_size > 5000)
        self.assertRegex(said.getvalue(), r"Q1 +135 +1.000e-02 +-1.05")


class Section4(Scratch):
    def setUp(self):
        super().setUp()
        rows = ["test,elements,n,dofs,force_quarter,error"]
        for test, force in (("compression", -0.08), ("extension", 0.17)):
            for elements, error in (("Q1", 0.04), ("Q1E9", 0.02), ("Q2", 0.01), ("IGA2", 0.01),
                                    ("Q1N2 on 1+", 0.02), ("Q1N2 on 1+ and 2+", 0.01)):  # fmt: skip
                for n in (4, 1, 2):
                    rows.append(
                        f"{test},{elements},{n},{100 * n**3},{force * (1 + error / n)},{error / n}"
                    )
        self.results = self.folder / "results.csv"
        self.results.write_text("\n".join(rows) + "\n")

    def test_forces_and_improvements_are_those_of_the_table(self):
        extension = section4.Results(self.results, "extension")
        self.assertAlmostEqual(extension.converged(), 4 * 0.17, 12)
        mesh, factor = section4.improvement(extension, "Q1N2 on 1+ and 2+")
        np.testing.assert_array_equal(mesh, [1, 2, 3])
        np.testing.assert_allclose(factor, 4.0, rtol=1e-12)

    def test_all_figures_are_drawn(self):
        with contextlib.redirect_stdout(io.StringIO()):
            self.assertEqual(
                section4.main(["--results", str(self.results), "--to", str(self.folder)]), 0
            )
        self.assertEqual(len(list(self.folder.glob("section4_*.png"))), 4)


class Contact(Scratch):
    def test_the_committed_curves_are_drawn(self):
        with contextlib.redirect_stdout(io.StringIO()):
            self.assertEqual(contact.main(["--to", str(self.folder)]), 0)
        names = sorted(path.name for path in self.folder.glob("*.png"))
        self.assertEqual(names, [f"contact_{n}.png" for n in ("hertz", "ironing", "mindlin")])

    def test_a_folder_without_curves_is_an_error(self):
        with self.assertRaisesRegex(Unreadable, "cannot be read"):
            contact.draw(self.folder, self.folder)


if __name__ == "__main__":
    unittest.main()
