"""What `make install PREFIX=` installs into a folder works there."""

import gzip
import os
import re
import shutil
import subprocess
import sys
import unittest

from verification import TOP
from verification.trouble.test_files import BEZEL, SECONDS, Folder

KINDS = ("release", "debug", "sanitize", "coverage")


def quiet():
    """The environment without the job server of another make."""
    return {k: v for k, v in os.environ.items() if not k.startswith(("MAKE", "MFLAGS"))}


class Install(Folder):
    def setUp(self):
        super().setUp()
        if BEZEL.parent.name not in KINDS:
            self.skipTest("the program was not built by this Makefile")
        self.prefix = self.at / "prefix"
        self.call("make", "install", f"KIND={BEZEL.parent.name}", f"BUILD={BEZEL.parents[1]}",
                  f"PREFIX={self.prefix}", cwd=TOP)  # fmt: skip

    def call(self, *command, cwd=None):
        """The output of a command that must succeed."""
        done = subprocess.run(
            [*map(str, command)], cwd=cwd or self.at, env={**quiet(), "PYTHON": sys.executable},
            capture_output=True, text=True, timeout=SECONDS, check=False)  # fmt: skip
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def test_everything_is_installed_and_runs(self):
        share = self.prefix / "share"
        bezel, post = self.prefix / "bin/bezel", self.prefix / "bin/bezel-post"
        self.call(bezel, "--quiet", "-o", "out", share / "doc/bezel/examples/manual/time.inp")
        self.assertTrue((self.at / "out/time.report.json").is_file())
        self.assertIn("curve", self.call(post, "--help"))
        for name in ("bezel", "bezel-post"):
            page = gzip.decompress((share / f"man/man1/{name}.1.gz").read_bytes()).decode()
            self.assertTrue(page.startswith(".TH BEZEL"), page[:40])
            self.assertTrue((share / "bash-completion/completions" / name).is_file())
        self.assertIn(page.split('"')[3].removeprefix("bezel "), self.call(bezel, "--version"))
        decks = {f.relative_to(TOP / "input") for f in (TOP / "input").rglob("*.inp")}
        installed = share / "doc/bezel/examples"
        self.assertEqual(decks, {f.relative_to(installed) for f in installed.rglob("*.inp")})


class Goals(unittest.TestCase):
    def test_every_goal_that_needs_the_program_knows_the_uses_of_modules(self):
        """A goal without depend.mk compiled only what had changed, and linked outdated users of
        its modules.
        """
        rules = "".join(
            (TOP / name).read_text()
            for name in ("Makefile", "tools/packages/packages.mk", "verification/unit/unit.mk")
        )
        needs = re.findall(r"^(\w+):(?!=).*\$\((?:B|U|BENCH)\)", rules, re.MULTILINE)
        compiles = re.search(r"^COMPILES := (.*)$", rules, re.MULTILINE)[1].split()
        self.assertIn("deck_errors", needs)
        self.assertEqual(set(needs) - set(compiles), set())

    def test_zero_does_not_switch_native_on(self):
        for value, expected in (("0", False), ("", False), ("1", True)):
            done = subprocess.run(["make", "-pn", "help", f"NATIVE={value}"], cwd=TOP, env=quiet(),
                                  capture_output=True, text=True, timeout=SECONDS, check=False)  # fmt: skip
            options = re.search(r"^OPT := (.*)$", done.stdout, re.MULTILINE)[1]
            self.assertEqual("-march=native" in options, expected, value)


class Tools(Folder):
    def start(self, *command, **env):
        return subprocess.run(
            [*map(str, command)], cwd=self.at, env={**quiet(), **env},
            capture_output=True, text=True, timeout=SECONDS, check=False)  # fmt: skip

    def test_bezel_post_does_not_run_files_of_the_working_folder(self):
        (self.at / "bin").mkdir()
        (self.at / "share/bezel").mkdir(parents=True)
        shutil.copy(TOP / "tools/packages/bezel-post", self.at / "bin")
        (self.at / "share/bezel/post").symlink_to(TOP / "post")
        for name in ("post", "numpy"):
            (self.at / f"{name}.py").write_text("print('mine')\n")
        (self.at / "a.dat").write_text("# step f\n1 2\n")
        done = self.start("bin/bezel-post", "diff", "a.dat", "a.dat", PYTHON=sys.executable)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("same: 1 table", done.stdout)
        self.assertNotIn("mine", done.stdout)

    def test_a_debian_package_without_its_tools_names_what_to_install(self):
        (self.at / "bin").mkdir()
        (self.at / "bin/dpkg-deb").write_text("")
        (self.at / "bin/dpkg-deb").chmod(0o755)
        (self.at / "debian").mkdir()
        done = self.start("/bin/sh", TOP / "tools/packages/deb.sh", self.at / "root", "1", "me",
                          PATH=str(self.at / "bin"))  # fmt: skip
        self.assertEqual(done.returncode, 1)
        self.assertIn("apt install dpkg-dev", done.stderr)

    def test_the_usage_of_setup_is_whole(self):
        done = self.start(TOP / "tools/setup.sh", "foo")
        self.assertEqual(done.returncode, 1)
        self.assertTrue(done.stdout.endswith("the exit code is 1.\n"), done.stdout)
        self.assertNotIn("set -eu", done.stdout)


if __name__ == "__main__":
    unittest.main()
