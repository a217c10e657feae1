"""Base class of teleoperation devices, and their samples: axes, buttons, pose or joints.

A device only emits samples. A `HandMapping` converts them to commands; limits,
collisions and stopping are servo's.
"""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from teleopctl.errors import TeleopctlError

if TYPE_CHECKING:
    from teleopctl.node import Node

STALE_S = 0.1
"""Age of a sample since its receipt from which all its inputs count as released, s."""


class DeviceError(TeleopctlError):
    """Error: a teleop device is missing, was taken away or cannot be used."""


@dataclass(frozen=True, slots=True)
class HandSample:
    """Sample of a teleoperation device at one time.

    Attributes:
        axes: Positions of sticks, triggers and pads by name, -1 to 1.
        buttons: Names of the buttons and keys that are pressed.
        pose: Position (m) and rotation (quaternion xyzw) of the device in a frame of its
            own; empty for a device without a pose. Only its changes count, see `PoseClutch`.
        joints: Positions of a leader's joints by name, rad or m; empty for other devices.
        sequence: Number of the sample, which grows.
        received_s: Time of its receipt on the monotonic clock, s.
    """

    axes: Mapping[str, float] = field(default_factory=dict)
    buttons: frozenset[str] = frozenset()
    pose: tuple[float, ...] = ()
    joints: Mapping[str, float] = field(default_factory=dict)
    sequence: int = 0
    received_s: float = field(default_factory=time.monotonic)

    def is_stale(self, now_s: float) -> bool:
        """Return whether the sample is too old to count, at a time on the monotonic clock, s."""
        return now_s - self.received_s > STALE_S


class TeleopDevice(ABC):
    """Base class of teleoperation devices; plug-ins of ``teleopctl.teleop_devices``.

    A device calls `emit` with each sample, at 50 Hz or more while something is held. It may emit
    the same object again while its inputs stay as they are. A device that falls silent counts as
    released after `STALE_S`.

    Args:
        node: Node in which the device runs, for its parameters, logger and subscriptions.
        emit: Function to call with each sample, from any thread.

    Attributes:
        mapping: The mapping that is used unless another one is given: the name of one that comes
            with teleopctl, or the path of a file.
        gives_joints: Whether its samples have joints, as those of a leader arm.
        reads_terminal: Whether it reads the keys of the terminal.
        help: Instructions for the operator, printed in the terminal in which it runs.
    """

    mapping: ClassVar[str | Path] = ""
    gives_joints: ClassVar[bool] = False
    reads_terminal: ClassVar[bool] = False
    help: ClassVar[str] = ""

    def __init__(self, node: Node, emit: Callable[[HandSample], object]) -> None:
        self.node = node
        self.emit = emit

    @classmethod  # noqa: B027 -- a device may be there at all times
    def check(cls) -> None:
        """Check that the device is there, before a robot is started for it.

        Raises:
            DeviceError: There is no such device, or it cannot be chosen without parameters.
        """

    @abstractmethod
    def start(self) -> None:
        """Open the device and begin to emit samples.

        Raises:
            DeviceError: There is no such device, or it cannot be used.
        """

    def inputs(self) -> frozenset[str]:
        """Return the names of the device's axes and buttons, for mappings; empty if unknown."""
        return frozenset()

    def stop(self) -> None:  # noqa: B027 -- a device may have nothing to close
        """Close the device; it emits no more samples."""
