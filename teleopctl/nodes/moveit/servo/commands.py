"""Commands as servo receives them: which is the newest, how old it is, and what it asks for."""

from __future__ import annotations

import enum
import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from teleopctl.kinematics import pose_matrix
from teleopctl.tf import Transform, normalize


class ServoCommandType(enum.IntEnum):
    """Values of ``moveit_msgs/srv/ServoCommandType``."""

    JOINT_JOG = 0
    TWIST = 1
    POSE = 2


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


class ServoCommandError(Exception):
    """A command cannot be obeyed; the text says why."""


def finite(values: Sequence[float], what: str) -> np.ndarray:
    """Return numbers as an array; raise `ServoCommandError` if one is not finite."""
    numbers = np.array(values, np.float64)
    if not np.isfinite(numbers).all():
        raise ServoCommandError(f"{what} has a value that is not a finite number")
    return numbers


# Any: message classes are generated at run time from definitions.
def twist_of(message: Any, *, unitless: bool, linear: float, rotational: float) -> np.ndarray:
    """Return the twist of a TwistStamped, (6,), m/s and rad/s, at most as fast as the limits.

    Args:
        message: The message.
        unitless: Whether its values are parts of the limits, -1 to 1.
        linear: Largest linear speed, m/s.
        rotational: Largest angular speed, rad/s.

    Raises:
        ServoCommandError: A value is not finite.
    """
    parts = []
    for vector, most in ((message.twist.linear, linear), (message.twist.angular, rotational)):
        values = finite((vector.x, vector.y, vector.z), "The twist")
        if unitless:
            values = np.clip(values, -1.0, 1.0) * most
        else:
            speed = float(np.linalg.norm(values))
            values = values * (most / speed) if speed > most else values
        parts.append(values)
    return np.concatenate(parts)


# Any: as above.
def pose_of(message: Any) -> np.ndarray:
    """Return the pose of a PoseStamped in the frame of its header, (4, 4).

    Raises:
        ServoCommandError: A value is not finite, or the quaternion is zero.
    """
    position, turn = message.pose.position, message.pose.orientation
    finite((position.x, position.y, position.z, turn.x, turn.y, turn.z, turn.w), "The pose")
    length = math.sqrt(turn.x**2 + turn.y**2 + turn.z**2 + turn.w**2)
    if length < 1e-6:
        raise ServoCommandError("The pose has a quaternion of zeros, which is no rotation")
    rotation = normalize((turn.x, turn.y, turn.z, turn.w))
    return pose_matrix(Transform((position.x, position.y, position.z), rotation))
