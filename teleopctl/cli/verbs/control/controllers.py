"""``teleopctl control``: verbs about controllers."""

from teleopctl.base.typed import TYPE_CHECKING, Annotated, Any, Iterable, Iterator
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.control.manager import ControllerName, ManagerOptions, TargetState
from teleopctl.errors import RefusedError, UsageError, existing_names_hint

if TYPE_CHECKING:
    from teleopctl.control import ControllerManagerClient
    from teleopctl.diagram import Diagram


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
    *,
    manager: ManagerOptions,
    as_json: AsJson = False,
) -> None:
    """List loaded controllers and their states."""
    if reference_interfaces:
        console.warn(
            "The '--reference-interfaces' argument is deprecated and will be removed in future "
            "releases. Use '--exported-interfaces' instead."
        )
    controllers = manager.response("list_controllers", "ListControllers").controller
    if as_json:
        console.out_json([_controller_document(controller) for controller in controllers])
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


def _controller_document(controller: Any) -> dict[str, Any]:
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
    *,
    manager: ManagerOptions,
    as_json: AsJson = False,
) -> None:
    """List the controller types that can be loaded."""
    response = manager.response("list_controller_types", "ListControllerTypes")
    pairs = list(zip(response.types, response.base_classes, strict=True))
    if as_json:
        console.out_json([{"type": kind, "base_class": base} for kind, base in pairs])
        return
    console.out_lines(f"{kind:70} {base}" for kind, base in pairs)


_LOGS = "check controller_manager logs"


def load_controller(
    controller_name: Annotated[
        str, Argument(help="The controller.", complete="loadable_controllers")
    ],
    param_file: Annotated[
        str | None, Argument(help="Parameter file for it.", metavar="PARAM_FILE")
    ] = None,
    set_state: Annotated[
        str | None,
        Option(
            "--set-state",
            help="State to bring the controller to after loading.",
            metavar="STATE",
            choices=("inactive", "active"),
        ),
    ] = None,
    *,
    manager: ManagerOptions,
    as_json: AsJson = False,
) -> None:
    """Load a controller, and configure or activate it if ``set_state`` is given."""
    from pathlib import Path

    if param_file and not Path(param_file).is_file():
        raise RefusedError(f"Controller parameter file : {param_file} does not exist, Aborting!")
    name = controller_name
    with manager.client() as client:
        states = _states(client)
        if name in states:
            say = console.note if as_json else console.out
            say(f"Controller : {name} already loaded, skipping load_controller!")
        else:
            if param_file:
                _set_param_file(client, name, param_file)
            if not client.load_controller(name):
                raise RefusedError(
                    f"Failed loading controller {name} {_LOGS}", hint=client.cause(name)
                )
            if set_state is None or not as_json:
                _say(f"Successfully loaded controller {name}", name, "unconfigured", as_json)
        if set_state is None:
            if as_json and name in states:
                _say("", name, states[name], as_json)
            return
        unconfigured = states.get(name, "unconfigured") == "unconfigured"
        if unconfigured and not client.configure_controller(name):
            raise _refused(f"Error configuring controller : {name}", client, name)
        if set_state == "active":
            ok, message = client.switch_controllers([name])
            if not ok:
                raise RefusedError(f"Error activating controller : {name}, {_LOGS}", hint=message)
        text = f"Successfully loaded controller {name} into state {set_state}"
        _say(text, name, set_state, as_json)


def _set_param_file(client: "ControllerManagerClient", name: str, file: str) -> None:
    from teleopctl.control import controller_load_parameters

    for setting, value in controller_load_parameters(name, client.name, [file]).items():
        if not client.set_parameter(f"{name}.{setting}", value):
            raise RefusedError(f"Could not set {name}.{setting} to {value} on {client.name}")


