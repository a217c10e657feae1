"""Replay of robot_state_publisher, whose transforms follow from the recorded joint states."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from teleopctl.bag import ComparedStream, RecordedTopic
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import deserialize, get_message, serialize
from teleopctl.node import expand_name
from teleopctl.nodes.robot_state_publisher import JointTransforms, publish_interval_ns
from teleopctl.robot import Joints, RobotDescription, SegmentTree

JOINT_STATE = "sensor_msgs/msg/JointState"
TF_TYPE = "tf2_msgs/msg/TFMessage"

_DEFAULT_NAME = "/robot_state_publisher"


class FrameReplay:
    """Replay of robot_state_publisher: computes a bag's ``/tf`` again from its joint states.

    As in the node, a state is due when the publish interval has passed since the last state that
    was used. For a state without a recorded message, nothing is computed.

    Args:
        urdf: Robot description as URDF text.
        parameters: Recorded parameters of all nodes, by full node name and parameter name.

    Attributes:
        name: Full name of the robot_state_publisher node.
        states_topic: Topic of the joint states that the node subscribes to.
        children: Names of the moving frames.
        fixed: Transforms of the fixed frames, with zero stamps, by frame name.
    """

    def __init__(self, urdf: str, parameters: Mapping[str, Mapping[str, object]]) -> None:
        found = (name for name, each in parameters.items() if "publish_frequency" in each)
        self.name = next(found, _DEFAULT_NAME)
        own = parameters.get(self.name, {})
        prefix = str(own.get("frame_prefix", ""))
        self._ignores_stamps = bool(own.get("ignore_timestamp", False))
        frequency = own.get("publish_frequency", 20.0)
        self._interval_ns = publish_interval_ns(
            frequency if isinstance(frequency, int | float) else 20.0
        )
        namespace, _, node = self.name.rpartition("/")
        self.states_topic = expand_name("joint_states", node, namespace or "/")
        description = RobotDescription.from_urdf(urdf)
        joints = Joints.for_display(description, lambda _: None)
        tree = SegmentTree(description, joints)
        self._transforms = JointTransforms(tree, prefix)
        # Any: the types of messages are made at run time.
        self._message: Any = get_message(TF_TYPE)
        self._joint_state = get_message(JOINT_STATE)
        self.fixed = {each.child_frame_id: each for each in self._transforms.fixed(0)}
        self.children = {prefix + joint.child for joint in tree.moving}
        self._last_ns: int | None = None

    def compare(self, time_ns: int, state: bytes, stream: ComparedStream) -> bytes | None:
        """Compute tf of a JointState and compare with ``stream``; return CDR, None if not compared.

        Args:
            time_ns: Time of the joint state, in nanoseconds.
            state: CDR of the joint state.
            stream: Recorded messages of the node on ``/tf``.
        """
        is_due = (
            not self._last_ns
            or self._ignores_stamps
            or time_ns - self._interval_ns >= self._last_ns
        )
        if not is_due:
            # A recorded message of this time stays in the stream, and is reported as extra.
            return None
        if stream.at(time_ns) is None:
            if self._last_ns is not None and stream.begin_ns < time_ns < stream.end_ns:
                stream.add_missing(time_ns)
            elif time_ns > stream.end_ns:
                stream.take(time_ns, b"")
            return None
        message: Any = deserialize(state, self._joint_state)
        if len(message.name) != len(message.position):
            return None
        self._last_ns = time_ns
        now = bytes(
            serialize(
                self._message(
                    transforms=self._transforms.moving(message.name, message.position, time_ns)
                )
            )
        )
        stream.take(time_ns, now)
        return now


def split_by_frames(
    topic: RecordedTopic, groups: Mapping[str, set[str]]
) -> dict[str, RecordedTopic]:
    """Return recorded ``/tf`` messages by publisher, given the frames of each in ``groups``.

    Args:
        topic: Recorded messages of ``/tf``.
        groups: Names of the frames of each replayed publisher, by its name.

    Returns:
        Messages by name of the publisher; those of other publishers have an empty name.
    """
    message_class = get_message(TF_TYPE)
    found: dict[str, list[Any]] = {name: [] for name in ("", *groups)}
    for recorded in topic.messages:
        try:
            message: Any = deserialize(recorded.data, message_class)
        except TeleopctlError:
            found[""].append(recorded)
            continue
        children = {transform.child_frame_id for transform in message.transforms}
        whose = next((n for n, names in groups.items() if children and children <= names), "")
        found[whose].append(recorded)
    return {
        name: RecordedTopic(topic.type_name, messages, numbers=topic.numbers)
        for name, messages in found.items()
    }
