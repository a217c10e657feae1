"""``teleopctl action``: actions, their types and goals, as ``ros2 action``."""

import sys

from teleopctl.base.typed import TYPE_CHECKING, Annotated, Any, Callable
from teleopctl.cli import console
from teleopctl.cli.graph_lookup import absolute_name, live_graph
from teleopctl.cli.listing import names_of_type, out_names, out_types, types_of
from teleopctl.cli.options import AsJson, check_not_negative
from teleopctl.cli.verb import Argument, Option, Verb, VerbGroup
from teleopctl.cli.verbs.topic.qos import QosOptions
from teleopctl.cli.verbs.topic.text import TextOptions
from teleopctl.errors import (
    RefusedError,
    TeleopctlError,
    UnavailableError,
    UsageError,
    existing_names_hint,
)
from teleopctl.wire import action_type as type_of_action

if TYPE_CHECKING:
    from teleopctl.cli.completion.completing import TypedWords
    from teleopctl.cli.verbs.topic.text import TextStyle
    from teleopctl.interfaces import Message
    from teleopctl.node import (
        ActionClient,
        ClientGoalHandle,
        Executor,
        GoalState,
        QoSProfile,
        ResponseFuture,
    )
    from teleopctl.wire import EndpointToken


GROUP = VerbGroup(
    "List actions, send goals and watch them.",
    {
        "list": Verb(f"{__name__}:list_actions", "List the actions."),
        "info": Verb(f"{__name__}:action_info", "Show the servers and clients of an action."),
        "type": Verb(f"{__name__}:action_type", "Print the type of an action."),
        "find": Verb(f"{__name__}:actions_of_type", "List the actions of a type."),
        "send_goal": Verb(
            f"{__name__}:send_goal",
            "Send a goal and wait for its result.",
            examples=(
                "teleopctl action send_goal -f /fibonacci "
                'example_interfaces/action/Fibonacci "{order: 5}"',
            ),
        ),
        "echo": Verb(f"{__name__}:echo", "Print the feedback and goal states of an action."),
        "goals": Verb(
            f"{__name__}.goals:list_goals", "List the goals of actions and their states."
        ),
        "cancel": Verb(
            f"{__name__}.goals:cancel_goals",
            "Cancel the goals of an action, or one of them.",
            examples=("teleopctl action cancel /fibonacci",),
        ),
    },
    leaves_nothing=True,
)


ActionName = Annotated[str, Argument(help="The action.", complete="actions")]
CountActions = Annotated[bool, Option("-c", "--count-actions", help="Print only the number.")]


def list_actions(
    show_types: Annotated[
        bool, Option("-t", "--show-types", help="Show the type of each action.")
    ] = False,
    count_actions: CountActions = False,
    as_json: AsJson = False,
) -> None:
    """List the actions."""
    graph = live_graph()
    actions = graph.action_names_and_types()
    if as_json:
        console.out_json(
            [
                {"name": name, "types": types, "servers": len(graph.action_servers(name))}
                for name, types in actions
            ]
        )
    else:
        out_names(actions, only_count=count_actions, show_types=show_types)


def action_info(
    action_name: ActionName,
    show_types: Annotated[
        bool, Option("-t", "--show-types", help="Show the types as well.")
    ] = False,
    only_count: Annotated[bool, Option("-c", "--count", help="Print no nodes.")] = False,
    as_json: AsJson = False,
) -> None:
    """Print the nodes that are clients and servers of an action."""
    graph = live_graph()
    name = absolute_name(action_name)
    sides = {"clients": graph.action_clients(name), "servers": graph.action_servers(name)}
    if as_json:
        nodes = {
            side: [{"node": e.full_name, "type": type_of_action(e)} for e in endpoints]
            for side, endpoints in sides.items()
        }
        console.out_json({"name": name, **nodes})
        return
    console.out(f"Action: {name}")
    for side, endpoints in sides.items():
        console.out(f"Action {side}: {len(endpoints)}")
        if not only_count:
            console.out_lines(_line(endpoint, show_types=show_types) for endpoint in endpoints)


def _line(endpoint: "EndpointToken", *, show_types: bool) -> str:
    shown_type = f" [{type_of_action(endpoint)}]" if show_types else ""
    return f"    {endpoint.full_name}{shown_type}"


