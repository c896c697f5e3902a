"""Printed tables are those of accepted steps, show the state of the last solve, and have rows for all
elements, whatever numbers the mesh file gives them.
"""

import shutil

from verification import TOP
from verification.trouble.test_files import HERE, Folder


class Tables(Folder):
    """Runs with curves and printed tables."""

    def times(self, name):
        """The times of the tables, and those of the rows of the curve."""
        lines = (self.at / f"{name}.out").read_text().splitlines()
        rows = (self.at / f"{name}_force.dat").read_text().splitlines()[1:]
        return (
            [float(line.split()[-1]) for line in lines if "Time" in line],
            [float(row.split()[1]) for row in rows],
        )


class Steps(Tables):
    """A deck whose steps have three iterations: those of length 1 do not converge."""

    def setUp(self):
        super().setUp()
        self.deck = self.deck.replace(
            "    LOOP,newton,20\n      TANG,,1\n    NEXT,newton\n    SAVE\n",
            "    TANG,,1\n" * 3 + "    DISP,ALL\n",
        )
        self.deck = self.deck.replace("-way", "-3*way").replace("DT,,0.1", "DT,,1")
        self.deck = self.deck.replace("time,10", "time,1")

    def test_steps_that_are_cut_back_leave_no_table(self):
        text = self.deck.replace("DT,,1\n", "DT,,1\n  AUTO,,0.01,1\n")
        (self.at / "auto.inp").write_text(text)
        done = self.run_bezel("auto.inp")
        self.assertEqual(done.returncode, 0, done.stderr)
        tables, rows = self.times("auto")
        self.assertGreater(len(rows), 1)
        self.assertEqual(tables, rows)

    def test_a_run_that_fails_keeps_the_tables_of_accepted_steps(self):
        """If no step is accepted, no file remains."""
        text = self.deck.replace("DT,,1\n", "DT,,1\n  AUTO,,0.9,1\n")
        (self.at / "fails.inp").write_text(text)
        self.assertEqual(self.run_bezel("fails.inp").returncode, 2)
        self.assertFalse((self.at / "fails.out").exists())
        text = text.replace("    TANG,,1\n" * 3, "    TANG,,1\n" * 2)
        text = text.replace("  DT,,1", "  DT,,0.01\n  LOOP,first,2\n    TIME\n" + "    TANG,,1\n" * 6
                            + "    DISP,ALL\n  NEXT\n  DT,,1")  # fmt: skip
        (self.at / "late.inp").write_text(text)
        self.assertEqual(self.run_bezel("late.inp").returncode, 2)
        tables, rows = self.times("late")
        self.assertEqual(tables, [0.01, 0.02])
        self.assertEqual(tables, rows)

    def test_tables_between_two_steps_remain(self):
        """PROP closes the step; the table after it belongs to no step that could be rejected."""
        text = self.deck.replace("END\n2 1", "  PROP,,2\n  DISP,ALL\nEND\n2 1")
        text = text.replace("ends ends\n", "ends ends\n\n\n")
        text = text.replace("    TANG,,1\n" * 3, "    TANG,,1\n" * 12)
        (self.at / "between.inp").write_text(text)
        done = self.run_bezel("between.inp")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.times("between")[0], [1.0, 1.0])


class Restarts(Tables):
    """RESTart keeps the tables up to the checkpoint."""

    def setUp(self):
        super().setUp()
        text = self.deck.replace("    SAVE\n", "    DISP,ALL\n    SAVE\n")
        text = text.replace("DT,,0.1", "DT,,0.01").replace("time,10", "time,2")
        (self.at / "box.inp").write_text(text)
        self.deck = text.replace("    SAVE\n", "")
        self.assertEqual(self.run_bezel("box.inp").returncode, 0)

    def restarted(self, text, times):
        """Run a deck under the name of the first one; its tables must be those of these times."""
        (self.at / "next.inp").write_text(text)
        done = self.run_bezel("--name", "box", "next.inp")
        self.assertEqual(done.returncode, 0, done.stderr)
        tables, rows = self.times("box")
        self.assertEqual(tables, times)
        self.assertEqual(rows, [0.01, 0.02, 0.03, 0.04])

    def test_restart_under_the_same_name_keeps_the_tables_before_the_checkpoint(self):
        for file in ("", ",./box.restart.h5"):  # the same deck again prints no table twice
            text = self.deck.replace("BATCh", "BATCh\n  RESTart" + file)
            self.restarted(text, [0.01, 0.02, 0.03, 0.04])
        self.restarted(text.replace("    DISP,ALL\n", ""), [0.01, 0.02])

    def test_restart_from_another_checkpoint_keeps_all_tables(self):
        shutil.move(self.at / "box.restart.h5", self.at / "other.h5")
        text = self.deck.replace("BATCh", "BATCh\n  RESTart,other.h5")
        self.restarted(text, [0.01, 0.02, 0.03, 0.04])
        self.restarted(text.replace("    DISP,ALL\n", ""), [0.01, 0.02, 0.03, 0.04])