def unload_controller(
    controller_name: ControllerName,
    *,
    manager: ManagerOptions,
    as_json: AsJson = False,
) -> None:
    """Unload a controller."""
    with manager.client() as client:
        if not client.unload_controller(controller_name):
            text = f"Error unloading controller {controller_name}, {_LOGS}"
            raise _refused(text, client, controller_name)
    text = f"Successfully unloaded controller {controller_name}"
    _say(text, controller_name, None, as_json)


def cleanup_controller(
    controller_name: ControllerName,
    *,
    manager: ManagerOptions,
    as_json: AsJson = False,
) -> None:
    """Bring a controller back to unconfigured."""
    with manager.client() as client:
        if not client.cleanup_controller(controller_name):
            text = f"Error cleaning up controller {controller_name}, {_LOGS}"
            raise _refused(text, client, controller_name)
    text = f"Successfully cleaned up controller {controller_name}"
    _say(text, controller_name, "unconfigured", as_json)


def set_controller_state(
    controller_name: ControllerName,
    state: TargetState,
    *,
    manager: ManagerOptions,
    as_json: AsJson = False,
) -> None:
    """Bring a controller to a state that one transition reaches, else raise an error."""
    name = controller_name
    with manager.client() as client:
        states = _states(client)
        present = states.get(name)
        match present, state:
            case None, _:
                text = f"controller {name} does not seem to be loaded"
                raise RefusedError(text, hint=existing_names_hint("controllers", [name], states))
            case "inactive", "unconfigured":
                if not client.cleanup_controller(name):
                    raise _refused(f"Error cleaning up controller, {_LOGS}", client, name)
                _say(f"successfully cleaned up {name}", name, state, as_json)
            case "unconfigured", "inactive":
                if not client.configure_controller(name):
                    raise _refused(f"Error configuring controller, {_LOGS}", client, name)
                _say(f"Successfully configured {name}", name, state, as_json)
            case "active", "inactive":
                ok, message = client.switch_controllers((), [name])
                if not ok:
                    raise RefusedError(f"Error stopping controller, {_LOGS}", hint=message)
                _say(f"Successfully deactivated {name}", name, state, as_json)
            case "inactive", "active":
                ok, message = client.switch_controllers([name])
                if not ok:
                    raise RefusedError(f"Error activating controller, {_LOGS}", hint=message)
                _say(f"Successfully activated {name}", name, state, as_json)
            case _:
                refused = {
                    "unconfigured": f"cleanup {name}",
                    "inactive": f"put {name} in 'inactive' state",
                    "active": f"activate {name}",
                }[state]
                raise RefusedError(f"cannot {refused} from its current state {present}")


def switch_controllers(
    deactivate: Annotated[
        list[str] | None,
        Option("--deactivate", help="Controllers to stop.", complete="active_controllers"),
    ] = None,
    activate: Annotated[
        list[str] | None,
        Option("--activate", help="Controllers to start.", complete="inactive_controllers"),
    ] = None,
    strict: Annotated[bool, Option("--strict", help="Switch all controllers or none.")] = False,
    best_effort: Annotated[
        bool, Option("--best-effort", help="Switch the controllers that can be switched.")
    ] = False,
    activate_asap: Annotated[
        bool, Option("--activate-asap", help="Switch between two control cycles.")
    ] = False,
    switch_timeout: Annotated[
        float, Option("--switch-timeout", help="Longest time for the switch, s.", metavar="S")
    ] = 5.0,
    *,
    manager: ManagerOptions,
    as_json: AsJson = False,
) -> None:
    """Stop and start controllers in one switch."""
    if strict and best_effort:
        raise UsageError("--strict and --best-effort exclude each other")
    with manager.client() as client:
        ok, message = client.switch_controllers(
            activate or (),
            deactivate or (),
            strictness=2 if strict else 1 if best_effort else 0,
            asap=activate_asap,
            timeout=switch_timeout,
        )
        if not ok:
            named = [*(activate or ()), *(deactivate or ())]
            raise RefusedError(message, hint=_unknown_names_hint(client, named))
    console.out_done(
        message,
        as_json=as_json,
        activate=activate or [],
        deactivate=deactivate or [],
        message=message,
    )


