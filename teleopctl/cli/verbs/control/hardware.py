"""``control`` verbs about hardware."""

from teleopctl.base.typed import Annotated, Any
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.control.session import (
    DEFAULT_MANAGER,
    ManagerName,
    RosArgs,
    TargetState,
    manager_client,
)
from teleopctl.errors import RefusedError, what_there_is

_STATES = {"unconfigured": 1, "inactive": 2, "active": 3}
_DOING = {"unconfigured": "cleaning up", "inactive": "stopping", "active": "activating"}


def list_hardware_components(
    verbose: Annotated[
        bool, Option("-v", "--verbose", help="List state interfaces and data types, too.")
    ] = False,
    controller_manager: ManagerName = DEFAULT_MANAGER,
    ros_args: RosArgs = None,
    as_json: AsJson = False,
) -> None:
    """List hardware and its states."""
    with manager_client(controller_manager, ros_args) as client:
        components = client.call("list_hardware_components", "ListHardwareComponents").component
    if as_json:
        console.out_json([_component_document(component) for component in components])
        return
    for number, component in enumerate(components, start=1):
        state = component.state
        console.out(f"Hardware Component {number}")
        console.out(f"\tname: {component.name}")
        console.out(f"\ttype: {component.type}")
        console.out(f"\tplugin name: {component.plugin_name}")
        console.out(f"\tstate: id={state.id} label={state.label}")
        console.out(f"\tread/write rate: {component.rw_rate} Hz")
        console.out(f"\tis_async: {component.is_async}")
        console.out("\tcommand interfaces")
        console.out_lines(
            f"\t\t{_interface(command, verbose)} {_claimed(command)}"
            for command in component.command_interfaces
        )
        if verbose:
            console.out("\tstate interfaces")
            console.out_lines(
                f"\t\t{_interface(measured, verbose)}" for measured in component.state_interfaces
            )


def list_hardware_interfaces(
    verbose: Annotated[bool, Option("-v", "--verbose", help="Show data types.")] = False,
    controller_manager: ManagerName = DEFAULT_MANAGER,
    ros_args: RosArgs = None,
    as_json: AsJson = False,
) -> None:
    """List the command and state interfaces of the hardware."""
    with manager_client(controller_manager, ros_args) as client:
        response = client.call("list_hardware_interfaces", "ListHardwareInterfaces")
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
    console.out_lines(
        f"\t{_interface(command, verbose)} {_claimed(command)}" for command in commands
    )
    console.out("state interfaces")
    console.out_lines(
        f"\t{state.name} [{state.data_type}]" if verbose else f"\t{state.name}" for state in states
    )


def set_hardware_component_state(
    component_name: Annotated[str, Argument(help="The hardware component.")],
    state: TargetState,
    controller_manager: ManagerName = DEFAULT_MANAGER,
    ros_args: RosArgs = None,
    as_json: AsJson = False,
) -> None:
    """Bring a hardware component to a state."""
    from teleopctl.interfaces import get_message

    target = get_message("lifecycle_msgs/msg/State")(id=_STATES[state], label=state)
    with manager_client(controller_manager, ros_args) as client:
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
                else what_there_is("hardware components", [component_name], known),
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


def _interface(interface: Any, verbose: bool) -> str:
    data_type = f" [{interface.data_type}]" if verbose else ""
    available = "available" if interface.is_available else "unavailable"
    return f"{interface.name}{data_type} [{available}]"


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
