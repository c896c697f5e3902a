"""The examples in the docstrings run, and the commands that compare need numpy alone."""

import doctest
import importlib
import pathlib
import pkgutil
import subprocess
import sys
import unittest

import post

TOP = pathlib.Path(post.__file__).parents[1]


def load_tests(loader, tests, pattern):
    """Add the examples of each module of the package (python -m unittest calls this)."""
    for module in pkgutil.walk_packages(post.__path__, "post."):
        if ".tests.test_" not in module.name and not module.name.endswith("__main__"):
            tests.addTests(doctest.DocTestSuite(importlib.import_module(module.name)))
    return tests


class Imports(unittest.TestCase):
    def test_diff_loads_numpy_alone(self):
        code = "import sys, post, post.diff; print([m for m in ('matplotlib', 'h5py', 'vtkmodules', 'pyvista') if m in sys.modules])"
        done = subprocess.run(
            [sys.executable, "-c", code], cwd=TOP, capture_output=True, text=True, check=True
        )
        self.assertEqual(done.stdout.strip(), "[]")

    def test_help_of_every_command_is_printed(self):
        for command in post.COMMANDS:
            done = subprocess.run(
                [sys.executable, "-m", "post", command, "--help"],
                cwd=TOP,
                capture_output=True,
                text=True,
            )
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("usage: post " + command, done.stdout)


if __name__ == "__main__":
    unittest.main()
