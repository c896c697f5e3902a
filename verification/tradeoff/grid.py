"""The runs of `python -m verification.tradeoff`: one option at a time is varied from the settings
of the paper.
"""

import re
from dataclasses import dataclass, field

LIMIT = 1500  # wall-clock seconds that a run may take
#: Table 4 of Corbett and Sauer 2015.
MESHES = {
    1: {"n": 3, "m": 1, "k": 2, "eps": 125},
    2: {"n": 7, "m": 2, "k": 4, "eps": 250},
    3: {"n": 11, "m": 3, "k": 8, "eps": 500},
}
USUAL = {"mu": 0.5, "q": 5, "degrees": 3}
ENRICHED, SPLINE = "Q1E9+Q1N2.1", "IGA2"
ELEMENTS = (
    "Q1", "Q1+Q1N2.1", "Q1E9", "Q1E9+Q1N2", "Q1E9+Q1N3", "Q1E9+Q1N4", "Q1E9+Q1N2.1", "Q1E9+Q1N2.2",
    "Q1E9+Q1N3.1", "Q1E9+Q1E9N2.1", "Q2", "Q2+Q2N2.1", "IGA2", "IGA3",
)  # fmt: skip

#: The beginning of the name of a deck, and the contact option that it uses.
SCHEMES = {"mortar": "MORTar", "balanced": "BALAnced", "refined": "REFIne 3"}
#: Decks that are not run with every element type.
SOME = {
    "balanced": ("Q1E9", "Q1E9+Q1N2", ENRICHED, SPLINE, "Q2"),
    "refined": (ENRICHED, SPLINE),
}

#: Element types that are also run on mesh 2.
BEST = (
    "Q1", "Q1E9", "Q1E9+Q1N2", "Q1E9+Q1N3", "Q1E9+Q1N2.1", "Q1E9+Q1E9N2.1", "Q2+Q2N2.1", "IGA2", "IGA3",
)  # fmt: skip


@dataclass
class Run:
    """One run: a deck, a mesh and settings, and the run with which it is compared."""

    group: str
    name: str
    mesh: int
    elements: str
    deck: str
    settings: dict = field(default_factory=dict)
    beside: "Run | None" = None
    ratio_to: "Run | None" = None

    @property
    def options(self):
        return [word for k, v in self.settings.items() for word in ("--set", f"{k}={v:.10g}")]

    @property
    def command(self):
        return " ".join(["bezel", *self.options, self.deck])

    @property
    def key(self):
        """The name of the run's folder."""
        said = {"mesh": self.mesh, **{k: v for k, v in self.settings.items() if k not in "nmk"}}
        words = [self.deck.removesuffix(".inp"), *(f"{k}{v:g}" for k, v in said.items())]
        return re.sub(r"[^\w.+-]", "_", "_".join(words))


def deck_of(elements):
    return elements.lower().replace("+", "_") + ".inp"


def new_run(group, name, mesh, elements, deck=None, beside=None, ratio_to=None, **more):
    settings = {**MESHES[mesh], **USUAL, **more}
    return Run(group, name, mesh, elements, deck or deck_of(elements), settings, beside, ratio_to)


REFERENCE = new_run("reference", "reference", 3, SPLINE, q=10)


def runs():
    """All runs, in the order in which they are made."""
    for part in (
        elements,
        points,
        penalties,
        schemes,
        solvers,
        tangents,
        places,
        augmented,
        steps,
        fine,
    ):
        yield from part()


def elements():
    """Element types, with the degree and the continuity of the layer."""
    for mesh, types in ((1, ELEMENTS), (2, BEST)):
        for name in types:
            yield new_run("elements", name, mesh, name)


def fine():
    """Runs on mesh 3, which are made only on request because each takes many minutes."""
    for name in ("Q1E9", "Q1E9+Q1N2", ENRICHED, SPLINE):
        yield new_run("elements", name, 3, name)


