"""The command line of ``spawner``: common options, and one request for each controller."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, field


@dataclass
class SpawnRequest:
    """Options of the spawner for one controller.

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
    staying = parser.add_mutually_exclusive_group()
    staying.add_argument(
        "--stay",
        action="store_true",
        help="stay, and bring the controllers up in each controller manager that takes the place "
        "of one that has ended",
    )
    staying.add_argument(
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
    parser.add_argument(
        "--keep-going",
        action=argparse.BooleanOptionalAction,
        default=False,
        help="bring up what can be, and fail at the end; what others claim stays inactive",
    )
    return parser


def read_command_line(
    words: Sequence[str], ros_files: Sequence[str] = ()
) -> tuple[argparse.Namespace, list[SpawnRequest]]:
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
        SpawnRequest(
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
        # The same file twice counts once; the last mention decides the order.
        own_files = list(dict.fromkeys(reversed(request.param_files)))[::-1]
        request.param_files = list(dict.fromkeys([*own_files, *ros_files]))
    return options, requests
