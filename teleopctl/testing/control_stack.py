"""The control stack without ROS, of `teleopctl.control`, where tests look for it."""

from __future__ import annotations

from teleopctl.control import (
    ControlStack as ControlStack,
    RecordedActionServer as RecordedActionServer,
    RecordedEndpoint as RecordedEndpoint,
    RecordedLog as RecordedLog,
    RecordedNode as RecordedNode,
)
