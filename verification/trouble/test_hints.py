"""Hints, notes and reasons for failures on the screen must fit the deck that they are about."""

import json
import pathlib
import shutil

from verification.trouble.test_files import Folder

HERE = pathlib.Path(__file__).resolve().parent
SILENT = HERE / "silent"
FINE = 14.06  # the force with 12 x 12 x 12 elements Q1E9; 8 x 8 x 8 elements Q2 give 14.54
SQUEEZED = (
    (SILENT / "locking.inp").read_text().replace("0.4999", "0.499").replace("0 0 0.02", "0 0 -0.1")
)

TOOL = """FEAP ** A rigid spline above a block
  ndm = 3

MATErial 1
  SOLId
    ELAStic NEOHook 1.0 0.3

PATCh,block
  BOX -1 -1 -1  2 2 1
  ELEMents 4 4 2
  TYPE Q1
  MATErial 1

SPLIne,tool FILE spli_tool.iga
  TYPE RIGId

FIX,block,3- 1 1 1

CONTact,c
  SURFaces tool ALL  block 3+

END

STOP
"""


class Locking(Folder):
    def force(self, name, record):
        """The largest force on a squeezed block whose elements are those of this record."""
        deck = SQUEEZED.replace("TYPE Q1\n", record)
        (self.at / f"{name}.inp").write_text(deck)
        done = self.run_bezel(f"{name}.inp")
        self.assertEqual(done.returncode, 0, done.stderr)
        report = json.loads((self.at / f"{name}.report.json").read_text())
        return report["final"]["force"]["force_3"], done.stderr

    def test_what_the_hint_recommends_does_not_lock(self):
        """The hint must recommend neither layers on Q1 nor quadratic splines, which give 7.5 and
        1.6 times the force of a fine mesh.
        """
        _, said = self.force("q1", "TYPE Q1\n")
        self.assertIn(
            "use hexahedra of TYPE Q1E9 (with ENRIch: EAS; with ELEMents and BLOCk: ENHAnced) or Q2",
            said,
        )
        self.assertNotIn("IGA", said)
        for name, record in {
            "q1e9": "TYPE Q1E9\n",
            "layer": "TYPE Q1E9\n  ENRIch 3+ 2 EAS\n",
            "q2": "TYPE Q2\n",
        }.items():
            with self.subTest(name):
                force, said = self.force(name, record)
                self.assertNotIn("lock", said)
                self.assertLess(force, 1.25 * FINE)


class Changed(Folder):
    def run_deck(self, name, *changes):
        """Run a deck of the folder `silent` with changes; return the texts of the screen and of
        the log.
        """
        deck = (SILENT / f"{name}.inp").read_text()
        for old, new in changes:
            self.assertIn(old, deck)
            deck = deck.replace(old, new)
        (self.at / f"{name}.inp").write_text(deck)
        done = self.run_bezel(f"{name}.inp")
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stderr, (self.at / f"{name}.log").read_text()


