"""``teleopctl service echo``."""

from teleopctl.base.typed import Annotated, Any
from teleopctl.cli import console
from teleopctl.cli.command_node import command_node
from teleopctl.cli.listing import types_of
from teleopctl.cli.live import absolute_name, live_graph
from teleopctl.cli.options import ServiceName, UseSimTime
from teleopctl.cli.verb import Argument, Option
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
from teleopctl.cli.verbs.topic.text import json_value
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
from teleopctl.cli.words.messages import service_class_named
from teleopctl.errors import NotFoundError, RefusedError


def echo(
    service_name: ServiceName,
    service_type: Annotated[
        str | None,
        Argument(
            help="Its type; otherwise the one that it has in the graph.", complete="service_types"
        ),
    ] = None,
    csv: Csv = False,
    as_json: Annotated[bool, Option("--json", help="Print one JSON object an event.")] = False,
    flow_style: FlowStyle = False,
    full_length: FullLength = False,
    truncate_length: TruncateLength = TRUNCATE,
    no_arr: NoArr = False,
    no_str: NoStr = False,
    use_sim_time: UseSimTime = False,
    qos_profile: ProfileName = None,
    qos_reliability: ReliabilityName = None,
    qos_durability: DurabilityName = None,
    qos_history: HistoryName = None,
    qos_depth: Depth = None,
    qos_liveliness: LivelinessName = None,
    qos_liveliness_lease_duration_seconds: LeaseDuration = None,
) -> None:
    """Print the requests and responses of a service.

    Its client or its server has to introspect it: see the parameters of the node, or
    configure_introspection of rclpy. Ctrl-C ends it.
    """
    from teleopctl.node import SingleThreadedExecutor, qos_profile_services_default
    from teleopctl.wire import EntityKind

    wishes = QosWishes(
        *(qos_profile, qos_reliability, qos_durability, qos_history, qos_depth),
        *(qos_liveliness, qos_liveliness_lease_duration_seconds),
    )
    service = absolute_name(service_name)
    service_class = service_class_named(service_type or _type_of(service))
    style = style_of(
        flow_style=flow_style,
        full_length=full_length,
        truncate_length=truncate_length,
        no_arr=no_arr,
        no_str=no_str,
    )

    # Any: the event of whatever service it is.
    def receive(event: Any) -> None:
        if as_json:
            console.out_json(json_value(event), compact=True)
        elif csv:
            console.out(style.csv(event))
        else:
            console.out_text(f"{style.event(event)}---")
        console.flush()

    topic = f"{service}/_service_event"
    with (
        command_node(use_sim_time=use_sim_time) as node,
        SingleThreadedExecutor(context=node.context) as executor,
    ):
        node.create_subscription(
            service_class.Event, topic, receive, wishes.applied_to(qos_profile_services_default)
        )
        event_type = service_class.Event.TYPE_NAME
        if not node.wait_for_match(EntityKind.MP, topic, event_type, 1, 0.0):
            console.note(
                f"No publishers on topic '{topic}'; is service introspection on the client or "
                "server enabled?"
            )
        executor.add_node(node)
        executor.spin()


def _type_of(service: str) -> str:
    """The type that a service has in the graph.

    Raises:
        NotFoundError: Nobody serves or calls it.
        RefusedError: It has several.
    """
    known = live_graph().service_names_and_types(include_hidden=True)
    try:
        types = types_of(service, known, kind="service")
    except NotFoundError as error:
        raise NotFoundError(f"Cannot find type for '{service}'", hint=error.hint) from error
    if len(types) > 1:
        raise RefusedError(
            f"More than one type associated with service '{service}'",
            hint=f"Name the one that is meant: {' or '.join(types)}.",
        )
    return types[0]
