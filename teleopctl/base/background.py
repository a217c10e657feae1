"""Processes that keep running after the command that started them has ended.

Each process has a record, a small file in the user's runtime folder with PID and start time. Both
are checked against the system whenever records are read, so that a record never stands for a
process that has ended, nor for another process with the same PID.
"""

from __future__ import annotations

import contextlib
import json
import os
import sys
import time
from pathlib import Path

from teleopctl.base import interrupts, progress
from teleopctl.base.files import open_private, write_private
from teleopctl.base.folders import (
    check_private,
    logs_dir as logs_dir,
    make_private,
    runtime_dir as runtime_dir,
)
from teleopctl.base.typed import TYPE_CHECKING, Mapping, NamedTuple, Sequence
from teleopctl.errors import SystemFailureError

# Commands that only read records import neither subprocess nor psutil, which take 10 ms.
if TYPE_CHECKING:
    import subprocess
    from contextlib import AbstractContextManager
    from typing import IO

    import psutil

    from teleopctl.base.start_timeouts import StartTimeouts
    from teleopctl.base.temporary import TemporaryFolder

READY = "ready"
"""Line that a background process writes to stdout when it is ready."""

LAUNCH = "launch"
"""Kind of a process that starts and watches other processes."""

FOREGROUND_LAUNCH = "foreground launch"
"""Kind of a launch in a terminal; `ended_records` returns its record after it was killed."""
LAUNCHES = (LAUNCH, FOREGROUND_LAUNCH)

_ANNOUNCE = "TELEOPCTL_ANNOUNCE"
_RECORDS = "processes"
_TEMPORARY = "temporary"
# Polling period while waiting for the end of a process: only children can be waited for.
_LOOK_EVERY_S = 0.02

# Period of progress checks while a process that announces readiness is starting.
_SOON_READY_S = 1.0
# Least time after SIGKILL before a process counts as one that cannot be killed.
_KILL_S = 5.0

# States of ended processes on Linux: zombie and dead.
_ENDED_STATES = ("Z", "X", "x")

# Children of this process, kept so that they are reaped when they end.
_children: dict[int, subprocess.Popen[str]] = {}

# Exit statuses of ended children, whose PIDs may be reused. Keys: PID and start mark.
_exit_statuses: dict[tuple[int, str], int] = {}


class StartTime(NamedTuple):
    """Start time of a process, with a mark that survives clock changes.

    Attributes:
        time: In seconds since the Unix epoch, by the system clock at the start; 0 before the start.
        mark: Distinguishes the process from others with the same PID, independent of clock
            changes; empty if the process ended before the mark could be read.
    """

    time: float = 0.0
    mark: str = ""


class ProcessRecord(NamedTuple):
    """Record of a background process: name, PID, start time, command, log file and kind.

    Attributes:
        name: Name shown to the user.
        pid: Process ID.
        start: Start time of the process.
        command: Program and arguments.
        log_file: File with the output of the process.
        kind: ``router``, ``node``, ``launch`` or ``foreground launch``.
        file: Path of the record file; None for processes of a launch, which the launch records.
    """

    name: str
    pid: int
    start: StartTime
    command: tuple[str, ...]
    log_file: Path
    kind: str
    file: Path | None = None


def start(
    name: str,
    argv: Sequence[str],
    *,
    kind: str,
    env: Mapping[str, str] | None = None,
    until_ready: StartTimeouts | None = None,
    takes_interrupts: bool = False,
) -> ProcessRecord:
    """Start a background process with a log file, optionally wait until ready; return its record.

    Args:
        name: Name of the process in ``ps`` and ``stop``.
        argv: Program and arguments.
        kind: ``router``, ``node`` or ``launch``.
        env: Complete environment of the process, which also determines the folders of its record
            and log; by default that of this process.
        until_ready: Time limits for the process to call `announce_ready`. None does not wait.
        takes_interrupts: Whether the program calls `interrupts.install_sigint_handler`. Then a
            SIGINT during its start is kept until that call.

    Raises:
        SystemFailureError: The program cannot be started, or the process reported a failure, ended
            or stalled before it announced that it is ready.
    """
    import subprocess

    from teleopctl.base.output import LOG_FILE, log_bytes

    # Keep the signals of the starter's console away; on other systems a new session does.
    flags = 0
    if sys.platform == "win32":
        flags = subprocess.CREATE_NEW_PROCESS_GROUP | subprocess.CREATE_NO_WINDOW
    environment = dict(os.environ if env is None else env)
    # Our own environment has the variable until this process announces that it is ready.
    environment.pop(_ANNOUNCE, None)
    log_bytes(environment)  # an invalid limit is reported here rather than in the log
    if until_ready is not None:
        environment[_ANNOUNCE] = "1"
    with _new_log(name, logs_dir(environment)) as log:
        log_file = Path(log.name)
        environment[LOG_FILE] = str(log_file)
        environment[progress.VARIABLE] = str(progress.progress_file(log_file))
        known: list[subprocess.Popen[str]] = []
        try:
            # An interrupt before the child is in the list would leave a process without a record.
            with (
                interrupts.delayed_interrupt(),
                _start_of_python(takes_interrupts=takes_interrupts),
            ):
                known.append(
                    subprocess.Popen(
                        list(argv),
                        stdin=subprocess.DEVNULL,
                        stdout=log if until_ready is None else subprocess.PIPE,
                        stderr=log,
                        env=environment,
                        text=True,
                        start_new_session=sys.platform != "win32",
                        creationflags=flags,
                    )
                )
        except OSError as error:
            raise SystemFailureError(f"Cannot start {argv[0]}: {error.strerror}") from error
        except KeyboardInterrupt:
            for child in known:
                _kill(child)
            raise
    (child,) = known
    try:
        _children[child.pid] = child
        if until_ready is not None:
            _await_ready(child, name, log_file, until_ready)
        file = runtime_dir(environment) / _RECORDS / f"{child.pid}.json"
        record = ProcessRecord(
            name, child.pid, start_time_of(child.pid), tuple(argv), log_file, kind, file
        )
        _write(record, file)
    except BaseException:
        # Without a record, no command would find the process.
        _kill(child)
        raise
    return record


