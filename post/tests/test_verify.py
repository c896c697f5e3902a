"""`verification.verify` with a stand-in for the program: every way a check can fail must be
counted as failed.
"""

import contextlib
import importlib.util
import io
import sys
import unittest
from unittest import mock

from post.tests.samples import Scratch, write_fields
from verification import verify

#: Writes the force -0.25 n (1 + error) and 135 dofs; `fail=1` ends with code 2; `nan=1` writes NaN.
PROGRAM = """#!{python}
import sys, pathlib, json
words = sys.argv[1:]
out = pathlib.Path(words[words.index("-o") + 1])
p = dict(words[i + 1].split("=") for i, w in enumerate(words) if w == "--set")
stem = pathlib.Path(words[-1]).stem
if p.get("fail"):
    print("step 1 did not converge", file=sys.stderr); sys.exit(2)
force = "nan" if p.get("nan") else repr(-0.25 * float(p["n"]) * (1 + float(p.get("error", 0))))
(out / (stem + "_force.dat")).write_text("# step time converged force_top_3\\n1 0.5 1 0.0\\n2 1.0 1 " + force + "\\n")
(out / (stem + ".report.json")).write_text(json.dumps(dict(status="done", dofs=135 * int(p["n"]))))
"""
CHECK = '[[check]]\ndeck = "a.inp"\ncurve = "force"\n'


