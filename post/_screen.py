"""Rendering without a screen: find an OpenGL library, or say what to install."""

import ctypes
import functools
import os
import subprocess
import sys

from post._error import Unreadable

INSTALL = (
    "install one: apt install libegl1 libgl1 libosmesa6 libxrender1 (Debian, Ubuntu); "
    "dnf install mesa-libEGL mesa-libOSMesa libXrender (Fedora, Rocky); "
    "conda install -c conda-forge mesalib (no root needed)"
)
PROBE = """from vtkmodules.vtkRenderingCore import vtkRenderWindow
import vtkmodules.vtkRenderingOpenGL2
window = vtkRenderWindow()
window.SetOffScreenRendering(1)
window.Render()
"""


def reason_not_ready():
    """The reason why nothing can be rendered, as one sentence, or None if rendering works.

    The libraries are looked for first, because VTK ends the process if it cannot open a window.
    """
    try:
        import vtkmodules  # noqa: F401
    except ImportError:
        return "the Python package 'vtk' is not installed: .venv/bin/pip install -r post/requirements.txt"
    try:
        import vtkmodules.vtkRenderingOpenGL2  # noqa: F401
    except ImportError as error:
        return f"VTK cannot load its OpenGL part ({error}); {INSTALL}"
    if not sys.platform.startswith("linux") or _osmesa():  # VTK falls back on OSMesa
        return None
    if not (_loads("libEGL.so.1") or os.environ.get("DISPLAY")):
        return f"pictures need EGL or OSMesa, and neither is installed; {INSTALL}"
    if not _renders():
        return f"EGL is installed but cannot draw (no driver), and OSMesa is missing; {INSTALL}"
    return None


@functools.cache
def _renders():
    """Whether a picture can be drawn; a separate process tries it."""
    return subprocess.run([sys.executable, "-c", PROBE], capture_output=True).returncode == 0


def prepare():
    """Make VTK render without a display or messages; raise Unreadable if it cannot."""
    reason = reason_not_ready()
    if reason:
        raise Unreadable(reason)
    from vtkmodules.vtkCommonCore import vtkLogger

    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_ERROR)


def _osmesa():
    return any(_loads(name) for name in ("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"))


def _loads(name):
    try:
        ctypes.CDLL(name)
        return True
    except OSError:
        return False
