"""Any number of threads gives the results of one thread, bit for bit."""

import json
import os
import re
import resource
import unittest

from verification import TOP
from verification.trouble.test_files import BEZEL, Folder

CUBE = TOP / "verification" / "performance" / "cube.inp"
RESTART = TOP / "verification" / "restart"
COUNTS = (1, 2, 3)
MEASURED = ("seconds", "cpu_seconds", "peak_memory_mb")


class Threads(Folder):
    def results(self, deck, threads, *settings, code=0):
        """Run a deck; return the contents of its curves and tables, its report without what is
        measured, and its error message.
        """
        out = self.at / f"{deck.stem}_{threads}"
        done = self.run_bezel("-o", out, "--threads", threads, *settings, deck)
        self.assertEqual(done.returncode, code, done.stderr)
        found = {p.name: p.read_bytes() for p in [*out.glob("*.dat"), *out.glob("*.out")]}
        report = json.loads((out / f"{deck.stem}.report.json").read_text())
        report["warnings"] = [text for text in report["warnings"] if "threads" not in text]
        found["report"] = {key: report[key] for key in report if key not in MEASURED}
        found["error"] = re.findall(r"error: .*", done.stderr)
        return found

    def compare(self, deck, *settings, code=0):
        """Runs with every number of threads must agree; return the results."""
        one, *others = (self.results(deck, n, *settings, code=code) for n in COUNTS)
        for n, other in zip(COUNTS[1:], others):
            self.assertEqual(one.keys(), other.keys())
            for name in one:
                self.assertTrue(one[name] == other[name], f"{deck.stem}: {name}, {n} threads")
        return one

    def cube(self, name, **changes):
        """Write the deck of a cube with changed texts, which also prints tables; return its
        path.
        """
        text = CUBE.read_text().replace("\n    NEXT,newton", "\n    NEXT,newton\n    DISP,ALL")
        text = text.replace("\n    NEXT,newton", "\n    NEXT,newton\n    STRE,ALL")
        for old, new in changes.values():
            self.assertIn(old, text)
            text = text.replace(old, new)
        path = self.at / f"{name}.inp"
        path.write_text(text)
        return path

    def test_elements_of_every_kind(self):
        kinds = {
            "q1": (5, "Q1"),
            "q1e9": (5, "Q1E9"),
            "q1n2": (3, "Q1E9\n  ENRIch 3+ 2"),
            "q2": (3, "Q2"),
            "iga": (3, "IGA 2"),
        }
        for name, (n, kind) in kinds.items():
            deck = self.cube(name, kind=("TYPE Q1\n", f"TYPE {kind}\n"))
            self.compare(deck, "--set", f"n={n}", "--set", "steps=1")

    def test_kept_factors(self):
        self.compare(self.cube("kept"), "--set", "n=13", "--set", "steps=1")

    def test_contact(self):
        for name in ("cells", "peel"):
            self.compare(RESTART / f"{name}.inp")

    def test_an_inverted_element_is_the_same_and_so_is_the_cut_step(self):
        # compressed further, Q1E9 has several solutions, and rounding decides which one is found
        for kind, cut in {"Q1E9": "-0.55", "Q2": "-0.6"}.items():
            stem = kind.lower()
            changes = {
                "kind": ("TYPE Q1\n", f"TYPE {kind}\n"),
                "far": ("-0.25", "-1.2"),  # beyond the support, so that elements must be inverted
                "long": ("DT,,0.2", "DT,,1.0"),
            }
            deck = self.cube(f"{stem}_fails", **changes)
            failed = self.compare(deck, "--set", "n=3", "--set", "steps=1", code=2)
            self.assertIn("is inverted", failed["error"][0])
            changes["far"] = ("-0.25", cut)
            changes["auto"] = ("DT,,1.0", "DT,,1.0\n  AUTO,,1e-3,1")
            found = self.compare(self.cube(stem, **changes), "--set", "n=3", "--set", "steps=1")
            self.assertGreater(found["report"]["cutbacks"], 0)

    def test_more_threads_than_cores_cause_a_warning(self):
        many = os.cpu_count() + 1
        done = self.run_bezel("--threads", many, "box.inp")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(f"with {many} threads each share", done.stderr)
        self.assertNotIn("threads", self.run_bezel("box.inp").stderr)

    @unittest.skipIf("sanitize" in BEZEL.parts, "the sanitizer reserves terabytes of addresses")
    def test_the_environment_starts_no_threads(self):
        """The stacks of 64 threads would not fit into this address space."""
        done = self.run_bezel(
            "box.inp",
            limits=[(resource.RLIMIT_AS, 400 * 2**20)],
            env=os.environ | {"OMP_NUM_THREADS": "64"},
        )
        self.assertEqual(done.returncode, 0, done.stderr)
