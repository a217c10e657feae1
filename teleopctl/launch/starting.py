"""Launch of a file for the command line: evaluate, then run here or in the background."""

from __future__ import annotations

import contextlib
import os
import sys
from contextlib import AbstractContextManager
from datetime import datetime
from functools import partial
from pathlib import Path

from teleopctl.base import background, interrupts, progress
from teleopctl.base.background import ProcessRecord
from teleopctl.base.start_timeouts import StartTimeouts
from teleopctl.base.typed import TYPE_CHECKING, Callable, Iterator
from teleopctl.errors import LaunchError, TeleopctlError
from teleopctl.launch.evaluation.context import LaunchContext
from teleopctl.launch.evaluation.evaluation import Evaluation, evaluate, shutdown_before_start
from teleopctl.launch.execution import status
from teleopctl.launch.execution.running import (
    died,
    forget_died,
    how_to_stop,
    started_in_background,
    stop_running,
)
from teleopctl.launch.execution.standby import StandbyProcess, standby_simulator
from teleopctl.launch.execution.status import ProcessStatus
from teleopctl.launch.frontends import read_launch_file
from teleopctl.launch.model.plan import LaunchPlan
from teleopctl.launch.model.request import LaunchRequest, load_request
from teleopctl.launch.recording import with_recorder

if TYPE_CHECKING:
    from teleopctl.launch.execution.supervisor import Supervisor

_log_directory: Path | None = None

# Ends what `take_temporary_files` begins; None once it has begun, and where no launch runs.
_temporary_files: contextlib.ExitStack | None = None


def current_log_directory() -> Path | None:
    """Return the log folder of the launch that this process evaluated last; None before that."""
    return _log_directory


def new_log_directory() -> Path:
    """Return the path of a log folder to create, named after time, host and process id."""
    stamp = datetime.now().strftime("%Y-%m-%d-%H-%M-%S-%f")
    return background.logs_dir() / f"{stamp}-{_host_name()}-{os.getpid()}"


def _host_name() -> str:
    if sys.platform != "win32":
        return os.uname().nodename
    import socket  # takes a millisecond to import

    return socket.gethostname()


def evaluate_request(
    request: LaunchRequest, log_directory: Path, *, is_shown: bool = False
) -> tuple[LaunchPlan, Evaluation]:
    """Return a launch request's plan and the evaluation for later events; nothing is started.

    Args:
        request: Launch file with its arguments and options.
        log_directory: Log folder of the launch.
        is_shown: Whether the plan is only shown, so that a shutdown before the start is no error.

    Raises:
        TeleopctlError: The file cannot be read, is no valid launch file, or cannot be evaluated.
    """
    global _log_directory
    _log_directory = log_directory
    file = Path(request.file)
    with _files_read(request) as files:
        plan, evaluation = evaluate(
            read_launch_file(file),
            request.arguments,
            log_directory,
            request,
            is_shown=True,
        )
    evaluation.files_read = frozenset(files)
    names = _names_that_run(plan, evaluation.context)
    if plan.start.shutdown is not None and not is_shown:
        hint = f"End it {how_to_stop(names)}." if names else None
        raise shutdown_before_start(plan.start.shutdown, hint)
    if names:
        # They are started, as in ROS 2: the running node may be about to end. But a second
        # robot_state_publisher, for example, publishes a second pose of the robot.
        plan.warnings.append(
            f"Nodes of the same names run already: {', '.join(names)}. Subscribers of their "
            f"topics receive messages of both. End the others {how_to_stop(names)}"
        )
    if request.record_into is not None:
        plan = with_recorder(plan, Path(request.record_into), file, request.arguments)
    return plan, evaluation


def _names_that_run(plan: LaunchPlan, context: LaunchContext) -> list[str]:
    """Return the sorted names of nodes in a plan that already run."""
    return sorted(
        {
            process.node_name
            for process in plan.start.processes
            if process.node_name is not None
            and not process.ends_by_itself
            and context.node_is_running(process.node_name)
        }
    )


def _files_read(request: LaunchRequest) -> AbstractContextManager[set[Path]]:
    if not request.watch:
        return contextlib.nullcontext(set())
    from teleopctl.launch.watch import files_read

    return files_read()


