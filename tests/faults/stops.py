"""Hands that are lost in motion: the robot stops, and does not move by itself when they come back.

``python -m tests.faults.stops [--count 20] [NAME …]`` drives the arm of ``teleopctl drive`` by a
key that is held, causes a fault, and measures until the joints are at rest. Then what was lost
comes back, with the key still held where there is one, and the joints are looked at again. It
prints a table, and the exit status is 1 if an arm was not at rest in time or moved by itself.

Faults: ``device killed`` (the process of the page and its device node), ``tab closed`` (the socket
ends), ``network off`` (the socket falls silent, and goes on later), ``servo killed``.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import signal
import statistics
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import psutil
from websockets.exceptions import ConnectionClosed, InvalidHandshake
from websockets.sync.client import connect
from websockets.sync.connection import Connection

from teleopctl.interfaces import get_message, to_nanoseconds
from teleopctl.node import SILENCE_S, Context, Node, SingleThreadedExecutor
from teleopctl.testing import free_port
from tests.faults.isolation import own_graph

TELEOPCTL = [sys.executable, "-m", "teleopctl"]
# Timeouts of the page's device node and of servo, and the time for braking, s.
_TIMEOUTS_S, _BRAKING_S = 0.2, 0.3
_MOVING, _AT_REST = 0.05, 2e-3  # rad/s
_SEEN_STILL_S, _LOOK_S, _LONGEST_S = 0.2, 1.0, 40.0
_PERIOD_S = 0.02


class Joint:
    """The joint that the key moves: newest velocity, and how long it has been still."""

    def __init__(self, node: Node) -> None:
        self.position = self.velocity = 0.0
        self.time_s = 0.0
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
            self._changed.notify_all()

    def wait(self, is_so: Callable[[], bool], longest_s: float = _LONGEST_S) -> bool:
        """Wait for a condition on the newest state; return whether it came."""
        with self._changed:
            return self._changed.wait_for(is_so, longest_s)

    def rest(self) -> tuple[float, float]:
        """Return simulated time (s) and way (rad) from now to the beginning of rest."""
        begun_s, begun = self.time_s, self.position
        still = [self.time_s, self.position]

        def is_at_rest() -> bool:
            if abs(self.velocity) > _AT_REST:
                still[:] = self.time_s, self.position
            return self.time_s - still[0] > _SEEN_STILL_S

        if not self.wait(is_at_rest):
            return float("inf"), abs(self.position - begun)
        return still[0] - begun_s, abs(still[1] - begun)


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
    browser: Browser = field(init=False)
    # Processes that were started again, which the launch does not end.
    again: list[subprocess.Popen[bytes]] = field(default_factory=list)

    def start(self) -> None:
        """Start ``teleopctl drive`` in the background, and open its page."""
        # A page that is started again has the same address.
        words = [*TELEOPCTL, "drive", "--port", str(free_port()), "--no-open", "-d"]
        done = subprocess.run(words, capture_output=True, text=True, check=True)
        found = re.search(r"^Mouse: +(\S+/drive) ", done.stdout, re.MULTILINE)
        assert found is not None, done.stdout + done.stderr
        self.address = found[1]
        self.browser = Browser(self.address)
        self.browser.wait_until_ready()

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


def _tab_closed(drive: Drive) -> Callable[[], None]:
    drive.browser.close()

    def open_again() -> None:
        drive.browser = Browser(drive.address)

    return open_again


def _network_off(drive: Drive) -> Callable[[], None]:
    drive.browser.is_silent = True

    def on() -> None:
        drive.browser.is_silent = False

    return on


FAULTS: dict[str, Callable[[Drive], Callable[[], None]]] = {
    "device killed": _device_killed,
    "tab closed": _tab_closed,
    "network off": _network_off,
    "servo killed": _servo_killed,
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
            drive.browser.close()
            for process in drive.again:
                process.kill()
                process.wait()
            executor.shutdown()
            context.shutdown()
    sys.exit(1 if wrong else 0)


def _run(drive: Drive, name: str, count: int) -> int:
    """Cause a fault many times; return how often something was wrong."""
    rests: list[float] = []
    ways: list[float] = []
    late = moved = 0
    for number in range(count):
        rest_s, way, crept = _once(drive, name, "ArrowRight" if number % 2 else "ArrowLeft")
        rests.append(rest_s)
        ways.append(way)
        late += rest_s > _TIMEOUTS_S + _BRAKING_S
        moved += crept > _AT_REST
        print(
            f"  {name} {number + 1}: at rest after {rest_s:.3f} s and {way:.3f} rad, "
            f"then {crept:.4f} rad",
            flush=True,
        )
    print(
        f"{name:14} {count} times: at rest after {statistics.median(rests):.3f} s (p50), "
        f"{max(rests):.3f} s (longest), {max(ways):.3f} rad at most; late {late}, "
        f"moved by itself {moved}",
        flush=True,
    )
    return late + moved


def _once(drive: Drive, name: str, key: str) -> tuple[float, float, float]:
    """Return time and way to rest after a fault, and the way when what was lost is back."""
    joint = drive.joint
    drive.browser.wait_until_ready()
    drive.browser.keys = []
    joint.wait(lambda: abs(joint.velocity) < _AT_REST)
    time.sleep(2 * _PERIOD_S)
    drive.browser.keys = [key]
    if not joint.wait(lambda: abs(joint.velocity) > _MOVING):
        raise SystemExit(f"The arm does not move: {drive.browser.state}")
    time.sleep(0.3)
    come_back = FAULTS[name](drive)
    rest_s, way = joint.rest()
    at = joint.position
    time.sleep(SILENCE_S + 0.3)  # until a silent hand's lease has ended
    come_back()
    drive.browser.wait_until_ready()
    end_s = joint.time_s + _LOOK_S
    crept = 0.0

    def has_looked() -> bool:
        nonlocal crept
        crept = max(crept, abs(joint.position - at))
        return joint.time_s > end_s

    joint.wait(has_looked)
    return rest_s, way, crept


if __name__ == "__main__":
    main()
