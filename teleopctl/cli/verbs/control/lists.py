"""``control list_controllers`` and ``list_controller_types``."""

from collections.abc import Iterable, Iterator

from teleopctl.base.typed import Annotated, Any
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Option
from teleopctl.cli.verbs.control.session import (
    DEFAULT_MANAGER,
    ManagerName,
    RosArgs,
    manager_client,
)

_COLORS = {"active": "\033[92m", "inactive": "\033[96m", "unconfigured": "\033[93m"}

_CONTROLLER_FIELDS = (
    "name",
    "type",
    "state",
    "update_rate",
    "is_async",
    "claimed_interfaces",
    "required_command_interfaces",
    "required_state_interfaces",
    "is_chainable",
    "is_chained",
    "exported_state_interfaces",
    "reference_interfaces",
)


def list_controllers(
    claimed_interfaces: Annotated[
        bool, Option("--claimed-interfaces", help="List the commands that each one owns.")
    ] = False,
    required_state_interfaces: Annotated[
        bool, Option("--required-state-interfaces", help="List the states that each one needs.")
    ] = False,
    required_command_interfaces: Annotated[
        bool,
        Option("--required-command-interfaces", help="List the commands that each one needs."),
    ] = False,
    chained_interfaces: Annotated[
        bool, Option("--chained-interfaces", help="List what each one is chained to.")
    ] = False,
    reference_interfaces: Annotated[
        bool,
        Option("--reference-interfaces", help="List the references that each one exports."),
    ] = False,
    exported_interfaces: Annotated[
        bool, Option("--exported-interfaces", help="List the interfaces that each one exports.")
    ] = False,
    verbose: Annotated[bool, Option("-v", "--verbose", help="List all of that.")] = False,
    controller_manager: ManagerName = DEFAULT_MANAGER,
    ros_args: RosArgs = None,
    as_json: AsJson = False,
) -> None:
    """List loaded controllers and their states."""
    if reference_interfaces:
        console.warn(
            "The '--reference-interfaces' argument is deprecated and will be removed in future "
            "releases. Use '--exported-interfaces' instead."
        )
    with manager_client(controller_manager, ros_args) as client:
        controllers = client.list_controllers()
    if as_json:
        console.out_json([_as_document(controller) for controller in controllers])
        return
    if not controllers:
        console.out("No controllers are currently loaded!")
        return
    names = max(len(controller.name) for controller in controllers)
    types = max(len(controller.type) for controller in controllers)
    states = max(len(controller.state) for controller in controllers)
    for controller in controllers:
        color = _COLORS.get(controller.state, "")
        console.out_coloured(
            (f"{controller.name:{names}}", color),
            (f" {controller.type:{types}}  ", ""),
            (f"{controller.state:{states}}", color),
        )
        if verbose:
            console.out(f"\tupdate_rate: {controller.update_rate} Hz")
            console.out(f"\tis_async: {controller.is_async}")
        if claimed_interfaces or verbose:
            _print_list("claimed interfaces", controller.claimed_interfaces)
        if required_command_interfaces or verbose:
            _print_list("required command interfaces", controller.required_command_interfaces)
        if required_state_interfaces or verbose:
            _print_list("required state interfaces", controller.required_state_interfaces)
        if chained_interfaces or verbose:
            _print_list("chained to interfaces", _chained(controller))
        if reference_interfaces or exported_interfaces or verbose:
            _print_list("exported reference interfaces", controller.reference_interfaces)
        if reference_interfaces or exported_interfaces or verbose:
            _print_list("exported state interfaces", controller.exported_state_interfaces)


def _print_list(title: str, entries: Iterable[str]) -> None:
    console.out(f"\t{title}:")
    console.out_lines(f"\t\t{entry}" for entry in entries)


def _chained(controller: Any) -> Iterator[str]:
    for connection in controller.chain_connections:
        for reference in connection.reference_interfaces:
            yield f"{reference:20}"


def _as_document(controller: Any) -> dict[str, Any]:
    document = {}
    for name in _CONTROLLER_FIELDS:
        value = getattr(controller, name)
        document[name] = value if isinstance(value, (str, int, bool)) else list(value)
    document["chain_connections"] = [
        {"name": one.name, "reference_interfaces": list(one.reference_interfaces)}
        for one in controller.chain_connections
    ]
    return document


def list_controller_types(
    controller_manager: ManagerName = DEFAULT_MANAGER,
    ros_args: RosArgs = None,
    as_json: AsJson = False,
) -> None:
    """List the controller types that can be loaded."""
    with manager_client(controller_manager, ros_args) as client:
        response = client.call("list_controller_types", "ListControllerTypes")
    pairs = list(zip(response.types, response.base_classes, strict=True))
    if as_json:
        console.out_json([{"type": kind, "base_class": base} for kind, base in pairs])
        return
    console.out_lines(f"{kind:70} {base}" for kind, base in pairs)
