"""Executable ``robot_state_publisher``: publishes transforms from joint positions.

Publishes the description, latched, on ``robot_description``; the transforms of fixed joints,
latched, on ``/tf_static``; and those of moving joints on ``/tf`` for each message on
``joint_states``, at most at ``publish_frequency``.
"""

from __future__ import annotations

import contextlib
import math
import struct
import sys
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from teleopctl.base import progress
from teleopctl.base.files import read_text
from teleopctl.errors import InvalidParameterError, TeleopctlError
from teleopctl.interfaces import (
    NANOSECONDS_PER_SECOND,
    PreparedMessage,
    deserialize,
    get_message,
)
from teleopctl.node import (
    ExternalShutdownException,
    Node,
    Parameter,
    QoSOverridingOptions,
    init,
    parse_ros_arguments,
    qos_profile_latched,
    qos_profile_sensor_data,
    spin,
)
from teleopctl.robot import Joint, Joints, MovingSegments, RobotDescription, SegmentTree
from teleopctl.tf import (
    PreparedTransforms,
    StaticTransformBroadcaster,
    Transform,
    TransformBroadcaster,
    move_transform,
    stamp_of,
    transform_stamped,
)

if TYPE_CHECKING:
    from geometry_msgs.msg import TransformStamped

_MAX_FREQUENCY = 1000.0

_LITTLE_ENDIAN = b"\x00\x01\x00\x00"
_STAMP = struct.Struct("<iI")
# Place behind the header of the CDR and the stamp of a joint state, in bytes.
_STATE_STAMP_END = 12


class JointTransforms:
    """TransformStamped messages of a robot's joints, computed from joint positions.

    Args:
        tree: Segments of the robot.
        prefix: Prefix of all frame names.
    """

    def __init__(self, tree: SegmentTree, prefix: str = "") -> None:
        self._tree = tree
        self._prefix = prefix
        # Created once per moving frame: at 1 kHz, creating messages would be most of the work.
        self._messages: dict[str, TransformStamped] = {}

    def moving(
        self, names: Sequence[str], positions: Sequence[float], stamp_ns: int
    ) -> list[TransformStamped]:
        """Return TransformStamped messages for joints and positions, reused by the next call.

        Args:
            names: Names of the joints.
            positions: Their positions, rad or m; joints whose position is not finite are left out.
            stamp_ns: Stamp of the messages, in nanoseconds.
        """
        measured = {
            name: value
            for name, value in zip(names, positions, strict=True)
            if math.isfinite(value)
        }
        return [
            self._moved(joint, transform, stamp_ns)
            for joint, transform in self._tree.transforms(measured)
        ]

    def prepared(self, names: Sequence[str]) -> PreparedJointTransforms:
        """Return a serialized tf message of the transforms that follow from the given joints."""
        return PreparedJointTransforms(self._tree.moving_segments(names), self._prefix)

    def fixed(self, stamp_ns: int) -> list[TransformStamped]:
        """Return TransformStamped messages of the fixed joints, with the given stamp."""
        return [
            self._message(segment.joint, segment.origin, stamp_ns) for segment in self._tree.fixed
        ]

    def _message(self, joint: Joint, transform: Transform, stamp_ns: int) -> TransformStamped:
        return transform_stamped(
            self._prefix + joint.parent, self._prefix + joint.child, stamp_ns, transform
        )

    def _moved(self, joint: Joint, transform: Transform, stamp_ns: int) -> TransformStamped:
        message = self._messages.get(joint.child)
        if message is None:
            message = self._messages[joint.child] = self._message(joint, transform, stamp_ns)
        else:
            move_transform(message, stamp_ns, transform)
        return message


class PreparedJointTransforms:
    """Serialized tf message of joints whose positions come in the same order each time.

    Args:
        segments: Segments that move with the joints.
        prefix: Prefix of all frame names.
    """

    def __init__(self, segments: MovingSegments, prefix: str) -> None:
        self._segments = segments
        self._message = PreparedTransforms(
            [(prefix + parent, prefix + child) for parent, child in segments.frames]
        )

    def serialized(self, positions: Sequence[float], stamp_ns: int) -> bytes:
        """Return the message for positions (rad or m) and a stamp (ns); empty if no joint moves."""
        if not self._segments.frames:
            return b""
        return self._message.serialized(stamp_ns, self._segments.numbers(positions))


