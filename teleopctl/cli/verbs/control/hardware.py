"""``teleopctl control``: verbs about hardware components."""

from collections.abc import Callable, Iterator

from teleopctl.base.typed import Annotated, Any
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.control.manager import ManagerOptions, RosArgs, TargetState
from teleopctl.errors import NotFoundError, RefusedError, existing_names_hint

_STATES = {"unconfigured": 1, "inactive": 2, "active": 3}
_DOING = {"unconfigured": "cleaning up", "inactive": "stopping", "active": "activating"}
_GREEN, _CYAN, _BLUE = "\033[92m", "\033[96m", "\033[94m"
_YELLOW, _RED, _MAGENTA = "\033[93m", "\033[91m", "\033[95m"
# By the id of lifecycle_msgs/State.
_STATE_COLOURS = {1: _YELLOW, 2: _MAGENTA, 3: _GREEN}


def list_hardware_components(
    verbose: Annotated[
        bool, Option("-v", "--verbose", help="List state interfaces and data types, too.")
    ] = False,
    *,
    manager: ManagerOptions,
    as_json: AsJson = False,
) -> None:
    """Print hardware components with their states and command interfaces."""
    components = manager.response("list_hardware_components", "ListHardwareComponents").component
    if as_json:
        console.out_json([_component_document(component) for component in components])
        return
    for number, component in enumerate(components, start=1):
        state = component.state
        colour = _STATE_COLOURS.get(state.id, _RED)
        console.out(f"Hardware Component {number}")
        console.out_coloured(("\tname: ", ""), (component.name, colour))
        console.out(f"\ttype: {component.type}")
        console.out(f"\tplugin name: {component.plugin_name}")
        console.out_coloured((f"\tstate: id={state.id} label=", ""), (state.label, colour))
        console.out(f"\tread/write rate: {component.rw_rate} Hz")
        console.out(f"\tis_async: {component.is_async}")
        console.out("\tcommand interfaces")
        for command in component.command_interfaces:
            claimed = _claimed(command)
            console.out_coloured(
                (f"\t\t{_typed_name(command, verbose)} ", ""),
                _availability(command),
                (" ", ""),
                (claimed, _BLUE if command.is_claimed else ""),
            )
        if verbose:
            console.out("\tstate interfaces")
            for measured in component.state_interfaces:
                console.out_coloured(
                    (f"\t\t{_typed_name(measured, verbose)} ", ""), _availability(measured)
                )


def list_hardware_interfaces(
    verbose: Annotated[bool, Option("-v", "--verbose", help="Show data types.")] = False,
    *,
    manager: ManagerOptions,
    as_json: AsJson = False,
) -> None:
    """List the command and state interfaces of the hardware."""
    response = manager.response("list_hardware_interfaces", "ListHardwareInterfaces")
    commands = sorted(response.command_interfaces, key=_name)
    states = sorted(response.state_interfaces, key=_name)
    if as_json:
        console.out_json(
            {
                "command_interfaces": [_interface_document(command) for command in commands],
                "state_interfaces": [_interface_document(state) for state in states],
            }
        )
        return
    console.out("command interfaces")
    for command in commands:
        available, _ = _availability(command)
        colour = _YELLOW
        if command.is_available:
            colour = _BLUE if command.is_claimed else _CYAN
        text = f"{_typed_name(command, verbose)} {available} {_claimed(command)}"
        console.out_coloured(("\t", ""), (text, colour))
    console.out("state interfaces")
    console.out_lines(f"\t{_typed_name(state, verbose)}" for state in states)


def set_hardware_component_state(
    component_name: Annotated[
        str, Argument(help="The hardware component.", complete="hardware_components")
    ],
    state: TargetState,
    *,
    manager: ManagerOptions,
    as_json: AsJson = False,
) -> None:
    """Bring a hardware component to a state."""
    from teleopctl.interfaces import get_message

    target = get_message("lifecycle_msgs/msg/State")(id=_STATES[state], label=state)
    with manager.client() as client:
        response = client.call(
            "set_hardware_component_state",
            "SetHardwareComponentState",
            name=component_name,
            target_state=target,
        )
        if not response.ok:
            there = client.call("list_hardware_components", "ListHardwareComponents").component
            known = [component.name for component in there]
            raise RefusedError(
                f"Error {_DOING[state]} hardware component, check controller_manager logs",
                hint=None
                if component_name in known
                else existing_names_hint("hardware components", [component_name], known),
            )
    console.out_done(
        f"Successfully set {component_name} to state {response.state}",
        as_json=as_json,
        component=component_name,
        state={"id": response.state.id, "label": response.state.label},
    )


