"""Received commands of servo: the newest one, its age and its content."""

from __future__ import annotations

import enum
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from teleopctl.errors import UsageError
from teleopctl.kinematics import GroupKinematics, PoseTask
from teleopctl.node import MessageInfo

# Excess over 1 that is rounding of the sender.
_ROUNDING = 1e-6


class ServoCommandType(enum.IntEnum):
    """Values of ``moveit_msgs/srv/ServoCommandType``."""

    JOINT_JOG = 0
    TWIST = 1
    POSE = 2

    @property
    def text(self) -> str:
        """The kind in words."""
        return self.name.lower().replace("_", " ")


# Excess over the shortest transit time of a sender, s, at which a command is late; time with late
# commands alone, s, after which one of the clocks must have been set; drift of two clocks, s/s.
_LATE_S, _SET_S, _DRIFT = 0.5, 1.0, 1e-3
_MOST_SENDERS = 100


class LateCommands:
    """Detector of delayed commands, as after a suspended process or connection.

    They all arrive at once then, so that the time of receipt does not show their age. The clocks of
    sender and receiver may differ: transit times are compared with the shortest one of the sender.
    """

    def __init__(self) -> None:
        # By sender: shortest transit time, time of its last update, and since when all are late, s.
        self._senders: dict[bytes, tuple[float, float, float | None]] = {}

    def is_late(self, info: MessageInfo, now_ns: int) -> bool:
        """Return whether a command is too old to be executed.

        Args:
            info: Its metadata.
            now_ns: Present time in nanoseconds since the epoch. The time of receipt would leave out
                the wait in the node's own queue.
        """
        sender, now_s = info["publisher_gid"], now_ns * 1e-9
        transit_s = (now_ns - info["source_timestamp"]) * 1e-9
        if sender not in self._senders and len(self._senders) >= _MOST_SENDERS:
            self._senders.clear()
        shortest_s, known_s, since_s = self._senders.get(sender, (transit_s, now_s, None))
        shortest_s = min(transit_s, shortest_s + _DRIFT * (now_s - known_s))
        late = transit_s - shortest_s > _LATE_S
        since_s = (since_s or now_s) if late else None
        if since_s is not None and now_s - since_s > _SET_S:
            late, shortest_s, since_s = False, transit_s, None
        self._senders[sender] = (shortest_s, now_s, since_s)
        return late


def served(task: PoseTask, kinematics: GroupKinematics) -> str:
    """Return the directions of a twist that a group executes, in words."""
    if task is PoseTask.POSE:
        return "it serves all six directions"
    count = len(kinematics.names)
    return f"with {count} joints it serves the position, and of the rotation what is left"


@dataclass(slots=True)
class ServoCommand:
    """Newest command, with the time of its receipt.

    Attributes:
        type: Kind of command.
        message: The message: JointJog, TwistStamped or PoseStamped.
        received_s: Time of its receipt on the monotonic clock, s. The stamp says nothing about
            that: clocks of two machines differ, and simulated time may stand still.
    """

    type: ServoCommandType
    # Any: message classes are generated at run time from definitions.
    message: Any
    received_s: float

    @classmethod
    def of(cls, kind: ServoCommandType, message: object) -> ServoCommand:
        """Return a message that has just been received as a command."""
        return cls(kind, message, time.monotonic())

    def age_s(self) -> float:
        """Return the time since its receipt, s."""
        return time.monotonic() - self.received_s


def finite(values: Sequence[float], what: str) -> np.ndarray:
    """Return numbers as an array; raise `UsageError` if one is not finite."""
    numbers = np.array(values, np.float64)
    if not np.isfinite(numbers).all():
        raise UsageError(f"{what} has a value that is not a finite number")
    return numbers


def parts_of_limit(values: np.ndarray, what: str) -> np.ndarray:
    """Return unitless values; raise `UsageError` if one is not within -1 to 1.

    As in MoveIt Servo: the sender takes them for m/s or rad/s, or is broken.
    """
    if float(np.abs(values).max(initial=0.0)) > 1.0 + _ROUNDING:
        raise UsageError(
            f"{what} has the value {float(values[np.argmax(np.abs(values))]):g}: unitless commands "
            "are -1 to 1 (parameter moveit_servo.command_in_type)"
        )
    return np.asarray(np.clip(values, -1.0, 1.0), np.float64)


# Any: message classes are generated at run time from definitions.
def twist_of(message: Any, *, unitless: bool, linear: float, rotational: float) -> np.ndarray:
    """Return the twist of a TwistStamped, (6,), m/s and rad/s, at most as fast as the limits.

    Args:
        message: The message.
        unitless: Whether its values are parts of the limits, -1 to 1.
        linear: Largest linear speed, m/s.
        rotational: Largest angular speed, rad/s.

    Raises:
        UsageError: A value is not finite, or is more than 1 where it is a part of a limit.
    """
    parts = []
    for vector, most in ((message.twist.linear, linear), (message.twist.angular, rotational)):
        values = finite((vector.x, vector.y, vector.z), "The twist")
        if unitless:
            values = parts_of_limit(values, "The twist") * most
        else:
            speed = float(np.linalg.norm(values))
            values = values * (most / speed) if speed > most else values
        parts.append(values)
    return np.concatenate(parts)
