"""The running robot: description, groups and measured state, received from their topics."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from teleopctl.errors import NotFoundError, UnavailableError

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from teleopctl.kinematics import Arm, RobotGroups
    from teleopctl.node import BareNode, Node
    from teleopctl.robot import RobotDescription

# Longest waits for a latched description, for a first state of the joints, and for a frame of
# /tf with the time between two looks, s.
_DESCRIPTION_S, _STATES_S, _TF_S, _LOOK_S = 3.0, 2.0, 2.0, 0.05
# How far (rad or m) a measured position may be outside its limits without a note: sensors' noise.
_NOISE = 0.01
_STRING = "std_msgs/msg/String"


class RunningRobot(NamedTuple):
    """Description and groups of the running robot, and its measured joint positions.

    Attributes:
        description: The robot.
        groups: Its groups.
        positions: Measured positions by joint; None if the robot does not run.
        compute_ik: Name of the service of a running move_group; empty without one.
    """

    description: RobotDescription
    groups: RobotGroups
    positions: dict[str, float] | None
    compute_ik: str = ""

    def arm(
        self, group: str = "", tool: str | Sequence[float] | npt.NDArray[np.float64] | None = None
    ) -> tuple[Arm, list[str]]:
        """Return a group as an `Arm` at the measured positions, else at rest, and warnings.

        Args:
            group: Name of the group; empty for the first that moves a tip.
            tool: Tool that poses are about, as of `Arm`.

        Raises:
            NotFoundError: There is no such group or tool.
            UnavailableError: A joint of the group has no measured position.
        """
        from teleopctl.kinematics import Arm

        arm = Arm(self.description, group, tool, self.groups)
        warnings = list(self.groups.warnings)
        for first, second in arm.model.touching:
            warnings.append(
                f"'{first}' and '{second}' touch at nearly all joint positions: they are allowed to"
            )
        if self.positions is not None:
            unknown = [
                name for name in arm.names if not math.isfinite(self.positions.get(name, math.nan))
            ]
            if unknown:
                raise UnavailableError(
                    f"The joint states have no position of {', '.join(unknown)}",
                    hint=f"They have: {', '.join(self.positions) or 'none'}",
                )
            arm.model.set_positions(self.positions)
            measured = arm.kinematics.present()
            arm.positions = arm.kinematics.clamp(measured)
            for name, at, moved in zip(arm.names, measured, arm.positions, strict=True):
                if abs(at - moved) > _NOISE:
                    warnings.append(f"Joint '{name}' is at {at:.4g}, outside its limits")
        return arm, warnings


def receive_robot(
    node: Node | BareNode,
    namespace: str = "",
    srdf: str | Path | None = None,
    *,
    needs_state: bool,
) -> RunningRobot:
    """Return the running robot of a namespace.

    Args:
        node: Node of the subscriptions.
        namespace: Namespace of the robot's topics.
        srdf: SRDF file; None for the SRDF that is published, or what the description suggests.
        needs_state: Whether the positions of its joints are needed.

    Raises:
        NotFoundError: No robot runs there, or several.
        UnavailableError: Its topics are silent.
    """
    above = f"/{namespace.strip('/')}" if namespace.strip("/") else ""
    topic = f"{above}/robot_description"
    graph = node.graph()
    publishers = graph.publishers(topic, _STRING)
    if not publishers:
        others = sorted(
            name.removesuffix("/robot_description")
            for name, _ in graph.topic_names_and_types()
            if name.endswith("/robot_description") and graph.publishers(name, _STRING)
        )
        raise NotFoundError(
            f"No robot runs: nothing publishes {topic}",
            hint=f"Others do in: {', '.join(each or '/' for each in others)} (--namespace)"
            if others
            else "Give a robot's FILE, or start one: teleopctl launch sim.yaml",
        )
    received = _Received(node, topic, f"{above}/joint_states", needs_state=needs_state)
    semantic = f"{topic}_semantic"
    if graph.publishers(semantic, _STRING) and not srdf:
        received.subscribe_semantic(semantic)
    # The messages arrive while these are imported, which takes longer.
    from teleopctl.kinematics import Arm as Arm, find_groups, parse_srdf, read_srdf
    from teleopctl.robot import RobotDescription

    try:
        received.wait(len(publishers))
    finally:
        received.close()
    texts = set(received.descriptions)
    if len(texts) > 1:
        names = ", ".join(sorted({each.full_name for each in publishers}))
        raise NotFoundError(
            f"{topic} has the descriptions of {len(texts)} robots, by {names}",
            hint="Robots in one graph need namespaces of their own.",
        )
    description = RobotDescription.from_urdf(received.descriptions[0])
    if srdf:
        groups = read_srdf(Path(srdf), description)
    elif received.semantic:
        groups = parse_srdf(received.semantic, description)
    else:
        groups = find_groups(description)
    service = f"{above}/compute_ik"
    return RunningRobot(
        description, groups, received.positions, service if graph.servers(service) else ""
    )


def lookup_frame(node: Node, frame: str, root: str) -> npt.NDArray[np.float64] | None:
    """Return the pose of the root link in a frame of ``/tf``, (4, 4); None if it does not come."""
    from teleopctl.kinematics import pose_matrix
    from teleopctl.tf import Buffer, TransformException, TransformListener, transform_of

    buffer = Buffer()
    listener = TransformListener(buffer, node)
    end_s = time.monotonic() + _TF_S
    try:
        while time.monotonic() < end_s:
            try:
                found = buffer.lookup_transform(frame, root, 0)
                return pose_matrix(transform_of(found.transform))
            except TransformException:
                time.sleep(_LOOK_S)
    finally:
        listener.unregister()
    return None


class _Received:
    """Subscriber of a running robot's description, groups and joint states."""

    def __init__(
        self,
        node: Node | BareNode,
        description_topic: str,
        states_topic: str,
        *,
        needs_state: bool,
    ) -> None:
        from teleopctl.interfaces import get_message
        from teleopctl.node import qos_profile_latched, qos_profile_sensor_data

        self.descriptions: list[str] = []
        self.semantic = ""
        self._string: Any = get_message(_STRING)
        self.positions: dict[str, float] | None = None
        self._node, self._needs_state = node, needs_state
        self._topics = (description_topic, states_topic)
        self._wants_semantic = False
        self._changed = threading.Condition()
        self._subscriptions = [
            node.create_subscription(
                self._string,
                description_topic,
                self._take_description,
                qos_profile_latched,
                immediate=True,
            )
        ]
        if needs_state:
            self._subscriptions.append(
                node.create_subscription(
                    get_message("sensor_msgs/msg/JointState"),
                    states_topic,
                    self._take_state,
                    qos_profile_sensor_data,
                    immediate=True,
                )
            )

    def subscribe_semantic(self, topic: str) -> None:
        """Receive the SRDF as well."""
        from teleopctl.node import qos_profile_latched

        self._wants_semantic = True
        self._subscriptions.append(
            self._node.create_subscription(
                self._string, topic, self._take_semantic, qos_profile_latched, immediate=True
            )
        )

    def close(self) -> None:
        """Destroy the subscriptions."""
        for subscription in self._subscriptions:
            self._node.destroy_subscription(subscription)

    def wait(self, publishers: int) -> None:
        """Wait until the description and the other required messages are received.

        Raises:
            UnavailableError: The description, or the joints' state, does not come.
        """
        with self._changed:
            self._changed.wait_for(
                lambda: (
                    len(self.descriptions) >= publishers
                    and (self.semantic or not self._wants_semantic)
                ),
                _DESCRIPTION_S,
            )
            if not self.descriptions:
                raise UnavailableError(f"{self._topics[0]} has a publisher that sends nothing")
            if self._needs_state and not self._changed.wait_for(
                lambda: self.positions is not None, _STATES_S
            ):
                raise UnavailableError(
                    f"No joint states on {self._topics[1]} within {_STATES_S:g} s",
                    hint="A joint_state_broadcaster or joint_state_publisher publishes them; a "
                    "command with positions, --named or --start needs none.",
                )

    # Any, here and below: message classes are generated at run time from definitions.
    def _take_description(self, message: Any) -> None:
        with self._changed:
            self.descriptions.append(str(message.data))
            self._changed.notify_all()

    def _take_semantic(self, message: Any) -> None:
        with self._changed:
            self.semantic = str(message.data)
            self._changed.notify_all()

    def _take_state(self, message: Any) -> None:
        with self._changed:
            found = dict(zip(message.name, map(float, message.position), strict=False))
            self.positions = {**(self.positions or {}), **found}
            self._changed.notify_all()
