"""``controller_manager/spawner`` and ``unspawner``: load, activate and unload controllers."""

from __future__ import annotations

import argparse
import contextlib
import os
import queue
import re
import signal
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType
from typing import NoReturn

from teleopctl import plugins
from teleopctl.base import progress
from teleopctl.control import (
    ControllerManagerClient,
    ControllerManagerUnavailableError,
    controller_load_parameters,
    parameter_place,
    similar_types,
)
from teleopctl.errors import TeleopctlError
from teleopctl.node import ExternalShutdownException, Node, init, parse_ros_arguments, try_shutdown


@dataclass
class SpawnRequest:
    """Request to load, configure and activate one controller.

    Attributes:
        name: Name of the controller.
        param_files: Parameter files for the controller's node; later files override earlier ones.
        load_only: Whether the controller stays unconfigured.
        inactive: Whether the controller stays inactive.
        ros_args: ROS arguments for the controller's node.
        type: Type of the controller, if no parameter file gives it.
    """

    name: str
    param_files: list[str] = field(default_factory=list)
    load_only: bool = False
    inactive: bool = False
    ros_args: list[str] = field(default_factory=list)
    type: str = ""


def _controller_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "-p",
        "--param-file",
        action="append",
        default=[],
        metavar="FILE",
        help="parameter file for the controller's node; may be given several times",
    )
    parser.add_argument(
        "--load-only", action="store_true", help="only load, leave the controller unconfigured"
    )
    parser.add_argument(
        "--inactive",
        "-s",  # as before Jazzy
        "--stopped",
        action="store_true",
        help="load and configure, but do not activate",
    )
    parser.add_argument(
        "-t",
        "--controller-type",
        default="",
        metavar="TYPE",
        help="the controller's type, if no parameter file gives it, as before Jazzy",
    )
    parser.add_argument(
        "--controller-ros-args",
        action="append",
        default=[],
        metavar="ARGS",
        help="ROS arguments for the controller's node",
    )


def add_manager_option(parser: argparse.ArgumentParser) -> None:
    """Add the option ``--controller-manager`` to a parser."""
    parser.add_argument(
        "-c",
        "--controller-manager",
        default="controller_manager",
        metavar="NAME",
        help="name of the controller manager's node",
    )


def _make_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="spawner",
        description="Load, configure and activate controllers.",
        epilog="--controller NAME [OPTIONS] names one more controller with options of its own.",
    )
    parser.add_argument("controller_names", nargs="*", metavar="NAME", help="controllers")
    add_manager_option(parser)
    parser.add_argument(
        "-n", "--namespace", default="", metavar="NS", help="the controller manager's namespace"
    )
    _controller_options(parser)
    staying = parser.add_mutually_exclusive_group()
    staying.add_argument(
        "--stay",
        action="store_true",
        help="keep running, and activate the controllers again whenever the controller manager "
        "restarts",
    )
    staying.add_argument(
        "-u",
        "--unload-on-kill",
        action="store_true",
        help="keep running, and deactivate and unload the controllers when interrupted",
    )
    parser.add_argument(
        "--controller-manager-timeout",
        type=float,
        default=0.0,
        metavar="S",
        help="seconds to wait for the controller manager; 0 waits forever",
    )
    parser.add_argument("--switch-timeout", type=float, default=5.0, metavar="S")
    parser.add_argument("--service-call-timeout", type=float, default=10.0, metavar="S")
    parser.add_argument(
        "--activate-as-group", action="store_true", help="activate all in one switch"
    )
    parser.add_argument(
        "--switch-asap",
        action=argparse.BooleanOptionalAction,
        default=False,
        help="switch between two control cycles instead of in parallel",
    )
    parser.add_argument(
        "--allow-active",
        action="store_true",
        help="do not fail for controllers that are already active",
    )
    parser.add_argument(
        "--keep-going",
        action=argparse.BooleanOptionalAction,
        default=False,
        help="activate the controllers that can be, and fail at the end; those of an unknown type "
        "are left out, and those whose joints are claimed stay inactive, with a warning",
    )
    return parser


