"""Tetrahedra inside a closed surface of triangles, made by Gmsh or TetGen as separate programs.

Both programs are optional and have licences of their own (GPL, AGPL). They run as processes that
read and write files, and no part of them is imported here. The points of the surface do not change.
"""

import importlib.util
import pathlib
import shutil
import subprocess
import sys
import tempfile

import numpy as np

from post._error import Unreadable
from post.mesh import _read_gmsh

INSTALL = "tools/setup.sh mesh installs both; so does apt install gmsh tetgen"
GEO = """Merge "surface.msh";
Surface Loop(1) = {1};
Volume(1) = {1};
Mesh.Algorithm3D = %d;
Mesh.MeshSizeExtendFromBoundary = 1;
Mesh.MeshSizeMax = %s;
Mesh.OptimizeThreshold = 0.35;
General.NumThreads = 1;
"""
#: Outside a sphere or a box the size increases by half of the distance from it.
FIELD = """Field[{k}] = {kind};
Field[{k}].VIn = {size!r};
Field[{k}].VOut = {far!r};
Field[{k}].Thickness = {thickness!r};
"""
PLACES = {
    "sphere": ("Ball", ("XCenter", "YCenter", "ZCenter", "Radius")),
    "box": ("Box", ("XMin", "YMin", "ZMin", "XMax", "YMax", "ZMax")),
}
#: TetGen of the Python package, run in a process of its own.
TETGEN = """import sys, numpy, tetgen
x, t = numpy.load('points.npy'), numpy.load('triangles.npy')
made = tetgen.TetGen(x, t.astype(numpy.int32)).tetrahedralize(switches=sys.argv[1])
numpy.save('out_points.npy', made[0])
numpy.save('out_tets.npy', made[1])
"""


def mesh(points, triangles, mesher="gmsh", size=None, fine=()):
    """(points, tets) inside a surface; the first len(points) points are exactly the given ones.

    points: (n, 3), each of which belongs to a triangle; triangles: (k, 3), with outward normals;
    mesher: gmsh or tetgen; size: largest edge of a tetrahedron inside [L], None for that of the
    surface; fine: regions with smaller tetrahedra, see `places`.
    """
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        if mesher == "gmsh":
            x, tets = _gmsh(folder, points, triangles, size, places(fine, points))
        elif fine:
            raise Unreadable("--fine needs Gmsh; TetGen uses one --size for the whole inside")
        else:
            x, tets = _tetgen(folder, points, triangles, size)
    return _numbered(points, x, tets, mesher)


def places(texts, points):
    """Gmsh input for regions given as D=sphere:x,y,z,r or D=box:x1,y1,z1,x2,y2,z2.

    >>> places(["0.5=sphere:0,0,1,2"], np.eye(3)).splitlines()[4]
    'Field[1].XCenter = 0.0;'
    """
    far, lines = float(np.linalg.norm(np.ptp(points, axis=0))), []
    for k, text in enumerate(texts, 1):
        size, _, choice = text.partition("=")
        kind, _, rest = choice.partition(":")
        try:
            size, numbers = float(size), [float(w) for w in rest.split(",")]
        except ValueError:
            numbers = []
        if kind not in PLACES or len(numbers) != len(PLACES[kind][1]) or not size > 0:
            raise Unreadable(
                f"'{text}' is not of the form D=sphere:x,y,z,r or D=box:x1,y1,z1,x2,y2,z2"
            )
        if kind == "box":
            numbers = [*map(min, numbers[:3], numbers[3:]), *map(max, numbers[:3], numbers[3:])]
        word, names = PLACES[kind]
        lines.append(FIELD.format(k=k, kind=word, size=size, far=far, thickness=2 * far))
        lines += [f"Field[{k}].{name} = {v!r};\n" for name, v in zip(names, numbers)]
    if lines:
        n = len(texts) + 1
        members = ", ".join(map(str, range(1, n)))
        lines.append(f"Field[{n}] = Min;\nField[{n}].FieldsList = {{{members}}};\n")
        lines.append(f"Background Field = {n};\n")
    return "".join(lines)


def available(mesher):
    """Whether a mesher is installed."""
    return bool(_program(mesher) or mesher == "tetgen" and importlib.util.find_spec("tetgen"))


