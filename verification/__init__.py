"""Programs that run decks and compare the results; run them from the top of the tree.

    .venv/bin/python -m verification.verify --case section4

    verify              the checks of all `expect.toml` (`make verify`)
    reference           a second implementation of three problems, to compare with the program
    section3            meshes below surfaces, and their use in runs
    section5_contact    sections 5.2 and 5.3: the hemisphere on the block
    section5_debonding  section 5.1: the strip peeled off the plate
    tradeoff            accuracy and cost of the options of contact (`make tradeoff`)
    contact_extremes    contact with extreme parameters
    debonding_extremes  debonding with extreme parameters
    debonding_points    accuracy and cost of the integration points of bonds
    lumped_mass         errors of lumped masses, by theory
    mutate              mutated decks
    mutate_source       changes of the source, and which of them the tests notice
    deck_errors.run     bad decks and their messages
    restart.run         stopped and restarted runs
    recover             the same for the runs of the quick checks (`verify --recover`)
    soak                random hostile inputs, kills, signals, limits and other units (`make soak`)
    trouble             files, signals, limits, damaged checkpoints; decks that must not go wrong silently
    performance.bench   comparison of speed with other programs (`make bench`)

Programs in `benchmark` and `patch` write the references, decks and tables of their folders.
"""

import importlib.util
import os
import pathlib
import sys

TOP = pathlib.Path(__file__).resolve().parent.parent  # top of the tree


def need_numpy():
    """Restart with the Python of .venv if this Python has no numpy; stop if neither has it."""
    if importlib.util.find_spec("numpy"):
        return
    python = TOP / ".venv/bin/python"
    other = pathlib.Path(sys.prefix).resolve() != (TOP / ".venv").resolve()
    if python.exists() and other and "-m" in sys.orig_argv:
        os.execv(python, [str(python), *sys.orig_argv[sys.orig_argv.index("-m") :]])
    sys.exit(
        "verify: error: the Python package numpy is missing\n"
        "hint: python3 -m venv .venv && .venv/bin/pip install -r post/requirements.txt (or apt install python3-numpy)"
    )
