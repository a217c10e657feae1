"""Makes ROS 2's Python packages importable: in this process, and in those that it starts.

The folder ``site`` is appended to ``sys.path``, and the finder of message packages to
``sys.meta_path``. So a really installed package has precedence, each as a whole: from a sourced
ROS 2, a virtual environment, or the current folder.

Processes of the same Python inherit this through ``PYTHONPATH``, which has a folder that contains
only a ``sitecustomize``. ``PYTHONPATH`` cannot contain ``site`` itself, since its folders come
before all installed packages.
"""

from __future__ import annotations

import os
import sys

from teleopctl.errors import SystemFailureError

_HERE = os.path.dirname(os.path.abspath(__file__))  # noqa: PTH100, PTH120 -- no Path at start-up

SITE = os.path.join(_HERE, "site")  # noqa: PTH118
"""Folder with ``rclpy``, ``tf2_ros`` and other packages."""

START_HOOK = os.path.join(_HERE, "start_hook")  # noqa: PTH118
"""Folder with the ``sitecustomize`` that makes the packages importable in child processes."""

PROGRAMS = os.path.join(_HERE, "programs")  # noqa: PTH118
"""Folder with the programs that start teleopctl: ``ros2``, ``launch_test``, ``xacro`` and so on."""

# Search paths that a sourced ROS 2 with Gazebo always sets: launch files read them, and append to
# them, without asking whether they are there.
_PATHS = ("LD_LIBRARY_PATH", "GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH")


def activate() -> None:
    """Make ROS 2's Python packages importable in this process. Idempotent.

    The packages are ``rclpy``, ``tf2_ros`` and others, and all message packages. Really installed
    packages have precedence.

    Example:
        >>> activate()
        >>> from geometry_msgs.msg import Point
        >>> Point(x=1.0)
        geometry_msgs.msg.Point(x=1.0, y=0.0, z=0.0)
    """
    from teleopctl.compat import finder

    if SITE not in sys.path:
        sys.path.append(SITE)
    finder.install()


def activate_children() -> None:
    """Make ROS 2's Python packages importable in child processes, as sourcing does. Idempotent.

    Python interpreters without teleopctl are not affected.
    """
    set_variables()
    inherited = os.environ.get("PYTHONPATH", "")
    if START_HOOK not in inherited.split(os.pathsep):
        # Before any other sitecustomize, which the hook's sitecustomize imports.
        os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, (START_HOOK, inherited)))


def set_variables() -> None:
    """Set the environment variables of a sourced ROS 2, for this process and its children.

    Idempotent. teleopctl's programs are at the end of ``PATH``, so that installed programs of the
    same names have precedence, and its packages at the end of ``AMENT_PREFIX_PATH``. Paths of
    libraries and of Gazebo's models are empty unless set.
    """
    os.environ.setdefault("ROS_VERSION", "2")
    os.environ.setdefault("ROS_PYTHON_VERSION", "3")
    for name in _PATHS:
        os.environ.setdefault(name, "")
    if not os.environ.get("ROS_DISTRO"):
        from teleopctl.interfaces import distribution

        os.environ["ROS_DISTRO"] = distribution()
    os.environ["TELEOPCTL_PYTHON"] = sys.executable
    _append("PATH", PROGRAMS, os.defpath)
    from teleopctl.packages import own_prefix

    try:
        prefix = str(own_prefix())
    except SystemFailureError:  # no folder to write to: named where the files of a package are used
        return
    _append("AMENT_PREFIX_PATH", prefix)


def _append(variable: str, folder: str, default: str = "") -> None:
    """Append a folder to a variable with a search path, unless it is there."""
    path = os.environ.get(variable, default)
    if folder not in path.split(os.pathsep):
        os.environ[variable] = os.pathsep.join(filter(None, (path, folder)))
