"""Test tools for robot CI and for authors of plug-ins; with pytest, as fixtures.

`RosGraph` is an isolated ROS graph: it starts processes and launch files, and waits for output
lines, nodes and messages. `assert_bag_repeats` makes a test of a recorded session. `ControlStack`
runs controllers and hardware components cycle by cycle, without a ROS graph. ``pytest_plugin``
provides the fixtures; all tools also work without pytest. See docs/testing.md.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.testing.control_stack import (
        ControlStack as ControlStack,
        RecordedActionServer as RecordedActionServer,
        RecordedEndpoint as RecordedEndpoint,
        RecordedLog as RecordedLog,
        RecordedNode as RecordedNode,
    )
    from teleopctl.testing.graph import RosGraph as RosGraph, free_port as free_port
    from teleopctl.testing.launched import LaunchedSystem as LaunchedSystem
    from teleopctl.testing.process import (
        LONGEST_WAIT_S as LONGEST_WAIT_S,
        Process as Process,
        eventually as eventually,
    )
    from teleopctl.testing.replayed import assert_bag_repeats as assert_bag_repeats
    from teleopctl.testing.robots import serial_robot as serial_robot
else:
    from teleopctl.base.lazy import attach

    __getattr__, __dir__, __all__ = attach()
