"""`python -m post COMMAND ...` runs the module that is named after the command."""

import difflib
import importlib
import sys

from post import COMMANDS
from post._error import Unreadable

USAGE = """usage: python -m post COMMAND ...

  curve        FILE.dat [FILE2 ...] -x disp -y force -o fig.png
  convergence  TABLE.csv [--where test=compression] -o fig.png
  field        RUN.vtkhdf --step last --scalar mises -o fig.png
  contact-map  RUN.vtkhdf [RUN2 ...] --scalar contact_pressure -o fig.png
  mesh         NET -o DIR/NAME [--enrich CHOICE] [--group NAME=CHOICE] [--pictures]
  diff         A B [--rel 1e-6] [--expect expect.toml] [--json F] [--junit F] [--update]

`python -m post COMMAND --help` lists the options of a command."""


def main(argv=None):
    """Run one command; return its exit code (2: a file or an option cannot be used)."""
    argv = sys.argv[1:] if argv is None else argv
    if not argv or argv[0] in ("-h", "--help"):
        print(USAGE)
        return 0 if argv else 2
    if argv[0] not in COMMANDS:
        near = difflib.get_close_matches(argv[0], COMMANDS, 1)
        hint = f"did you mean '{near[0]}'?" if near else "known commands: " + " ".join(COMMANDS)
        print(f"post: error: unknown command '{argv[0]}'\nhint: {hint}", file=sys.stderr)
        return 2
    try:
        return importlib.import_module(f"post.{argv[0].replace('-', '_')}").main(argv[1:])
    except Unreadable as error:
        print(f"post {argv[0]}: error: {error}", file=sys.stderr)
        return 2
    except ModuleNotFoundError as error:
        print(
            f"post {argv[0]}: error: the Python package '{error.name}' is not installed\n"
            "hint: python3 -m venv .venv && .venv/bin/pip install -r post/requirements.txt",
            file=sys.stderr,
        )
        return 2
    except BrokenPipeError:  # the reader of the output has ended, as in `| head`
        sys.stderr.close()
        return 2


if __name__ == "__main__":
    sys.exit(main())
