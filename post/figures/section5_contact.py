"""Figures 17 to 21 of Corbett and Sauer 2015, sections 5.2 and 5.3: sliding contact.

Figures 18 to 20 are drawn from tables of curves, one for each mesh, element type and coefficient of friction:

    <folder>/<mesh>_<elements>_<mu>.dat          for example 2_Q1E9+Q1N2_0.dat or 2_IGA2_0.5.dat
    <folder>/<mesh>_<elements>_<mu>/*_sole.dat   a folder written by the program

with the columns of `CURVe,sole`: factor_2 (fraction of the half turn), FORCe 3 and TORQue of both
sides. The reference for the force, IGA2 on a fine mesh, is read from `reference_IGA2_0.dat`;
without this file the finest IGA2 mesh is used instead, and the figure says so.

Figures 17 and 21 are drawn only if there are result files, which `python -m
verification.section5_contact --mesh 1 2 3` leaves in a folder for each run.

    python -m post.figures.section5_contact [--results FOLDER] [--fields build/section5_contact]
        [--to doc/verification/figures]
"""

import argparse
import pathlib
import re
import sys

import numpy as np

from post import _grid, _style, contact_map, field
from post._contact_faces import surfaces
from post._error import Unreadable
from post._table import read_table

TOP = pathlib.Path(__file__).resolve().parents[2]
RESULTS = TOP / "verification/benchmark/section5_contact/runs"
FIELDS = TOP / "build/section5_contact"
FIGURES = TOP / "doc/verification/figures"
NAME = re.compile(r"(?P<mesh>\w+)_(?P<elements>[^_]+)_(?P<mu>[0-9.]+)$")

#: Table 4 of the paper: degrees of freedom of meshes 1 to 3, in the order of its legends.
DOFS = {
    "Q1E9": (177, 951, 3915),
    "Q1E9+Q1N2": (225, 1035, 4047),
    "Q1E9+Q1N3": (285, 1131, 4191),
    "Q1E9+Q1N2.1": (402, 1752, 5940),
    "IGA2": (417, 1620, 5535),
}
SLIDING = 120.0  # angle [degrees] beyond which all points slide, according to the paper


class Run:
    """One curve table: the angle in degrees, and force and torque of both sides."""

    def __init__(self, path, mesh, elements, mu):
        table = read_table(path)
        turn = table.columns[table.find("factor_2")]
        turning = turn >= 0.0
        if "factor_1" in table.columns:  # the rotation begins when the downward motion has ended
            down = table.columns["factor_1"]
            turning = down >= down.max() * (1 - 1e-9)
        self.mesh, self.elements, self.mu = mesh, elements, mu
        self.degrees = 180.0 * turn[turning]
        self.force, self.torque = (
            [table.columns[_column(table, side, end)][turning] for side in (1, 2)]
            for end in ("force_3", "torque")
        )

    @property
    def dofs(self):
        return DOFS[self.elements][int(self.mesh) - 1]

    def amplitude(self):
        """Largest magnitude of the torque on either side, which should be zero without friction."""
        return max(np.abs(t).max() for t in self.torque)

    def forces(self):
        """The mean of the force over the rotation, for each side."""
        return [_mean(self.degrees, np.abs(f)) for f in self.force]

    def mean_force(self):
        """The mean of the force over the rotation and over both sides."""
        return np.mean(self.forces())

    def roughness(self):
        """Largest deviation of the torque from its mean while all points slide."""
        late = self.degrees >= SLIDING
        deviations = []
        for torque in self.torque:
            mean = _mean(self.degrees[late], torque[late])
            deviations.append(np.abs(torque[late] - mean).max())
        return max(deviations)


def _column(table, side, end):
    pattern = re.compile(rf"contact_.*_{side}_{end}$")
    found = [name for name in table.columns if pattern.match(name)]
    if len(found) != 1:
        raise Unreadable(
            f"{table.path}: expected one column contact_..._{side}_{end}, found {len(found)}"
        )
    return found[0]


