"""Printed tables have rows for all elements, whatever numbers the mesh file gives them, and show the
state of the last solve.
"""

import shutil

from verification.trouble.test_files import HERE, Folder


class Stresses(Folder):
    def elements(self, name):
        """Run a deck of the folder `silent`; return the elements of the rows of each table."""
        for path in (HERE / "silent").glob(f"{name}.*"):
            shutil.copy(path, self.at)
        done = self.run_bezel(f"{name}.inp")
        self.assertEqual(done.returncode, 0, done.stderr)
        tables = (self.at / f"{name}.out").read_text().split("E l e m e n t")[1:]
        rows = [[line.split() for line in table.splitlines()] for table in tables]
        return [[int(row[0]) for row in table if len(row) == 12] for table in rows]

    def test_numbers_of_the_file_need_not_begin_at_1(self):
        last, every = self.elements("numbered_elements")
        self.assertEqual(sorted(set(last)), [11, 12])
        self.assertEqual(sorted(set(every)), list(range(3, 13)))

    def test_equal_numbers_of_a_block_and_a_mesh(self):
        (table,) = self.elements("after_block")
        self.assertEqual(len(table), 16)
        self.assertEqual(set(table), {1})


class Displacements(Folder):
    DECK = """FEAP ** a block slides on its base in steps that resemble each other
  ndm = 3
MATErial 1
  SOLId
  ELAStic NEOHook 1.0 0.3
  FINIte

PATCh,base
  BOX -1 -1 -0.5 5 2 0.5
  ELEMents 10 4 1
  TYPE Q1
  MATErial 1

PATCh,block
  BOX 0 -0.5 0 1 1 1
  ELEMents 2 2 2
  TYPE Q1
  MATErial 1

FIX,base,3- 1 1 1
MOVE,block,3+ TRANslate 0 0 -0.02 PROP 1
MOVE,block,3+ TRANslate 0.1 0 0 PROP 1
CONTact,c
  SURFaces block 3-  base 3+

END
BATCh
  PROP,,1
  DT,,0.25
  LOOP,t,3
    TIME
    DISP,,115,115
    LOOP,n,40
      UTAN,,1
    NEXT
    DISP,,115,115
  NEXT
  TIME
  DISP,,115,115
  TIME
  FORM
  TIME
  DISP,,115,115
END

STOP
"""

    def test_displacements_change_only_when_a_system_is_solved(self):
        """The next step may start from predicted displacements, but not before its first forces."""
        (self.at / "slide.inp").write_text(self.DECK)
        done = self.run_bezel("slide.inp")
        self.assertEqual(done.returncode, 0, done.stderr)
        text = (self.at / "slide.out").read_text()
        rows = [line.split() for line in text.splitlines() if line.split()[:1] == ["115"]]
        self.assertEqual(len(rows), 8)
        for before, after in ((1, 2), (3, 4), (5, 6), (5, 7)):
            self.assertEqual(rows[before], rows[after])
        self.assertNotEqual(rows[1], rows[3])
