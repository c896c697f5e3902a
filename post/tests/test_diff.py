"""Comparison of runs and references: what is the same, what differs, what is unreadable."""

import contextlib
import io
import json
import unittest
from xml.etree import ElementTree

from post import _report
from post._error import Unreadable
from post.diff import main
from post.tests.samples import Scratch, write_curve, write_report, write_run


class Diff(Scratch):
    def diff(self, *words):
        """Return the exit code; what was printed is in self.said."""
        said = io.StringIO()
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            code = main([str(w) for w in words])
        self.said = said.getvalue()
        return code

    def curves(self, **of_b):
        """Write two curve files, a.dat and b.dat, the second one with changes."""
        write_curve(self.folder / "a.dat")
        write_curve(self.folder / "b.dat", **of_b)
        return self.folder / "a.dat", self.folder / "b.dat"


class Verdicts(Diff):
    def test_a_file_is_the_same_as_its_copy(self):
        self.assertEqual(self.diff(*self.curves(), "--exact"), 0)
        self.assertIn("same: 1 table, 8 columns, 80 values", self.said)

    def test_a_changed_value_differs_and_its_row_is_named(self):
        a, b = self.curves(
            force=lambda t: -0.3 * t + 0.05 * t**2 + (1e-4 if abs(t - 0.7) < 0.01 else 0)
        )
        self.assertEqual(self.diff(a, b), 1)
        self.assertRegex(self.said, r"force_top_3 .*differs in 1 .*row 7 \(time 0.7\)")

    def test_each_kind_of_tolerance_lets_its_difference_pass(self):
        a, b = self.curves(force=lambda t: -0.3 * t + 0.05 * t**2 + 1e-6)
        self.assertEqual(self.diff(a, b), 1)
        self.assertEqual(self.diff(a, b, "--abs", "1.1e-6"), 0)
        self.assertEqual(self.diff(a, b, "--abs", "0.9e-6"), 1)
        self.assertEqual(self.diff(a, b, "--scaled", "5e-6"), 0)  # largest magnitude 0.25
        self.assertEqual(self.diff(a, b, "--scaled", "3e-6"), 1)
        self.assertEqual(self.diff(a, b, "--rel", "5e-5"), 0)  # smallest magnitude 0.03
        self.assertEqual(self.diff(a, b, "--rel", "2e-5"), 1)

    def test_a_tolerance_can_name_its_column(self):
        a, b = self.curves(force=lambda t: -0.3 * t + 0.05 * t**2 + 1e-6)
        self.assertEqual(self.diff(a, b, "--abs", "force=2e-6"), 0)
        self.assertEqual(self.diff(a, b, "--abs", "disp=2e-6"), 1)
        self.assertEqual(self.diff(a, b, "--ignore", "force"), 0)

    def test_a_pattern_that_names_nothing_is_refused(self):
        self.assertEqual(self.diff(*self.curves(), "--abs", "forec=1"), 2)
        self.assertIn("no column matches 'forec'", self.said)

    def test_a_tolerance_that_is_none_is_refused(self):
        for word in ("nan", "-1", "inf", "much"):
            self.assertEqual(self.diff(*self.curves(), "--rel=" + word), 2, word)

    def test_a_missing_column_differs_and_is_named(self):
        a, b = self.curves(names=("disp_top_3", "torque"))
        self.assertEqual(self.diff(a, b), 1)
        self.assertIn("'torque' is missing in " + str(a), self.said)
        self.assertIn("'force_top_3' is missing in " + str(b), self.said)

    def test_different_lengths_differ(self):
        a, b = self.curves(steps=9, end=0.9)
        self.assertEqual(self.diff(a, b), 1)
        self.assertIn("expected 9 rows, found 10", self.said)

    def test_nan_differs_even_from_nan(self):
        a, b = self.curves(force=lambda t: float("nan") if t > 0.95 else -0.3 * t + 0.05 * t**2)
        self.assertEqual(self.diff(a, b, "--rel", "1e9"), 1)
        self.assertIn("NaN or infinity in the second", self.said)
        self.assertEqual(self.diff(b, b), 1)

    def test_unreadable_sides_end_with_code_2_and_one_line(self):
        a, b = self.curves()
        b.write_text(b.read_text()[:-40])
        self.assertEqual(self.diff(a, b), 2)
        self.assertEqual(len(self.said.strip().splitlines()), 1)
        for text in ("", "# step f\n", "words\n"):
            b.write_text(text)
            self.assertEqual(self.diff(a, b), 2, text)
        self.assertEqual(self.diff(a, self.folder / "none.dat"), 2)