def reload_controller_libraries(
    force_kill: Annotated[
        bool, Option("--force-kill", help="Stop active controllers as well.")
    ] = False,
    *,
    manager: ManagerOptions,
    as_json: AsJson = False,
) -> None:
    """Unload all controllers and read their code again."""
    with manager.client() as client:
        response = client.call(
            "reload_controller_libraries", "ReloadControllerLibraries", force_kill=force_kill
        )
        if not response.ok:
            raise RefusedError(f"Error reloading libraries, {_LOGS}", hint=client.reload_error())
    console.out_done("Reload successful", as_json=as_json, reloaded=True)


def _say(text: str, controller: str, state: str | None, as_json: bool) -> None:
    """Print a controller's new state; None for an unloaded controller."""
    console.out_done(text, as_json=as_json, controller=controller, state=state)


def _refused(text: str, client: "ControllerManagerClient", controller: str) -> RefusedError:
    cause = client.cause(controller)
    near = _unknown_names_hint(client, [controller])
    return RefusedError(text, hint="\n  ".join(filter(None, (cause, near))) or None)


def _unknown_names_hint(client: "ControllerManagerClient", names: Iterable[str]) -> str | None:
    """Return a hint with similar names of loaded controllers; None if all names are loaded."""
    loaded = _states(client)
    unknown = [name for name in names if name not in loaded]
    return existing_names_hint("controllers", unknown, loaded) if unknown else None


def _states(client: "ControllerManagerClient") -> dict[str, str]:
    return {controller.name: controller.state for controller in client.list_controllers()}


# Name of the PDF file of ros2 control.
_NAME = "controller_diagram"


def view_controller_chains(
    output: Annotated[
        str | None,
        Option(
            "-o",
            "--output",
            help="File name without extension; by default in the folder for temporary files.",
            metavar="FILE",
        ),
    ] = None,
    *,
    manager: ManagerOptions,
    as_json: AsJson = False,
) -> None:
    """Write a diagram of controllers and their interfaces as DOT, SVG and PDF files.

    Shows state interfaces on the left of each controller, and the commanded interfaces on the
    right: of hardware, or reference interfaces of the next controller. Writes a Graphviz file, an
    SVG, and a PDF if Graphviz's program dot is installed.
    """
    import tempfile
    from pathlib import Path

    from teleopctl.cli.listing import out_files
    from teleopctl.diagram import format_dot, to_svg, write_diagram_files

    with manager.client() as client:
        diagram = controller_diagram(client.list_controllers())
    base = Path(output) if output else Path(tempfile.gettempdir()) / _NAME
    files = write_diagram_files(base, format_dot(diagram), to_svg(diagram), console.note)
    out_files(files, as_json=as_json)


# Any: ControllerState of controller_manager_msgs.
def controller_diagram(controllers: Iterable[Any]) -> "Diagram":
    """Return a diagram of controllers with their state and command interfaces."""
    from teleopctl.diagram import DiagramBox, connect

    boxes: dict[str, DiagramBox] = {}
    pairs: list[tuple[str, str]] = []

    def interface(name: str) -> str:
        # The state and the command interface of a joint's position have a box each.
        return boxes.setdefault(name, DiagramBox(name, name.partition(" ")[2], "topic")).key

    for controller in controllers:
        key = f"controller {controller.name}"
        text = f"{controller.name}\n{controller.state}"
        boxes[key] = DiagramBox(key, text, "node")
        pairs += [
            (interface(f"state {name}"), key) for name in controller.required_state_interfaces
        ]
        # Exported interfaces are listed without the controller's name, which users of them prepend.
        pairs += [
            (interface(f"command {controller.name}/{name}"), key)
            for name in controller.reference_interfaces
        ]
        pairs += [
            (key, interface(f"state {controller.name}/{name}"))
            for name in controller.exported_state_interfaces
        ]
        pairs += [
            (key, interface(f"command {name}")) for name in controller.required_command_interfaces
        ]
    return connect(list(boxes.values()), pairs)
