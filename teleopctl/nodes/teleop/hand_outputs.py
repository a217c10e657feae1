"""Outputs of an operator's commands: topics of a servo node, or of a mobile base."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from teleopctl.interfaces import get_message, get_service, set_stamp
from teleopctl.node import Node
from teleopctl.nodes.teleop.driven_robot import DrivenArm, DrivenRobot
from teleopctl.teleop import HandCommand
from teleopctl.tf import Transform

_DEPTH = 10
# Values of moveit_msgs/srv/ServoCommandType.
_JOINT_JOG, _TWIST, _POSE = 0, 1, 2
_TWISTS = ("geometry_msgs/msg/TwistStamped", "geometry_msgs/msg/Twist")
_CMD_VEL = "cmd_vel"
# Full speeds of a mobile base, m/s and rad/s: those of teleop_twist_keyboard.
_BASE_SPEEDS = {"linear": 0.5, "rotational": 1.0}

# Any, here and below: message classes are generated at run time from definitions.


class ServoOutput:
    """Publishes commands to the topics of a servo node, stamped and in a frame.

    Args:
        node: Node of the endpoints.
        servo: Full name of the servo node.
        robot: The robot that it moves.
    """

    def __init__(self, node: Node, servo: str, robot: DrivenRobot) -> None:
        self._node, self._servo, self._robot = node, servo, robot
        self._twist: Any = get_message("geometry_msgs/msg/TwistStamped")()
        self._pose: Any = get_message("geometry_msgs/msg/PoseStamped")()
        self._jog: Any = get_message("control_msgs/msg/JointJog")()
        self._poses = node.create_publisher(type(self._pose), f"{servo}/pose_target_cmds", _DEPTH)
        self._twists = node.create_publisher(type(self._twist), f"{servo}/delta_twist_cmds", _DEPTH)
        self._jogs = node.create_publisher(type(self._jog), f"{servo}/delta_joint_cmds", _DEPTH)
        self._kind = get_service("moveit_msgs/srv/ServoCommandType")
        self._switch = node.create_client(self._kind, f"{servo}/switch_command_type")
        self._chosen: int | None = None
        self._was_jog = False
        # What the twist was made from.
        self._made_from: tuple[object, ...] = ()

    @property
    def problem(self) -> str:
        """Reason why nothing moves; empty if a servo node subscribes."""
        if self._twists.get_subscription_count():
            return ""
        return (
            f"Nothing moves the arm, since {self._servo} does not run: start it with "
            "teleopctl launch servo.yaml"
        )

    def _choose(self, kind: int, *, begins: bool) -> None:
        """Set servo's command type at the start of a motion; other nodes may have changed it."""
        if (kind != self._chosen or begins) and self._switch.service_is_ready():
            self._chosen = kind
            self._switch.call_async(self._kind.Request(command_type=kind))

    def _stamp(self, message: Any) -> None:
        set_stamp(message.header.stamp, self._node.get_clock().nanoseconds())

    def move(self, command: HandCommand, part: float, frame: str, *, begins: bool) -> None:
        """Publish a twist of the tool.

        Args:
            command: The operator's command.
            part: Part of servo's speeds.
            frame: ``base`` for the axes of the root link, ``tip`` for those of the gripper.
            begins: Whether a motion begins with it.
        """
        arm = self._robot.arm
        if arm is None:
            return
        self._was_jog = False
        self._choose(_TWIST, begins=begins)
        scales, is_unitless = self._robot.scales, self._robot.is_unitless
        of_linear = part * (1.0 if is_unitless else scales["linear"])
        of_angular = part * (1.0 if is_unitless else scales["rotational"])
        # An input that is held gives the same twist again and again.
        made_from = (command, of_linear, of_angular, frame, arm)
        if made_from != self._made_from:
            self._made_from = made_from
            linear, angular = command.linear, command.angular
            if frame == "base":
                linear, angular = arm.in_root(linear), arm.in_root(angular)
            self._twist.header.frame_id = arm.root if frame == "base" else arm.tip
            _fill(self._twist.twist.linear, linear, of_linear)
            _fill(self._twist.twist.angular, angular, of_angular)
        self.repeat()

    def repeat(self) -> None:
        """Publish the last twist again, with a new stamp."""
        self._stamp(self._twist)
        self._twists.publish(self._twist)

    def halt(self) -> None:
        """Publish zero motion, as commands of the last type."""
        arm = self._robot.arm
        if arm is not None and self._was_jog:
            self._publish_jog(arm, dict.fromkeys(arm.joints, 0.0))
        else:
            self.move(HandCommand(), 0.0, "base", begins=False)

    def pull(self, target: Transform, *, begins: bool) -> None:
        """Publish a pose of the tool, in the frame of the root link."""
        arm = self._robot.arm
        if arm is None:
            return
        self._was_jog = False
        self._choose(_POSE, begins=begins)
        self._stamp(self._pose)
        self._pose.header.frame_id, pose = arm.root, self._pose.pose
        pose.position.x, pose.position.y, pose.position.z = target.translation
        orientation = pose.orientation
        orientation.x, orientation.y, orientation.z, orientation.w = target.rotation
        self._poses.publish(self._pose)

    def jog(self, displacements: Mapping[str, float], *, begins: bool) -> None:
        """Publish displacements of joints from where servo commands them, rad or m, by joint."""
        arm = self._robot.arm
        if arm is not None:
            self._choose(_JOINT_JOG, begins=begins)
            self._was_jog = True
            self._publish_jog(arm, displacements)

    def _publish_jog(self, arm: DrivenArm, displacements: Mapping[str, float]) -> None:
        jog = self._jog
        self._stamp(jog)
        jog.header.frame_id = arm.root
        jog.joint_names = list(displacements)
        jog.displacements = list(displacements.values())
        self._jogs.publish(jog)


