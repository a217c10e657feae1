"""``teleopctl launch``: many nodes from a launch file."""

import contextlib
import os
import sys
from pathlib import Path

from teleopctl.base.typed import TYPE_CHECKING, Annotated
from teleopctl.cli import console
from teleopctl.cli.options import (
    LoggerServices,
    StallTimeout,
    UpTimeout,
    turn_on_logger_services,
)
from teleopctl.cli.verb import Argument, Option, Verb
from teleopctl.cli.waiting import start_timeouts
from teleopctl.errors import TeleopctlError, UsageError

if TYPE_CHECKING:
    from teleopctl.base.start_timeouts import StartTimeouts
    from teleopctl.launch import DryRun, FollowUp, LaunchRequest, ProcessStatus

VERB = Verb(
    f"{__name__}:launch",
    "Start a launch file, show its output, and stop it on Ctrl-C.",
    examples=(
        "teleopctl launch sim.yaml camera:=false",
        "teleopctl launch --detach display.yaml model:=my_robot.urdf.xacro",
        "teleopctl launch sim.yaml record:=true",
    ),
)


def launch(
    words: Annotated[
        list[str],
        Argument(
            metavar="[PACKAGE] FILE [NAME:=VALUE]...",
            help="A launch file, by path, of a package, or a built-in one; its arguments.",
            complete="launch_words",
        ),
    ],
    show_args: Annotated[
        bool, Option("--show-args", "-s", "--show-arguments", help="List the file's arguments.")
    ] = False,
    print_plan: Annotated[
        bool,
        Option("--print", "-p", "--print-description", help="Print what would be started."),
    ] = False,
    noninteractive: Annotated[
        bool,
        Option(
            "--noninteractive", "-n", help="Accepted for compatibility with ROS 2: always on here."
        ),
    ] = False,
    show_all: Annotated[
        bool,
        Option(
            "--show-all-subprocesses-output",
            "-a",
            help="Show the standard output of every process.",
        ),
    ] = False,
    verbose: Annotated[
        bool,
        Option(
            "--verbose",
            help="Show all that built-in launch files' nodes log; else a terminal gets warnings.",
        ),
    ] = False,
    launch_prefix: Annotated[
        str | None,
        Option("--launch-prefix", help="Prefix of each command line."),
    ] = None,
    launch_prefix_filter: Annotated[
        str | None,
        Option(
            "--launch-prefix-filter",
            help="Use --launch-prefix only for programs that match this pattern.",
        ),
    ] = None,
    log_file_name: Annotated[
        str,
        Option(
            "--log-file-name",
            "-f",
            help="File name of the log of all output, without .log.",
            metavar="NAME",
        ),
    ] = "launch",
    skip_missing: Annotated[
        bool,
        Option("--skip-missing", help="Skip packages and programs that cannot be found."),
    ] = False,
    debug: Annotated[
        bool, Option("--debug", help="Print debug messages of the launch; ROS 2's -d.")
    ] = False,
    watch: Annotated[
        bool,
        Option(
            "--watch",
            help="Restart a node when its source or its robot description is saved.",
        ),
    ] = False,
    exit_status: Annotated[
        bool,
        Option(
            "--exit-status",
            help="End with 1 when a process died and 130 after Ctrl-C, where ROS 2 ends with 0.",
        ),
    ] = False,
    detach: Annotated[bool, Option("--detach", "-d", help="Return once everything is up.")] = False,
    timeout: UpTimeout = None,
    stall_timeout: StallTimeout = None,
    open_page: Annotated[
        bool, Option("--open", help="Open the page of the robot in the browser.")
    ] = False,
    safe: Annotated[
        bool,
        Option(
            "--safe", help="Refuse robot descriptions whose expressions are more than arithmetic."
        ),
    ] = False,
    logger_services: LoggerServices = False,
) -> int:
    """Start a launch file, show its output, and stop it on Ctrl-C."""
    del noninteractive
    if safe:
        # For this process and its child processes, which may read descriptions themselves.
        os.environ["TELEOPCTL_SAFE"] = "1"
    if logger_services:
        turn_on_logger_services()
    if open_page:
        os.environ["TELEOPCTL_OPEN"] = "1"
    from teleopctl.compat import activation
    from teleopctl.launch import find_launch_file, standby_simulator
    from teleopctl.packages import apply_source_hooks

    if launch_prefix_filter is not None and launch_prefix is None:
        raise UsageError("--launch-prefix must be specified if --launch-prefix-filter is provided")
    if not log_file_name or Path(log_file_name).name != log_file_name:
        raise UsageError(f"--log-file-name is a name, not a path: '{log_file_name}'")
    timeouts = start_timeouts(timeout, stall_timeout, detach=detach)
    package, name, arguments = parse_launch_words(words)
    # The launch file may read variables of a sourced ROS 2, and its commands run with them.
    activation.activate_children()
    file = find_launch_file(package, name)
    apply_source_hooks()
    if show_args:
        from teleopctl.launch import describe_arguments

        console.out_text("\n".join(describe_arguments(file, arguments)))
        return 0
    runs_here = not (print_plan or detach)
    # Before the imports that the evaluation needs.
    with standby_simulator(file) if runs_here else contextlib.nullcontext() as standby:
        from teleopctl.launch import (
            LaunchRequest,
            bag_folder,
            launch_name,
            run_here,
            undeclared_argument_warnings,
        )

        folder = bag_folder(file, arguments)
        request = LaunchRequest(
            file=str(file),
            arguments=arguments,
            # In the background all output goes into one log, which has to be complete.
            show_all_output=show_all or detach,
            prefix=launch_prefix,
            prefix_filter=launch_prefix_filter,
            skip_missing=skip_missing,
            debug=debug,
            exit_status=exit_status,
            watch=watch,
            record_into=None if folder is None else str(folder),
            log_name=log_file_name,
        )
        try:
            if print_plan:
                _print(request)
                return 0
            if detach:
                console.note_once(
                    "launch-d",
                    "-d means --detach here; ROS 2's -d, for debug messages, is --debug. "
                    "(Printed once.)",
                )
                _start(request, launch_name(file), timeouts)
                return 0
            return run_here(
                request,
                standby,
                on_terminal=sys.stdout.isatty(),
                coloured=console.colour_enabled(sys.stdout),
                verbose=verbose or show_all,
            )
        except TeleopctlError:
            for warning in undeclared_argument_warnings(file, arguments):
                console.warn(warning)
            raise


