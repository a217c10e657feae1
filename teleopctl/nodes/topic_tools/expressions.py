"""Executables ``transform`` and ``relay_field``: topics computed from others by expressions."""

from __future__ import annotations

import argparse
import builtins
import contextlib
import importlib
import os
import sys
from collections.abc import Callable, Sequence
from typing import Any

from teleopctl.errors import InvalidMessageError, NotFoundError, UsageError, did_you_mean
from teleopctl.interfaces import documents_from_yaml, get_message, message_from_yaml, normalize
from teleopctl.node import (
    DurabilityPolicy,
    ExternalShutdownException,
    HistoryPolicy,
    Node,
    QoSPresetProfiles,
    QoSProfile,
    ReliabilityPolicy,
    init,
    parse_ros_arguments,
    qos_for_publishers,
    spin,
)
from teleopctl.nodes.argument_parser import ArgumentParser

_LOOK_PERIOD_S = 0.1
# Without --wait-for-start the input has to be there: this long is a graph waited for.
_LOOKS = 10

# Any, here and below: messages of any type, and what a user's expression returns.


def _run(make: Callable[[argparse.Namespace], Callable[[Any], Any]], name: str, args: Any) -> None:
    """Run a node that publishes what a function makes of each message of a topic.

    Raises:
        NotFoundError: Nothing publishes the input.
    """
    function = make(args)
    with (
        contextlib.suppress(KeyboardInterrupt, ExternalShutdownException),
        init(args=sys.argv),
        Node(f"{name}_{os.getpid()}") as node,
    ):
        output = get_message(normalize(args.output_type))
        topic = args.input if args.input.startswith("/") else f"{node.get_namespace()}{args.input}"
        looks = 0

        def look() -> None:
            nonlocal looks
            looks += 1
            tokens = node.graph().publishers(topic)
            if tokens:
                node.destroy_timer(timer)
                qos = _qos(args) or qos_for_publishers([token.qos for token in tokens], 5)
                publisher = node.create_publisher(output, args.output_topic, qos)

                def receive(message: Any) -> None:
                    for result in function(message):
                        publisher.publish(result)

                node.create_subscription(get_message(tokens[0].type_name), topic, receive, qos)
            elif looks >= _LOOKS and not args.wait_for_start:
                hint = did_you_mean(
                    topic, [name for name, _ in node.graph().topic_names_and_types()]
                )
                raise NotFoundError(
                    f"Wrong input topic: nothing publishes {topic}",
                    hint=hint or "With --wait-for-start, the program waits for a publisher.",
                )

        timer = node.create_timer(_LOOK_PERIOD_S, look)
        spin(node)


def _qos(args: argparse.Namespace) -> QoSProfile | None:
    """Return the QoS profile that options ask for; None for that of the publishers."""
    policies = {
        "reliability": (args.qos_reliability, ReliabilityPolicy),
        "durability": (args.qos_durability, DurabilityPolicy),
        "history": (args.qos_history, HistoryPolicy),
    }
    chosen = [args.qos_profile, args.qos_depth, *(word for word, _ in policies.values())]
    if all(option is None for option in chosen):
        return None
    qos = QoSPresetProfiles.get_from_short_key(args.qos_profile or "sensor_data")
    for name, (word, policy) in policies.items():
        if word:
            setattr(qos, name, policy.get_from_short_key(word))
    if args.qos_depth is not None:
        qos.depth = args.qos_depth
    return qos