class Stresses(Folder):
    def elements(self, name):
        """Run a deck of the folder `silent`; return the elements of the rows of each table."""
        for path in (HERE / "silent").glob(f"{name}.*"):
            shutil.copy(path, self.at)
        done = self.run_bezel(f"{name}.inp")
        self.assertEqual(done.returncode, 0, done.stderr)
        tables = (self.at / f"{name}.out").read_text().split("E l e m e n t")[1:]
        rows = [[line.split() for line in table.splitlines()] for table in tables]
        return [[int(row[0]) for row in table if len(row) == 12] for table in rows]

    def test_numbers_of_the_file_need_not_begin_at_1(self):
        last, every = self.elements("numbered_elements")
        self.assertEqual(sorted(set(last)), [11, 12])
        self.assertEqual(sorted(set(every)), list(range(3, 13)))

    def test_equal_numbers_of_a_block_and_a_mesh(self):
        (table,) = self.elements("after_block")
        self.assertEqual(len(table), 16)
        self.assertEqual(set(table), {1})

    def test_the_von_mises_stress_of_a_node_is_that_of_its_components(self):
        """A column of Q2 between two walls under its weight has the stress 1 - x, which is exact."""
        shutil.copy(HERE / "silent/mises_of_column.inp", self.at)
        done = self.run_bezel("mises_of_column.inp")
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = [line.split() for line in (self.at / "mises_of_column.out").read_text().splitlines()]
        nodes = [row for row in rows if len(row) == 8 and row[0].isdigit()]
        self.assertEqual(len(nodes), 63)
        for row in nodes:
            self.assertAlmostEqual(float(row[7]), abs(float(row[1])), delta=1e-9)


class Displacements(Folder):
    DECK = """FEAP ** a block slides on its base in steps that resemble each other
  ndm = 3
MATErial 1
  SOLId
  ELAStic NEOHook 1.0 0.3
  FINIte

PATCh,base
  BOX -1 -1 -0.5 5 2 0.5
  ELEMents 10 4 1
  TYPE Q1
  MATErial 1

PATCh,block
  BOX 0 -0.5 0 1 1 1
  ELEMents 2 2 2
  TYPE Q1
  MATErial 1

FIX,base,3- 1 1 1
MOVE,block,3+ TRANslate 0 0 -0.02 PROP 1
MOVE,block,3+ TRANslate 0.1 0 0 PROP 1
CONTact,c
  SURFaces block 3-  base 3+

END
BATCh
  PROP,,1
  DT,,0.25
  LOOP,t,3
    TIME
    DISP,,115,115
    LOOP,n,40
      UTAN,,1
    NEXT
    DISP,,115,115
  NEXT
  TIME
  DISP,,115,115
  TIME
  FORM
  TIME
  DISP,,115,115
END

STOP
"""

    def test_displacements_change_only_when_a_system_is_solved(self):
        """The next step may start from predicted displacements, but not before its first forces."""
        (self.at / "slide.inp").write_text(self.DECK)
        done = self.run_bezel("slide.inp")
        self.assertEqual(done.returncode, 0, done.stderr)
        text = (self.at / "slide.out").read_text()
        rows = [line.split() for line in text.splitlines() if line.split()[:1] == ["115"]]
        self.assertEqual(len(rows), 8)
        old = [float(line.split()[-1]) for line in text.splitlines() if "Nothing has been" in line]
        self.assertEqual(old, [0, 0.25, 0.5, 0.75, 0.75])  # not those of the new steps
        for before, after in ((1, 2), (3, 4), (5, 6), (5, 7)):
            self.assertEqual(rows[before], rows[after])
        self.assertNotEqual(rows[1], rows[3])


