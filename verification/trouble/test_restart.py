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

    def moving(self, *changes):
        """The deck with a density and a pressure, which a motion needs, and these changes."""
        text = self.deck.replace("VOLUme 3", "VOLUme 3\n    DENSity 1")
        text = text.replace("MOVE,a,3+ TRANslate 0 0 -way PROP 1", "PRESsure,a,3+ 10 PROP 1")
        text = text.replace("a 3- 3", "a 3- 3\n  DISP a 3+ 3\n  BOOK KINEtic")
        for before, after in changes:
            text = text.replace(before, after)
        return text

    def last_row(self, name, text):
        """Run this deck; return the last three values of its curve and what the run says."""
        (self.at / f"{name}.inp").write_text(text)
        done = self.run_bezel(f"{name}.inp")
        self.assertEqual(done.returncode, 0, done.stderr)
        row = (self.at / f"{name}_force.dat").read_text().splitlines()[-1].split()
        return [float(word) for word in row[-3:]], done.stderr

    def test_a_motion_that_was_turned_off_begins_from_rest(self):
        """TRANsient,OFF after RESTart ends the motion of the checkpoint, as it does in one deck."""
        scheme = "  TRANsient,NEWMark\n"
        text = self.moving(("time,10", "time,4"))
        first = text.replace("BATCh\n", f"BATCh\n{scheme}")
        batch = text.split("BATCh\n")[1]
        loop = batch[batch.index("  LOOP,time") : batch.index("END")]
        again = f"  TRANsient,OFF\n{scheme}{loop}"
        self.last_row("box", first)
        whole, _ = self.last_row("whole", first.replace(loop, loop + again))
        self.assertGreater(whole[2], 0.0)
        for before in ("", scheme):
            start = f"BATCh\n{before}  RESTart,box.restart.h5\n"
            row, _ = self.last_row("next", text.replace(loop, again).replace("BATCh\n", start))
            for found, wanted in zip(row, whole, strict=True):
                self.assertAlmostEqual(found, wanted, 9)

    def test_lumped_masses_that_are_left_out_are_noticed(self):
        word = "BATCh\n  TRANsient,NEWMark\n"
        self.last_row("box", self.moving(("BATCh\n", word + "  MASS,LUMPed\n")))
        for mass, warns in (("", True), ("  MASS,LUMPed\n", False)):
            restart = f"BATCh\n  RESTart,box.restart.h5\n  TRANsient,NEWMark\n{mass}"
            _, said = self.last_row("next", self.moving(("BATCh\n", restart)))
            self.assertEqual("had lumped masses" in said, warns)

    def test_loads_that_jump_after_the_checkpoint_are_noticed(self):
        """The first run ends at t = 1 with the factor 0.5; a checkpoint contains no tables."""
        alone = self.deck.replace("  PROP,,1\n", "")
        alone = alone[: alone.index("2 1\n0 0")] + "STOP\n"
        for settings, text, warns in (
            (("ends=0.5",), self.deck, False),
            (("ends=1",), self.deck, True),
            ((), alone, True),
        ):
            done = self.continued(*settings, text=text)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(
                "jump in the first step after RESTart" in done.stderr, warns, done.stderr
            )

    def test_a_run_that_unloads_knows_the_loads_of_the_first_one(self):
        text = self.deck.replace("MOVE,a,3+ TRANslate 0 0 -way PROP 1", "PRESsure,a,3+ 1")
        text = text.replace("time,10", "time,1").replace("DT,,0.1", "DT,,1")
        (self.at / "box.inp").write_text(text)
        self.assertEqual(self.run_bezel("box.inp").returncode, 0)
        text = text.replace("ends ends\n", "ends ends\n2 0\n")
        done = self.continued(text=text)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(" 0 warnings", done.stderr)

    def test_another_load_is_no_jump_over_a_limit_point(self):
        text = self.deck.replace("MOVE,a,3+ TRANslate 0 0 -way PROP 1", "PRESsure,a,3+ 1 PROP 1")
        (self.at / "box.inp").write_text(text)
        self.assertEqual(self.run_bezel("box.inp").returncode, 0)
        text = text.replace("a,3+ 1", "a,3+ 2").replace("time,10", "time,5")
        done = self.continued(text=text.replace("ends ends\n", "ends ends\n2 2\n"))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn("distant state", done.stderr)

    def test_reactions_with_other_loads_before_the_first_solve_are_noticed(self):
        self.last_row("box", self.moving())
        for load, warns in (("10 PROP", False), ("20 PROP", True)):
            word = "BATCh\n  RESTart,box.restart.h5\n  REACtion,ALL\n"
            _, said = self.last_row("next", self.moving(("BATCh\n", word), ("10 PROP", load)))
            self.assertEqual("forces of the checkpoint with the loads" in said, warns)

    def test_a_checkpoint_on_an_arc_is_noticed(self):
        deck = (TOP / "input/manual/arcl_length.inp").read_text()
        (self.at / "arc.inp").write_text(deck)
        stopped = self.run_bezel("arc.inp", env={**os.environ, "BEZEL_STOP": "150"})
        self.assertEqual(stopped.returncode, 4, stopped.stderr)
        (self.at / "next.inp").write_text(
            deck.replace("BATCh\n", "BATCh\n  RESTart,arc.restart.h5\n")
        )
        done = self.run_bezel("next.inp")
        self.assertIn("the checkpoint lies on a path of ARCLength", done.stderr)

    def test_another_cohesive_law_is_another_model(self):
        base = "PATCh,base\n  BOX 0 0 -1  1 1 lz\n  ELEMents 1 1 1\n  TYPE RIGId\n\n"
        glue = "CONTact,c\n  SURFaces a 3- base 3+\n  COHEsive EXPOnential 2 0.01\n\nCURVe"
        text = self.deck.replace("PATCh,a", base + "PATCh,a").replace("FIX,a,3- 1 1 1\n", "")
        text = text.replace("CURVe", glue, 1).replace("a 3- 3", "a 3+ 3")
        (self.at / "box.inp").write_text(text)
        self.assertEqual(self.run_bezel("box.inp").returncode, 0)
        done = self.continued(text=text)
        self.assertEqual(done.returncode, 0, done.stderr)
        (self.at / "next.log").unlink()
        other = text.replace("2 0.01", "2 0.01 IRREversible")
        self.refused(self.continued(text=other), "contact")

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
        self.stopped(TOP / "verification/trouble/silent/auto_dt_in_loop.inp", *range(41, 71))

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