class Contact(Changed):
    def test_a_contact_that_never_closes_is_noted_with_its_smallest_gap(self):
        """The punch stops 0.02 above the block, moves away from it, or faces away from it."""
        said, log = self.run_deck("narrow", ("0 0 -0.06", "0 0 -0.03"))
        note = "note: contact 'c' has not closed in any step: the smallest gap was 0.02 at "
        self.assertIn(note, said)
        self.assertIn(", in step 1\n", said)
        self.assertIn(note, log)
        self.assertNotIn("warning:", said)
        said, _ = self.run_deck("narrow", ("0 0 -0.06", "0 0 0.03"))
        self.assertIn("the smallest gap was 0.05 at", said)
        self.assertIn(", at the start\n", said)
        said, _ = self.run_deck("back_to_back")
        self.assertIn(
            "'c' has not closed in any step: no point of either side was ever opposite", said
        )

    def test_bodies_of_which_all_faces_are_named_do_not_face_away(self):
        """Faces beside the gap face sideways; their closest points lie on edges."""
        said, _ = self.run_deck("side_by_side")
        self.assertNotIn("faces away", said)

    def test_a_face_far_above_another_one_is_opposite_it(self):
        said, log = self.run_deck(
            "narrow", ("0.26 0.26 1.05", "0.26 0.26 5"), ("0 0 -0.06", "0 0 -4.01")
        )
        self.assertNotIn("warning:", said)
        self.assertIn("contact c: smallest gap at the start 4 at", log)

    def test_a_contact_that_closes_is_not_noted(self):
        for name in ("narrow", "closed_gap", "slide"):
            with self.subTest(name):
                self.assertNotIn("note:", self.run_deck(name)[0])

    def test_the_log_says_in_words_what_touches_without_points(self):
        """With the default scheme, cells between the integration points may touch while no point
        is closed.
        """
        _, log = self.run_deck("narrow", ("0 0 -0.06", "0 0 -0.03"))
        self.assertIn("  nothing is in contact\n", log)
        _, log = self.run_deck("narrow")
        self.assertIn("  in contact between the integration points, area 1.00E-02", log)
        self.assertNotIn("in contact 0 + 0", log)

    def test_schemes_without_cells_do_not_see_a_narrow_punch(self):
        """With these schemes a fine mesh is needed for an integration point to face the punch;
        cells do not need such a point.
        """
        surfaces = "  SURFaces punch 3-  low 3+\n"
        alarm = "punch 3- lies between the integration points of low 3+ at the start"
        for scheme in ("HALFpass", "BALAnced"):
            with self.subTest(scheme):
                change = (surfaces, f"{surfaces}  SCHEme {scheme}\n")
                self.assertIn(alarm, self.run_deck("narrow", change)[0])
                said, _ = self.run_deck("narrow", change, ("n = 2", "n = 6"))
                self.assertNotIn(alarm, said)

    def test_a_rigid_spline_that_faces_away_is_told_of_its_reverse(self):
        """The hint must name REVErse, because a spline has no opposite face to choose instead."""
        shutil.copy(HERE / "../../input/manual/spli_tool.iga", self.at)
        away = "tool ALL faces away from block 3+"
        (self.at / "tool.inp").write_text(TOOL)
        said = self.run_bezel("--check", "tool.inp").stderr
        self.assertIn(away, said)
        self.assertIn("hint: REVErse in SPLIne,tool reverses its normal", said)
        (self.at / "tool.inp").write_text(TOOL.replace("RIGId\n", "RIGId\n  REVErse\n"))
        self.assertNotIn("warning:", self.run_bezel("--check", "tool.inp").stderr)


class Rigid(Changed):
    def test_forces_at_nodes_of_a_rigid_patch_are_reported_as_meaningless(self):
        """Node 0 at a point of both bodies is that of the block, whose record needs no warning."""
        said, _ = self.run_deck("history_of_rigid")
        self.assertEqual(said.count("warning:"), 1, said)
        self.assertIn("REAC 1 3\n", said)
        self.assertIn("hint: FORCe of a CURVe with a face of the rigid patch gives its whole", said)
        note = "Values at single nodes of rigid patches have no meaning"
        self.assertIn(note, (self.at / "history_of_rigid.out").read_text())

    def test_nodes_of_a_rigid_patch_are_counted_if_there_are_several(self):
        change = ("POINt 0 0 1.2 3", "PLANe 3 1.2 3")
        said, _ = self.run_deck("part_of_rigid", change)
        self.assertIn("4 of the 4 nodes belong to rigid patches; forces at single nodes", said)