def _parser(name: str, description: str, example: str) -> ArgumentParser:
    parser = ArgumentParser(
        prog=name,
        description=description,
        epilog=f"Example:\n  {example}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("input", help="input topic")
    parser.add_argument("output_topic", help="output topic")
    parser.add_argument("output_type", help="type of the output topic")
    parser.add_argument(
        "--wait-for-start", action="store_true", help="wait for a publisher of the input"
    )
    profiles = [key.lower() for key in QoSPresetProfiles.short_keys()]
    parser.add_argument("--qos-profile", choices=profiles, help="QoS preset (sensor_data)")
    parser.add_argument("--qos-depth", type=int, metavar="N", help="depth")
    for name_, policy in (
        ("history", HistoryPolicy),
        ("reliability", ReliabilityPolicy),
        ("durability", DurabilityPolicy),
    ):
        parser.add_argument(f"--qos-{name_}", choices=policy.short_keys(), help=f"{name_} policy")
    return parser


def transform_function(
    expression: str, field: str | None, modules: Sequence[str]
) -> Callable[[Any], list[Any]]:
    """Return a function that evaluates a Python expression with a message, or a field, as ``m``.

    Args:
        expression: Expression that returns a message, or a list of messages.
        field: Path of a field of the message, such as ``orientation.x``; None for the message.
        modules: Modules to import for the expression.

    Raises:
        UsageError: A module does not exist, or the expression is not Python.
    """
    names: dict[str, Any] = {"__builtins__": builtins}
    for module in modules:
        root = module.partition(".")[0]
        try:
            importlib.import_module(module)
            names[root] = importlib.import_module(root)
        except ImportError as error:
            raise UsageError(f"Failed to import module: {module}", hint=str(error)) from error
        # `std_msgs.msg.String` after `--import std_msgs`, as ROS 2's examples have it.
        with contextlib.suppress(ImportError):
            importlib.import_module(f"{module}.msg")
    try:
        code = compile(expression, "expression", "eval")
    except (SyntaxError, ValueError) as error:
        raise UsageError(f"Wrong expression '{expression}': {error}") from error
    path = [part for part in (field or "").split(".") if part]
    if field is not None and not path:
        raise UsageError(f"Invalid field value '{field}'")

    def evaluate(message: Any) -> list[Any]:
        for part in path:
            try:
                message = getattr(message, part)
            except AttributeError as error:
                raise InvalidMessageError(f"Invalid field '{'.'.join(path)}': {error}") from error
        try:
            # The user who runs the program wrote the expression, and has all its permissions.
            result = eval(code, {**names, "m": message})  # noqa: S307
        except Exception as error:
            raise InvalidMessageError(f"Expression '{expression}' failed: {error}") from error
        return list(result) if isinstance(result, list | tuple) else [result]

    return evaluate


def field_function(output_type: str, expression: str) -> Callable[[Any], list[Any]]:
    """Return a function that fills a message from YAML whose texts are expressions on ``m``.

    A text that is not an expression stays a text.

    Args:
        output_type: Type of the message.
        expression: YAML, such as ``{frame_id: m.data}``.

    Raises:
        UsageError: The text is not YAML, or not a mapping.
    """
    output = get_message(normalize(output_type))
    documents = documents_from_yaml(expression)
    if len(documents) != 1 or not isinstance(documents[0], dict):
        raise UsageError(
            f"The expression needs to be a dictionary in YAML format, got '{expression}'"
        )
    template = documents[0]

    def value(content: Any, message: Any) -> Any:
        if isinstance(content, dict):
            return {key: value(each, message) for key, each in content.items()}
        if isinstance(content, str):
            try:
                return eval(content, {"__builtins__": builtins, "m": message})  # noqa: S307
            except (NameError, SyntaxError):
                return content
            except AttributeError as error:
                raise InvalidMessageError(f"Invalid field: {error}") from error
        return content

    return lambda message: [message_from_yaml(output, value(template, message))]


def transform() -> None:
    """Publish what an expression makes of each message of a topic until Ctrl-C.

    Raises:
        TeleopctlError: An argument is wrong, or the expression fails.
    """
    parser = _parser(
        "transform",
        "Publish what a Python expression makes of a topic, or of one of its fields.",
        "transform /imu --field orientation.x /x std_msgs/Float64 "
        "'std_msgs.msg.Float64(data=-numpy.rad2deg(m))' --import std_msgs numpy",
    )
    parser.add_argument("expression", nargs="?", default="m", help="expression on the message, m")
    parser.add_argument(
        "-i", "--import", dest="modules", nargs="+", default=["numpy"], help="modules to import"
    )
    parser.add_argument("--field", help="field of the message, such as orientation.x")
    args = parser.parse_args(parse_ros_arguments(sys.argv).program[1:])
    _run(lambda a: transform_function(a.expression, a.field, a.modules), "transform", args)


def relay_field() -> None:
    """Publish fields of a topic's messages in messages of another type until Ctrl-C.

    Raises:
        TeleopctlError: An argument is wrong, or a field does not exist.
    """
    parser = _parser(
        "relay_field",
        "Publish fields of a topic in a message of another type.",
        'relay_field /chatter /header std_msgs/Header "{stamp: now, frame_id: m.data}"',
    )
    parser.add_argument("expression", help="YAML of the output; its texts are expressions on m")
    args = parser.parse_args(parse_ros_arguments(sys.argv).program[1:])
    _run(lambda a: field_function(a.output_type, a.expression), "relay_field", args)
