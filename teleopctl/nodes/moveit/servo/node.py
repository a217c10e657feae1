"""Node ``servo_node``: twists, poses and joint velocities in, commands of a controller out."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from teleopctl.base import progress
from teleopctl.commander import (
    CommandPublisher,
    CommandTopic,
    Controller,
    Controllers,
    StreamKind,
    choose_streams,
    read_pose,
)
from teleopctl.errors import TeleopctlError, UsageError
from teleopctl.interfaces import deserialize, get_message, get_service
from teleopctl.kinematics import (
    ClearanceChecker,
    CompiledScene,
    GroupKinematics,
    KinematicModel,
    PoseTask,
    Reason,
    RobotGroups,
    ServoCore,
    ServoStep,
    StatusCode,
    find_groups,
    parse_srdf,
    pose_matrix,
    read_srdf,
)
from teleopctl.node import (
    LeaseWatch,
    MessageInfo,
    Node,
    Parameter,
    StopHolders,
    qos_profile_latched,
)
from teleopctl.nodes.moveit.servo.commands import (
    LateCommands,
    ServoCommand,
    ServoCommandType,
    finite,
    parts_of_limit,
    served,
    twist_of,
)
from teleopctl.nodes.moveit.servo.markers import StatusMarkers, StatusPublisher
from teleopctl.nodes.moveit.servo.parameters import ServoParameters
from teleopctl.nodes.moveit.servo.scene import SceneFollower
from teleopctl.packages import resolve_uri
from teleopctl.robot import Joints, RobotDescription, stop_decelerations
from teleopctl.tf import LiveBuffer, TransformException, TransformListener, transform_of

_DEPTH = 10
# Deviation of the measured from the commanded position, rad or m, at which something else moves or
# holds the arm: servo stops, and starts at the measured state with the next command.
_LOST = 0.3
# Age of the measured state, s, at which servo does not begin.
_STALE_STATE_S = 1.0
# Acceleration of joints that have neither an acceleration nor a velocity limit, rad/s² or m/s².
_DEFAULT_ACCELERATION = 10.0
# A trajectory's point lies this many periods ahead, so that the controller moves on when the next
# message is late.
_PERIODS_AHEAD = 2.0
# Periods without a step after which the motion stops instead of continuing from its old state.
_STALLED_PERIODS = 50
_LIMITS = "robot_description_planning.joint_limits"

# Any, here and below: message classes are generated at run time from definitions.
_JointState: Any = get_message("sensor_msgs/msg/JointState")


class ServoNode(Node):
    """Servo as a node, with the topics, services and parameters of MoveIt Servo.

    It is silent until a command arrives; the first one begins a period at once. While commands
    arrive, or the arm still moves, a step is computed and published in each period of the node's
    clock. Without a command for ``incoming_command_timeout`` the arm decelerates and servo falls
    silent again.
    """

    def __init__(self) -> None:
        progress.report(progress.STARTING)
        super().__init__(
            "servo_node",
            allow_undeclared_parameters=True,
            automatically_declare_parameters_from_overrides=True,
        )
        self.parameters = ServoParameters(self)
        self._period_s = float(self.parameters["publish_period"])
        self._command: ServoCommand | None = None
        self._late = LateCommands()
        self._stepped_ns = 0
        self._type: ServoCommandType | None = None
        self._is_paused = False
        self._core: ServoCore | None = None
        self._scene: CompiledScene | None = None
        self._positions: dict[str, float] = {}
        self._state: bytes | None = None
        self._states_at_s = -float("inf")
        self._targets: dict[str, float] = {}
        self._outputs: list[CommandPublisher] = []
        self._goals: dict[str, Any] = {}
        self._said = ""
        self._urdf = ""
        self._tf: LiveBuffer | None = None
        self._running: set[str] = set()
        self._status = StatusPublisher(self, self.parameters["status_topic"])
        kinds = ServoCommandType
        for parameter, type_name, kind in (
            ("joint_command_in_topic", "control_msgs/msg/JointJog", kinds.JOINT_JOG),
            ("cartesian_command_in_topic", "geometry_msgs/msg/TwistStamped", kinds.TWIST),
            ("pose_command_in_topic", "geometry_msgs/msg/PoseStamped", kinds.POSE),
        ):
            self.create_subscription(
                get_message(type_name), self.parameters[parameter], self._receiver(kind), _DEPTH
            )
        self.create_subscription(
            _JointState, self.parameters["joint_topic"], self._on_state, 1, raw=True
        )
        self.create_service(
            get_service("moveit_msgs/srv/ServoCommandType"),
            "~/switch_command_type",
            self._switch_command_type,
        )
        self.create_service(get_service("std_srvs/srv/SetBool"), "~/pause_servo", self._pause)
        # Those of MoveIt Servo before Iron, which pymoveit2 calls.
        for name, is_paused in (("start_servo", False), ("stop_servo", True)):
            handler = partial(self._set_paused, is_paused)
            self.create_service(get_service("std_srvs/srv/Trigger"), f"~/{name}", handler)
        self._markers = StatusMarkers(self)
        self._lease = LeaseWatch(self)
        self._stop = StopHolders(self, lambda _: self._lease.end())
        self._timer = self.create_timer(self._period_s, self._step, autostart=False)
        self.add_post_set_parameters_callback(self._follow_parameters)
        self._controllers = Controllers(self, self._on_controllers)
        if given := self._text("robot_description"):
            self._start(given)
        else:
            topic = self.create_subscription(
                get_message("std_msgs/msg/String"),
                "robot_description",
                lambda message: self._start(message.data),
                qos_profile_latched,
            ).topic_name
            self.get_logger().info(f"Waiting for the robot description on {topic}")
            progress.report(progress.WAITING, topic)

    # --- start ----------------------------------------------------------------------------------

    def _start(self, urdf: str) -> None:
        if self._core is not None:
            if urdf != self._urdf:
                self.get_logger().warning(
                    "Another robot description was published; servo keeps the first one"
                )
            return
        progress.report(progress.STARTING)
        self._urdf = urdf
        try:
            description = RobotDescription.from_urdf(urdf)
            joints = Joints.of(description)
            groups = self._groups(description, joints)
            for warning in groups.warnings:
                self.get_logger().warning(warning)
            has_arm = any(group.tip for group in groups.groups.values())
            if not has_arm and not self.parameters["needs_arm"]:
                self.get_logger().info(f"The robot '{description.name}' has no arm to move")
                progress.report(progress.READY)
                return
            group = groups.group(str(self.parameters["move_group_name"]))
            model = KinematicModel(description)
            clearance = ClearanceChecker(model, groups.allowed_collisions)
            if gripper := groups.gripper_of(group.name):
                # Fingers close on each other, or on what they hold.
                clearance.allow_within(description.joints[name].child for name in gripper.joints)
            self._group = group
            core = self._use(model, clearance)
            self._follower = SceneFollower(
                self, KinematicModel(description), groups, self._on_scene
            )
        except TeleopctlError as error:
            hint = f" ({error.hint})" if error.hint else ""
            self.get_logger().error(f"Servo cannot start: {error.message}{hint}")
            progress.report(progress.FAILED, f"servo cannot start: {error.message}")
            return
        self._root = description.root
        kinematics = self._kinematics
        self.get_logger().info(
            f"Servo moves '{group.tip}' by {', '.join(kinematics.names)} (group '{group.name}'): "
            f"{served(core.task, kinematics)}"
        )
        self._controllers.request()
        progress.report(progress.READY)

    def _use(self, model: KinematicModel, clearance: ClearanceChecker) -> ServoCore:
        """Compute steps on a model from now on; the motion continues."""
        kinematics = GroupKinematics(model, self._group)
        before, task = self._core, str(self.parameters["task"])
        if before is None:
            self._limits = self._accelerations(kinematics, model.joints)
        core = ServoCore(
            kinematics,
            self._limits,
            clearance=clearance if self.parameters["check_collisions"] else None,
            settings=self.parameters.settings(),
            task=None if task == "auto" else PoseTask(task),
        )
        if before is not None:
            core.positions, core.velocities = before.positions, before.velocities
        self._model, self._kinematics, self._clearance = model, kinematics, clearance
        self._core = core
        return core

    def _on_scene(self, scene: CompiledScene) -> None:
        """Compile a new planning scene, on a thread of its own; the next step uses it."""
        self._scene = scene

    def _adopt_scene(self) -> None:
        scene, self._scene = self._scene, None
        if scene is not None:
            scene.model.set_positions(self._states)
            self._use(scene.model, scene.clearance)

    def _groups(self, description: RobotDescription, joints: Joints) -> RobotGroups:
        """Return the robot's groups: of the SRDF if there is one, else those of the description.

        Raises:
            TeleopctlError: The SRDF cannot be used.
        """
        if text := self._text("robot_description_semantic"):
            return parse_srdf(text, description, joints)
        if file := self._text("srdf"):
            return read_srdf(resolve_uri(file), description, joints)
        return find_groups(description, joints)

    def _text(self, name: str) -> str:
        """Return a parameter that is a text; empty if it is not given."""
        return str(self.get_parameter_or(name, Parameter(name, value="")).value or "")

    def _accelerations(self, kinematics: GroupKinematics, joints: Joints) -> np.ndarray:
        """Return the largest acceleration of each joint, (n,), rad/s² or m/s²."""
        limits = {name: joints[name].limits for name in kinematics.names}
        given = {}
        for name in kinematics.names:
            values = self.get_parameters_by_prefix(f"{_LIMITS}.{name}")
            if "has_acceleration_limits" in values and values["has_acceleration_limits"].value:
                given[name] = float(values["max_acceleration"].value)
        found, derived = stop_decelerations(limits, given)
        if derived:
            self.get_logger().info(
                f"Joints without an acceleration limit: {', '.join(derived)}. Theirs is the "
                "velocity limit over 0.2 s"
            )
        return np.array(
            [
                found[name] if np.isfinite(found[name]) else _DEFAULT_ACCELERATION
                for name in kinematics.names
            ]
        )

    def _follow_parameters(self, parameters: list[Parameter]) -> None:
        if self._core is None or not any("moveit_servo." in p.name for p in parameters):
            return
        try:
            self._core.set_settings(self.parameters.settings())
        except TeleopctlError as error:
            self.get_logger().error(error.message)
        self._core.set_clearance(self._clearance if self.parameters["check_collisions"] else None)

    # --- controllers ----------------------------------------------------------------------------

    def _on_controllers(self, controllers: list[Controller]) -> None:
        """Choose the controllers that command the group's joints."""
        if self._core is None:
            return
        joints = self._kinematics.names
        topic, kind = self.parameters["command_out_topic"], self.parameters["command_out_type"]
        if topic:
            targets = [self._named_target(self.resolve_topic_name(topic), kind, controllers)]
        else:
            targets = choose_streams(controllers, joints)
        if targets == [output.target for output in self._outputs]:
            return
        for output in self._outputs:
            output.destroy()
        for subscription in self._goals.values():
            self.destroy_subscription(subscription)
        self._goals.clear()
        self._running = set()
        ahead_s = _PERIODS_AHEAD * self._period_s
        self._outputs = [CommandPublisher(self, one, ahead_s, gives_way=True) for one in targets]
        for target in targets:
            if target.kind is StreamKind.TRAJECTORY:
                self._watch_goals(target.topic.rpartition("/")[0])
        if targets:
            self.get_logger().info(
                f"Servo commands {', '.join(target.topic for target in targets)}"
            )
        elif self._core is not None:
            self.get_logger().warning(
                f"No active controllers command {', '.join(joints)} together: servo waits for them"
            )

    def _named_target(self, topic: str, kind: str, controllers: list[Controller]) -> CommandTopic:
        """Return the topic that the parameters name: with its controller's joints, if it has one.

        Without one it takes the group's joints: positions, or velocities as arrays if
        ``publish_joint_positions`` is false.
        """
        for controller in controllers:
            if controller.stream is not None and controller.stream.topic == topic:
                return controller.stream
        quantity = "position" if self.parameters["publish_joint_positions"] else "velocity"
        of_messages = StreamKind(kind or StreamKind.TRAJECTORY)
        return CommandTopic(topic, of_messages, tuple(self._kinematics.names), quantity)

    def _watch_goals(self, controller: str) -> None:
        """Follow whether a controller executes a trajectory."""
        topic = f"{controller}/follow_joint_trajectory/_action/status"

        def received(message: Any) -> None:
            # ACCEPTED, EXECUTING and CANCELING.
            if any(1 <= status.status <= 3 for status in message.status_list):
                self._running.add(controller)
            else:
                self._running.discard(controller)

        self._goals[controller] = self.create_subscription(
            get_message("action_msgs/msg/GoalStatusArray"), topic, received, qos_profile_latched
        )

    # --- commands -------------------------------------------------------------------------------

    def _receiver(self, kind: ServoCommandType) -> Callable[[Any, MessageInfo], None]:
        def received(message: Any, info: MessageInfo) -> None:
            if self._is_paused:
                return
            if refusal := self._lease.refusal(info["publisher_gid"]):
                text = f"A {kind.text} command is refused: {refusal}"
                self.get_logger().warning(text, throttle_duration_sec=5.0)
                return
            if self._type is not None and kind is not self._type:
                chosen = f"~/switch_command_type chose {self._type.text} commands"
                text = f"A {kind.text} command is ignored: {chosen}"
                self.get_logger().warning(text, throttle_duration_sec=5.0)
                return
            if self._late.is_late(info, time.time_ns()):
                text = f"A {kind.text} command is ignored: it was delayed on its way"
                self.get_logger().warning(text, throttle_duration_sec=5.0)
                return
            self._command = ServoCommand.of(kind, message)
            self._targets = {}
            if self._core is None:
                self._report(StatusCode.INVALID, "no robot description has been received")
            elif self._timer.is_canceled():
                self._begin()

        return received

    def _begin(self) -> None:
        """Begin to move from the measured state, with a first step at once."""
        if not self._reset():
            self._command = None
            return
        self._timer.reset()
        self._stepped_ns = self._timer.clock.elapsed_ns()
        self._step()

    def _reset(self) -> bool:
        """Restart at the measured state; return whether there is one, and a controller."""
        self._adopt_scene()
        assert self._core is not None
        missing = [name for name in self._kinematics.names if name not in self._states]
        age_s = time.monotonic() - self._states_at_s
        if missing or age_s > _STALE_STATE_S:
            topic = self.parameters["joint_topic"]
            what = f"of {', '.join(missing)}" if missing else f"for {age_s:.1f} s"
            self._report(StatusCode.INVALID, f"no states {what} on {topic}")
            return False
        if not self._outputs:
            self._report(
                StatusCode.INVALID,
                f"no active controllers command {', '.join(self._kinematics.names)} together",
            )
            self._controllers.request()
            return False
        self._model.set_positions(self._states)
        self._core.reset(self._kinematics.vector(self._states))
        return True

    def _on_state(self, data: bytes) -> None:
        # Read when it is needed: states may arrive a thousand times a second, also while all rests.
        self._state = data
        self._states_at_s = time.monotonic()

    @property
    def _states(self) -> dict[str, float]:
        """The last received position of each joint, rad or m."""
        if self._state is not None:
            message = deserialize(self._state, _JointState)
            self._state = None
            self._positions.update(zip(message.name, message.position, strict=False))
        return self._positions

    def _switch_command_type(self, request: Any, response: Any) -> Any:
        try:
            self._type = ServoCommandType(request.command_type)
            response.success = True
        except ValueError:
            self.get_logger().warning(f"Unknown command type {request.command_type} requested")
            response.success = False
        return response

    def _pause(self, request: Any, response: Any) -> Any:
        return self._set_paused(bool(request.data), request, response)

    def _set_paused(self, is_paused: bool, _request: Any, response: Any) -> Any:
        response.success = True
        if is_paused == self._is_paused:
            response.message = "Requested pause state is already active."
            return response
        self._is_paused = is_paused
        self._command = None
        self._targets = {}
        response.message = "Servoing disabled" if self._is_paused else "Servoing enabled"
        return response

    # --- the loop -------------------------------------------------------------------------------

    def _step(self) -> None:
        """Compute and publish the step of one period; stop the timer once all is still."""
        self._adopt_scene()
        core = self._core
        assert core is not None
        if reason := self._refusal(core):
            self._command = None
            self._targets = {}
            self._timer.cancel()
            self._report(StatusCode.INVALID, reason)
            return
        try:
            step = self._next(core)
        except UsageError as error:
            self._command = None
            self._report(StatusCode.INVALID, error.message)
            step = core.halt_step(self._period_s)
        else:
            self._report(step.code, step.message, step.reasons)
        self._publish(step)
        if self._command is None and not self._targets and core.is_still:
            self._timer.cancel()
            self._said = ""

    def _refusal(self, core: ServoCore) -> str:
        """Return why servo must not command the joints in this step; call it once in each."""
        before_ns, self._stepped_ns = self._stepped_ns, self._timer.clock.elapsed_ns()
        if self._stepped_ns - before_ns > 1e9 * _STALLED_PERIODS * self._period_s:
            return f"servo was suspended for {1e-9 * (self._stepped_ns - before_ns):.1f} s"
        if self._stop.names:
            return f"the robot is stopped by {', '.join(self._stop.names)}"
        if self._running:
            return f"{', '.join(sorted(self._running))} executes a trajectory"
        if not self._outputs:
            return f"no active controllers command {', '.join(self._kinematics.names)} together"
        measured = self._kinematics.vector(self._states)
        away = np.abs(measured - core.positions)
        if float(away.max()) > _LOST + float(np.abs(core.velocities).max()) * _LOST:
            name = self._kinematics.names[int(np.argmax(away))]
            return f"joint '{name}' is {float(away.max()):.2f} from where it was commanded"
        return ""

    def _next(self, core: ServoCore) -> ServoStep:
        """Return the next step: by the newest command, or to a halt.

        Raises:
            UsageError: The command cannot be obeyed.
        """
        command = self._command
        if command is not None and command.age_s() > float(
            self.parameters["incoming_command_timeout"]
        ):
            self._command = command = None
        if command is None:
            if self._targets:
                return self._target_step(core)
            return core.halt_step(self._period_s)
        if command.type is ServoCommandType.TWIST:
            return core.twist_step(self._twist(command.message), self._period_s)
        if command.type is ServoCommandType.POSE:
            T_frame = self._frame(command.message.header.frame_id)
            return core.pose_step(
                T_frame @ read_pose(command.message.pose, "The pose"), self._period_s
            )
        return self._jog(core, command.message)

    def _jog(self, core: ServoCore, message: Any) -> ServoStep:
        names = list(message.joint_names)
        unknown = [name for name in names if name not in self._kinematics.names]
        if unknown:
            raise UsageError(
                f"The command names {', '.join(unknown)}; the group has "
                f"{', '.join(self._kinematics.names)}"
            )
        for what in ("velocities", "displacements"):
            values = getattr(message, what)
            if len(values) not in (0, len(names)):
                raise UsageError(f"{len(names)} joint names have {len(values)} {what}")
        if len(message.displacements):
            moved = finite(message.displacements, "The command")
            at = self._kinematics.by_name(core.positions)
            self._targets = {
                name: at[name] + float(by) for name, by in zip(names, moved, strict=True)
            }
            self._command = None
            return self._target_step(core)
        velocities = np.zeros(len(self._kinematics.names))
        given = finite(message.velocities, "The command")
        if self.parameters["command_in_type"] == "unitless":
            given = parts_of_limit(given, "The command") * float(self.parameters["scale.joint"])
        for name, velocity in zip(names, given, strict=False):
            velocities[self._kinematics.names.index(name)] = velocity
        return core.joint_step(velocities, self._period_s)

    def _target_step(self, core: ServoCore) -> ServoStep:
        speed = float(self.parameters["scale.joint"])
        speeds = np.array([min(limit.velocity, speed) for limit in self._kinematics.limits])
        step = core.target_step(self._targets, speeds, self._period_s)
        if not step.is_moving:
            self._targets = {}
        return step

    def _twist(self, message: Any) -> np.ndarray:
        """Return a command's twist of the tool in the axes of the root link, (6,)."""
        twist = twist_of(
            message,
            unitless=self.parameters["command_in_type"] == "unitless",
            linear=float(self.parameters["scale.linear"]),
            rotational=float(self.parameters["scale.rotational"]),
        )
        pose = self._frame(message.header.frame_id)
        linear, angular = pose[:3, :3] @ twist[:3], pose[:3, :3] @ twist[3:]
        if not self.parameters["apply_twist_commands_about_ee_frame"]:
            # About the origin of the frame: the tool is carried around it.
            linear = linear + np.cross(angular, self._kinematics.pose()[:3, 3] - pose[:3, 3])
        return np.concatenate((linear, angular))

    def _frame(self, frame: str) -> np.ndarray:
        """Return the pose of a command's frame in the root link's frame, (4, 4).

        Raises:
            UsageError: The frame is unknown.
        """
        assert self._core is not None
        if not frame or frame == self._root:
            return np.eye(4)
        if frame in self._model.links:
            self._kinematics.set(self._core.positions)
            return self._model.pose(frame)
        if self._tf is None:
            # Transforms are received from the first command on that needs them.
            self._tf = LiveBuffer(node=self)
            TransformListener(self._tf, self)
        try:
            found = self._tf.lookup_transform(self._root, frame, 0)
        except TransformException as error:
            raise UsageError(f"The frame '{frame}' of the command is unknown: {error}") from None
        return pose_matrix(transform_of(found.transform))

    def _publish(self, step: ServoStep) -> None:
        positions = self._kinematics.by_name(step.positions)
        velocities = self._kinematics.by_name(step.velocities)
        for output in self._outputs:
            output.publish(positions, velocities, self._states)

    def _report(self, code: StatusCode, message: str, reasons: Sequence[Reason] = ()) -> None:
        """Publish the status, and log it when it changes to one that stops the motion."""
        if code is StatusCode.INVALID:
            reasons = (Reason(code, message),)
            message = f"{code.text}: {message}"
        if self._core is not None:
            self._markers.show(self._root, self._kinematics, reasons)
        self._status.publish(code, message, is_stepping=not self._timer.is_canceled())
        if message != self._said and code is StatusCode.INVALID:
            self.get_logger().warning(message, throttle_duration_sec=1.0)
        self._said = message
