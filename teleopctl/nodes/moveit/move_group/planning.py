"""Motion planning: requests, plans, and MoveIt's services for them."""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from teleopctl.commander import read_pose
from teleopctl.errors import TeleopctlError, UsageError
from teleopctl.interfaces import get_message, get_service
from teleopctl.kinematics import (
    CollisionScene,
    CompiledScene,
    GroupKinematics,
    MotionPlan,
    MotionSettings,
    MoveItErrorCode,
    PlanningError,
    has_ompl,
    overload_note,
    plan_line,
    plan_to_joints,
    planner_names,
    planner_parameters,
)
from teleopctl.node import MutuallyExclusiveCallbackGroup
from teleopctl.nodes.moveit.move_group import messages
from teleopctl.nodes.moveit.move_group.constraints import ConstraintSet
from teleopctl.nodes.moveit.move_group.context import MoveGroupContext
from teleopctl.nodes.moveit.move_group.goals import goal_link, joint_goal, pose_goal, solutions
from teleopctl.nodes.moveit.move_group.parameters import setting

# Time for a request that allows none, s, as in MoveIt.
_DEFAULT_PLANNING_TIME_S = 1.0
_PILZ = "pilz_industrial_motion_planner"
# Step along a straight line of the Pilz planner's LIN, m.
_LINE_STEP_M = 0.005
_DISPLAY_DEPTH = 10

# Any, here and below: message classes are generated at run time from definitions.


@dataclass(frozen=True)
class Planned:
    """Plan with its start state.

    Attributes:
        plan: The plan.
        start: Positions of all joints at its start, rad or m.
        compiled: Compiled scene in which it was planned.
        kinematics: Kinematics of its group, on that scene.
        scene: The scene.
    """

    plan: MotionPlan
    start: dict[str, float]
    compiled: CompiledScene
    kinematics: GroupKinematics
    scene: CollisionScene