class JointStateReader:
    """Reader of serialized joint states, faster for those with the same joints as the last one.

    Attributes:
        names: Joints of the last joint state.
        positions: Positions of these joints, rad or m.
        stamp_ns: Stamp of the last joint state, in nanoseconds.
        has_same_names: Whether the last joint state had the joints of the one before.
    """

    def __init__(self) -> None:
        self._type = get_message("sensor_msgs/msg/JointState")
        # The bytes between stamp and positions: frame, names, and the number of positions.
        self._between = b""
        self._positions = struct.Struct("")
        self.names: list[str] = []
        self.positions: Sequence[float] = ()
        self.stamp_ns = 0
        self.has_same_names = False

    def read(self, payload: bytes) -> None:
        """Read a joint state in CDR.

        Raises:
            TeleopctlError: The data is no joint state.
        """
        between = self._between
        end = _STATE_STAMP_END + len(between)
        self.has_same_names = (
            bool(between)
            and payload.startswith(between, _STATE_STAMP_END)
            and payload[:4] == _LITTLE_ENDIAN
            and len(payload) >= end + self._positions.size
        )
        if self.has_same_names:
            self.positions = self._positions.unpack_from(payload, end)
            sec, nanosec = _STAMP.unpack_from(payload, 4)
            self.stamp_ns = sec * NANOSECONDS_PER_SECOND + nanosec
            return
        state: Any = deserialize(payload, self._type)
        self.names, self.positions = list(state.name), list(state.position)
        self.stamp_ns = stamp_of(state.header.stamp)
        self._between = b""
        if payload[:4] == _LITTLE_ENDIAN and 0 < len(self.positions) == len(self.names):
            start = PreparedMessage(state, ["position"]).offsets["position"]
            self._between = payload[_STATE_STAMP_END:start]
            self._positions = struct.Struct(f"<{len(self.positions)}d")


class RobotStatePublisher(Node):
    """Node ``robot_state_publisher``: publishes a robot's transforms from joint states.

    Args:
        file: URDF file that is read if the parameter ``robot_description`` is empty.

    Raises:
        TeleopctlError: ``robot_description`` is missing or is not a robot.
    """

    def __init__(self, file: Path | None = None) -> None:
        progress.report(progress.STARTING)
        super().__init__("robot_state_publisher")
        urdf = self.declare_parameter("robot_description", "").value
        if not urdf and file is not None:
            self.get_logger().warning(
                "No robot_description parameter, but command-line argument available.  Assuming "
                "argument is name of URDF file.  This backwards compatibility fallback will be "
                "removed in the future."
            )
            urdf = read_text(file)
            self.set_parameters([Parameter("robot_description", value=urdf)])
        self._interval_ns = publish_interval_ns(
            self.declare_parameter("publish_frequency", 20.0).value
        )
        self._ignores_stamps = bool(self.declare_parameter("ignore_timestamp", False).value)
        self._prefix = str(self.declare_parameter("frame_prefix", "").value)
        self._string = get_message("std_msgs/msg/String")
        self._description_publisher = self.create_publisher(
            self._string, "robot_description", qos_profile_latched
        )
        self._moving = TransformBroadcaster(self)
        self._fixed = StaticTransformBroadcaster(self)
        # Joint states arrive on a thread of Zenoh, parameters on the one that spins.
        self._lock = threading.Lock()
        self._reader = JointStateReader()
        self._prepared: PreparedJointTransforms | None = None
        # Stamps of the last published transforms by joint, for joints other than the present ones:
        # those of the states that arrive now.
        self._stamps: dict[str, int] = {}
        self._names: list[str] = []
        # Stamp of the transforms of the present joints; 0 until they are published.
        self._published = 0
        # Stamp of the transform of a present joint that was published longest ago; 0 for never.
        self._oldest = 0
        self._last_stamp = 0
        self._tree = self._segments(urdf)
        self._transforms = JointTransforms(self._tree, self._prefix)
        self._publish_description(urdf)
        self.add_on_set_parameters_callback(self._check_parameters)
        self.add_post_set_parameters_callback(self._take_parameters)
        self.create_subscription(
            get_message("sensor_msgs/msg/JointState"),
            "joint_states",
            self._take_joint_state,
            qos_profile_sensor_data,
            raw=True,
            immediate=True,
            qos_overriding_options=QoSOverridingOptions.with_default_policies(),
        )
        self.get_logger().info("Robot initialized")
        progress.report(progress.READY)

    def _segments(self, urdf: str) -> SegmentTree:
        description = _read(urdf)
        for sentence in description.repairs:
            self.get_logger().warning(sentence)
        return SegmentTree(description, Joints.for_display(description, self.get_logger().warning))

    def _publish_description(self, urdf: str) -> None:
        for name in self._tree.names:
            self.get_logger().info(f"got segment {name}")
        self._description_publisher.publish(self._string(data=urdf))
        self._publish_fixed()

    def _publish_fixed(self) -> None:
        stamp = self.get_clock().now().nanoseconds
        self._fixed.sendTransform(self._transforms.fixed(stamp))

    def _take_joint_state(self, payload: bytes) -> None:
        with self._lock:
            try:
                self._reader.read(payload)
            except TeleopctlError as error:
                self.get_logger().warning(
                    f"A message on joint_states is ignored: {error.message}",
                    throttle_duration_sec=1.0,
                )
                return
            self._publish_moving()

    def _publish_moving(self) -> None:
        """Publish the transforms of the last joint state, if they are due."""
        reader = self._reader
        names, positions, stamp = reader.names, reader.positions, reader.stamp_ns
        if not reader.has_same_names:
            self._prepared = None
            if len(names) != len(positions):
                self._refuse(names, positions)
                return
            self._take_names(names)
        if stamp < self._last_stamp:
            self.get_logger().warning(
                "Moved backwards in time, re-publishing joint transforms!",
                throttle_duration_sec=1.0,
            )
            self._forget_stamps()
        self._last_stamp = stamp
        oldest = self._oldest
        if oldest and not self._ignores_stamps and stamp - self._interval_ns < oldest:
            return
        # The sum is finite only if all positions are; that is the quickest check.
        if math.isfinite(sum(positions)) and (self._prepared or len(set(names)) == len(names)):
            if self._prepared is None:
                self._prepared = self._transforms.prepared(names)
            if data := self._prepared.serialized(positions, stamp):
                self._moving.pub_tf.publish(data)
        elif transforms := self._transforms.moving(names, positions, stamp):
            self._moving.sendTransform(transforms)
        self._published = self._oldest = stamp

    def _take_names(self, names: list[str]) -> None:
        """Prepare for states with the given joints."""
        if self._published:
            self._stamps.update(dict.fromkeys(self._names, self._published))
        self._names, self._published = names, 0
        self._oldest = min([self._stamps.get(name, 0) for name in names], default=0)

    def _forget_stamps(self) -> None:
        """Publish the next joint state, however short the time since the last one."""
        self._stamps.clear()
        self._published = self._oldest = 0

    def _refuse(self, names: Sequence[str], positions: Sequence[float]) -> None:
        """Log why a joint state with another number of positions than names is ignored."""
        if positions:
            self.get_logger().error(
                "Robot state publisher ignored an invalid JointState message",
                throttle_duration_sec=1.0,
            )
        else:
            # Velocities or efforts without positions do not determine transforms.
            self.get_logger().warning(
                "Robot state publisher ignored a JointState message about joint(s) "
                f"{', '.join(names)}: it has no positions",
                throttle_duration_sec=10.0,
            )

    def _check_parameters(self, parameters: list[Parameter]) -> Any:
        """Reject an invalid ``robot_description`` or ``publish_frequency``."""
        result = get_message("rcl_interfaces/msg/SetParametersResult")(successful=True)
        for parameter in parameters:
            try:
                if parameter.name == "robot_description":
                    _read(parameter.value)
                elif parameter.name == "publish_frequency":
                    publish_interval_ns(parameter.value)
            except TeleopctlError as error:
                result.successful, result.reason = False, error.message
        return result

    def _take_parameters(self, parameters: list[Parameter]) -> None:
        values = {parameter.name: parameter.value for parameter in parameters}
        with self._lock:
            self._prepared = None
            self._set_parameters(values)

    def _set_parameters(self, values: dict[str, Any]) -> None:
        if "publish_frequency" in values:
            self._interval_ns = publish_interval_ns(values["publish_frequency"])
        if "ignore_timestamp" in values:
            self._ignores_stamps = bool(values["ignore_timestamp"])
        if "frame_prefix" in values:
            self._prefix = str(values["frame_prefix"])
            self._transforms = JointTransforms(self._tree, self._prefix)
            self._fixed.forget()
            self._publish_fixed()
        if "robot_description" in values:
            self._tree = self._segments(values["robot_description"])
            self._transforms = JointTransforms(self._tree, self._prefix)
            self._forget_stamps()
            self._fixed.forget()
            self._publish_description(values["robot_description"])


