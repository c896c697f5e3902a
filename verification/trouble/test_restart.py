"""A checkpoint is accepted only by its own model, a damaged checkpoint is rejected in one sentence,
and a run that is stopped anywhere ends like an uninterrupted run.
"""

import json
import os
import random
import shutil
import subprocess

import h5py

from verification import TOP
from verification.checks import Run
from verification.recover import difference, run
from verification.trouble.test_files import BEZEL, Folder

SEED = 3


class Restart(Folder):
    def setUp(self):
        super().setUp()
        done = self.run_bezel("--set", "ends=0.5", "box.inp")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.checkpoint = self.at / "box.restart.h5"

    def continued(self, *settings, word="", text=None):
        """Run a deck with RESTart, with other parameters or another text."""
        deck = (text or self.deck).replace("BATCh", f"BATCh\n  RESTart,box.restart.h5{word}")
        (self.at / "next.inp").write_text(deck)
        more = [part for setting in settings for part in ("--set", setting)]
        return self.run_bezel(*more, "next.inp")

    def refused(self, done, what):
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn(what, done.stderr)
        self.assertFalse((self.at / "next.log").exists())

    def test_another_model_is_refused_and_the_message_says_what_differs(self):
        self.refused(self.continued("lz=2"), "differs in the coordinates of nodes")
        self.refused(self.continued("e=200"), "differs in the constants of materials")
        self.refused(self.continued("n=3"), "it has 27 nodes, and this model has 64")
        other = self.deck.replace("TYPE Q1", "TYPE Q1E9")
        self.refused(self.continued(text=other), "differs in the element types")
        other = self.deck.replace("NEOHook e nu\n    FINIte VOLUme 3", "ISOTropic e nu\n    SMALl")
        self.refused(self.continued(text=other), "the material laws")
        other = self.deck.replace("FIX,a,3- 1 1 1", "FIX,a,2- 1 1 1")
        self.refused(self.continued(text=other), "it has 27 equations, and this model has 36")

    def test_other_knots_are_another_model(self):
        points = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 0.25, 0.75, 1)]
        lines = [f"  {n} 0 {x} {y} {z} 1" for n, (x, y, z) in enumerate(points, 1)]
        rows = ["    " + " ".join(str(4 * i + n) for n in (1, 2, 3, 4)) for i in range(4)]
        spline = "\n".join(["NURBs", *lines, "", "KNOTs", "  open 1 7  0 0 0 knot 1 1 1"])
        spline += "\n  open 2 4  0 0 1 1\n\nNPATch\n  solid 1  2 2 4  2 2 1\n" + "\n".join(rows)
        head, rest = self.deck.split("PATCh,a", 1)
        rest = rest.split("\n\n", 1)[1].replace(",a,", ",npatch1,").replace(" a ", " npatch1 ")
        head = head.replace("  n = 2", "  knot = 0.5")
        self.of_another_model(head + spline + "\n\n" + rest, "knot=0.4")

    def test_other_constraints_are_another_model(self):
        folder = TOP / "verification" / "trouble" / "silent"
        shutil.copy(folder / "hanging_cube.msh", self.at)
        constraints = (folder / "hanging_cube.con").read_text()
        (self.at / "first.con").write_text(constraints)
        (self.at / "second.con").write_text(
            constraints.replace("1 0.25 5 0.25 4 0.25 8 0.25", "1 0.1 5 0.4 4 0.4 8 0.1")
        )
        head, rest = self.deck.split("PATCh,a", 1)
        rest = rest.split("\n\n", 1)[1].replace("FIX,a,3-", "FIX,PLANe,3,0")
        rest = rest.replace("MOVE,a,3+", "MOVE,PLANe,3,2").replace("FORCe a 3-", "FORCe PLANe 3 0")
        mesh = "MESH,a FILE hanging_cube.msh\n  CONStraint first.con\n  MATErial 1\n\n"
        deck = head + mesh + rest
        self.of_another_model(deck, text=deck.replace("first.con", "second.con"))

    def of_another_model(self, deck, *settings, text=None):
        """Check that the checkpoint of a deck is refused by one with other knots or constraints."""
        (self.at / "box.inp").write_text(deck)
        done = self.run_bezel("--set", "ends=0.5", "box.inp")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.refused(
            self.continued(*settings, text=text or deck),
            "differs in the knots of splines or hanging nodes",
        )

    def test_loads_may_change_and_the_log_says_so(self):
        done = self.continued("way=0.2")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(
            "changed since the analysis that wrote the checkpoint: the loads and prescribed motions\n",
            (self.at / "next.log").read_text(),
        )

    def test_constants_change_only_by_a_word(self):
        done = self.continued("e=200", word=",CONStants")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(
            "wrote the checkpoint: the constants of materials", (self.at / "next.log").read_text()
        )
        (self.at / "next.log").unlink()
        self.refused(self.continued("lz=2", word=",CONStants"), "the coordinates of nodes")
        self.refused(self.continued(word=",all"), "expected CONStants, found 'all'")

    def test_dynamics_follow_the_deck_and_not_the_checkpoint(self):
        still = self.deck.replace("VOLUme 3", "VOLUme 3\n    DENSity 1")
        still = still.replace("MOVE,a,3+ TRANslate 0 0 -way PROP 1", "PRESsure,a,3+ 10 PROP 1")
        still = still.replace("a 3- 3", "a 3- 3\n  DISP a 3+ 3\n  BOOK KINEtic")
        moving = still.replace("PROP,,1", "TRANsient,NEWMark\n  PROP,,1")
        more = moving.replace("time,10", "time,20")
        for name, deck in (("box", moving), ("whole", more), ("rest", still)):
            (self.at / f"{name}.inp").write_text(deck)
            self.assertEqual(self.run_bezel(f"{name}.inp").returncode, 0)
        end = {}
        for name in ("whole", "rest"):
            row = (self.at / f"{name}_force.dat").read_text().splitlines()[-1].split()
            end[name] = [float(word) for word in row[-3:]]
        self.assertNotAlmostEqual(end["whole"][0], end["rest"][0], 2)
        self.assertGreater(end["whole"][2], 0)
        self.assertEqual(end["rest"][2], 0)
        restart = "  RESTart,box.restart.h5\n"
        for before, after, of, warns in (
            ("  TRANsient,NEWMark\n", "", "whole", False),
            ("", "  TRANsient,NEWMark\n", "whole", False),
            ("", "  TRANsient,OFF\n", "rest", False),
            ("", "", "rest", True),
        ):
            text = still.replace("BATCh\n", "BATCh\n" + before + restart + after)
            (self.at / "next.inp").write_text(text)
            done = self.run_bezel("next.inp")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual("continues without inertia" in done.stderr, warns)
            row = (self.at / "next_force.dat").read_text().splitlines()[-1].split()
            for found, wanted in zip(row[-3:], end[of], strict=True):
                self.assertAlmostEqual(float(found), wanted, 7)

    def test_a_motion_after_a_static_checkpoint_begins_from_rest(self):
        """It equals the motion after the same static steps in one deck."""
        still = self.deck.replace("VOLUme 3", "VOLUme 3\n    DENSity 1")
        still = still.replace("MOVE,a,3+ TRANslate 0 0 -way PROP 1", "PRESsure,a,3+ 10 PROP 1")
        still = still.replace("a 3- 3", "a 3- 3\n  DISP a 3+ 3\n  BOOK KINEtic")
        batch = still.split("BATCh\n")[1]
        loop = batch[batch.index("  LOOP,time") : batch.index("END")]
        motion = "  TRANsient,NEWMark\n" + loop.replace("time,10", "time,3")
        decks = {
            "box": still,
            "whole": still.replace(loop, loop + motion),
            "next": still.replace(loop, "  RESTart,box.restart.h5\n" + motion),
        }
        end = {}
        for name, deck in decks.items():
            (self.at / f"{name}.inp").write_text(deck)
            done = self.run_bezel(f"{name}.inp")
            self.assertEqual(done.returncode, 0, done.stderr)
            row = (self.at / f"{name}_force.dat").read_text().splitlines()[-1].split()
            end[name] = [float(word) for word in row[-3:]]
        for found, wanted in zip(end["next"], end["whole"], strict=True):
            self.assertAlmostEqual(found, wanted, 9)

    def test_a_motion_after_static_steps_begins_from_rest_also_if_it_is_restarted(self):
        """RESTart, static steps with a checkpoint, and then a motion: --restart from this checkpoint
        repeats the motion, which begins from rest.
        """
        text = self.deck.replace("VOLUme 3", "VOLUme 3\n    DENSity 1")
        text = text.replace("MOVE,a,3+ TRANslate 0 0 -way PROP 1", "PRESsure,a,3+ 10 PROP 1")
        text = text.replace("time,10", "time,2").replace("1 1\n\nSTOP", "9 9\n\nSTOP")
        (self.at / "box.inp").write_text(text)
        self.assertEqual(self.run_bezel("box.inp").returncode, 0)
        loop = text[text.index("  LOOP,time") : text.index("END\n2 1")]
        text = text.replace("BATCh\n", "BATCh\n  RESTart,box.restart.h5\n  ARCLength,DYNAmic\n")
        motion = "  TRANsient,NEWMark\n" + loop.replace("    SAVE\n", "")
        (self.at / "next.inp").write_text(text.replace(loop, loop + motion))
        self.assertEqual(self.run_bezel("next.inp").returncode, 0)
        whole = (self.at / "next_force.dat").read_text()
        done = self.run_bezel("--restart", "next.restart.h5", "next.inp")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual((self.at / "next_force.dat").read_text(), whole)

    def test_the_balance_goes_on_from_a_deck_without_one(self):
        """BOOK in the second deck includes the work of the steps before the checkpoint."""
        self.deck = self.deck.replace("ends = 1", "ends = 2")
        (self.at / "box.inp").write_text(self.deck)
        self.assertEqual(self.run_bezel("box.inp").returncode, 0)
        booked = self.deck.replace("a 3- 3", "a 3- 3\n  BOOK WORK\n  BOOK IMBAlance")
        done = self.continued(text=booked)
        self.assertEqual(done.returncode, 0, done.stderr)
        (self.at / "whole.inp").write_text(booked.replace("time,10", "time,20"))
        self.assertEqual(self.run_bezel("whole.inp").returncode, 0)
        end = {}
        for name in ("next", "whole"):
            row = (self.at / f"{name}_force.dat").read_text().splitlines()[-1].split()
            end[name] = [float(word) for word in [row[1], *row[-2:]]]
        self.assertGreater(end["whole"][1], 0.0)
        for found, wanted in zip(end["next"], end["whole"], strict=True):
            self.assertAlmostEqual(found, wanted, 12)

    def test_another_mesh_file_is_refused(self):
        mesh = self.at / "mesh.inc"
        mesh.write_text("  BOX 0 0 0  1 1 lz\n")
        text = self.deck.replace("  BOX 0 0 0  1 1 lz\n", "  INCLude mesh.inc\n")
        (self.at / "in.inp").write_text(text)
        self.assertEqual(self.run_bezel("in.inp").returncode, 0)
        mesh.write_text("  BOX 0 0 0  1 2 lz\n")
        done = self.run_bezel("--restart", "in.restart.h5", "in.inp")
        self.assertEqual(done.returncode, 1, done.stderr)

    def test_damaged_bytes_are_refused_in_one_sentence(self):
        whole = self.checkpoint.read_bytes()
        chance = random.Random(SEED)
        for _ in range(40):
            at = chance.randrange(len(whole) - 40)
            damaged = bytearray(whole)
            damaged[at] ^= 1 << chance.randrange(8)
            self.checkpoint.write_bytes(damaged)
            done = self.run_bezel("--restart", "box.restart.h5", "--set", "ends=0.5", "box.inp")
            self.assertEqual(done.returncode, 3, f"byte {at}: {done.stderr}")
            self.assertEqual(done.stderr.count("error:"), 1)
        for size in (0, 10, 1000, len(whole) // 2):
            self.checkpoint.write_bytes(whole[:size])
            done = self.run_bezel("--restart", "box.restart.h5", "--set", "ends=0.5", "box.inp")
            self.assertEqual(done.returncode, 3, f"{size} bytes: {done.stderr}")

    def test_changed_datasets_are_refused(self):
        names = []
        with h5py.File(self.checkpoint) as file:
            file["last"].visititems(
                lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None
            )
        kept = self.at / "kept.h5"
        shutil.copy(self.checkpoint, kept)
        for name in names:
            shutil.copy(kept, self.checkpoint)
            with h5py.File(self.checkpoint, "r+") as file:
                values = file["last"][name][...]
                if values.size == 0:
                    continue
                values.flat[0] += 1
                file["last"][name][...] = values
            done = self.run_bezel("--restart", "box.restart.h5", "--set", "ends=0.5", "box.inp")
            self.assertEqual(done.returncode, 3, f"{name}: {done.stderr}")
            self.assertEqual(done.stderr.count("error:"), 1)


class Names(Folder):
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


class Stops(Folder):
    def stopped(self, deck, *commands):
        """Stop a run before each of these commands; the restarted run must be equal bit for bit,
        with the same numbers of iterations and cut-backs.
        """
        call = Run(f"stop/{deck.stem}", deck)
        self.assertEqual(run(BEZEL, call, self.at / "whole"), 0)
        for command in commands:
            out = self.at / str(command)
            self.assertEqual(run(BEZEL, call, out, stop=command), 4, command)
            self.assertEqual(
                run(BEZEL, call, out, "--restart", str(out / f"{deck.stem}.restart.h5")), 0
            )
            self.assertIsNone(difference(self.at / "whole", out, deck.stem), command)

    def test_between_a_cut_back_and_the_end_of_its_step(self):
        """The pattern of the tangent must not depend on the couplings of the failed attempt."""
        self.stopped(TOP / "input/manual/arcl.inp", 59, 349)

    def changed(self, name, *changes):
        """The path of a deck that differs from that of the box in these pairs of texts."""
        text = self.deck
        for old, new in changes:
            text = text.replace(old, new)
        (self.at / f"{name}.inp").write_text(text)
        return self.at / f"{name}.inp"

    def test_the_interval_of_tplot_and_noprint_continue(self):
        deck = self.changed(
            "interval",
            ("  LOOP,time", "  TPLOt,,2\n  NOPRint\n  LOOP,time"),
            ("    SAVE\n", "    DISP,ALL\n    SAVE\n"),
            ("ends ends\n", "ends ends\n\ndisp,27,3\n"),
        )
        self.stopped(deck, 25)

    def test_each_pass_takes_its_table_although_prop_closes_the_step(self):
        """The checkpoint that is written when PROP closes a step does not count this PROP yet."""
        tables = "".join(f"1 0 0 100 {0.1 * k:.1f}\n" for k in range(1, 11))
        deck = self.changed(
            "passes",
            ("  PROP,,1\n", "  FACTor,REUSe\n"),
            ("    TIME\n", "    PROP,,1\n    TIME\n"),
            ("2 1\n0 0\nends ends\n", tables),
        )
        self.stopped(deck, 20, 47)

    def test_a_run_that_begins_with_its_own_checkpoint_is_stopped_anywhere(self):
        """A stop before RESTart, or later with kept factors, keeps the state of the checkpoint."""
        text = self.deck.replace("time,10", "time,2")
        for factor in ("", "  FACTor,REUSe\n"):
            after = text.replace("    SAVE\n", "").replace("DT,,0.1", "DT,,0.2")
            after = after.replace("BATCh\n", f"BATCh\n{factor}  RESTart\n")
            (self.at / "first.inp").write_text(text)
            (self.at / "next.inp").write_text(after)
            whole = None
            for stop in (0, 1, 2, 10, 15):
                with self.subTest(stop=stop, factor=factor):
                    self.assertEqual(self.run_bezel("--name", "x", "first.inp").returncode, 0)
                    env = {**os.environ, **({"BEZEL_STOP": str(stop)} if stop else {})}
                    done = self.run_bezel("--name", "x", "next.inp", env=env)
                    self.assertEqual(done.returncode, 4 if stop else 0, done.stderr)
                    if stop:
                        done = self.run_bezel(
                            "--name", "x", "--restart", "x.restart.h5", "next.inp"
                        )
                        self.assertEqual(done.returncode, 0, done.stderr)
                    rows = (self.at / "x_force.dat").read_text()
                    self.assertEqual(rows.count("\n"), 5)
                    whole = whole or rows
                    self.assertEqual(rows, whole)

    def test_noprint_after_a_table_does_not_remove_those_of_the_rest_of_the_step(self):
        """A step that is reached in several parts has the table of its end."""
        deck = self.changed(
            "parts",
            ("  DT,,0.1\n", "  DT,,0.1\n  AUTO,,0.01,0.1\n"),
            ("LOOP,newton,20\n      TANG,,1\n    NEXT,newton\n    SAVE\n",
             "TANG,,1\n    TANG,,1\n    TANG,,1\n    DISP,,27\n    NOPRint\n"),
            ("NEXT,time\n", "NEXT,time\n  PRINt\n  DISP,,27\n"),
            ("time,10", "time,1"), ("DT,,0.1\n", "DT,,1\n"), ("0.01,0.1", "0.01,1"), ("-way", "-3*way"),
        )  # fmt: skip
        done = self.run_bezel("parts.inp")
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = (self.at / "parts_force.dat").read_text().splitlines()[1:]
        self.assertGreater(len(rows), 1)
        self.assertEqual(deck.with_suffix(".out").read_text().count("Time"), len(rows) + 1)

    def test_a_script_continues_a_deck_whatever_its_ending(self):
        script = TOP / "input/slurm/many_decks.sh"
        (self.at / "deck.dat").write_text(self.deck)
        said = []
        for stop in ("40", "0"):
            env = {**os.environ, "BEZEL": str(BEZEL), "OUT": "out"}
            if stop != "0":
                env["BEZEL_STOP"] = stop
            done = subprocess.run(
                ["bash", script, "deck.dat"], cwd=self.at, env=env, capture_output=True, text=True, check=False
            )  # fmt: skip
            said.append((done.returncode, (self.at / "out/deck/deck.log").read_text()))
        self.assertEqual([code for code, _ in said], [4, 0])
        self.assertIn("restarted after step", said[1][1])

    def test_printed_tables_after_the_checkpoint_are_removed(self):
        """The run is stopped after a table of a step, and before the table of a later one."""
        deck = self.changed("printed", ("    SAVE\n", "    DISP,ALL\n    REAC,,1,3\n    SAVE\n"))
        self.stopped(deck, 15, 52)

    def test_a_run_that_is_restarted_from_its_own_checkpoint_prints_no_table_twice(self):
        deck = self.changed(
            "printed", ("    SAVE\n", "    DISP,ALL\n"), ("END\n2 1", "SAVE\nEND\n2 1")
        )
        text = deck.read_text().replace("time,10", "time,5")
        first = text.index("  LOOP,time")
        loop = text[first : text.index("SAVE\n")]
        deck.write_text(text.replace("SAVE\n", "SAVE\n" + loop))
        self.assertEqual(self.run_bezel("printed.inp").returncode, 0)
        printed = (self.at / "printed.out").read_text()
        self.assertEqual(printed.count("Time"), 10)
        done = self.run_bezel("--restart", "printed.restart.h5", "printed.inp")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual((self.at / "printed.out").read_text(), printed)

    def test_lumped_masses_continue_before_there_is_a_motion(self):
        deck = self.changed(
            "lumped",
            ("VOLUme 3", "VOLUme 3\n    DENSity 1"),
            ("MOVE,a,3+ TRANslate 0 0 -way PROP 1", "PRESsure,a,3+ 10 PROP 1"),
            ("  PROP,,1\n", "  PROP,,1\n  MASS,LUMPed\n"),
            ("NEXT,time\n", "NEXT,time\n  TRANsient,NEWMark\n"),
        )
        text = deck.read_text().replace("time,10", "time,4")
        loop = text[text.index("  LOOP,time") : text.index("  TRANsient")]
        deck.write_text(text.replace("  TRANsient,NEWMark\n", "  TRANsient,NEWMark\n" + loop))
        self.stopped(deck, 15)

    def test_within_an_iteration_that_started_from_a_prediction(self):
        """The energy of the step is measured with the reactions at the start of the step."""
        self.stopped(TOP / "verification/soak/decks/friction.inp", 126)

    def test_where_a_step_has_found_that_a_body_must_be_held(self):
        self.stopped(TOP / "verification/trouble/silent/pressed.inp", 3, 28)

    def test_between_a_new_dt_and_the_end_of_the_step_before_it(self):
        """The new DT has no influence on the step that is open when it is given."""
        self.stopped(TOP / "verification/trouble/silent/auto_dt_in_loop.inp", 57, 68)

    def test_warnings_given_before_the_stop_are_in_the_report(self):
        """Each warning is there once, even the one about the work taken by penetration, which is
        issued only at the end.
        """
        deck = TOP / "verification/trouble/silent/soft_penalty.inp"
        self.stopped(deck, 20)
        report = json.loads((self.at / "20" / "soft_penalty.report.json").read_text())
        self.assertIn("too soft", " ".join(report["warnings"]))

    def test_a_restarted_run_knows_that_it_has_needed_inertia(self):
        """The report must not say `equilibrium`, even if only the part before the stop needed
        inertia.
        """
        self.stopped(TOP / "verification/soak/decks/cohesive.inp", 383)