class NothingPassesVacuously(Diff):
    def test_no_common_column_differs(self):
        a, b = self.folder / "a.dat", self.folder / "b.dat"
        a.write_text("# f\n1\n")
        b.write_text("# g\n1\n")
        self.assertEqual(self.diff(a, b), 1)
        self.assertIn("have no column in common", self.said)

    def test_everything_ignored_differs(self):
        self.assertEqual(self.diff(*self.curves(), "--ignore", "*"), 1)

    def test_folders_without_results_are_unreadable(self):
        self.assertEqual(self.diff(self.folder, self.folder), 2)

    def test_no_common_row_differs(self):
        a, b = self.folder / "a.csv", self.folder / "b.csv"
        a.write_text("n,f\n1,2\n")
        b.write_text("n,f\n2,2\n")
        self.assertEqual(self.diff(a, b, "--key", "n"), 1)
        self.assertIn("have no row in common", self.said)


class Interpolation(Diff):
    line = staticmethod(lambda t: 2.0 * t)

    def test_other_steps_of_a_linear_path_are_the_same(self):
        a, b = self.folder / "a.dat", self.folder / "b.dat"
        write_curve(a, steps=20, force=self.line)
        write_curve(b, steps=7, force=self.line)
        self.assertEqual(self.diff(a, b), 1)
        self.assertEqual(self.diff(a, b, "--interpolate", "time"), 0)
        self.assertEqual(
            self.diff(b, a, "--interpolate", "time"), 0
        )  # rows before the first step are noted

    def test_a_run_that_stops_early_differs(self):
        a, b = self.folder / "a.dat", self.folder / "b.dat"
        write_curve(a, steps=20, force=self.line, end=0.9)
        write_curve(b, steps=7, force=self.line)
        self.assertEqual(self.diff(a, b, "--interpolate", "time"), 1)
        self.assertIn("time ends at 0.9, expected 1", self.said)

    def test_a_key_that_turns_back_is_refused(self):
        a, b = self.folder / "a.dat", self.folder / "b.dat"
        a.write_text("# time f\n0.1 1\n0.3 2\n0.2 3\n")
        b.write_text("# time f\n0.1 1\n0.2 2\n")
        self.assertEqual(self.diff(a, b, "--interpolate", "time"), 2)
        self.assertIn("does not increase at row 3", self.said)


