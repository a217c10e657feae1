"""``teleopctl stop --robot``: stops the robot's motion, and releases it again."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from teleopctl.base.start_timeouts import StartTimeouts
from teleopctl.cli import console
from teleopctl.cli.command_node import command_node
from teleopctl.cli.verbs.run import command_of, find_program, start_in_background
from teleopctl.errors import RefusedError, UnavailableError
from teleopctl.interfaces import get_message, get_service
from teleopctl.node import (
    RELEASE_SERVICE,
    RELEASE_TYPE,
    STOP_TOPIC,
    Future,
    SingleThreadedExecutor,
    StopButton,
    StopHolders,
    qos_profile_latched,
)

if TYPE_CHECKING:
    from teleopctl.node import Node

_HOLDER = "robot_stop"
_STATE = "/is_stopped"
# Longest wait until all controller managers have stopped the robot, in seconds.
_LONGEST_WAIT_S = 3.0


def stop_robot(as_json: bool) -> int:
    """Stop the motion of every robot in the graph, and keep a node running that holds it."""
    with _graph() as graph:
        graph.button.press()
        managers = graph.managers()
        late = graph.wait(managers, stopped=True)
        if f"/{_HOLDER}" not in graph.button.others():
            program, arguments = find_program([_HOLDER])
            start_in_background(_HOLDER, command_of(program, arguments), StartTimeouts())
            graph.wait_for_holder()
    _print(managers, late, "stopped", as_json)
    return 0


def release_robot(as_json: bool) -> int:
    """Release every robot in the graph; raise if another node still holds it stopped.

    Raises:
        RefusedError: A node without a service for it holds the robot stopped.
        UnavailableError: A controller manager does not respond.
    """
    with _graph() as graph:
        for node in graph.button.others():
            graph.call_release(node)
        graph.button.release()
        managers = graph.managers()
        late = graph.wait(managers, stopped=False)
        if late and (holders := graph.holders.names):
            raise RefusedError(
                f"The robot is still stopped by {', '.join(holders)}",
                hint=f"Release it there, or end that node and run this command again: "
                f"it holds {STOP_TOPIC} true.",
            )
    _print(managers, late, "released", as_json)
    return 0


def _print(managers: list[str], late: list[str], state: str, as_json: bool) -> None:
    if late:
        raise UnavailableError(
            f"Not {state} within {_LONGEST_WAIT_S:g} s: the robot of {', '.join(late)}",
            hint=(
                "The joints may keep following their last commands. " if state == "stopped" else ""
            )
            + "`teleopctl logs` has what keeps the controller manager from it.",
        )
    if as_json:
        console.out_json({state: managers})
    elif managers:
        console.out(f"The robot is {state}: {', '.join(managers)}")
    elif state == "stopped":
        console.note(
            "No controller manager is running. One that starts is stopped until "
            "`teleopctl stop --robot --release`."
        )
    else:
        console.note("No controller manager is running.")


class _Graph:
    """Node of the command: presses the button, and follows holders and controller managers."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._executor = SingleThreadedExecutor(context=node.context)
        self._executor.add_node(node)
        self.holders = StopHolders(node, lambda _names: None)
        self.button = StopButton(node)

    def managers(self) -> list[str]:
        """Return the nodes that stop the robot on ``/stop``."""
        return sorted(
            topic.removesuffix(_STATE)
            for topic, types in self._node.get_topic_names_and_types()
            if topic.endswith(_STATE) and "std_msgs/msg/Bool" in types
        )

    def wait(self, managers: list[str], *, stopped: bool) -> list[str]:
        """Wait until controller managers are stopped or released; return those that are not."""
        waiting = set(managers)
        done: Future[None] = Future()

        def follow(manager: str) -> None:
            # Any: the class of std_msgs/Bool is generated at run time.
            def received(message: Any) -> None:
                (waiting.discard if bool(message.data) is stopped else waiting.add)(manager)
                if not waiting and not done.done():
                    done.set_result(None)

            topic, kind = f"{manager}{_STATE}", get_message("std_msgs/msg/Bool")
            self._node.create_subscription(kind, topic, received, qos_profile_latched)

        for manager in managers:
            follow(manager)
        if waiting:
            self._executor.spin_until_future_complete(done, _LONGEST_WAIT_S)
        return sorted(waiting)

    def wait_for_holder(self) -> None:
        """Wait until the node that holds the robot is in the graph, where a release finds it."""
        self._node.context.wait_for_change(
            lambda: f"/{_HOLDER}" in self.button.others(), _LONGEST_WAIT_S
        )

    def call_release(self, node: str) -> None:
        """Call a node's service ``~/release``, if it has one."""
        name = RELEASE_SERVICE.replace("~", node)
        offered = dict(self._node.get_service_names_and_types())
        if RELEASE_TYPE not in offered.get(name, ()):
            return
        kind = get_service(RELEASE_TYPE)
        future = self._node.create_client(kind, name).call_async(kind.Request())
        self._executor.spin_until_future_complete(future, _LONGEST_WAIT_S)


@contextlib.contextmanager
def _graph() -> Iterator[_Graph]:
    with command_node(session_mode="client", name=_HOLDER) as node:
        yield _Graph(node)
