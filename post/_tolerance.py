"""Tolerances of a comparison: a general one, and others for particular columns."""

import fnmatch
import math
from dataclasses import dataclass, field

from post._error import Unreadable

KINDS = ("rel", "abs", "scaled")


@dataclass(frozen=True)
class Tolerance:
    """A value passes if |got - want| is at most the largest of

    rel * |want|,  abs,  scaled * (largest |want| of the column).

    >>> Tolerance(rel=1e-3).allowed(want=2.0, largest=5.0)
    0.002
    """

    rel: float = 0.0
    abs: float = 0.0
    scaled: float = 0.0

    def __post_init__(self):
        for kind in KINDS:
            value = getattr(self, kind)
            if isinstance(value, bool) or not isinstance(value, (int, float)):
                raise Unreadable(f"the tolerance {kind} = {value!r} is not a number")
            if not (math.isfinite(value) and value >= 0):
                raise Unreadable(f"the tolerance {kind} = {value} is negative or not finite")

    def allowed(self, want, largest):
        """The largest difference that passes; `want` may be an array."""
        import numpy as np

        bound = np.maximum(self.rel * np.abs(want), max(self.abs, self.scaled * largest))
        return bound if np.ndim(bound) else float(bound)

    def __str__(self):
        given = [f"{kind} {getattr(self, kind):.3g}" for kind in KINDS if getattr(self, kind) > 0]
        return " or ".join(given) or "exact"


#: Allows only for round-off, which depends on the compiler and the number of threads.
DEFAULT = Tolerance(rel=1e-9, scaled=1e-12)


@dataclass
class Tolerances:
    """The general tolerance, and those of the columns that match a pattern.

    A pattern is the beginning of a name or contains `*`; it is compared with `column` and with
    `table/column`, ignoring case. The longest pattern that matches replaces the general tolerance.

    >>> t = Tolerances(Tolerance(rel=1e-6), {"torque": Tolerance(abs=1e-3)})
    >>> str(t.of("force", "top")), str(t.of("force", "torque_3"))
    ('rel 1e-06', 'abs 0.001')
    """

    general: Tolerance = DEFAULT
    named: dict = field(default_factory=dict)
    used: set = field(default_factory=set)

    def of(self, table, column):
        """The tolerance of a column; the patterns that match it are recorded in `used`."""
        found = [p for p in self.named if matches(p, table, column)]
        self.used.update(found)
        return self.named[max(found, key=len)] if found else self.general


def matches(pattern, table, column):
    """Whether a pattern matches this column: exactly, as the beginning of a name, or by wildcards.

    >>> matches("fo*_3", "top", "force_3"), matches("top/", "top", "force"), matches("x", "top", "u")
    (True, True, False)
    """
    pattern = pattern.lower()
    full = (column.lower(), f"{table}/{column}".lower())
    if any(c in pattern for c in "*?["):
        return any(fnmatch.fnmatchcase(name, pattern) for name in full)
    return any(name.startswith(pattern) for name in full)


def parse(words):
    """Tolerances from options of the command line: {'rel': ['1e-6', 'force=1e-4'], 'abs': None,
    ...}.

    >>> parse({"rel": ["1e-6", "force=1e-4"]}).of("t", "force")
    Tolerance(rel=0.0001, abs=0.0, scaled=0.0)
    """
    general, named = {}, {}
    for kind in KINDS:
        for word in words.get(kind) or ():
            pattern, _, value = word.rpartition("=")
            try:
                value = float(value)
            except ValueError:
                raise Unreadable(
                    f"'{word}' is not a tolerance; write --{kind} 1e-6 or --{kind} force=1e-6"
                ) from None
            (named.setdefault(pattern, {}) if pattern else general)[kind] = value
    return Tolerances(
        Tolerance(**general) if general else DEFAULT,
        {pattern: Tolerance(**kinds) for pattern, kinds in named.items()},
    )
