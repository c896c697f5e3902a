"""The parser of the options of a command."""

import argparse
import re


def parser(**words):
    """An ArgumentParser for which -1e-3 and -.5,2 are values like -1, not options.

    >>> p = parser()
    >>> _ = p.add_argument("--range", type=float, nargs=2)
    >>> p.parse_args(["--range", "-1e-3", "-.5E2"]).range
    [-0.001, -50.0]
    """
    p = argparse.ArgumentParser(**words)
    p._negative_number_matcher = re.compile(r"^-\.?\d")
    return p
