"""What the joints of a robot may do and which follow others: the only place to ask.

Whoever limits, moves, simulates or shows joints takes them from here; `joint_rules` decides.
Radians or metres, and their derivatives; effort in N m or N.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot.joint_rules import JointLimits, joint_limits, resolve_mimics
from teleopctl.robot.urdf import Mimic

if TYPE_CHECKING:
    from teleopctl.robot.description import RobotDescription
    from teleopctl.robot.urdf import Joint


@dataclass(frozen=True, slots=True)
class JointModel:
    """A joint that moves along or about one axis.

    Attributes:
        joint: How the URDF has it.
        limits: What it may be commanded to.
        leaders: Joints that it follows, as `resolve_mimics` returns them; none for most.
    """

    joint: Joint
    limits: JointLimits
    leaders: tuple[Mimic, ...] = ()

    @property
    def mimic(self) -> Mimic | None:
        """Mimic relation to the independent joint that the joint follows in the end."""
        return self.leaders[-1] if self.leaders else None


class Joints(Mapping[str, JointModel]):
    """Joints of a robot that move along or about one axis, in the URDF's order.

    Args:
        joints: All joints of the URDF by name.
        limits: What has been decided for joints in ``<ros2_control>``; the URDF says the rest.
        mimics: What each following joint follows directly.

    Raises:
        InvalidDescriptionError: As `resolve_mimics` does.
    """

    def __init__(
        self,
        joints: Mapping[str, Joint],
        limits: Mapping[str, JointLimits],
        mimics: Mapping[str, Mimic],
    ) -> None:
        self._joints = joints
        leaders = resolve_mimics(joints, mimics)
        self._models = {
            name: JointModel(
                joint, limits.get(name) or joint_limits(joint, {}, []), leaders.get(name, ())
            )
            for name, joint in joints.items()
            if joint.is_single_axis
        }
        self._followers = [
            (name, model.leaders) for name, model in self._models.items() if model.leaders
        ]

    def __getitem__(self, name: str) -> JointModel:
        return self._models[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._models)

    def __len__(self) -> int:
        return len(self._models)

    @classmethod
    def of(cls, description: RobotDescription) -> Joints:
        """Return the joints with the limits and mimics of URDF and ``<ros2_control>``.

        Raises:
            InvalidDescriptionError: When ``<ros2_control>`` is wrong.
        """
        limits, controlled = _in_control(description)
        own = {
            name: joint.mimic
            for name, joint in description.joints.items()
            if joint.mimic is not None and name not in limits
        }
        return cls(description.joints, limits, {**own, **controlled})

    @classmethod
    def for_display(cls, description: RobotDescription, warn: Callable[[str], object]) -> Joints:
        """Return the joints for display, which ignores faults of ``<ros2_control>``.

        They differ from `of` in two points: an unusable ``<ros2_control>`` is reported and passed
        over, and a ``<mimic>`` holds even where ``mimic="false"`` switches it off in control,
        which is how ``robot_state_publisher`` and ``joint_state_publisher`` have it in ROS 2.

        Args:
            description: The robot.
            warn: Receives a sentence about what is passed over.
        """
        own = {
            name: joint.mimic
            for name, joint in description.joints.items()
            if joint.mimic is not None
        }
        try:
            limits, controlled = _in_control(description)
            return cls(description.joints, limits, {**controlled, **own})
        except InvalidDescriptionError as error:
            warn(f"Joints are shown without what <ros2_control> says of them: {error.message}")
            return cls(description.joints, {}, own)

    @property
    def mimics(self) -> dict[str, Mimic]:
        """Return the direct mimic relation of each mimic joint."""
        return {name: leaders[0] for name, leaders in self._followers}

    def with_mimics(self, mimics: Mapping[str, Mimic]) -> Joints:
        """Return the same joints with these mimic relations.

        Raises:
            InvalidDescriptionError: As `resolve_mimics` does.
        """
        limits = {name: model.limits for name, model in self.items()}
        return Joints(self._joints, limits, mimics)

    def positions(self, given: Mapping[str, float]) -> dict[str, float]:
        """Return positions completed by those of mimic joints.

        A position that is given stays, because it was measured. Any other following joint stands
        where its nearest leader with a position puts it. Nothing is said of the rest.

        Args:
            given: Positions by joint; for every independent joint, the result has all joints.
        """
        complete = dict(given)
        for name, leaders in self._followers:
            if name in given:
                continue
            for mimic in leaders:
                # a joint that cannot move, such as a fixed one, stands at zero
                leader = given.get(mimic.joint, None if mimic.joint in self._models else 0.0)
                if leader is not None:
                    complete[name] = mimic.multiplier * leader + mimic.offset
                    break
        return complete


def _in_control(description: RobotDescription) -> tuple[dict[str, JointLimits], dict[str, Mimic]]:
    """Limits of the joints in ``<ros2_control>``, and what those follow that follow another."""
    limits: dict[str, JointLimits] = {}
    mimics: dict[str, Mimic] = {}
    for component in description.ros2_control:
        for part in component.joints:
            limits[part.name] = part.limits
            if part.leaders:
                mimics[part.name] = part.leaders[0]
    return limits, mimics
