"""Processes that go on after the command that started them has ended.

Each has a record, a small file in the user's runtime folder with its pid and start time. Both are
checked against the system whenever records are read, so that a record never speaks of a process
that is gone, nor of another one that was given the same pid.
"""

import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from datetime import datetime
from pathlib import Path
from typing import IO, TYPE_CHECKING, NamedTuple

from teleopctl.base import interrupts, progress
from teleopctl.base.files import open_private, write_private
from teleopctl.base.folders import (
    check_private,
    logs_dir as logs_dir,
    make_private,
    runtime_dir as runtime_dir,
)
from teleopctl.base.output import LOG_FILE, log_bytes
from teleopctl.base.start_timeouts import ProgressMonitor, StartTimeouts
from teleopctl.errors import SystemFailureError

if TYPE_CHECKING:
    import psutil

    from teleopctl.base.temporary import TemporaryFolder

READY = "ready"
"""The line by which a background process says that it is up."""

LAUNCH = "launch"
"""The kind of a process that starts and watches others."""

FOREGROUND_LAUNCH = "foreground launch"
"""The kind of a launch in a terminal; `ended` has it once it has been killed."""
LAUNCHES = (LAUNCH, FOREGROUND_LAUNCH)

_ANNOUNCE = "TELEOPCTL_ANNOUNCE"
_RECORDS = "processes"
_TEMPORARY = "temporary"
# A process that is no child cannot be waited for on every system: it is looked at this often.
_LOOK_EVERY_S = 0.02

# How often to look whether what is to announce that it is ready gets on.
_SOON_READY_S = 1.0

# What keeps the signals of the starter's console away; elsewhere a session of its own does.
if sys.platform == "win32":
    _CREATION_FLAGS = subprocess.CREATE_NEW_PROCESS_GROUP | subprocess.CREATE_NO_WINDOW
else:
    _CREATION_FLAGS = 0

# Children of this process, kept so that they are reaped when they end.
_children: dict[int, subprocess.Popen[str]] = {}

# Of children that have ended and whose pid may be another process's by now: pid and start mark.
_exit_statuses: dict[tuple[int, str], int] = {}


class StartTime(NamedTuple):
    """Start time of a process, with a mark that survives clock changes.

    Attributes:
        time: In seconds since the Unix epoch, by the clock as it was set then; 0 before the start.
        mark: What tells the process from any other one that has its pid, however the clock is
            set; empty when it was too short-lived to be asked.
    """

    time: float = 0.0
    mark: str = ""


class ProcessRecord(NamedTuple):
    """Record of a background process: name, PID, start time, command, log file and kind.

    Attributes:
        name: Name shown to the user.
        pid: Process id.
        start: Start time of the process.
        command: Program and arguments.
        log_file: File with the output of the process.
        kind: ``router``, ``node``, ``launch`` or ``foreground launch``.
        file: The record itself; None for what a launch started, of which the launch keeps book.
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
    """Start a background process, with its output in a log file.

    Args:
        name: What people call it, in ``ps`` and ``stop``.
        argv: Program and arguments.
        kind: ``router``, ``node`` or ``launch``.
        env: Its whole environment, which also says where its record and its log belong; by
            default that of this process.
        until_ready: How long to wait until the process calls `announce_ready`. None does not wait.
        takes_interrupts: Whether the program calls `interrupts.take`, and so loses no SIGINT that
            comes while it starts.

    Raises:
        SystemFailureError: The program cannot be started, or it reported a failure, ended or did
            not get on instead of announcing that it is ready.
    """
    environment = dict(os.environ if env is None else env)
    # It may be in our own environment, when this process has not announced itself yet.
    environment.pop(_ANNOUNCE, None)
    log_bytes(environment)  # a faulty bound is better said here than in the log
    if until_ready is not None:
        environment[_ANNOUNCE] = "1"
    with _new_log(name, logs_dir(environment)) as log:
        log_file = Path(log.name)
        environment[LOG_FILE] = str(log_file)
        environment[progress.VARIABLE] = str(progress.progress_file(log_file))
        known: list[subprocess.Popen[str]] = []
        try:
            # An interrupt before it is known would leave a process that nobody finds again.
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
                        creationflags=_CREATION_FLAGS,
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
        # Without a record nobody would find it again.
        _kill(child)
        raise
    return record


def _start_of_python(*, takes_interrupts: bool) -> AbstractContextManager[None]:
    if takes_interrupts:
        return interrupts.blocked_for_children()
    return contextlib.nullcontext()


def _kill(child: "subprocess.Popen[str]") -> None:
    """End a process that was started just now, and what it has started itself, at once."""
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
        SystemFailureError: It cannot be written.
    """
    file = runtime_dir() / _RECORDS / f"{(pid := os.getpid())}.json"
    _write(ProcessRecord(name, pid, start_time_of(pid), tuple(command), log_file, kind), file)
    return file


