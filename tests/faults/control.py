"""Faults of hardware, controllers, simulators and reloads while an arm follows a goal.

``python -m tests.faults.control [NAME …]`` prints a table: what the joints do, the line of the log
that explains it, how the goal ends, the control cycles missed, and the same with ``/stop`` after
and before the fault. The exit status is 1 if something is not as it should be.

Each trial starts the launch files anew, with hardware and a controller that a file makes fail.
"""

from __future__ import annotations

import argparse
import contextlib
import itertools
import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import psutil

from teleopctl.interfaces import get_action, get_message, get_service, to_nanoseconds
from teleopctl.node import (
    ActionClient,
    Context,
    GoalState,
    Node,
    SingleThreadedExecutor,
    StopButton,
    qos_profile_latched,
)
from tests.faults.isolation import own_graph

_JOINTS = ["joint_1", "joint_2", "joint_3"]
_WAY, _SECONDS = 1.2, 8
_RATE = 100
# Longest waits, in seconds.
_LONGEST_S = 40.0
_EXPLAINED_WITHIN_S = 15.0
# Time in which joints come to rest, and for which they are looked at, in seconds.
_LOOK_S = 2.0
_AT_REST = 2e-3
# Any, in this module: messages, whose classes are made at run time.

_FollowJointTrajectory = get_action("control_msgs/action/FollowJointTrajectory")

_CONTROLLERS = f"""\
controller_manager:
  ros__parameters:
    update_rate: {_RATE}
    cycle_timeout: CYCLE_TIMEOUT
    joint_state_broadcaster: {{type: joint_state_broadcaster/JointStateBroadcaster}}
    arm_controller: {{type: joint_trajectory_controller/JointTrajectoryController}}
    mine: {{type: "my_controller:Mine"}}
arm_controller:
  ros__parameters:
    joints: [joint_1, joint_2, joint_3]
    command_interfaces: [position]
    state_interfaces: [position]
"""
_HARDWARE = """\
import math
import pathlib
import time

from teleopctl.control.hardware.mock import GenericSystem

FAULT = pathlib.Path(__file__).with_name("fault")


class Faulty(GenericSystem):
    def fault(self, method):
        name = FAULT.read_text() if FAULT.exists() else ""
        if name == f"{method} raises":
            raise OSError("the bus does not answer")
        if name == f"{method} blocks":
            FAULT.unlink()
            time.sleep(1.7)
        if name == f"{method} hangs":
            time.sleep(1000)
        return name

    def read(self, time_ns, period):
        outcome = super().read(time_ns, period)
        if self.fault("read") == "NaN":
            self.state_interfaces["joint_2/position"].value = math.nan
        return outcome

    def write(self, time_ns, period):
        self.fault("write")
        return super().write(time_ns, period)
"""
_CONTROLLER = """\
import pathlib
import time

from teleopctl.control import ControllerInterface

FAULT = pathlib.Path(__file__).with_name("fault")


class Mine(ControllerInterface):
    def on_init(self):
        pass

    def on_configure(self):
        pass

    def update(self, time_ns, period):
        if FAULT.exists():
            name = FAULT.read_text()
            if name == "controller raises":
                raise ValueError("no such joint")
            if name == "controller sleeps":
                FAULT.unlink()
                time.sleep(1.7)
            if name == "controller hangs":
                time.sleep(1000)
"""


@dataclass(frozen=True)
class Fault:
    """Fault that is caused while the arm moves, and the expected behaviour.

    Attributes:
        name: Name of the fault in the table.
        launch: Launch file and its arguments.
        cause: Function that causes the fault in a trial.
        explanation: Expression that exactly one line of log or command matches.
        joints: What the joints should do: ``hold``, ``follow`` the goal, or ``end`` with the
            process that moves them.
        goal: How the goal should end: ``ABORTED`` with a text, or ``goes on``; ``server gone``.
        obeys: Whether the manager confirms a stop after the fault.
        timeout_s: Parameter ``cycle_timeout`` of the manager, in seconds.
        repair: Function that ends the fault, after which a goal must succeed; None if nothing can.
    """

    name: str
    launch: str
    cause: Callable[[Trial], None]
    explanation: str
    joints: str = "hold"
    goal: str = "ABORTED"
    obeys: bool = True
    timeout_s: float = 3.0
    repair: Callable[[Trial], None] | None = None