def read_command_line(
    arguments: Sequence[str], ros_files: Sequence[str] = ()
) -> tuple[argparse.Namespace, list[SpawnRequest]]:
    """Parse the spawner's arguments; return common options and a request for each controller.

    Args:
        arguments: Arguments of the program, without ``--ros-args`` groups.
        ros_files: Parameter files of the spawner itself, which the controllers use too.
    """
    groups: list[list[str]] = [[]]
    for word in arguments:
        if word == "--controller":
            groups.append([])
        else:
            groups[-1].append(word)
    parser = _make_parser()
    options = parser.parse_args(groups[0])
    if options.namespace and not options.controller_manager.startswith("/"):
        options.controller_manager = f"/{options.namespace.strip('/')}/{options.controller_manager}"
    own = argparse.ArgumentParser(prog="spawner --controller", add_help=False)
    own.add_argument("name")
    _controller_options(own)
    requests = [
        SpawnRequest(
            name,
            list(options.param_file),
            options.load_only,
            options.inactive,
            list(options.controller_ros_args),
            options.controller_type,
        )
        # A launch argument may give several names as one word; names contain no blanks.
        for word in options.controller_names
        for name in word.split()
    ]
    for group in groups[1:]:
        given = own.parse_args(group)
        requests.append(
            SpawnRequest(
                given.name,
                [*options.param_file, *given.param_file],
                given.load_only or options.load_only,
                given.inactive or options.inactive,
                [*options.controller_ros_args, *given.controller_ros_args],
                given.controller_type or options.controller_type,
            )
        )
    if not requests:
        parser.error("At least one controller name must be provided")
    for request in requests:
        # A file that is given twice counts once, at its last position.
        own_files = list(dict.fromkeys(reversed(request.param_files)))[::-1]
        request.param_files = list(dict.fromkeys([*own_files, *ros_files]))
    return options, requests


_BLUE, _CYAN, _GREEN, _BOLD, _END = "\033[94m", "\033[96m", "\033[92m", "\033[1m", "\033[0m"


# Name of the parameter in a controller's reason for a failure.
_PARAMETER = re.compile("[Pp]arameter '([^']+)'")
# Part of the controller manager's refusal if another controller commands the joint in another mode.
_OTHER_MODE = "prepare command mode switch was rejected"


class SpawnError(Exception):
    """Error of the spawner: a controller could not be spawned; the reason was logged."""


