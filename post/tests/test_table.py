"""Reading of curve files, .csv files and reports."""

import unittest

from post._error import Unreadable
from post._report import read_report
from post._table import read_table
from post.tests.samples import Scratch, write_curve, write_report


class CurveFile(Scratch):
    def read(self, text):
        (self.folder / "a.dat").write_text(text)
        return read_table(self.folder / "a.dat")

    def refused(self, text, words):
        with self.assertRaisesRegex(Unreadable, words):
            self.read(text)

    def test_columns_are_read_by_name(self):
        write_curve(self.folder / "a.dat")
        table = read_table(self.folder / "a.dat")
        self.assertEqual(len(table), 10)
        self.assertEqual(table.quantities(), ["disp_top_3", "force_top_3"])
        self.assertAlmostEqual(table.columns["force_top_3"][-1], -0.25, 14)

    def test_a_three_digit_exponent_without_its_letter_is_a_number(self):
        self.assertEqual(self.read("# step f\n 1 1.0000000000000000-105\n").columns["f"][0], 1e-105)

    def test_a_beginning_that_fits_two_columns_is_refused(self):
        table = self.read("# step force_1 force_2\n1 2 3\n")
        with self.assertRaisesRegex(Unreadable, "several columns"):
            table.find("force")
        self.assertEqual(table.find("FORCE_2"), "force_2")

    def test_a_misspelt_column_gets_a_hint(self):
        with self.assertRaisesRegex(Unreadable, "did you mean 'force'"):
            self.read("# step force\n1 2\n").find("forec")

    def test_what_cannot_be_read_is_said(self):
        self.refused("", "is empty")
        self.refused("1 2\n", "line of column names after '#'")
        self.refused("# step f\n", "no rows")
        self.refused("# step f\n1 2\n2\n", "line 3 .*expected 2 numbers, found 1.*truncated")
        self.refused("# step f\n1 2\n2 3.", "is incomplete: the file is truncated")
        self.refused("# step f\n1 *****\n", r"'\*\*\*\*\*' is not a number")
        self.refused("# step f f\n1 2 3\n", "duplicate column 'f'")

    def test_what_is_no_text_file_is_said(self):
        with self.assertRaisesRegex(Unreadable, "does not exist"):
            read_table(self.folder / "none.dat")
        with self.assertRaisesRegex(Unreadable, "not a regular file"):
            read_table(self.folder)
        (self.folder / "b.dat").write_bytes(bytes(range(128, 256)))
        with self.assertRaisesRegex(Unreadable, "not a text file"):
            read_table(self.folder / "b.dat")


class CsvFile(Scratch):
    def test_words_and_numbers_and_comments_are_kept_apart(self):
        path = self.folder / "a.csv"
        path.write_text('# origin\nelements,n,f\n"Q1, fine",2,0.5\nQ2,4,1e-3\n')
        table = read_table(path)
        self.assertEqual(table.comments, ["# origin"])
        self.assertEqual(list(table.columns["elements"]), ["Q1, fine", "Q2"])
        self.assertEqual(list(table.columns["n"]), [2.0, 4.0])

    def test_a_mark_at_the_start_is_not_part_of_a_name(self):
        path = self.folder / "a.csv"
        path.write_bytes(b"\xef\xbb\xbftime,f\n0,1\n")
        self.assertEqual(list(read_table(path).columns), ["time", "f"])

    def test_a_short_line_is_named(self):
        path = self.folder / "a.csv"
        path.write_text("# origin\na,b\n1,2\n3\n")
        with self.assertRaisesRegex(Unreadable, "line 4 .* expected 2 fields, found 1"):
            read_table(path)


class Report(Scratch):
    def test_nested_entries_get_dotted_names_and_timings_are_left_out(self):
        write_report(self.folder / "a.report.json")
        columns = read_report(self.folder / "a.report.json").columns
        self.assertEqual(columns["elements.Q1"][0], 12)
        self.assertEqual(columns["final.force.force_top_3"][0], -0.25)
        self.assertFalse([n for n in columns if n.startswith(("seconds", "peak", "version"))])

    def test_a_cut_report_is_unreadable(self):
        write_report(self.folder / "a.report.json")
        text = (self.folder / "a.report.json").read_text()
        (self.folder / "a.report.json").write_text(text[:100])
        with self.assertRaisesRegex(Unreadable, "is not JSON"):
            read_report(self.folder / "a.report.json")


if __name__ == "__main__":
    unittest.main()
