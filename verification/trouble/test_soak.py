"""The checks of the soak test detect every kind of failure that they must detect."""

import os
import random
import stat
import time
import unittest

import numpy as np

from verification.recover import difference
from verification.soak import fuzz
from verification.soak.launch import Call, call, errors, judge
from verification.soak.minimise import minimise
from verification.soak.trials import KILLED, Context, deck_trial, in_units, memory_trial, schedule
from verification.trouble.test_files import BEZEL, Folder

SHELL = "#!/bin/sh\n"
WHOLE = "deck.inp:3:1: error: bad\n    3 | x\n      | ^\nhint: h\n"


class Judge(Folder):
    def wrong(self, code, stderr="", **more):
        return judge(Call(code, stderr), self.at / "out", **more).split(":")[0]

    def test_every_kind_of_failure(self):
        self.assertEqual(self.wrong(None), "hang")
        self.assertEqual(self.wrong(-11), "crash")
        self.assertEqual(self.wrong(1, WHOLE + "Backtrace for this error:"), "crash")
        self.assertEqual(self.wrong(70, WHOLE), "code")
        self.assertEqual(self.wrong(1), "message")
        self.assertEqual(self.wrong(1, WHOLE + WHOLE), "message")
        self.assertEqual(self.wrong(1, "error: bad\n"), "place")
        self.assertEqual(self.wrong(1, WHOLE.replace("^", " ")), "caret")
        self.assertEqual(self.wrong(1, WHOLE), "")
        self.assertEqual(self.wrong(0), "output")
        changed = {self.at / "box.inp": b"another deck"}
        self.assertEqual(self.wrong(1, WHOLE, before=changed), "input")

    def test_files_of_a_run(self):
        out = self.at / "out"
        out.mkdir()
        report = out / "box.report.json"
        report.write_text('{"exit_code": 0, "status": "done"}')
        wrong = lambda: judge(Call(0, files=[f for f in out.iterdir()]), out, (0, 1, 2, 3)).split(
            ":"
        )[0]
        self.assertEqual(wrong(), "")
        (out / "box.lock").touch()
        self.assertEqual(wrong(), "left")
        (out / "box.lock").unlink()
        (out / "box_force.dat").write_text("# a b\n1 2\n3\n")
        self.assertEqual(wrong(), "output")
        (out / "box_force.dat").write_text("# a b\n1 NaN\n")
        self.assertEqual(wrong(), "number")
        (out / "box_force.dat").unlink()
        (out / "box.vtkhdf").write_text("no file of HDF5")
        self.assertEqual(wrong(), "output")
        (out / "box.vtkhdf").unlink()
        report.write_text('{"exit_code": 2, "status": "done"}')
        self.assertEqual(wrong(), "output")

    def test_an_error_is_found_with_its_place(self):
        self.assertEqual(errors(WHOLE), [("column", True, "bad")])
        self.assertEqual(errors("error: bad\n"), [("", False, "bad")])

    def test_a_program_that_waits_is_a_hang(self):
        program = self.at / "sleeps"
        program.write_text(SHELL + "exec sleep 60\n")
        program.chmod(program.stat().st_mode | stat.S_IXUSR)
        begin = time.monotonic()
        done = call(program, self.at, "out", seconds=0.1)
        self.assertEqual(judge(done, self.at / "out").split(":")[0], "hang")
        self.assertLess(time.monotonic() - begin, 10)

    def test_a_program_that_crashes_leaves_a_small_deck(self):
        program = self.at / "crashes"  # on every deck that has MATErial
        program.write_text(
            SHELL + 'for deck; do :; done\ngrep -q MATE "$deck" && kill -SEGV $$\nexit 0\n'
        )
        program.chmod(program.stat().st_mode | stat.S_IXUSR)
        context = Context(program, self.at)
        for seed in range(20):
            _, failure = deck_trial(context, random.Random(seed))
            if failure and failure.what.startswith("crash"):
                break
        deck = next(content for name, content in failure.files.items() if name.endswith(".inp"))
        self.assertIn(b"MATE", deck)
        self.assertEqual(len(deck.split()), 1, deck)


class Trials(Folder):
    def test_a_seed_gives_the_same_trials(self):
        text = self.deck.encode()
        for seed in range(200):
            one, other = (fuzz.mutate_text(text, random.Random(seed)) for _ in range(2))
            self.assertEqual(one, other)
        one, other = (schedule("1", ("deck", "kill")), schedule("1", ("deck", "kill")))
        self.assertEqual([next(one) for _ in range(99)], [next(other) for _ in range(99)])

    def test_the_smallest_text_is_found(self):
        text = b"\n".join(b"line %d with words" % i for i in range(50))
        small = minimise(text, lambda part: b"37" in part and b"words" in part)
        self.assertEqual(sorted(small.split()), [b"37", b"words"])

    def test_other_units_are_told_from_other_results(self):
        rows = np.array([[1, 0.5, 1.0, 3, 0, 1, 2.0], [2, 1.0, 1.0, 3, 0, 1, 4.0]])
        scaled = rows * [1, 7, 1, 1, 1, 1, 50]
        self.assertEqual(in_units(rows, scaled, ((2, 1, 0),), (5, 2, 7)), "")
        scaled[1, 6] *= 1 + 1e-8
        self.assertIn("column 7", in_units(rows, scaled, ((2, 1, 0),), (5, 2, 7)))
        self.assertIn("rows", in_units(rows, scaled[:1], ((2, 1, 0),), (5, 2, 7)))

    def test_results_that_differ_in_a_bit_differ(self):
        for name in ("a", "b"):
            self.assertEqual(self.run_bezel("-o", name, "box.inp").returncode, 0)
        self.assertIsNone(difference(self.at / "a", self.at / "b", "box"))
        curve = self.at / "b" / "box_force.dat"
        curve.write_text(curve.read_text().replace("E-", "E+", 1))
        self.assertEqual(difference(self.at / "a", self.at / "b", "box"), "box_force.dat differs")

    def test_a_program_that_memory_does_not_let_begin_is_no_failure(self):
        program = self.at / "begins"
        for code, failed in ((0, True), (1, False)):  # of --version
            program.write_text(SHELL + f'[ "$2" = --version ] && exit {code}\nexit 1\n')
            program.chmod(program.stat().st_mode | stat.S_IXUSR)
            _, failure = memory_trial(Context(program, self.at), random.Random(1))
            self.assertEqual(failure is not None, failed)

    def test_decks_that_are_killed_have_units_and_checkpoints(self):
        for deck, powers in KILLED.items():
            text = deck.read_text()
            self.assertIn("SAVE", text)
            self.assertIn("  s = 1.0", text)
            self.assertTrue(all(len(row) == 3 for row in powers))
        self.assertTrue(os.access(BEZEL, os.X_OK))

    def test_self_contact_with_line_searches_does_not_depend_on_units(self):
        # Round-off leads the line searches another way; the contact cells of the converged state
        # must not depend on that way.
        deck = next(d for d in KILLED if d.stem == "self")
        unit = (3.0, 7e-6, 5e3)
        curves = []
        for name, values in (("one", (1.0, 1.0, 1.0)), ("other", unit)):
            words = [w for n, v in zip("lst", values, strict=True) for w in ("--set", f"{n}={v!r}")]
            self.assertEqual(self.run_bezel("-o", name, *words, deck).returncode, 0)
            curves.append(np.loadtxt(self.at / name / "self_force.dat", ndmin=2))
        self.assertEqual(in_units(*curves, KILLED[deck], unit), "")


if __name__ == "__main__":
    unittest.main()