class Spawner:
    """Client of a controller manager that loads, configures and activates controllers.

    Args:
        node: Node of the spawner.
        options: Common options of `read_command_line`.
    """

    def __init__(self, node: Node, options: argparse.Namespace) -> None:
        self._node = node
        self._options = options
        self._logger = node.get_logger()
        self._client = ControllerManagerClient(
            node, options.controller_manager, call_timeout=options.service_call_timeout
        )
        self._colors = _colors_wanted()

    def spawn(self, requests: Sequence[SpawnRequest]) -> None:
        """Wait for the controller manager; load, configure and activate controllers as requested.

        Raises:
            SpawnError: A controller could not be spawned; with ``--keep-going``, all others have
                been tried.
            ControllerManagerUnavailableError: The controller manager does not respond.
        """
        progress.report(progress.STARTING, f"waiting for {self._client.name}")
        self._client.wait(self._options.controller_manager_timeout, log_waiting=True)
        group: list[str] = []
        failures: list[str] = []
        for request in requests:
            if self._options.keep_going and (reason := self._unknown_type(request)):
                self._warn(f"Controller {request.name} is left out: {reason}")
                continue
            try:
                if self._prepare(request):
                    group.append(request.name)
            except SpawnError as error:
                if not self._options.keep_going:
                    raise
                failures.append(str(error))
        if failures:
            progress.report(progress.FAILED, "; ".join(failures))
            raise SpawnError
        if not group:
            return
        if refusal := self._switch(group):
            self._fail(
                f"Failed to activate the parsed controllers list : {group}",
                fatal=False,
                why=refusal,
            )
        self._logger.info(
            self._paint(
                _GREEN, f"Configured and activated all the parsed controllers list : {group}!"
            )
        )

    def stay(self, requests: Sequence[SpawnRequest]) -> NoReturn:
        """Spawn the controllers, and again in each new controller manager; never return.

        Raises:
            ExternalShutdownException: The context was shut down.
            ControllerManagerUnavailableError: No controller manager responds within
                ``--controller-manager-timeout``.
        """
        while True:
            progress.report(progress.STARTING)
            self._client.wait(self._options.controller_manager_timeout, log_waiting=True)
            served = self._client.sessions()
            try:
                self.spawn(requests)
                progress.report(progress.READY)
            except SpawnError:
                pass  # the reason is in the log, and in the progress file for a launch that waits
            except ControllerManagerUnavailableError as error:
                self._logger.error(error.message)  # the controller manager ended meanwhile
            self._client.wait_for_restart(served)

    def _prepare(self, request: SpawnRequest) -> bool:
        """Bring a controller up; return whether it still has to be activated with the group."""
        progress.doing(f"loading {request.name}")
        state = self._load(request)
        if request.load_only:
            return False
        if state == "active" and self._options.allow_active:
            self._logger.info(f"Controller {request.name} is already active")
            return False
        progress.doing(f"configuring {request.name}")
        if not self._client.configure_controller(request.name):
            files = request.param_files
            self._fail("Failed to configure controller", request.name, files, fatal=False)
        if request.inactive or self._options.activate_as_group:
            return not request.inactive
        if self._options.keep_going and (reason := self._claimed_joints(request.name)):
            self._warn(f"Controller {request.name} stays inactive: {reason}")
            return False
        refusal = self._switch([request.name])
        if not refusal:
            self._logger.info(self._bold(_GREEN, "Configured and activated ", request.name))
        elif self._options.keep_going and _OTHER_MODE in refusal:
            self._warn(f"Controller {request.name} stays inactive: {refusal}")
        else:
            self._fail(f"Failed to activate controller : {request.name}", fatal=False, why=refusal)
        return False

    def _unknown_type(self, request: SpawnRequest) -> str:
        """Return why a controller's type is unknown, with file and line; empty if it is known."""
        files = request.param_files
        try:
            settings = controller_load_parameters(request.name, self._client.name, files)
        except TeleopctlError:
            return ""  # `_load` reports it
        name = str(settings.get("type") or request.type)
        if not name or plugins.find(plugins.CONTROLLERS, name) is not None:
            return ""
        # The manager may run elsewhere, with other plug-ins than this process.
        types = self._client.call("list_controller_types", "ListControllerTypes").types
        if name in types:
            return ""
        place = parameter_place(request.name, self._client.name, files, "type")
        where = f" ({place})" if place else ""
        near = similar_types(name, types)
        hint = (
            f"Did you mean {' or '.join(near)}?"
            if near
            else "`teleopctl control list_controller_types` lists all."
        )
        return f"its type '{name}'{where} is unknown. {hint}"

    def _claimed_joints(self, name: str) -> str:
        """Return which active controllers claim a controller's commands; empty if none does."""
        controllers = self._client.list_controllers()
        wanted = {
            interface
            for controller in controllers
            if controller.name == name
            for interface in controller.required_command_interfaces
        }
        holders = {
            controller.name: claimed
            for controller in controllers
            if controller.name != name
            and (claimed := [one for one in controller.claimed_interfaces if one in wanted])
        }
        if not holders:
            return ""
        held = "; ".join(f"{holder} commands {', '.join(of)}" for holder, of in holders.items())
        manager = self._client.name
        option = "" if manager == "/controller_manager" else f" -c {manager}"
        return (
            f"{held}. To swap them: teleopctl control switch_controllers{option} "
            f"--deactivate {' '.join(holders)} --activate {name}"
        )

    def _warn(self, sentence: str) -> None:
        """Log a warning; a command that waits for this process in a launch shows it, too."""
        self._logger.warning(sentence)
        progress.remark(sentence)

    def _load(self, request: SpawnRequest) -> str:
        """Load a controller unless it is loaded; return its state."""
        present = {
            controller.name: controller.state for controller in self._client.list_controllers()
        }
        if request.name in present:
            self._logger.warning("Controller already loaded, skipping load_controller")
            return str(present[request.name])
        self._set_parameters(request)
        if not self._client.load_controller(request.name):
            self._fail(f"Failed loading controller {request.name}", request.name)
        self._logger.info(self._bold(_BLUE, "Loaded ", request.name))
        return "unconfigured"

    def _set_parameters(self, request: SpawnRequest) -> None:
        try:
            settings = controller_load_parameters(
                request.name, self._client.name, request.param_files
            )
        except TeleopctlError as error:
            self._fail(error.message)
        if request.type:
            settings.setdefault("type", request.type)
        if request.ros_args:
            settings["node_options_args"] = [
                word for arguments in request.ros_args for word in arguments.split()
            ]
        for name, value in settings.items():
            self._logger.info(
                self._paint(_CYAN, f'Setting controller param "{name}" to "{value}" for ')
                + self._paint(_CYAN + _BOLD, request.name)
            )
            if not self._client.set_parameter(f"{request.name}.{name}", value):
                self._fail(
                    f'Could not set controller param "{name}" to "{value}" for {request.name}'
                )

    def _switch(self, names: Sequence[str]) -> str:
        """Activate controllers; return the reason of a refusal, empty on success."""
        progress.doing(f"activating {', '.join(names)}")
        ok, message = self._client.switch_controllers(
            names, asap=self._options.switch_asap, timeout=self._options.switch_timeout
        )
        if ok:
            return ""
        self._logger.error(message)
        return message or "refused"

    def unload(self, requests: Sequence[SpawnRequest]) -> None:
        """Deactivate and unload the requested controllers; raise SpawnError if that fails."""
        names = [request.name for request in requests if not request.load_only]
        self._logger.info("Deactivating and unloading controllers...")
        active = [
            controller.name
            for controller in self._client.list_controllers()
            if controller.name in names and controller.state == "active"
        ]
        if active:
            if not self._client.switch_controllers((), active)[0]:
                self._fail("Failed to deactivate controller")
            self._logger.info(f"Successfully deactivated controllers : {active}")
        unloaded = [request.name for request in requests]
        for name in unloaded:
            if not self._client.unload_controller(name):
                self._fail("Failed to unload controller")
        self._logger.info(f"Successfully unloaded controllers : {unloaded}")

    def _fail(
        self,
        text: str,
        controller: str = "",
        files: Sequence[str] = (),
        *,
        fatal: bool = True,
        why: str = "",
    ) -> NoReturn:
        """Log and raise an error; a reason ``why``, which is logged already, is reported too.

        The parameter that a logged cause names gets its place in the controller's files.
        """
        if controller and (cause := self._client.cause(controller)):
            text = f"{text}: {cause}"
            named = _PARAMETER.search(cause)
            place = named and parameter_place(controller, self._client.name, files, named[1])
            text += f" ({place})" if place else ""
        reason = f"{text}: {' '.join(why.split())}" if why else text
        if not self._options.keep_going:
            progress.report(progress.FAILED, reason)
        if fatal:
            self._logger.fatal(text)
        else:
            self._logger.error(text)
        raise SpawnError(reason)

    def _paint(self, color: str, text: str) -> str:
        return f"{color}{text}{_END}" if self._colors else text

    def _bold(self, color: str, text: str, name: str) -> str:
        return self._paint(color, text) + self._paint(color + _BOLD, name)


