"""Actions ``move_action`` and ``execute_trajectory``."""

from __future__ import annotations

import threading
import time
from typing import Any

from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import get_action, get_message
from teleopctl.kinematics import MoveItErrorCode, PlanningError
from teleopctl.node import ActionServer, CancelResponse, GoalResponse
from teleopctl.nodes.moveit.move_group import messages
from teleopctl.nodes.moveit.move_group.constraints import ConstraintSet
from teleopctl.nodes.moveit.move_group.context import MoveGroupContext
from teleopctl.nodes.moveit.move_group.execution import Execution, Outcome
from teleopctl.nodes.moveit.move_group.planning import Planned, Planning

# Time for which results are kept, s, as in rclcpp; rclpy keeps them for a quarter of an hour, with
# trajectories of hundreds of kilobytes.
_RESULT_S = 10.0
# Goals at once: with more, something sends them in a loop.
_MOST_GOALS = 20
_REPLAN_ATTEMPTS = 5

# Any, here and below: message classes are generated at run time from definitions.


class MoveGroupActions:
    """Servers of the actions ``move_action`` and ``execute_trajectory``.

    Each goal has a thread of its own, as in MoveIt.

    Args:
        context: Robot, state and scene.
        planning: Planner.
        execution: Executor of trajectories.
    """

    def __init__(self, context: MoveGroupContext, planning: Planning, execution: Execution) -> None:
        self._context, self._planning, self._execution = context, planning, execution
        self._log = context.node.get_logger()
        self._goals = 0
        self._move = self._serve("moveit_msgs/action/MoveGroup", "move_action", self._on_move)
        self._execute = self._serve(
            "moveit_msgs/action/ExecuteTrajectory", "execute_trajectory", self._on_execute
        )

    def _serve(self, type_name: str, name: str, run: Any) -> Any:
        def begin(handle: Any) -> None:
            self._goals += 1
            if not handle.is_cancel_requested:
                handle.executing()
            threading.Thread(target=self._run, args=(handle, run), name=name, daemon=True).start()

        def accept(goal: object) -> GoalResponse:
            del goal
            if self._goals < _MOST_GOALS:
                return GoalResponse.ACCEPT
            self._log.warning(f"{name}: a goal is rejected, since {self._goals} are under way")
            return GoalResponse.REJECT

        return ActionServer(
            self._context.node,
            get_action(type_name),
            name,
            None,
            handle_accepted_callback=begin,
            goal_callback=accept,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
            result_timeout=_RESULT_S,
        )

    def _run(self, handle: Any, run: Any) -> None:
        try:
            run(handle)
        except Exception as error:  # noqa: BLE001 - raised again where the node spins
            self._context.node.fail(error)
        finally:
            self._goals -= 1

    # --- execute_trajectory ---------------------------------------------------------------------

    def _on_execute(self, handle: Any) -> None:
        action = get_action("moveit_msgs/action/ExecuteTrajectory")
        self._log.info("Execution request received")
        handle.publish_feedback(action.Feedback(state="MONITOR"))
        outcome = self._execution.execute(
            handle.request.trajectory,
            named=list(handle.request.controller_names),
            is_canceled=lambda: handle.is_cancel_requested,
        )
        self._say("Execution completed", outcome)
        result = action.Result(error_code=messages.error_code(outcome.code, outcome.text))
        handle.publish_feedback(action.Feedback(state="IDLE"))
        _end(handle, outcome, result)

    # --- move_action ----------------------------------------------------------------------------

    def _on_move(self, handle: Any) -> None:
        action = get_action("moveit_msgs/action/MoveGroup")
        result = action.Result()
        begin_s = time.monotonic()

        def tell(state: str) -> None:
            handle.publish_feedback(action.Feedback(state=state))

        outcome = self._move_goal(handle, result, tell)
        if not result.planning_time:
            result.planning_time = time.monotonic() - begin_s
        result.error_code = messages.error_code(outcome.code, outcome.text)
        self._say("move_action", outcome)
        tell("IDLE")
        _end(handle, outcome, result)

    def _move_goal(self, handle: Any, result: Any, tell: Any) -> Outcome:
        """Plan, and execute unless the request is for a plan only; return the end."""
        request, options = handle.request.request, handle.request.planning_options
        self._mention_unused(options)
        plan_only = bool(options.plan_only) or not self._execution.is_allowed()
        if plan_only and not options.plan_only:
            self._log.warning(
                "This instance of MoveGroup is not allowed to execute trajectories but the goal "
                "request has plan_only set to false. Only a motion plan will be computed anyway."
            )
        diff = options.planning_scene_diff
        if not plan_only and self._is_met(request):
            self._log.info(
                "Goal constraints are already satisfied. No need to plan or execute any motions"
            )
            return Outcome(MoveItErrorCode.SUCCESS)
        if not plan_only:
            # The plan begins where the arm comes to rest.
            self._execution.end_present()
        attempts = 1
        if options.replan and not plan_only:
            attempts = int(options.replan_attempts) or _REPLAN_ATTEMPTS
        outcome = Outcome(MoveItErrorCode.FAILURE)
        for attempt in range(attempts):
            tell("PLANNING")
            begin_s = time.monotonic()
            try:
                planned = self._planning.plan(
                    self._from_now(request, plan_only),
                    _or_none(diff),
                    lambda: handle.is_cancel_requested,
                )
            except PlanningError as error:
                outcome = Outcome(error.code, error.message)
                again = error.code in (MoveItErrorCode.PLANNING_FAILED, MoveItErrorCode.TIMED_OUT)
            except TeleopctlError as error:
                return Outcome(MoveItErrorCode.FAILURE, error.message)
            else:
                result.planning_time = time.monotonic() - begin_s
                self._fill(result, planned)
                if plan_only:
                    return Outcome(MoveItErrorCode.SUCCESS, "; ".join(planned.plan.notes))
                if handle.is_cancel_requested:
                    return Outcome(MoveItErrorCode.PREEMPTED, "The goal was canceled")
                tell("MONITOR")
                outcome = self._follow(handle, planned, result)
                again = (
                    outcome.code is MoveItErrorCode.MOTION_PLAN_INVALIDATED_BY_ENVIRONMENT_CHANGE
                )
            if handle.is_cancel_requested:
                return Outcome(MoveItErrorCode.PREEMPTED, "The goal was canceled")
            if not again or attempt + 1 == attempts:
                break
            self._log.info(f"{outcome.text}: planning again ({attempt + 2} of {attempts})")
            if options.replan_delay > 0.0:
                time.sleep(min(float(options.replan_delay), 10.0))
        return outcome

    def _follow(self, handle: Any, planned: Planned, result: Any) -> Outcome:
        """Execute a plan, while its rest is checked whenever the scene changes."""
        context, plan = self._context, planned.plan

        def is_valid(spent_s: float) -> str:
            with context.lock:
                compiled = context.scene.compile()
            compiled.model.set_positions(context.measured())
            kinematics = context.kinematics(
                planned.kinematics.group, compiled.model, planned.kinematics.group.tip
            )
            for at_s, positions in zip(plan.times.tolist(), plan.positions, strict=True):
                if at_s < spent_s - 0.1:
                    continue
                kinematics.set(positions)
                if touching := compiled.clearance.collisions():
                    first, second = touching[0].bodies
                    return (
                        "The scene changed during execution, and the rest of the path would let "
                        f"'{first}' and '{second}' collide"
                    )
            return ""

        outcome = self._execution.execute(
            result.planned_trajectory,
            is_canceled=lambda: handle.is_cancel_requested,
            is_valid=is_valid,
        )
        if outcome.code is MoveItErrorCode.SUCCESS:
            result.executed_trajectory = result.planned_trajectory
        return outcome

    def _is_met(self, request: Any) -> bool:
        """Return whether the robot's present state meets a goal and the path constraints."""
        context = self._context
        try:
            group = context.group(request.group_name)
            if not request.goal_constraints or context.state_problem(group.joints):
                return False
            with context.lock:
                context.update_state()
                model = context.scene.model
                path = ConstraintSet(context, request.path_constraints, None, model)
                if path.unmet():
                    return False
                return any(
                    (goal := ConstraintSet(context, message, None, model)) and not goal.unmet()
                    for message in request.goal_constraints
                )
        except PlanningError:
            return False

    def _from_now(self, request: Any, plan_only: bool) -> Any:
        """Return a request that begins at the robot's present state if it is to be executed.

        Raises:
            PlanningError: The start state has values that are no positions.
        """
        state = request.start_state
        if plan_only or not state.joint_state.name:
            return request
        measured = self._context.measured()
        given = self._context.positions(state)
        if any(abs(at - measured.get(name, at)) > 1e-3 for name, at in given.items()):
            self._log.warning(
                "Execution of motions should always start at the robot's current state. Ignoring "
                "the state supplied as start state in the motion planning request"
            )
        state.joint_state = get_message("sensor_msgs/msg/JointState")()
        return request

    def _fill(self, result: Any, planned: Planned) -> None:
        frame = self._context.planning_frame
        result.planned_trajectory = messages.write_trajectory(planned.plan, frame)
        result.trajectory_start = messages.write_robot_state(planned.start, frame)

    def _mention_unused(self, options: Any) -> None:
        if options.look_around:
            self._log.info("look_around has no effect: there is no sensor that is moved to look")

    def _say(self, what: str, outcome: Outcome) -> None:
        if outcome.code is MoveItErrorCode.SUCCESS:
            self._log.info(f"{what}: SUCCEEDED")
        else:
            self._log.warning(f"{what}: {outcome.code.name}: {outcome.text}")


def _or_none(diff: Any) -> Any:
    """Return a PlanningScene of changes; None if it changes nothing."""
    world, state = diff.world, diff.robot_state
    changes = (
        world.collision_objects,
        state.attached_collision_objects,
        diff.allowed_collision_matrix.entry_names,
        diff.link_padding,
        diff.link_scale,
    )
    if not any(len(each) for each in changes):
        return None
    diff.is_diff = state.is_diff = True
    return diff


def _end(handle: Any, outcome: Outcome, result: Any) -> None:
    if outcome.code is MoveItErrorCode.SUCCESS:
        handle.succeed(result)
    elif handle.is_cancel_requested:
        handle.canceled(result)
    else:
        handle.abort(result)
