"""``controller_manager/spawner``: loads, configures and activates controllers."""

from __future__ import annotations

import argparse
import contextlib
import os
import queue
import signal
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType
from typing import NoReturn

from teleopctl import progress
from teleopctl.control import ControllerManagerClient, manager_settings
from teleopctl.errors import TeleopctlError
from teleopctl.node import ExternalShutdownException, Node, init, parse_ros_arguments, try_shutdown

_BLUE, _CYAN, _GREEN, _BOLD, _END = "\033[94m", "\033[96m", "\033[92m", "\033[1m", "\033[0m"


class SpawnError(Exception):
    """A controller could not be brought up; it has been logged why."""


@dataclass
class Request:
    """What is asked for one controller.

    Attributes:
        name: The controller.
        param_files: Parameter files for its node, later ones win.
        load_only: Leave it unconfigured.
        inactive: Leave it inactive.
        ros_args: ROS arguments for its node.
        type: Its type, where no parameter file gives it.
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
        help="the controller's type, where no parameter file gives it, as before Jazzy",
    )
    parser.add_argument(
        "--controller-ros-args",
        action="append",
        default=[],
        metavar="ARGS",
        help="ROS arguments for the controller's node",
    )


def _make_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="spawner",
        description="Load, configure and activate controllers.",
        epilog="--controller NAME [OPTIONS] names one more controller with options of its own.",
    )
    parser.add_argument("controller_names", nargs="*", metavar="NAME", help="controllers")
    parser.add_argument(
        "-c",
        "--controller-manager",
        default="controller_manager",
        metavar="NAME",
        help="name of the controller manager's node",
    )
    parser.add_argument(
        "-n", "--namespace", default="", metavar="NS", help="the controller manager's namespace"
    )
    _controller_options(parser)
    parser.add_argument(
        "-u",
        "--unload-on-kill",
        action="store_true",
        help="stay, and deactivate and unload the controllers when interrupted",
    )
    parser.add_argument(
        "--controller-manager-timeout",
        type=float,
        default=0.0,
        metavar="S",
        help="seconds to wait for the controller manager; 0 waits for ever",
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
        help="switch between two control cycles rather than beside them",
    )
    parser.add_argument(
        "--allow-active",
        action="store_true",
        help="count a controller that is active already as a success",
    )
    return parser


def read_command_line(
    words: Sequence[str], ros_files: Sequence[str] = ()
) -> tuple[argparse.Namespace, list[Request]]:
    """Split a command line into common options and one request for each controller.

    Args:
        words: The program's arguments, without ROS's.
        ros_files: Parameter files of the spawner itself, which are the controllers' as well.
    """
    groups: list[list[str]] = [[]]
    for word in words:
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
        Request(
            name,
            list(options.param_file),
            options.load_only,
            options.inactive,
            list(options.controller_ros_args),
            options.controller_type,
        )
        # Names have no blanks: a launch argument gives several of them as one word.
        for word in options.controller_names
        for name in word.split()
    ]
    for group in groups[1:]:
        given = own.parse_args(group)
        requests.append(
            Request(
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
        # The same file twice counts once; the last mention decides the order.
        own_files = list(dict.fromkeys(reversed(request.param_files)))[::-1]
        request.param_files = list(dict.fromkeys([*own_files, *ros_files]))
    return options, requests


class Spawner:
    """Brings controllers up.

    Args:
        node: The spawner's node.
        options: The common options.
    """

    def __init__(self, node: Node, options: argparse.Namespace) -> None:
        self._node = node
        self._options = options
        self._logger = node.get_logger()
        self._client = ControllerManagerClient(
            node, options.controller_manager, call_timeout=options.service_call_timeout
        )
        self._colors = _colors_wanted()

    def spawn(self, requests: Sequence[Request]) -> None:
        """Bring all controllers up, one after the other.

        Raises:
            SpawnError: One could not be brought up; those behind it have not been tried.
            ControllerManagerUnavailableError: The controller manager does not answer.
        """
        self._client.wait(self._options.controller_manager_timeout, patient=True)
        group: list[str] = []
        for request in requests:
            state = self._load(request)
            if request.load_only:
                continue
            if state == "active" and self._options.allow_active:
                self._logger.info(f"Controller {request.name} is already active")
                continue
            if not self._client.configure_controller(request.name):
                self._fail("Failed to configure controller", request.name, fatal=False)
            if request.inactive:
                continue
            if self._options.activate_as_group:
                group.append(request.name)
            elif refusal := self._switch([request.name]):
                self._fail(
                    f"Failed to activate controller : {request.name}", fatal=False, why=refusal
                )
            else:
                self._logger.info(self._bold(_GREEN, "Configured and activated ", request.name))
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

    def _load(self, request: Request) -> str:
        """Load a controller unless it is; returns its state before."""
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

    def _set_parameters(self, request: Request) -> None:
        try:
            settings = manager_settings(request.name, self._client.name, request.param_files)
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
        """Activate controllers; return why that was refused, or an empty text."""
        ok, message = self._client.switch_controllers(
            names, asap=self._options.switch_asap, timeout=self._options.switch_timeout
        )
        if ok:
            return ""
        self._logger.error(message)
        return message or "refused"

    def unload(self, requests: Sequence[Request]) -> None:
        """Deactivate and unload what was brought up."""
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
        self, text: str, controller: str = "", *, fatal: bool = True, why: str = ""
    ) -> NoReturn:
        """End with an error; ``why`` is in the log already, and told to a launch that waits."""
        if controller and (cause := self._client.cause(controller)):
            text = f"{text}: {cause}"
        progress.tell(progress.FAILED, f"{text}: {' '.join(why.split())}" if why else text)
        if fatal:
            self._logger.fatal(text)
        else:
            self._logger.error(text)
        raise SpawnError(text)

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
    """From now on Ctrl-C and SIGTERM only go into the queue that is returned."""
    # An event would not do: its lock may be held by the very wait that the signal interrupts.
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


def main(args: list[str] | None = None) -> int:
    """Spawn controllers; returns the exit status.

    Args:
        args: Command line; None takes the process's.
    """
    words = sys.argv[1:] if args is None else args
    given = parse_ros_arguments(words)
    files = [str(file) for file in given.parameters if isinstance(file, Path)]
    options, requests = read_command_line(given.program, files)
    init(args=words, session_mode="client")
    node = Node(f"spawner_{requests[0].name}", start_parameter_services=False)
    spawner = Spawner(node, options)
    try:
        spawner.spawn(requests)
        if options.unload_on_kill:
            received = _catch_signals()
            node.get_logger().info("Waiting until interrupt to unload controllers")
            _wait_for_signal(received)
            node.get_logger().info("KeyboardInterrupt successfully captured!")
            spawner.unload(requests)
    except (SpawnError, ExternalShutdownException):
        return 1
    except TeleopctlError as error:
        node.get_logger().fatal(error.message)
        progress.tell(progress.FAILED, error.message)
        if error.hint:
            node.get_logger().info(error.hint)
        return 1
    finally:
        node.destroy_node()
        try_shutdown()
    return 0


if __name__ == "__main__":
    sys.exit(main())