def _start_of_python(*, takes_interrupts: bool) -> AbstractContextManager[None]:
    if takes_interrupts:
        return interrupts.blocked_for_children()
    return contextlib.nullcontext()


def _kill(child: subprocess.Popen[str]) -> None:
    """Kill a child process that was just started, and its descendants."""
    import psutil

    with contextlib.suppress(psutil.Error):
        for descendant in psutil.Process(child.pid).children(recursive=True):
            with contextlib.suppress(psutil.Error):
                descendant.kill()
    child.kill()
    child.wait()


def record_this_process(name: str, command: Sequence[str], log_file: Path, *, kind: str) -> Path:
    """Write this process's record file, and return its path.

    Raises:
        SystemFailureError: The file cannot be written.
    """
    file = runtime_dir() / _RECORDS / f"{(pid := os.getpid())}.json"
    _write(ProcessRecord(name, pid, start_time_of(pid), tuple(command), log_file, kind), file)
    return file


def announce_ready(failure: str | None = None) -> None:
    """Report readiness or a failure to the waiting parent process; then stdout goes to the log.

    Does nothing if no process waits for this one.
    """
    if os.environ.pop(_ANNOUNCE, None) is None:
        return
    # The starting process may have stopped waiting and closed its end of the pipe.
    with contextlib.suppress(OSError):
        sys.stdout.write(f"{READY if failure is None else ' '.join(failure.split())}\n")
        sys.stdout.flush()
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())


def exit_status(record: ProcessRecord) -> int | None:
    """Return the exit status of a recorded child process; None if it runs or is no child."""
    known = _exit_statuses.get((record.pid, record.start.mark))
    if known is not None:
        return known
    child = _children.get(record.pid)
    return None if child is None else child.poll()


def records(folder: Path | None = None) -> list[ProcessRecord]:
    """Return the records of running background processes, oldest first; delete stale ones.

    Launches in terminals are left out; see `foreground_launches`. Records of ended processes are
    removed, except those that `ended_records` returns.

    Args:
        folder: Runtime folder with the records; by default `runtime_dir`.
    """
    # A child that another command has stopped would stay a zombie.
    for child in list(_children.values()):
        child.poll()
    alive = []
    for path, record in _all_records(folder):
        if record is not None and is_alive(record):
            alive += [record] if record.kind != FOREGROUND_LAUNCH else []
        elif record is None or not _is_kept(record):
            path.unlink(missing_ok=True)
    return sorted(alive, key=lambda record: record.start.time)


def foreground_launches(folder: Path | None = None) -> list[ProcessRecord]:
    """Return the records of running launches in terminals."""
    found = (record for _, record in _all_records(folder) if record is not None)
    return [each for each in found if each.kind == FOREGROUND_LAUNCH and is_alive(each)]


def ended_records(folder: Path | None = None) -> list[ProcessRecord]:
    """Return the records of ended launches, and of other processes that failed or were killed."""
    return [r for _, r in _all_records(folder) if r and _is_kept(r) and not is_alive(r)]


def remove_record(record: ProcessRecord) -> None:
    """Remove the record and temporary files of an ended process."""
    if record.file is None:
        return
    record.file.unlink(missing_ok=True)
    temporary = record.file.parent.with_name(_TEMPORARY)
    if temporary.exists():
        from teleopctl.base.temporary import remove_abandoned

        remove_abandoned(temporary, _is_recorded, ended=record.pid)