class BaseOutput:
    """Publishes the velocity of a mobile base.

    Args:
        node: Node of the publisher.
        topic: Full name of the topic.
        type_name: Type of its messages, Twist or TwistStamped.

    Attributes:
        topic: Full name of the topic.
        scales: Full speeds: ``linear`` in m/s, ``rotational`` in rad/s.
    """

    def __init__(self, node: Node, topic: str, type_name: str) -> None:
        self._node, self.topic = node, topic
        self.scales = dict(_BASE_SPEEDS)
        self._message: Any = get_message(type_name)()
        self._is_stamped = type_name == _TWISTS[0]
        self._publisher = node.create_publisher(type(self._message), topic, _DEPTH)

    @classmethod
    def find(cls, node: Node, topic: str = "") -> BaseOutput | None:
        """Return the output to a topic that has subscribers; None if none has.

        Args:
            node: Node of the publisher.
            topic: Name of the topic; empty for one that is called ``cmd_vel``, also below a
                controller's name.
        """
        wanted = node.resolve_topic_name(topic) if topic else ""
        found = []
        for name, types in node.get_topic_names_and_types():
            last = name.rpartition("/")[2]
            is_it = name == wanted if wanted else last in (_CMD_VEL, f"{_CMD_VEL}_unstamped")
            if is_it and node.count_subscribers(name):
                found += [(len(name), name, each) for each in _TWISTS if each in types]
        if not found:
            return None
        _, name, type_name = min(found)
        return cls(node, name, type_name)

    @property
    def problem(self) -> str:
        """Reason why nothing moves; empty if a base subscribes."""
        if self._publisher.get_subscription_count():
            return ""
        return no_base(self.topic)

    def move(self, command: HandCommand, part: float) -> None:
        """Publish a velocity, in the axes of the base.

        Args:
            command: The operator's command.
            part: Part of the full speeds.
        """
        twist = self._message.twist if self._is_stamped else self._message
        _fill(twist.linear, command.linear, part * self.scales["linear"])
        _fill(twist.angular, command.angular, part * self.scales["rotational"])
        self.repeat()

    def repeat(self) -> None:
        """Publish the last velocity again, with a new stamp."""
        if self._is_stamped:
            set_stamp(self._message.header.stamp, self._node.get_clock().nanoseconds())
        self._publisher.publish(self._message)


def no_base(topic: str) -> str:
    """Return the text for a topic of velocities to which no base subscribes."""
    return f"no node subscribes to {topic}: does the base's controller run?"


# Any: a message geometry_msgs/msg/Vector3.
def _fill(vector: Any, values: tuple[float, float, float], factor: float) -> None:
    vector.x, vector.y, vector.z = (factor * value for value in values)
