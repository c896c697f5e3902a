"""Figures and comparisons from the files that bezel writes.

There are six commands. Each is a module of the same name that can also be used as a library:

=============  ==============================================================  ======================
command        what it does                                                    needs
=============  ==============================================================  ======================
curve          plots columns of curve files against each other                 numpy, matplotlib
convergence    plots relative errors against degrees of freedom, with slopes   numpy, matplotlib
field          renders a step of a result file without a screen                h5py, matplotlib, vtk
contact-map    draws contact surfaces from above, side by side                 h5py, matplotlib, vtk
diff           compares two runs, or a run and a reference                     numpy; h5py for fields
mesh           meshes an enriched body below a net or a spline surface         numpy; Gmsh or TetGen
=============  ==============================================================  ======================

No command reads a deck. `mesh` reads a net or a spline surface; the others read only results and
tables. Large packages are imported only when needed:

>>> import post
>>> post.diff.compare.__name__
'compare'
"""

import importlib

from post._error import Unreadable

COMMANDS = ("curve", "convergence", "field", "contact-map", "diff", "mesh")
MODULES = tuple(name.replace("-", "_") for name in COMMANDS)
__all__ = [*MODULES, "Unreadable"]


def __getattr__(name):
    """Import the module of a command when it is first used."""
    if name in MODULES:
        return importlib.import_module(f"post.{name}")
    raise AttributeError(f"module 'post' has no attribute {name!r}")
