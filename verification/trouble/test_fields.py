"""Fields of contact contain no artefacts of the format of the result file."""

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