class Sliding(Folder):
    def slide(self, *changes):
        """What the screen shows for a block that is pushed sideways."""
        deck = (HERE / "slides.inp").read_text()
        for old, new in changes:
            self.assertIn(old, deck)
            deck = deck.replace(old, new)
        (self.at / "slides.inp").write_text(deck)
        done = self.run_bezel("slides.inp")
        self.assertEqual(done.returncode, 2, done.stderr)
        return done.stderr

    def test_a_body_beyond_its_friction_is_named_with_its_motion(self):
        """The block is pushed with half of the load from above, and friction bears a twentieth
        of that load.
        """
        said = self.slide()
        self.assertIn("body 'up' slides along x, where only friction holds it", said)
        self.assertIn("are 0.5 times its normal loads, but friction can resist at most 0.05", said)
        self.assertIn("hint: support the body against this motion", said)
        self.assertIn("slides along y", self.slide(("PRESsure,up,1-", "PRESsure,up,2-")))

    def test_loads_just_beyond_the_friction_are_named_with_their_time(self):
        """The push grows up to 0.31 of the load from above, which is constant, and friction bears
        0.3 of it; the last step fails at less than 0.3.
        """
        changes = (
            ("mu = 0.05", "mu = 0.3"),
            ("q = 0.5", "q = 0.31"),
            ("q*p PROP 1", "q*p PROP 2"),
            ("PROP,,1\n", "PROP,,1,2\n"),
            ("END\n\n\nSTOP", "END\n2 2\n0 0 0.5 1\n\n2 2\n0.5 0 1 1\n\n\nSTOP"),
        )
        for more in ((), (("q*p PROP 2", "q*p PROP 2 FOLLower"),)):
            said = self.slide(*changes, *more)
            self.assertIn("; at time 1, body 'up' slides along", said)
            self.assertIn("times its normal loads, but friction can resist at most 0.3", said)

    def test_supports_across_the_motion_do_not_hide_it(self):
        self.assertIn("slides along x", self.slide(("FIX,low", "FIX,up,2- 0 1 0\nFIX,low")))

    def test_a_body_that_is_not_held_by_friction_alone_is_not_named(self):
        """A support in the direction of the push holds the block; the run fails because it is
        allowed too few iterations.
        """
        said = self.slide(("FIX,low", "FIX,up,1+ 1 0 0\nFIX,low"), ("newton,25", "newton,1"))
        self.assertNotIn("slides along", said)


class Remedies(Changed):
    """A hint must not recommend what the deck has already, or less than it has."""

    def test_the_recommended_penalty_is_stiffer_than_that_of_the_deck(self):
        for penalty, recommended in {"AUTO 0.02": "AUTO'", "400": "AUTO 2.7'"}.items():
            said, _ = self.run_deck(
                "soft_penalty",
                ("NORMal PENAlty eps", f"NORMal PENAlty {penalty}"),
                ("0 0 -0.1", "0 0 -0.4"),
            )
            self.assertIn("warning: contact 'sole': surfaces penetrate by", said)
            self.assertIn(f"such as 'NORMal PENAlty {recommended}", said)
        said, _ = self.run_deck("soft_friction")
        self.assertIn("hint: use a stiffer penalty in FRICtion\n", said)

    def test_the_recommended_points_are_more_than_those_of_the_deck(self):
        said, _ = self.run_deck("bond_edge")
        self.assertIn("'QUADrature 10 10'", said)
        said, _ = self.run_deck("bond_edge", ("COHEsive", "QUADrature 11 11\n  COHEsive"))
        self.assertIn("'QUADrature 22 22'", said)
        narrow = ("BOX 0 0 1  1 1 0.5", "BOX 0 0 1  0.05 0.05 0.5")
        said, _ = self.run_deck("bond_edge", narrow, ("COHEsive", "QUADrature 30 4\n  COHEsive"))
        self.assertIn("'QUADrature 50 50'", said)
        said, _ = self.run_deck("bond_edge", narrow, ("COHEsive", "QUADrature 50 50\n  COHEsive"))
        self.assertIn("hint: use elements whose borders follow the edge of the bonded area", said)

    def test_motions_of_single_nodes_are_to_be_distributed(self):
        """Smaller elements or steps would not help this deck, which presses a corner inwards."""
        said, _ = self.run_deck("inside_out")
        self.assertIn("hint: distribute a load or a prescribed motion that acts at single", said)

    def test_friction_that_acts_later_is_not_to_be_added(self):
        said, _ = self.run_deck("falling_block")
        self.assertIn("or add friction\n", said)
        said, _ = self.run_deck(
            "falling_block", ("middle 3-\n", "middle 3-\n  FRICtion COULomb 0.3 AFTEr 9\n")
        )
        self.assertIn("or let friction act earlier (AFTEr)\n", said)

    def test_hourglassing_is_a_cause_only_with_enhanced_elements(self):
        """A straight column under twice the load at which it buckles."""
        column = (
            ("BOX 0 0 0  1 1 1", "BOX 0 0 0  1 1 8"),
            ("ELEMents 3 3 3", "ELEMents 1 1 8"),
            ("0 0 0.02", "* * -0.25"),
        )
        self.assertIn("hourglassing", self.run_deck("clean", *column, ("Q1\n", "Q1E9\n"))[0])
        said, _ = self.run_deck("clean", *column, ("Q1\n", "Q2\n"))
        self.assertIn("hint: possible causes: buckling, a limit point;", said)

    def test_a_failed_step_recommends_only_what_the_deck_lacks(self):
        deck = (HERE / "slides.inp").read_text().replace("FIX,low", "FIX,up,1+ 1 0 0\nFIX,low")
        deck = deck.replace("newton,25", "newton,1")
        line = deck.replace("UTAN,,1", "UTAN,LINE,1")
        smooth = line.replace("PENAlty AUTO", "PENAlty AUTO SMOOth 0.01")
        for text, remedy in (
            (deck, "use UTAN,LINE,1, or use NORMal ... SMOOth d"),
            (line, "use NORMal ... SMOOth d"),
            (smooth, "use a softer penalty"),
        ):
            (self.at / "slides.inp").write_text(text)
            done = self.run_bezel("slides.inp")
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(f"no step is small enough: {remedy}\n", done.stderr)


