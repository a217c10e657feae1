"""Hands that are lost in motion: the robot stops, and does not move by itself when they come back.

``python -m tests.faults.stops [--count 20] [NAME …]`` drives the arm of ``teleopctl drive`` by a
hand, causes a fault, and measures until the joints are at rest. Then what was lost comes back, with
the key still held where there is one, and the joints are looked at for a time after each. It prints
a table, and the exit status is 1 if an arm was not at rest in time or moved by itself.

Faults of a held key: ``device killed`` and ``device frozen`` (the process of the page and its
device node; SIGKILL, SIGSTOP), ``tab closed`` (the socket ends), ``network off`` (the socket falls
silent, and goes on later), ``servo killed``, ``servo frozen``. Of a gamepad's stick: ``gamepad
killed``, ``gamepad frozen``, ``gamepad unplugged``. Of a key in Chromium: ``browser closed``,
``browser offline`` (nothing passes between it and the page, what was sent comes later).
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import re
import signal
import socket
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, Protocol
from urllib.parse import urlsplit

import psutil
from websockets.exceptions import ConnectionClosed, InvalidHandshake
from websockets.sync.client import connect
from websockets.sync.connection import Connection

from teleopctl.interfaces import get_message, to_nanoseconds
from teleopctl.node import SILENCE_S, Context, Node, SingleThreadedExecutor
from teleopctl.testing import free_port
from tests.emulated_gamepad import EmulatedGamepad
from tests.faults.isolation import own_graph
from tests.system.browser import browser, open_page

TELEOPCTL = [sys.executable, "-m", "teleopctl"]
# Timeouts of the page's device node and of servo, and the time for braking, s.
_TIMEOUTS_S, _BRAKING_S = 0.2, 0.3
_MOVING, _AT_REST = 0.05, 2e-3  # rad/s
_SEEN_STILL_S, _LOOK_S, _LONGEST_S = 0.5, 3.0, 40.0
# Time until it has been seen that the hand has let go, also on a busy machine, s.
_PERIOD_S, _LET_GO_S = 0.02, 0.4


class Joint:
    """The joint that the key moves: newest velocity, and how long it has been still."""

    def __init__(self, node: Node) -> None:
        self.position = self.velocity = 0.0
        self.time_s = 0.0
        # Range of the positions since it was last set.
        self.least = self.most = 0.0
        # Simulated time and position at the mark, and at the newest state that moved after it.
        self._begun = self._moved = (0.0, 0.0)
        self._changed = threading.Condition()
        node.create_subscription(
            get_message("sensor_msgs/msg/JointState"), "/joint_states", self._on_state, 10
        )

    # Any: message classes are generated at run time.
    def _on_state(self, message: Any) -> None:
        position = message.position[list(message.name).index("joint_1")]
        time_s = to_nanoseconds(message.header.stamp) * 1e-9
        with self._changed:
            if time_s > self.time_s:
                self.velocity = (position - self.position) / (time_s - self.time_s)
            self.position, self.time_s = position, time_s
            # Noted here, since the thread that waits may be late.
            if abs(self.velocity) > _AT_REST:
                self._moved = (time_s, position)
            self.least, self.most = min(self.least, position), max(self.most, position)
            self._changed.notify_all()

    def wait(self, is_so: Callable[[], bool], longest_s: float = _LONGEST_S) -> bool:
        """Wait for a condition on the newest state; return whether it came."""
        with self._changed:
            return self._changed.wait_for(is_so, longest_s)

    def look(self, duration_s: float) -> float:
        """Return the largest way (rad) between two positions of a simulated time."""
        self.least = self.most = self.position
        end_s = self.time_s + duration_s
        self.wait(lambda: self.time_s > end_s)
        return self.most - self.least

    def mark(self) -> None:
        """Set the beginning of what `rest` measures."""
        with self._changed:
            self._begun = self._moved = (self.time_s, self.position)

    def rest(self) -> tuple[float, float]:
        """Return simulated time (s) and way (rad) from the mark to the beginning of rest."""
        begun_s, begun = self._begun
        if not self.wait(lambda: self.time_s - self._moved[0] > _SEEN_STILL_S):
            return float("inf"), abs(self.position - begun)
        moved_s, moved = self._moved
        return moved_s - begun_s, abs(moved - begun)


class Hand(Protocol):
    """Way in which the arm is turned."""

    def wait_until_ready(self) -> None:
        """Wait until the robot can be driven."""

    def hold(self, direction: int) -> None:
        """Turn the arm to a side, 1 or -1, from now on; 0 lets go."""

    def close(self) -> None:
        """End it."""


class Pad:
    """A gamepad and its device node.

    Args:
        folder: Folder for the gamepad's file.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._number = 0
        self.start()

    def start(self) -> None:
        """Plug a gamepad in, and start the node that reads it."""
        self._number += 1
        self.pad = EmulatedGamepad(self._folder / f"js{self._number}")
        words = [*TELEOPCTL, "run", "teleop_device", "teleop_device", "gamepad"]
        words += ["--ros-args", "-p", f"dev:={self.pad.path}"]
        nowhere = subprocess.DEVNULL
        self.process = subprocess.Popen(words, stdout=nowhere, stderr=nowhere)

    def wait_until_ready(self) -> None:
        """Do nothing: the first motion is waited for."""

    def hold(self, direction: int) -> None:
        """Push the stick to a side with the enabling button, or let go of both."""
        self.pad.axis(0, float(direction))
        self.pad.button(4, is_down=direction != 0)

    def close(self) -> None:
        """End the node."""
        self.process.send_signal(signal.SIGCONT)
        self.process.kill()
        self.process.wait()