def _colors_wanted() -> bool:
    setting = os.environ.get("RCUTILS_COLORIZED_OUTPUT")
    if setting in ("0", "1"):
        return setting == "1"
    return sys.stderr.isatty() and "NO_COLOR" not in os.environ


def _catch_signals() -> queue.SimpleQueue[int]:
    """Handle SIGINT and SIGTERM from now on by putting their numbers into the returned queue."""
    # Not an event: the wait that the signal interrupts may hold the event's lock.
    received: queue.SimpleQueue[int] = queue.SimpleQueue()

    def receive(number: int, frame: FrameType | None) -> None:
        del frame
        received.put(number)

    signal.signal(signal.SIGINT, receive)
    signal.signal(signal.SIGTERM, receive)
    return received


def _wait_for_signal(received: queue.SimpleQueue[int]) -> None:
    while True:
        with contextlib.suppress(queue.Empty):
            received.get(timeout=1.0)  # waking up now and then lets Windows deliver the signal
            return


def spawner(args: list[str] | None = None) -> int:
    """Run ``controller_manager spawner``: bring controllers up; return the exit status.

    Args:
        args: Command line; None takes ``sys.argv``.
    """
    words = sys.argv[1:] if args is None else args
    given = parse_ros_arguments(words)
    files = [str(file) for file in given.parameters if isinstance(file, Path)]
    options, requests = read_command_line(given.program, files)
    progress.report(progress.STARTING)
    init(args=words, session_mode="client")
    node = Node(f"spawner_{requests[0].name}", start_parameter_services=False)
    process = Spawner(node, options)
    try:
        if options.stay:
            process.stay(requests)
        process.spawn(requests)
        if options.unload_on_kill:
            received = _catch_signals()
            progress.report(progress.READY)
            node.get_logger().info("Waiting until interrupt to unload controllers")
            _wait_for_signal(received)
            node.get_logger().info("KeyboardInterrupt successfully captured!")
            process.unload(requests)
    except ExternalShutdownException:
        return 0 if options.stay else 1
    except SpawnError:
        return 1
    except TeleopctlError as error:
        node.get_logger().fatal(error.message)
        progress.report(progress.FAILED, error.message)
        if error.hint:
            node.get_logger().info(error.hint)
        return 1
    finally:
        node.destroy_node()
        try_shutdown()
    return 0