def temporary_folder() -> TemporaryFolder:
    """Make a private temporary folder; return a `TemporaryFolder` that can remove it.

    The folder lies next to the records. If this process is killed, the processes that it started
    may still need the files, so that the folder is removed together with the record.

    Raises:
        SystemFailureError: The folder cannot be made.
    """
    from teleopctl.base.temporary import TemporaryFolder

    parent = runtime_dir() / _TEMPORARY
    try:
        make_private(parent)
        return TemporaryFolder(parent, _is_recorded)
    except OSError as error:
        raise SystemFailureError(
            f"Cannot make a temporary folder in {parent}: {error.strerror}",
            hint="Set TELEOPCTL_RUNTIME_DIR to a folder that you may write to.",
        ) from error


def _is_recorded(pid: int) -> bool:
    return (runtime_dir() / _RECORDS / f"{pid}.json").exists()


def start_time_of(pid: int) -> StartTime:
    """Return when a process started, as a `StartTime`; the current time if it has ended."""
    if sys.platform == "linux":
        _, mark = _linux_state(pid)
        return StartTime(_linux_start(mark) if mark else time.time(), mark)
    import psutil

    try:
        process = psutil.Process(pid)
        return StartTime(process.create_time(), _start_mark(process))
    except (psutil.Error, OSError):
        # The process has ended already; its log has the reason.
        return StartTime(time.time())


def is_alive(record: ProcessRecord) -> bool:
    """Return whether the recorded process still runs, and not another one with its PID."""
    child = _children.get(record.pid)
    if sys.platform != "linux" or (child is not None and child.poll() is not None):
        return _process(record) is not None
    state, mark = _linux_state(record.pid)
    return mark == record.start.mark and state not in _ENDED_STATES


def terminal_of(record: ProcessRecord) -> str | None:
    """Return the terminal of a running process, such as ``/dev/pts/1``; None if it has none."""
    import psutil

    process = _process(record)
    try:
        # On Windows psutil has no such method; there every process of a console gets its Ctrl-C.
        return None if process is None else getattr(process, "terminal", lambda: "the console")()
    except psutil.Error:
        return None


def stop(record: ProcessRecord, *, patience_s: float = 5.0) -> None:
    """Stop a process by SIGINT, then SIGTERM, then SIGKILL with descendants; remove its record.

    Args:
        record: Record of the process; a process that has already ended is no error.
        patience_s: Time to wait after each signal for the process to end, in seconds.

    Raises:
        SystemFailureError: The process does not end, or this user may not end it; the record stays.
    """
    import signal

    import psutil

    process = _process(record)
    if process is not None:
        # Windows has no interrupt that reaches a process without a common console.
        gentle = [signal.SIGTERM] if os.name == "nt" else [signal.SIGINT, signal.SIGTERM]
        try:
            for number in gentle:
                process.send_signal(number)
                if _wait(process, patience_s):
                    break
            else:
                for member in [*process.children(recursive=True), process]:
                    with contextlib.suppress(psutil.NoSuchProcess):
                        member.kill()
                # However impatient the caller is: on a busy machine a kill takes a moment.
                if not _wait(process, max(patience_s, _KILL_S)):
                    # The process may be in a driver call that cannot be interrupted.
                    raise SystemFailureError(
                        f"{record.name} (pid {record.pid}) has not ended, though it was killed"
                    )
        except psutil.NoSuchProcess:
            pass
        except psutil.AccessDenied as error:
            raise SystemFailureError(
                f"{record.name} (pid {record.pid}) may not be ended by this user"
            ) from error
    remove_record(record)


def _is_kept(record: ProcessRecord) -> bool:
    """Whether a record outlives its process."""
    return record.kind in LAUNCHES or progress.has_failed(record.log_file)


def _await_ready(
    child: subprocess.Popen[str], name: str, log_file: Path, timeouts: StartTimeouts
) -> None:
    import threading

    from teleopctl.base.start_timeouts import ProgressMonitor

    lines: list[str] = []
    stream = child.stdout
    assert stream is not None
    # A pipe cannot be read with a deadline on every system; a thread can be waited for.
    reader = threading.Thread(target=_read_line, args=(stream, lines), daemon=True)
    reader.start()
    monitor = ProgressMonitor(timeouts)
    reader.join(_SOON_READY_S)
    while reader.is_alive():
        monitor.update(log_file.stat().st_size, [child.pid])
        if monitor.has_stalled or monitor.is_over:
            raise SystemFailureError(
                f"{name} is not ready after {monitor.elapsed_s:.1f} s",
                hint=f"Its output is in {log_file}.",
            )
        reader.join(min(_SOON_READY_S, timeouts.stall_s))
    line = lines[0] if lines else ""
    if line == READY:
        return
    raise SystemFailureError(
        line or f"{name} ended while it was starting", hint=f"Its output is in {log_file}."
    )


