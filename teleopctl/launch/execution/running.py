"""Nodes, launches and processes of launches in the background: list, find and stop them."""

from __future__ import annotations

import time
from contextlib import contextmanager

from teleopctl.base import background, interrupts, progress
from teleopctl.base.background import ProcessRecord
from teleopctl.base.typed import (
    TYPE_CHECKING,
    Callable,
    Collection,
    Iterable,
    Iterator,
    NamedTuple,
)
from teleopctl.errors import NotFoundError, did_you_mean
from teleopctl.launch.execution import status
from teleopctl.launch.execution.status import describe_exit

if TYPE_CHECKING:
    from pathlib import Path

# Seconds before each harder signal.
_PATIENCE_S = 5.0
# A launch waits 5 s before it sends SIGTERM to its processes, and 5 s more before SIGKILL.
_LAUNCH_PATIENCE_S = 12.0


class Running(NamedTuple):
    """A process in the background or of a launch, with its record and state.

    Attributes:
        record: Name, pid, start time, command and log file of the process.
        launch: Record of the launch that started the process, or None.
        node_name: Full name of the process's node if a launch file gives the name, or None.
        is_alive: Whether the process runs; a launch keeps the entries of processes that have ended.
        ending: How and when the process ended, such as ``exited 1, 3 s ago``; only from `died`.
        is_death_shown: Whether the command that started the process has shown why it died.
    """

    record: ProcessRecord
    launch: ProcessRecord | None = None
    node_name: str | None = None
    is_alive: bool = True
    ending: str = ""
    is_death_shown: bool = False

    @property
    def qualified_name(self) -> str:
        """Name of the process, after the launch's name and a slash if a launch started it."""
        return f"{self.launch.name}/{self.record.name}" if self.launch else self.record.name


def running(
    folder: Path | None = None, *, include_ended: bool = False, include_foreground: bool = False
) -> list[Running]:
    """Return background nodes and launches, each launch followed by its running processes.

    Args:
        folder: Runtime folder with the records; by default the user's.
        include_ended: Whether to include ended processes of running launches.
        include_foreground: Whether to include launches that run in terminals, after the others.
    """
    found: list[Running] = []
    records = background.records(folder)
    if include_foreground:
        records += background.foreground_launches(folder)
    for record in records:
        found.append(Running(record))
        if record.kind in background.LAUNCHES:
            found.extend(
                Running(process.record(), record, process.node_name, process.state == "running")
                for process in status.read(status.folder_of(record)) or ()
                if process.state == "running" or include_ended
            )
    return found + _orphans(folder)


def died(folder: Path | None = None) -> list[Running]:
    """Return background nodes, and processes of background launches, that failed or were killed.

    Includes nodes without a launch, and processes of launches that still run or that have ended.
    """
    found = [
        Running(record, is_alive=False, ending=_ending_of(record))
        for record in background.ended_records(folder)
        if record.kind not in background.LAUNCHES
    ]
    # A launch that ends between the two calls is in both lists.
    listed = [*background.records(folder), *background.ended_records(folder)]
    launches = {record.pid: record for record in listed if record.kind == background.LAUNCH}
    return found + [
        Running(
            process.record(),
            launch,
            process.node_name,
            is_alive=False,
            ending=_ending(process.exit_status, process.ended_at),
            is_death_shown=status.is_death_shown(status.folder_of(launch), process.name),
        )
        for launch in launches.values()
        for process in status.read(status.folder_of(launch)) or ()
        if process.state == "died"
    ]


def forget_died(entry: Running) -> None:
    """Remove the record of an ended process, or of its launch if that has ended too."""
    record = entry.launch or entry.record
    if not background.is_alive(record):
        background.remove_record(record)


def _ending_of(record: ProcessRecord) -> str:
    said = progress.read(record.log_file)
    if said is None or said.exit_status is None:
        return describe_exit(None)
    return _ending(said.exit_status, said.time)


def _ending(exit_status: int | None, ended_at: float) -> str:
    return f"{describe_exit(exit_status)}, {duration(time.time() - ended_at)} ago"


def duration(seconds: float) -> str:
    """Return a duration in words: ``3 s``, ``2m05s``, ``1h02m``."""
    whole = max(0, int(seconds))
    minutes, hours = whole // 60, whole // 3600
    if hours:
        return f"{hours}h{minutes % 60:02d}m"
    return f"{minutes}m{whole % 60:02d}s" if minutes else f"{whole} s"


