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
