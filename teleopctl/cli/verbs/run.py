"""``teleopctl run``."""

import os
import sys
from collections.abc import Sequence

from teleopctl.base.typed import TYPE_CHECKING, Annotated
from teleopctl.cli import console
from teleopctl.cli.options import (
    LoggerServices,
    StallTimeout,
    UpTimeout,
    turn_on_logger_services,
)
from teleopctl.cli.verb import Argument, Option, Verb
from teleopctl.errors import NotFoundError, SystemFailureError, UsageError, did_you_mean

if TYPE_CHECKING:
    from teleopctl.base.background import ProcessRecord
    from teleopctl.base.start_timeouts import StartTimeouts
    from teleopctl.packages import PackageProgram


def replace_this_process(command: list[str]) -> int:
    """Replace this process by a command; on Windows run it and return its exit status.

    Raises:
        SystemFailureError: The command cannot be started.
    """
    sys.stdout.flush()
    try:
        if os.name == "nt":
            return _wait_for(command)
        os.execvp(command[0], command)  # noqa: S606 -- the user's own command
    except OSError as error:
        raise SystemFailureError(f"Cannot run {command[0]}: {error.strerror}") from error


def _wait_for(command: list[str]) -> int:
    """Run a command and return its status; on Windows, ``exec`` would end this process at once."""
    import signal
    import subprocess

    # Ctrl-C reaches both processes, and only the command handles it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    return subprocess.run(command, check=False).returncode


VERB = Verb(
    f"{__name__}:run",
    "Start one node: a program of a package, or a Python file by its path.",
    passes_on=True,
    examples=(
        "teleopctl run teleop_py_pkg simple_publisher",
        "teleopctl run ./my_node.py --ros-args -r chatter:=/talk -p rate:=5",
    ),
)


def run(
    words: Annotated[
        list[str],
        Argument(
            metavar="[PACKAGE] EXECUTABLE|FILE [ARGS]...",
            help="Program, and the arguments passed to it, such as --ros-args -p NAME:=VALUE.",
            complete="programs",
        ),
    ],
    prefix: Annotated[str | None, Option("--prefix", help="Prefix of the command line.")] = None,
    detach: Annotated[bool, Option("--detach", "-d", help="Return once the node is up.")] = False,
    timeout: UpTimeout = None,
    stall_timeout: StallTimeout = None,
    logger_services: LoggerServices = False,
) -> int:
    """Run a program of a package or a Python file; with ``detach`` in the background.

    The package can be omitted if the program's name is unique. Python files can import rclpy and
    message packages.
    """
    from teleopctl.cli.waiting import start_timeouts
    from teleopctl.wire import ensure_router

    timeouts = start_timeouts(timeout, stall_timeout, detach=detach)
    if logger_services:
        turn_on_logger_services()
    executable, arguments = find_program(words)
    ensure_router()
    if not detach and prefix is None:
        from teleopctl.nodes.execute import execute

        return execute(executable, arguments)
    command = [*_words(prefix or ""), *command_of(executable, arguments)]
    if detach:
        return _run_in_background(executable, command, timeouts)

    return replace_this_process(command)


def find_program(words: Sequence[str]) -> "tuple[PackageProgram, list[str]]":
    """Find the program that a command line names; return it and the remaining arguments.

    Raises:
        TeleopctlError: The package or program does not exist.
    """
    from teleopctl import packages

    first, *rest = words
    if packages.is_path(first):
        return packages.find_executable(None, first), rest
    try:
        offered = packages.find_package(first).executables
    except NotFoundError as unknown_package:
        try:
            return packages.find_executable(None, first), rest
        except NotFoundError:
            unknown_package.hint = _suggestion(first) or unknown_package.hint
            raise unknown_package from None
    if rest and not rest[0].startswith("-"):
        return packages.find_executable(first, rest[0]), rest[1:]
    # Only the package is named: run its program of the same name, or its only program.
    if first in offered or len(offered) != 1:
        return packages.find_executable(first, first), rest
    return next(iter(offered.values())), rest


def _suggestion(name: str) -> str | None:
    from teleopctl import packages

    everything = packages.list_packages()
    programs = {program for package in everything for program in package.executables}
    return did_you_mean(name, {package.name for package in everything} | programs)


def _words(prefix: str) -> list[str]:
    import shlex

    try:
        return shlex.split(prefix)
    except ValueError as error:
        raise UsageError(f"--prefix {prefix}: {error}") from error


def command_of(executable: "PackageProgram", arguments: Sequence[str]) -> list[str]:
    """Return the command line of a process that runs a program of a package."""
    program = [str(executable.file)]
    if executable.file is None:
        program = [executable.package, executable.name]
    return [sys.executable, "-P", "-m", "teleopctl.nodes", *program, *arguments]


def _run_in_background(
    executable: "PackageProgram", command: list[str], timeouts: "StartTimeouts"
) -> int:
    from teleopctl.base import progress
    from teleopctl.base.token_file import Address

    record, nodes = start_in_background(executable.name, command, timeouts)
    if nodes:
        console.out(f"{record.name} is up: {', '.join(nodes)} [pid {record.pid}]")
        said = progress.read(record.log_file)
        if said is not None and said.state == progress.READY and said.detail:
            console.out(Address.parse(said.detail).announcement)
    else:
        console.out(f"{record.name} has finished")
    return 0


def start_in_background(
    executable: str, command: list[str], timeouts: "StartTimeouts"
) -> "tuple[ProcessRecord, list[str]]":
    """Start a program in the background, and wait for its node.

    Args:
        executable: Name of the program, from which the process's name is made.
        command: Command line of the process.
        timeouts: Longest waits for the node.

    Returns:
        Record of the process, and the names of its nodes; none if it has finished.

    Raises:
        TeleopctlError: The program failed, or its node is not up within the timeouts.
    """
    from functools import partial

    from teleopctl.base import background
    from teleopctl.launch import NewNodes, started_in_background, unused_launch_name, wait_for_node

    with NewNodes() as new_nodes:
        name = unused_launch_name(executable.removesuffix(".py"))
        ours = command[0] == sys.executable
        start = partial(background.start, name, command, kind="node", takes_interrupts=ours)
        with started_in_background(start) as record:
            nodes = wait_for_node(new_nodes, record, timeouts, console.note)
    return record, list(nodes)
