"""``teleopctl action send_goal``."""

import sys
import uuid

from teleopctl.base.typed import TYPE_CHECKING, Annotated, Any
from teleopctl.cli import console
from teleopctl.cli.command_node import command_node
from teleopctl.cli.live import absolute_name
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.action.listing import ActionName
from teleopctl.cli.waiting import wait_aloud
from teleopctl.cli.words.messages import action_class_named, goal_with
from teleopctl.cli.words.numbers import check_not_negative
from teleopctl.errors import RefusedError, UnavailableError, UsageError, what_there_is
from teleopctl.interfaces import get_message, message_to_dict, message_to_yaml
from teleopctl.node import ActionClient, Future, GoalState, LoggingSeverity, SingleThreadedExecutor
from teleopctl.wire import action_type

if TYPE_CHECKING:
    from teleopctl.interfaces import Message
    from teleopctl.node import ClientGoalHandle, Executor, ResponseFuture

_FAILED = 1
_INTERRUPTED = 130
# Of action_msgs/srv/CancelGoal: there is no such goal, and the wish came after its end.
_UNKNOWN, _ENDED_ALREADY = 2, 3


def send_goal(
    action_name: ActionName,
    type_name: Annotated[
        str,
        Argument(
            help="Its type, such as example_interfaces/action/Fibonacci.",
            metavar="ACTION_TYPE",
            complete="action_types",
        ),
    ],
    values: Annotated[
        str | None,
        Argument(
            help="The goal as YAML; fields left out have their defaults.", complete="prototypes"
        ),
    ] = None,
    feedback: Annotated[bool, Option("-f", "--feedback", help="Print the feedback.")] = False,
    stdin: Annotated[bool, Option("--stdin", help="Read the goal from standard input.")] = False,
    timeout: Annotated[
        float | None,
        Option(
            "-t",
            "--timeout",
            help="Wait so many seconds for the server, and for the result; 0 for no result.",
            metavar="SECONDS",
        ),
    ] = None,
    as_json: Annotated[bool, Option("--json", help="Print one JSON object an event.")] = False,
) -> int:
    """Send a goal and wait for its result.

    Without a server it waits for one. Ctrl-C cancels the goal and waits for its end; another one
    ends the command at once. The exit status is 0 when the goal has succeeded.
    """
    if stdin and values is not None:
        raise UsageError("--stdin stands in the place of the goal; leave one of them out")
    check_not_negative(timeout=timeout)
    action = action_class_named(type_name)
    text = sys.stdin.read() if stdin else "{}" if values is None else values
    goal = goal_with(action, text)
    report = _JsonReport() if as_json else _Report()
    with (
        command_node(session_mode="client") as node,
        SingleThreadedExecutor(context=node.context) as executor,
    ):
        # What its library would log of a server that goes away is said below.
        node.get_logger().set_level(LoggingSeverity.FATAL)
        executor.add_node(node)
        client = ActionClient(node, action, absolute_name(action_name))
        return _Exchange(client, executor, report, timeout).run(goal, with_feedback=feedback)


class _Report:
    """What is printed of a goal, in the words of ``ros2 action send_goal``."""

    def say(self, line: str) -> None:
        console.out(line)
        console.flush()

    def sending(self, goal: "Message") -> None:
        self._show("Sending goal:\n     ", goal)

    def rejected(self) -> None:
        self.say("Goal was rejected.")

    def accepted(self, goal_id: bytes) -> None:
        console.out_text(f"Goal accepted with ID: {goal_id.hex()}\n")
        console.flush()

    # Any: the message of whatever action it is.
    def feedback(self, message: Any) -> None:
        self._show("Feedback:\n    ", message.feedback)

    def result(self, state: GoalState, result: "Message") -> None:
        self._show("Result:\n    ", result)
        self.say(f"Goal finished with status: {state.name}")

    def _show(self, head: str, message: "Message") -> None:
        console.out_text(f"{head}{message_to_yaml(message)}")
        console.flush()


class _JsonReport(_Report):
    """The same as one JSON object a line."""

    def say(self, line: str) -> None:
        console.note(line)

    def rejected(self) -> None:
        self._write("rejected")

    def sending(self, goal: "Message") -> None:
        self._write("goal", goal=message_to_dict(goal))

    def accepted(self, goal_id: bytes) -> None:
        self._write("accepted", goal_id=goal_id.hex())

    # Any: the message of whatever action it is.
    def feedback(self, message: Any) -> None:
        self._write("feedback", feedback=message_to_dict(message.feedback))

    def result(self, state: GoalState, result: "Message") -> None:
        self._write("result", status=state.name, result=message_to_dict(result))

    def _write(self, event: str, **values: "console.Json") -> None:
        console.out_json({"event": event, **values}, compact=True)
        console.flush()


