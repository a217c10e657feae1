"""From a hand to the joints' command, and what device and drive page take of a core.

A hand turns back and forth, on the drive page's websocket and on ``/joy``; each time the first
trajectory of servo that turns with it is waited for. Servo has 100 Hz, as the bare loop beside it,
which only looks for a value that another thread sets: it shows what the machine itself adds. Times
are of one clock, of the moment at which the hand's message is sent and servo's is received.

The floor of the processor's share is `tests.benchmarks.drive_floor`: the same messages at the same
rate by Zenoh and websockets alone; both are measured in turns.
"""

from __future__ import annotations

import bisect
import contextlib
import json
import math
import os
import re
import statistics
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import psutil
import pytest
import zenoh
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect
from websockets.sync.connection import Connection

from teleopctl.interfaces import get_message, get_service
from teleopctl.testing import RosGraph, eventually, free_port
from tests.benchmarks.figure import Figure

TURNS = 150
PERIOD_S, SERVO_S = 0.02, 0.01
WINDOW_S = 10.0
DEVICE_AIM, PAGE_AIM = "p50 15, p99 30 ms", "p50 25, p99 50 ms"
COMMANDS = "/arm_controller/joint_trajectory"
LEADER_HZ, SWING, SWING_HZ = 60, 0.15, 0.4
# Longest time from the receipt of a command to the publication of a step that does not have it yet.
STEP_NS = 1_000_000
Turn = Callable[[int], None]


class Hand:
    """A hand that turns: sends its state each 20 ms and at once with each turn."""

    def __init__(self, send: Turn) -> None:
        self._send, self._sign = send, 0
        self._lock = threading.Lock()
        self._ended = threading.Event()
        threading.Thread(target=self._run, daemon=True).start()

    def turn(self, sign: int) -> None:
        """Turn to a side, 1 or -1; 0 lets go."""
        with self._lock:
            self._sign = sign
            self._send(sign)

    def end(self) -> None:
        """Send nothing any more."""
        self._ended.set()

    def _run(self) -> None:
        with contextlib.suppress(ConnectionClosed):
            while not self._ended.wait(PERIOD_S):
                with self._lock:
                    self._send(self._sign)


class Commands:
    """Servo's commands of the joint that turns: the change of its steps."""

    def __init__(self, ros: RosGraph) -> None:
        self._last = self._step = 0.0
        self._wanted = 0
        self._came_ns = 0
        self._came = threading.Condition()
        kind = get_message("trajectory_msgs/msg/JointTrajectory")
        ros.node.create_subscription(kind, COMMANDS, self._take, 10)

    # Any: message classes are generated at run time.
    def _take(self, message) -> None:
        now_ns = time.monotonic_ns()
        with self._came:
            if not message.points:
                return
            position = message.points[-1].positions[list(message.joint_names).index("joint_1")]
            # Servo's commands are a period apart.
            step, self._last = position - self._last, position
            change, self._step = step - self._step, step
            if self._wanted and change * self._wanted > 1e-5:
                self._wanted, self._came_ns = 0, now_ns
                self._came.notify_all()

    def after(self, act: Callable[[], None], sign: int) -> float:
        """Act; return the time in ms until the first command that changes to a side."""
        with self._came:
            self._wanted, self._came_ns = sign, 0
        begun_ns = time.monotonic_ns()
        act()
        with self._came:
            assert self._came.wait_for(lambda: self._came_ns, 5.0), "no command has come"
            return (self._came_ns - begun_ns) * 1e-6


def latencies(hand: Hand, commands: Commands) -> list[float]:
    """Turn a hand back and forth; return the times to servo's commands in ms."""
    found = []
    hand.turn(1)
    time.sleep(0.5)
    for number in range(TURNS):
        sign = -1 if number % 2 == 0 else 1
        found.append(commands.after(partial(hand.turn, sign), sign))
        # At any phase of servo's period, and long enough to be at the speed again.
        time.sleep(0.15 + 0.0013 * (number % 8))
    hand.turn(0)
    return found


def bare_latencies() -> list[float]:
    """Return times in ms until a loop at servo's rate sees what another thread has set."""
    wanted, found = [0], []
    seen = threading.Condition()
    ended = threading.Event()

    def loop() -> None:
        last, due = 0, time.monotonic()
        while not ended.is_set():
            due += SERVO_S
            time.sleep(max(0.0, due - time.monotonic()))
            if wanted[0] != last:
                last = wanted[0]
                with seen:
                    found.append(time.monotonic_ns())
                    seen.notify_all()

    threading.Thread(target=loop, daemon=True).start()
    times = []
    for number in range(1, TURNS + 1):
        time.sleep(0.02 + 0.0013 * (number % 8))
        begun_ns = time.monotonic_ns()
        wanted[0] = number
        with seen:
            assert seen.wait_for(partial(_has, found, number), 5.0)
        times.append((found[-1] - begun_ns) * 1e-6)
    ended.set()
    return times


