"""Figures of sliding contact: what is taken from the tables."""

import contextlib
import io

import numpy as np

from post._error import Unreadable
from post.figures import section5_contact
from post.tests.samples import Scratch


def write_run(path, amplitude=0.0, plateau=0.0, force=1.3):
    """Ten steps down, then 3 degrees per step; the torque is plateau (1 - exp(-angle/4)) plus a
    sine.
    """
    names = "step time factor_1 factor_2 iterations cutbacks converged " + " ".join(
        f"contact_sole_{side}_{q}" for side in (1, 2) for q in ("force_3", "torque")
    )
    rows = [
        (i + 1, 0.1 * (i + 1), 0.1 * (i + 1), 0.0, 5, 0, 1, 0.1 * i, 9.0, -0.1 * i, 9.0)
        for i in range(9)
    ]
    for i in range(61):
        angle = 3.0 * i
        torque = plateau * (1 - np.exp(-angle / 4)) + amplitude * np.sin(np.radians(6 * angle))
        rows.append((i + 10, 1 + i / 60, 1.0, i / 60, 5, 0, 1, force, -torque, -force, torque))
    path.parent.mkdir(parents=True, exist_ok=True)
    np.savetxt(path, rows, header=names, comments="# ")


class Section5(Scratch):
    def test_measures_are_those_of_the_turn(self):
        write_run(self.folder / "2_IGA2_0.dat", amplitude=0.02)
        write_run(self.folder / "2_Q1E9+Q1N2_0.5" / "run_sole.dat", amplitude=0.01, plateau=0.4)
        smooth, rough = section5_contact.read_runs(self.folder)
        self.assertEqual((smooth.elements, smooth.mu, smooth.dofs), ("IGA2", 0.0, 1620))
        self.assertEqual((rough.elements, rough.mu, rough.dofs), ("Q1E9+Q1N2", 0.5, 1035))
        self.assertEqual(
            (smooth.degrees[0], smooth.degrees[-1], len(smooth.degrees)), (0.0, 180.0, 61)
        )
        self.assertAlmostEqual(smooth.amplitude(), 0.02, 12)
        self.assertAlmostEqual(smooth.mean_force(), 1.3, 12)
        self.assertAlmostEqual(rough.roughness(), 0.01, 9)

    def test_figures_of_all_meshes_are_drawn(self):
        for mesh in (1, 2, 3):
            for elements in section5_contact.DOFS:
                for mu in ("0", "0.5"):
                    name = f"{mesh}_{elements}_{mu}.dat"
                    write_run(self.folder / name, 0.01 / mesh**2, 0.4 * float(mu), 1.3 + 0.1 / mesh)
        write_run(self.folder / "reference_IGA2_0.dat")
        with contextlib.redirect_stdout(io.StringIO()):
            code = section5_contact.main(["--results", str(self.folder), "--to", str(self.folder)])
        self.assertEqual(code, 0)
        self.assertEqual(len(list(self.folder.glob("section5_figure*.png"))), 3)

    def test_the_finest_iga_mesh_serves_as_reference(self):
        write_run(self.folder / "1_IGA2_0.dat", force=1.4)
        write_run(self.folder / "3_IGA2_0.dat", force=1.5)
        runs = section5_contact.Runs(section5_contact.read_runs(self.folder), False)
        force, words = section5_contact.reference_force(runs)
        self.assertAlmostEqual(force, 1.5, 12)
        self.assertEqual(words, "IGA2, mesh 3")

    def test_what_is_missing_is_said(self):
        with self.assertRaisesRegex(Unreadable, "contains no run"):
            section5_contact.read_runs(self.folder)
        write_run(self.folder / "1_Q1E9_0.dat")
        runs = section5_contact.Runs(section5_contact.read_runs(self.folder), False)
        with self.assertRaisesRegex(Unreadable, "no run reference_IGA2_0"):
            section5_contact.reference_force(runs)
        (self.folder / "2_IGA2_0").mkdir()
        with self.assertRaisesRegex(Unreadable, "found 0"):
            section5_contact.read_runs(self.folder)