def action_type(action_name: ActionName, as_json: AsJson = False) -> None:
    """Print the type of an action."""
    actions = live_graph().action_names_and_types()
    out_types(types_of(absolute_name(action_name), actions, kind="action"), as_json=as_json)


def actions_of_type(
    type_name: Annotated[
        str, Argument(help="The action type.", metavar="TYPE", complete="action_types")
    ],
    count_actions: CountActions = False,
    as_json: AsJson = False,
) -> None:
    """List the actions of a type."""
    found = names_of_type(type_name, live_graph().action_names_and_types(), kind="action")
    out_names(found, only_count=count_actions, as_json=as_json)


_FAILED = 1
_INTERRUPTED = 130
# Return codes of action_msgs/srv/CancelGoal: ERROR_UNKNOWN_GOAL_ID, ERROR_GOAL_TERMINATED.
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
            help="Seconds to wait for the server, and for the result; 0 for no result.",
            metavar="SECONDS",
        ),
    ] = None,
    as_json: Annotated[bool, Option("--json", help="Print one JSON object an event.")] = False,
) -> int:
    """Send a goal and wait for its result.

    Waits for a server if there is none. Ctrl-C cancels the goal and waits for its end; a second
    Ctrl-C ends the command at once. The exit status is 0 if the goal succeeded.
    """
    from teleopctl.cli.command_node import command_node
    from teleopctl.cli.messages import action_class_named, goal_from_text
    from teleopctl.node import ActionClient, LoggingSeverity, SingleThreadedExecutor

    if stdin and values is not None:
        raise UsageError("--stdin replaces the goal argument; give one of them")
    check_not_negative(timeout=timeout)
    action = action_class_named(type_name)
    text = sys.stdin.read() if stdin else "{}" if values is None else values
    goal = goal_from_text(action, text)
    report = _JsonReport() if as_json else _Report()
    with (
        command_node(session_mode="client") as node,
        SingleThreadedExecutor(context=node.context) as executor,
    ):
        # The loss of the server is reported below, so the library must not log it.
        node.get_logger().set_level(LoggingSeverity.FATAL)
        executor.add_node(node)
        client = ActionClient(node, action, absolute_name(action_name))
        return _Exchange(client, executor, report, timeout).run(goal, with_feedback=feedback)


class _Report:
    """Output about a goal, with the texts of ``ros2 action send_goal``."""

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

    # Any: message of any action.
    def feedback(self, message: Any) -> None:
        self._show("Feedback:\n    ", message.feedback)

    def result(self, state: "GoalState", result: "Message") -> None:
        self._show("Result:\n    ", result)
        self.say(f"Goal finished with status: {state.name}")

    def _show(self, head: str, message: "Message") -> None:
        from teleopctl.interfaces import message_to_yaml

        console.out_text(f"{head}{message_to_yaml(message)}")
        console.flush()


class _JsonReport(_Report):
    """Output about a goal as one JSON object per line."""

    def say(self, line: str) -> None:
        console.note(line)

    def rejected(self) -> None:
        self._write("rejected")

    def sending(self, goal: "Message") -> None:
        from teleopctl.interfaces import message_to_dict

        self._write("goal", goal=message_to_dict(goal))

    def accepted(self, goal_id: bytes) -> None:
        self._write("accepted", goal_id=goal_id.hex())

    # Any: message of any action.
    def feedback(self, message: Any) -> None:
        from teleopctl.interfaces import message_to_dict

        self._write("feedback", feedback=message_to_dict(message.feedback))

    def result(self, state: "GoalState", result: "Message") -> None:
        from teleopctl.interfaces import message_to_dict

        self._write("result", status=state.name, result=message_to_dict(result))

    def _write(self, event: str, **values: "console.Json") -> None:
        console.out_json({"event": event, **values}, compact=True)
        console.flush()


