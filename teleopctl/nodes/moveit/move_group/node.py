"""Node ``move_group``: waits for the robot, then offers MoveIt's services and actions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from teleopctl.base import progress
from teleopctl.base.kept_memory import return_freed_memory
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import get_message
from teleopctl.kinematics import (
    KinematicModel,
    RobotGroups,
    find_groups,
    parse_srdf,
    read_srdf,
    write_srdf,
)
from teleopctl.node import Node, Timer, qos_profile_latched
from teleopctl.nodes.moveit.move_group.actions import MoveGroupActions
from teleopctl.nodes.moveit.move_group.context import MoveGroupContext
from teleopctl.nodes.moveit.move_group.execution import Execution
from teleopctl.nodes.moveit.move_group.file_services import FileServices
from teleopctl.nodes.moveit.move_group.kinematics_services import KinematicsServices
from teleopctl.nodes.moveit.move_group.parameters import (
    limited_joints,
    mention_unused,
    setting,
)
from teleopctl.nodes.moveit.move_group.planning import Planning
from teleopctl.nodes.moveit.move_group.scene_services import SceneServices
from teleopctl.nodes.moveit.move_group.simulation_world import SimulationWorld
from teleopctl.packages import resolve_uri
from teleopctl.robot import RobotDescription

_DESCRIPTION, _SEMANTIC = "robot_description", "robot_description_semantic"
# How long an SRDF on its topic may come after the description, s.
_SEMANTIC_WAIT_S = 0.5

# Any, here and below: message classes are generated at run time from definitions.
_String: Any = get_message("std_msgs/msg/String")
_JointState: Any = get_message("sensor_msgs/msg/JointState")


class MoveGroupNode(Node):
    """MoveIt's ``move_group``, with its services, actions, topics and parameters.

    Services and actions appear once the robot's description has been read.
    """

    def __init__(self) -> None:
        progress.report(progress.STARTING)
        super().__init__(
            "move_group",
            allow_undeclared_parameters=True,
            automatically_declare_parameters_from_overrides=True,
        )
        self._move_group: MoveGroupContext | None = None
        self._urdf = self._srdf = ""
        self._starting: Timer | None = None
        mention_unused(self)
        self._urdf = self._given(_DESCRIPTION, self._on_urdf)
        self._srdf = self._given(_SEMANTIC, self._on_srdf)
        if self._urdf:
            self._start_soon()
        else:
            topic = self.resolve_topic_name(_DESCRIPTION)
            self.get_logger().info(f"Waiting for the robot description on {topic}")
            progress.report(progress.WAITING, topic)

    def _given(self, name: str, receive: Callable[[str], None]) -> str:
        """Return a text from its parameter; if it is not set, follow the topic of its name."""
        given = str(setting(self, name, ""))
        if not given:
            self.create_subscription(
                _String, name, lambda message: receive(message.data), qos_profile_latched
            )
        elif setting(self, f"publish_{name}", default=False):
            publisher = self.create_publisher(_String, name, qos_profile_latched)
            publisher.publish(_String(data=given))
        return given

    def _on_urdf(self, urdf: str) -> None:
        if self._move_group is None:
            self._urdf = urdf
            self._start_soon()
        elif urdf != self._urdf:
            self.get_logger().warning(
                "Another robot description was published; move_group keeps the first one"
            )

    def _on_srdf(self, srdf: str) -> None:
        if self._move_group is None:
            self._srdf = srdf
            if self._urdf:
                self._start_soon()
        elif srdf != self._srdf:
            self.get_logger().warning(
                "Another SRDF was published; move_group keeps what it began with"
            )

    def _start_soon(self) -> None:
        """Start at once with an SRDF, or after a time in which one may arrive on its topic."""
        if self._srdf:
            self._start()
        elif self._starting is None:
            self._starting = self.create_timer(_SEMANTIC_WAIT_S, self._start)

    def _start(self) -> None:
        if self._starting is not None:
            self._starting.cancel()
        if self._move_group is not None:
            return
        progress.report(progress.STARTING)
        log = self.get_logger()
        try:
            model, groups = self._robot()
            # The first compilation finds all that is wrong with the robot's shapes.
            context = MoveGroupContext(self, model, groups)
            context.scene.compiled()
        except TeleopctlError as error:
            hint = f" ({error.hint})" if error.hint else ""
            log.error(f"move_group cannot start: {error.message}{hint}")
            progress.report(progress.FAILED, f"move_group cannot start: {error.message}")
            return
        padding = float(setting(self, "robot_description_planning.default_robot_padding", 0.0))
        if padding > 0.0:
            context.scene.padding_m = dict.fromkeys(model.links, padding)
            context.scene.changed()
        self._move_group = context
        self.create_subscription(_JointState, "joint_states", context.receive_state, 1, raw=True)
        KinematicsServices(context)
        SceneServices(context)
        FileServices(context, self._urdf)
        planning = Planning(context)
        MoveGroupActions(context, planning, Execution(context))
        if setting(self, "world_from_simulation", default=False):
            self._world = SimulationWorld(context)
        self._publish_semantic(groups, model.description)
        names = ", ".join(
            f"'{group.name}' ({', '.join(group.joints)})" for group in groups.groups.values()
        )
        log.info(
            f"Loaded robot '{model.description.name}' in frame '{context.planning_frame}', groups: "
            f"{names or 'none'}"
        )
        return_freed_memory()
        log.info("You can start planning now!")
        progress.report(progress.READY)

    def _publish_semantic(self, groups: RobotGroups, description: RobotDescription) -> None:
        """Publish the groups as an SRDF, unless another node does: clients would find others."""
        if self.count_publishers(_SEMANTIC):
            return
        if not self._srdf:
            self._srdf = write_srdf(groups, description)
        publisher = self.create_publisher(_String, _SEMANTIC, qos_profile_latched)
        publisher.publish(_String(data=self._srdf))

    def _robot(self) -> tuple[KinematicModel, RobotGroups]:
        """Return the model of the robot and its groups.

        Raises:
            TeleopctlError: Description, SRDF or limits are invalid.
        """
        log = self.get_logger()
        description = RobotDescription.from_urdf(self._urdf)
        model = KinematicModel(description)
        for warning in model.warnings:
            # The other warnings are about physics; the simulator logs them.
            if "collide" in warning or "overlap" in warning or "touch" in warning:
                log.warning(warning)
            else:
                log.debug(warning)
        model.joints = limited_joints(self, model.joints)
        if self._srdf:
            groups = parse_srdf(self._srdf, description, model.joints)
        elif file := str(setting(self, "srdf", "")):
            groups = read_srdf(resolve_uri(file), description, model.joints)
        else:
            groups = find_groups(description, model.joints)
            log.info("There is no SRDF: the groups are those of the description")
        for warning in groups.warnings:
            log.warning(warning)
        return model, groups