class Runs(Diff):
    def test_folders_stems_and_files_can_be_compared(self):
        a, b = write_run(self.folder / "a"), write_run(self.folder / "b", stem="other")
        self.assertEqual(self.diff(a, b), 0)
        self.assertEqual(self.diff(a / "cube", b / "other"), 0)
        self.assertEqual(self.diff(a, b / "other_force.dat"), 0)
        self.assertEqual(self.diff(a / "cube", b / "other.report.json"), 0)

    def test_a_report_is_compared_without_its_timings(self):
        a, b = write_run(self.folder / "a"), write_run(self.folder / "b")
        write_report(b / "cube.report.json", seconds={"assembly": 9.0}, version="2")
        self.assertEqual(self.diff(a, b), 0)
        write_report(b / "cube.report.json", status="stopped")
        self.assertEqual(self.diff(a, b), 1)
        self.assertRegex(self.said, "status .*done .*stopped")

    def test_a_report_of_another_format_is_unreadable(self):
        write_report(self.folder / "a.report.json", format=2)
        with self.assertRaisesRegex(
            Unreadable, "has report format 2, and this program reads format 1"
        ):
            _report.load(self.folder / "a.report.json")

    def test_a_file_on_one_side_only_differs(self):
        a, b = write_run(self.folder / "a"), write_run(self.folder / "b")
        write_curve(b / "cube_torque.dat")
        self.assertEqual(self.diff(a, b), 1)
        self.assertIn("'torque' of", self.said)

    def test_a_curve_may_have_the_name_of_another_part(self):
        for name in ("report", "fields"):
            a, b = write_run(self.folder / "a"), write_run(self.folder / "b")
            write_curve(a / f"cube_{name}.dat")
            write_curve(b / f"cube_{name}.dat", force=lambda t: -0.33 * t)
            self.assertEqual(self.diff(a, b), 1)
            self.assertEqual(self.diff(a / "cube", b / "cube"), 1)
            self.assertIn(f"{name}.dat", self.said)
            write_report(a / "cube.report.json", status="stopped")
            self.assertEqual(self.diff(a / "cube", b / "cube"), 1)
            self.assertRegex(self.said, "status .*stopped .*done")

    def test_json_files_beside_a_report_do_not_replace_it(self):
        a, b = write_run(self.folder / "a"), write_run(self.folder / "b")
        write_report(b / "cube.report.json", status="failed")
        for run in (a, b):
            (run / "part.mesh.json").write_text('{"degree": 2}')
        self.assertEqual(self.diff(a, b), 1)
        self.assertRegex(self.said, "status .*done .*failed")
        self.assertIn("'part.mesh.json' is not compared: it is not the report of a run", self.said)
        self.assertEqual(self.diff(a, b / "cube.report.json"), 1)
        write_report(b / "cube.report.json")
        (b / "part.mesh.json").unlink()
        (a / "diff.json").write_text("[]")  # neither a report nor on both sides
        self.assertEqual(self.diff(a, b), 0)
        (b / "part.mesh.json").write_text('{"degree": 3}')
        self.assertEqual(self.diff(a, b / "part.mesh.json"), 1)

    def test_several_json_files_without_a_report_are_all_compared(self):
        for run, value in (("a", 1), ("b", 2)):
            (self.folder / run).mkdir()
            (self.folder / run / "1.json").write_text(f'{{"f": {value}}}')
            (self.folder / run / "2.json").write_text('{"f": 1}')
        self.assertEqual(self.diff(self.folder / "a", self.folder / "b"), 1)

    def test_a_table_beside_a_curve_does_not_replace_it(self):
        a, b = write_run(self.folder / "a"), write_run(self.folder / "b")
        for name in ("force.csv", "force.dat"):
            write_curve(b / "cube_force.dat", force=lambda t: -0.33 * t)
            for run in (a, b):
                (run / name).write_text("# f\n1\n" if name.endswith(".dat") else "f\n1\n")
            self.assertEqual(self.diff(a, b), 1)
            self.assertRegex(self.said, "force_top_3 .*differs in 10")
            write_curve(b / "cube_force.dat")
            self.assertEqual(self.diff(a, b), 0)
            (b / name).write_text((b / name).read_text().replace("1", "2"))
            self.assertEqual(self.diff(a, b), 1)
            self.assertIn(f"{name}: ", self.said)
            for run in (a, b):
                (run / name).unlink()

    def test_a_single_curve_may_be_called_report(self):
        write_curve(self.folder / "report.dat")
        write_curve(self.folder / "fields.dat", steps=5)
        self.assertEqual(
            self.diff(
                self.folder / "report.dat", self.folder / "fields.dat",
                "--interpolate", "time", "--scaled", "0.1",
            ),
            0,
        )  # fmt: skip

    def test_curves_without_rows_do_not_keep_the_others_from_being_compared(self):
        a, b = write_run(self.folder / "a"), write_run(self.folder / "b")
        for run in (a, b):
            write_curve(run / "cube_tplot.dat", steps=0)
        self.assertEqual(self.diff(a, b), 0)
        self.assertIn("'tplot' is not compared: it has no rows", self.said)
        write_curve(a / "cube_tplot.dat")
        self.assertEqual(self.diff(a, b), 1)
        self.assertEqual(self.diff(b, a), 1)
        self.assertIn("'tplot' of", self.said)
        write_curve(a / "cube_force.dat", force=lambda t: -0.33 * t)
        write_curve(a / "cube_tplot.dat", steps=0)
        self.assertEqual(self.diff(a, b), 1)
        self.assertEqual(self.diff(b / "cube_tplot.dat", b / "cube_tplot.dat"), 2)

    def test_a_stem_does_not_contain_the_files_of_a_longer_one(self):
        a, b = write_run(self.folder / "a"), write_run(self.folder / "b")
        write_run(self.folder / "a", stem="cube_2")
        self.assertEqual(self.diff(a / "cube", b / "cube"), 0)
        self.assertEqual(self.diff(a / "cube_2", b / "cube"), 0)

    def test_rows_are_matched_by_key_and_a_csv_reference_may_select(self):
        a, b = self.folder / "a.csv", self.folder / "b.csv"
        a.write_text("elements,n,f,g\nQ1,2,0.5,1\nQ2,2,0.6,1\nQ1,4,0.7,1\n")
        b.write_text("elements,n,f\nQ1,4,0.7\nQ1,2,0.5\n")
        self.assertEqual(self.diff(a, b, "--key", "elements,n"), 0)

    def test_words_against_numbers_are_unreadable(self):
        a, b = self.folder / "a.csv", self.folder / "b.csv"
        a.write_text("n,f\n1,abc\n")
        b.write_text("n,f\n1,2\n")
        self.assertEqual(self.diff(a, b), 2)