class Observer:
    """Node that sends the goal, presses the button, and records the joint states."""

    def __init__(self) -> None:
        self._context = Context()
        self._context.init([])
        self.node = Node("observer", context=self._context, start_parameter_services=False)
        self.states: list[tuple[float, int, list[float]]] = []
        self.is_stopped = threading.Event()
        self._changed = threading.Condition()
        self.node.create_subscription(
            get_message("sensor_msgs/msg/JointState"),
            "/joint_states",
            self._received,
            1000,
            immediate=True,
        )
        self.node.create_subscription(
            get_message("std_msgs/msg/Bool"),
            "/controller_manager/is_stopped",
            self._stop_confirmed,
            qos_profile_latched,
            immediate=True,
        )
        self._button = StopButton(self.node)
        self._client = ActionClient(
            self.node, _FollowJointTrajectory, "/arm_controller/follow_joint_trajectory"
        )
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        threading.Thread(target=self._executor.spin, daemon=True).start()

    def _received(self, message: Any) -> None:
        positions = dict(zip(message.name, message.position, strict=True))
        if not positions.keys() >= set(_JOINTS):
            return
        with self._changed:
            entry = [positions[name] for name in _JOINTS]
            self.states.append((time.monotonic(), to_nanoseconds(message.header.stamp), entry))
            self._changed.notify_all()

    def _stop_confirmed(self, message: Any) -> None:
        (self.is_stopped.set if message.data else self.is_stopped.clear)()

    def wait_until(self, condition: Callable[[], bool], timeout_s: float = _LONGEST_S) -> bool:
        """Wait until a condition holds after a state; return whether it did in time."""
        with self._changed:
            return self._changed.wait_for(condition, timeout_s)

    def send_goal(self, seconds: int = _SECONDS) -> Any:
        """Send the goal; return its handle, None if it was refused or not answered."""
        if not self._client.wait_for_server(_LONGEST_S):
            return None
        goal = _FollowJointTrajectory.Goal()
        point = get_message("trajectory_msgs/msg/JointTrajectoryPoint")(positions=[_WAY, 0.3, 0.3])
        point.time_from_start.sec = seconds
        goal.trajectory.joint_names, goal.trajectory.points = _JOINTS, [point]
        future = self._client.send_goal_async(goal)
        if not future.wait(_LONGEST_S):
            return None
        handle: Any = future.result()
        return handle if handle.accepted else None

    def press(self) -> bool:
        """Stop the robot; return whether the manager confirms it within three seconds."""
        self._button.press()
        return self.is_stopped.wait(3.0)

    def release(self) -> bool:
        """Release the robot; return whether the manager confirms it within three seconds."""
        self._button.release()
        deadline = time.monotonic() + 3.0
        while self.is_stopped.is_set() and time.monotonic() < deadline:
            time.sleep(0.02)
        return not self.is_stopped.is_set()

    def call(self, service: str, type_name: str) -> None:
        """Call a service with an empty request, and wait for the response."""
        kind = get_service(type_name)
        client = self.node.create_client(kind, service)
        assert client.wait_for_service(_LONGEST_S)
        assert client.call(kind.Request(), _LONGEST_S) is not None

    def close(self) -> None:
        """Destroy the node."""
        self._executor.shutdown()
        self.node.destroy_node()
        self._context.try_shutdown()


