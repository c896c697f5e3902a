"""Figures 8 to 12 of Corbett and Sauer 2015, section 4, and one on the enriched element with
enhanced strains.

The errors are drawn from verification/benchmark/section4/results.csv, which
`python -m verification.verify --study --all --case section4` writes, and from field.csv beside it,
which study.py there writes. The cube of Figures 8 and 11 is drawn only if a program is given:

    python -m post.figures.section4 [--results FILE] [--bezel build/release/bezel]
        [--to doc/verification/figures]
"""

import argparse
import pathlib
import shutil
import sys
import tempfile

import numpy as np

from post import _style, field
from post._error import Unreadable
from post._table import read_table
from post.convergence import Series, plot
from post.figures.demo import run

TOP = pathlib.Path(__file__).resolve().parents[2]
RESULTS = TOP / "verification/benchmark/section4/results.csv"
FIGURES = TOP / "doc/verification/figures"
QUARTERS = 4  # the runs model a quarter of the cube; the paper gives the force on the whole cube

ONE, TWO = " on 1+", " on 1+ and 2+"
Q1 = ("Q1", "Q1N2" + ONE, "Q1N2" + TWO, "IGA2")
Q1E9 = ("Q1E9", "Q1E9+Q1N2" + ONE, "Q1E9+Q1N2" + TWO, "IGA2")
Q2 = ("Q2", "Q2N2" + ONE, "Q2N2" + TWO, "IGA2")


class Results:
    """Results of one test, 'compression' or 'extension', by element type."""

    def __init__(self, path, test):
        self.table, self.test = read_table(path), test
        self.path = path

    def column(self, elements, name):
        """(nmesh) values of a column for an element type, from the coarsest to the finest mesh;
        empty if there are no runs.

        name: force (on the whole cube), error (its magnitude), or another column of the table.
        """
        c = self.table.columns
        rows = np.flatnonzero((c["test"] == self.test) & (c["elements"] == elements))
        rows = rows[np.argsort(c["n"][rows])]
        if name == "force":
            return QUARTERS * c["force_quarter"][rows]
        return np.abs(c["error"][rows]) if name == "error" else c[name][rows]

    def series(self, types, name="error"):
        """Errors against degrees of freedom (post.convergence.Series) of those types that were
        run.
        """
        found = [Series(t, self.column(t, "dofs"), self.column(t, name)) for t in types]
        found = [s for s in found if len(s.x)]
        if not found:
            raise Unreadable(f"'{self.path}' has no {self.test} results of {', '.join(types)}")
        return found

    def converged(self):
        """The force relative to which the errors are given."""
        c = self.table.columns
        row = np.flatnonzero(c["test"] == self.test)[0]
        return QUARTERS * c["force_quarter"][row] / (1 + c["error"][row])


def improvement(results, enriched, plain="Q1"):
    """(mesh numbers, error of `plain` / error of `enriched` on the same mesh)"""
    n = np.intersect1d(results.column(plain, "n"), results.column(enriched, "n"))
    pick = lambda t: results.column(t, "error")[np.isin(results.column(t, "n"), n)]
    return np.arange(1, len(n) + 1), pick(plain) / pick(enriched)


def errors(ax, results, types, title, share=None):
    """Plot errors against degrees of freedom; `share`: axes whose limits to share, or None."""
    if share is not None:  # set before plotting, so that the limits include the lines of both
        ax.sharex(share)
        ax.sharey(share)
    plot(ax, results.series(types), guides=())
    ax.set_title(title, loc="left")


def forces(ax, results, types, title):
    """Plot the force against degrees of freedom, and the converged value as a line."""
    for s in results.series(types):
        ax.semilogx(
            s.x,
            results.column(s.name, "force"),
            label=_style.element_label(s.name),
            **_style.element(s.name),
        )
    ax.axhline(results.converged(), color="#999999", linewidth=0.9, zorder=0, label="converged")
    ax.set_xlabel("degrees of freedom")
    ax.set_ylabel("force $F_z / E_0 L_0^2$")
    ax.set_title(title, loc="left")
    ax.legend()


def figure_9(results, plt):
    figure, axes = plt.subplots(2, 2, figsize=(_style.PAGE, 5.6))
    errors(axes[0, 0], results, Q1, "a) linear")
    errors(axes[0, 1], results, Q1E9, "b) linear with enhanced strains", axes[0, 0])
    errors(axes[1, 0], results, Q2, "c) quadratic", axes[0, 0])
    forces(axes[1, 1], results, ("Q1", "Q1E9", "Q2", "IGA2"), "d) force")
    return figure


def figure_10(results, plt):
    figure, ax = plt.subplots(figsize=(4.6, 3.6))
    errors(ax, results, ("Q1", "Q1N2" + ONE, "Q1E9", "Q1E9+Q1N2" + ONE, "Q2"), "")
    return figure


