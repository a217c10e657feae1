"""Transmissions between the actuators and the joints of a robot, as in transmission_interface.

Positions are in rad or m, efforts in N m or N. In the formulas, a1 and a2 are values of the
actuators and n their reductions, j1 and j2 values of the joints, m their reductions and o their
offsets. Efforts follow from the velocities: both sides have the same power.
Source: transmission_interface of ros2_control.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, ClassVar

from teleopctl.errors import InvalidDescriptionError

if TYPE_CHECKING:
    from teleopctl.robot.ros2_control_tag import TransmissionEnd, TransmissionInfo

_POSITIONS = ("position", "absolute_position")
_VELOCITY = "velocity"
_EFFORTS = ("effort", "torque", "force")

Values = tuple[float, ...]


class Transmission(ABC):
    """Transmission between actuators and joints, both in the order of their roles.

    Args:
        actuator_reductions: Reduction of each actuator, not 0.
        joint_reductions: Reduction of each joint, not 0.
        joint_offsets: Position of each joint when its actuators are at 0, rad or m.

    Raises:
        InvalidDescriptionError: A reduction is 0, or a number of values is wrong.
    """

    size: ClassVar[int]
    quantities: ClassVar[tuple[str, ...]] = (*_POSITIONS, _VELOCITY, *_EFFORTS)

    def __init__(
        self,
        actuator_reductions: Sequence[float],
        joint_reductions: Sequence[float],
        joint_offsets: Sequence[float],
    ) -> None:
        counts = {len(actuator_reductions), len(joint_reductions), len(joint_offsets)}
        if counts != {self.size}:
            raise InvalidDescriptionError(
                f"A {type(self).__name__} has {self.size} actuators and {self.size} joints, not "
                f"{len(actuator_reductions)} and {len(joint_reductions)}"
            )
        if 0.0 in (*actuator_reductions, *joint_reductions):
            raise InvalidDescriptionError("Transmission reduction ratios cannot be zero.")
        self._n, self._m = tuple(actuator_reductions), tuple(joint_reductions)
        self._offsets = tuple(joint_offsets)

    def actuator_to_joint(self, quantity: str, values: Sequence[float]) -> Values:
        """Return the joints' values of a quantity such as ``position`` for those of actuators."""
        if quantity in _EFFORTS:
            return self._joint_efforts(values)
        moved = self._joint_motions(values)
        if quantity in _POSITIONS:
            return tuple(value + offset for value, offset in zip(moved, self._offsets, strict=True))
        return moved

    def joint_to_actuator(self, quantity: str, values: Sequence[float]) -> Values:
        """Return the actuators' values of a quantity such as ``position`` for those of joints."""
        if quantity in _EFFORTS:
            return self._actuator_efforts(values)
        if quantity in _POSITIONS:
            values = [value - offset for value, offset in zip(values, self._offsets, strict=True)]
        return self._actuator_motions(values)

    @property
    def is_direct(self) -> bool:
        """Whether joints and actuators have the same values."""
        return False

    @abstractmethod
    def _joint_motions(self, values: Sequence[float]) -> Values:
        """Return the joints' velocities for those of the actuators."""

    @abstractmethod
    def _actuator_motions(self, values: Sequence[float]) -> Values:
        """Return the actuators' velocities for those of the joints."""

    @abstractmethod
    def _joint_efforts(self, values: Sequence[float]) -> Values:
        """Return the joints' efforts for those of the actuators."""

    @abstractmethod
    def _actuator_efforts(self, values: Sequence[float]) -> Values:
        """Return the actuators' efforts for those of the joints."""


class SimpleTransmission(Transmission):
    """Gear between one actuator and one joint: j = a / m + o; effort j = a m.

    Type ``transmission_interface/SimpleTransmission``. The reduction is the joint's.
    """

    size = 1

    @property
    def is_direct(self) -> bool:
        """Whether the joint has the values of its actuator: reduction 1 and offset 0."""
        return self._m == (1.0,) and self._offsets == (0.0,)

    def _joint_motions(self, values: Sequence[float]) -> Values:
        return (values[0] / self._m[0],)

    def _actuator_motions(self, values: Sequence[float]) -> Values:
        return (values[0] * self._m[0],)

    def _joint_efforts(self, values: Sequence[float]) -> Values:
        return (values[0] * self._m[0],)

    def _actuator_efforts(self, values: Sequence[float]) -> Values:
        return (values[0] / self._m[0],)


