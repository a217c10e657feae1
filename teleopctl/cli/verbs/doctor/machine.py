"""Checks of this machine: packages, drawing, memory that processes share, variables."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator

from teleopctl.cli.verbs.doctor.finding import Finding, warning
from teleopctl.errors import TeleopctlError

# In a process of its own, since drivers that do not fit end the one that tries them.
_DRAW = """
import sys
from teleopctl.errors import TeleopctlError
from teleopctl.sim import check_drawing, choose_backend
try:
    choose_backend()
    check_drawing()
except TeleopctlError as error:
    sys.exit(f"{error.message}\\n{error.hint or ''}")
"""


def check_packages() -> Iterator[Finding]:
    """Yield packages that cannot be read."""
    from teleopctl.packages import faults_of_search, list_packages

    list_packages()
    yield from map(warning, faults_of_search())


def check_drawing() -> Iterator[Finding]:
    """Yield why cameras cannot be rendered, if so."""
    tried = subprocess.run(
        [sys.executable, "-P", "-c", _DRAW], capture_output=True, text=True, check=False
    )
    if tried.returncode != 0:
        text, _, hint = tried.stderr.strip().partition("\n")
        if tried.returncode < 0:
            text = f"Drawing ends a process by signal {-tried.returncode}"
        yield warning(f"{text}; cameras will have no pictures.", hint)


def check_shared_memory() -> Iterator[Finding]:
    """Yield why shared memory is not usable, if so."""
    from teleopctl.wire import has_room_for_shared_memory

    if not has_room_for_shared_memory():
        yield warning(
            "/dev/shm has little room: pictures are copied between processes.",  # noqa: S108
            "In a container: docker run --shm-size=1g …",
        )


def check_environment() -> Iterator[Finding]:
    """Yield the environment variables of ROS 2 that have another meaning or no effect here."""
    asked = os.environ.get("RMW_IMPLEMENTATION", "")
    if asked not in ("", "rmw_zenoh_cpp"):
        yield warning(
            f"RMW_IMPLEMENTATION={asked}: nodes of ROS 2 that use it do not meet those of here.",
            "Start them with RMW_IMPLEMENTATION=rmw_zenoh_cpp.",
        )
    try:
        from teleopctl.interfaces import known_types
        from teleopctl.wire import domain_id

        domain_id()
        known_types()
    except TeleopctlError as error:
        yield Finding(error.message, error.hint or "")