class Moved(Folder):
    def displacement(self, *changes):
        """The displacement of a face that MOVE and EDISplacement prescribe, and the screen's
        text.
        """
        deck = (SILENT / "moved_twice.inp").read_text()
        for old, new in (("END\n\nBATCh", "CURVe,u\n  DISP bar 1+ 1\n\nEND\n\nBATCh"), *changes):
            self.assertIn(old, deck)
            deck = deck.replace(old, new)
        (self.at / "moved.inp").write_text(deck)
        done = self.run_bezel("moved.inp")
        self.assertEqual(done.returncode, 0, done.stderr)
        report = json.loads((self.at / "moved.report.json").read_text())
        return report["final"]["u"]["disp_1"], done.stderr

    def test_the_hint_does_not_double_the_motion(self):
        """Each of the two ways that the hint gives must lead to the motion that the deck
        prescribes twice.
        """
        move = "MOVE,bar,1+ TRANslate 0.01 0 0\n"
        _, said = self.displacement()
        self.assertIn("hint: remove this record, because MOVE prescribes the whole motion", said)
        self.assertIn("or replace the MOVE by FIX", said)
        for change in (
            ("EDISplacement\n  1 4.0  0.01 0 0\n", ""),
            (move, "FIX,bar,1+ 1 1 1\n"),
        ):
            with self.subTest(change[1]):
                found, said = self.displacement(change)
                self.assertAlmostEqual(found, 0.01, 12)
                self.assertNotIn("warning:", said)

    def test_motions_that_are_added_are_warned_of(self):
        move = "MOVE,bar,1+ TRANslate 0.01 0 0\n"
        found, said = self.displacement((move, f"FIX,bar,1+ 1 1 1\n{move}"))
        self.assertAlmostEqual(found, 0.02, 12)
        self.assertIn("at a dof that MOVE prescribes too, and the two are added", said)

    def test_a_restraint_of_what_move_moves_is_noted(self):
        """FIX of the same face as MOVE is usual; of another face, the common edge is a conflict."""
        remove = ("EDISplacement\n  1 4.0  0.01 0 0\n", "")
        move = "MOVE,bar,1+ TRANslate 0.01 0 0\n"
        found, said = self.displacement(remove, (move, f"FIX,bar,1+ 1 0 0\n{move}"))
        self.assertAlmostEqual(found, 0.01, 12)
        self.assertIn(
            "note: MOVE in line 16 prescribes displacements in direction 1 at all nodes that FIX in line 15",
            said,
        )
        self.assertNotIn("warning:", said)
        _, said = self.displacement(remove, (move, f"FIX,bar,1+ 0 1 1\n{move}"))
        self.assertNotIn("FIX", said)
        _, said = self.displacement(remove, (move, f"FIX,bar,3- 1 0 0\n{move}"))
        self.assertIn(
            "warning: MOVE in line 16 prescribes displacements in direction 1 at nodes that this FIX restrains (number: 2)",
            said,
        )


