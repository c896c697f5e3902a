"""Results never replace a file that the run reads, and files are complete however a run ends.

The environment variable BEZEL names the program; the default is build/release/bezel.
"""

import json
import os
import pathlib
import resource
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

HERE = pathlib.Path(__file__).resolve().parent
BEZEL = pathlib.Path(os.environ.get("BEZEL", HERE / "../../build/release/bezel")).resolve()
SECONDS = 60


class Folder(unittest.TestCase):
    """Each test works in a folder that contains only the deck box.inp."""

    def setUp(self):
        self.at = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.at)
        self.deck = (HERE / "box.inp").read_text()
        (self.at / "box.inp").write_text(self.deck)

    def run_bezel(self, *arguments, limits=(), **more):
        """Run the program in the folder; limits are pairs of a resource and a number."""

        def set_limits():
            for kind, most in limits:
                resource.setrlimit(kind, (most, most))

        return subprocess.run(
            [BEZEL, *map(str, arguments)],
            cwd=self.at,
            capture_output=True,
            text=True,
            timeout=SECONDS,
            preexec_fn=set_limits if limits else None,
            check=False,
            **more,
        )

    def files(self):
        return sorted(path.name for path in self.at.iterdir())


class Hints(Folder):
    def test_a_symmetric_tangent_of_friction_that_fails_names_utan(self):
        """Without the hint, a user of TANG is advised to take smaller steps, which do not help."""
        deck = (HERE / "tangent_friction.inp").read_text()
        (self.at / "tang.inp").write_text(deck)
        done = self.run_bezel("tang.inp")
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn("use UTAN,,1", done.stderr)
        (self.at / "utan.inp").write_text(deck.replace("TANG,,1", "UTAN,,1"))
        done = self.run_bezel("utan.inp")
        self.assertEqual(done.returncode, 0, done.stderr)


