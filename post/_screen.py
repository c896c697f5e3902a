"""Rendering without a screen: which OpenGL library is there, and what to install where none is."""

import ctypes
import os

from post._error import Unreadable

INSTALL = (
    "install one: apt install libegl1 libgl1 libosmesa6 libxrender1 (Debian, Ubuntu); "
    "dnf install mesa-libEGL mesa-libOSMesa libXrender (Fedora, Rocky); "
    "conda install -c conda-forge mesalib (no root needed)"
)


def reason_not_ready():
    """Why nothing can be rendered here, as one sentence, or None where it can.

    Looks only whether libraries load: creating a window without any ends the process in some
    versions of VTK.
    """
    try:
        import vtkmodules  # noqa: F401
    except ImportError:
        return "the Python package 'vtk' is not installed: .venv/bin/pip install -r post/requirements.txt"
    if not any(_loads(name) for name in ("libEGL.so.1", "libOSMesa.so.8", "libOSMesa.so")):
        return f"pictures need EGL or OSMesa, and neither is on this machine; {INSTALL}"
    try:
        import vtkmodules.vtkRenderingOpenGL2  # noqa: F401
    except ImportError as error:
        return f"VTK cannot load its OpenGL part ({error}); {INSTALL}"
    return None


def prepare():
    """Make VTK render without a display and without chatter; raises Unreadable where it cannot."""
    reason = reason_not_ready()
    if reason:
        raise Unreadable(reason)
    if not os.environ.get("DISPLAY") and "VTK_DEFAULT_OPENGL_WINDOW" not in os.environ:
        kind = "vtkEGLRenderWindow" if _loads("libEGL.so.1") else "vtkOSOpenGLRenderWindow"
        os.environ["VTK_DEFAULT_OPENGL_WINDOW"] = kind
    from vtkmodules.vtkCommonCore import vtkLogger

    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_ERROR)


def _loads(name):
    try:
        ctypes.CDLL(name)
        return True
    except OSError:
        return False