@dataclass
class Trial:
    """One launch of the arm with a goal in progress.

    Attributes:
        fault: Fault to cause.
        folder: Folder with the hardware, the controller, and the file that makes them fail.
        observer: Node that watches the arm.
        said: Output of commands that the fault runs.
        problems: What was not as it should be.
        others: Processes beside the launch, to be interrupted at the end.
    """

    fault: Fault
    folder: Path
    observer: Observer
    said: list[str] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)
    others: list[subprocess.Popen[bytes]] = field(default_factory=list)

    def start(self) -> None:
        """Start the launch file, and wait until its controllers are active."""
        self.log = self.folder / "launch.log"
        self._file = self.log.open("w", encoding="utf-8")
        self.launch = subprocess.Popen(
            [
                *(sys.executable, "-m", "teleopctl", "launch", *self.fault.launch.split()),
                f"controllers_file:={self.folder / 'controllers.yaml'}",
            ],
            stdout=self._file,
            stderr=subprocess.STDOUT,
            stdin=subprocess.DEVNULL,
            env={**os.environ, "PYTHONPATH": f"{self.folder}:{os.environ.get('PYTHONPATH', '')}"},
            start_new_session=True,
        )
        deadline = time.monotonic() + _LONGEST_S
        while self.text().count("Configured and activated") < 3:
            if time.monotonic() > deadline or self.launch.poll() is not None:
                raise RuntimeError(f"the launch did not start:\n{self.text()}")
            time.sleep(0.05)
        assert self.observer.wait_until(lambda: bool(self.observer.states))

    def text(self) -> str:
        """Return what the launch has printed so far."""
        return self.log.read_text(encoding="utf-8", errors="replace")

    def run(self, words: Sequence[str], timeout_s: float = 30.0) -> tuple[int, str]:
        """Run a teleopctl command; return status and output, status -1 if it did not end."""
        try:
            done = subprocess.run(
                [sys.executable, "-m", "teleopctl", *words],
                capture_output=True,
                text=True,
                check=False,
                timeout=timeout_s,
            )
        except subprocess.TimeoutExpired:
            self.problems.append(f"'{' '.join(words)}' did not end")
            return -1, ""
        return done.returncode, done.stdout + done.stderr

    def make_fail(self, name: str) -> None:
        """Make hardware or controller fail in a way."""
        part = self.folder / "fault.part"
        part.write_text(name)
        part.rename(self.folder / "fault")

    def kill(self, program: str) -> None:
        """Kill a process of the launch, named by a word of its command line."""
        for process in psutil.Process(self.launch.pid).children(recursive=True):
            if program in process.cmdline():
                process.kill()
                return
        raise RuntimeError(f"no {program} to kill")

    def reload(self, old: str, new: str) -> None:
        """Change the controller's code, and reload it, which must fail."""
        path = self.folder / "my_controller.py"
        path.write_text(_CONTROLLER.replace(old, new, 1))
        status, said = self.run(["control", "reload", "mine"])
        self.said.append(said)
        if status != 1:
            self.problems.append(f"the reload ended with status {status}")

    def end(self) -> None:
        """Interrupt the launch; a process that does not end within 15 s is a problem."""
        for other in self.others:
            other.send_signal(signal.SIGINT)
            other.wait(15.0)
        self.launch.send_signal(signal.SIGINT)
        try:
            self.launch.wait(15.0)
        except subprocess.TimeoutExpired:
            self.problems.append("the launch did not end")
            os.killpg(self.launch.pid, signal.SIGKILL)
            self.launch.wait()
        if "SIGTERM" in self.text() or "SIGKILL" in self.text():
            self.problems.append("a process had to be ended by force")
        if "Traceback" in self.text():
            self.problems.append("a traceback")
        self._file.close()

    # -- what is seen ------------------------------------------------------------------------------

    def explanations(self, since: int) -> list[str]:
        """Return the lines of log and commands that match the explanation, without repetition."""
        lines = [*self.text()[since:].splitlines(), *"\n".join(self.said).splitlines()]
        return [line for line in lines if re.search(self.fault.explanation, line)]

    def alarms(self, since: int) -> list[str]:
        """Return all warnings and errors of a part of the log, and all lines of dead processes."""
        wanted = re.compile(r"\[(WARN|ERROR)\]|process has died|Traceback")
        return [line for line in self.text()[since:].splitlines() if wanted.search(line)]

    def wait_for_explanation(self, since: int) -> None:
        """Wait until the explanation is in the log."""
        deadline = time.monotonic() + _EXPLAINED_WITHIN_S
        while not self.explanations(since) and time.monotonic() < deadline:
            time.sleep(0.05)

    def motion(self, since: int) -> str:
        """Return what the joints have done from a state on: ``hold``, ``follow`` or ``end``."""
        states = self.observer.states[since:]
        recent = [entry for when, _, entry in states if when > time.monotonic() - 0.5]
        if not recent:
            return "end"
        # The others go on or hold as the first; one may be NaN.
        spread = max(entry[0] for entry in recent) - min(entry[0] for entry in recent)
        return "follow" if spread > _AT_REST else "hold"

    def missed(self, first: int, last: int) -> int:
        """Return the number of cycles without a state between two states, by their stamps."""
        stamps = [stamp for _, stamp, _ in self.observer.states[first:last]]
        gaps = [later - earlier for earlier, later in itertools.pairwise(stamps)]
        return sum(round(gap * _RATE / 1e9) - 1 for gap in gaps if gap > 1.5e9 / _RATE)