def unspawner(args: list[str] | None = None) -> int:
    """Run ``controller_manager unspawner``: deactivate and unload controllers; return the status.

    Args:
        args: Command line; None takes ``sys.argv``.
    """
    words = sys.argv[1:] if args is None else args
    parser = argparse.ArgumentParser(
        prog="unspawner", description="Deactivate and unload controllers."
    )
    parser.add_argument("controller_names", nargs="+", metavar="NAME", help="controllers")
    add_manager_option(parser)
    parser.add_argument("--switch-timeout", type=float, default=5.0, metavar="S")
    options = parser.parse_args(parse_ros_arguments(words).program)
    names: list[str] = options.controller_names
    init(args=words, session_mode="client")
    node = Node(f"unspawner_{names[0]}", start_parameter_services=False)
    logger = node.get_logger()
    try:
        client = ControllerManagerClient(node, options.controller_manager)
        client.wait(10.0)
        active = [
            controller.name
            for controller in client.list_controllers()
            if controller.name in names and controller.state == "active"
        ]
        if active and client.switch_controllers((), active, timeout=options.switch_timeout)[0]:
            logger.info("Deactivated controller")
        for name in names:
            if not client.unload_controller(name):
                cause = client.cause(name)
                logger.error("Failed to unload controller" + (f": {cause}" if cause else ""))
                return 1
            logger.info("Unloaded controller")
    except ExternalShutdownException:
        return 1
    except TeleopctlError as error:
        logger.fatal(error.message)
        if error.hint:
            logger.info(error.hint)
        return 1
    finally:
        node.destroy_node()
        try_shutdown()
    return 0
