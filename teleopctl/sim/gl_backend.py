"""Choice of MuJoCo's OpenGL backend for rendering without a window.

mujoco reads ``MUJOCO_GL`` once, at import. On Linux rendering needs no display: EGL draws on a
GPU or with Mesa's software rasteriser, OSMesa in software only. Other platforms need no choice.
"""

from __future__ import annotations

import ctypes
import os
import sys

from teleopctl.errors import TeleopctlError, UnavailableError

_LIBRARIES = {"egl": "libEGL.so.1", "osmesa": "libOSMesa.so.8"}

INSTALL_HINT = (
    "On Debian and Ubuntu: apt install libegl1 libgl1-mesa-dri (or libosmesa6, with "
    "MUJOCO_GL=osmesa)"
)


def choose_backend() -> str:
    """Set ``MUJOCO_GL`` to an installed backend unless already set; return the backend's name.

    Returns:
        The backend: ``egl``, ``osmesa`` or the user's choice; empty where the
        platform has its own.

    Raises:
        TeleopctlError: If Linux has no library to draw with; the hint names the packages.
        RuntimeError: mujoco is already imported, and has chosen a backend itself.
    """
    requested = os.environ.get("MUJOCO_GL", "").lower()
    if requested or not sys.platform.startswith("linux"):
        return requested
    if "mujoco" in sys.modules:
        raise RuntimeError("mujoco was imported before the choice of its OpenGL backend")
    for backend, library in _LIBRARIES.items():
        if _is_there(library):
            os.environ["MUJOCO_GL"] = backend
            return backend
    raise missing_library("neither libEGL nor libOSMesa is installed")


def missing_library(reason: object) -> TeleopctlError:
    """Return the error for a machine on which no OpenGL library can be used.

    Args:
        reason: Error text of what failed.
    """
    first_line = str(reason).strip().splitlines()[0] if str(reason).strip() else "no OpenGL"
    return UnavailableError(
        f"Cannot render, a system library for drawing is missing: {first_line}",
        hint=INSTALL_HINT,
    )


def check_drawing() -> None:
    """Create and free an OpenGL context of the chosen backend; raise if that is not possible.

    To import the backend is not enough: only a context reveals a library without a driver.

    Raises:
        TeleopctlError: If the backend's library is missing or unusable.
    """
    try:
        import mujoco

        context = mujoco.GLContext(16, 16)
        context.make_current()
        context.free()
    except (ImportError, AttributeError, OSError, RuntimeError) as error:
        if isinstance(error, ModuleNotFoundError) and error.name == "mujoco":
            raise
        # For a missing library, PyOpenGL accesses an attribute of None.
        backend = os.environ.get("MUJOCO_GL", "").lower()
        library = _LIBRARIES.get(backend, "OpenGL")
        raise missing_library(f"{library} cannot be used ({error})") from error


def _is_there(library: str) -> bool:
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True