class Inputs(Folder):
    def refused(self, *arguments):
        """The run must end with code 1 and leave every file as it was."""
        before = {path.name: path.read_text() for path in self.at.iterdir()}
        done = self.run_bezel(*arguments)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("would overwrite", done.stderr)
        self.assertEqual(before, {path.name: path.read_text() for path in self.at.iterdir()})

    def test_a_deck_named_like_the_log_is_kept(self):
        (self.at / "my.log").write_text(self.deck)
        self.refused("my.log")

    def test_an_included_file_named_like_a_curve_is_kept(self):
        (self.at / "x_force.dat").write_text("! nothing\n")
        (self.at / "box.inp").write_text(
            self.deck.replace("PARAmeters", "INCLude x_force.dat\n\nPARAmeters")
        )
        self.refused("--name", "x", "box.inp")

    def test_a_deck_is_kept_under_another_name_of_the_same_file(self):
        os.link(self.at / "box.inp", self.at / "y.report.json.part")
        self.refused("--name", "y", "box.inp")

    def test_a_mesh_named_like_the_report_is_kept(self):
        mesh = HERE.parent / "deck_errors" / "mesh_good.msh"
        shutil.copy(mesh, self.at / "m.report.json")
        (self.at / "m.inp").write_text(
            "FEAP ** mesh\n  ndm = 3\n\nMATErial 1\n  SOLId\n    ELAStic NEOHook 1 0.3\n    FINIte VOLUme 3\n\n"
            "MESH,a FILE m.report.json\n  MATErial 1\n\nEND\n\nSTOP\n"
        )
        self.refused("m.inp")

    def test_links_of_results_are_replaced_and_not_followed(self):
        out = self.at / "out"
        out.mkdir()
        (self.at / "precious").write_text("precious\n")
        for name in ("log", "lock", "report.json.part", "restart.h5.part", "vtkhdf.part"):
            (out / f"box.{name}").symlink_to("../precious")
        os.link(self.at / "precious", out / "box_force.dat.part")
        done = self.run_bezel("-o", "out", "box.inp")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual((self.at / "precious").read_text(), "precious\n")
        self.assertFalse((out / "box.log").is_symlink())

    def test_curves_of_an_earlier_run_are_removed_and_nothing_else(self):
        """If a run closed no step, old curves used to remain beside its log as if they were its
        own.
        """
        self.assertEqual(self.run_bezel("-o", "out", "--name", "a", "box.inp").returncode, 0)
        for name in ["a_other.dat", "b_force.dat"]:
            (self.at / "out" / name).write_text("kept")
        text = self.deck.replace("TANG,,1", "TANG").replace("SAVE", "")
        (self.at / "idle.inp").write_text(text)
        row = (self.at / "out/a_force.dat").read_text()
        (self.at / "bad.inp").write_text(
            text.replace("ELAStic NEOHook e nu", "ELAStic NEOHook e 2")
        )
        self.assertEqual(self.run_bezel("-o", "out", "--name", "a", "bad.inp").returncode, 1)
        self.assertEqual(
            self.run_bezel("-o", "out", "--name", "a", "--check", "idle.inp").returncode, 0
        )
        self.assertEqual((self.at / "out/a_force.dat").read_text(), row)
        done = self.run_bezel("-o", "out", "--name", "a", "idle.inp")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("0 steps", done.stderr)
        names = sorted(path.name for path in (self.at / "out").iterdir())
        kept = ["a.log", "a.report.json", "a.restart.h5", "a_other.dat", "b_force.dat"]
        self.assertEqual(names, kept)

    def test_fields_and_tables_of_an_earlier_run_are_removed(self):
        """They used to remain if the new run wrote none, or failed in its first step."""
        text = self.deck.replace("    SAVE\n", "    DISP,ALL\n    PLOT\n").replace(
            "time,10", "time,2"
        )
        for name, code in (("none", 0), ("fails", 2)):
            with self.subTest(name):
                (self.at / "box.inp").write_text(text)
                self.assertEqual(self.run_bezel("box.inp").returncode, 0)
                results = ["box.out", "box.pvd", "box.vtkhdf", "box_0001.vtu", "box_0002.vtu"]
                self.assertLessEqual(set(results), set(self.files()))
                new = self.deck.replace("    SAVE\n", "")
                if code:
                    new = text.replace("way = 0.1", "way = 100")
                (self.at / "box.inp").write_text(new)
                self.assertEqual(self.run_bezel("--check", "box.inp").returncode, 0)
                self.assertLessEqual(set(results), set(self.files()))
                self.assertEqual(self.run_bezel("box.inp").returncode, code)
                self.assertEqual(set(results) & set(self.files()), set())

    def test_a_curve_of_another_name_is_not_replaced(self):
        """The curve y_force of x and the curve force of x_y would have the same file."""
        (self.at / "other.inp").write_text(self.deck.replace("CURVe,force", "CURVe,y_force"))
        self.assertEqual(self.run_bezel("--name", "x_y", "box.inp").returncode, 0)
        row = (self.at / "x_y_force.dat").read_text()
        done = self.run_bezel("--name", "x", "other.inp")
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("would overwrite './x_y_force.dat', the curve 'force' of 'x_y'", done.stderr)
        self.assertEqual((self.at / "x_y_force.dat").read_text(), row)
        for name in ("x_y_force.dat", "x_y.report.json"):
            (self.at / name).unlink()
        self.assertEqual(self.run_bezel("--name", "x", "other.inp").returncode, 0)
        done = self.run_bezel("--name", "x_y", "box.inp")
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("the curve 'y_force' of 'x'", done.stderr)
        self.assertEqual(self.run_bezel("--name", "x", "other.inp").returncode, 0)

    def test_restarts_keep_the_curves(self):
        self.assertEqual(self.run_bezel("box.inp").returncode, 0)
        row = (self.at / "box_force.dat").read_text()
        self.assertEqual(self.run_bezel("--restart", "box.restart.h5", "box.inp").returncode, 0)
        self.assertEqual((self.at / "box_force.dat").read_text(), row)
        first, last = self.deck.split("BATCh\n", 1)
        (self.at / "box.inp").write_text(first + "BATCh\n  RESTart\nEND\n\nSTOP\n")
        done = self.run_bezel("box.inp")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual((self.at / "box_force.dat").read_text(), row)

    def test_intervals_of_histories_and_of_fields_select_the_same_steps(self):
        text = self.deck.replace("BATCh\n", "BATCh\n  TPLOt,,3\n").replace(
            "END\n2 1", "END\nDISP 1 3\n\n2 1"
        )
        (self.at / "box.inp").write_text(text)
        self.assertEqual(self.run_bezel("box.inp").returncode, 0)
        rows = (self.at / "box_tplot.dat").read_text().splitlines()[1:]
        self.assertEqual([int(row.split()[0]) for row in rows], [3, 6, 9])

    def test_a_bad_name_makes_no_folder(self):
        for name in (".", "..", "a/b", 300 * "a"):
            done = self.run_bezel("-o", "out", "--name", name, "box.inp")
            self.assertEqual(done.returncode, 1, name)
            self.assertEqual(self.files(), ["box.inp"])