def _numbered(points, x, tets, mesher):
    """The given points followed by the mesher's own, and the tetrahedra, reordered where their
    volume was negative.
    """
    n = len(points)
    scale = np.ptp(points, axis=0).max()
    used = np.zeros(len(x), dtype=bool)
    used[tets.ravel()] = True
    # The mesher writes 16 digits, so its copies of the points may differ by round-off.
    if len(x) < n or not used[:n].all() or abs(x[:n] - points).max() > 1e-14 * scale:
        raise Unreadable(f"{mesher} changed points of the given surface")
    number = np.full(len(x), -1)
    number[:n] = np.arange(n)
    new = n + np.flatnonzero(used[n:])
    number[new] = n + np.arange(len(new))
    tets = number[tets]
    full = np.concatenate([points, x[new]])
    a, b, c, d = (full[tets[:, k]] for k in range(4))
    negative = np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) < 0
    tets[negative] = tets[negative][:, [1, 0, 2, 3]]
    return full, tets


def _run(command, folder, name):
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if done.returncode:
        lines = (done.stdout + done.stderr).strip().splitlines()
        said = next((w for w in lines if "rror" in w), lines[-1] if lines else "without output")
        raise Unreadable(f"{name} ended with code {done.returncode}: {said.strip()}")
    return done.stdout


def _program(name):
    """The command that starts a program, from the folder of this Python or the search path, or
    None.
    """
    beside = pathlib.Path(sys.executable).parent / name
    if beside.exists():
        python = beside.read_bytes()[:2] == b"#!"
        return [sys.executable, str(beside)] if python else [str(beside)]
    found = shutil.which(name)
    return [found] if found else None


def _gmsh(folder, points, triangles, size, sizes=""):
    command = _program("gmsh")
    if not command:
        raise Unreadable(f"Gmsh is not installed; {INSTALL}")
    with open(folder / "surface.msh", "w") as f:
        f.write(f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{len(points)}\n")
        f.writelines(f"{i} {a!r} {b!r} {c!r}\n" for i, (a, b, c) in enumerate(points.tolist(), 1))
        f.write(f"$EndNodes\n$Elements\n{len(triangles)}\n")
        f.writelines(
            f"{i} 2 2 1 1 {a} {b} {c}\n" for i, (a, b, c) in enumerate((triangles + 1).tolist(), 1)
        )
        f.write("$EndElements\n")
    limit = "1e22" if size is None else repr(float(size))
    # Try HXT first and, if it fails, the older and slower Delaunay mesher.
    for algorithm in (10, 1):
        (folder / "volume.geo").write_text(GEO % (algorithm, limit) + sizes)
        out = folder / "out.msh"
        try:
            _run(command + ["volume.geo", "-3", "-format", "msh22", "-save_all", "-o", "out.msh",
                            "-setnumber", "Mesh.SaveAll", "1"], folder, "Gmsh")  # fmt: skip
            x, tags, cells, _ = _read_gmsh.read_all(out)
        except Unreadable as error:
            failed = error
            continue
        tets = np.array([nodes for kind, _, nodes in cells if kind == 4], dtype=np.int64)
        if len(tets):
            order = np.argsort(tags)  # the mesher's own points come after the given ones
            return x[order], np.searchsorted(tags[order], tets)
        failed = Unreadable(
            "Gmsh made no tetrahedra; check whether the surface below the layer intersects itself"
        )
    raise failed


def _tetgen(folder, points, triangles, size):
    switches = "pYq1.2/15" + ("" if size is None else f"a{size**3 / (6 * np.sqrt(2)):.17g}")
    if importlib.util.find_spec("tetgen"):
        np.save(folder / "points.npy", points)
        np.save(folder / "triangles.npy", triangles)
        _run([sys.executable, "-c", TETGEN, switches + "Q"], folder, "TetGen")
        return np.load(folder / "out_points.npy"), np.load(folder / "out_tets.npy").astype(np.int64)
    command = _program("tetgen")
    if not command:
        raise Unreadable(f"TetGen is not installed; {INSTALL}")
    with open(folder / "s.poly", "w") as f:
        f.write(f"{len(points)} 3 0 0\n")
        f.writelines(f"{i} {a!r} {b!r} {c!r}\n" for i, (a, b, c) in enumerate(points.tolist()))
        f.write(f"{len(triangles)} 0\n")
        f.writelines(f"1\n3 {a} {b} {c}\n" for a, b, c in triangles.tolist())
        f.write("0\n0\n")
    _run(command + ["-" + switches + "Q", "s.poly"], folder, "TetGen")
    return _tetgen_table(folder / "s.1.node", 3, float), _tetgen_table(folder / "s.1.ele", 4, int)


def _tetgen_table(path, width, kind):
    rows = [line.split() for line in path.read_text().splitlines() if not line.startswith("#")]
    return np.array([r[1 : 1 + width] for r in rows[1:] if r], dtype=kind)