class Pipe:
    """Passes what two sides send each other, but for a time in which it is blocked.

    Args:
        port: Port of the server on this machine.

    Attributes:
        is_blocked: Whether nothing passes: what is sent meanwhile comes later.
        port: Port to connect to.
    """

    def __init__(self, port: int) -> None:
        self._target = port
        self.is_blocked = False
        self._server = socket.create_server(("127.0.0.1", 0))
        self.port = int(self._server.getsockname()[1])
        threading.Thread(target=self._accept, daemon=True).start()

    def close(self) -> None:
        """Accept no more connections."""
        self._server.close()

    def _accept(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                one, _ = self._server.accept()
                other = socket.create_connection(("127.0.0.1", self._target))
                for source, sink in ((one, other), (other, one)):
                    threading.Thread(target=self._pass, args=(source, sink), daemon=True).start()

    def _pass(self, source: socket.socket, sink: socket.socket) -> None:
        with contextlib.suppress(OSError):
            while data := source.recv(65536):
                while self.is_blocked:
                    time.sleep(_PERIOD_S)
                sink.sendall(data)
        for each in (source, sink):
            with contextlib.suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)


class Chromium:
    """The drive page in Chromium, through a pipe.

    Args:
        address: Address of the page.
    """

    def __init__(self, address: str) -> None:
        port = int(re.findall(r":(\d+)/", address)[0])
        self.pipe = Pipe(port)
        self._address = address.replace(str(port), str(self.pipe.port))
        self._running = browser()
        self._browser = self._running.__enter__()
        self._key = ""
        self.open()

    def open(self) -> None:
        """Open the page in a tab."""
        self._key = ""
        # Without the 3D view, whose pictures are drawn by the processor here.
        self.page = open_page(self._browser, "about:blank")
        self.page.route(lambda url: urlsplit(url).path == "/", lambda route: route.abort())
        self.page.goto(self._address)

    def wait_until_ready(self) -> None:
        """Wait until the robot can be driven."""
        ready = "typeof state == 'object' && state.robot && !state.problem"
        self.page.wait_for_function(ready, timeout=1e3 * _LONGEST_S)

    def hold(self, direction: int) -> None:
        """Press an arrow key, or let go of it."""
        if self._key:
            self.page.keyboard.up(self._key)
        self._key = {1: "ArrowRight", -1: "ArrowLeft", 0: ""}[direction]
        if self._key:
            self.page.keyboard.down(self._key)

    def close(self) -> None:
        """End the browser."""
        self._running.__exit__(None, None, None)
        self.pipe.close()