class Words(Folder):
    def test_out_is_answered_with_o(self):
        done = self.run_bezel("--out", "folder", "box.inp")
        self.assertEqual(done.returncode, 1)
        self.assertIn("hint: -o DIR", done.stderr)

    def test_a_run_ends_with_one_line(self):
        done = self.run_bezel("box.inp")
        self.assertRegex(done.stderr, r"\Abezel: done, .* steps?, .* s; see ./box\.log\n\Z")
        self.assertEqual(self.run_bezel("--quiet", "box.inp").stderr, "")

    def test_a_file_without_bezier_cells_has_the_version_that_others_read(self):
        for kind, version in (("Q1", "1.0"), ("IGA 2", "2.2")):
            text = self.deck.replace("TYPE Q1", f"TYPE {kind}").replace("    SAVE\n", "    PLOT\n")
            (self.at / "box.inp").write_text(text)
            self.assertEqual(self.run_bezel("box.inp").returncode, 0)
            for file in self.at.glob("box_*.vtu"):
                self.assertIn(f'version="{version}"'.encode(), file.read_bytes()[:200])
            self.assertTrue(list(self.at.glob("box_*.vtu")))


class Limits(Folder):
    def test_files_that_cannot_grow_end_with_code_3_and_a_report(self):
        for room in (1024, 8192, 40960):
            out = self.at / str(room)
            done = self.run_bezel("-o", out, "box.inp", limits=[(resource.RLIMIT_FSIZE, room)])
            self.assertEqual(done.returncode, 3, done.stderr)
            self.assertEqual(json.loads((out / "box.report.json").read_text())["exit_code"], 3)
            self.assertFalse((out / "box.lock").exists())
            self.assertFalse((out / "box.report.json.part").exists())

    @unittest.skipUnless(os.geteuid() == 0 and shutil.which("mount"), "only root mounts a disk")
    def test_a_full_disk_leaves_no_unfinished_file(self):
        """If there was no room even for its first bytes, an empty field file used to be left."""
        (self.at / "box.inp").write_text(self.deck.replace("    SAVE\n", "    PLOT\n    SAVE\n"))
        for pages in range(2, 12):
            out = self.at / str(pages)
            out.mkdir()
            mount = ["mount", "-t", "tmpfs", "-o", f"size={4096 * pages}", "none", out]
            if subprocess.run(mount, capture_output=True, check=False).returncode != 0:
                self.skipTest("this system mounts no disk")
            try:
                done = self.run_bezel("-o", out, "box.inp")
                self.assertEqual(done.returncode, 3, done.stderr)
                self.assertEqual([f.name for f in out.glob("*.part")], [], f"{pages} pages")
            finally:
                subprocess.run(["umount", out], check=True)

    def test_no_room_at_all_ends_with_code_3(self):
        done = self.run_bezel("box.inp", limits=[(resource.RLIMIT_FSIZE, 0)])
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertFalse((self.at / "box.lock").exists())

    @unittest.skipIf("sanitize" in BEZEL.parts, "the sanitizer reserves terabytes of addresses")
    def test_small_address_spaces_end_at_once(self):
        """With some limits, the threads of OpenBLAS used to wait forever for their memory."""
        environment = {k: v for k, v in os.environ.items() if not k.startswith("OPENBLAS_NUM")}
        for threads, sizes in ((1, (250, 310, 340)), (2, (320, 480, 600, 700, 900))):
            for size in sizes:
                done = self.run_bezel(
                    "--threads",
                    threads,
                    "box.inp",
                    limits=[(resource.RLIMIT_AS, size * 2**20)],
                    env=environment,
                )
                self.assertIn(done.returncode, (0, 3), f"{threads} threads, {size} MB")

    @unittest.skipIf("sanitize" in BEZEL.parts, "the sanitizer reserves terabytes of addresses")
    def test_factors_go_to_disk_where_memory_is_short_and_give_the_same_digits(self):
        shutil.copy(HERE / "../performance/cube.inp", self.at / "cube.inp")
        arguments = ("cube.inp", "--set", "n=16", "--set", "steps=1")
        self.assertEqual(self.run_bezel(*arguments).returncode, 0)
        whole = (self.at / "cube_force.dat").read_text().split()[-1]
        used = set()
        for size in range(350, 280, -20):
            done = self.run_bezel(*arguments, limits=[(resource.RLIMIT_AS, size * 2**20)])
            self.assertIn(done.returncode, (0, 3), f"{size} MB: {done.stderr}")
            self.assertEqual([name for name in self.files() if "mumps" in name], [])
            if done.returncode == 3:
                continue
            force = (self.at / "cube_force.dat").read_text().split()[-1]
            self.assertAlmostEqual(float(force) / float(whole), 1.0, delta=1e-9)
            log = (self.at / "cube.log").read_text()
            used |= {line for line in log.splitlines() if line.endswith("precision on disk")}
        self.assertTrue(used)


