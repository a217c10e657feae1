"""Shared state of ``move_group``: robot, measured joints, planning scene, frames."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from teleopctl.errors import NotFoundError, TeleopctlError, UsageError
from teleopctl.interfaces import deserialize, get_message
from teleopctl.kinematics import (
    AttachedBody,
    CollisionScene,
    CompiledScene,
    GroupKinematics,
    IkSolver,
    JointGroup,
    KinematicModel,
    MotionLimits,
    MoveItErrorCode,
    PlanningError,
    RobotGroups,
    Tolerance,
    pose_matrix,
    served_task,
    with_tip,
)
from teleopctl.node import Duration, Node
from teleopctl.nodes.moveit.move_group import messages
from teleopctl.tf import LiveBuffer, TransformException, TransformListener, transform_of

# Age of the measured state, s, from which it is too old for a motion.
_STALE_STATE_S = 1.0
# Time to wait for a transform, s, such as the first one after the listener was made.
_FRAME_WAIT_S = 1.0

# Any, here and below: message classes are generated at run time from definitions.
_JointState: Any = get_message("sensor_msgs/msg/JointState")


class MoveGroupContext:
    """Robot, measured state, scene and frames, as all services and actions use them.

    Args:
        node: The node.
        model: Model of the robot.
        groups: Its groups.

    Attributes:
        node: The node.
        groups: Groups of the robot.
        root: Name of the root link, in whose frame all poses are.
        planning_frame: Frame of poses in messages: that of the SRDF's virtual joint, which lies in
            the root link, or the root link.
        scene: The planning scene; its model is at the measured state.
        lock: Held while the scene or its compiled model is used.
    """

    def __init__(
        self,
        node: Node,
        model: KinematicModel,
        groups: RobotGroups,
    ) -> None:
        self.node, self.groups = node, groups
        description = model.description
        self.root = description.root
        self.planning_frame = groups.virtual_frame or self.root
        allowed = [*model.touching, *groups.allowed_collisions, *_grippers(groups, model)]
        self.scene = CollisionScene(model, allowed)
        self.lock = threading.RLock()
        self._listeners: list[Callable[[], object]] = []
        self._tf: LiveBuffer | None = None
        self._tf_since_s = 0.0
        self._state: bytes | None = None
        self._state_at_s = -math.inf
        self._measured: dict[str, float] = {}
        self._known_joints = frozenset(model.positions())
        self._tasks: dict[tuple[str, str, bytes], Any] = {}
        self._unknown: set[str] = set()

    # --- state ----------------------------------------------------------------------------------

    def receive_state(self, data: bytes) -> None:
        """Store a received JointState, which is read when it is needed."""
        with self.lock:
            self._state, self._state_at_s = data, time.monotonic()

    def update_state(self) -> None:
        """Move the scene's model to the newest measured state; to be called with the lock."""
        if self._state is None:
            return
        message = deserialize(self._state, _JointState)
        self._state = None
        if isinstance(message, _JointState):
            for name, at in zip(message.name, message.position, strict=False):
                if name in self._known_joints and math.isfinite(at):
                    self._measured[name] = float(at)
            self.scene.model.set_positions(self._measured)

    def measured(self) -> dict[str, float]:
        """Return the measured positions of the joints, rad or m, by name."""
        with self.lock:
            self.update_state()
            return dict(self._measured)

    def state_problem(self, joints: tuple[str, ...]) -> str:
        """Return why the joints' measured state is unknown, as a sentence; empty if it is known."""
        measured = self.measured()
        missing = [name for name in joints if name not in measured]
        if missing:
            return f"No state of {', '.join(missing)} has been received on /joint_states"
        age_s = time.monotonic() - self._state_at_s
        if age_s > _STALE_STATE_S:
            return f"The last state on /joint_states is {age_s:.1f} s old"
        return ""

    def positions(self, state: Any = None) -> dict[str, float]:
        """Return the positions of all joints: the measured ones, changed by a RobotState.

        Raises:
            PlanningError: The state has values that are no positions.
        """
        with self.lock:
            self.update_state()
            positions = self.scene.model.positions()
        if state is None:
            return positions
        try:
            given = messages.read_joint_state(state.joint_state)
        except UsageError as error:
            raise PlanningError(error.message, MoveItErrorCode.INVALID_ROBOT_STATE) from error
        unknown = given.keys() - self._known_joints - self._unknown
        if unknown:
            self._unknown |= unknown
            self.node.get_logger().warning(
                f"A state names joints that the robot has not, which are ignored: "
                f"{', '.join(sorted(unknown))}"
            )
        given = {name: at for name, at in given.items() if name in self._known_joints}
        return {**positions, **self.scene.model.joints.positions({**positions, **given})}

    def scene_of(self, state: Any) -> CollisionScene:
        """Return the scene with the attached objects of a RobotState, to be used with the lock.

        Raises:
            PlanningError: An attached object cannot be attached.
        """
        if not state.attached_collision_objects:
            return self.scene
        scene = self.scene.copy()
        if not state.is_diff:
            for name in list(scene.attached):
                scene.drop(name)
        try:
            for message in state.attached_collision_objects:
                self.apply_attached(scene, message)
        except (UsageError, NotFoundError) as error:
            raise PlanningError(error.message, MoveItErrorCode.INVALID_OBJECT_NAME) from error
        return scene

    # --- groups ---------------------------------------------------------------------------------

    def group(self, name: str) -> JointGroup:
        """Return a group.

        Raises:
            PlanningError: There is no such group.
        """
        if name in self.groups.groups:
            return self.groups.groups[name]
        known = ", ".join(self.groups.groups) or "none"
        raise PlanningError(
            f"There is no group '{name}': the groups are {known}",
            MoveItErrorCode.INVALID_GROUP_NAME,
        )

    def kinematics(
        self, group: JointGroup, model: KinematicModel, link: str = ""
    ) -> GroupKinematics:
        """Return the kinematics of a link that a group moves, its tip by default.

        Args:
            group: The group.
            model: Model to be moved.
            link: A link, or a frame of an attached object; empty for the group's tip.

        Raises:
            PlanningError: There is no such link, or the group does not move it.
        """
        link = link or group.tip
        tool = None
        if link and link not in model.links:
            fixed = self.scene.fixed_to(link)
            if fixed is None:
                raise PlanningError(
                    f"The robot has no link '{link}', and holds no object of that name",
                    MoveItErrorCode.INVALID_LINK_NAME,
                )
            link, tool = fixed
        if not link:
            # A gripper: joint goals need no tip, and the last of its links will do.
            link = model.description.joints[group.joints[-1]].child
        elif group.tip != link and not self._moves(group, link):
            raise PlanningError(
                f"The group '{group.name}' does not move '{link}'",
                MoveItErrorCode.INVALID_LINK_NAME,
            )
        try:
            return GroupKinematics(model, with_tip(group, link), tool)
        except UsageError as error:
            raise PlanningError(error.message, MoveItErrorCode.INVALID_GROUP_NAME) from error

    def _moves(self, group: JointGroup, link: str) -> bool:
        parents = {joint.child: joint for joint in self.scene.model.description.joints.values()}
        while link in parents:
            if parents[link].name in group.joints:
                return True
            link = parents[link].parent
        return False

    def solver(
        self,
        group: JointGroup,
        compiled: CompiledScene,
        link: str = "",
        *,
        avoid: bool,
        tolerance: Tolerance | None = None,
    ) -> IkSolver:
        """Return a solver of a group's inverse kinematics, to be used with the lock."""
        kinematics = self.kinematics(group, compiled.model, link)
        return IkSolver(
            kinematics,
            task=self.task(kinematics),
            tolerance=tolerance,
            clearance=compiled.clearance if avoid else None,
        )

    def task(self, kinematics: GroupKinematics) -> Any:
        """Return the task of a group for a link, from the cache."""
        key = (kinematics.group.name, kinematics.group.tip, kinematics.T_tip_tool.tobytes())
        if key not in self._tasks:
            self._tasks[key] = served_task(kinematics)
        return self._tasks[key]

    def limits(self, kinematics: GroupKinematics) -> MotionLimits:
        """Return the limits of a group's joints."""
        return MotionLimits.of(kinematics)

    # --- frames ---------------------------------------------------------------------------------

    def frame(self, name: str, scene: CollisionScene | None = None) -> np.ndarray:
        """Return the pose of a frame in the root link's frame, (4, 4).

        Raises:
            PlanningError: The frame is unknown.
        """
        name = name.removeprefix("/")
        if name in ("", self.root, self.planning_frame):
            return np.eye(4)
        with self.lock:
            self.update_state()
            found = (scene or self.scene).frame(name)
        if found is not None:
            return found
        return self.transform(name)

    def transform(self, frame: str) -> np.ndarray:
        """Return the newest pose of a frame of /tf in the root link's frame, (4, 4).

        Raises:
            PlanningError: The frame is unknown.
        """
        if self._tf is None:
            self._tf = LiveBuffer(node=self.node)
            TransformListener(self._tf, self.node)
            self._tf_since_s = time.monotonic()
        # Only what a new listener has not yet received is waited for: an unknown frame is answered.
        wait_s = max(0.0, self._tf_since_s + _FRAME_WAIT_S - time.monotonic())
        try:
            found = self._tf.lookup_transform(self.root, frame, 0, Duration(seconds=wait_s))
        except TransformException as error:
            raise PlanningError(
                f"The frame '{frame}' is unknown: {error}", MoveItErrorCode.FRAME_TRANSFORM_FAILURE
            ) from None
        return pose_matrix(transform_of(found.transform))

    # --- scene ----------------------------------------------------------------------------------

    def when_scene_changed(self, listener: Callable[[], object]) -> None:
        """Call a function after each change of the scene."""
        self._listeners.append(listener)

    def scene_changed(self) -> None:
        """Call the listeners of the scene."""
        for listener in self._listeners:
            listener()

    def apply_object(self, scene: CollisionScene, message: Any) -> None:
        """Apply a CollisionObject to a scene, with the lock.

        Raises:
            PlanningError: Its frame is unknown.
            UsageError, NotFoundError: It cannot be applied.
        """
        name, operation = message.id, _operation(message)
        if operation == messages.REMOVE:
            if name:
                scene.remove(name)
            else:
                scene.clear()
            return
        at = self.frame(message.header.frame_id, scene)
        if operation == messages.MOVE:
            if message.primitives or message.meshes or message.planes:
                self.node.get_logger().warning(
                    f"Move operation for object '{name}' ignores the geometry specified in the "
                    "message."
                )
            scene.move(name, *messages.read_move(message, at))
            return
        added = messages.read_object(message, at)
        for shape in added.shapes:
            if shape.warning:
                self.node.get_logger().warning(f"Collision object '{name}': {shape.warning}")
        if operation == messages.APPEND:
            scene.append(added)
        else:
            scene.add(messages.with_simulation_flags(added, scene.objects.get(name)))

    def apply_attached(self, scene: CollisionScene, message: Any) -> None:
        """Apply an AttachedCollisionObject to a scene, with the lock.

        Raises:
            PlanningError: Its frame is unknown.
            UsageError, NotFoundError: It cannot be applied.
        """
        self.update_state()
        given, link = message.object, message.link_name
        operation = _operation(given)
        if operation == messages.REMOVE:
            self._detach(scene, given.id, link)
            return
        if operation == messages.MOVE:
            raise UsageError(f"The attached object '{given.id}' cannot be moved: it is held")
        scene.model.body(link)
        weight = float(message.weight)
        if not (math.isfinite(weight) and weight >= 0.0):
            raise UsageError(
                f"The weight of the attached object '{given.id}' must be 0 kg or more, got {weight}"
            )
        if given.primitives or given.meshes or given.planes:
            at = self.frame(given.header.frame_id or link, scene)
            own = np.linalg.inv(scene.model.pose(link)) @ at
            one = messages.read_object(given, own)
            one = messages.with_simulation_flags(one, scene.objects.get(given.id))
        else:
            one = scene.take(given.id, link)
        attached = AttachedBody(
            one,
            link,
            frozenset(message.touch_links),
            weight,
            message.detach_posture if message.detach_posture.joint_names else None,
        )
        if operation == messages.APPEND:
            scene.append_attached(attached)
            return
        under = scene.attach(attached)
        if not weight:
            self.node.get_logger().info(
                f"Attached object '{given.id}' has no weight: as much as water in its shapes is "
                "assumed (field weight, kg)"
            )
        if under:
            self.node.get_logger().info(
                f"Attached object '{given.id}' may touch what it lies on: {', '.join(under)}"
            )

    def apply_scene(self, scene: CollisionScene, message: Any) -> list[str]:
        """Apply a PlanningScene message, with the lock; return what cannot be applied.

        A message that is no difference replaces all objects, attached objects and allowed
        collisions.
        """
        problems: list[str] = []
        if message.robot_model_name not in ("", scene.model.description.name):
            self.node.get_logger().warning(
                f"Setting the scene for model '{message.robot_model_name}' but model "
                f"'{scene.model.description.name}' is loaded."
            )
        if message.world.octomap.octomap.data:
            problems.append("Octomaps are not supported: give boxes or meshes")
        if message.name:
            scene.name = message.name
        if not message.is_diff:
            scene.clear()
        state = message.robot_state
        if not message.is_diff and not state.is_diff:
            for name in list(scene.attached):
                scene.drop(name)
        if message.allowed_collision_matrix.entry_names or not message.is_diff:
            problems += self._tried(lambda: self._set_allowed(scene, message))
        for each in message.link_padding:
            if self._is_size(scene, each.link_name, each.padding, problems):
                scene.padding_m[each.link_name] = float(each.padding)
        for each in message.link_scale:
            if self._is_size(scene, each.link_name, each.scale, problems):
                scene.scale[each.link_name] = float(each.scale)
        scene.changed()
        for each in message.object_colors:
            color = each.color
            scene.colors[each.id] = (color.r, color.g, color.b, color.a)
        for each in message.world.collision_objects:
            problems += self._tried(self.apply_object, scene, each)
        for each in state.attached_collision_objects:
            problems += self._tried(self.apply_attached, scene, each)
        return problems

    def _set_allowed(self, scene: CollisionScene, message: Any) -> None:
        if not message.allowed_collision_matrix.entry_names:
            # A new scene without a matrix: that of the robot is better than none.
            return
        scene.allowed = messages.read_allowed(message.allowed_collision_matrix)

    def _is_size(self, scene: CollisionScene, link: str, value: float, problems: list[str]) -> bool:
        """Return whether a padding or scale is about a link, and not negative."""
        if link not in scene.model.links:
            problems.append(f"Padding or scale of '{link}', which is no link of the robot")
        elif not (math.isfinite(value) and value >= 0.0):
            problems.append(f"Padding or scale of '{link}' must be 0 or more, got {value:g}")
        else:
            return True
        return False

    def _tried(self, apply: Callable[..., object], *arguments: object) -> list[str]:
        try:
            apply(*arguments)
        except TeleopctlError as error:
            return [f"{error.message} ({error.hint})" if error.hint else error.message]
        return []

    def _detach(self, scene: CollisionScene, name: str, link: str) -> None:
        if name:
            held = scene.attached.get(name)
            if held is not None and link and held.link != link:
                raise UsageError(f"The object '{name}' is attached to '{held.link}', not '{link}'")
            scene.detach(name)
            return
        for each in [one.object.name for one in scene.attached.values() if link in ("", one.link)]:
            scene.detach(each)


def _operation(message: Any) -> int:
    # The constants are bytes.
    value = message.operation
    return value[0] if isinstance(value, bytes) else int(value)


def _grippers(groups: RobotGroups, model: KinematicModel) -> list[tuple[str, str]]:
    """Return the pairs of fingers of each gripper, which close on each other."""
    pairs = []
    for effector in groups.end_effectors.values():
        gripper = groups.groups.get(effector.group)
        if gripper is None:
            continue
        links = [model.description.joints[name].child for name in gripper.joints]
        pairs += [(first, second) for first in links for second in links if first < second]
    return pairs
