"""Programs that run decks and compare what they compute; start them from the top of the tree.

verify              checks of `expect.toml`, what `make verify` runs
section3            meshes below surfaces, and runs on them
section5_contact    sections 5.2 and 5.3: the hemisphere on the block
section5_debonding  section 5.1: the strip peeled off the plate
tradeoff            errors and CPU seconds of what a user may choose in contact
contact_extremes, debonding_extremes, debonding_points, mutate, and the programs of the folders
deck_errors, restart, performance, patch and benchmark: their docstrings say what they do.

    .venv/bin/python -m verification.verify --case section4
"""

import importlib.util
import os
import pathlib
import sys

TOP = pathlib.Path(__file__).resolve().parent.parent  # of the tree


def need_numpy():
    """Continue with the Python of .venv if this one has no numpy; stop if that has none either."""
    if importlib.util.find_spec("numpy"):
        return
    python = TOP / ".venv/bin/python"
    if python.exists() and pathlib.Path(sys.prefix).resolve() != (TOP / ".venv").resolve():
        os.execv(python, [str(python), *sys.orig_argv[1:]])
    sys.exit(
        "verify: error: the Python package numpy is missing\n"
        "hint: python3 -m venv .venv && .venv/bin/pip install -r post/requirements.txt (or apt install python3-numpy)"
    )