class Planning:
    """Planner of requests, with MoveIt's services.

    These are ``plan_kinematic_path``, ``compute_cartesian_path``, ``query_planner_interface``,
    ``get_planner_params`` and ``set_planner_params``.

    Args:
        context: Robot, state and scene.
    """

    def __init__(self, context: MoveGroupContext) -> None:
        self._context, node = context, context.node
        self._log = node.get_logger()
        self._said: set[str] = set()
        self._params: dict[tuple[str, str, str], dict[str, str]] = {}
        # Planning takes long: it does not keep the scene's services waiting.
        group = MutuallyExclusiveCallbackGroup()
        self._display = node.create_publisher(
            get_message("moveit_msgs/msg/DisplayTrajectory"), "display_planned_path", _DISPLAY_DEPTH
        )
        for type_name, name, callback in (
            ("moveit_msgs/srv/GetMotionPlan", "plan_kinematic_path", self._plan_service),
            ("moveit_msgs/srv/GetCartesianPath", "compute_cartesian_path", self._line_service),
        ):
            node.create_service(get_service(type_name), name, callback, callback_group=group)
        for type_name, name, callback in (
            ("moveit_msgs/srv/QueryPlannerInterfaces", "query_planner_interface", self._query),
            ("moveit_msgs/srv/GetPlannerParams", "get_planner_params", self._get_params),
            ("moveit_msgs/srv/SetPlannerParams", "set_planner_params", self._set_params),
        ):
            node.create_service(get_service(type_name), name, callback)

    # --- plans ----------------------------------------------------------------------------------

    def plan(
        self,
        request: Any,
        scene_diff: Any = None,
        is_canceled: Callable[[], bool] | None = None,
    ) -> Planned:
        """Return a plan for a MotionPlanRequest.

        Args:
            request: A ``moveit_msgs/msg/MotionPlanRequest``.
            scene_diff: A PlanningScene of changes that hold for this plan alone; None for none.
            is_canceled: Whether the search shall end; None for never.

        Raises:
            PlanningError: There is no plan; with MoveIt's code.
        """
        context = self._context
        group = context.group(request.group_name)
        self._mention_unused(request)
        planner = self._planner(request)
        if not request.goal_constraints:
            raise PlanningError(
                "The request has no goal constraints", MoveItErrorCode.INVALID_GOAL_CONSTRAINTS
            )
        link = goal_link(request.goal_constraints[0])
        with context.lock:
            start = context.positions(request.start_state)
            scene = context.scene_of(request.start_state)
            if scene_diff is not None:
                scene = scene.copy()
                context.apply_scene(scene, scene_diff)
            compiled = scene.compile()
        compiled.model.set_positions(start)
        kinematics = context.kinematics(group, compiled.model, link)
        given = set(request.start_state.joint_state.name)
        if problem := context.state_problem(
            tuple(name for name in kinematics.names if name not in given)
        ):
            raise PlanningError(problem, MoveItErrorCode.ROBOT_STATE_STALE)
        vector = kinematics.vector(start)
        path = ConstraintSet(context, request.path_constraints, kinematics)
        if violated := path.violation(vector):
            raise PlanningError(
                f"The start violates the path constraints: {violated}",
                MoveItErrorCode.START_STATE_VIOLATES_PATH_CONSTRAINTS,
            )
        settings = replace(self._settings(request, planner, kinematics), is_canceled=is_canceled)
        plan = self._search(request, kinematics, vector, compiled, path, settings)
        plan = self._slowed(plan, kinematics, request)
        for note in plan.notes:
            self._log.info(note)
        if scene.attached and (note := overload_note(kinematics, plan)):
            held = ", ".join(f"'{name}' ({compiled.mass(name):.3g} kg)" for name in scene.attached)
            self._log.warning(f"{note}, with {held}")
            plan = replace(plan, notes=(*plan.notes, f"{note}, with {held}"))
        planned = Planned(plan, start, compiled, kinematics, scene)
        self._publish(planned)
        return planned

    def _search(
        self,
        request: Any,
        kinematics: GroupKinematics,
        start: np.ndarray,
        compiled: CompiledScene,
        path: ConstraintSet,
        settings: MotionSettings,
    ) -> MotionPlan:
        """Return a plan to any of the goals.

        Raises:
            PlanningError: There is none; with the code of the first goal.
        """
        goals: list[np.ndarray] = []
        first: PlanningError | None = None
        for message in request.goal_constraints:
            try:
                goals += self._goals(message, kinematics, start, compiled, path)
            except PlanningError as error:
                first = first or error
        if not goals:
            assert first is not None
            raise first
        begin_s = time.monotonic()
        if request.pipeline_id == _PILZ and request.planner_id == "LIN":
            kinematics.set(goals[0])
            target = kinematics.pose()
            kinematics.set(start)
            return plan_line(
                kinematics,
                start,
                [target],
                max_step_m=_LINE_STEP_M,
                clearance=compiled.clearance,
                condition=path.condition(),
                settings=settings,
            )
        attempts = max(1, int(request.num_planning_attempts))
        for attempt in range(attempts):
            left_s = settings.timeout_s - (time.monotonic() - begin_s)
            try:
                return plan_to_joints(
                    kinematics,
                    start,
                    goals,
                    clearance=compiled.clearance,
                    condition=path.condition(),
                    settings=replace(settings, seed=attempt, timeout_s=max(left_s, 1e-3)),
                )
            except PlanningError as error:
                again = error.code in (MoveItErrorCode.PLANNING_FAILED, MoveItErrorCode.TIMED_OUT)
                left_s = settings.timeout_s - (time.monotonic() - begin_s)
                if not again or attempt + 1 == attempts or left_s <= 0.0:
                    raise
        raise AssertionError

    def _goals(
        self,
        message: Any,
        kinematics: GroupKinematics,
        start: np.ndarray,
        compiled: CompiledScene,
        path: ConstraintSet,
    ) -> list[np.ndarray]:
        """Return the positions, (n,) each, that meet one goal."""
        context = self._context
        constraints = ConstraintSet(context, message, kinematics)
        if not constraints:
            raise PlanningError(
                "A goal has no constraints", MoveItErrorCode.INVALID_GOAL_CONSTRAINTS
            )
        if constraints.joints:
            if constraints.regions or constraints.orientations:
                raise PlanningError(
                    "A goal of joints and of a pose at once is not supported",
                    MoveItErrorCode.INVALID_GOAL_CONSTRAINTS,
                )
            return [joint_goal(constraints, kinematics, start)]
        kinematics.set(start)
        if not constraints.orientations:
            # A position is reached at the rotation that is kept on the way.
            link = goal_link(message)
            constraints.orientations = [one for one in path.orientations if one.link == link]
        goal = pose_goal(constraints, kinematics)
        return solutions(
            goal,
            kinematics,
            start,
            compiled.clearance,
            context.task(kinematics),
            path,
        )

    def _settings(self, request: Any, planner: str, kinematics: GroupKinematics) -> MotionSettings:
        timeout_s = float(request.allowed_planning_time)
        if not (math.isfinite(timeout_s) and timeout_s > 0.0):
            timeout_s = _DEFAULT_PLANNING_TIME_S
            self._say(f"The planning request had no allowed planning time: {timeout_s:g} s is used")
        return MotionSettings(
            planner=planner,
            timeout_s=timeout_s,
            velocity_scaling=self._scaling("velocity", request.max_velocity_scaling_factor),
            acceleration_scaling=self._scaling(
                "acceleration", request.max_acceleration_scaling_factor
            ),
            limits=self._context.limits(kinematics),
            parameters=self._parameters(request, planner),
        )

    def _parameters(self, request: Any, planner: str) -> dict[str, str]:
        """Return the parameters of ``set_planner_params`` that a request's planner has."""
        given = self._merged_params(request.pipeline_id, request.planner_id, request.group_name)
        if not given:
            return {}
        known = planner_parameters(planner)
        return {name: value for name, value in given.items() if name in known}

    def _scaling(self, word: str, value: float) -> float:
        """Return a scaling factor as MoveIt understands it: 1 for one that is not above 0 to 1.

        Raises:
            PlanningError: It is not finite, which must not become the full speed.
        """
        if not math.isfinite(value):
            raise PlanningError(
                f"max_{word}_scaling_factor is {value:g}, and not from 0 to 1",
                MoveItErrorCode.FAILURE,
            )
        if 0.0 < value <= 1.0:
            return float(value)
        if value != 0.0:
            self._log.warning(
                f"Invalid max_{word}_scaling_factor {value:g} specified, defaulting to 1 instead."
            )
        return 1.0

    def _slowed(self, plan: MotionPlan, kinematics: GroupKinematics, request: Any) -> MotionPlan:
        """Return a plan in which a link's speed is at most that of the request."""
        most = float(request.max_cartesian_speed)
        if not (math.isfinite(most) and most > 0.0) or len(plan.times) < 2:
            return plan
        link = request.cartesian_speed_limited_link or kinematics.group.tip
        points = []
        for positions in plan.positions:
            kinematics.set(positions)
            pose = self._context.scene.frame(link) if link not in kinematics.model.links else None
            points.append((kinematics.model.pose(link) if pose is None else pose)[:3, 3])
        kinematics.set(plan.positions[0])
        speeds = np.linalg.norm(np.diff(points, axis=0), axis=1) / np.diff(plan.times)
        factor = max(1.0, float(speeds.max()) / most)
        return replace(
            plan,
            times=plan.times * factor,
            velocities=plan.velocities / factor,
            accelerations=plan.accelerations / factor**2,
        )

    def _publish(self, planned: Planned) -> None:
        if not self._display.get_subscription_count():
            return
        frame = self._context.planning_frame
        message: Any = get_message("moveit_msgs/msg/DisplayTrajectory")(
            model_id=planned.kinematics.model.description.name
        )
        message.trajectory = [messages.write_trajectory(planned.plan, frame)]
        message.trajectory_start = messages.write_robot_state(
            planned.start, frame, planned.scene.attached.values()
        )
        self._display.publish(message)

    def _mention_unused(self, request: Any) -> None:
        corner = request.workspace_parameters.max_corner
        if corner.x or corner.y or corner.z:
            self._say(
                "workspace_parameters have no effect: planning uses all that the arm can reach"
            )
        if request.trajectory_constraints.constraints:
            self._say("trajectory_constraints have no effect: there is no planner that uses them")
        if request.reference_trajectories:
            self._say("reference_trajectories have no effect: there is no planner that uses them")

    def _say(self, sentence: str) -> None:
        """Log a sentence once."""
        if sentence not in self._said:
            self._said.add(sentence)
            self._log.info(sentence)

    # --- planners -------------------------------------------------------------------------------

    def _planner(self, request: Any) -> str:
        """Return OMPL's name of the planner that a request selects.

        Raises:
            PlanningError: There is no such pipeline or planner.
        """
        pipeline, name = request.pipeline_id, request.planner_id
        if pipeline == _PILZ or name in ("LIN", "PTP", "CIRC"):
            if name == "CIRC":
                raise PlanningError(
                    "Arcs (CIRC) are not supported: plan straight lines (LIN) between points of it",
                    MoveItErrorCode.PLANNING_FAILED,
                )
            return ""
        if pipeline not in ("", "ompl"):
            self._say(f"There is no planning pipeline '{pipeline}': 'ompl' plans instead")
        if match := re.fullmatch(r".*\[(.*)\]", name):
            name = match[1]
        node = self._context.node
        configured = setting(
            node,
            f"ompl.planner_configs.{name}.type",
            setting(node, f"planner_configs.{name}.type", ""),
        )
        name = str(configured or name)
        return (
            name.removeprefix("geometric::").removesuffix("kConfigDefault").removesuffix("kDefault")
        )

    def _query(self, request: Any, response: Any) -> Any:
        del request
        description: Any = get_message("moveit_msgs/msg/PlannerInterfaceDescription")
        names = planner_names()
        library = "OMPL" if has_ompl() else "teleopctl"
        response.planner_interfaces = [
            description(name=library, pipeline_id="ompl", planner_ids=list(names)),
            description(name="teleopctl lines", pipeline_id=_PILZ, planner_ids=["LIN", "PTP"]),
        ]
        return response

    def _get_params(self, request: Any, response: Any) -> Any:
        merged = self._merged_params(request.pipeline_id, request.planner_config, request.group)
        response.params.keys, response.params.values = list(merged), list(merged.values())
        response.params.descriptions = [""] * len(merged)
        return response

    def _merged_params(self, pipeline: str, planner: str, group: str) -> dict[str, str]:
        """Return the parameters of a planner, those of a group before those of all groups."""
        return {
            **self._params.get((pipeline, planner, ""), {}),
            **self._params.get((pipeline, planner, group), {}),
        }

    def _set_params(self, request: Any, response: Any) -> Any:
        key = (request.pipeline_id, request.planner_config, request.group)
        given = dict(zip(request.params.keys, request.params.values, strict=False))
        self._params[key] = given if request.replace else {**self._params.get(key, {}), **given}
        try:
            known = {"type", *planner_parameters(request.planner_config)}
        except UsageError as error:
            self._log.warning(f"set_planner_params: {error.message}")
            return response
        if unused := sorted(given.keys() - known):
            self._log.info(f"Planner parameters are kept and have no effect: {', '.join(unused)}")
        return response

    # --- services -------------------------------------------------------------------------------

    def _plan_service(self, request: Any, response: Any) -> Any:
        answer = response.motion_plan_response
        answer.group_name = request.motion_plan_request.group_name
        begin_s = time.monotonic()
        frame = self._context.planning_frame
        try:
            planned = self.plan(request.motion_plan_request)
        except (PlanningError, TeleopctlError) as error:
            answer.error_code = self.refused("plan_kinematic_path", error)
        else:
            answer.trajectory = messages.write_trajectory(planned.plan, frame)
            answer.trajectory_start = messages.write_robot_state(planned.start, frame)
            answer.error_code = messages.error_code(
                MoveItErrorCode.SUCCESS, "; ".join(planned.plan.notes)
            )
        answer.planning_time = time.monotonic() - begin_s
        return response

    def _line_service(self, request: Any, response: Any) -> Any:
        try:
            planned = self._line(request)
        except (PlanningError, TeleopctlError) as error:
            response.error_code = self.refused("compute_cartesian_path", error)
            return response
        frame = self._context.planning_frame
        response.start_state = messages.write_robot_state(planned.start, frame)
        response.solution = messages.write_trajectory(planned.plan, frame)
        response.fraction = planned.plan.fraction
        response.error_code = messages.error_code(
            MoveItErrorCode.SUCCESS, "; ".join(planned.plan.notes)
        )
        self._publish(planned)
        return response

    def _line(self, request: Any) -> Planned:
        context = self._context
        group = context.group(request.group_name)
        if not (math.isfinite(request.max_step) and request.max_step > 0.0):
            raise PlanningError(
                "Maximum step to take between consecutive configurations along Cartesian path was "
                f"not specified (this value needs to be > 0): {request.max_step:g}",
                MoveItErrorCode.FAILURE,
            )
        with context.lock:
            start = context.positions(request.start_state)
            scene = context.scene_of(request.start_state)
            compiled = scene.compile()
        compiled.model.set_positions(start)
        kinematics = context.kinematics(group, compiled.model, request.link_name)
        given = set(request.start_state.joint_state.name)
        if problem := context.state_problem(
            tuple(name for name in kinematics.names if name not in given)
        ):
            raise PlanningError(problem, MoveItErrorCode.ROBOT_STATE_STALE)
        at = context.frame(request.header.frame_id, scene)
        is_own = request.header.frame_id not in ("", context.root) and request.header.frame_id in (
            request.link_name,
            kinematics.group.tip,
        )
        poses: list[np.ndarray] = []
        for number, message in enumerate(request.waypoints, 1):
            try:
                pose = read_pose(message, f"Waypoint {number}")
            except UsageError as error:
                raise PlanningError(
                    error.message, MoveItErrorCode.INVALID_GOAL_CONSTRAINTS
                ) from error
            # In the frame of the link itself each waypoint begins at the one before, as in MoveIt.
            base = poses[-1] if is_own and poses else kinematics.pose() if is_own else at
            poses.append(np.asarray(base @ pose))
        vector = kinematics.vector(start)
        path = ConstraintSet(context, request.path_constraints, kinematics)
        settings = replace(self._settings(_LineRequest(request), "", kinematics), timeout_s=30.0)
        if not poses:
            still = np.vstack((vector,))
            nothing = np.zeros_like(still)
            plan = MotionPlan(
                kinematics.names, np.zeros(1), still, nothing, nothing, "", 0.0, 0.0, still
            )
        else:
            plan = plan_line(
                kinematics,
                vector,
                poses,
                max_step_m=float(request.max_step),
                jump_factor=max(float(request.jump_threshold), 0.0),
                jump_rad=max(float(request.revolute_jump_threshold), 0.0),
                jump_m=max(float(request.prismatic_jump_threshold), 0.0),
                task=context.task(kinematics),
                clearance=compiled.clearance if request.avoid_collisions else None,
                condition=path.condition(),
                settings=settings,
                least_fraction=0.0,
            )
        plan = self._slowed(plan, kinematics, request)
        self._log.info(
            f"Computed Cartesian path with {len(plan.times)} points (followed "
            f"{100.0 * plan.fraction:f}% of requested trajectory)"
        )
        for note in plan.notes:
            self._log.info(note)
        return Planned(plan, start, compiled, kinematics, scene)

    def refused(self, what: str, error: TeleopctlError) -> Any:
        """Log why a request is refused; return it as MoveItErrorCodes."""
        code = error.code if isinstance(error, PlanningError) else MoveItErrorCode.FAILURE
        self._log.warning(f"{what}: {error.message}")
        return messages.error_code(code, error.message)


class _LineRequest:
    """Scaling factors of a GetCartesianPath request, as attributes of a MotionPlanRequest."""

    allowed_planning_time = _DEFAULT_PLANNING_TIME_S
    pipeline_id = planner_id = group_name = ""

    def __init__(self, request: Any) -> None:
        self.max_velocity_scaling_factor = request.max_velocity_scaling_factor
        self.max_acceleration_scaling_factor = request.max_acceleration_scaling_factor
