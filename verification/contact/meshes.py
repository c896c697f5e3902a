"""Write the meshes of the self-contact cases, Gmsh 2.2.

    python -m verification.contact.meshes

slit/slit.msh: a block 4 x 1 x 2 with a slit of width 0.04 at half its height, from x = 1 to x = 3.
The meshes of the two faces of the slit do not match. Groups: `slit`, and its faces `upper` and
`lower`; `bottom`; `top`.

slit/cut.msh: two blocks 1 x 1 x 1 at a distance of 0.01, of 3 x 3 x 3 and 4 x 4 x 4 elements, in
one mesh. Groups: `slit` (both faces between the blocks), `upper`, `lower`; `bottom`; `top`.

shared/posts.msh: two blocks 1 x 1 x 1 at a distance of 1. Groups: `first` and `second` (the tops of
the two blocks); `both` (the two tops together); `bottom`.
"""

import pathlib

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent


class Mesh:
    """Nodes, hexahedra and named quadrilaterals."""

    def __init__(self):
        self.nodes, self.hexas, self.faces = [], [], []

    def box(self, counts, place, known=None):
        """Add the hexahedra of a box, with nodes at place(i, j, k); return the node numbers [i,
        j, k].
        """
        n1, n2, n3 = counts
        number = np.zeros((n1 + 1, n2 + 1, n3 + 1), dtype=int)
        for i, j, k in np.ndindex(number.shape):
            if known is not None and known.get((i, j, k)):
                number[i, j, k] = known[i, j, k]
                continue
            self.nodes.append(place(i, j, k))
            number[i, j, k] = len(self.nodes)
        for i, j, k in np.ndindex(n1, n2, n3):
            low = [
                number[i, j, k],
                number[i + 1, j, k],
                number[i + 1, j + 1, k],
                number[i, j + 1, k],
            ]
            high = [
                number[i, j, k + 1],
                number[i + 1, j, k + 1],
                number[i + 1, j + 1, k + 1],
                number[i, j + 1, k + 1],
            ]
            self.hexas.append(low + high)
        return number

    def layer(self, plane, *names, where=lambda i: True):
        """Add the faces of a layer of nodes plane[i, j] to the groups `names`."""
        n1, n2 = plane.shape
        for i, j in np.ndindex(n1 - 1, n2 - 1):
            if where(i):
                quad = [plane[i, j], plane[i + 1, j], plane[i + 1, j + 1], plane[i, j + 1]]
                self.faces += [(name, quad) for name in names]

    def write(self, path):
        names = sorted({name for name, _ in self.faces})
        lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(names) + 1)]
        lines += [f'2 {i + 1} "{name}"' for i, name in enumerate(names)]
        lines += [f'3 {len(names) + 1} "body"', "$EndPhysicalNames", "$Nodes", str(len(self.nodes))]
        lines += [f"{i + 1} {x:.17g} {y:.17g} {z:.17g}" for i, (x, y, z) in enumerate(self.nodes)]
        lines += ["$EndNodes", "$Elements", str(len(self.faces) + len(self.hexas))]
        rows = [(3, names.index(name) + 1, quad) for name, quad in self.faces]
        rows += [(5, len(names) + 1, hexa) for hexa in self.hexas]
        for e, (kind, tag, nodes) in enumerate(rows):
            lines.append(" ".join(str(v) for v in (e + 1, kind, 2, tag, tag, *nodes)))
        path.write_text("\n".join([*lines, "$EndElements", ""]), encoding="utf-8")


def slit(path, n=16, across=2, layers=4, gap=0.04):
    """A block with a slit."""
    mesh = Mesh()

    def x_of(i, k, lean):
        # nodes within the slit are shifted to the right above it, and to the left below it
        x, fade = 4 * i / n, k / layers
        return x + lean * (1 - fade) * 0.3 * 4 / n * max(0.0, np.sin(np.pi * (x - 1) / 2)) * (
            1 < x < 3
        )

    def opening(i, k):
        return 0.5 * gap * (1 < 4 * i / n < 3) * (1 - k / layers)

    def lower(i, j, k):
        k = layers - k
        return x_of(i, k, -1), j / across, 1 - k / layers - opening(i, k)

    def upper(i, j, k):
        return x_of(i, k, 1), j / across, 1 + k / layers + opening(i, k)

    below = mesh.box((n, across, layers), lower)
    shared = {
        (i, j, 0): below[i, j, layers]
        for i in range(n + 1)
        for j in range(across + 1)
        if not n < 4 * i < 3 * n
    }
    above = mesh.box((n, across, layers), upper, shared)
    mesh.layer(below[:, :, layers], "slit", "lower", where=lambda i: n <= 4 * i < 3 * n)
    mesh.layer(above[:, :, 0], "slit", "upper", where=lambda i: n <= 4 * i < 3 * n)
    mesh.layer(below[:, :, 0], "bottom")
    mesh.layer(above[:, :, layers], "top")
    mesh.write(path)


def cut(path):
    """Two blocks whose meshes do not match."""
    mesh = Mesh()
    below = mesh.box((3, 3, 3), lambda i, j, k: (i / 3, j / 3, k / 3))
    above = mesh.box((4, 4, 4), lambda i, j, k: (i / 4, j / 4, 1.01 + k / 4))
    mesh.layer(below[:, :, 3], "slit", "lower")
    mesh.layer(above[:, :, 0], "slit", "upper")
    mesh.layer(below[:, :, 0], "bottom")
    mesh.layer(above[:, :, 4], "top")
    mesh.write(path)


def posts(path):
    """Two blocks beside each other."""
    mesh = Mesh()
    for name, x, n in (("first", 0, 3), ("second", 2, 2)):
        block = mesh.box((n, n, 2), lambda i, j, k, x=x, n=n: (x + i / n, j / n, k / 2))
        mesh.layer(block[:, :, 0], "bottom")
        mesh.layer(block[:, :, 2], name, "both")
    mesh.write(path)


if __name__ == "__main__":
    posts(HERE / "shared/posts.msh")
    slit(HERE / "slit/slit.msh")
    cut(HERE / "slit/cut.msh")