@contextlib.contextmanager
def _trial(fault: Fault) -> Iterator[Trial]:
    with tempfile.TemporaryDirectory(prefix="teleopctl-control-") as name:
        folder = Path(name)
        limit = f"{fault.timeout_s}"
        (folder / "controllers.yaml").write_text(_CONTROLLERS.replace("CYCLE_TIMEOUT", limit))
        (folder / "my_hardware.py").write_text(_HARDWARE)
        (folder / "my_controller.py").write_text(_CONTROLLER)
        observer = Observer()
        trial = Trial(fault, folder, observer)
        try:
            trial.start()
            yield trial
        finally:
            trial.end()
            observer.close()


def _expect(trial: Trial, what: str, seen: object, wanted: object) -> None:
    if seen != wanted:
        trial.problems.append(f"{what}: {seen}, expected {wanted}")


def _result(handle: Any, timeout_s: float) -> tuple[str, str]:
    future = handle.get_result_async()
    if not future.wait(timeout_s):
        return "goes on", ""
    response = future.result()
    return GoalState(response.status).name, response.result.error_string


def in_motion(fault: Fault) -> dict[str, str]:
    """Cause a fault while the arm moves, then stop the robot; return the cells of the table."""
    with _trial(fault) as trial:
        observer = trial.observer
        command: subprocess.Popen[str] | None = None
        if fault.goal == "server gone":
            command = _send_by_command(observer)
            handle = None
        else:
            handle = observer.send_goal()
        assert observer.wait_until(lambda: observer.states[-1][2][0] > 0.1), "the arm does not move"
        first, since = len(observer.states) - 1, len(trial.text())
        place = observer.states[-1][2][0]
        fault.cause(trial)
        trial.wait_for_explanation(since)
        time.sleep(_LOOK_S)
        last = len(observer.states)
        joints = trial.motion(first)
        _expect(trial, "joints", joints, fault.joints)
        way = abs(observer.states[-1][2][0] - place)
        if handle is not None:
            ended, why = _result(handle, 0.5)
            _expect(trial, "goal", ended, fault.goal)
        else:
            assert command is not None
            ended, why = _end_of_command(trial, command)
        listing, listed = trial.run(["control", "list_controllers"])
        missed = trial.missed(first, last)
        before = trial.missed(max(0, first - 200), first)
        is_confirmed = observer.press() if fault.goal != "server gone" else False
        _expect(trial, "stop confirmed", is_confirmed, fault.obeys)
        if is_confirmed:
            time.sleep(1.0)
            if trial.motion(first) == "follow":
                trial.problems.append("the joints go on while the robot is stopped")
            if observer.send_goal() is not None:
                trial.problems.append("a goal was accepted while the robot was stopped")
        refused = ""
        if not is_confirmed and fault.goal != "server gone":
            status, refused = trial.run(["stop", "--robot"])
            _expect(trial, "status of 'stop --robot'", status, 1)
        after_repair = _repair(trial)
        explanations = trial.explanations(since)
        _expect(trial, "explanations", len(explanations), 1)
        alarms = trial.alarms(since)
    return {
        "joints": "no more states" if joints == "end" else f"{joints}, after {way:.3f} rad",
        "explanation": _without_stamp(explanations[0]) if explanations else "none",
        "goal": f"{ended}: {why}" if why else ended,
        "missed": f"{missed} ({before} before)",
        "list_controllers": f"status {listing}" + (f": {_one_line(listed)}" if listing else ""),
        "stop after": "confirmed" if is_confirmed else _one_line(refused) or "-",
        "repaired": after_repair,
        "problems": "; ".join(trial.problems),
        "alarms": "\n".join(alarms),
    }


def _repair(trial: Trial) -> str:
    """End the fault, if that is possible, release the robot, and reach a goal; return how."""
    if trial.fault.repair is None:
        return "-"
    observer = trial.observer
    trial.fault.repair(trial)
    _expect(trial, "released", observer.release(), True)
    handle = observer.send_goal(seconds=1)
    if handle is None:
        trial.problems.append("the goal after the repair was refused")
        return "refused"
    ended, why = _result(handle, _LONGEST_S)
    _expect(trial, "goal after the repair", ended, "SUCCEEDED")
    error = abs(observer.states[-1][2][0] - _WAY)
    return f"{ended}, error {error:.4f} rad" if ended == "SUCCEEDED" else f"{ended}: {why}"