def _start(request: "LaunchRequest", name: str, timeouts: "StartTimeouts") -> None:
    from teleopctl.launch import addresses, start_in_background

    running: list[ProcessStatus] = []

    def report(process: "ProcessStatus", node: str | None) -> None:
        if process.state == "running":
            running.append(process)
        _report(process, node)

    record = start_in_background(request, name, report, console.warn, timeouts, console.note)
    if not running:
        console.out(f"{record.name} has finished")
        return
    console.out(f"{record.name} is up; see `teleopctl logs -f {record.name}`")
    console.out(f"To end it: teleopctl stop {record.name}")
    if request.record_into is not None:
        console.out(f"It is recorded into {request.record_into}")
    for address in addresses(running):
        console.out(address.announcement)


def parse_launch_words(words: list[str]) -> tuple[str | None, str, dict[str, str]]:
    """Parse the words of a launch command into package or None, file and arguments.

    Raises:
        UsageError: The file is missing, or an argument is not ``name:=value``.
    """
    from teleopctl.launch import is_launch_file

    names: list[str] = []
    arguments: dict[str, str] = {}
    for word in words:
        name, separator, value = word.partition(":=")
        if separator and name:
            arguments[name] = value
        elif arguments or separator or len(names) == 2 or any(map(is_launch_file, names)):
            raise UsageError(
                f"malformed launch argument '{word}', expected format '<name>:=<value>'",
            )
        else:
            names.append(word)
    if not names:
        raise UsageError("Which launch file?", hint="teleopctl launch FILE")
    return (names[0] if len(names) == 2 else None), names[-1], arguments


def _report(process: "ProcessStatus", node: str | None) -> None:
    from pathlib import Path

    from teleopctl.base import progress

    said = progress.read(Path(process.log_file))
    for remark in said.remarks if said is not None else ():
        console.warn(f"{process.name}: {remark}")
    if process.state == "finished":
        console.out(f"{process.name} has finished")
    else:
        name = f": {node}" if node else ""
        console.out(f"{process.name} is up{name} [pid {process.pid}]")
    console.flush()


def _print(request: "LaunchRequest") -> None:
    from teleopctl.launch import evaluate_request, new_log_directory

    plan, evaluation = evaluate_request(request, new_log_directory(), is_shown=True)
    for warning in plan.warnings:
        console.warn(warning)
    _print_further(plan.start)
    _print_dry_run(tuple(evaluation.dry_run(plan.start)))


def _print_dry_run(dry_run: "tuple[DryRun, ...]", indent: str = "") -> None:
    for each in dry_run:
        console.out(f"{indent}{each.when}:")
        inner = f"{indent}  "
        _print_further(each.follow_up, inner)
        if each.error is not None:
            console.out(f"{inner}not known before: {each.error.message}")
        _print_dry_run(each.then, inner)


def _print_further(further: "FollowUp", indent: str = "") -> None:
    from teleopctl.launch import CallSequence, command_text

    for _, _, message in further.messages:
        console.out(f"{indent}{message}")
    for process in further.processes:
        console.out(f"{indent}{process.name}:")
        command = process.command[0] if process.shell else command_text(process.command)
        console.out_text(f"{indent}  {command}")
        for variable, value in process.environment.items():
            console.out_text(f"{indent}  env {variable}={value or ''}")
    for work in further.works:
        if isinstance(work, CallSequence):
            console.out_lines(f"{indent}{line}" for line in work.describe())
    for path, content in further.files.items():
        console.out(f"{indent}{path}:")
        console.out_lines(f"{indent}  {line}" for line in content.splitlines())
    if further.shutdown is not None:
        console.out(f"{indent}the launch ends: {further.shutdown}")
