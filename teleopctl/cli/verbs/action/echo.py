"""``teleopctl action echo``."""

from collections.abc import Callable

from teleopctl.base.typed import Annotated, Any
from teleopctl.cli import console
from teleopctl.cli.command_node import command_node
from teleopctl.cli.listing import types_of
from teleopctl.cli.live import absolute_name, live_graph
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.action.listing import ActionName
from teleopctl.cli.verbs.topic.qos.options import (
    Depth,
    DurabilityName,
    HistoryName,
    LeaseDuration,
    LivelinessName,
    ProfileName,
    QosWishes,
    ReliabilityName,
)
from teleopctl.cli.verbs.topic.text import TextStyle, json_value
from teleopctl.cli.verbs.topic.text_options import (
    TRUNCATE,
    Csv,
    FlowStyle,
    FullLength,
    NoArr,
    NoStr,
    TruncateLength,
    style_of,
)
from teleopctl.cli.words.messages import action_class_named
from teleopctl.errors import UsageError
from teleopctl.interfaces import get_message
from teleopctl.node import (
    QoSProfile,
    SingleThreadedExecutor,
    qos_profile_action_status_default,
    qos_profile_services_default,
)

_INTERFACES = ("GOAL_SERVICE", "CANCEL_SERVICE", "RESULT_SERVICE", "FEEDBACK_TOPIC", "STATUS_TOPIC")


def echo(
    action_name: ActionName,
    type_name: Annotated[
        str | None,
        Argument(
            help="Its type; otherwise the one that it has in the graph.",
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
    csv: Csv = False,
    as_json: Annotated[bool, Option("--json", help="Print one JSON object a message.")] = False,
    flow_style: FlowStyle = False,
    full_length: FullLength = False,
    truncate_length: TruncateLength = TRUNCATE,
    no_arr: NoArr = False,
    no_str: NoStr = False,
    qos_profile: ProfileName = None,
    qos_reliability: ReliabilityName = None,
    qos_durability: DurabilityName = None,
    qos_history: HistoryName = None,
    qos_depth: Depth = None,
    qos_liveliness: LivelinessName = None,
    qos_liveliness_lease_duration_seconds: LeaseDuration = None,
) -> None:
    """Print the feedback and goal states of an action.

    That is the feedback and the states of its goals, and what its services are asked and answer
    where introspection of them is on. Ctrl-C ends it.
    """
    chosen = _chosen(interfaces)
    style = style_of(
        flow_style=flow_style,
        full_length=full_length,
        truncate_length=truncate_length,
        no_arr=no_arr,
        no_str=no_str,
    )
    name = absolute_name(action_name)
    type_ = type_name or types_of(name, live_graph().action_names_and_types(), kind="action")[0]
    action = action_class_named(type_)
    wishes = QosWishes(
        *(qos_profile, qos_reliability, qos_durability, qos_history, qos_depth),
        *(qos_liveliness, qos_liveliness_lease_duration_seconds),
    )

    def printer(interface: str) -> Callable[[Any], None]:
        return lambda message: _print(interface, message, style, csv=csv, as_json=as_json)

    with command_node() as node, SingleThreadedExecutor(context=node.context) as executor:
        for interface, (topic, message_class, qos) in _topics(action).items():
            if interface in chosen:
                node.create_subscription(
                    message_class,
                    f"{name}/_action/{topic}",
                    printer(interface),
                    wishes.applied_to(qos),
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
        # FEEDBACK and STATUS are what earlier versions call them.
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


# Any, here and below: the messages of whatever action it is.
def _topics(action: Any) -> dict[str, tuple[str, type[Any], QoSProfile]]:
    """What each interface is: a topic, the class of its messages, and its quality of service."""
    parts = action.Impl

    def events(topic: str, service: Any) -> tuple[str, type[Any], QoSProfile]:
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


def _print(interface: str, message: Any, style: TextStyle, *, csv: bool, as_json: bool) -> None:
    if as_json:
        console.out_json({"interface": interface, "message": json_value(message)}, compact=True)
    elif csv:
        console.out(f"interface: {interface}\n{style.csv(message)}")
    else:
        write = style.event if interface.endswith("_SERVICE") else style.yaml
        text = write(message)
        console.out_text(f"interface: {interface}\n{text}---")
    console.flush()