class Browser:
    """What a browser with the drive page sends: a key that is held, 50 times a second.

    Attributes:
        keys: Keys that are held.
        is_silent: Whether the network is off: nothing arrives, and the socket stays open.
    """

    def __init__(self, address: str) -> None:
        self._address = re.sub("^http", "ws", address) + "/socket"
        self.keys: list[str] = []
        self.is_silent = False
        self.state: dict[str, Any] = {}
        self._ended = False
        self._socket: Connection | None = None
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def wait_until_ready(self) -> None:
        """Wait until the robot can be driven."""
        end_s = time.monotonic() + _LONGEST_S
        while not self.state or self.state["problem"] or self.state["opening"] is None:
            if time.monotonic() > end_s:
                raise SystemExit(f"The page is not ready: {self.state.get('problem')}")
            time.sleep(0.05)

    def hold(self, direction: int) -> None:
        """Press an arrow key, or let go of it."""
        self.keys = {1: ["ArrowRight"], -1: ["ArrowLeft"], 0: []}[direction]

    def close(self) -> None:
        """Close the tab."""
        self._ended = True
        if self._socket is not None:
            self._socket.close()
        self._thread.join()

    def _run(self) -> None:
        while not self._ended:
            try:
                with connect(self._address, open_timeout=5) as socket:
                    self._socket = socket
                    threading.Thread(target=self._read, args=[socket], daemon=True).start()
                    self._send(socket)
            except (ConnectionClosed, InvalidHandshake, OSError, TimeoutError):
                # As the page does: what is not seen to be released counts as released.
                self.keys, self.state = [], {}
                time.sleep(0.1)

    def _send(self, socket: Connection) -> None:
        sequence = 0
        while not self._ended:
            sequence += 1
            if not self.is_silent:
                socket.send(json.dumps({"type": "hands", "sequence": sequence, "keys": self.keys}))
            time.sleep(_PERIOD_S)

    def _read(self, socket: Connection) -> None:
        try:
            for text in socket:
                message = json.loads(text)
                if message["type"] == "state":
                    self.state = message
        except ConnectionClosed:
            pass


@dataclass
class Drive:
    """The running command, a browser, and the joint."""

    joint: Joint
    address: str = ""
    # The hand that is used now.
    hand: Hand = field(init=False)
    # Processes that were started again, which the launch does not end.
    again: list[subprocess.Popen[bytes]] = field(default_factory=list)

    def start(self) -> None:
        """Start ``teleopctl drive`` in the background."""
        # A page that is started again has the same address.
        words = [*TELEOPCTL, "drive", "--port", str(free_port()), "--no-open", "-d"]
        done = subprocess.run(words, capture_output=True, text=True, check=True)
        found = re.search(r"^Mouse: +(\S+/drive) ", done.stdout, re.MULTILINE)
        assert found is not None, done.stdout + done.stderr
        self.address = found[1]

    def process(self, executable: str) -> psutil.Process:
        """Return the process of an executable of the launch."""
        for process in psutil.process_iter(["cmdline", "environ"]):
            words = process.info["cmdline"] or []
            own = (process.info["environ"] or {}).get("TELEOPCTL_ROUTER")
            if own == os.environ["TELEOPCTL_ROUTER"] and executable in words:
                return process
        raise SystemExit(f"There is no process {executable}")

    def restart(self, executable: str) -> Callable[[], None]:
        """Kill a process; return what starts it again with the same words."""
        process = self.process(executable)
        words, environment = process.cmdline(), process.environ()
        # The end of a process is noticed late on a busy machine.
        self.joint.mark()
        process.send_signal(signal.SIGKILL)
        process.wait(10)

        def start() -> None:
            nowhere = subprocess.DEVNULL
            process = subprocess.Popen(words, env=environment, stdout=nowhere, stderr=nowhere)
            self.again.append(process)

        return start


def _device_killed(drive: Drive) -> Callable[[], None]:
    return drive.restart("rviz2")


def _servo_killed(drive: Drive) -> Callable[[], None]:
    return drive.restart("servo_node")


def _frozen(drive: Drive, executable: str) -> Callable[[], None]:
    process = drive.process(executable)
    drive.joint.mark()
    process.send_signal(signal.SIGSTOP)
    return lambda: process.send_signal(signal.SIGCONT)


def _tab_closed(drive: Drive) -> Callable[[], None]:
    drive.hand.close()

    def open_again() -> None:
        drive.hand = Browser(drive.address)

    return open_again


def _network_off(drive: Drive) -> Callable[[], None]:
    hand = drive.hand
    assert isinstance(hand, Browser)
    hand.is_silent = True

    def on() -> None:
        hand.is_silent = False

    return on


def _pad_killed(drive: Drive) -> Callable[[], None]:
    hand = drive.hand
    assert isinstance(hand, Pad)
    hand.process.kill()
    hand.process.wait()
    return hand.start


def _pad_frozen(drive: Drive) -> Callable[[], None]:
    hand = drive.hand
    assert isinstance(hand, Pad)
    hand.process.send_signal(signal.SIGSTOP)

    def go_on() -> None:
        hand.process.send_signal(signal.SIGCONT)
        hand.hold(0)

    return go_on


def _pad_unplugged(drive: Drive) -> Callable[[], None]:
    hand = drive.hand
    assert isinstance(hand, Pad)
    hand.pad.unplug()

    def start_again() -> None:
        hand.close()
        hand.start()

    return start_again


