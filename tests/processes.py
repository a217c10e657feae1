"""Real processes for tests: each environment has its own router, domain and folders."""

import contextlib
import os
import re
import shlex
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import psutil

from teleopctl import background
from teleopctl.errors import TeleopctlError

ROOT = Path(__file__).parents[1]

LONGEST_WAIT_S = 20.0
"""Deadline of every wait unless a test names one: generous, since it is reached only on failure."""

Stream = Literal["any", "stdout", "stderr"]


def free_port() -> int:
    """A TCP port of the loopback interface that nothing listens on at the moment."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        return server.getsockname()[1]


class Process:
    """A running program whose output lines can be waited for."""

    def __init__(self, argv: Sequence[str], env: dict[str, str], cwd: Path) -> None:
        self._lines: list[tuple[str, str]] = []
        self._searched = 0
        self._open_streams = 2
        self._changed = threading.Condition()
        self._popen = subprocess.Popen(
            list(argv),
            env=env,
            cwd=cwd,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            encoding="utf-8",
            errors="replace",
            start_new_session=os.name != "nt",
            creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
        )
        for name in ("stdout", "stderr"):
            threading.Thread(target=self._read, args=(name,), daemon=True).start()

    def _read(self, name: str) -> None:
        for line in getattr(self._popen, name):
            with self._changed:
                self._lines.append((name, line.rstrip("\n")))
                self._changed.notify_all()
        with self._changed:
            self._open_streams -= 1
            self._changed.notify_all()

    @property
    def pid(self) -> int:
        return self._popen.pid

    @property
    def returncode(self) -> int | None:
        return self._popen.poll()

    @property
    def stdout(self) -> str:
        """What it has written to standard output so far."""
        return self._text("stdout")

    @property
    def stderr(self) -> str:
        """What it has written to standard error so far."""
        return self._text("stderr")

    def _text(self, stream: str) -> str:
        with self._changed:
            return "".join(f"{line}\n" for name, line in self._lines if name == stream)

    def wait_for_line(
        self, pattern: str, timeout_s: float = LONGEST_WAIT_S, *, stream: Stream = "any"
    ) -> re.Match[str]:
        """Wait for a line that the pattern is found in, behind the line found last.

        Fails with the whole output when the time is up or the program ends without such a line.
        """
        regex = re.compile(pattern)
        found: list[re.Match[str]] = []

        def search() -> bool:
            while self._searched < len(self._lines):
                name, line = self._lines[self._searched]
                self._searched += 1
                match = regex.search(line) if stream in ("any", name) else None
                if match:
                    found.append(match)
                    return True
            return self._open_streams == 0

        with self._changed:
            self._changed.wait_for(search, timeout_s)
        if not found:
            raise AssertionError(f"no line matches {pattern!r}\n{self._report()}")
        return found[0]

    def send(self, text: str) -> None:
        """Write to its standard input."""
        assert self._popen.stdin is not None
        self._popen.stdin.write(text)
        self._popen.stdin.flush()

    def interrupt(self) -> None:
        """What Ctrl-C does."""
        self._popen.send_signal(
            signal.SIGINT if os.name != "nt" else signal.CTRL_BREAK_EVENT  # type: ignore[attr-defined]
        )

    def terminate(self) -> None:
        self._popen.terminate()

    def wait(self, timeout_s: float = LONGEST_WAIT_S) -> int:
        """Wait for its end and all its output; returns the exit status."""
        try:
            status = self._popen.wait(timeout_s)
        except subprocess.TimeoutExpired:
            raise AssertionError(f"it did not end within {timeout_s} s\n{self._report()}") from None
        with self._changed:
            # A descendant that lives on may keep the streams open.
            self._changed.wait_for(lambda: self._open_streams == 0, 1.0)
        return status

    def kill(self) -> None:
        """End it and what it started, in process groups of their own too, at once."""
        with contextlib.suppress(psutil.NoSuchProcess):
            process = psutil.Process(self._popen.pid)
            for descendant in process.children(recursive=True):
                with contextlib.suppress(psutil.NoSuchProcess):
                    descendant.kill()
        self._popen.kill()
        self._popen.wait()
        if self._popen.stdin is not None:
            with contextlib.suppress(OSError):
                self._popen.stdin.close()

    def _report(self) -> str:
        output = "\n".join(f"{name}: {line}" for name, line in self._lines)
        return f"{shlex.join(map(str, self._popen.args))}\n{output}\nstatus: {self.returncode}"


class RosEnvironment:
    """Environment variables of one isolated ROS graph, and the processes started in it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._processes: list[Process] = []
        self.use_port(free_port())

    def use_port(self, port: int) -> None:
        """Expect the router on another port."""
        self.port = port
        self.router = f"tcp/127.0.0.1:{port}"
        self.domain = 1 + port % 100
        self.variables = {
            "TELEOPCTL_ROUTER": self.router,
            "ROS_DOMAIN_ID": str(self.domain),
            "TELEOPCTL_RUNTIME_DIR": str(self.folder / "runtime"),
            "ROS_LOG_DIR": str(self.folder / "log"),
        }
        foreign = ("ROS_", "RMW_", "ZENOH_", "TELEOPCTL_", "AMENT_", "RUST_LOG", "PYTHONUNBUFFERED")
        inherited = {k: v for k, v in os.environ.items() if not k.startswith(foreign)}
        self.env = inherited | self.variables

    def start_router(self) -> background.ProcessRecord:
        """Start the router as the daemon is started; whoever calls it runs in this environment."""
        for attempt in range(3):
            try:
                return background.start(
                    "router",
                    [sys.executable, "-m", "teleopctl.wire.router", self.router],
                    kind="router",
                    env=self.env,
                    ready_within_s=LONGEST_WAIT_S,
                )
            except TeleopctlError as error:
                # Another test may have been given the same free port.
                if attempt == 2 or "in use" not in str(error):
                    raise
                self.use_port(free_port())
                os.environ.update(self.variables)
        raise AssertionError

    def run(
        self,
        args: Sequence[str] | str,
        timeout: float = LONGEST_WAIT_S,
        *,
        input: str | None = None,  # noqa: A002 - subprocess's word
        cwd: Path | None = None,
    ) -> subprocess.CompletedProcess[str]:
        """Run ``teleopctl ARGS`` to its end; args as a list, or as one line for a shell."""
        return self.run_module("teleopctl", args, timeout, input=input, cwd=cwd)

    def spawn(self, args: Sequence[str] | str, *, cwd: Path | None = None) -> Process:
        """Start ``teleopctl ARGS``; it is killed at the end of the test."""
        return self.spawn_module("teleopctl", args, cwd=cwd)

    def run_module(
        self,
        module: str,
        args: Sequence[str] | str = (),
        timeout: float = LONGEST_WAIT_S,
        *,
        input: str | None = None,  # noqa: A002 - subprocess's word
        cwd: Path | None = None,
    ) -> subprocess.CompletedProcess[str]:
        """Run ``python -m MODULE ARGS`` to its end."""
        return subprocess.run(
            [sys.executable, "-m", module, *_words(args)],
            env=self.env,
            cwd=cwd or self.folder,
            input=input,
            stdin=subprocess.DEVNULL if input is None else None,
            capture_output=True,
            text=True,
            encoding="utf-8",
            timeout=timeout,
            check=False,
        )

    def spawn_module(
        self, module: str, args: Sequence[str] | str = (), *, cwd: Path | None = None
    ) -> Process:
        """Start ``python -m MODULE ARGS``; it is killed at the end of the test."""
        # The tests' own programs are not installed: Python finds them from the root.
        home = ROOT if module.startswith("tests.") else self.folder
        process = Process([sys.executable, "-m", module, *_words(args)], self.env, cwd or home)
        self._processes.append(process)
        return process

    def spawn_command(self, argv: Sequence[str]) -> Process:
        """Start any program; it is killed at the end of the test."""
        process = Process(argv, self.env, self.folder)
        self._processes.append(process)
        return process

    def close(self) -> None:
        """End every process that was started here, in the background too."""
        for process in self._processes:
            process.kill()
        for record in background.records():
            background.stop(record, patience_s=2.0)


def eventually(check, timeout_s: float = LONGEST_WAIT_S, what: str = "it") -> None:
    """Wait for something that gives no event, such as the end of a process of someone else."""
    deadline = time.monotonic() + timeout_s
    pause = threading.Event()
    while not check():
        assert time.monotonic() < deadline, f"{what} did not happen within {timeout_s} s"
        pause.wait(0.01)


def _words(args: Sequence[str] | str) -> list[str]:
    return shlex.split(args) if isinstance(args, str) else [str(word) for word in args]