def _has(found: list[int], count: int) -> bool:
    return len(found) >= count


def texts(times: list[float]) -> str:
    p50, p99 = statistics.median(times), statistics.quantiles(times, n=100)[98]
    return f"p50 {p50:.1f}, p99 {p99:.1f} ms"


def share(process: psutil.Process) -> float:
    """Return what a process takes of a core, as a part, over a window."""
    used = sum(process.cpu_times()[:2])
    time.sleep(WINDOW_S)
    return (sum(process.cpu_times()[:2]) - used) / WINDOW_S


@contextlib.contextmanager
def floor(ros: RosGraph, kind: str, source: str) -> Iterator[psutil.Process]:
    """Run the floor of a device or a page; what it puts is received once, as by servo."""
    key = "floor_of_drive/twist"
    received = ros.node.context.session.declare_subscriber(key, zenoh.handlers.RingChannel(1))
    words = [sys.executable, "-m", "tests.benchmarks.drive_floor", kind, source, key]
    with subprocess.Popen(words, env={**os.environ, **ros.env}) as process:
        try:
            yield psutil.Process(process.pid)
        finally:
            process.kill()
    received.undeclare()


def shares(ours: psutil.Process, bare: psutil.Process) -> tuple[list[float], list[float]]:
    """Return shares of a core of a process and of its floor, in turns."""
    pairs = [(share(ours), share(bare)) for _ in range(3)]
    return [each for each, _ in pairs], [each for _, each in pairs]


def share_figure(subject: str, ours: list[float], bare: list[float]) -> Figure:
    return Figure(
        subject,
        f"{statistics.median(ours):.3f} ({min(ours):.3f} to {max(ours):.3f})",
        f"{statistics.median(bare):.3f}",
        statistics.median(ours) / statistics.median(bare),
    )


@pytest.fixture
def address(ros: RosGraph) -> Iterator[str]:
    """The running command's page."""
    process = ros.spawn("drive --port 0 --no-open")
    yield process.wait_for_line(r"^Mouse: +(\S+/drive) ")[1]
    process.interrupt()
    process.wait()


def process_with(ros: RosGraph, word: str) -> psutil.Process:
    """Return the process of this graph that has a word on its command line."""
    router = ros.env["TELEOPCTL_ROUTER"]
    for process in psutil.process_iter(["cmdline", "environ"]):
        is_own = (process.info["environ"] or {}).get("TELEOPCTL_ROUTER") == router
        if is_own and word in (process.info["cmdline"] or []):
            return process
    raise AssertionError(f"no process has {word}")


# Any: values of a JSON document.
def hands(sequence: int, sign: int) -> dict[str, Any]:
    """Return the drive page's message of an arrow key, 1 or -1, or of none."""
    keys = {0: [], 1: ["ArrowLeft"], -1: ["ArrowRight"]}[sign]
    return {"type": "hands", "sequence": sequence, "keys": keys}


def connection_to(port: int) -> Connection:
    """Return a connection to a server that starts."""
    while True:
        try:
            return connect(f"ws://127.0.0.1:{port}")
        except OSError:
            time.sleep(0.05)


@pytest.mark.timeout(300)
def test_page(ros: RosGraph, address: str, figures: list[Figure]):
    commands = Commands(ros)
    page_process = process_with(ros, "rviz2")
    alone = share(page_process)
    with connect(f"{re.sub('^http', 'ws', address)}/socket") as page:
        state: dict[str, object] = {}

        def read() -> None:
            with contextlib.suppress(ConnectionClosed):
                for text in page:
                    state.update(json.loads(text))

        threading.Thread(target=read, daemon=True).start()
        eventually(lambda: state.get("opening") is not None and not state["problem"])
        sequence = 0

        def send(sign: int) -> None:
            nonlocal sequence
            sequence += 1
            page.send(json.dumps(hands(sequence, sign)))

        hand = Hand(send)
        found = latencies(hand, commands)
        bare = bare_latencies()
        hand.turn(1)
        port = free_port()
        with (
            floor(ros, "page", str(port)) as bare_process,
            connection_to(port) as floor_page,
        ):
            floor_hand = Hand(lambda sign: floor_page.send(json.dumps(hands(0, sign))))
            driving, floors = shares(page_process, bare_process)
            floor_hand.end()
        hand.end()
    figures += [
        Figure(
            f"page to joint command ({PAGE_AIM})",
            texts(found),
            texts(bare),
            statistics.median(found) / statistics.median(bare),
        ),
        share_figure(
            "/drive while a key is held, of a core (aim 0.05)",
            [each - alone for each in driving],
            floors,
        ),
    ]


