"""The factors that FACTor AUTO keeps lead to the same solution as FULL, and to identical bits in
every run.
"""

import json
import re

from verification import TOP
from verification.trouble.test_files import Folder

CUBE = TOP / "verification" / "performance" / "cube.inp"


class Kept(Folder):
    """The cube has 14,000 equations, slightly more than the number from which AUTO keeps
    factors.
    """

    def solve(self, name, factor="", n=13, steps=2):
        """Return the report, the bytes of the curve, and the log."""
        text = CUBE.read_text().replace("BATCh\n", f"BATCh\n  {factor}\n")
        (self.at / f"{name}.inp").write_text(text)
        done = self.run_bezel("--set", f"n={n}", "--set", f"steps={steps}", f"{name}.inp")
        self.assertEqual(done.returncode, 0, done.stderr)
        report = json.loads((self.at / f"{name}.report.json").read_text())
        curve = (self.at / f"{name}_force.dat").read_bytes()
        return report, curve, (self.at / f"{name}.log").read_text()

    def factorisations(self, log):
        return int(re.search(r"^factorise +(\d+)", log, re.MULTILINE)[1])

    def test_a_large_model_keeps_factors_by_default_and_has_the_answer_of_full(self):
        report, curve, log = self.solve("default")
        full, _, full_log = self.solve("full", "FACTor FULL")
        force = full["final"]["force"]["force_3"]
        self.assertAlmostEqual(report["final"]["force"]["force_3"] / force, 1, delta=1e-10)
        self.assertLessEqual(abs(report["iterations"] - full["iterations"]), 2)
        self.assertEqual(report["negative_pivots"], 0)
        self.assertLess(self.factorisations(log), 4)
        self.assertEqual(self.factorisations(full_log), full["iterations"])
        self.assertIn("krylov", log)
        for part in ("analyse", "factorise", "solve", "assembly"):
            self.assertGreater(report["cpu_seconds"][part], 0, part)
        again, same, _ = self.solve("again", "FACTor AUTO")
        self.assertEqual(curve, same)
        self.assertEqual(report["final"], again["final"])

    def test_a_small_model_has_the_bits_of_full(self):
        report, curve, log = self.solve("default", n=4)
        full, same, _ = self.solve("full", "FACTor FULL", n=4)
        self.assertEqual(curve, same)
        self.assertEqual(report["iterations"], full["iterations"])
        self.assertNotIn("krylov", log)
