"""Hints, notes and reasons of failures on the screen fit the deck that they are about."""

import json
import pathlib

from verification.trouble.test_files import Folder

SILENT = pathlib.Path(__file__).resolve().parent / "silent"
FINE = 14.06  # the force of 12 x 12 x 12 Q1E9; 8 x 8 x 8 Q2 give 14.54
SQUEEZED = (SILENT / "locking.inp").read_text().replace("0.4999", "0.499").replace("0 0 0.02", "0 0 -0.1")


class Locking(Folder):
    def force(self, name, record):
        """The largest force of a squeezed block whose elements are those of this record."""
        deck = SQUEEZED.replace("TYPE Q1\n", record)
        (self.at / f"{name}.inp").write_text(deck)
        done = self.run_bezel(f"{name}.inp")
        self.assertEqual(done.returncode, 0, done.stderr)
        report = json.loads((self.at / f"{name}.report.json").read_text())
        return report["final"]["force"]["force_3"], done.stderr

    def test_what_the_hint_recommends_does_not_lock(self):
        """Layers on Q1 and quadratic splines give 7.5 and 1.6 times the force of a fine mesh."""
        _, said = self.force("q1", "TYPE Q1\n")
        self.assertIn("use TYPE Q1E9 (ENHAnced with ELEMents), with ENRIch ... EAS on it, or Q2", said)
        self.assertNotIn("IGA", said)
        for name, record in {
            "q1e9": "TYPE Q1E9\n",
            "layer": "TYPE Q1E9\n  ENRIch 3+ 2 EAS\n",
            "q2": "TYPE Q2\n",
        }.items():
            with self.subTest(name):
                force, said = self.force(name, record)
                self.assertNotIn("lock", said)
                self.assertLess(force, 1.25 * FINE)