def heed():
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


class Signals(Folder):
    def stopped(self, number, delay, *arguments, ignore=None):
        """The exit code of a run to which a signal is sent after a delay."""
        process = subprocess.Popen(
            [BEZEL, "--quiet", *arguments, "box.inp"],
            cwd=self.at,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            preexec_fn=ignore or heed,  # under nohup the tests themselves ignore SIGHUP
        )
        time.sleep(delay)
        process.send_signal(number)
        return process.wait(SECONDS)

    def test_a_signal_in_a_step_writes_a_checkpoint(self):
        for number in (signal.SIGHUP, signal.SIGUSR1, signal.SIGUSR2, signal.SIGTERM):
            code = self.stopped(number, 0.6, "--set", "n=14", "-o", number.name)
            self.assertEqual(code, 4, number)
            left = {path.suffix for path in (self.at / number.name).iterdir()}
            self.assertEqual(left & {".lock", ".part"}, set())
            self.assertTrue((self.at / number.name / "box.restart.h5").exists())

    def test_a_signal_while_the_deck_is_read_writes_a_checkpoint(self):
        for number in (signal.SIGHUP, signal.SIGTERM):
            self.assertEqual(self.stopped(number, 0.3, "--set", "n=70", "-o", number.name), 4)
            self.assertTrue((self.at / number.name / "box.restart.h5").exists())

    def test_nohup_stays_in_force(self):
        ignore = lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN)
        self.assertEqual(self.stopped(signal.SIGHUP, 0.3, "--set", "n=8", ignore=ignore), 0)

    def test_the_time_limit_includes_reading(self):
        done = self.run_bezel("--set", "n=60", "--time-limit", "0.05", "box.inp")
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertEqual(json.loads((self.at / "box.report.json").read_text())["steps"], 0)


if __name__ == "__main__":
    unittest.main()
