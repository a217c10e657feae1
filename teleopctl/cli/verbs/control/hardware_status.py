"""``control view_hardware_status``."""

import time
from collections.abc import Callable, Iterator

from teleopctl.base.typed import Annotated, Any
from teleopctl.cli import console
from teleopctl.cli.command_node import command_node
from teleopctl.cli.learning import learn_type
from teleopctl.cli.live import live_graph
from teleopctl.cli.verb import Option
from teleopctl.cli.verbs.control.session import RosArgs
from teleopctl.cli.verbs.topic.text import json_value
from teleopctl.errors import NotFoundError, what_there_is
from teleopctl.interfaces import get_message, message_to_yaml
from teleopctl.node import SingleThreadedExecutor

_TYPE = "control_msgs/msg/HardwareStatus"
_TOPIC = "/hardware_status"
# After so many messages an ID that has not been heard of is taken for a wrong one, as in ros2.
_ENOUGH = 10
_KINDS = {
    "Generic Hardware States": "hardware_status",
    "CANopen States": "canopen_states",
    "EtherCAT States": "ethercat_states",
    "VDA5050 States": "vda5050_states",
}
_GREEN, _CYAN, _BLUE, _YELLOW, _RED = (f"\033[{code}m" for code in (92, 96, 94, 93, 91))


def view_hardware_status(
    hardware_id: Annotated[
        str | None,
        Option("-i", "--hardware-id", help="Only this hardware component.", metavar="ID"),
    ] = None,
    device_id: Annotated[
        str | None, Option("-d", "--device-id", help="Only this device of it.", metavar="ID")
    ] = None,
    ros_args: RosArgs = None,
    as_json: Annotated[bool, Option("--json", help="Print one JSON object a message.")] = False,
) -> None:
    """Print what hardware reports of itself, until Ctrl-C."""
    graph = live_graph()
    topics = [
        name
        for name, types in graph.topic_names_and_types(include_hidden=True)
        if name.endswith(_TOPIC) and _TYPE in types
    ]
    if not topics:
        raise NotFoundError(
            f"No topics of type '{_TYPE}' found.",
            hint="Controller managers of Lyrical and later have them where hardware reports.",
        )
    learn_type(_TYPE, graph)
    if not as_json:
        console.note("Subscribing to the following topics:")
        for topic in topics:
            console.note(f"\t{topic}")
    watch = _Watch(hardware_id, device_id)
    show = _show_json if as_json else _show
    with (
        command_node(ros_args=ros_args or ()) as node,
        SingleThreadedExecutor(context=node.context) as executor,
    ):
        for topic in topics:
            node.create_subscription(
                get_message(_TYPE), topic, lambda message: watch.take(message, show), 10
            )
        executor.add_node(node)
        executor.spin()


# Any, here and below: a HardwareStatus, or a part of one.
class _Watch:
    """Which messages are shown, and whether those that are asked for exist."""

    def __init__(self, hardware_id: str | None, device_id: str | None) -> None:
        self._hardware_id = hardware_id
        self._device_id = device_id
        self._hardware: set[str] = set()
        self._devices: set[str] = set()
        self._count = 0

    def take(self, message: Any, show: Callable[[Any, list[Any]], None]) -> None:
        """Print a message, if it is of the selected hardware.

        Raises:
            NotFoundError: What is asked for was not among the first messages.
        """
        self._count += 1
        self._hardware.add(message.hardware_id)
        self._devices.update(device.device_id for device in message.hardware_device_states)
        if self._count == _ENOUGH:
            _check("Hardware", self._hardware_id, self._hardware)
            _check("Device", self._device_id, self._devices)
        if self._hardware_id not in (None, message.hardware_id):
            return
        devices = [
            device
            for device in message.hardware_device_states
            if self._device_id in (None, device.device_id)
        ]
        if devices or self._device_id is None:
            show(message, devices)
            console.flush()


def _check(what: str, wanted: str | None, known: set[str]) -> None:
    if wanted is not None and wanted not in known:
        raise NotFoundError(
            f"{what} ID '{wanted}' not found.",
            hint=what_there_is(f"{what.lower()} IDs", [wanted], sorted(known)),
        )


def _show(message: Any, devices: list[Any]) -> None:
    stamp = message.header.stamp
    clock = time.strftime("%H:%M:%S", time.localtime(stamp.sec))
    console.out_coloured(
        ("Hardware ID: ", _GREEN),
        (f"{message.hardware_id} (", ""),
        (f"stamp: {clock}.{stamp.nanosec // 1_000_000:03d}", _YELLOW),
        (")", ""),
    )
    for device in devices:
        console.out_coloured(("  Device ID: ", _CYAN), (device.device_id, ""))
        lines = list(_states(device))
        if not lines:
            console.out_coloured(("    Status: No specific states reported", _RED))
        for line, colour in lines:
            console.out_coloured((line, colour))
    console.out("---")


def _states(device: Any) -> Iterator[tuple[str, str]]:
    for title, field in _KINDS.items():
        # A distribution may lack a kind.
        states = getattr(device, field, ())
        if states:
            yield f"    {title}:", _BLUE
        for state in states:
            yield "      -", ""
            for line in message_to_yaml(state).splitlines():
                yield f"        {line}", ""


def _show_json(message: Any, devices: list[Any]) -> None:
    console.out_json(
        {
            "header": json_value(message.header),
            "hardware_id": message.hardware_id,
            "hardware_device_states": [json_value(device) for device in devices],
        },
        compact=True,
    )
