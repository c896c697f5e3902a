"""Fields of contact contain no artefacts of the format of the result file or of several contacts."""

import numpy as np

from post._fields import read_fields
from verification.trouble.test_files import HERE, Folder


class Contact(Folder):
    def test_quadratic_elements_have_no_negative_pressure_below_the_surface(self):
        """The lower side of the upper block is in contact everywhere, under a pressure of 5."""
        deck = (HERE / "silent/pressed.inp").read_text()
        before, after = deck.split("PATCh,up")
        after = after.replace("TYPE Q1\n", "TYPE Q2\n", 1).replace(
            "  NEXT,time\n", "  NEXT,time\n  PLOT\n"
        )
        (self.at / "q2.inp").write_text(f"{before}PATCh,up{after}")
        done = self.run_bezel("q2.inp")
        self.assertEqual(done.returncode, 0, done.stderr)
        arrays = read_fields(self.at / "q2.vtkhdf").arrays
        for name in ("contact_pressure", "contact_state"):
            with self.subTest(name):
                values = arrays[name][1][-1]
                self.assertGreater(values.max(), 0.99)
                self.assertEqual(values.min(), 0.0)

    def test_output_may_name_all_fields(self):
        names = (
            "displacement stress mises pressure reaction contact_gap contact_pressure contact_state"
        )
        deck = (HERE / "silent/pressed.inp").read_text()
        deck = deck.replace("BATCh\n", f"BATCh\n  OUTPut,,every 1 {names}\n")
        (self.at / "all.inp").write_text(deck)
        done = self.run_bezel("all.inp")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertLessEqual(set(names.split()), set(read_fields(self.at / "all.vtkhdf").arrays))

    def on_floor(self, name, field, *options):
        """Run a deck of the folder `silent`; return the x and the field of the points at z = 0."""
        (self.at / "d.inp").write_text((HERE / f"silent/{name}.inp").read_text())
        done = self.run_bezel(*options, "d.inp")
        self.assertEqual(done.returncode, 0, done.stderr)
        found = read_fields(self.at / "d.vtkhdf")
        on = np.abs(found.points[:, 2]) < 1e-9
        return found.points[on, 0], found.arrays[field][1][-1][on]

    def test_neighbouring_faces_of_two_contacts_have_one_pressure(self):
        """Each contact has the area of its own faces only, also at the nodes on their border."""
        x, pressure = self.on_floor("seam_of_contacts", "contact_pressure")
        self.assertIn(1.0, x)
        np.testing.assert_allclose(pressure, 1.0, rtol=1e-9)
        _, traction = self.on_floor("seam_of_contacts", "contact_traction")
        np.testing.assert_allclose(np.abs(traction[:, 2]), 1.0, rtol=1e-9)

    def test_the_gap_is_that_of_the_contact_that_a_node_faces(self):
        """Over the left floor the block hovers 0.099, over the right one 0.019 above it."""
        x, gap = self.on_floor("gap_of_two_contacts", "contact_gap")
        np.testing.assert_allclose(gap[x < -0.2], 0.099, atol=2e-4)
        np.testing.assert_allclose(gap[x > 0.1], 0.019, atol=2e-4)

    def test_a_contact_that_faces_nothing_does_not_look_closed(self):
        _, gap = self.on_floor("gap_of_two_contacts", "contact_gap", "--set", "dx=-1.2")
        np.testing.assert_allclose(gap, 0.099, atol=2e-4)
