"""One process of a launch: start, output, signals and exit status."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import threading
import time
from functools import partial
from pathlib import Path

from teleopctl.base import interrupts, progress
from teleopctl.base.output import LOG_FILE, LogFile
from teleopctl.base.typed import TYPE_CHECKING, Callable
from teleopctl.launch.execution.screen import QuietLines, Screen
from teleopctl.launch.execution.standby import StandbyProcess
from teleopctl.launch.execution.streams import lines, stream
from teleopctl.launch.model.plan import ProcessPlan

if TYPE_CHECKING:
    from typing import IO


# How long to read on after a process has ended, in case a descendant keeps its output open.
_LAST_WORDS_S = 1.0
# Exit statuses of a process that ended because of a signal.
_ENDED_BY_INTERRUPT = frozenset({128 + signal.SIGINT, -signal.SIGINT, 0xC000013A})
_ENDED_BY_TERMINATION = frozenset({128 + signal.SIGTERM, -signal.SIGTERM})


class Child:
    """A process of a launch: not yet started, running or ended.

    Args:
        plan: Plan of the process.
        log_file: Path of the log file for the process's output.
        screen: Screen on which the output is shown.
        on_exit: Called with the child, on another thread, when the process has ended and its output
            was read.
        on_output: Called with the child, each line of output and whether the line came from stdout,
            on another thread.
    """

    def __init__(
        self,
        plan: ProcessPlan,
        log_file: Path,
        screen: Screen,
        on_exit: Callable[[Child], None],
        on_output: Callable[[Child, bytes, bool], None],
    ) -> None:
        self.plan = plan
        self.log_file = log_file
        self.retries = 0
        self._screen = screen
        self._on_exit = on_exit
        self._on_output = on_output
        self._ended_at = 0.0
        self._process: subprocess.Popen[bytes] | None = None
        self._log: LogFile | None = None
        self._signals_sent: set[int] = set()
        self._pipes: tuple[IO[bytes], IO[bytes]]

    @property
    def pid(self) -> int | None:
        """Process id of the last start, also after its end; None before the first start."""
        return None if self._process is None else self._process.pid

    @property
    def is_running(self) -> bool:
        """Whether the process was started and has not ended."""
        return self._process is not None and self._process.returncode is None

    @property
    def exit_status(self) -> int | None:
        """Exit status of the process, negative for a signal; None if the process has not ended."""
        return None if self._process is None else self._process.returncode

    @property
    def ended_at(self) -> float:
        """Time at which the process ended, in seconds since the Unix epoch; 0 before."""
        return self._ended_at

    @property
    def was_signalled(self) -> bool:
        """Whether the launch has sent a signal to the process since its last start."""
        return bool(self._signals_sent)

    @property
    def is_ready(self) -> bool:
        """Whether the process has written to its progress file that it is ready."""
        said = progress.read(self.log_file)
        return said is not None and said.state == progress.READY

    @property
    def is_starting(self) -> bool:
        """Whether the process runs, and is neither ready nor reports that it has failed."""
        said = progress.read(self.log_file)
        is_done = said is not None and said.state in (progress.READY, progress.FAILED)
        return self.is_running and not is_done

    @property
    def ended_cleanly(self) -> bool:
        """Whether the process ended with 0, by SIGINT, or, if the launch signalled, by SIGTERM."""
        status = self.exit_status
        if status == 0 or status in _ENDED_BY_INTERRUPT:
            return True
        return self.was_signalled and status in _ENDED_BY_TERMINATION

    def start(self, standby: StandbyProcess | None = None) -> None:
        """Start the process; its output is not read before `relay_output` is called.

        Args:
            standby: Process that waits for its arguments, which becomes this one if it fits.

        Raises:
            OSError: The process cannot be started.
            ValueError: The command line contains a null byte.
        """
        self._signals_sent.clear()
        # The progress file is that of the previous process.
        progress.progress_file(self.log_file).unlink(missing_ok=True)
        environment = _environment(self.plan, self.log_file)
        taken = None if standby is None else standby.take(self.plan, environment)
        self._process, self._pipes = taken or self._start_process(environment)
        self._log = LogFile(self.log_file, partial(self._screen.log, "WARNING", "launch"))

    def _start_process(
        self, environment: dict[str, str]
    ) -> tuple[subprocess.Popen[bytes], tuple[IO[bytes], IO[bytes]]]:
        plan = self.plan
        runs_our_main = plan.is_node and plan.command[0] == sys.executable
        emulate = plan.emulate_tty and sys.platform != "win32"
        with (
            interrupts.blocked_for_children() if runs_our_main else contextlib.nullcontext(),
            stream(as_terminal=emulate) as out,
            stream(as_terminal=emulate) as err,
        ):
            process = subprocess.Popen(
                plan.command[0] if plan.shell else plan.command,
                shell=plan.shell,
                cwd=plan.working_directory,
                env=environment,
                stdin=subprocess.DEVNULL,
                stdout=out.written,
                stderr=err.written,
                # When this process is killed, SIGPIPE must not kill a node at its next line.
                restore_signals=not plan.is_node,
                **interrupts.own_group(),
            )
            return process, (out.read(), err.read())

    def relay_output(self) -> None:
        """Start threads that copy the process's output to log and screen until the process ends."""
        threading.Thread(
            target=self._attend,
            args=(self._process, self._log),
            name=self.plan.name,
            daemon=True,
        ).start()

    def signal(self, number: signal.Signals) -> None:
        """Send a signal to the process group of the process, if the process is running."""
        process = self._process
        if process is None or process.poll() is not None:
            return
        self._signals_sent.add(number)
        with contextlib.suppress(ProcessLookupError, PermissionError):
            if sys.platform == "win32":
                if number == signal.SIGINT:
                    process.send_signal(signal.CTRL_BREAK_EVENT)
                else:
                    process.kill()
            else:
                os.killpg(process.pid, number)

    def _attend(self, process: subprocess.Popen[bytes], log: LogFile) -> None:
        with contextlib.closing(log):
            readers = [
                threading.Thread(target=self._relay, args=(pipe, log, is_stdout), daemon=True)
                for pipe, is_stdout in zip(self._pipes, (True, False), strict=True)
            ]
            for reader in readers:
                reader.start()
            process.wait()
            self._ended_at = time.time()
            for reader in readers:
                reader.join(_LAST_WORDS_S)
        self._on_exit(self)

    def _relay(self, pipe: IO[bytes], log: LogFile, is_stdout: bool) -> None:
        output = self.plan.stdout if is_stdout else self.plan.stderr
        own = self._own_log("stdout" if is_stdout else "stderr") if output.own_log else None
        quiet = QuietLines() if self.plan.is_quiet and self._screen.is_terse else None
        with pipe, contextlib.closing(own) if own is not None else contextlib.nullcontext():
            for line in lines(pipe):
                log.write(line)
                if own is not None:
                    own.write(line)
                self._on_output(self, line, is_stdout)
                shown = output.screen and not (quiet is not None and quiet.hides(line))
                self._screen.relay(self.plan.name, line, shown=shown, kept=output.log)

    def _own_log(self, stream: str) -> LogFile:
        return LogFile(self.log_file.with_name(f"{self.plan.name}-{stream}.log"))


def start_error_text(error: OSError | ValueError) -> str:
    """Return in words why a process could not be started."""
    if isinstance(error, OSError) and error.strerror:
        return f"{error.strerror}: {error.filename}" if error.filename else error.strerror
    return str(error)


def _environment(plan: ProcessPlan, log_file: Path) -> dict[str, str]:
    # Unbuffered, since otherwise the output of a node appears only when a buffer is full.
    wanted = {
        **os.environ,
        "PYTHONUNBUFFERED": "1",
        progress.VARIABLE: str(progress.progress_file(log_file)),
        **plan.environment,
    }
    if plan.is_node:
        # The node writes to this file when this process has ended before it.
        wanted[LOG_FILE] = str(log_file)
    return {name: value for name, value in wanted.items() if value is not None}