def points():
    """Contact quadrature, compared with ten points per direction on the same mesh."""
    for mesh, counts in ((1, (2, 3, 4, 5, 7, 10)), (2, (3, 5, 10))):
        for name in (ENRICHED, SPLINE):
            beside = new_run("points", "q 10", mesh, name, q=10)
            for q in counts:
                yield new_run("points", f"q {q}", mesh, name, beside=beside, q=q)


def penalties():
    """Multiples of the paper's penalty, compared with the largest one at which the same mesh
    converges.
    """
    for mesh, types, factors in (
        (1, (ENRICHED, SPLINE), (0.1, 0.3, 1, 3, 10)),
        (2, (ENRICHED,), (0.1, 1, 3)),
    ):
        usual = MESHES[mesh]["eps"]
        for name in types:
            most = 1 if (mesh, name) == (1, ENRICHED) else 3
            beside = new_run("penalty", "", mesh, name, eps=most * usual)
            for x in factors:
                yield new_run("penalty", f"x {x:g}", mesh, name, beside=beside, eps=x * usual)


def schemes():
    """Two half passes, the default scheme, BALAnced (also with larger penalties), and subcells at
    the boundary.
    """
    for mesh, types in ((1, (*BEST, "Q2")), (2, BEST)):
        for name in types:
            plain = new_run("scheme", "half passes", mesh, name)
            yield plain
            for word, scheme in SCHEMES.items():
                if name in SOME.get(word, types) and (mesh, name, word) != (
                    2,
                    "Q1E9+Q1N2",
                    "balanced",
                ):
                    deck = f"{word}_{deck_of(name)}"
                    yield new_run("scheme", scheme, mesh, name, deck, plain, plain)
    usual = MESHES[1]["eps"]
    for word in ("mortar", "balanced"):
        for x in (3, 10, 100):
            name = f"{SCHEMES[word]}, penalty x {x}"
            yield new_run("scheme", name, 1, ENRICHED, f"{word}_{deck_of(ENRICHED)}", eps=x * usual)


def steps():
    """Degrees per step, compared with steps of one degree."""
    for mesh in (1, 2):
        beside = new_run("steps", "1 deg", mesh, ENRICHED, degrees=1)
        for degrees in (1, 3, 6, 9):
            yield new_run("steps", f"{degrees} deg", mesh, ENRICHED, beside=beside, degrees=degrees)


def solvers():
    """FACTor, compared with a factorisation in every iteration."""
    plain = new_run("solver", "full", 2, ENRICHED)
    yield plain
    for word in ("reuse", "single"):
        yield new_run("solver", word, 2, ENRICHED, f"{word}.inp", plain, plain)


def tangents():
    """The symmetric part of the tangent without friction, compared with the full tangent."""
    for name, deck in ((ENRICHED, "symmetric.inp"), (SPLINE, "symmetric_iga2.inp")):
        plain = new_run("tangent", "UTAN", 1, name, mu=0)
        yield plain
        yield new_run("tangent", "TANG", 1, name, deck, plain, plain, mu=0)


def places():
    """Meshes that are finer at the contact, compared with uniform ones."""
    plain = new_run("place", "even, 7 7 2 and 4 4 4", 2, ENRICHED)
    yield plain
    for name, deck in (
        ("as many, drawn to the contact", "graded.inp"),
        ("as fine there, fewer elsewhere", "thinned.inp"),
    ):
        yield new_run("place", name, 2, ENRICHED, deck, plain)


def augmented():
    """AUGMent, compared with the penalty alone and with larger penalties."""
    for mesh, tries in ((1, ((1, 2), (1, 4), (0.1, 4))), (2, ((1, 3),))):
        plain = new_run("augment", "penalty", mesh, ENRICHED)
        yield plain
        usual = MESHES[mesh]["eps"]
        for x in (0.1, 10) if mesh == 1 else (3,):
            yield new_run("augment", f"penalty x {x:g}", mesh, ENRICHED, None, plain, eps=x * usual)
        for x, times in tries:
            yield new_run(
                "augment", f"AUGMent {times} passes, penalty x {x:g}", mesh, ENRICHED, "augment.inp",
                plain, None, eps=x * usual, times=times,
            )  # fmt: skip