class Numbers(Folder):
    """A range whose numbers are not those of the nodes or elements that are meant."""

    def warnings(self, text, *commands, code=0):
        """What a deck says if its last batch ends with these commands."""
        head, tail = text.rsplit("\nEND\n", 1)
        text = "\n".join([head, *(f"  {command}" for command in commands), f"END\n{tail}"])
        (self.at / "next.inp").write_text(text)
        done = self.run_bezel("next.inp")
        self.assertEqual(done.returncode, code, done.stderr)
        return done.stderr

    def test_numbers_of_a_mesh_file(self):
        shutil.copy(TOP / "input/manual/mesh.msh", self.at)
        text = (TOP / "input/manual/mesh.inp").read_text()
        said = self.warnings(text, "DISP,,17", "REAC,,17", "STRE,NODE,17")
        self.assertEqual(said.count("node 17 of the model is node"), 3)
        said = self.warnings(text, "STRE,,1,2")
        self.assertIn("no element has a number from 1 to 2: the table of STRE is empty", said)
        self.assertNotIn("warning:", self.warnings(text, "DISP,ALL", "DISP", "STRE", "STRE,,65,70"))

    def test_nodes_that_tie_has_joined(self):
        second = "\nPATCh,b\n  BOX 0 0 1  1 1 1\n  ELEMents 1 1 1\n  TYPE Q1\n  MATErial 1\n\nTIE\n"
        text = self.deck.replace("  n = 2", "  n = 1").replace("\nFIX,", f"{second}\nFIX,", 1)
        text = text.replace("MOVE,a,", "MOVE,b,")
        for table in ("DISP,,9", "REAC,,9", "STRE,NODE,9", "DISP,,9,13", "DISP,,5,9"):
            said = self.warnings(text, table)
            self.assertIn(f"node 9 is not in the table of {table[:4]}", said)
            self.assertEqual(said.count("warning:"), 1)
        for table in ("DISP,,5", "DISP,,1,16", "DISP,ALL", "REAC", "DISP,,13,16"):
            self.assertNotIn("warning:", self.warnings(text, table))

    def test_an_interval_that_is_longer_than_the_run(self):
        text = self.deck.replace("time,10", "time,3").replace(
            "ends ends\n", "ends ends\n\ndisp,27,3\n\n"
        )
        for every, n in ((5, 1), (3, 0)):
            for word in ("OUTPut wrote no fields", "TPLOt wrote no row"):
                command = f"  OUTPut,,every {every}\n" if word[0] == "O" else f"  TPLOt,,{every}\n"
                deck = text.replace("  LOOP,time", f"{command}  LOOP,time")
                if word[0] == "O":
                    deck = deck.replace("\ndisp,27,3\n\n", "")
                self.assertEqual(self.warnings(deck).count(word), n)

    def test_save_with_the_name_of_a_file(self):
        text = self.deck.replace("time,10", "time,1")
        self.assertNotIn("warning:", self.warnings(text, "SAVE"))
        said = self.warnings(text, "SAVE,mid")
        self.assertIn("SAVE does not use the name 'mid'", said)


class Reactions(Folder):
    """Reactions are those of the state that is printed."""

    def sums(self, *commands, after=""):
        """The third components of the sums over all nodes in the tables of a deck with a force."""
        text = self.deck.replace(
            "MOVE,a,3+ TRANslate 0 0 -way PROP 1", "EFORce\n  3 1.0  0 0 0.1\n"
        )
        head, _ = text.split("  LOOP,time")
        batch = "\n".join(f"  {command}" for command in commands)
        (self.at / "next.inp").write_text(f"{head}{batch}\nEND\n2 1\n0 0\n1 1\n\n{after}\nSTOP\n")
        done = self.run_bezel("next.inp")
        self.assertEqual(done.returncode, 0, done.stderr)
        lines = (self.at / "next.out").read_text().splitlines()
        return [float(line.split()[-1]) for line in lines if line.split()[:1] == ["Sum"]]

    def test_before_the_first_solve_of_a_step_they_have_the_loads_of_the_last_one(self):
        solve = ("LOOP,,20", "TANG,,1", "NEXT")
        sums = self.sums("TIME", *solve, "REAC", "TIME", "REAC", *solve, "REAC")
        self.assertEqual(len(sums), 3)
        for found in sums:
            self.assertAlmostEqual(found, 0.0, 9)

    def test_another_load_table_between_two_steps_does_not_act_on_them(self):
        solve = ("LOOP,,20", "TANG,,1", "NEXT")
        sums = self.sums("REAC", "TIME", *solve, "PROP,,1", "REAC", after="1 0 0 100 5\n")
        self.assertEqual(len(sums), 2)
        for found in sums:
            self.assertAlmostEqual(found, 0.0, 9)


class Idle(Folder):
    """PLOT and SAVE after a TIME without a solve."""

    def test_plot_in_a_step_without_a_solve_does_not_act_on_the_next_one(self):
        solve = "  LOOP,,20\n    TANG,,1\n  NEXT\n"
        head, tail = self.deck.split("  LOOP,time")
        tail = tail.split("END\n", 1)[1]
        for word, left in (("PLOT", "next.vtkhdf"), ("SAVE", "next.restart.h5")):
            batch = f"  TIME\n{solve}  TIME\n  {word}\n  TIME\n{solve}"
            (self.at / "next.inp").write_text(f"{head}{batch}END\n{tail}")
            done = self.run_bezel("next.inp")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn(f"{word} has no effect after a TIME that no TANG,,1", done.stderr)
            self.assertFalse((self.at / left).exists())
            batch = f"  TIME\n{solve}  TIME\n  {word}\n{solve}"
            (self.at / "next.inp").write_text(f"{head}{batch}END\n{tail}")
            done = self.run_bezel("next.inp")
            self.assertNotIn("warning:", done.stderr)
            self.assertTrue((self.at / left).exists())