class Outputs(Diff):
    def test_json_and_junit_tell_the_same(self):
        a, b = self.curves(force=lambda t: float("nan"))
        files = "--json", self.folder / "r.json", "--junit", self.folder / "r.xml"
        self.assertEqual(self.diff(a, b, *files), 1)
        result = json.loads((self.folder / "r.json").read_text())
        self.assertEqual(result["result"], "differs")
        bad = [c["name"] for c in result["tables"][0]["columns"] if not c["ok"]]
        failures = ElementTree.parse(self.folder / "r.xml").getroot().iter("testcase")
        self.assertEqual(bad, [c.get("name") for c in failures if c.find("failure") is not None])

    def test_unreadable_is_written_too(self):
        a, _ = self.curves()
        self.assertEqual(self.diff(a, self.folder / "none", "--json", self.folder / "r.json"), 2)
        self.assertEqual(json.loads((self.folder / "r.json").read_text())["result"], "unreadable")

    def test_expect_gives_tolerances(self):
        a, b = self.curves(force=lambda t: -0.3 * t + 0.05 * t**2 + 1e-6)
        expect = self.folder / "expect.toml"
        expect.write_text("[diff]\nrel = 1e-9\ncolumn.force = { abs = 2e-6 }\n")
        self.assertEqual(self.diff(a, b, "--expect", expect), 0)
        expect.write_text("title = 'none'\n")
        self.assertEqual(self.diff(a, b, "--expect", expect), 2)

    def test_what_is_wrong_in_expect_is_said(self):
        a, b = self.curves()
        expect = self.folder / "expect.toml"
        for text, words in (
            ('rel = "x"', "rel = 'x' is not a number"),
            ("column.force = { asb = 1e-3 }", "column.force: unknown entry 'asb'"),
            ("column.force = 1e-3", "force is not a table"),
            ('column = "force"', "column is not a table"),
            ('key = "step"', "key = 'step' is not a list"),
            ("only = [1]", "only = .1. is not a list"),
            ("interpolate = 1", "interpolate = 1 is not the name of a column"),
        ):
            expect.write_text(f"[diff]\n{text}\n")
            self.assertEqual(self.diff(a, b, "--expect", expect), 2, text)
            self.assertRegex(self.said, words)
        expect.write_text("diff = 1\n")
        self.assertEqual(self.diff(a, b, "--expect", expect), 2)