class Verify(Scratch):
    def setUp(self):
        super().setUp()
        self.case = self.folder / "cases/cube"
        self.case.mkdir(parents=True)
        roots = mock.patch.object(verify, "ROOTS", (self.folder / "cases",))
        roots.start()
        self.addCleanup(roots.stop)
        self.program = self.folder / "bezel"
        self.program.write_text(PROGRAM.format(python=sys.executable))
        self.program.chmod(0o755)

    def run_verify(self, expect, *words):
        """(exit code, last line); everything printed is in self.said"""
        (self.case / "expect.toml").write_text(expect)
        said = io.StringIO()
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            code = verify.main(
                ["--bezel", str(self.program), "--out", str(self.folder / "out"), *words]
            )
        self.said = said.getvalue()
        return code, self.said.strip().splitlines()[-1]

    def test_a_value_within_tolerance_passes_and_one_outside_fails(self):
        check = CHECK + "want = -0.5\nrel = 1e-6\n"
        self.assertEqual(self.run_verify(check + "set = { n = 2 }\n"), (0, "1 passed, 0 failed"))
        self.assertEqual(
            self.run_verify(check + "set = { n = 2, error = 1e-5 }\n"), (1, "0 passed, 1 failed")
        )

    def test_row_factor_and_report_are_understood(self):
        expect = CHECK + "set = { n = 1 }\nrow = 1\nwant = 0\nabs = 1e-9\n"
        expect += (
            CHECK + "set = { n = 1 }\nrow = { time = 1.0 }\nfactor = 4\nwant = -1.0\nrel = 1e-12\n"
        )
        expect += '[[check]]\ndeck = "a.inp"\nset = { n = 1 }\nreport = "dofs"\nwant = 135\n'
        expect += '[[check]]\ndeck = "a.inp"\nset = { n = 1 }\nreport = "status"\nwant = "done"\n'
        self.assertEqual(self.run_verify(expect), (0, "4 passed, 0 failed"))

    def test_whatever_goes_wrong_is_a_failed_row_and_the_rest_goes_on(self):
        good = CHECK + "set = { n = 1 }\nwant = -0.25\nrel = 1e-9\n"
        bad = [
            CHECK + "set = { n = 1, nan = 1 }\nwant = -0.25\nrel = 1e9\n",
            CHECK + "set = { n = 1, fail = 1 }\nwant = -0.25\nrel = 1\n",
            CHECK + "set = { n = 1 }\nrel = 1\n",
            CHECK + "set = { n = 1 }\ncolumn = 'torque'\nwant = 1\nrel = 1\n",
            CHECK + "set = { n = 1 }\nrow = 7\nwant = 1\nrel = 1\n",
            "[[check]]\nname = 'none'\ncurve = 'force'\nwant = 1\n",
            CHECK.replace("force", "torque") + "set = { n = 1 }\nwant = 1\nrel = 1\n",
            CHECK + "set = { n = 1 }\nwant = -0.25\nrel = -1\n",
        ]
        code, last = self.run_verify("".join(bad) + good)
        self.assertEqual((code, last), (1, f"1 passed, {len(bad)} failed"), self.said)
        self.assertIn("step 1 did not converge", self.said)

    def test_no_check_and_no_program_and_no_case_do_not_pass(self):
        self.assertEqual(self.run_verify("title = 'empty'\n")[0], 1)
        self.assertEqual(self.run_verify(CHECK + "wnt = 1\n"), (1, "0 passed, 1 failed"))
        self.assertEqual(self.run_verify("title = ", "--case", "cube"), (1, "0 passed, 1 failed"))
        check = CHECK + "set = { n = 1 }\nwant = -0.25\nrel = 1e-9\n"
        self.assertEqual(self.run_verify(check, "--case", "sphere")[0], 1)
        self.program.unlink()
        self.assertEqual(self.run_verify(check), (1, "0 passed, 1 failed"))

    def test_each_row_of_a_table_is_a_check(self):
        (self.case / "ref.csv").write_text("kind,n,f\nQ1,1,-0.25\nQ1,2,-0.5\nQ2,1,-0.26\n")
        expect = '[[check]]\neach = "ref.csv"\nname = "{kind} {n}"\nset = { n = "{n}" }\ncurve = "force"\nwant = "{f}"\n'
        expect += '[check.map.kind]\nQ1 = { deck = "a.inp", rel = 1e-9 }\nQ2 = { deck = "b.inp", rel = 1e-9 }\n'
        self.assertEqual(self.run_verify(expect), (1, "2 passed, 1 failed"))
        self.assertRegex(self.said, r"Q2 1 +-0.25 +-0.26 +3.8e-02 +rel 1e-09 +FAILED")

    def test_a_whole_curve_is_compared(self):
        (self.case / "ref.csv").write_text("time,force_top_3\n0.5,0\n1,-0.25\n")
        expect = CHECK + 'set = { n = 1 }\nreference = "ref.csv"\nrel = 1e-9\n'
        self.assertEqual(self.run_verify(expect), (0, "2 passed, 0 failed"))
        (self.case / "ref.csv").write_text("time,force_top_3\n0.5,0\n1,-0.25\n2,0\n")
        self.assertEqual(self.run_verify(expect), (1, "2 passed, 1 failed"))

    def test_a_study_is_judged_on_its_finest_mesh_and_written(self):
        expect = '[[study]]\nvary = { kind = ["Q1", "Q2"], n = [1, 2] }\nslow = [4]\ndeck = "a.inp"\nset = { n = "{n}" }\n'
        expect += 'curve = "force"\nvalue = "f"\nwant = -0.5\nlimit = 1e-6\n'
        self.assertEqual(self.run_verify(expect), (0, "2 passed, 0 failed"))
        self.assertFalse((self.case / "results.csv").exists())
        self.assertEqual(self.run_verify(expect, "--all"), (1, "0 passed, 2 failed"))
        self.assertEqual(self.run_verify(expect, "--study")[1], "2 passed, 0 failed")
        lines = (self.case / "results.csv").read_text().splitlines()
        self.assertEqual(lines[1:3], ["kind,n,dofs,f,error", "Q1,1,135,-0.25,-5.0000e-01"])
        self.assertEqual(self.run_verify(expect + "shrink = 0.5\n"), (0, "2 passed, 0 failed"))

    @unittest.skipUnless(importlib.util.find_spec("h5py"), "h5py is not installed")
    def test_a_field_is_compared_at_every_point(self):
        write_fields(self.folder / "r.vtkhdf")
        self.program.write_text(
            f"#!{sys.executable}\nimport shutil, sys\n"
            f"shutil.copy({str(self.folder / 'r.vtkhdf')!r}, sys.argv[sys.argv.index('-o') + 1] + '/a.vtkhdf')\n"
        )
        linear = '[[check]]\ndeck = "a.inp"\nfield = "displacement"\nscaled = 1e-12\naffine = [[{}, 0, 0], [0, -0.1, 0], [0, 0, 0.4]]\n'
        constant = '[[check]]\ndeck = "a.inp"\nfield = "stress"\nrow = 20\nabs = 1e-12\nwant = [0.5, 0, 0, 0, 0, {}]\n'
        good = linear.format(0.3) + constant.format(-0.5)
        self.assertEqual(self.run_verify(good), (0, "2 passed, 0 failed"), self.folder)
        bad = (
            linear.format(0.3001)
            + constant.format(0.5)
            + linear.format(0.3).replace("scaled = 1e-12\n", "")
        )
        self.assertEqual(self.run_verify(bad), (1, "0 passed, 3 failed"))


if __name__ == "__main__":
    unittest.main()