def figure_12(results, plt):
    figure, axes = plt.subplots(2, 2, figsize=(_style.PAGE, 5.6))
    errors(axes[0, 0], results, Q1, "a) linear")
    errors(axes[0, 1], results, Q2, "b) quadratic", axes[0, 0])
    ax = axes[1, 0]
    for elements in Q1[1:3]:
        mesh, factor = improvement(results, elements)
        ax.plot(mesh, factor, label=_style.element_label(elements), **_style.element(elements))
    ax.set_xticks(mesh)
    ax.axhline(1.0, color="#999999", linewidth=0.9, zorder=0)
    ax.set_ylim(bottom=0.0)
    ax.set_xlabel("mesh")
    ax.set_ylabel("error of Q1 / error of Q1N2")
    ax.set_title("c) improvement", loc="left")
    ax.legend()
    forces(axes[1, 1], results, ("Q1", "Q1N2" + TWO, "Q2", "IGA2"), "d) force")
    return figure


def figure_enhanced(compression, extension, fields, plt):
    """Plot the errors with enhanced strains in the enriched layer, which the paper leaves for
    future research.

    fields: (Results, Results) with the errors of fields, or None.
    """
    from matplotlib.ticker import LogLocator, NullFormatter

    layers = ("Q1E9+Q1N2", "Q1E9+Q1E9N2", "Q1E9+Q1E9N2 tapered")
    types = ("Q1E9", *(layer + faces for layer in layers for faces in (ONE, TWO)))
    columns = {"error": "force"}
    if fields:
        columns |= {
            "displacement_face": "normal displacement, face",
            "mises_face": "von Mises stress, face",
        }
    figure, axes = plt.subplots(
        2, len(columns), figsize=(_style.PAGE, 5.0), squeeze=False, sharex="col"
    )
    for row, results in enumerate((compression, extension)):
        for ax, column in zip(axes[row], columns):
            shown = results if column == "error" else fields[row]
            for s in shown.series(types, column):
                ax.loglog(
                    s.x, s.error, label=_style.element_label(s.name), **_style.element(s.name)
                )
            ax.yaxis.set_major_locator(LogLocator(subs=(1, 3) if column == "error" else (1, 2, 5)))
            ax.xaxis.set_major_locator(LogLocator(subs=(1,) if column == "error" else (1, 2, 5)))
            for axis in (ax.xaxis, ax.yaxis):
                axis.set_major_formatter(lambda x, _: f"{x:.10f}".rstrip("0").rstrip("."))
                axis.set_minor_formatter(NullFormatter())
        axes[row, 0].set_ylabel(f"{results.test}: relative error")
    for ax, title in zip(axes[0], columns.values()):
        ax.set_title(title, loc="left")
    for ax in axes[1]:
        ax.set_xlabel("degrees of freedom")
    handles, labels = axes[0, -1].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3 if fields else 2)
    return figure


#: Panels of Figures 8 and 11: elements along half an edge, lift of the top, and caption.
CUBES = (
    (1, -0.25, "mesh 1, undeformed"),
    (4, -0.25, "mesh 3, undeformed"),
    (4, -0.25, "mesh 3, compressed"),
    (4, 1.0, "mesh 3, stretched"),
)


def cube(bezel, to):
    """Run the quarter of the cube with Q1N2 on one face, and draw its meshes."""
    with tempfile.TemporaryDirectory() as place:
        folder, files = pathlib.Path(place), {}
        shutil.copy(RESULTS.with_name("cube.inc"), folder)
        deck = (
            RESULTS.with_name("q1n2_1.inp")
            .read_text()
            .replace("  NEXT,time\n", "  NEXT,time\n  PLOT\n")
        )
        for n, lift, _ in CUBES:
            file = folder / f"cube_{n}_{lift:g}.inp"
            file.write_text(
                deck.replace("n = 2 ", f"n = {n} ").replace("u = -0.25", f"u = {lift:g}")
            )
            run(bezel, folder, file)
            files[n, lift] = str(file.with_suffix(".vtkhdf"))
        field.draw([files[n, lift] for n, lift, _ in CUBES], to / "section4_figure8.png", scalar="body",
                   warp=[0.0, 0.0, 1.0, 1.0], outline=False, labels=[c for _, _, c in CUBES],
                   say_step=False, view="35,18")  # fmt: skip


def draw(results=RESULTS, to=FIGURES):
    """Draw all four figures from a table of results into a folder."""
    compression, extension = Results(results, "compression"), Results(results, "extension")
    more = pathlib.Path(results).with_name("field.csv")
    fields = [Results(more, r.test) for r in (compression, extension)] if more.exists() else None
    with _style.styled() as plt:
        for name, figure in (
            ("section4_figure9", figure_9(compression, plt)),
            ("section4_figure10", figure_10(compression, plt)),
            ("section4_figure12", figure_12(extension, plt)),
            ("section4_enhanced", figure_enhanced(compression, extension, fields, plt)),
        ):
            _style.save(figure, pathlib.Path(to) / f"{name}.png")


def main(argv=None):
    p = argparse.ArgumentParser(prog="section4", description="Draw Figures 8 to 12 of the paper.")
    p.add_argument(
        "--results",
        default=RESULTS,
        metavar="FILE",
        help="(default verification/benchmark/section4/results.csv)",
    )
    p.add_argument(
        "--to", default=FIGURES, metavar="DIR", help="(default doc/verification/figures)"
    )
    p.add_argument("--bezel", type=pathlib.Path, metavar="FILE", help="program that runs the cube")
    o = p.parse_args(argv)
    try:
        draw(o.results, o.to)
        if o.bezel:
            cube(o.bezel.resolve(), pathlib.Path(o.to))
    except Unreadable as error:
        print(f"section4: error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