class _Exchange:
    """One goal, from the wait for its server to its end."""

    def __init__(
        self,
        client: "ActionClient[Any, Any, Any]",
        executor: "Executor",
        report: _Report,
        timeout_s: float | None,
    ) -> None:
        import uuid

        from teleopctl.interfaces import get_message

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
        from teleopctl.cli.waiting import wait_with_notice

        console.note("Waiting for an action server to become available...")
        if not wait_with_notice(self._client.wait_for_server, self._timeout_s, self._explain):
            raise UnavailableError(
                f"Action server is not available after waiting {self._timeout_s:g} seconds."
            )

    def _explain(self) -> str:
        """Return a hint while waiting: another type or other names of actions in the graph."""
        name = self._client.action_name
        graph = self._client.node.graph()
        # The client of this command is in the graph too, so only servers count.
        servers = graph.action_servers(name)
        if here := {kind for server in servers if (kind := type_of_action(server))}:
            return f"'{name}' has the type {' and '.join(sorted(here))}."
        actions = graph.action_names_and_types()
        served = [action for action, _ in actions if graph.action_servers(action)]
        return (
            f"No server of '{name}' yet. {existing_names_hint('actions', [name], served, served)}"
        )

    def _follow(self, sent: "ResponseFuture[ClientGoalHandle[Any]]") -> int:
        # A timeout of 0 means no wait for the result; the acceptance is waited for anyway.
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
        from teleopctl.node import GoalState

        result = self._client.request_result(self._id)
        if not self._wait(result, timeout_s):
            raise UnavailableError(f"Timed out waiting for result after {timeout_s:g} seconds.")
        while self._client.queued_feedback():
            self._executor.spin_once(0)
        answer = result.result()
        assert answer is not None
        state = GoalState(answer.status)
        self._report.result(state, answer.result)
        return 0 if state is GoalState.SUCCEEDED else _FAILED

    def _cancel(self) -> int:
        """Cancel the goal after Ctrl-C and show its end; another Ctrl-C ends the command.

        A single-threaded server that executes the goal receives the request when the goal has
        ended.
        """
        from teleopctl.cli.waiting import wait_with_notice

        self._report.say("Canceling goal...")
        answer = self._client.request_cancel(self._id)
        wait_with_notice(lambda bound_s: self._wait(answer, bound_s), None, self._silent)
        response = answer.result()
        assert response is not None
        if response.goals_canceling:
            self._report.say("Goal canceled.")
        elif response.return_code == _ENDED_ALREADY:
            console.note("The goal ended before the server received the cancel request.")
        else:
            unknown = response.return_code == _UNKNOWN
            raise RefusedError(
                "Failed to cancel goal",
                hint="The server does not know this goal."
                if unknown
                else "The server rejected the request.",
            )
        self._take_result(None)
        return _INTERRUPTED

    def _silent(self) -> str:
        return (
            f"'{self._client.action_name}' has not answered yet; it may be busy. Ctrl-C "
            "again ends this command and leaves the goal to the server."
        )

    # Any: response to any of the requests.
    def _wait(self, answer: "ResponseFuture[Any]", timeout_s: float | None) -> bool:
        """Spin until a response has arrived; return False after ``timeout_s`` seconds.

        Raises:
            UnavailableError: The server has disappeared, so no response will arrive.
        """
        from teleopctl.node import Future

        settled: Future[None] = Future()
        answer.on_end(lambda: settled.set_result(None))
        answer.on_unanswered(lambda: settled.set_result(None))
        self._executor.spin_until_future_complete(settled, timeout_s)
        if settled.done() and not answer.done():
            raise UnavailableError(f"The server of '{self._client.action_name}' has disappeared")
        return answer.done()


_INTERFACES = ("GOAL_SERVICE", "CANCEL_SERVICE", "RESULT_SERVICE", "FEEDBACK_TOPIC", "STATUS_TOPIC")


