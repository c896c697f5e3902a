"""What the user requests holds wherever the request stands: --set in a loop, PLOT and SAVE after a
command that solves nothing.
"""

import h5py

from verification.trouble.test_files import Folder

LOOP = """LOOP,2
PARAmeter
  n = 3
  k = k+1

NEXT

"""


class Settings(Folder):
    def test_set_holds_whenever_the_first_record_is_read(self):
        """A loop reads the record n = 3 twice, and k counts from the value of the command line."""
        deck = self.deck.replace("PARAmeters\n", "PARAmeters\n  k = 0\n", 1)
        deck = deck.replace("PATCh,a", LOOP + "PATCh,a", 1).replace("  n = 2\n", "", 1)
        deck = deck.replace("ELEMents n n n", "ELEMents n n k")
        (self.at / "box.inp").write_text(deck)
        for settings, elements in (((), 18), (("--set", "n=2"), 8), (("--set", "k=3"), 45)):
            done = self.run_bezel(*settings, "--check", "box.inp")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn(f"elements   {elements} Q1", done.stdout)


class Output(Folder):
    def test_plot_and_save_after_form_write_the_last_step(self):
        """FORM begins a step in which nothing is solved; two further steps follow."""
        more = "\nBATCh\n  FORM\n  SAVE\n  PLOT\nEND\n\nBATCh\n  TIME\n  TANG,,1\n  TANG,,1\nEND\n"
        deck = self.deck.replace("\nSTOP", more + "\nSTOP")
        deck = deck.replace("    SAVE\n", "")
        (self.at / "box.inp").write_text(deck)
        done = self.run_bezel("box.inp")
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = (self.at / "box_force.dat").read_text().splitlines()[1:]
        with h5py.File(self.at / "box.vtkhdf") as file:
            self.assertEqual(list(file["VTKHDF/Steps/StepNumber"]), [len(rows) - 1])
        done = self.run_bezel("--restart", "box.restart.h5", "box.inp")
        self.assertIn(f"restarted after step {len(rows) - 1}", (self.at / "box.log").read_text())