def _orphans(folder: Path | None) -> list[Running]:
    """Return the running processes of launches that were killed; remove records without any."""
    found: list[Running] = []
    for launch in background.ended_records(folder):
        if launch.kind not in background.LAUNCHES:
            continue
        statuses = status.read(status.folder_of(launch)) or ()
        alive = [
            Running(process.record(), None, process.node_name)
            for process in statuses
            if process.state == "running" and background.is_alive(process.record())
        ]
        # A launch in the foreground has shown its deaths in the terminal.
        is_death_shown = launch.kind == background.FOREGROUND_LAUNCH
        if not alive and (
            is_death_shown or not any(process.state == "died" for process in statuses)
        ):
            background.remove_record(launch)
        found.extend(alive)
    return found


def find_running(
    name: str, *, include_ended: bool = False, include_foreground: bool = False
) -> list[Running]:
    """Return the background processes of a record, else node, else executable name; or raise.

    Names of a process that a launch started are ``exec-N``, ``launch/exec-N``, its executable's
    name, and its node's name.

    Raises:
        NotFoundError: No process of that name runs; the hint lists those that do.
    """
    everything = running(include_ended=include_ended, include_foreground=include_foreground)
    for names in (_exact_names, _node_names, _executable_names):
        found = [entry for entry in everything if name in names(entry)]
        if found:
            return found
    known = [entry.record.name for entry in everything if entry.is_alive]
    hint = did_you_mean(name, known) or _listing(known)
    for launch in background.foreground_launches():
        if name == launch.name:
            hint = f"{name} runs in the foreground. End it with {_ctrl_c(launch)}."
    raise NotFoundError(f"Nothing named '{name}' runs in the background", hint=hint)


def how_to_stop(node_names: Collection[str]) -> str:
    """Return the end of a sentence about how to stop the processes of running nodes."""
    owners = {
        owner.pid: owner
        for entry in running(include_foreground=True)
        if entry.node_name in node_names
        for owner in (entry.launch or entry.record,)
    }
    in_background = [r for r in owners.values() if r.kind != background.FOREGROUND_LAUNCH]
    ways = [_ctrl_c(r) for r in owners.values() if r.kind == background.FOREGROUND_LAUNCH]
    if in_background:
        names = " ".join(sorted(record.name for record in in_background))
        ways.insert(0, f"`teleopctl stop {names}`")
    return f"with {', and '.join(ways)}" if ways else "where it was started"


def _ctrl_c(launch: ProcessRecord) -> str:
    """Return in words how to end a launch in the foreground."""
    terminal = background.terminal_of(launch)
    if terminal is None:
        return f"`kill -INT {launch.pid}`, since it has no terminal"
    return f"Ctrl-C in its terminal, {terminal} (pid {launch.pid})"


def stop_running(record: ProcessRecord) -> None:
    """Stop a background process by SIGINT, then by SIGTERM and SIGKILL if needed."""
    is_launch = record.kind == background.LAUNCH
    background.stop(record, patience_s=_LAUNCH_PATIENCE_S if is_launch else _PATIENCE_S)


@contextmanager
def started_in_background(start: Callable[[], ProcessRecord]) -> Iterator[ProcessRecord]:
    """Start a background process and yield its record; on Ctrl-C in the block, stop the process.

    Args:
        start: Function that starts the process and returns its record at once.

    Raises:
        KeyboardInterrupt: The process was stopped after Ctrl-C; the text says so.
    """
    record = None
    try:
        with interrupts.delayed_interrupt():
            record = start()
        yield record
    except KeyboardInterrupt:
        if record is None:
            raise
        stop_running(record)
        raise KeyboardInterrupt(f"{record.name} has been stopped") from None


def newest_log(name: str) -> Path | None:
    """Return the newest log file of a background process by its name; None if there is none."""
    if not name or any(character in name for character in "/\\*?["):
        return None
    logs = background.logs_dir().glob(f"{name}-[0-9]*.log")
    return max(logs, key=lambda path: path.stat().st_mtime, default=None)


def _exact_names(entry: Running) -> Iterable[str]:
    return entry.record.name, entry.qualified_name


def _node_names(entry: Running) -> Iterable[str]:
    name = entry.node_name
    return () if name is None else (name, name.lstrip("/"), name.rpartition("/")[2])


def _executable_names(entry: Running) -> Iterable[str]:
    return (entry.record.name.rpartition("-")[0],) if entry.launch else ()


def _listing(known: list[str]) -> str:
    return (
        f"Running: {', '.join(known)}" if known else "Nothing is running there; see `teleopctl ps`."
    )
