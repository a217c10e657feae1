"""Isolated ROS graph for tests: router, domain, folders and processes."""

from __future__ import annotations

import itertools
import os
import shlex
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, MutableMapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from teleopctl.base import background
from teleopctl.base.start_timeouts import StartTimeouts
from teleopctl.errors import TeleopctlError
from teleopctl.testing.process import LONGEST_WAIT_S, Process

if TYPE_CHECKING:
    from teleopctl.interfaces import MessageT
    from teleopctl.node import Node, QoSProfile
    from teleopctl.testing.launched import LaunchedSystem
    from teleopctl.testing.observer import Observer


# Prefixes of variables that would connect a process to another graph or to the user's settings.
_FOREIGN = ("ROS_", "RMW_", "ZENOH_", "TELEOPCTL_", "AMENT_", "RUST_LOG", "PYTHONUNBUFFERED")

_RUNTIME = "runtime"
_LOG = "log"

LONGEST_LAUNCH_S = 120.0
"""Time limit of a launch in seconds; a launch without progress fails after 30 s."""

# Seconds that ``teleopctl launch`` may take beyond ``timeout_s``; its own timeout reports more.
_AROUND_LAUNCH_S = 30.0

# Lines of each log in a failure report.
_REPORTED_LINES = 100

# ROS domains of the graphs; graphs that share a router use them one after the other.
_DOMAINS = range(1, 101)

# Two tests may get the same free port; the second test then tries another port.
_START_ATTEMPTS = 3

# Wait before the next harder signal when processes are ended after a test, in seconds.
_PATIENCE_S = 2.0