def echo(
    action_name: ActionName,
    type_name: Annotated[
        str | None,
        Argument(
            help="Type; by default the one in the graph.",
            metavar="ACTION_TYPE",
            complete="action_types",
        ),
    ] = None,
    interfaces: Annotated[
        str | None,
        Option(
            "-i",
            "--interfaces",
            help=f"Only these, with | between them: {', '.join(_INTERFACES)}.",
            metavar="A|B",
        ),
    ] = None,
    as_json: Annotated[bool, Option("--json", help="Print one JSON object a message.")] = False,
    *,
    text: TextOptions,
    qos: QosOptions,
) -> None:
    """Print the feedback, goal states and service events of an action, until Ctrl-C.

    Service calls are printed as well, where service introspection of the action is enabled. Ends on
    Ctrl-C.
    """
    from teleopctl.cli.command_node import command_node
    from teleopctl.cli.messages import action_class_named
    from teleopctl.node import SingleThreadedExecutor

    chosen = _chosen(interfaces)
    style = text.style(as_json=as_json)
    name = absolute_name(action_name)
    type_ = type_name or types_of(name, live_graph().action_names_and_types(), kind="action")[0]
    action = action_class_named(type_)

    def printer(interface: str) -> Callable[[Any], None]:
        return lambda message: _print_message(
            interface, message, style, csv=text.csv, as_json=as_json
        )

    with command_node() as node, SingleThreadedExecutor(context=node.context) as executor:
        for interface, (topic, message_class, default_qos) in _topics(action).items():
            if interface in chosen:
                node.create_subscription(
                    message_class,
                    f"{name}/_action/{topic}",
                    printer(interface),
                    qos.applied_to(default_qos),
                )
        executor.add_node(node)
        executor.spin()


def _chosen(interfaces: str | None) -> frozenset[str]:
    if interfaces is None:
        return frozenset(_INTERFACES)
    if not interfaces:
        raise UsageError("Input action interface name is empty.")
    chosen = set()
    for word in interfaces.split("|"):
        name = word.strip().upper()
        # FEEDBACK and STATUS are the names of earlier versions.
        found = next(
            (each for each in _INTERFACES if name in (each, each.split("_TOPIC")[0])), None
        )
        if found is None:
            raise UsageError(
                f'"{word.strip()}" is incorrect interface name.',
                hint=f"One of {', '.join(_INTERFACES)}.",
            )
        chosen.add(found)
    return frozenset(chosen)


# Any, here and below: messages of any action.
def _topics(action: Any) -> "dict[str, tuple[str, type[Any], QoSProfile]]":
    """Return the topic, message class and QoS profile of each interface of an action."""
    from teleopctl.interfaces import get_message
    from teleopctl.node import (
        QoSProfile,
        qos_profile_action_status_default,
        qos_profile_services_default,
    )

    parts = action.Impl

    def events(topic: str, service: Any) -> "tuple[str, type[Any], QoSProfile]":
        message_class = get_message(f"{service.TYPE_NAME}_Event")
        return f"{topic}/_service_event", message_class, qos_profile_services_default

    services = (parts.SendGoalService, parts.CancelGoalService, parts.GetResultService)
    return {
        "GOAL_SERVICE": events("send_goal", services[0]),
        "CANCEL_SERVICE": events("cancel_goal", services[1]),
        "RESULT_SERVICE": events("get_result", services[2]),
        "FEEDBACK_TOPIC": ("feedback", parts.FeedbackMessage, QoSProfile(depth=10)),
        "STATUS_TOPIC": ("status", parts.GoalStatusMessage, qos_profile_action_status_default),
    }


def _print_message(
    interface: str, message: Any, style: "TextStyle", *, csv: bool, as_json: bool
) -> None:
    from teleopctl.cli.verbs.topic.text import json_value

    if as_json:
        console.out_json({"interface": interface, "message": json_value(message)}, compact=True)
    elif csv:
        console.out(f"interface: {interface}\n{style.csv(message)}")
    else:
        write = style.event if interface.endswith("_SERVICE") else style.yaml
        text = write(message)
        console.out_text(f"interface: {interface}\n{text}---")
    console.flush()


def complete_actions(incomplete: str) -> list[str]:
    """Return completion candidates: the names of live actions."""
    return [name for name in _actions_with_types() if name.startswith(incomplete)]


def complete_types(ctx: "TypedWords", incomplete: str) -> list[str]:
    """Return completion candidates: the types of the action on the command line, else all known."""
    from teleopctl.cli.graph_lookup import absolute_name
    from teleopctl.interfaces import list_types

    name = ctx.params.get("action_name")
    live = _actions_with_types().get(absolute_name(name)) if name else None
    return [type_ for type_ in live or list_types("action") if type_.startswith(incomplete)]


def _actions_with_types() -> dict[str, list[str]]:
    from teleopctl.cli.graph_lookup import live_graph

    try:
        return dict(live_graph().action_names_and_types())
    except TeleopctlError:
        return {}
