"""Files of `post mesh`: what is written, what is read, and the one sentence for each error."""

import json
import pathlib
import subprocess
import sys
import unittest
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO

import numpy as np

from post import __main__ as command
from post import _screen
from post._error import Unreadable
from post.mesh import _draw, _read, _report, _smooth, _surface, _tets, _write, body_of
from post.tests.net_samples import Folder, grid, rows, vtk


class Files(Folder):
    def run_command(self, *argv):
        out, err = StringIO(), StringIO()
        with redirect_stdout(out), redirect_stderr(err):
            code = command.main(["mesh", *argv])
        return code, out.getvalue(), err.getvalue()

    def test_the_command_writes_what_the_deck_names(self):
        code, out, err = self.run_command(
            self.block(), "-o", str(self.folder / "b"), "--interior", "hexes",
            "--enrich", "normal:0,0,1,30", "--group", "top=normal:0,0,1,30")  # fmt: skip
        self.assertEqual((code, err), (0, ""))
        for ending in ("msh", "bext.json", "layer", "con", "inp", "mesh.json"):
            self.assertTrue((self.folder / f"b.{ending}").exists(), ending)
        deck = (self.folder / "b.inp").read_text()
        self.assertIn("SPLIne,b FILE b.bext.json", deck)
        data = json.loads((self.folder / "b.bext.json").read_text())
        self.assertIn("top", data["sets"])
        self.assertEqual(
            len((self.folder / "b.layer").read_text().splitlines()) - 1, data["num_elems"]
        )

    def test_a_layer_alone_has_no_deck(self):
        words = [self.block(), "-o", str(self.folder / "b"), "--interior", "none"]
        code, out, err = self.run_command(*words)
        self.assertEqual((code, err), (0, ""))
        self.assertFalse((self.folder / "b.inp").exists())
        self.assertIn("no deck is written", out)

    def test_a_place_that_cannot_be_written_is_named(self):
        words = [self.block(), "-o", str(self.folder / "b/a"), "--interior", "none"]
        (self.folder / "b").write_text("a file, not a folder")
        code, _, err = self.run_command(*words)
        self.assertEqual(code, 2)
        self.assertRegex(err, "b' cannot be written: ")

    def test_the_rocker_arm_is_a_closed_net_with_named_parts(self):
        path = self.folder / "rocker_arm.obj"
        script = pathlib.Path(command.__file__).parents[1] / "input/rocker_arm.py"
        subprocess.run([sys.executable, str(script), str(path)], check=True)
        body = body_of(str(path), interior="none")
        self.assertLessEqual({"bore_left", "bore_right", "pad"}, set(body.surface.sets))
        self.assertEqual(len(_smooth.extraordinary(body.whole)), 16)
        # Two holes: vertices - edges + faces = 2 - 2 genus; a net has twice as many edges as quads.
        self.assertEqual(len(body.form.inner) - len(body.whole.nodes), 2 - 2 * 2)

    def test_pictures_are_drawn(self):
        if _screen.reason_not_ready():
            self.skipTest("nothing to draw with")
        with redirect_stdout(StringIO()):
            paths = _draw.draw(self.body(), self.folder / "a")
        for path in paths:
            self.assertGreater(pathlib.Path(path).stat().st_size, 10_000)

    def test_both_layouts_of_vtk_files_are_read(self):
        """VTK writes OFFSETS and CONNECTIVITY since version 5 of the format."""
        points, cells = grid()
        old = vtk(points, cells)
        offsets = " ".join(map(str, 8 * np.arange(len(cells) + 1)))
        nodes = " ".join(map(str, np.ravel(cells)))
        start, end = old.index("CELLS"), old.index("CELL_TYPES")
        new = (old[:start].replace("Version 2.0", "Version 5.1")
               + f"CELLS {len(cells) + 1} {8 * len(cells)}\nOFFSETS vtktypeint64\n{offsets}\n"
               f"CONNECTIVITY vtktypeint64\n{nodes}\n" + old[end:])  # fmt: skip
        one, two = (_read.read_vtk(self.file(n, t)) for n, t in (("a.vtk", old), ("b.vtk", new)))
        for i in range(3):
            np.testing.assert_array_equal(one[i], two[i])

    def test_points_of_the_bulk_come_back_bit_by_bit(self):
        body = self.body()
        path = self.file("b.msh", _write.gmsh_text(body))
        points = _read.read_net(path).points
        np.testing.assert_array_equal(points, body.points)

    def test_vectors_are_shared_between_elements(self):
        body = body_of(self.block((5, 5, 5)), interior="none")
        data = json.loads(_write.bext_text(_write.grouped(body.surface)))
        total = sum(len(ids) for ids in body.surface.nodes)
        self.assertLess(data["num_coeff_vecs"], total / 10)

    def test_gmsh_4_and_off_and_obj_give_the_same_net(self):
        points, cells = grid((1, 1, 1))
        quads = _read.boundary(cells)
        off = f"OFF\n8 6 12\n{rows(points)}\n" + "\n".join(
            "4 " + " ".join(map(str, q)) for q in quads
        )
        obj = "\n".join(["v " + r for r in rows(points).splitlines()]
                        + ["f " + " ".join(f"{i + 1}/1" for i in q) for q in quads])  # fmt: skip
        gmsh = ("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 8 1 8\n2 1 0 8\n" + "\n".join(map(str, range(1, 9)))
                + f"\n{rows(points)}\n$EndNodes\n$Elements\n1 6 1 6\n2 1 3 6\n"
                + "\n".join(f"{k + 1} " + " ".join(str(i + 1) for i in q) for k, q in enumerate(quads))
                + "\n$EndElements\n")  # fmt: skip
        for name, text in (("a.off", off), ("a.obj", obj), ("a.msh", gmsh)):
            net = _read.read_net(self.file(name, text))
            np.testing.assert_array_equal(net.points, points)
            np.testing.assert_array_equal(net.quads, quads)

    def test_tetrahedra_fill_what_the_pyramids_leave_and_keep_its_points(self):
        for mesher in ("gmsh", "tetgen"):
            if not _tets.available(mesher):
                continue
            body = body_of(self.block(), mesher=mesher)
            report = _report.describe(body)
            self.assertLess(report["volume"]["relative_difference"], 1e-12)
            self.assertEqual(_report.bad(report), [])
            np.testing.assert_array_equal(body.points[: len(body.form.inner)], body.form.inner)


