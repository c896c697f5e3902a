"""Warnings about contacts, and multipliers of AUGMent, after RESTart and after bonds have broken."""

import json
import shutil

from verification.checks import read_table
from verification.trouble.test_files import HERE, Folder

PRESS = """FEAP ** a rigid plate on a block of one element
  ndm = 3

MATErial 1
  SOLId
    ELAStic NEOHook 100.0 0.3
    FINIte VOLUme 3

PATCh,low
  BOX 0 0 -1  1 1 1
  ELEMents 1 1 1
  TYPE Q1
  MATErial 1

PATCh,up
  BOX -1 -1 0  3 3 1
  ELEMents 1 1 1
  TYPE RIGId

FIX,low,3- 1 1 1
MOVE,up,ALL TRANslate 0 0 -0.1 PROP 1

CONTact,c
  SURFaces up 3- low 3+
  NORMal PENAlty 100

CURVe,c
  FORCe low 3- 3

END

BATCh
  PROP,,1
  DT,,0.5
  LOOP,time,1
    TIME
    LOOP,augment,6
      LOOP,newton,30
        UTAN,,1
      NEXT,newton
      AUGMent,,0.01
    NEXT,augment
    SAVE
  NEXT,time
END
2 2
0 0  0.5 0.5
1 0.5

STOP
"""
AUGMENT = "    LOOP,augment,6\n", "      AUGMent,,0.01\n    NEXT,augment\n"


class Contacts(Folder):
    def run_deck(self, name, text, *options):
        """Run a deck; return the warnings of its report."""
        (self.at / f"{name}.inp").write_text(text)
        done = self.run_bezel(*options, f"{name}.inp")
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads((self.at / f"{name}.report.json").read_text())["warnings"]

    def without(self, text):
        for part in AUGMENT:
            self.assertIn(part, text)
            text = text.replace(part, "")
        return text

    def restarted(self, text, of="a"):
        return text.replace("BATCh\n", f"BATCh\n  RESTart,{of}.restart.h5\n")

    def force(self, name):
        table = read_table(self.at / f"{name}_c.dat")
        return float(table.columns[table.find("force_3")][-1])

    def test_bonds_that_all_break_cause_no_other_warning(self):
        """No step ends with the forces that they bore, and rounding errors are all that is left."""
        warnings = self.run_deck("a", (HERE / "silent" / "bonds_all_broken.inp").read_text())
        self.assertEqual(len(warnings), 1, warnings)
        self.assertIn("of the bonds break within step 1", warnings[0])

    def test_warnings_come_again_in_a_run_that_continues_the_checkpoint(self):
        """Each run has a report of its own; with --restart, the report keeps its warnings."""
        text = self.without(PRESS)
        said = "surfaces penetrate by"
        self.assertIn(said, " ".join(self.run_deck("a", text)))
        warnings = self.run_deck("b", self.restarted(text))
        self.assertEqual(sum(said in warning for warning in warnings), 1, warnings)
        soft = text.replace("PENAlty 100", "PENAlty 1")
        soft = self.restarted(soft).replace(".h5\n", ".h5,CONStants\n")
        warnings = self.run_deck("c", soft)
        self.assertEqual(sum(said in warning for warning in warnings), 1, warnings)
        shutil.copy(self.at / "a.restart.h5", self.at / "first.h5")
        warnings = self.run_deck("a", text, "--restart", "first.h5")
        self.assertEqual(sum(said in warning for warning in warnings), 1, warnings)

    def test_events_before_the_checkpoint_are_warned_of_again(self):
        """Bonds that have broken do not break again."""
        text = (HERE / "silent" / "bonds_all_broken.inp").read_text()
        text = text.replace("  NEXT,newton\n", "  NEXT,newton\n  SAVE\n")
        warnings = self.run_deck("a", text)
        self.assertEqual(len(warnings), 1, warnings)
        self.assertIn("of the bonds break within step 1", warnings[0])
        warnings = self.run_deck("b", self.restarted(text))
        self.assertEqual(len(warnings), 1, warnings)
        self.assertIn("before the checkpoint, most bonds broke within one step", warnings[0])

    def test_multipliers_without_augment_after_a_restart_are_warned_of(self):
        for scheme in ("", "  SCHEme HALFpass\n"):
            text = PRESS.replace("  NORMal", scheme + "  NORMal")
            self.run_deck("a", text)
            said = "the checkpoint contains multipliers of AUGMent"
            warnings = self.run_deck("b", self.restarted(text))
            self.assertNotIn(said, " ".join(warnings))
            warnings = self.run_deck("c", self.restarted(self.without(text)))
            self.assertEqual(sum(said in warning for warning in warnings), 1, warnings)
            # nothing has moved, and the multipliers act in all runs
            self.assertAlmostEqual(self.force("c") / self.force("a"), 1.0, places=6)
            # also if the run without AUGMent is continued after its first step
            longer = self.restarted(self.without(text)).replace("LOOP,time,1", "LOOP,time,2")
            shutil.copy(self.at / "c.restart.h5", self.at / "kept.h5")
            self.run_deck("d", longer)
            whole = self.force("d")
            self.run_deck("c", self.restarted(self.without(text)), "--restart", "kept.h5")
            self.assertAlmostEqual(self.force("c") / whole, 1.0, places=6)
