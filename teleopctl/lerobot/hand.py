"""Teleoperation device that drives the robot while lerobot's programs run, and its actions."""

from __future__ import annotations

import contextlib
import signal
import subprocess
import sys

from teleopctl.errors import NotFoundError, UnavailableError
from teleopctl.lerobot.newest import FIRST_S
from teleopctl.node import Node

_REFERENCE = "control_msgs/msg/JointTrajectoryControllerState"
_PROGRAM = ("run", "teleop_device", "teleop_device")
_END_S = 5.0


class HandProcess:
    """Child process ``teleop_device``, which drives the robot through servo.

    Args:
        device: Name of the device.
        mapping: Name or file of its mapping; empty for its own.
    """

    def __init__(self, device: str, mapping: str = "") -> None:
        words = [sys.executable, "-m", "teleopctl", *_PROGRAM, device]
        if mapping:
            words += ["--mapping", mapping]
        self._process = subprocess.Popen(words)

    def check(self) -> None:
        """Raise an error if the process has ended; it has logged the reason.

        Raises:
            UnavailableError: The process has ended.
        """
        if (status := self._process.poll()) is not None:
            raise UnavailableError(f"The device has ended with status {status}: see above")

    def stop(self) -> None:
        """End the process, which releases the robot."""
        if self._process.poll() is None:
            # Windows has no interrupt for one process.
            with contextlib.suppress(ValueError):
                self._process.send_signal(signal.SIGINT)
            try:
                self._process.wait(_END_S)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()


def reference_topics(node: Node) -> list[str]:
    """Return the reference topics of the controllers, after waiting for one.

    Args:
        node: Node of the graph.

    Raises:
        NotFoundError: No controller does.
    """
    found: list[str] = []

    def are_there() -> bool:
        found[:] = [
            name
            for name, types in node.get_topic_names_and_types()
            if _REFERENCE in types and node.count_publishers(name)
        ]
        return bool(found)

    node.context.wait_for_change(are_there, FIRST_S)
    if not found:
        raise NotFoundError(
            "No controller publishes its references",
            hint="Start the robot and its controllers: teleopctl drive",
        )
    return sorted(found)