class Errors(Folder):
    def message(self, text, name="a.vtk", **options):
        with self.assertRaises(Unreadable) as caught:
            body_of(self.file(name, text), **({"interior": "none"} | options))
        return str(caught.exception)

    def quads(self):
        points, cells = grid((2, 2, 2))
        return points, _read.boundary(cells)

    def test_an_open_surface_is_not_closed(self):
        points, quads = self.quads()
        self.assertIn("is not closed: 4 edges", self.message(vtk(points, quads[1:], 9)))

    def test_a_surface_seen_from_inside(self):
        points, quads = self.quads()
        text = vtk(points, quads[:, ::-1], 9)
        self.assertIn("point inward", self.message(text))
        body = body_of(self.file("b.vtk", text), interior="none", orient=True)
        self.assertGreater(_surface.measures(body.surface)[1], 0)

    def test_one_quad_that_is_turned(self):
        points, quads = self.quads()
        quads[3] = quads[3, ::-1]
        self.assertIn("opposite orientation; --orient", self.message(vtk(points, quads, 9)))
        body = body_of(self.file("b.vtk", vtk(points, quads, 9)), interior="none", orient=True)
        self.assertEqual(len(body.surface.nodes), len(quads))

    def test_degenerate_quads(self):
        points, quads = self.quads()
        twice = quads.copy()
        twice[2, 1] = twice[2, 0]
        self.assertIn(
            "quad 3 is degenerate: it has a duplicate point", self.message(vtk(points, twice, 9))
        )
        points = points.copy()
        points[quads[0, 1]] = points[quads[0, 0]]
        self.assertIn("no area, or an edge without length", self.message(vtk(points, quads, 9)))

    def test_points_that_are_missing(self):
        points, quads = self.quads()
        quads[1, 2] = 99
        self.assertIn(
            "cell 2 refers to a point outside the 27 points", self.message(vtk(points, quads, 9))
        )

    def test_counts_that_are_wrong_and_files_that_end_early(self):
        points, quads = self.quads()
        text = vtk(points, quads, 9)
        self.assertIn(
            "does not match its 24 cells",
            self.message(text.replace("CELLS 24 120", "CELLS 24 119")),
        )
        self.assertIn("found the end of the file after", self.message(text[: len(text) // 2]))
        self.assertIn(
            "is not a valid value of the number of points",
            self.message(text.replace("POINTS 27", "POINTS -27")),
        )
        self.assertIn("found 'x'", self.message(text.replace("0.0", "x", 1)))

    def test_other_cells_and_files(self):
        points, _ = self.quads()
        self.assertIn("type 5", self.message(vtk(points, np.array([[0, 1, 2]]), 5)))
        self.assertIn(
            "has 3 corners", self.message("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2", "a.off")
        )
        self.assertIn("unknown ending '.stl'", self.message("solid", "a.stl"))
        self.assertIn("is not BEXT 2.0", self.message("{}", "a.bext.json"))
        self.assertIn("found the end of the file", self.message("type surface\nnodeN 3\n", "a.iga"))

    def test_a_spline_file_whose_functions_do_not_sum_to_one(self):
        text = _write.bext_text(_write.grouped(self.body().surface))
        data = json.loads(text)
        data["coefficients"]["dense_coefficient_vectors"][0]["components"][5] += 0.5
        self.assertIn("do not sum to one", self.message(json.dumps(data), "a.bext.json"))

    def test_places_of_small_tetrahedra_that_are_none(self):
        text = vtk(*grid())
        for fine in (
            "0.1",
            "x=sphere:0,0,0,1",
            "0=sphere:0,0,0,1",
            "1=sphere:0,0,1",
            "1=cylinder:1,1",
        ):
            said = self.message(text, interior="tets", fine=[fine])
            self.assertIn(f"'{fine}' is not of the form D=sphere", said)
        said = self.message(text, interior="tets", mesher="tetgen", fine=["1=sphere:0,0,0,1"])
        self.assertIn("--fine needs Gmsh", said)

    def gmsh(self, version="2.2"):
        """A closed net as a Gmsh file of either version."""
        points, quads = self.quads()
        lines = rows(points).splitlines()
        cells = [" ".join(str(i + 1) for i in q) for q in quads]
        head = f"$MeshFormat\n{version} 0 8\n$EndMeshFormat\n$Nodes\n"
        if version == "2.2":
            nodes = "27\n" + "\n".join(f"{i} {x}" for i, x in enumerate(lines, 1))
            elements = "24\n" + "\n".join(f"{k} 3 2 1 1 {c}" for k, c in enumerate(cells, 1))
        else:
            tags = "\n".join(map(str, range(1, 28)))
            nodes = f"1 27 1 27\n2 1 0 27\n{tags}\n" + "\n".join(lines)
            elements = "1 24 1 24\n2 1 3 24\n" + "\n".join(
                f"{k} {c}" for k, c in enumerate(cells, 1)
            )
        return f"{head}{nodes}\n$EndNodes\n$Elements\n{elements}\n$EndElements\n"

    def test_gmsh_files_that_are_twice_partitioned_or_not_whole(self):
        good = self.gmsh()
        body_of(self.file("good.msh", good), interior="none")
        for old, new, said in (
            ("\n5 ", "\n4 ", "duplicate node 4"),
            ("\n5 ", "\n5.5 ", "the number of a node, 5.5, is not an integer"),
            ("$Elements", "$Nodes\n0\n$EndNodes\n$Elements", "duplicate section $Nodes"),
            ("$Nodes", "$PartitionedEntities\n$Nodes", "the mesh is partitioned"),
            ("2.2 0 8", "2.2 1 8", "is a binary Gmsh file"),
            ("$EndElements", "", "ends before $EndElements"),
        ):
            self.assertIn(said, self.message(good.replace(old, new, 1), "a.msh"))

    def test_nodes_of_gmsh_4_with_parameters(self):
        text = self.gmsh("4.1").replace("2 1 0 27", "2 1 1 27")
        self.assertIn("expected a number of $Nodes, found", self.message(text, "a.msh"))
        start = text.index("0.0 0.0 0.0")
        end = text.index("$EndNodes")
        given = "".join(line + " 0.25 0.75\n" for line in text[start:end].splitlines())
        points = _read.read_net(self.file("b.msh", text[:start] + given + text[end:])).points
        np.testing.assert_array_equal(points, self.quads()[0])

    def test_files_from_windows(self):
        plain = _read.read_net(self.file("a.msh", self.gmsh()))
        path = self.folder / "b.msh"
        path.write_bytes(b"\xef\xbb\xbf" + self.gmsh().replace("\n", "\r\n").encode())
        net = _read.read_net(str(path))
        np.testing.assert_array_equal(net.points, plain.points)
        np.testing.assert_array_equal(net.quads, plain.quads)

    def test_points_at_one_place_are_named(self):
        points, quads = self.quads()
        points = np.vstack([points, points[quads[0, 0]]])
        quads[0, 0] = 27
        self.assertIn("(points 1 and 28 coincide", self.message(vtk(points, quads, 9)))

    def test_spline_files_with_something_else_in_them(self):
        data = json.loads(_write.bext_text(_write.grouped(self.body().surface)))
        for change, said in (
            ({"sets": {"a": [99]}}, "set 'a' refers to an element that does not exist"),
            ({"sets": {"a": [1.5]}}, "is not an integer"),
            ({"sets": [1]}, "is not BEXT 2.0"),
            ({"dim": 3}, "contains a solid; expected a surface"),
            ({"dim": 1}, "contains curves; expected a surface"),
            ({"dim": "2"}, "contains no surface"),
            ({"num_elems": 3}, "announces 3 elements"),
        ):
            self.assertIn(said, self.message(json.dumps(data | change), "a.bext.json"))
        self.assertIn("nested too deeply", self.message("[" * 100_000, "a.bext.json"))
        head = "B E X T 2.0\n1 8 1 8 0\n" + "0 0 0 1\n" * 8 + "1\n"
        self.assertIn("contains a solid", self.message(head + "1 1 8 8 1 1 1\n", "a.bext"))
        self.assertIn("contains curves", self.message(head + "1 1 2 2 1\n", "a.bext"))
        data["coefficients"]["dense_coefficient_vectors"][0]["components"][0] = float("nan")
        self.assertIn("do not sum to one", self.message(json.dumps(data), "a.bext.json"))
        self.assertIn("found 'type volume'", self.message("type volume\nnodeN 0\n", "a.iga"))
        self.assertIn("line 1: expected numbers", self.message("f 1 2 3 " + 20 * "9", "a.obj"))

    def test_options_that_make_no_sense(self):
        text = vtk(*grid())
        for options, said in (
            ({"size": -1.0}, "--size -1"),
            ({"heights": {"factor": float("nan")}}, "--layer nan"),
            ({"heights": {"constant": 0.0}}, "--thickness 0"),
            ({"refine": -1}, "--refine -1"),
            ({"split": "box:9,9,9,9,9,9"}, "--split 'box:9,9,9,9,9,9' selects no element"),
            ({"groups": ["plain=all"]}, "the name 'plain' is reserved"),
        ):
            self.assertIn(said, self.message(text, **options))

    def test_options_without_effect(self):
        for words, said in (
            ("--interior none --size 0.3", "--size has no effect with --interior none"),
            ("--open --mesher gmsh", "--mesher has no effect with --open"),
            ("--interior hexes --fine 0.1=sphere:0,0,0,1", "--fine has no effect"),
            ("--layer 0.3 --thickness 0.1 --interior none", "--layer has no effect"),
            ("--open --interior hexes", "--interior hexes has no effect"),
        ):
            err = StringIO()
            with redirect_stdout(StringIO()), redirect_stderr(err):
                place = str(self.folder / "b")
                code = command.main(["mesh", self.block(), "-o", place, *words.split()])
            self.assertEqual(code, 2, words)
            self.assertIn(said, err.getvalue())

    def test_a_group_that_is_there_already(self):
        text = vtk(*grid())
        self.assertIn(
            "there is a group 'top' already",
            self.message(text, groups=["top=normal:0,0,1,30", "top=normal:0,0,-1,30"]),
        )

    def test_a_choice_that_names_nothing(self):
        text = vtk(*grid())
        self.assertIn("expected 6 numbers", self.message(text, groups=["top=box:1,2"]))
        self.assertIn("selects no element", self.message(text, groups=["top=box:9,9,9,10,10,10"]))
        self.assertIn("no set 'top'", self.message(text, enrich="set:top"))


if __name__ == "__main__":
    unittest.main()