def _mean(x, y):
    """Mean of y over x by the trapezoidal rule, since the steps in x differ where they were cut
    back.

    >>> float(_mean(np.array([0.0, 1.0, 3.0]), np.array([0.0, 1.0, 3.0])))
    1.5
    """
    return np.trapezoid(y, x) / (x[-1] - x[0]) if len(x) > 1 else y[0]


def read_runs(folder):
    """All runs of a folder (list of Run)."""
    folder, runs = pathlib.Path(folder), []
    if not folder.is_dir():
        raise Unreadable(f"'{folder}' is not a folder")
    for path in sorted(folder.iterdir()):
        stem = path.name if path.is_dir() else path.stem
        match = NAME.fullmatch(stem)
        if not match or (path.is_file() and path.suffix != ".dat"):
            continue
        if path.is_dir():
            tables = sorted(path.glob("*_sole.dat"))
            if len(tables) != 1:
                raise Unreadable(f"'{path}': expected one table *_sole.dat, found {len(tables)}")
            path = tables[0]
        runs.append(Run(path, match["mesh"], match["elements"], float(match["mu"])))
    if not runs:
        raise Unreadable(f"'{folder}' contains no run <mesh>_<elements>_<mu>")
    return runs


class Runs:
    """Runs with or without friction, in the order of the paper's legends."""

    def __init__(self, runs, friction):
        self.all = [r for r in runs if (r.mu > 0) == friction and r.elements in DOFS]
        self.reference = next((r for r in runs if r.mesh == "reference" and r.mu == 0), None)

    def on(self, mesh, smooth=False):
        """Runs on a mesh; smooth: leave out the element types with a faceted surface."""
        types = [e for e in DOFS if not (smooth and e == "Q1E9")]
        return [r for e in types for r in self.all if r.elements == e and r.mesh == str(mesh)]

    def by_elements(self):
        """(elements, runs from the coarsest to the finest mesh) on the meshes of Table 4."""
        for elements in DOFS:
            runs = [r for m in (1, 2, 3) for r in self.on(m) if r.elements == elements]
            if runs:
                yield elements, runs


def _line(elements):
    """The line properties of an element type, the same in all figures."""
    style = _style.element(elements)
    return style | {"markerfacecolor": style["color"]}  # open markers stand for the block


def torques(ax, runs):
    """Plot the torque about the axis against the angle, solid for the hemisphere and dashed for the
    block; both are positive in the sense in which the block is turned.
    """
    for run in runs:
        style = _line(run.elements) | {"marker": ""}
        ax.plot(run.degrees, -run.torque[0], label=run.elements, **style)
        ax.plot(run.degrees, run.torque[1], **style | {"linestyle": "--", "linewidth": 0.9})
    ax.set_xticks(range(0, 181, 60 if len(runs) == 1 else 30))


def legend(figure, ax, more=()):
    """Draw one legend for all panels, below them; `more`: further entries as (line, label)."""
    from matplotlib.lines import Line2D

    handles, words = ax.get_legend_handles_labels()
    handles += [Line2D([], [], color="#555555", linestyle=line) for line, _ in more]
    words += [text for _, text in more]
    figure.legend(handles, words, loc="outside lower center", ncol=len(words), columnspacing=1.2)


SIDES = (("-", "hemisphere"), ("--", "block"))


def convergence(ax, runs, value, words):
    """Plot a measure of each run against its degrees of freedom."""
    for elements, found in runs.by_elements():
        ax.loglog(
            [r.dofs for r in found], [value(r) for r in found], label=elements, **_line(elements)
        )
    _degrees_of_freedom(ax)
    ax.set_ylabel(words)


def _degrees_of_freedom(ax):
    """Label only a few ticks, because the axis spans less than two decades."""
    from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

    ax.set_xlabel("degrees of freedom")
    ax.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    ax.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    ax.xaxis.set_minor_formatter(NullFormatter())