@contextlib.contextmanager
def _own_temporary_files() -> Iterator[None]:
    """Remove the temporary files of Python launch files at the end of the launch.

    Many write parameter files for their nodes to the temporary folder, and never remove them.
    """
    global _temporary_files
    with contextlib.ExitStack() as stack:
        _temporary_files = stack
        try:
            yield
        finally:
            _temporary_files = None


def take_temporary_files() -> None:
    """Let tempfile make its files in a folder of the launch that runs here, if one does.

    The folder is made at the first call, and removed at the end of the launch.

    Raises:
        SystemFailureError: The folder cannot be made.
    """
    global _temporary_files
    if _temporary_files is None:
        return
    # Launch files in YAML and XML do without it, which takes 4 ms.
    import tempfile

    _temporary_files.callback(setattr, tempfile, "tempdir", tempfile.tempdir)
    tempfile.tempdir = str(_temporary_files.enter_context(background.temporary_folder()))
    _temporary_files = None


@_own_temporary_files()
def run_here(
    request: LaunchRequest,
    standby: StandbyProcess | None = None,
    *,
    on_terminal: bool = False,
    coloured: bool = False,
    verbose: bool = False,
) -> int:
    """Run a launch in the foreground until all processes have ended; return the exit status.

    Args:
        request: Launch file with its arguments and options.
        standby: Process that waits for its arguments, for the first process that it fits.
        on_terminal: Whether the output goes to a terminal; the launch then logs when all processes
            are up.
        coloured: Whether levels and process names are coloured on a terminal.
        verbose: Whether a terminal gets all output; otherwise only warnings and errors of nodes
            from teleopctl's own launch files, unless these choose the output.

    Raises:
        TeleopctlError: The file cannot be evaluated; no process was started.
    """
    from teleopctl.base.output import outlive_output
    from teleopctl.launch.execution.supervisor import Supervisor

    plan, evaluation = evaluate_request(request, new_log_directory())
    prepare(plan)
    outlive_output()
    with _findable(plan.log_directory, request):
        supervisor = Supervisor(
            plan,
            evaluation,
            coloured=on_terminal and coloured,
            is_terse=on_terminal and not (verbose or request.debug),
            debug=request.debug,
            log_name=request.log_name,
            standby=standby,
        )
        if not on_terminal:
            return _run(supervisor, evaluation, request)
        return _run_on_terminal(supervisor, evaluation, request)


@_own_temporary_files()
def run_in_background(request_file: Path) -> int:
    """Run the launch request in a file until all processes have ended; return the exit status.

    Files in the request's folder report warnings, or the error of the evaluation, to the command
    that waits for the launch.
    """
    folder = request_file.parent
    with contextlib.ExitStack() as stack:
        try:
            request = load_request(request_file)
            progress.report(progress.STARTING, f"evaluating {Path(request.file).name}")
            standby = stack.enter_context(standby_simulator(Path(request.file)))
            from teleopctl.launch.execution.supervisor import Supervisor

            plan, evaluation = evaluate_request(request, folder)
            _write(folder, plan.write_files)
            _call_latest(folder)
        except TeleopctlError as error:
            status.write_refusal(folder, error)
            raise
        status.write_warnings(folder, plan.warnings)
        supervisor = Supervisor(
            plan, evaluation, in_background=True, debug=request.debug, standby=standby
        )
        return _run(supervisor, evaluation, request)


def _run(supervisor: Supervisor, evaluation: Evaluation, request: LaunchRequest) -> int:
    with _watched(supervisor, evaluation, request):
        interrupts.raise_if_interrupted()
        status = supervisor.run()
    return status if request.exit_status else supervisor.ros2_exit_status


@contextlib.contextmanager
def _watched(
    supervisor: Supervisor, evaluation: Evaluation, request: LaunchRequest
) -> Iterator[None]:
    if not request.watch:
        yield
        return
    from teleopctl.launch.watch import Watch

    watch = Watch(request, evaluation, supervisor.restarts)
    supervisor.restarts.watch(watch)
    try:
        yield
    finally:
        watch.close()


def _run_on_terminal(supervisor: Supervisor, evaluation: Evaluation, request: LaunchRequest) -> int:
    from teleopctl.launch.execution.readiness import NewNodes, report_when_up

    with NewNodes() as new_nodes, report_when_up(new_nodes, supervisor):
        return _run(supervisor, evaluation, request)


