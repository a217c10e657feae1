"""Makes ROS 2's Python packages importable: in this process, and in those that it starts.

Two things are put in place: the folder ``site`` at the end of ``sys.path``, and the finder of
message packages at the end of ``sys.meta_path``. So a package that is really installed wins, each
as a whole: from a sourced ROS 2, a virtual environment, or the current folder.

Processes of the same Python inherit this through ``PYTHONPATH``, which names a folder with nothing
but a ``sitecustomize``. It cannot name ``site`` itself: what stands there comes before all that is
installed.
"""

from __future__ import annotations

import os
import sys

_HERE = os.path.dirname(os.path.abspath(__file__))  # noqa: PTH100, PTH120 -- no Path at start-up

SITE = os.path.join(_HERE, "site")  # noqa: PTH118
"""The folder of ``rclpy``, ``tf2_ros`` and the like."""

START_HOOK = os.path.join(_HERE, "start_hook")  # noqa: PTH118
"""The folder of the ``sitecustomize`` that activates each Python started with it."""

PROGRAMS = os.path.join(_HERE, "programs")  # noqa: PTH118
"""The folder of ``ros2``, ``teleopctl`` and ``xacro``, as programs that stand for ours."""


def activate() -> None:
    """Make ROS 2's Python packages importable in this process. Idempotent.

    These are ``rclpy``, ``tf2_ros`` and others, and all message packages. Packages that are really
    installed take precedence.

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

    The interpreters among them that have no teleopctl are left as they are.
    """
    set_variables()
    inherited = os.environ.get("PYTHONPATH", "")
    if START_HOOK not in inherited.split(os.pathsep):
        # In front of any other sitecustomize, which ours runs when it is done.
        os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, (START_HOOK, inherited)))


def set_variables() -> None:
    """Set the environment variables of a sourced ROS 2, for this process and its children.

    Idempotent.

    Our programs stand at the end of ``PATH``: one that is installed is found before.
    """
    os.environ.setdefault("ROS_VERSION", "2")
    os.environ.setdefault("ROS_PYTHON_VERSION", "3")
    if not os.environ.get("ROS_DISTRO"):
        from teleopctl.interfaces import distribution

        os.environ["ROS_DISTRO"] = distribution()
    os.environ["TELEOPCTL_PYTHON"] = sys.executable
    path = os.environ.get("PATH", os.defpath)
    if PROGRAMS not in path.split(os.pathsep):
        os.environ["PATH"] = os.pathsep.join(filter(None, (path, PROGRAMS)))