def _browser_closed(drive: Drive) -> Callable[[], None]:
    hand = drive.hand
    assert isinstance(hand, Chromium)
    hand.page.close()
    return hand.open


def _browser_offline(drive: Drive) -> Callable[[], None]:
    hand = drive.hand
    assert isinstance(hand, Chromium)
    hand.pipe.is_blocked = True

    def on() -> None:
        hand.pipe.is_blocked = False

    return on


# The hand of each fault, and what causes it; that returns what brings back what was lost.
FAULTS: dict[str, tuple[type[Hand], Callable[[Drive], Callable[[], None]]]] = {
    "device killed": (Browser, _device_killed),
    "device frozen": (Browser, partial(_frozen, executable="rviz2")),
    "tab closed": (Browser, _tab_closed),
    "network off": (Browser, _network_off),
    "servo killed": (Browser, _servo_killed),
    "servo frozen": (Browser, partial(_frozen, executable="servo_node")),
    "gamepad killed": (Pad, _pad_killed),
    "gamepad frozen": (Pad, _pad_frozen),
    "gamepad unplugged": (Pad, _pad_unplugged),
    "browser closed": (Chromium, _browser_closed),
    "browser offline": (Chromium, _browser_offline),
}


def main() -> None:
    """Cause all faults; print a row for each kind."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help="parts of names of faults")
    parser.add_argument("--count", type=int, default=20, help="times of each")
    options = parser.parse_args()
    wanted = [
        name for name in FAULTS if not options.names or any(part in name for part in options.names)
    ]
    wrong = 0
    with own_graph():
        context = Context()
        context.init()
        node = Node("witness", context=context)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        threading.Thread(target=executor.spin, daemon=True).start()
        drive = Drive(Joint(node))
        drive.start()
        try:
            for name in wanted:
                wrong += _run(drive, name, options.count)
        finally:
            for process in drive.again:
                process.kill()
                process.wait()
            executor.shutdown()
            context.shutdown()
    sys.exit(1 if wrong else 0)


def _run(drive: Drive, name: str, count: int) -> int:
    """Cause a fault many times; return how often something was wrong."""
    with tempfile.TemporaryDirectory() as folder:
        kind = FAULTS[name][0]
        drive.hand = Pad(Path(folder)) if kind is Pad else kind(drive.address)  # type: ignore[call-arg]
        try:
            return _run_with(drive, name, count)
        finally:
            drive.hand.close()


def _run_with(drive: Drive, name: str, count: int) -> int:
    rests: list[float] = []
    ways: list[float] = []
    late = moved = 0
    for number in range(count):
        rest_s, way, crept, moved_back = _once(drive, name, 1 if number % 2 else -1)
        rests.append(rest_s)
        ways.append(way)
        late += rest_s > _TIMEOUTS_S + _BRAKING_S
        moved += max(crept, moved_back) > _AT_REST
        print(
            f"  {name} {number + 1}: at rest after {rest_s:.3f} s and {way:.3f} rad, "
            f"then {crept:.4f} rad, and when it is back {moved_back:.4f} rad",
            flush=True,
        )
    print(
        f"{name:14} {count} times: at rest after {statistics.median(rests):.3f} s (p50), "
        f"{max(rests):.3f} s (longest), {max(ways):.3f} rad at most; late {late}, "
        f"moved by itself {moved}",
        flush=True,
    )
    return late + moved


def _once(drive: Drive, name: str, direction: int) -> tuple[float, float, float, float]:
    """Return time and way to rest after a fault, the way then, and when what was lost is back."""
    joint = drive.joint
    drive.hand.wait_until_ready()
    drive.hand.hold(0)
    joint.wait(lambda: abs(joint.velocity) < _AT_REST)
    time.sleep(_LET_GO_S)
    drive.hand.hold(direction)
    if not joint.wait(lambda: abs(joint.velocity) > _MOVING):
        raise SystemExit("The arm does not move")
    time.sleep(0.3)
    # A busy machine may hold a hand up for a moment.
    if not joint.wait(lambda: abs(joint.velocity) > _MOVING):
        raise SystemExit("The arm moves no more")
    joint.mark()
    come_back = FAULTS[name][1](drive)
    rest_s, way = joint.rest()
    # Longer than a silent hand's lease.
    crept = joint.look(max(_LOOK_S, SILENCE_S + 0.5))
    come_back()
    drive.hand.wait_until_ready()
    return rest_s, way, crept, joint.look(_LOOK_S)


if __name__ == "__main__":
    main()