def start_in_background(
    request: LaunchRequest,
    name: str,
    on_up: Callable[[ProcessStatus, str | None], None],
    warn: Callable[[str], None],
    timeouts: StartTimeouts,
    show: Callable[[str], None],
    *,
    ends_on_failure: bool = False,
) -> ProcessRecord:
    """Start a launch in a background process, and return its record once all is up.

    Args:
        request: Launch file with its arguments and options.
        name: Name of the launch; a number is appended if a running launch has that name.
        on_up: Called for each process once it is up, with its status and node name (or None).
        warn: Called with each warning of the evaluation.
        timeouts: Maximum times of the wait, in total and without progress.
        show: Called now and then with a line about the processes that are still starting.
        ends_on_failure: Whether the launch is ended if it does not come up; otherwise the rest of
            it runs on.

    Raises:
        TeleopctlError: The file cannot be evaluated, or a process died or made no progress.
    """
    from teleopctl.launch.execution.readiness import NewNodes, wait_for_launch

    _prepare()
    request_file = new_log_directory() / status.REQUEST_FILE
    _write(request_file.parent, partial(request.save, request_file))
    with NewNodes() as new_nodes:
        start = partial(
            background.start,
            unused_launch_name(name),
            [sys.executable, "-P", "-m", "teleopctl.launch", str(request_file)],
            kind=background.LAUNCH,
            takes_interrupts=True,
        )
        with started_in_background(start) as record:
            try:
                wait_for_launch(new_nodes, record, on_up, warn, timeouts, show)
            except TeleopctlError as error:
                if not ends_on_failure or not background.is_alive(record):
                    raise
                stop_running(record)
                hint = f"All of it has been ended; see `teleopctl logs {record.name}`."
                raise LaunchError(error.message, hint=hint) from error
    return record


def launch_name(file: Path) -> str:
    """Return the name for a launch of a file: the file's name without its endings."""
    return file.stem.removesuffix(".launch")


def unused_launch_name(name: str) -> str:
    """Return an unused launch name, numbered if needed; remove records of dead namesakes.

    Records of that name are removed if their processes have died.
    """
    here = (*background.records(), *background.foreground_launches())
    taken = {record.name for record in here}
    for entry in died():
        if name == (entry.launch or entry.record).name:
            forget_died(entry)
    if name not in taken:
        return name
    return next(
        candidate
        for number in range(2, len(taken) + 3)
        if (candidate := f"{name}-{number}") not in taken
    )


@contextlib.contextmanager
def _findable(log_directory: Path, request: LaunchRequest) -> Iterator[None]:
    """While the block runs, keep the record of a launch in the foreground.

    With the record, ``logs`` finds the launch; if the launch is killed, ``ps`` and ``stop`` find
    its remaining processes.
    """
    record = None
    # Without a record, only those commands do not work.
    with contextlib.suppress(TeleopctlError):
        record = background.record_this_process(
            unused_launch_name(launch_name(Path(request.file))),
            ["teleopctl", "launch", str(log_directory / status.REQUEST_FILE)],
            log_directory / f"{request.log_name}.log",
            kind=background.FOREGROUND_LAUNCH,
        )
    try:
        yield
    finally:
        if record is not None:
            record.unlink(missing_ok=True)


def prepare(plan: LaunchPlan) -> None:
    """Start the router if needed, and write the log folder and parameter files of a plan.

    Raises:
        TeleopctlError: The router cannot be started, or a file cannot be written.
    """
    _prepare()
    _write(plan.log_directory, plan.write_files)
    _call_latest(plan.log_directory)


def _prepare() -> None:
    from teleopctl.wire import domain_id, ensure_router

    domain_id()  # raises here, once, instead of in each process
    ensure_router()


def _write(log_directory: Path, write: Callable[[], None]) -> None:
    try:
        log_directory.mkdir(parents=True, exist_ok=True)
        write()
    except OSError as error:
        raise LaunchError(
            f"Cannot write to the log folder {log_directory}: {error.strerror}",
            hint="Set ROS_LOG_DIR to a folder that you may write to.",
        ) from error


def _call_latest(log_directory: Path) -> None:
    """Make ``latest`` a link to the folder of the newest launch, as in ROS 2, if possible."""
    link, new = (log_directory.with_name(name) for name in ("latest", f"latest.{os.getpid()}"))
    if link.exists() and not link.is_symlink():
        return
    # Windows restricts links to some users; a launch at the same time may interfere.
    with contextlib.suppress(OSError):
        new.symlink_to(log_directory, target_is_directory=True)
        new.replace(link)
