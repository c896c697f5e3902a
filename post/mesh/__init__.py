"""Mesh an enriched body below a net of quads or a spline surface: `python -m post mesh NET -o
body`.

NET is a closed net of quads (VTK, OFF, OBJ, Gmsh; of a file of hexahedra, the boundary is taken) or
an extracted spline surface (BEXT 2.0, .iga). The body consists of a layer of enriched elements
below the surface and, inside it, of pyramids and tetrahedra or of the hexahedra of the file. The
command writes the mesh files, a deck that reads them and a report. As a library:

>>> from post.mesh import body_of
>>> body_of("net.off").cells["tets"].shape  # doctest: +SKIP
"""

import pathlib
import sys

from post import _options
from post._error import Unreadable
from post.mesh import _body, _choose, _net, _patches, _read, _read_spline, _report, _smooth, _write


def surface_of(path, closed=True, orient=False, refine=0, smooth=False, split=None):
    """(Surface, Net or None) of a file; for the arguments see the options of the command."""
    net = None
    if refine < 0:
        raise Unreadable(f"--refine {refine}: expected a number of steps that is not negative")
    if _read_spline.is_spline(path):
        if refine:
            raise Unreadable(
                "--refine applies to nets only; a spline surface already has its elements"
            )
        surface = _read_spline.read_spline(path, closed)
    else:
        net = _net.checked(_read.read_net(path), path, closed, orient)
        for _ in range(refine):
            net = _net.refined(net)
        surface = _patches.extract(net)
    if split:
        from post.mesh import _split

        chosen = _choose.elements(surface, split)
        if not chosen.any():
            raise Unreadable(f"--split '{split}' selects no element of the surface")
        surface = _split.split(surface, chosen)
    if smooth:
        surface = _smooth.smooth(surface, everywhere=smooth == "everywhere")
    return surface, net


def body_of(path, closed=True, orient=False, refine=0, smooth=False, split=None, groups=(),
            enrich=None, **options):  # fmt: skip
    """The Body of a file; all further options are passed to _body.build."""
    surface, net = surface_of(path, closed, orient, refine, smooth, split)
    _choose.named(surface, groups)
    if not closed:
        options["interior"] = "none"
    keep = None if enrich is None else _choose.elements(surface, enrich)
    return _body.build(surface, net, enrich=keep, **options)


def main(argv):
    """Run the command; return its exit code, which is 1 if the body is unfit for a run."""
    o = _parser().parse_args(argv)
    output = pathlib.Path(o.output)
    if not output.name.isidentifier():
        raise Unreadable(
            f"'{output.name}' is not a valid name for a deck; use letters, digits and _ only"
        )
    if without := _without_effect(o):
        raise Unreadable(without)
    heights = {"factor": o.layer, "constant": o.thickness}
    heights = {key: value for key, value in heights.items() if value is not None}
    body = body_of(
        o.file, not o.open, o.orient, o.refine, o.smooth, o.split, o.group, o.enrich,
        interior=o.interior, mesher=o.mesher or "gmsh", size=o.size, heights=heights, junction=o.t_junction,
        fine=o.fine,
    )  # fmt: skip
    report = _report.describe(body)
    try:
        for path in _write.write(body, output, " ".join(argv)):
            print(path)
        _report.write(report, output.with_name(output.name + ".mesh.json"))
    except OSError as error:
        raise Unreadable(
            f"'{error.filename or output}' cannot be written: {error.strerror}"
        ) from None
    print(_report.text(report))
    if not any(map(len, body.cells.values())):
        print("no deck is written, because a layer without elements inside cannot be run")
    if o.pictures:
        from post.mesh import _draw

        _draw.draw(body, output)
    problems = _report.bad(report)
    for sentence in problems:
        print(f"post mesh: {sentence}", file=sys.stderr)
    return 1 if problems else 0


def _without_effect(o):
    """A sentence about an option that another one leaves without effect, or None."""
    if o.layer is not None and o.thickness is not None:
        return "--layer has no effect with --thickness; leave one of them out"
    if o.open and o.interior == "hexes":
        return "--interior hexes has no effect with --open, which makes only the layer"
    other = "--open" if o.open else f"--interior {o.interior}"
    given = {"--size": o.size is not None, "--fine": o.fine, "--mesher": o.mesher is not None}
    if o.open or o.interior != "tets":
        for name in (n for n, there in given.items() if there):
            return f"{name} has no effect with {other}, which makes no tetrahedra"
    return None


def _parser():
    p = _options.parser(
        prog="post mesh", description="Mesh an enriched body below a net of quads or a spline surface.",
        epilog="A choice of elements is box:x1,y1,z1,x2,y2,z2, cylinder:px,py,pz,ax,ay,az,r, "
        "sphere:x,y,z,r, normal:nx,ny,nz,degrees, distance:x,y,z,d, set:name or all; "
        "a&b selects the elements that both choices select, a+b those that either selects.",
    )  # fmt: skip
    p.add_argument("file", help=".vtk .off .obj .msh nets, .bext.json .bext .iga splines")
    p.add_argument(
        "-o",
        "--output",
        required=True,
        metavar="DIR/NAME",
        help="folder and stem of the files to write",
    )
    p.add_argument("--interior", choices=("tets", "hexes", "none"), default="tets",
                   help="fill the inside with tetrahedra (default) or with the hexahedra of the file, or make the layer only")  # fmt: skip
    p.add_argument("--mesher", choices=("gmsh", "tetgen"), help="program that makes the tetrahedra (default gmsh)")  # fmt: skip
    p.add_argument("--size", type=float, help="largest edge of the tetrahedra inside [L]")
    p.add_argument("--fine", action="append", default=[], metavar="D=PLACE",
                   help="edge length D of the tetrahedra in a sphere or a box (Gmsh only); may be repeated")  # fmt: skip
    p.add_argument(
        "--open",
        action="store_true",
        help="accept an open surface, below which only a layer is made",
    )
    p.add_argument(
        "--orient",
        action="store_true",
        help="reverse quads where needed so that all normals point outward",
    )
    p.add_argument(
        "--refine",
        type=int,
        default=0,
        metavar="N",
        help="first refine the net by this number of Catmull-Clark steps",
    )
    p.add_argument("--smooth", nargs="?", const="local", choices=("local", "everywhere"),
                   help="use D-patches, whose normals are continuous at extraordinary points")  # fmt: skip
    p.add_argument(
        "--split",
        metavar="CHOICE",
        help="split the chosen elements into four each (makes T-junctions)",
    )
    p.add_argument("--t-junction", choices=("constraint", "peak"), default="constraint",
                   help="pyramids below T-junctions: one per quad, or with a common peak")  # fmt: skip
    p.add_argument("--layer", type=float, metavar="F",
                   help="largest height of the layer relative to the edge length (default 0.8, or 0.3 "
                   "above hexahedra)")  # fmt: skip
    p.add_argument(
        "--thickness", type=float, metavar="H", help="height of the layer, the same everywhere [L]"
    )
    p.add_argument(
        "--enrich",
        metavar="CHOICE",
        help="keep the spline on these elements and use plain faces elsewhere",
    )
    p.add_argument("--group", action="append", default=[], metavar="NAME=CHOICE",
                   help="name a group of elements, to be used by FIX and MOVE; may be repeated")  # fmt: skip
    p.add_argument("--pictures", action="store_true", help="draw NAME_surface.png and NAME_cut.png")
    return p