def figure_18(runs, plt):
    """Draw one panel for each of the four smooth surfaces, because in one panel their curves would
    overlap.
    """
    figure = plt.figure(figsize=(_style.PAGE, 3.7))
    grid = figure.add_gridspec(2, 3, width_ratios=(1, 1, 1.75))
    first = None
    for k, run in enumerate(runs.on(2, smooth=True)):
        ax = first = figure.add_subplot(grid[k // 2, k % 2], sharex=first, sharey=first)
        torques(ax, [run])
        ax.set_title(("a) " if k == 0 else "") + run.elements, loc="left")
        ax.label_outer()
        if k % 2 == 0:
            ax.set_ylabel("$M_z / E_0 L_0^3$ on mesh 2")
        if k // 2 == 1:
            ax.set_xlabel("rotation [degrees]")
    ax = figure.add_subplot(grid[:, 2])
    convergence(ax, runs, Run.amplitude, "largest torque $M_z / E_0 L_0^3$")
    ax.set_title("b) largest torque on either side", loc="left")
    legend(figure, ax, SIDES)
    return figure


def reference_force(runs):
    """(mean force, name of the run that gives it)"""
    if runs.reference:
        return runs.reference.mean_force(), "IGA2, fine mesh"
    iga = dict(runs.by_elements()).get("IGA2")
    if not iga:
        raise Unreadable("there is no run reference_IGA2_0, and none of IGA2 without friction")
    return iga[-1].mean_force(), f"IGA2, mesh {iga[-1].mesh}"


def figure_19(runs, plt):
    reference, words = reference_force(runs)
    figure, axes = plt.subplots(1, 2, figsize=(_style.PAGE, 3.2))
    for elements, found in runs.by_elements():
        dofs, style = [r.dofs for r in found], _line(elements)
        forces = np.array([r.forces() for r in found])
        axes[0].semilogx(dofs, forces[:, 0], label=elements, **style)
        block = {"linestyle": "--", "markerfacecolor": "white"}
        axes[0].semilogx(dofs, forces[:, 1], **style | block)
    axes[0].axhline(reference, color="#999999", linewidth=0.9, zorder=0)
    axes[0].annotate(
        words, (0, reference), xycoords=("axes fraction", "data"), va="bottom", color="#555555",
        fontsize=7.5, xytext=(3, 1), textcoords="offset points",
    )  # fmt: skip
    _degrees_of_freedom(axes[0])
    axes[0].set_ylabel("mean contact force $P_z / E_0 L_0^2$")
    axes[0].set_title("a) force on each side", loc="left")

    def error(run):
        value = abs(run.mean_force() / reference - 1)
        return value if value > 0 else np.nan  # the run is the reference itself

    convergence(axes[1], runs, error, "relative error")
    axes[1].set_title("b) error of the mean of both sides", loc="left")
    _annotate_dip(axes[1], dict(runs.by_elements()).get("Q1E9", []), error)
    legend(figure, axes[0], SIDES)
    return figure


def _annotate_dip(ax, facets, error):
    """Say why the error of the mean is small where the errors of the two sides cancel."""
    for run in facets:
        first, second = run.forces()
        if error(run) < 0.1 * (first - second) / (first + second):
            ax.annotate(
                "the errors of the\ntwo sides cancel:\nsee a)", (run.dofs, error(run)),
                xytext=(-22, 8), textcoords="offset points", fontsize=7.5, va="bottom", ha="right",
                arrowprops={"arrowstyle": "-", "color": "#555555", "linewidth": 0.7},
            )  # fmt: skip


def figure_20(runs, plt):
    figure, axes = plt.subplots(1, 2, figsize=(_style.PAGE, 3.2))
    torques(axes[0], runs.on(2))
    axes[0].set_title("a) mesh 2", loc="left")
    axes[0].set_xlabel("rotation [degrees]")
    axes[0].set_ylabel("torque $M_z / E_0 L_0^3$")
    convergence(axes[1], runs, Run.roughness, "largest deviation from the mean")
    axes[1].set_title("b) torque from 120 to 180 degrees", loc="left")
    legend(figure, axes[1], SIDES)
    return figure


#: Figure 21: mesh and elements of each panel, in the order of the paper.
TRACTIONS = (
    ("2", "Q1E9"), ("2", "IGA2"), ("2", "Q1E9+Q1N2"), ("2", "Q1E9+Q1N3"), ("2", "Q1E9+Q1N2.1"), ("3", "Q1E9+Q1N2.1"),
)  # fmt: skip
MESHED = "Q1E9+Q1N2.1"  # the elements of the meshes in Figure 17


def bodies(fields, to):
    """Draw Figures 17 and 21: the meshes, and the tractions after 180 degrees."""
    found = {}
    for mesh, elements in {*TRACTIONS, *((m, MESHED) for m in "123")}:
        found[mesh, elements] = next(fields.glob(f"{mesh}_{elements}_0.5/*.vtkhdf"), None)
    missing = [f"{m}_{e}_0.5" for (m, e), file in sorted(found.items()) if file is None]
    if missing:
        print(
            f"no result files of {', '.join(missing)} in {fields}: Figures 17 and 21 are not drawn"
        )
        return []
    field.draw([str(found[m, MESHED]) for m in "123"], str(to / "section5_figure17.png"), scalar="body", warp=0.0,
               labels=[f"mesh {m}" for m in "123"], say_step=False, outline=False, view="-65,12")  # fmt: skip
    labels = [f"{'abcdef'[i]}) {e}, mesh {m}" for i, (m, e) in enumerate(TRACTIONS)]
    contact_map.draw([str(found[case]) for case in TRACTIONS], str(to / "section5_figure21.png"),
                     labels=labels, say_step=False, words="$t_x / E_0$ after 180 degrees")  # fmt: skip
    distances(found)
    return ["section5_figure17", "section5_figure21"]


def distances(found):
    """Print how far the deformed face of the block is from those of other runs: the root mean square
    over the points that all meshes have in common, in units of L0.
    """
    faces = {case: face(found[case], 2) for case in TRACTIONS}
    for case, mine in faces.items():
        row = []
        for theirs in faces.values():
            both = sorted(set(mine) & set(theirs))
            off = np.array([mine[i] - theirs[i] for i in both])
            row.append(f"{np.sqrt((off**2).sum(axis=1).mean()):.3f}")
        print(f"face of the block, {case[1]}, mesh {case[0]}: {' '.join(row)} from a) to f)")


def face(path, body):
    """Displacements of a contact surface at the corners and in the middle of the faces and their
    edges: {undeformed position in eighths of L0: displacement (3)}.
    """
    grid = _grid.load(str(path), "last")[0]
    nothing = np.zeros(grid.n_points)
    shape = []
    for displacement in (0.0, np.asarray(grid.point_data["displacement"])):
        grid.points = np.asarray(grid.points, dtype=float) + displacement
        (side,) = (s for s in surfaces(grid, path, nothing, 3) if s.body == body)
        shape.append(side.x.reshape(-1, 3))
    keys = np.rint(8 * shape[0]).astype(int)
    return {tuple(key): u for key, u in zip(keys.tolist(), shape[1] - shape[0])}


def draw(results=RESULTS, to=FIGURES):
    """Draw those figures for which there are runs; return their names."""
    runs, names = read_runs(results), []
    plain, rough = Runs(runs, False), Runs(runs, True)
    with _style.styled() as plt:
        for name, make, chosen in (
            ("section5_figure18", figure_18, plain),
            ("section5_figure19", figure_19, plain),
            ("section5_figure20", figure_20, rough),
        ):
            if chosen.all:
                _style.save(make(chosen, plt), pathlib.Path(to) / f"{name}.png")
                names.append(name)
    return names


def main(argv=None):
    p = argparse.ArgumentParser(
        prog="section5_contact", description="Draw Figures 17 to 21 of the paper."
    )
    p.add_argument("--results", default=RESULTS, metavar="FOLDER")
    p.add_argument("--fields", type=pathlib.Path, default=FIELDS, metavar="FOLDER")
    p.add_argument("--to", default=FIGURES, metavar="DIR")
    o = p.parse_args(argv)
    try:
        draw(o.results, o.to)
        bodies(o.fields, pathlib.Path(o.to))
    except Unreadable as error:
        print(f"section5_contact: error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