def while_stopped(fault: Fault) -> tuple[str, str]:
    """Cause a fault while the robot is stopped; return whether it stays so, and problems."""
    with _trial(fault) as trial:
        observer = trial.observer
        observer.send_goal()
        assert observer.wait_until(lambda: observer.states[-1][2][0] > 0.1), "the arm does not move"
        assert observer.press(), "the stop is not confirmed"
        time.sleep(1.0)
        first, since = len(observer.states), len(trial.text())
        place = observer.states[-1][2]
        fault.cause(trial)
        trial.wait_for_explanation(since)
        time.sleep(_LOOK_S)
        ways = [abs(a - b) for a, b in zip(observer.states[-1][2], place, strict=True)]
        if fault.joints != "end":
            _expect(trial, "joints while stopped", trial.motion(first), "hold")
        if max(ways) > 0.02 and not fault.name.startswith("simulated time"):
            trial.problems.append(f"moved by {max(ways):.3f} rad while stopped")
        if not observer.is_stopped.is_set():
            trial.problems.append("released by the fault")
        if fault.goal != "server gone" and observer.send_goal() is not None:
            trial.problems.append("a goal was accepted while the robot was stopped")
    return "stays" if not trial.problems else "see problems", "; ".join(trial.problems)


def _send_by_command(observer: Observer) -> subprocess.Popen[str]:
    assert observer.wait_until(lambda: bool(observer.states))
    goal = f"{{trajectory: {{joint_names: {_JOINTS}, points: [{{positions: [{_WAY}, 0.3, 0.3], "
    goal += f"time_from_start: {{sec: {_SECONDS}}}}}]}}}}"
    return subprocess.Popen(
        [
            *(sys.executable, "-m", "teleopctl", "action", "send_goal"),
            "/arm_controller/follow_joint_trajectory",
            "control_msgs/action/FollowJointTrajectory",
            goal,
        ],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


def _end_of_command(trial: Trial, command: subprocess.Popen[str]) -> tuple[str, str]:
    try:
        said, _ = command.communicate(timeout=10.0)
    except subprocess.TimeoutExpired:
        command.kill()
        command.communicate()
        trial.problems.append("'action send_goal' did not end")
        return "hangs", ""
    return f"'action send_goal' status {command.returncode}", said.strip().splitlines()[-1]


def _one_line(text: str) -> str:
    return " ".join(line.strip() for line in text.strip().splitlines())


def _without_stamp(line: str) -> str:
    return re.sub(r"^\[[\w.-]+\] |\[\d+\.\d+\] | \[pid .*|/tmp/\S*/", "", line).strip()


_MOCK = "controller.yaml hardware:=my_hardware:Faulty"
_SIM = "sim.yaml camera:=false viewer:=false"
_TOPIC = f"{_SIM} control:=topic"


def _reload(old: str, new: str) -> Callable[[Trial], None]:
    return lambda trial: trial.reload(old, new)


def _start_simulator(trial: Trial) -> None:
    before = len(trial.observer.states)
    words = ("run", "mujoco_sim", "mujoco_sim", "--ros-args", "-p", f"update_rate:={_RATE}")
    trial.others.append(
        subprocess.Popen([sys.executable, "-m", "teleopctl", *words], stderr=subprocess.DEVNULL)
    )
    assert trial.observer.wait_until(lambda: len(trial.observer.states) > before + 100)


FAULTS = (
    Fault(
        "hardware raises in read",
        _MOCK,
        lambda trial: trial.make_fail("read raises"),
        r"Hardware 'RobotSystem' raised in read: OSError: the bus does not answer \(.*:\d+\)",
        joints="end",
    ),
    Fault(
        "hardware raises in write",
        _MOCK,
        lambda trial: trial.make_fail("write raises"),
        r"Hardware 'RobotSystem' raised in write: OSError: the bus does not answer \(.*:\d+\)",
        joints="end",
    ),
    Fault(
        "hardware blocks for 1.7 s",
        _MOCK,
        lambda trial: trial.make_fail("read blocks"),
        r"ERROR.*Hardware 'RobotSystem' has not returned from read\(\) for 1\.\d s",
    ),
    Fault(
        "hardware blocks for ever",
        _MOCK,
        lambda trial: trial.make_fail("write hangs"),
        r"ERROR.*Hardware 'RobotSystem' has not returned from write\(\) for 1\.\d s",
        joints="end",
        obeys=False,
        timeout_s=0.0,
    ),
    Fault(
        "hardware returns NaN",
        _MOCK,
        lambda trial: trial.make_fail("NaN"),
        r"Hardware does not measure 'joint_2/position': it is not a number",
    ),
    Fault(
        "controller raises",
        _MOCK,
        lambda trial: trial.make_fail("controller raises"),
        r"Controller 'mine' raised in update: ValueError: no such joint \(.*:\d+\)",
        joints="follow",
        goal="goes on",
    ),
    Fault(
        "controller sleeps for 1.7 s",
        _MOCK,
        lambda trial: trial.make_fail("controller sleeps"),
        r"ERROR.*Controller 'mine' has not returned from update\(\) for 1\.\d s",
    ),
    Fault(
        "controller sleeps for ever, in one process with the simulator",
        _SIM,
        lambda trial: trial.make_fail("controller hangs"),
        r"ERROR.*Controller 'mine' has not returned from update\(\) for 1\.\d s",
        joints="end",
        goal="server gone",
        obeys=False,
    ),
    Fault(
        "controller sleeps for 1.7 s, control:=topic",
        _TOPIC,
        lambda trial: trial.make_fail("controller sleeps"),
        r"ERROR.*Controller 'mine' has not returned from update\(\) for 1\.\d s",
    ),
    Fault(
        "simulator killed, in one process",
        _SIM,
        lambda trial: trial.kill("mujoco_sim"),
        r"\[mujoco_sim-\d\]: process has died",
        joints="end",
        goal="server gone",
        obeys=False,
    ),
    Fault(
        "simulator killed, control:=topic",
        _TOPIC,
        lambda trial: trial.kill("mujoco_sim"),
        r"Nothing publishes /robot_joint_states any more: the control cycle stands still",
        joints="end",
        repair=_start_simulator,
    ),
    Fault(
        "simulated time jumps back, in one process",
        _SIM,
        lambda trial: trial.observer.call(
            "/reset_simulation", "simulation_interfaces/srv/ResetSimulation"
        ),
        r"without their goals: (time jumped back|the simulation was reset)",
    ),
    Fault(
        "simulated time jumps back, control:=topic",
        _TOPIC,
        lambda trial: trial.observer.call(
            "/reset_simulation", "simulation_interfaces/srv/ResetSimulation"
        ),
        r"without their goals: (time jumped back|the simulation was reset)",
    ),
    *(
        Fault(
            f"reload fails in {phase}",
            _MOCK,
            _reload(old, new),
            rf"^teleopctl: Could not reload controller 'mine', (?=.*_controller\.py:\d+).*{error}",
            joints="follow",
            goal="goes on",
        )
        for phase, old, new, error in (
            ("its import", "import time\n", "import time time\n", "SyntaxError"),
            ("on_init", "def on_init(self):\n", "def on_init(self):\n        1 / 0\n", "on_init"),
            (
                "on_configure",
                "def on_configure(self):\n",
                "def on_configure(self):\n        1 / 0\n",
                "on_configure",
            ),
            (
                "its first update",
                "(self, time_ns, period):\n",
                "(self, time_ns, period):\n        1 / 0\n",
                "first update",
            ),
        )
    ),
)


def main() -> None:
    """Cause all faults, or those of the command line; print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help="parts of the names of faults")
    parser.add_argument("--quick", action="store_true", help="without /stop before the fault")
    parser.add_argument("--alarms", action="store_true", help="print all warnings and errors")
    options = parser.parse_args()
    chosen = [
        fault
        for fault in FAULTS
        if not options.names or any(name in fault.name for name in options.names)
    ]
    problems = 0
    head = (
        "fault",
        "joints",
        "explanation",
        "goal",
        "missed",
        "list_controllers",
        "stop after",
        "repaired",
    )
    print("|", " | ".join((*head, "stop before")), "|")
    print("|" + "---|" * (len(head) + 1))
    for fault in chosen:
        with own_graph():
            cells = in_motion(fault)
        before, more = "-", ""
        if not options.quick:
            with own_graph():
                before, more = while_stopped(fault)
        row = [fault.name, *(cells[name] for name in head[1:]), before]
        print("|", " | ".join(row), "|", flush=True)
        if options.alarms:
            print(cells["alarms"], flush=True)
        if text := "; ".join(filter(None, (cells["problems"], more))):
            problems += 1
            print(f"PROBLEM in '{fault.name}': {text}", flush=True)
    sys.exit(1 if problems else 0)


if __name__ == "__main__":
    main()
