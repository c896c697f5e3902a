"""Files that a run with RESTart continues belong to the run of its checkpoint."""

import json
import shutil

import h5py

from verification.trouble.test_files import Folder


class ContinuedFiles(Folder):
    """Files that are continued belong to the run of the checkpoint and have its columns and fields."""

    def setUp(self):
        super().setUp()
        self.deck = self.deck.replace("time,10", "time,2").replace("DT,,0.1", "DT,,0.2")
        self.run_as("box")

    def run_as(self, name, *changes, code=0, options=(), restart=""):
        """Run the deck under a name with these changes; return what the run says."""
        text = self.deck
        for old, new in changes:
            self.assertIn(old, text)
            text = text.replace(old, new)
        if restart:
            text = text.replace("BATCh\n", f"BATCh\n  {restart}\n")
        (self.at / "deck.inp").write_text(text)
        done = self.run_bezel("--name", name, *options, "deck.inp")
        self.assertEqual(done.returncode, code, done.stderr)
        return done.stderr

    def table(self, name, curve="force"):
        """The names of the columns and the rows of a curve."""
        head, *rows = (self.at / f"{name}_{curve}.dat").read_text().splitlines()
        return head[1:].split(), [[float(word) for word in row.split()] for row in rows]

    def test_other_quantities_begin_a_new_table(self):
        before = self.table("box")
        for change in ("DISP a 3+ 3", "FORCe a 3- 3\n  DISP a 3+ 3"):
            with self.subTest(change):
                self.run_as("box")
                said = self.run_as("box", ("FORCe a 3- 3", change), restart="RESTart")
                self.assertIn("has other columns than its table before the restart", said)
                self.assertIn("1 warning", said)
                head, rows = self.table("box")
                self.assertEqual([row[0] for row in rows], [3, 4])
                self.assertEqual({len(row) for row in rows}, {len(head)})
                (self.at / "box_force.dat.old").rename(self.at / "old_force.dat")
                self.assertEqual(self.table("old"), before)

    def test_a_table_that_the_run_of_the_checkpoint_did_not_write_is_set_aside(self):
        more = ("CURVe,force\n", "CURVe,more\n  DISP a 3+ 3\n\nCURVe,force\n")
        self.run_as("box", more)
        before = self.table("box", "more")
        self.run_as("box")
        said = self.run_as("box", more, restart="RESTart")
        self.assertIn("the run of the checkpoint did not write this table", said)
        self.assertEqual([row[0] for row in self.table("box")[1]], [1, 2, 3, 4])
        self.assertEqual([row[0] for row in self.table("box", "more")[1]], [3, 4])
        (self.at / "box_more.dat.old").rename(self.at / "old_more.dat")
        self.assertEqual(self.table("old", "more"), before)

    def test_a_checkpoint_lies_beside_the_deck_or_in_the_working_folder(self):
        deck = self.deck.replace("BATCh\n", "BATCh\n  RESTart,box.restart.h5\n")
        (self.at / "sub").mkdir()
        (self.at / "sub" / "next.inp").write_text(deck)
        self.assertEqual(self.run_bezel("sub/next.inp").returncode, 0)
        shutil.copy(self.at / "next.restart.h5", self.at / "sub" / "box.restart.h5")
        self.assertEqual(self.run_bezel("sub/next.inp").returncode, 0)
        self.assertEqual([row[0] for row in self.table("next")[1]], [3, 4, 5, 6])

    def test_a_table_that_the_deck_does_not_continue_loses_the_steps_after_the_checkpoint(self):
        more = ("CURVe,force\n", "CURVe,more\n  DISP a 3+ 3\n\nCURVe,force\n")
        self.run_as("box", more)
        shutil.copy(self.at / "box.restart.h5", self.at / "copy.h5")
        self.run_as("box", more, restart="RESTart")
        self.assertEqual([row[0] for row in self.table("box", "more")[1]], [1, 2, 3, 4])
        shutil.copy(self.at / "copy.h5", self.at / "box.restart.h5")
        table = self.at / "box_more.dat"
        head, *rows = table.read_text().splitlines(keepends=True)
        table.write_text("".join([head, "# made by hand\n", *rows]))
        self.run_as("box", restart="RESTart")
        self.assertEqual(table.read_text(), "".join([head, "# made by hand\n", *rows[:2]]))
        self.assertIn("which this deck does not continue", (self.at / "box.log").read_text())

    def test_an_interval_without_a_multiple_after_restart_is_noticed(self):
        one_step = ("time,2", "time,1")  # the third
        for n, says in ((2, True), (3, False)):
            name, restart = f"every_{n}", f"RESTart,box.restart.h5\n  OUTPut,,every {n}"
            said = self.run_as(name, one_step, restart=restart)
            self.assertEqual("OUTPut wrote no fields" in said, says)

    def test_rows_before_the_first_load_table_have_the_factor_1(self):
        none = (("  PROP,,1\n", ""), ("2 1\n0 0\nends ends\n", ""))
        self.run_as("box", *none)
        two = (("PROP,,1", "PROP,,1\n  PROP,,2"), ("ends ends\n", "ends ends\n\n2 1\n0 0\n1 1\n"))
        for changes, head, rows in (
            ((), ["factor_1"], [[1.0], [1.0], [0.6], [0.8]]),
            (two, ["factor_1", "factor_2"], [[1.0, 0.0], [1.0, 0.0], [0.6, 0.0], [0.8, 0.0]]),
            (none, ["factor_1", "factor_2"], [[1.0, 0.0], [1.0, 0.0], [0.6, 0.0], [0.8, 0.0]]),
        ):
            last = self.table("box")[1]
            self.run_as("box", *changes, restart="RESTart")
            names, found = self.table("box")
            self.assertEqual([name for name in names if "factor" in name], head)
            self.assertEqual({len(row) for row in found}, {len(names)})
            for row, factors in zip(found, rows, strict=False):
                for factor, wanted in zip(row[2:], factors, strict=False):
                    self.assertAlmostEqual(factor, wanted, 12)
            self.assertEqual([row[-1] for row in found[: len(last)]], [row[-1] for row in last])
            self.assertEqual([row[0] for row in found], list(range(1, len(last) + 3)))

    def test_files_of_another_run_are_not_continued(self):
        """The checkpoint of one name is continued under another name that has older files."""
        printed = ("    SAVE\n", "    DISP,ALL\n    PLOT\n")
        for options, restart in (
            ((), "RESTart,box.restart.h5"),
            (("--restart", "box.restart.h5"), ""),
        ):
            with self.subTest(restart):
                self.run_as("b", printed, ("way = 0.1", "way = -0.05"))
                before = self.table("b")
                self.assertEqual(len(before[1]), 2)
                said = self.run_as("b", options=options, restart=restart)
                self.assertIn("not those of the run that wrote the checkpoint", said)
                self.assertIn("the ending .old", said)
                new = [3.0, 4.0] if restart else []
                self.assertEqual([row[0] for row in self.table("b")[1]], new)
                left = [name for name in self.files() if name[:2] in ("b.", "b_")]
                own = ["b.log", "b.report.json", "b.restart.h5", "b_force.dat"]
                if not restart:
                    own.remove("b.restart.h5")
                own += [f"b.{kind}.old" for kind in ("out", "pvd", "vtkhdf")]
                own += ["b_0001.vtu", "b_0002.vtu", "b_force.dat.old"]
                self.assertEqual(left, sorted(own))
                (self.at / "b_force.dat.old").rename(self.at / "old_force.dat")
                self.assertEqual(self.table("old"), before)
                for name in left:
                    (self.at / name).unlink(missing_ok=True)

    def test_files_are_continued_from_a_copy_of_the_checkpoint(self):
        for text, fields in ((self.deck, ""), (self.deck.replace("  FORCe a 3- 3\n", ""), "field")):
            with self.subTest(fields):
                if fields:
                    text = text.replace("CURVe,force\n\n", "")
                self.deck = text.replace("    SAVE\n", "    PLOT\n    SAVE\n")
                self.run_as("box")
                names = self.files()
                rows = None if fields else self.table("box")
                shutil.move(self.at / "box.restart.h5", self.at / "copy.h5")
                self.run_as("box", options=("--restart", "copy.h5"))
                left = [name for name in names if name not in ("box.restart.h5", "copy.h5")]
                self.assertEqual([name for name in self.files() if name != "copy.h5"], left)
                if not fields:
                    self.assertEqual(self.table("box"), rows)

    def test_files_of_a_later_run_of_the_same_name_are_not_continued(self):
        """The checkpoint of the first run is still there, but curves and fields are those of another
        run, with the step of the checkpoint or without it.
        """
        self.deck = self.deck.replace("    SAVE\n", "    PLOT\n    SAVE\n")
        other = (("    SAVE\n", ""), ("way = 0.1", "way = -0.05"))
        for more, steps in (((), [1, 2]), ((("time,2", "time,1"),), [1])):
            with self.subTest(steps):
                self.run_as("box")
                self.run_as("box", *other, *more)
                before = self.table("box")
                self.assertEqual([row[0] for row in before[1]], steps)
                said = self.run_as("box", restart="RESTart")
                self.assertIn("not those of the run that wrote the checkpoint", said)
                self.assertEqual([row[0] for row in self.table("box")[1]], [3, 4])
                self.assertEqual(self.steps("box.vtkhdf"), [3, 4])
                (self.at / "box_force.dat.old").rename(self.at / "old_force.dat")
                self.assertEqual(self.table("old"), before)
                self.run_as("box")
                self.run_as("box", *other, *more)
                said = self.run_as("box", options=("--restart", "box.restart.h5"))
                self.assertIn("not those of the run that wrote the checkpoint", said)
                self.assertEqual(self.table("box")[1], [])

    def test_fields_of_a_later_run_without_the_step_of_the_checkpoint_are_not_continued(self):
        self.deck = self.deck.replace("CURVe,force\n  FORCe a 3- 3\n\n", "")
        self.deck = self.deck.replace("    SAVE\n", "    PLOT\n    SAVE\n")
        self.run_as("n")
        self.run_as("n", ("    SAVE\n", ""), ("time,2", "time,1"))
        said = self.run_as("n", restart="RESTart")
        self.assertIn("not those of the run that wrote the checkpoint", said)
        self.assertEqual(self.steps("n.vtkhdf"), [3, 4])
        for every in (1, 3):  # with 3, no fields were written before the checkpoint
            change = ("    PLOT\n", ""), ("  DT,,0.2\n", f"  DT,,0.2\n  OUTPut,,every {every}\n")
            self.run_as("n", *change)
            said = self.run_as("n", *change, restart="RESTart")
            self.assertNotIn("warning:", said)
            self.assertEqual(self.steps("n.vtkhdf"), [1, 2, 3, 4] if every == 1 else [3])

    def test_other_constants_and_loads_do_not_change_the_rows_before_them(self):
        """The rows are compared with those in the checkpoint, not with values of the new deck."""
        self.deck = self.deck.replace("FORCe a 3- 3", "FORCe a 3- 3\n  ENERgy\n  MAXImum mises")
        for name in ("box.restart.h5", "copy.h5"):
            self.run_as("box")
            before = self.table("box")[1]
            shutil.copy(self.at / "box.restart.h5", self.at / "copy.h5")
            for _ in range(2):
                said = self.run_as(
                    "box", ("  e = 100", "  e = 150"), restart=f"RESTart,{name},CONStants"
                )
                self.assertNotIn("warning:", said)
                rows = self.table("box")[1]
                self.assertEqual(rows[:2], before)
                self.assertEqual([row[0] for row in rows], [1, 2, 3, 4])
                shutil.copy(self.at / "copy.h5", self.at / "box.restart.h5")

    def test_the_report_of_a_restarted_run_has_the_last_row_of_tplot(self):
        """Its interval is longer than the distance to the checkpoint."""
        self.deck = self.deck.replace("time,2", "time,5").replace(
            "DT,,0.2\n", "DT,,0.1\n  TPLOt,,3\n"
        )
        self.deck = self.deck.replace("ends ends\n", "ends ends\n\ndisp,27,3\n\n")
        self.run_as("box")
        final = json.loads((self.at / "box.report.json").read_text())["final"]
        self.assertEqual(final["tplot"]["step"], 3)
        self.run_as("box", options=("--restart", "box.restart.h5"))
        self.assertEqual(json.loads((self.at / "box.report.json").read_text())["final"], final)

    def test_names_may_have_letters_outside_ascii(self):
        """A warning that quotes such a name is in the checkpoint."""
        text = self.deck.replace(",a,", ",träger,").replace(" a ", " träger ")
        text = text.replace("PATCh,a", "PATCh,träger").replace(
            "FIX,", "FIX,klötzchen,3+ 1 1 1\nFIX,", 1
        )
        body = "PATCh,klötzchen\n  BOX 0 0 1  1 1 1\n  ELEMents 2 2 1\n  TYPE Q1\n  MATErial 1\n\n"
        self.deck = text.replace("PATCh,", body + "PATCh,", 1)
        said = self.run_as("box")
        self.assertIn("klötzchen", said)
        before = self.table("box")
        self.run_as("box", options=("--restart", "box.restart.h5"))
        self.assertEqual(self.table("box"), before)
        warnings = json.loads((self.at / "box.report.json").read_text())["warnings"]
        self.assertIn("klötzchen", " ".join(warnings))

    def test_a_checkpoint_that_does_not_exist_is_found_before_anything_is_written(self):
        log = (self.at / "box.log").read_text()
        text = self.deck.replace("BATCh\n", "BATCh\n  RESTart,none.h5\n")
        (self.at / "next.inp").write_text(text)
        for words in (("next.inp",), ("box.inp", "--restart", "none.h5")):
            for more in (("--check",), ()):
                done = self.run_bezel("--name", "box", *more, *words)
                self.assertEqual(done.returncode, 1 if len(words) == 1 else 3, done.stderr)
                self.assertIn("none.h5", done.stderr)
                self.assertNotIn("no problems found", done.stdout)
                if more or len(words) == 1:
                    self.assertEqual((self.at / "box.log").read_text(), log)

    def steps(self, name):
        with h5py.File(self.at / name) as file:
            return list(file["VTKHDF/Steps/StepNumber"])

    def test_a_longer_deck_without_a_curve_continues_its_fields_from_a_copy(self):
        """Its text has one more line, but the file has the step and time of the checkpoint."""
        self.deck = self.deck.replace("CURVe,force\n  FORCe a 3- 3\n\n", "")
        self.deck = self.deck.replace("    SAVE\n", "    PLOT\n    SAVE\n")
        self.run_as("n")
        shutil.copy(self.at / "n.restart.h5", self.at / "copy.h5")
        for _ in range(2):
            said = self.run_as("n", restart="RESTart,copy.h5")
            self.assertNotIn("warning:", said)
            self.assertEqual(self.steps("n.vtkhdf"), [1, 2, 3, 4])
            self.assertTrue((self.at / "n_0001.vtu").exists())
            self.assertIn("n_0001.vtu", (self.at / "n.pvd").read_text())

    def test_other_quantities_begin_a_new_table_from_a_copy(self):
        self.deck = self.deck.replace("    SAVE\n", "    PLOT\n    SAVE\n")
        for fields, says in ((True, "has other columns than its table"), (False, "ending .old")):
            with self.subTest(fields):
                self.run_as("box")
                before = self.table("box")
                shutil.copy(self.at / "box.restart.h5", self.at / "copy.h5")
                if not fields:
                    (self.at / "box.vtkhdf").unlink()
                    (self.at / "box.pvd").unlink()
                change = ("FORCe a 3- 3", "FORCe a 3- 2")
                said = self.run_as("box", change, restart="RESTart,copy.h5")
                self.assertIn(says, said)
                self.assertEqual([row[0] for row in self.table("box")[1]], [3, 4])
                self.assertEqual(self.steps("box.vtkhdf"), [1, 2, 3, 4] if fields else [3, 4])
                (self.at / "box_force.dat.old").rename(self.at / "old_force.dat")
                self.assertEqual(self.table("old"), before)

    def test_a_second_try_replaces_the_files_of_the_first(self):
        """They have no step up to the checkpoint, so nothing is renamed."""
        for _ in range(2):
            said = self.run_as("try", restart="RESTart,box.restart.h5")
            self.assertNotIn("warning:", said)
            self.assertEqual([row[0] for row in self.table("try")[1]], [3, 4])
        self.assertFalse([name for name in self.files() if name.endswith(".old")])

    def test_a_reaction_that_is_zero_up_to_rounding_does_not_matter(self):
        self.deck = self.deck.replace("FORCe a 3- 3", "FORCe a 3- 3\n  FORCe a 3- 1")
        self.run_as("box")
        head, *rows = (self.at / "box_force.dat").read_text().splitlines()
        rows = [row[:-25] + f"{1e-12:25.15e}" for row in rows]
        (self.at / "box_force.dat").write_text("\n".join([head, *rows, ""]))
        shutil.copy(self.at / "box.restart.h5", self.at / "copy.h5")
        said = self.run_as("box", restart="RESTart,copy.h5")
        self.assertNotIn("warning:", said)
        self.assertEqual([row[0] for row in self.table("box")[1]], [1, 2, 3, 4])

    def test_other_fields_than_those_of_the_file_are_refused(self):
        def fields(names):
            return ("  DT,,0.2\n", f"  DT,,0.2\n  OUTPut,,every 1 {names}\n")

        self.run_as("box", fields("displacement"))
        before = self.table("box")
        said = self.run_as("box", fields("displacement mises"), restart="RESTart", code=3)
        self.assertIn("contains the fields displacement up to step 2, but OUTPut names", said)
        self.assertIn("OUTPut,,every 1 displacement mises", said)
        self.assertEqual(self.table("box"), before)
        for names in ("displacement", ""):
            self.run_as("box", fields(names), restart="RESTart")
        with h5py.File(self.at / "box.vtkhdf") as file:
            self.assertEqual(list(file["VTKHDF/Steps/StepNumber"]), [1, 2, 3, 4, 5, 6])
            self.assertNotIn("mises", file["VTKHDF/PointData"])
