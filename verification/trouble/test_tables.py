"""Printed tables have rows for all elements, whatever numbers the mesh file gives them."""

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