def announce_ready(failure: str | None = None) -> None:
    """Report to the starting process that this one is up, or why it failed.

    Does nothing in a process that nobody waits for. From here on, standard output goes to the log.
    """
    if os.environ.pop(_ANNOUNCE, None) is None:
        return
    # The starter may have given up waiting and closed its end.
    with contextlib.suppress(OSError):
        sys.stdout.write(f"{READY if failure is None else ' '.join(failure.split())}\n")
        sys.stdout.flush()
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())


def exit_status(record: ProcessRecord) -> int | None:
    """Return the exit status of a child process; None while it runs and for others."""
    known = _exit_statuses.get((record.pid, record.start.mark))
    if known is not None:
        return known
    child = _children.get(record.pid)
    return None if child is None else child.poll()


def records(folder: Path | None = None) -> list[ProcessRecord]:
    """Return the records of running background processes, oldest first.

    Those that `ended` returns are not.

    Args:
        folder: Whose processes; by default those of `runtime_dir`.
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
    """Return the records of launches in terminals."""
    found = (record for _, record in _all_records(folder) if record is not None)
    return [each for each in found if each.kind == FOREGROUND_LAUNCH and is_alive(each)]


def ended_records(folder: Path | None = None) -> list[ProcessRecord]:
    """Return the records of launches and nodes that died."""
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


def temporary_folder() -> "TemporaryFolder":
    """Make a private temporary folder for this process, and return the folder.

    It lies beside the records, private to the user. If this process is killed, the processes that
    it started may still need the files, so that the folder is removed with the record.

    Raises:
        SystemFailureError: It cannot be made.
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
    import psutil

    try:
        process = psutil.Process(pid)
        return StartTime(process.create_time(), _start_mark(process))
    except (psutil.Error, OSError):
        # It has ended already, which is for its log to explain.
        return StartTime(time.time())


def is_alive(record: ProcessRecord) -> bool:
    """Return whether the recorded process still runs, and not another one with its pid."""
    return _process(record) is not None


def terminal_of(record: ProcessRecord) -> str | None:
    """Return the terminal of a process, such as ``/dev/pts/1``; None if it has none."""
    import psutil

    process = _process(record)
    try:
        # Windows has no such method: there every process of a console gets its Ctrl-C.
        return None if process is None else getattr(process, "terminal", lambda: "the console")()
    except psutil.Error:
        return None


def stop(record: ProcessRecord, *, patience_s: float = 5.0) -> None:
    """Stop a background process: SIGINT, then SIGTERM, then SIGKILL with its descendants.

    Args:
        record: The process; one that has ended meanwhile is no error.
        patience_s: How long to wait, in seconds, before each harder signal.

    Raises:
        SystemFailureError: It does not end, or may not be ended by this user; its record stays.
    """
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
                if not _wait(process, patience_s):
                    # It may be in a call of a driver that cannot be interrupted.
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
    child: "subprocess.Popen[str]", name: str, log_file: Path, timeouts: StartTimeouts
) -> None:
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


def _wait(process: "psutil.Process", timeout_s: float) -> bool:
    """Wait for the end of a process; False when the time is up.

    The processes of other commands are no children of this one, and psutil would wait until their
    parent has taken note of the end, which in a container without an init process is never.
    """
    deadline = time.monotonic() + timeout_s
    while _is_running(process):
        if time.monotonic() >= deadline:
            return False
        time.sleep(_LOOK_EVERY_S)
    return True


def _is_running(process: "psutil.Process") -> bool:
    import psutil

    child = _children.get(process.pid)
    if child is not None:
        return child.poll() is None
    try:
        return process.is_running() and process.status() != psutil.STATUS_ZOMBIE
    except psutil.Error:
        # Gone, or another user's by now, whose state some systems keep to themselves.
        return False


def _process(record: ProcessRecord) -> "psutil.Process | None":
    """The running process of a record, or None when it has ended."""
    import psutil

    child = _children.get(record.pid)
    if child is not None and (status := child.poll()) is not None:
        # Its pid may be another process's by now, the recorded one's too.
        _exit_statuses[record.pid, record.start.mark] = status
        del _children[record.pid]
    try:
        process = psutil.Process(record.pid)
        is_same = _start_mark(process) == record.start.mark
    except (psutil.Error, OSError):
        return None
    return process if is_same and _is_running(process) else None


def _start_mark(process: "psutil.Process") -> str:
    if sys.platform != "linux":
        return f"{process.create_time():.3f}"
    # There psutil adds up the clock and the time since the boot, so that its answer changes when
    # a machine without a battery for its clock, a robot say, finds the time in the network.
    boot = Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii").strip()
    stat = Path(f"/proc/{process.pid}/stat").read_text(encoding="utf-8", errors="replace")
    # The name of the program, in parentheses, may hold anything; the start is the 22nd field.
    return f"{boot}/{stat.rpartition(')')[2].split()[19]}"


def _write(record: ProcessRecord, path: Path) -> None:
    folder = path.parent
    entry = {**record._asdict(), "log_file": str(record.log_file)}
    del entry["file"]
    try:
        make_private(folder)
        # Replaced in one step: nobody reads half a record.
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
