"""A launch from the command's point of view: evaluate, then run it here or in the background."""

from __future__ import annotations

import contextlib
import os
import socket
import sys
from collections.abc import Callable, Iterator, Mapping
from datetime import datetime
from pathlib import Path

from teleopctl import background
from teleopctl.background import ProcessRecord
from teleopctl.errors import LaunchError, TeleopctlError
from teleopctl.launch.evaluation.evaluation import evaluate
from teleopctl.launch.execution.running import died, forget_died, stopped_by_ctrl_c
from teleopctl.launch.execution.status import PLAN_FILE, ProcessStatus
from teleopctl.launch.frontends import read_launch_file
from teleopctl.launch.model.plan import LaunchPlan


def new_log_directory() -> Path:
    """Return the folder of a launch that starts now: date, host and process, as in ROS 2."""
    stamp = datetime.now().strftime("%Y-%m-%d-%H-%M-%S-%f")
    return background.logs_dir() / f"{stamp}-{socket.gethostname()}-{os.getpid()}"


def make_plan(
    file: Path,
    arguments: Mapping[str, str],
    *,
    show_all_output: bool = False,
    prefix: str | None = None,
) -> LaunchPlan:
    """Read and evaluate a launch file; nothing is started or written.

    Raises:
        TeleopctlError: The file cannot be read, does not follow the vocabulary, or something in it
            cannot be evaluated.
    """
    return evaluate(
        read_launch_file(file),
        arguments,
        new_log_directory(),
        show_all_output=show_all_output,
        prefix=prefix,
    )


def run_here(plan: LaunchPlan, *, on_terminal: bool = False, coloured: bool = False) -> int:
    """Carry out a plan in the foreground and return the exit status.

    Args:
        plan: What to start.
        on_terminal: Whether a person reads the output: lines are shorter than ROS 2's, and at the
            end of the start it is said what is up.
        coloured: Whether levels are coloured there.
    """
    from teleopctl.launch.execution.supervisor import Supervisor
    from teleopctl.output import outlive_output

    _prepare(plan)
    outlive_output()
    with _findable_if_killed(plan):
        if not on_terminal:
            return Supervisor(plan).run()
        return _run_on_terminal(plan, coloured=coloured)


def _run_on_terminal(plan: LaunchPlan, *, coloured: bool) -> int:
    from teleopctl.launch.execution.readiness import NewNodes, tell_when_up
    from teleopctl.launch.execution.supervisor import Supervisor
    from teleopctl.launch.execution.terminal import Terminal

    terminal = Terminal([process.name for process in plan.processes], coloured=coloured)
    supervisor = Supervisor(plan, terminal=terminal)
    with NewNodes() as new_nodes, tell_when_up(new_nodes, supervisor.statuses, supervisor.tell):
        return supervisor.run()


def start_in_background(
    plan: LaunchPlan, name: str, on_up: Callable[[ProcessStatus, str | None], None]
) -> ProcessRecord:
    """Carry out a plan in a process of its own, and return once everything is up.

    Args:
        plan: What to start.
        name: What the launch is to be called; a number is added where the name is taken.
        on_up: Called for each process once it is up.

    Raises:
        TeleopctlError: A process died, or did not come up in time.
    """
    from teleopctl.launch.execution.readiness import NewNodes, wait_for_launch

    _prepare(plan)
    plan_file = plan.log_directory / PLAN_FILE
    plan_file.write_text(plan.dump(), encoding="utf-8")
    with NewNodes() as new_nodes:
        record = background.start(
            free_name(name),
            [sys.executable, "-P", "-m", "teleopctl.launch", str(plan_file)],
            kind=background.LAUNCH,
        )
        with stopped_by_ctrl_c(record):
            wait_for_launch(new_nodes, record, on_up)
    return record


def free_name(name: str) -> str:
    """Return a name that no background process has: the given one, or one with a number.

    What had that name and has died is forgotten.
    """
    taken = {record.name for record in background.records()}
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
def _findable_if_killed(plan: LaunchPlan) -> Iterator[None]:
    """While the block runs, keep the record by which ``ps`` and ``stop`` find what it leaves."""
    record = None
    # Who cannot have one is only not found.
    with contextlib.suppress(TeleopctlError):
        record = background.record_this_process(
            "launch",
            ["teleopctl", "launch", str(plan.log_directory / PLAN_FILE)],
            plan.log_directory / "launch.log",
            kind=background.FOREGROUND_LAUNCH,
        )
    try:
        yield
    finally:
        if record is not None:
            record.unlink(missing_ok=True)


def _prepare(plan: LaunchPlan) -> None:
    from teleopctl.wire import domain_id, ensure_router

    domain_id()  # a faulty one would be reported by each of the processes
    ensure_router()
    try:
        plan.write_files()
    except OSError as error:
        raise LaunchError(
            f"Cannot write to the log folder {plan.log_directory}: {error.strerror}",
            hint="Set ROS_LOG_DIR to a folder that you may write to.",
        ) from error
