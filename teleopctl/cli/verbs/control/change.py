"""``control`` verbs that change controllers."""

from pathlib import Path

from teleopctl.base.typed import TYPE_CHECKING, Annotated
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.control.session import (
    DEFAULT_MANAGER,
    ControllerName,
    ManagerName,
    RosArgs,
    TargetState,
    manager_client,
)
from teleopctl.errors import RefusedError, UsageError

if TYPE_CHECKING:
    from teleopctl.control import ControllerManagerClient

_LOGS = "check controller_manager logs"


def load_controller(
    controller_name: Annotated[str, Argument(help="The controller.")],
    param_file: Annotated[
        str | None, Argument(help="Parameter file for it.", metavar="PARAM_FILE")
    ] = None,
    set_state: Annotated[
        str | None,
        Option(
            "--set-state",
            help="Bring it to this state as well.",
            metavar="STATE",
            choices=("inactive", "active"),
        ),
    ] = None,
    controller_manager: ManagerName = DEFAULT_MANAGER,
    ros_args: RosArgs = None,
    as_json: AsJson = False,
) -> None:
    """Load a controller."""
    if param_file and not Path(param_file).is_file():
        raise RefusedError(f"Controller parameter file : {param_file} does not exist, Aborting!")
    name = controller_name
    with manager_client(controller_manager, ros_args) as client:
        states = _states(client)
        if name in states:
            say = console.note if as_json else console.out
            say(f"Controller : {name} already loaded, skipping load_controller!")
        else:
            if param_file:
                _set_param_file(client, name, param_file)
            if not client.load_controller(name):
                raise _refused(f"Failed loading controller {name} {_LOGS}", client, name)
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
    from teleopctl.control import manager_settings

    for setting, value in manager_settings(name, client.name, [file]).items():
        if not client.set_parameter(f"{name}.{setting}", value):
            raise RefusedError(f"Could not set {name}.{setting} to {value} on {client.name}")


def unload_controller(
    controller_name: ControllerName,
    controller_manager: ManagerName = DEFAULT_MANAGER,
    ros_args: RosArgs = None,
    as_json: AsJson = False,
) -> None:
    """Unload a controller."""
    with manager_client(controller_manager, ros_args) as client:
        if not client.unload_controller(controller_name):
            text = f"Error unloading controller {controller_name}, {_LOGS}"
            raise _refused(text, client, controller_name)
    text = f"Successfully unloaded controller {controller_name}"
    _say(text, controller_name, None, as_json)


def cleanup_controller(
    controller_name: ControllerName,
    controller_manager: ManagerName = DEFAULT_MANAGER,
    ros_args: RosArgs = None,
    as_json: AsJson = False,
) -> None:
    """Bring a controller back to unconfigured."""
    with manager_client(controller_manager, ros_args) as client:
        if not client.cleanup_controller(controller_name):
            text = f"Error cleaning up controller {controller_name}, {_LOGS}"
            raise _refused(text, client, controller_name)
    text = f"Successfully cleaned up controller {controller_name}"
    _say(text, controller_name, "unconfigured", as_json)


def set_controller_state(
    controller_name: ControllerName,
    state: TargetState,
    controller_manager: ManagerName = DEFAULT_MANAGER,
    ros_args: RosArgs = None,
    as_json: AsJson = False,
) -> None:
    """Bring a controller to a state."""
    name = controller_name
    with manager_client(controller_manager, ros_args) as client:
        present = _states(client).get(name)
        match present, state:
            case None, _:
                raise RefusedError(f"controller {name} does not seem to be loaded")
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
        Option("--deactivate", help="Controllers to stop.", complete="controllers"),
    ] = None,
    activate: Annotated[
        list[str] | None,
        Option("--activate", help="Controllers to start.", complete="controllers"),
    ] = None,
    strict: Annotated[
        bool, Option("--strict", help="Change nothing unless all can be changed.")
    ] = False,
    best_effort: Annotated[
        bool, Option("--best-effort", help="Change those that can be changed.")
    ] = False,
    activate_asap: Annotated[
        bool, Option("--activate-asap", help="Switch between two control cycles.")
    ] = False,
    switch_timeout: Annotated[
        float, Option("--switch-timeout", help="Longest time for the switch, s.", metavar="S")
    ] = 5.0,
    controller_manager: ManagerName = DEFAULT_MANAGER,
    ros_args: RosArgs = None,
    as_json: AsJson = False,
) -> None:
    """Stop and start controllers in one go."""
    if strict and best_effort:
        raise UsageError("--strict and --best-effort exclude each other")
    with manager_client(controller_manager, ros_args) as client:
        ok, message = client.switch_controllers(
            activate or (),
            deactivate or (),
            strictness=2 if strict else 1 if best_effort else 0,
            asap=activate_asap,
            timeout=switch_timeout,
        )
    if not ok:
        raise RefusedError(message)
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
    controller_manager: ManagerName = DEFAULT_MANAGER,
    ros_args: RosArgs = None,
    as_json: AsJson = False,
) -> None:
    """Unload all controllers and read their code again."""
    with manager_client(controller_manager, ros_args) as client:
        response = client.call(
            "reload_controller_libraries", "ReloadControllerLibraries", force_kill=force_kill
        )
        if not response.ok:
            raise RefusedError(
                f"Error reloading libraries, {_LOGS}", hint=client.why_not_reloaded()
            )
    console.out_done("Reload successful", as_json=as_json, reloaded=True)


def _say(text: str, controller: str, state: str | None, as_json: bool) -> None:
    """Say in which state a controller is now; None once it is unloaded."""
    console.out_done(text, as_json=as_json, controller=controller, state=state)


def _refused(text: str, client: "ControllerManagerClient", controller: str) -> RefusedError:
    return RefusedError(text, hint=client.cause(controller))


def _states(client: "ControllerManagerClient") -> dict[str, str]:
    return {controller.name: controller.state for controller in client.list_controllers()}