def main(args: list[str] | None = None) -> int:
    """Run ``robot_state_publisher`` until Ctrl-C or a shutdown; return the exit status.

    Args:
        args: Command line; None takes ``sys.argv``.

    Raises:
        TeleopctlError: The description is missing or invalid.
    """
    words = parse_ros_arguments(sys.argv[1:] if args is None else args).program
    with (
        contextlib.suppress(KeyboardInterrupt, ExternalShutdownException),
        init(args=args),
        RobotStatePublisher(Path(words[0]) if words else None) as node,
    ):
        spin(node)
    return 0


def _read(urdf: str) -> RobotDescription:
    if not urdf:
        raise InvalidParameterError(
            "The robot_description parameter must not be empty",
            hint="Give it by --params-file, or start the node by a launch file such as "
            "`teleopctl launch display.yaml model:=FILE`.",
        )
    return RobotDescription.from_urdf(urdf)


def publish_interval_ns(frequency: float) -> int:
    """Return the shortest time between tf messages for a rate in Hz, in ns (whole milliseconds).

    Raises:
        InvalidParameterError: The frequency is not above 0 and at most 1000 Hz.
    """
    if not 0.0 < frequency <= _MAX_FREQUENCY:
        raise InvalidParameterError(f"publish_frequency must be between 0.0 and {_MAX_FREQUENCY}")
    # Whole milliseconds, as in ROS 2, so that no message of a stream at exactly that rate is lost.
    return int(1000 / frequency) * 1_000_000