class Overlap(Folder):
    def check(self, name, *changes):
        """What the screen shows for a deck of the folder `silent` with changes, read but not run."""
        deck = (SILENT / f"{name}.inp").read_text()
        for old, new in changes:
            self.assertIn(old, deck)
            deck = deck.replace(old, new)
        (self.at / f"{name}.inp").write_text(deck)
        done = self.run_bezel("--check", f"{name}.inp")
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stderr

    def test_bodies_that_overlap_are_named(self):
        """Bodies may overlap deeply, or lie inside each other; all outer faces of one may even lie
        on those of the other. Bodies that TIE joins somewhere count twice where they overlap.
        """
        alarm = "'low' and 'up' overlap at the start"
        up = "0.5 0.5 0.6  1 1 1"
        for place in (up, "0.5 0.5 0  1 1 1", "1.6 1.6 -0.1  2 2 2", "0 0 0  2 2 1"):
            with self.subTest(place):
                other_mesh = ("ELEMents 2 2 2", "ELEMents 3 3 2")
                self.assertIn(alarm, self.check("same_room", (up, place), other_mesh))
        tied = ("0.6  1 1 1\n  ELEMents 2 2 2", "0.5  1 1 1\n  ELEMents 1 1 1")
        self.assertIn(alarm, self.check("same_room", tied))
        said = self.check("same_room", tied, ("FIX,low", "TIE\n\nFIX,low"))
        self.assertIn("element 33 of 'up' and element 22 of 'low' overlap (the middles of 4", said)

    def test_bodies_that_touch_or_act_on_each_other_do_not_overlap(self):
        for place in ("0.5 0.5 1  1 1 1", "2 0 0  1 1 1", "2 2 1  1 1 1", "3 3 3  1 1 1"):
            with self.subTest(place):
                said = self.check("same_room", ("0.5 0.5 0.6  1 1 1", place))
                self.assertNotIn("overlap", said)
        self.assertNotIn("overlap", self.check("nested"))

    def test_independent_models_in_one_deck_may_overlap(self):
        """Two pairs of bodies in contact, one pair shifted by a part of its width."""
        patch = "PATCh,{}\n  BOX 0 {} {}  1 1 1\n  ELEMents 2 2 2\n  TYPE Q1\n  MATErial 1\n\n"
        more = "".join(
            patch.format(name, y, z)
            for name, y, z in (("a", 0, 3), ("b", 0, 4), ("c", 0.4, 3), ("d", 0.4, 4))
        )
        contact = "CONTact,{}\n  SURFaces {} 3+  {} 3-\n\n"
        joined = contact.format("ab", "a", "b") + contact.format("cd", "c", "d")
        said = self.check("same_room", ("FIX,low", f"{more}{joined}FIX,low"))
        self.assertEqual(said.count("overlap at the start"), 1)
        said = self.check("same_room", ("FIX,low", f"{more}FIX,low"))
        self.assertIn("'a' and 'c' overlap at the start", said)


class Changes(Folder):
    def test_the_log_says_when_a_contact_closes_and_opens(self):
        """The contacts of the deck have the default scheme and BALAnced."""
        shutil.copy(SILENT / "through_by_inertia.inp", self.at / "deck.inp")
        done = self.run_bezel("deck.inp")
        self.assertEqual(done.returncode, 0, done.stderr)
        lines = (self.at / "deck.log").read_text().splitlines()
        for name in ("mortar", "balanced"):
            with self.subTest(name):
                self.assertEqual(
                    [
                        line
                        for line in lines
                        if line.startswith(f"contact {name}: ") and line.endswith(" in contact")
                    ],
                    [
                        f"contact {name}: closed, 25 + 0 points in contact",
                        f"contact {name}: opened, no points in contact",
                    ],
                )