@pytest.mark.timeout(300)
def test_device(ros: RosGraph, address: str, figures: list[Figure]):
    del address
    commands = Commands(ros)
    kind = get_message("sensor_msgs/msg/Joy")
    publisher = ros.node.create_publisher(kind, "/joy", 1)
    device = ros.spawn("run teleop_device teleop_device joy")
    eventually(lambda: publisher.get_subscription_count() == 1)
    joy = kind(axes=[0.0] * 8, buttons=[0] * 11)
    joy.buttons[4] = 1

    def send(sign: int) -> None:
        joy.axes[0] = float(sign)
        publisher.publish(joy)

    hand = Hand(send)
    found = latencies(hand, commands)
    bare = bare_latencies()
    hand.turn(1)
    with floor(ros, "joy", publisher.key) as bare_process:
        eventually(lambda: sum(bare_process.cpu_times()[:2]) > 0.3)
        taken, floors = shares(psutil.Process(device.pid), bare_process)
    hand.end()
    device.interrupt()
    device.wait()
    figures += [
        Figure(
            f"device to joint command ({DEVICE_AIM})",
            texts(found),
            texts(bare),
            statistics.median(found) / statistics.median(bare),
        ),
        share_figure("device while a stick is held, of a core (aim 0.02)", taken, floors),
    ]


class Leader:
    """An arm that swings, 60 times a second, and what servo makes of its states."""

    def __init__(self, ros: RosGraph, at: dict[str, float]) -> None:
        self._at, self._began_s = at, time.monotonic()
        kind = get_message("sensor_msgs/msg/JointState")
        self._state = kind(name=list(at))
        self._publisher = ros.node.create_publisher(kind, "/leader/joint_states", 1)
        # Times of samples, of the device's commands, and of servo's, ns.
        self.samples: list[int] = []
        self.jogs: list[int] = []
        self.commands: list[int] = []
        for type_name, topic, times in (
            ("control_msgs/msg/JointJog", "/servo_node/delta_joint_cmds", self.jogs),
            ("trajectory_msgs/msg/JointTrajectory", COMMANDS, self.commands),
        ):
            ros.node.create_subscription(
                get_message(type_name),
                topic,
                lambda _, info, times=times: times.append(info["source_timestamp"]),
                100,
            )
        self.ended = threading.Event()
        threading.Thread(target=self._run, daemon=True).start()

    def _run(self) -> None:
        due_s = self._began_s
        while not self.ended.is_set():
            turned = SWING * math.sin(math.tau * SWING_HZ * (due_s - self._began_s))
            self._state.position = [
                value + (turned if name == "joint_1" else 0.0) for name, value in self._at.items()
            ]
            self.samples.append(time.time_ns())
            self._publisher.publish(self._state)
            due_s += 1 / LEADER_HZ
            time.sleep(max(0.0, due_s - time.monotonic()))

    def ages(self) -> list[float]:
        """Return the age of each sample in the first command that is made from it, ms."""
        found = []
        for jog_ns in self.jogs:
            sample_ns = self.samples[bisect.bisect(self.samples, jog_ns) - 1]
            # A step that had begun when the jog came does not count.
            number = bisect.bisect(self.commands, jog_ns + STEP_NS)
            if number < len(self.commands):
                found.append((self.commands[number] - sample_ns) * 1e-6)
        return found


@pytest.mark.timeout(300)
def test_leader(ros: RosGraph, address: str, figures: list[Figure]):
    del address
    states: list[Any] = []
    kind = get_message("sensor_msgs/msg/JointState")
    ros.node.create_subscription(kind, "/joint_states", states.append, 1)
    eventually(lambda: states)
    leader = Leader(ros, dict(zip(states[-1].name, states[-1].position, strict=True)))
    device = ros.spawn("run teleop_device teleop_device --leader /leader")
    engage = get_service("std_srvs/srv/SetBool")
    client = ros.node.create_client(engage, "/teleop_device/engage")
    assert client.wait_for_service(60.0)

    def is_engaged() -> bool:
        response = client.call(engage.Request(data=True), 10.0)
        return response is not None and response.success

    eventually(is_engaged)
    eventually(lambda: len(leader.jogs) > 100)
    leader.jogs.clear()
    time.sleep(2 * WINDOW_S)
    found = leader.ages()
    bare = bare_latencies()
    leader.ended.set()
    device.interrupt()
    device.wait()
    figures.append(
        Figure(
            f"leader at {LEADER_HZ} Hz: age in the first command (p50 8 ms)",
            texts(found),
            texts(bare),
            statistics.median(found) / statistics.median(bare),
        )
    )
