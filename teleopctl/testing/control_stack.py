"""Control stack without ROS for tests, imported from `teleopctl.control`."""

from __future__ import annotations

from teleopctl.control import (
    ControlStack as ControlStack,
    RecordedActionServer as RecordedActionServer,
    RecordedEndpoint as RecordedEndpoint,
    RecordedLog as RecordedLog,
    RecordedNode as RecordedNode,
)