def _read_line(stream: IO[str], lines: list[str]) -> None:
    with stream:
        lines.append(stream.readline().strip())


def _wait(process: psutil.Process, timeout_s: float) -> bool:
    """Wait for the end of a process; False when the time is up.

    Not psutil's own wait, which for a process that is not a child waits until the parent has reaped
    the process. In a container without an init process that never happens.
    """
    deadline = time.monotonic() + timeout_s
    while _is_running(process):
        if time.monotonic() >= deadline:
            return False
        time.sleep(_LOOK_EVERY_S)
    return True


def _is_running(process: psutil.Process) -> bool:
    import psutil

    child = _children.get(process.pid)
    if child is not None:
        return child.poll() is None
    try:
        return process.is_running() and process.status() != psutil.STATUS_ZOMBIE
    except psutil.Error:
        # The process has ended, or its PID now belongs to another user, whose processes are hidden.
        return False


def _process(record: ProcessRecord) -> psutil.Process | None:
    """The running process of a record, or None when it has ended."""
    import psutil

    child = _children.get(record.pid)
    if child is not None and (status := child.poll()) is not None:
        # The PID may have been reused, even by the recorded process.
        _exit_statuses[record.pid, record.start.mark] = status
        del _children[record.pid]
    try:
        process = psutil.Process(record.pid)
        is_same = _start_mark(process) == record.start.mark
    except (psutil.Error, OSError):
        return None
    return process if is_same and _is_running(process) else None


def _start_mark(process: psutil.Process) -> str:
    if sys.platform != "linux":
        return f"{process.create_time():.3f}"
    # On Linux psutil adds the clock and the time since boot, so that its result changes when a
    # machine without a battery-backed clock, such as a robot, sets its clock over the network.
    _, mark = _linux_state(process.pid)
    if not mark:
        raise ProcessLookupError(process.pid)
    return mark


def _linux_state(pid: int) -> tuple[str, str]:
    """Return the letter of a process's state and its start mark; two empty texts if it has none."""
    try:
        boot = Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii").strip()
        stat = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return "", ""
    # The program's name, in parentheses, may contain anything; the start time is the 22nd field.
    fields = stat.rpartition(")")[2].split()
    return fields[0], f"{boot}/{fields[19]}"


def _linux_start(mark: str) -> float:
    """Return the time of a start mark, in seconds since the Unix epoch."""
    age = Path("/proc/uptime").read_text(encoding="ascii").split()[0]
    ticks = int(mark.rpartition("/")[2])
    return time.time() - float(age) + ticks / os.sysconf("SC_CLK_TCK")


def _write(record: ProcessRecord, path: Path) -> None:
    folder = path.parent
    entry = {**record._asdict(), "log_file": str(record.log_file)}
    del entry["file"]
    try:
        make_private(folder)
        # Replaced atomically, so that no reader gets half a record.
        write_private(path, json.dumps(entry))
    except OSError as error:
        raise SystemFailureError(
            f"Cannot record a background process in {folder}: {error.strerror}",
            hint="Set TELEOPCTL_RUNTIME_DIR to a folder that you may write to.",
        ) from error


def _all_records(folder: Path | None) -> list[tuple[Path, ProcessRecord | None]]:
    place = (runtime_dir() if folder is None else folder) / _RECORDS
    check_private(place)
    return [(path, _read(path)) for path in sorted(place.glob("*.json"))]


def _read(path: Path) -> ProcessRecord | None:
    try:
        entry = json.loads(path.read_text(encoding="utf-8"))
        return ProcessRecord(
            str(entry["name"]),
            int(entry["pid"]),
            StartTime(float(entry["start"][0]), str(entry["start"][1])),
            tuple(str(word) for word in entry["command"]),
            Path(entry["log_file"]),
            str(entry["kind"]),
            path,
        )
    except (OSError, ValueError, LookupError, TypeError):
        return None


def _new_log(name: str, folder: Path) -> IO[bytes]:
    from datetime import datetime

    safe = "".join(c if c.isalnum() or c in "._-" else "_" for c in name)
    stamp = datetime.now().strftime("%Y-%m-%d-%H-%M-%S-%f")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / f"{safe}-{stamp}-{os.getpid()}.log"
        return open(path, "ab", opener=open_private)
    except OSError as error:
        raise SystemFailureError(
            f"Cannot write to the log folder {folder}: {error.strerror}",
            hint="Set ROS_LOG_DIR to a folder that you may write to.",
        ) from error