class RosGraph:
    """Isolated ROS graph for tests, with a router, a ROS domain and folders of its own.

    Processes of the graph and other nodes on the machine do not discover each other. As a context
    manager the graph starts the router and sets this process's environment variables, so that the
    test's own nodes join the graph; at the end it ends all processes that it has started, also
    those in the background.

        with RosGraph(folder) as graph:
            talker = graph.spawn("run teleop_py_pkg simple_publisher")
            talker.wait_for_line("Publishing")

    Args:
        folder: Folder for process records and logs; working directory of the programs.

    Attributes:
        port: TCP port of the router on the loopback interface.
        router: Endpoint of the router, in the format of ``TELEOPCTL_ROUTER``.
        domain: ROS domain ID of the graph.
        variables: Environment variables that make a process join the graph.
        env: Whole environment of the processes: that of this process, without variables of other
            graphs, and with ``variables``.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._processes: list[Process] = []
        self._last_run: subprocess.CompletedProcess[str] | None = None
        self._observer: Observer | None = None
        self._leave: Callable[[], None] | None = None
        self._shared_domains = itertools.cycle(_DOMAINS)
        self._router_owner: RosGraph | None = None
        self._use_port(free_port())

    @property
    def folder(self) -> Path:
        """Folder with the graph's process records and logs, where its programs start."""
        return self._folder

    def _use_port(self, port: int, domain: int | None = None) -> None:
        self.port = port
        self.router = f"tcp/127.0.0.1:{port}"
        self.domain = _DOMAINS[port % len(_DOMAINS)] if domain is None else domain
        self.variables = {
            "TELEOPCTL_ROUTER": self.router,
            # Tests check topics; a test that needs the web page sets viewer:=true.
            "TELEOPCTL_VIEWER": "false",
            "ROS_DOMAIN_ID": str(self.domain),
            "TELEOPCTL_RUNTIME_DIR": str(self.folder / _RUNTIME),
            "ROS_LOG_DIR": str(self.folder / _LOG),
        }
        self.env = dict(os.environ)
        self.join(self.env)

    def _move_to(self, port: int, domain: int | None = None) -> None:
        """Use another port, also in this process if this process is in the graph."""
        is_here = self._has_this_process
        self._use_port(port, domain)
        if is_here:
            self.join(os.environ)

    def __enter__(self) -> RosGraph:
        self.start_router()
        before = dict(os.environ)
        self.join(os.environ)
        self._leave = lambda: _restore(before)
        return self

    def __exit__(self, *_: object) -> None:
        try:
            self.close()
        finally:
            if self._leave is not None:
                self._leave()

    def join(self, environ: MutableMapping[str, str]) -> None:
        """Change environment variables in a mapping so that processes with them join the graph."""
        for name in [name for name in environ if name.startswith(_FOREIGN)]:
            del environ[name]
        environ.update(self.variables)

    def start_router(self) -> background.ProcessRecord:
        """Start the router as ``teleopctl daemon start`` does; return its process record.

        Raises:
            TeleopctlError: The router cannot start.
        """
        for attempt in range(1, _START_ATTEMPTS + 1):
            try:
                return background.start(
                    "router",
                    [sys.executable, "-m", "teleopctl.wire.router", self.router],
                    kind="router",
                    env=self.env,
                    until_ready=StartTimeouts(),
                )
            except TeleopctlError as error:
                if attempt == _START_ATTEMPTS or "in use" not in str(error):
                    raise
                self._move_to(free_port())
        raise AssertionError

    def share_router(self, owner: RosGraph) -> None:
        """Use another graph's router, started if needed, in a ROS domain of this graph's own.

        Neither graph discovers the nodes of the other graph, and ``teleopctl daemon stop`` in this
        graph refuses to stop the router.

        Raises:
            TeleopctlError: The router cannot start.
        """
        records = background.records(owner.folder / _RUNTIME)
        if not any(record.kind == "router" for record in records):
            owner.start_router()
        self._router_owner = owner
        self._move_to(owner.port, next(owner._shared_domains))

    def run(
        self,
        args: Sequence[str] | str,
        timeout: float = LONGEST_WAIT_S,
        *,
        input: str | None = None,  # noqa: A002 - subprocess's word
        cwd: Path | None = None,
    ) -> subprocess.CompletedProcess[str]:
        """Run ``teleopctl ARGS`` to its end; return exit status and output (CompletedProcess)."""
        return self.run_module("teleopctl", args, timeout, input=input, cwd=cwd)

    def spawn(self, args: Sequence[str] | str, *, cwd: Path | None = None) -> Process:
        """Start ``teleopctl ARGS`` and return the `Process`, which `close` kills."""
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
        """Run ``python -m MODULE ARGS`` to its end; return exit status and output."""
        self._last_run = subprocess.run(
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
        return self._last_run

    def spawn_module(
        self, module: str, args: Sequence[str] | str = (), *, cwd: Path | None = None
    ) -> Process:
        """Start ``python -m MODULE ARGS`` and return the `Process`, which `close` kills."""
        return self.spawn_command([sys.executable, "-m", module, *_words(args)], cwd=cwd)

    def spawn_command(self, argv: Sequence[str], *, cwd: Path | None = None) -> Process:
        """Start a program by its command line; return the `Process`, which `close` kills."""
        process = Process(argv, self.env, cwd or self.folder)
        self._processes.append(process)
        return process

    def launch(self, *words: str, timeout_s: float = LONGEST_LAUNCH_S) -> LaunchedSystem:
        """Start a launch file in the background; return the `LaunchedSystem` once all nodes are up.

        The launch ends with the graph, or by `LaunchedSystem.stop`.

        Args:
            words: Arguments as on the command line: ``[PACKAGE] FILE [NAME:=VALUE]…``.
            timeout_s: Time limit in seconds, as ``--timeout`` of ``teleopctl launch``.

        Raises:
            AssertionError: A process died or did not become ready; the message has the output.
        """
        from teleopctl.testing.launched import LaunchedSystem

        before = {record.file for record in self._launches()}
        options = ["--detach", "--timeout", f"{timeout_s:g}"]
        done = self.run(["launch", *options, *words], timeout_s + _AROUND_LAUNCH_S)
        if done.returncode != 0:
            raise AssertionError(
                f"teleopctl launch {shlex.join(words)}: exit status {done.returncode}\n"
                f"{done.stdout}{done.stderr}"
            )
        (record,) = [record for record in self._launches() if record.file not in before]
        return LaunchedSystem(record)

    def _launches(self) -> list[background.ProcessRecord]:
        """Return the records of launches, running or ended."""
        folder = self.folder / _RUNTIME
        # A launch that ends between the two calls is in both results.
        records = {
            r.file: r for r in (*background.records(folder), *background.ended_records(folder))
        }
        return [record for record in records.values() if record.kind == background.LAUNCH]

    @property
    def node(self) -> Node:
        """Node in the test's process, for publishers and clients; a thread spins the node."""
        return self._observing().node

    def wait_for_nodes(self, *names: str, timeout_s: float = LONGEST_WAIT_S) -> None:
        """Wait until nodes with these full names are in the graph; AssertionError on timeout.

        Raises:
            AssertionError: The timeout has passed; the message lists the nodes of the graph.
        """
        self._observing().wait_for_nodes(names, timeout_s)

    def wait_for_message(
        self,
        message_type: type[MessageT],
        topic: str,
        matching: Callable[[MessageT], object] | None = None,
        *,
        qos: QoSProfile | int = 10,
        timeout_s: float = LONGEST_WAIT_S,
    ) -> MessageT:
        """Wait for and return a topic's next message, or the next that satisfies ``matching``.

        Args:
            message_type: Message class of the topic.
            topic: Name of the topic.
            matching: Function called with each message; returns whether the message matches. None
                accepts the first message.
            qos: QoS of the subscription, or its depth; with ``qos_profile_latched`` earlier
                messages count too.
            timeout_s: Longest wait in seconds.

        Raises:
            AssertionError: The timeout has passed; the error has the last received message.
        """
        return self._observing().wait_for_message(
            message_type, topic, matching, qos=qos, timeout_s=timeout_s
        )

    @property
    def _has_this_process(self) -> bool:
        # The port alone may be one that another graph had before.
        return all(
            os.environ.get(name) == self.variables[name]
            for name in ("TELEOPCTL_ROUTER", "TELEOPCTL_RUNTIME_DIR")
        )

    def _observing(self) -> Observer:
        if self._observer is None:
            from teleopctl.testing.observer import Observer

            if not self._has_this_process:
                raise RuntimeError(
                    "This process is not in the graph: use it as a context manager, or the "
                    "fixture ros_graph."
                )
            self._observer = Observer()
        return self._observer

    def reports(self) -> Iterator[tuple[str, str]]:
        """Yield (title, text) pairs for a failure report: last command, processes, ends of logs."""
        if self._router_owner is not None:
            yield from self._router_owner.reports()
        if (last := self._last_run) is not None:
            output = f"{last.stdout}\n{last.stderr}\nstatus: {last.returncode}"
            yield "last command", f"{shlex.join(last.args)}\n{output}"
        for process in self._processes:
            yield f"process {process.pid}", process.report()
        for log_file in sorted((self.folder / _LOG).glob("*.log")):
            text = log_file.read_text(encoding="utf-8", errors="replace")
            if text:
                yield log_file.name, "".join(text.splitlines(keepends=True)[-_REPORTED_LINES:])

    def close(self) -> None:
        """End all processes that the graph has started, and shut down the test process's node.

        The processes are found by the graph's folder, not by environment variables, which a test
        may have changed.
        """
        # Imported only here: more than half of this module's import time.
        from teleopctl.launch import running

        observer, self._observer = self._observer, None
        try:
            if observer is not None:
                observer.close()
        finally:
            for process in self._processes:
                process.kill()
            for entry in running(self.folder / _RUNTIME):
                background.stop(entry.record, patience_s=_PATIENCE_S)


def free_port() -> int:
    """Return the number of a TCP port of the loopback interface that is free at present."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        port: int = server.getsockname()[1]
        return port


def _restore(before: Mapping[str, str]) -> None:
    for name in os.environ.keys() - before.keys():
        del os.environ[name]
    os.environ.update(before)


def _words(args: Sequence[str] | str) -> list[str]:
    return shlex.split(args) if isinstance(args, str) else [str(word) for word in args]