class DifferentialTransmission(Transmission):
    """Differential, as in wrists: two actuators move one joint by their sum, one by the difference.

    Type ``transmission_interface/DifferentialTransmission``:
    j1 = (a1 / n1 + a2 / n2) / (2 m1) + o1; j2 = (a1 / n1 - a2 / n2) / (2 m2) + o2.
    """

    size = 2

    def _joint_motions(self, values: Sequence[float]) -> Values:
        first, second = values[0] / self._n[0], values[1] / self._n[1]
        return (first + second) / (2.0 * self._m[0]), (first - second) / (2.0 * self._m[1])

    def _actuator_motions(self, values: Sequence[float]) -> Values:
        first, second = values[0] * self._m[0], values[1] * self._m[1]
        return (first + second) * self._n[0], (first - second) * self._n[1]

    def _joint_efforts(self, values: Sequence[float]) -> Values:
        first, second = values[0] * self._n[0], values[1] * self._n[1]
        return (first + second) * self._m[0], (first - second) * self._m[1]

    def _actuator_efforts(self, values: Sequence[float]) -> Values:
        first, second = values[0] / self._m[0], values[1] / self._m[1]
        return (first + second) / (2.0 * self._n[0]), (first - second) / (2.0 * self._n[1])


class FourBarLinkageTransmission(Transmission):
    """Four-bar linkage: the second actuator is not on the first joint and must follow its motion.

    Type ``transmission_interface/FourBarLinkageTransmission``:
    j1 = a1 / (m1 n1) + o1; j2 = (a2 / n2 - a1 / (m1 n1)) / m2 + o2.
    """

    size = 2
    quantities = ("position", _VELOCITY, "effort")

    def _joint_motions(self, values: Sequence[float]) -> Values:
        first = values[0] / (self._m[0] * self._n[0])
        return first, (values[1] / self._n[1] - first) / self._m[1]

    def _actuator_motions(self, values: Sequence[float]) -> Values:
        return (
            values[0] * self._m[0] * self._n[0],
            (values[0] + values[1] * self._m[1]) * self._n[1],
        )

    def _joint_efforts(self, values: Sequence[float]) -> Values:
        second = values[1] * self._n[1]
        return self._m[0] * self._n[0] * values[0] + second, self._m[1] * second

    def _actuator_efforts(self, values: Sequence[float]) -> Values:
        second = values[1] / self._m[1]
        return (values[0] - second) / (self._m[0] * self._n[0]), second / self._n[1]


_TYPES: Mapping[str, type[Transmission]] = {
    f"transmission_interface/{kind.__name__}": kind
    for kind in (SimpleTransmission, DifferentialTransmission, FourBarLinkageTransmission)
}


def ends_by_role(ends: Iterable[TransmissionEnd]) -> list[TransmissionEnd]:
    """Return joints or actuators in the order of their roles, ``joint1`` before ``joint2``.

    Ends that have the same role stay in the order of the description.
    """
    return sorted(ends, key=lambda end: end.role)


def make_transmission(info: TransmissionInfo) -> Transmission:
    """Return the transmission of a ``<transmission>`` tag, with its reductions and offsets.

    Raises:
        InvalidDescriptionError: Its type is unknown, a reduction is 0, or it has too many or too
            few joints or actuators.
    """
    kind = _TYPES.get(info.type)
    where = f"Transmission '{info.name}' (line {info.line} of the robot description)"
    if kind is None:
        raise InvalidDescriptionError(
            f"{where}: type '{info.type}' is unknown", hint=f"Known are {', '.join(_TYPES)}."
        )
    joints, actuators = ends_by_role(info.joints), ends_by_role(info.actuators)
    try:
        return kind(
            [end.mechanical_reduction for end in actuators],
            [end.mechanical_reduction for end in joints],
            [end.offset for end in joints],
        )
    except InvalidDescriptionError as error:
        raise InvalidDescriptionError(f"{where}: {error.message}") from error


def transmission_has_effect(info: TransmissionInfo) -> bool:
    """Return whether joints and actuators of a transmission have different values."""
    try:
        return not make_transmission(info).is_direct
    except InvalidDescriptionError:
        return True