def _name(interface: Any) -> str:
    name: str = interface.name
    return name


def _typed_name(interface: Any, verbose: bool) -> str:
    return f"{interface.name} [{interface.data_type}]" if verbose else str(interface.name)


def _availability(interface: Any) -> tuple[str, str]:
    """Return the word for an interface's availability, and its colour."""
    return ("[available]", _BLUE) if interface.is_available else ("[unavailable]", _YELLOW)


def _claimed(interface: Any) -> str:
    return "[claimed]" if interface.is_claimed else "[unclaimed]"


def _interface_document(interface: Any) -> dict[str, Any]:
    return {
        "name": interface.name,
        "data_type": interface.data_type,
        "is_available": interface.is_available,
        "is_claimed": interface.is_claimed,
    }


def _component_document(component: Any) -> dict[str, Any]:
    return {
        "name": component.name,
        "type": component.type,
        "plugin_name": component.plugin_name,
        "state": {"id": component.state.id, "label": component.state.label},
        "rw_rate": component.rw_rate,
        "is_async": component.is_async,
        "command_interfaces": [_interface_document(c) for c in component.command_interfaces],
        "state_interfaces": [_interface_document(s) for s in component.state_interfaces],
    }


_TYPE = "control_msgs/msg/HardwareStatus"
_TOPIC = "/hardware_status"
# Number of messages after which an ID that was not received counts as wrong, as in ros2.
_ENOUGH = 10
_KINDS = {
    "Generic Hardware States": "hardware_status",
    "CANopen States": "canopen_states",
    "EtherCAT States": "ethercat_states",
    "VDA5050 States": "vda5050_states",
}


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
    """Print status messages of hardware components until Ctrl-C."""
    from teleopctl.cli.command_node import command_node
    from teleopctl.cli.graph_lookup import learn_type, live_graph
    from teleopctl.interfaces import get_message
    from teleopctl.node import SingleThreadedExecutor

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
    selected = _StatusFilter(hardware_id, device_id)
    show = _print_status_as_json if as_json else _print_status
    with (
        command_node(ros_args=ros_args or ()) as node,
        SingleThreadedExecutor(context=node.context) as executor,
    ):
        for topic in topics:
            node.create_subscription(
                get_message(_TYPE), topic, lambda message: selected.show_selected(message, show), 10
            )
        executor.add_node(node)
        executor.spin()


# Any, here and below: a HardwareStatus, or a part of one.
class _StatusFilter:
    """Filter of status messages by hardware and device ID, with a check that the IDs exist."""

    def __init__(self, hardware_id: str | None, device_id: str | None) -> None:
        self._hardware_id = hardware_id
        self._device_id = device_id
        self._hardware: set[str] = set()
        self._devices: set[str] = set()
        self._count = 0

    def show_selected(self, message: Any, show: Callable[[Any, list[Any]], None]) -> None:
        """Call ``show`` with a status and its selected devices, if it is of the selected hardware.

        Raises:
            NotFoundError: The selected hardware or device was not in the first messages.
        """
        self._count += 1
        self._hardware.add(message.hardware_id)
        self._devices.update(device.device_id for device in message.hardware_device_states)
        if self._count == _ENOUGH:
            _check_known("Hardware", self._hardware_id, self._hardware)
            _check_known("Device", self._device_id, self._devices)
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


def _check_known(what: str, wanted: str | None, known: set[str]) -> None:
    if wanted is not None and wanted not in known:
        raise NotFoundError(
            f"{what} ID '{wanted}' not found.",
            hint=existing_names_hint(f"{what.lower()} IDs", [wanted], sorted(known)),
        )


def _print_status(message: Any, devices: list[Any]) -> None:
    import time

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
        lines = list(_state_lines(device))
        if not lines:
            console.out_coloured(("    Status: No specific states reported", _RED))
        for line, colour in lines:
            console.out_coloured((line, colour))
    console.out("---")


def _state_lines(device: Any) -> Iterator[tuple[str, str]]:
    from teleopctl.interfaces import message_to_yaml

    for title, field in _KINDS.items():
        # Messages of a distribution may lack a field.
        states = getattr(device, field, ())
        if states:
            yield f"    {title}:", _BLUE
        for state in states:
            yield "      -", ""
            for line in message_to_yaml(state).splitlines():
                yield f"        {line}", ""


def _print_status_as_json(message: Any, devices: list[Any]) -> None:
    from teleopctl.cli.verbs.topic.text import json_value

    console.out_json(
        {
            "header": json_value(message.header),
            "hardware_id": message.hardware_id,
            "hardware_device_states": [json_value(device) for device in devices],
        },
        compact=True,
    )
