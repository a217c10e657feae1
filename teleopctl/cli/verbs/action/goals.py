"""``teleopctl action goals`` and ``cancel``: goals that other programs have sent."""

import threading
import time

from teleopctl.base.typed import TYPE_CHECKING, Annotated, Any
from teleopctl.cli import console
from teleopctl.cli.graph_lookup import absolute_name
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option
from teleopctl.errors import NotFoundError, RefusedError, UnavailableError, existing_names_hint

if TYPE_CHECKING:
    from collections.abc import Sequence

    from teleopctl.node import Node

# Time within which an action server's latched goal states are there, s.
_GATHER_S = 1.0
_TIMEOUT_S = 5.0
# Return codes of action_msgs/srv/CancelGoal.
_REJECTED, _UNKNOWN_GOAL, _TERMINATED = 1, 2, 3
# States of a goal that has not ended: accepted, executing, canceling.
_ACTIVE = (1, 2, 3)


class _Goal:
    """A goal of an action, with its state.

    Attributes:
        action: Name of the action.
        id: The goal's ID as hexadecimal digits.
        state: State, such as EXECUTING.
        is_active: Whether the goal has not ended.
        accepted_ns: Time at which the server accepted it, ns since the epoch.
    """

    __slots__ = ("accepted_ns", "action", "id", "is_active", "state")

    # Any: a message of action_msgs, whose class is created at run time.
    def __init__(self, action: str, status: Any) -> None:
        from teleopctl.node import GoalState

        info = status.goal_info
        self.action = action
        self.id = bytes(bytearray(info.goal_id.uuid)).hex()
        self.state = GoalState(status.status).name
        self.is_active = status.status in _ACTIVE
        self.accepted_ns = info.stamp.sec * 1_000_000_000 + info.stamp.nanosec


def list_goals(
    action_name: Annotated[
        str | None, Argument(help="The action; by default all.", complete="actions")
    ] = None,
    include_ended: Annotated[
        bool, Option("-a", "--all", help="Include goals that have ended, which servers remember.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """List the goals of one action or of all: ID, state and how long ago they were accepted."""
    from teleopctl.cli.command_node import command_node

    with command_node(session_mode="client") as node:
        goals = _goals(node, _actions(node, action_name))
        now_ns = node.get_clock().now().nanoseconds
    shown = [goal for goal in goals if goal.is_active or include_ended]
    if as_json:
        console.out_json(
            [
                {"action": goal.action, "id": goal.id, "state": goal.state}
                | {"accepted_at": goal.accepted_ns / 1e9}
                for goal in shown
            ]
        )
        return
    width = max((len(goal.state) for goal in shown), default=0)
    for goal in shown:
        age_s = max(0.0, (now_ns - goal.accepted_ns) / 1e9)
        console.out(f"{goal.action}  {goal.id}  {goal.state:{width}}  {age_s:.0f} s ago")
    if not shown:
        console.note("No goals." if include_ended else "No goals that are under way.")


def cancel_goals(
    action_name: Annotated[str, Argument(help="The action.", complete="actions")],
    goal_id: Annotated[
        str | None,
        Option("--id", help="Cancel this goal alone: its ID, or the first digits of it."),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Cancel all goals of an action, or the one with an ID; return when the server has accepted it.

    The goals end when the server has stopped them: `teleopctl action goals` shows it.
    """
    from teleopctl.cli.command_node import command_node
    from teleopctl.interfaces import get_service

    with command_node(session_mode="client") as node:
        (name,) = _actions(node, action_name)
        service: Any = get_service("action_msgs/srv/CancelGoal")
        request = service.Request()
        goals = _goals(node, [name])
        if goal_id is not None:
            goal = _goal_with_id(goals, goal_id, name)
            request.goal_info.goal_id.uuid = bytes.fromhex(goal.id)
        elif not any(goal.is_active for goal in goals):
            if as_json:
                console.out_json({"action": name, "canceling": []})
            else:
                console.note(f"'{name}' has no goals that are under way.")
            return
        client = node.create_client(service, f"{name}/_action/cancel_goal")
        response: Any = client.call_async(request).wait_for_response(_TIMEOUT_S)
    if response is None:
        raise UnavailableError(
            f"The server of '{name}' does not respond within {_TIMEOUT_S:g} s",
            hint="It may execute a goal in the thread that takes requests.",
        )
    if response.return_code == _REJECTED:
        raise RefusedError(f"The server of '{name}' rejects the request")
    if response.return_code in (_UNKNOWN_GOAL, _TERMINATED):
        ended = response.return_code == _TERMINATED
        raise NotFoundError("The goal has ended" if ended else "The server does not know this goal")
    ids = [bytes(bytearray(info.goal_id.uuid)).hex() for info in response.goals_canceling]
    if as_json:
        console.out_json({"action": name, "canceling": ids})
    else:
        console.out_lines(f"{name}  {each}  CANCELING" for each in ids)


def _actions(node: "Node", action_name: str | None) -> list[str]:
    """Return the full names of actions with a server: the given one, or all.

    Raises:
        NotFoundError: The action has no server.
    """
    graph = node.graph()
    served = [name for name, _ in graph.action_names_and_types() if graph.action_servers(name)]
    if action_name is None:
        return served
    name = absolute_name(action_name)
    if name not in served:
        hint = existing_names_hint("actions", [name], served, served)
        raise NotFoundError(f"Action '{name}' has no server", hint=hint)
    return [name]


def _goals(node: "Node", actions: "Sequence[str]") -> list[_Goal]:
    """Return the goals of actions, from the newest states that their servers publish, latched."""
    from teleopctl.interfaces import get_message
    from teleopctl.node import qos_profile_action_status_default

    newest: dict[str, Any] = {}
    changed = threading.Condition()

    def subscribe(action: str) -> None:
        # Any: a message of action_msgs, whose class is created at run time.
        def receive(message: Any) -> None:
            with changed:
                newest[action] = message
                changed.notify()

        node.create_subscription(
            get_message("action_msgs/msg/GoalStatusArray"),
            f"{action}/_action/status",
            receive,
            qos_profile_action_status_default,
            immediate=True,
        )

    for action in actions:
        subscribe(action)
    deadline = time.monotonic() + _GATHER_S
    with changed:
        # A server without goals has published nothing.
        while len(newest) < len(actions) and (left := deadline - time.monotonic()) > 0:
            changed.wait(left)
    goals = [
        _Goal(action, status) for action, array in newest.items() for status in array.status_list
    ]
    return sorted(goals, key=lambda goal: (goal.action, goal.accepted_ns))


def _goal_with_id(goals: "Sequence[_Goal]", beginning: str, action: str) -> _Goal:
    """Return the goal whose ID begins with some digits.

    Raises:
        NotFoundError: There is no such goal, or there are several.
    """
    found = [goal for goal in goals if goal.id.startswith(beginning.lower().replace("-", ""))]
    if len(found) == 1:
        return found[0]
    if found:
        raise NotFoundError(f"{len(found)} goals of '{action}' have an ID with {beginning}")
    known = ", ".join(goal.id for goal in goals if goal.is_active)
    raise NotFoundError(
        f"'{action}' has no goal with the ID {beginning}",
        hint=f"Under way: {known}." if known else None,
    )