class _Exchange:
    """One goal, from the wait for its server to its end."""

    def __init__(
        self,
        client: ActionClient[Any, Any, Any],
        executor: "Executor",
        report: _Report,
        timeout_s: float | None,
    ) -> None:
        self._client = client
        self._executor = executor
        self._report = report
        self._timeout_s = timeout_s
        self._key = uuid.uuid4().bytes
        self._id = get_message("unique_identifier_msgs/msg/UUID")(uuid=self._key)

    def run(self, goal: "Message", *, with_feedback: bool) -> int:
        self._wait_for_server()
        self._report.sending(goal)
        sent = self._client.send_goal_async(
            goal, self._report.feedback if with_feedback else None, self._id
        )
        try:
            return self._follow(sent)
        except KeyboardInterrupt:
            return self._cancel()

    def _wait_for_server(self) -> None:
        console.note("Waiting for an action server to become available...")
        if not wait_aloud(self._client.wait_for_server, self._timeout_s, self._explain):
            raise UnavailableError(
                f"Action server is not available after waiting {self._timeout_s:g} seconds."
            )

    def _explain(self) -> str:
        """What there is in the place of the server."""
        name = self._client.action_name
        graph = self._client.node.graph()
        # Ours is a client of what nobody may serve.
        servers = graph.action_servers(name)
        if here := {kind for server in servers if (kind := action_type(server))}:
            return f"'{name}' has the type {' and '.join(sorted(here))}."
        actions = graph.action_names_and_types()
        served = [action for action, _ in actions if graph.action_servers(action)]
        return f"No server of '{name}' yet. {what_there_is('actions', [name], served, served)}"

    def _follow(self, sent: "ResponseFuture[ClientGoalHandle[Any]]") -> int:
        # Without a wait for the result the acceptance is waited for all the same.
        if not self._wait(sent, self._timeout_s or None):
            raise UnavailableError(
                f"Timed out waiting for goal acceptance after {self._timeout_s:g} seconds."
            )
        handle = sent.result()
        assert handle is not None
        if not handle.accepted:
            self._report.rejected()
            return _FAILED
        self._report.accepted(self._key)
        return 0 if self._timeout_s == 0 else self._take_result(self._timeout_s)

    def _take_result(self, timeout_s: float | None) -> int:
        result = self._client.ask_for_result(self._id)
        if not self._wait(result, timeout_s):
            raise UnavailableError(f"Timed out waiting for result after {timeout_s:g} seconds.")
        while self._client.feedback_waiting():
            self._executor.spin_once(0)
        answer = result.result()
        assert answer is not None
        state = GoalState(answer.status)
        self._report.result(state, answer.result)
        return 0 if state is GoalState.SUCCEEDED else _FAILED

    def _cancel(self) -> int:
        """Cancel the goal after Ctrl-C and show its end; another Ctrl-C ends the command.

        A server whose only thread is at the goal hears of the wish when the goal has ended.
        """
        self._report.say("Canceling goal...")
        answer = self._client.cancel(self._id)
        wait_aloud(lambda bound_s: self._wait(answer, bound_s), None, self._silent)
        response = answer.result()
        assert response is not None
        if response.goals_canceling:
            self._report.say("Goal canceled.")
        elif response.return_code == _ENDED_ALREADY:
            console.note("The goal ended before the server heard that it was to be canceled.")
        else:
            unknown = response.return_code == _UNKNOWN
            raise RefusedError(
                "Failed to cancel goal",
                hint="The server does not know it." if unknown else "The server refuses.",
            )
        self._take_result(None)
        return _INTERRUPTED

    def _silent(self) -> str:
        return (
            f"'{self._client.action_name}' has not answered yet: it hears of this when it is done "
            "with what it does now. Ctrl-C again ends this command and leaves the goal to it."
        )

    # Any: the answer to whichever request it is.
    def _wait(self, answer: "ResponseFuture[Any]", timeout_s: float | None) -> bool:
        """Spin until an answer has come; False when the time, in seconds, ran out.

        Raises:
            UnavailableError: None will come: the server has gone away.
        """
        settled: Future[None] = Future()
        answer.on_end(lambda: settled.set_result(None))
        answer.when_unanswered(lambda: settled.set_result(None))
        self._executor.spin_until_future_complete(settled, timeout_s)
        if settled.done() and not answer.done():
            raise UnavailableError(f"The server of '{self._client.action_name}' has gone away")
        return answer.done()
