"""Test tools for robot CI and for authors of plug-ins; with pytest, as fixtures.

`RosGraph` is a ROS graph in a box: processes whose lines, nodes and messages are waited for, and
launch files that are brought up in it. ``pytest_plugin`` offers it as fixtures; without pytest
everything here works as well. See docs/testing.md.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from teleopctl.lazy import attach

if TYPE_CHECKING:
    from teleopctl.testing.graph import RosGraph as RosGraph
    from teleopctl.testing.graph import free_port as free_port
    from teleopctl.testing.launched import LaunchedSystem as LaunchedSystem
    from teleopctl.testing.process import LONGEST_WAIT_S as LONGEST_WAIT_S
    from teleopctl.testing.process import Process as Process
    from teleopctl.testing.process import eventually as eventually
else:
    __getattr__, __all__ = attach(
        __name__,
        {
            "graph": "RosGraph free_port",
            "launched": "LaunchedSystem",
            "process": "LONGEST_WAIT_S Process eventually",
        },
    )
