"""Colours, markers, sizes and fonts of all figures.

The colours of numbered series are those of Okabe and Ito, which colour-blind people can distinguish.
An element type has the same colour in all figures. Every series also has its own marker or line
style, so that a figure printed in grey remains readable.
"""

import contextlib

#: The palette of Okabe and Ito 2008 without its yellow, which is too light for lines on white
#: paper.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
MARKERS = ("o", "s", "^", "D", "v", "P", "X")
LINES = ("-", "--", "-.", ":")
#: Widths of a figure in one and in two columns of a journal page [inch].
COLUMN, PAGE = 3.5, 7.2

#: Element types, the same in all figures: colour, and marker of a curve that does not distinguish
#: the number of enriched faces. Open markers stand for enriched surfaces.
ELEMENTS = {
    "Q1": ("#0072B2", "o"), "Q1N2": ("#56B4E9", "s"), "Q1+Q1N2.1": ("#332288", "v"),
    "Q1E9": ("#D55E00", "o"), "Q1E9+Q1N2": ("#E69F00", "s"), "Q1E9+Q1N3": ("#882255", "^"),
    "Q1E9+Q1N4": ("#44AA99", "<"), "Q1E9+Q1N2.1": ("#CC79A7", "v"), "Q1E9+Q1N2.2": ("#661100", "p"),
    "Q1E9+Q1N3.1": ("#AA4499", "h"), "Q1E9+Q1E9N2": ("#5E3C99", "X"),
    "Q1E9+Q1E9N2 tapered": ("#999933", "P"), "Q1E9+Q1E9N2.1": ("#7570B3", "d"),
    "Q2": ("#009E73", "o"), "Q2N2": ("#BBCC33", "s"), "Q2+Q2N2": ("#BBCC33", "s"),
    "Q2+Q2N2.1": ("#8C564B", "v"), "IGA2": ("#000000", "D"), "IGA3": ("#888888", "P"),
}  # fmt: skip

RC = {
    "figure.dpi": 100, "savefig.dpi": 200, "savefig.bbox": "tight", "savefig.pad_inches": 0.04,
    "font.family": "DejaVu Sans", "font.size": 8.5, "axes.titlesize": 9, "axes.labelsize": 9, "legend.fontsize": 7.5,
    "axes.linewidth": 0.7, "axes.spines.top": False, "axes.spines.right": False, "axes.axisbelow": True,
    "axes.grid": True, "grid.color": "#dddddd", "grid.linewidth": 0.5,
    "lines.linewidth": 1.3, "lines.markersize": 4.5, "lines.markeredgewidth": 1.0,
    "legend.frameon": False, "legend.handlelength": 2.6, "xtick.direction": "out", "ytick.direction": "out",
    "figure.constrained_layout.use": True, "svg.hashsalt": "bezel", "pdf.fonttype": 42,
}  # fmt: skip


@contextlib.contextmanager
def styled():
    """matplotlib.pyplot with this style, off-screen; all settings are restored afterwards.

    >>> with styled() as plt:
    ...     plt.rcParams["legend.frameon"]
    False
    """
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    with plt.rc_context(RC):
        try:
            yield plt
        finally:
            plt.close("all")


def series(i):
    """Line properties of the i-th series; colour and marker change first, then the line style.

    >>> series(0)["marker"], series(7)["linestyle"]
    ('o', '--')
    """
    n = len(COLOURS)
    return {
        "color": COLOURS[i % n],
        "marker": MARKERS[i % n],
        "linestyle": LINES[i // n % len(LINES)],
    }


def element(name):
    """Line properties of an element type, given by its name in verification: 'Q1E9+Q1N2 on 1+ and
    2+'. If the name says which faces are enriched, marker and line style stand for their number.

    >>> element("Q1")["marker"], element("Q1N2 on 1+")["marker"], element("Q1N2 on 1+ and 2+")["marker"]
    ('o', 's', '^')
    >>> element("Q1N2")["color"] == element("Q1N2 on 1+")["color"] != element("Q1")["color"]
    True
    """
    kind, _, where = name.partition(" on ")
    colour, marker = ELEMENTS.get(kind, ("#666666", "o"))
    faces = 0 if not where else 2 if " and " in where else 1
    enriched = "N" in kind
    return {
        "color": colour,
        "marker": ("s", "^")[faces - 1] if faces else marker,
        "linestyle": ("-", "--", ":")[faces],
        "markerfacecolor": "white" if enriched else colour,
    }


def is_element(name):
    """Whether `element` knows the type.

    >>> is_element("Q1N2 on 1+"), is_element("mesh 3")
    (True, False)
    """
    return name.partition(" on ")[0] in ELEMENTS


def element_label(name):
    """A shorter name for legends.

    >>> element_label("Q1E9+Q1N2 on 1+ and 2+"), element_label("Q2N2 on 1+"), element_label("Q1")
    ('Q1E9+Q1N2, two faces', 'Q2N2, one face', 'Q1')
    """
    kind, _, faces = name.partition(" on ")
    return kind + (", two faces" if " and " in faces else ", one face" if faces else "")


def save(figure, path):
    """Write a figure, by default as .png; the same data give the same file, because it contains no
    date.
    """
    import pathlib

    from post._error import Unreadable

    path = pathlib.Path(path)
    path = path if path.suffix else path.with_suffix(".png")
    empty = {".png": {"Software": None}, ".pdf": {"CreationDate": None}, ".svg": {"Date": None}}
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path, metadata=empty.get(path.suffix.lower()))
    except OSError as error:
        raise Unreadable(f"'{path}' cannot be written: {error.strerror}") from None
    except ValueError as error:
        raise Unreadable(f"'{path}': {error}") from None
    print(f"wrote {path}")