class Update(Diff):
    def test_old_and_new_are_shown_and_only_those_cells_change(self):
        a, b = self.folder / "a.csv", self.folder / "b.csv"
        b.write_text("# origin\nelements,n,f\nQ1,2,0.50\nQ2,2,0.6\n")
        a.write_text("elements,n,f\nQ2,2,0.625\nQ1,2,0.5000000000001\n")
        self.assertEqual(self.diff(a, b, "--key", "elements,n", "--update"), 0)
        self.assertIn("f, row 2: 0.6 -> 0.625", self.said)
        self.assertEqual(b.read_text(), "# origin\nelements,n,f\nQ1,2,0.50\nQ2,2,0.625\n")
        self.assertEqual(self.diff(a, b, "--key", "elements,n"), 0)

    def test_a_curve_with_new_rows_is_rewritten(self):
        a, b = self.curves(steps=5)
        self.assertEqual(self.diff(a, b, "--update"), 0)
        self.assertEqual(self.diff(a, b, "--exact"), 0)

    def test_comments_of_a_curve_that_is_rewritten_are_kept(self):
        a, b = self.curves(steps=5)
        names, *rest = b.read_text().splitlines()
        b.write_text("\n".join([names, "# made by hand", *rest]) + "\n")
        self.assertEqual(self.diff(a, b, "--update"), 0)
        self.assertIn("# made by hand", b.read_text())
        self.assertEqual(self.diff(a, b, "--exact"), 0)

    def test_other_rows_with_a_choice_of_columns_are_refused(self):
        a, b = self.curves(steps=5)
        old = b.read_text()
        self.assertEqual(self.diff(a, b, "--only", "force", "--update"), 2)
        self.assertIn("would change columns that --only leaves out", self.said)
        self.assertEqual(b.read_text(), old)

    def test_a_report_is_rewritten(self):
        a, b = write_run(self.folder / "a"), write_run(self.folder / "b")
        write_report(a / "cube.report.json", iterations=31)
        self.assertEqual(self.diff(a, b, "--update"), 0)
        self.assertIn("iterations, the report: 30 -> 31", self.said)
        self.assertEqual(self.diff(a, b), 0)

    def test_a_report_is_not_rewritten_for_a_choice_of_entries(self):
        a, b = write_run(self.folder / "a"), write_run(self.folder / "b")
        write_report(a / "cube.report.json", iterations=31)
        old = (b / "cube.report.json").read_text()
        self.assertEqual(self.diff(a, b, "--only", "iterations", "--update"), 2)
        self.assertIn("only be rewritten as a whole", self.said)
        self.assertEqual((b / "cube.report.json").read_text(), old)

    def test_nan_never_becomes_a_reference(self):
        b, a = self.curves(force=lambda t: float("nan"))
        old = b.read_text()
        self.assertEqual(self.diff(a, b, "--update"), 2)
        self.assertEqual(b.read_text(), old)
        write_curve(a, force=lambda t: float("nan") if t > 0.6 else t)
        write_curve(b, steps=5, end=0.5, force=lambda t: t)
        old = b.read_text()
        self.assertEqual(self.diff(a, b, "--update"), 2)
        self.assertEqual(b.read_text(), old)

    def test_a_lost_row_is_not_kept_silently(self):
        a, b = self.folder / "a.csv", self.folder / "b.csv"
        a.write_text("n,f\n1,1\n2,6\n4,7\n")
        old = "n,f\n1,1\n2,5\n3,9\n"
        b.write_text(old)
        self.assertEqual(self.diff(a, b, "--key", "n", "--update"), 2)
        self.assertIn("1 rows are missing in " + str(a), self.said)
        self.assertEqual(b.read_text(), old)

    def test_a_curve_with_new_rows_of_a_key_is_rewritten(self):
        a, b = self.folder / "a.dat", self.folder / "b.dat"
        a.write_text("# n f\n1 1\n2 6\n3 7\n")
        b.write_text("# n f\n2 5\n1 1\n")
        self.assertEqual(self.diff(a, b, "--key", "n", "--update"), 0)
        self.assertEqual(self.diff(a, b, "--key", "n"), 0)

    def test_an_update_that_compares_nothing_is_refused(self):
        a, b = self.curves(force=lambda t: -0.33 * t)
        self.assertEqual(self.diff(a, b, "--ignore", "*", "--update"), 2)
        self.assertIn("nothing was written", self.said)

    def test_an_update_writes_its_comparison_too(self):
        a, b = self.curves(force=lambda t: -0.33 * t)
        self.assertEqual(self.diff(a, b, "--update", "--json", self.folder / "r.json"), 0)
        self.assertEqual(json.loads((self.folder / "r.json").read_text())["result"], "differs")

    def test_a_lost_column_is_not_dropped_silently(self):
        a, b = self.curves(names=("disp_top_3", "torque"))
        old = b.read_text()
        self.assertEqual(self.diff(a, b, "--update"), 2)
        self.assertEqual(b.read_text(), old)


if __name__ == "__main__":
    unittest.main()
