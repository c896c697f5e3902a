"""Check the runner itself: read the output of its tests, whose names say how each of them must end.

usage: RUN test_funit -v | check.py
"""

import re
import sys

text = sys.stdin.read()
started = re.findall(r"test_funit\.pf: (\w+)$", text, re.M)
failed = set(re.findall(r"test_funit\.pf:\d+: (\w+): ", text))
wrong = [name for name in started if name.startswith("fails_") != (name in failed)]
if wrong or not started:
    sys.exit(f"{text}\nthe runner judges wrongly: {' '.join(wrong) or 'nothing ran'}")
