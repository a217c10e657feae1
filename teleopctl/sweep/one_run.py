"""One run of a sweep: a launch, simulated and recorded, with its request and its result.

Each run is executed in a separate process, whose environment sets its own router, ROS domain and
folders.
"""

from __future__ import annotations

import contextlib
import json
import os
import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from teleopctl.base import background, progress
from teleopctl.base.start_timeouts import StartTimeouts
from teleopctl.errors import (
    LaunchError,
    SystemFailureError,
    TeleopctlError,
    UnavailableError,
)

if TYPE_CHECKING:
    from teleopctl.base.background import ProcessRecord
    from teleopctl.launch import ProcessStatus, Running
    from teleopctl.node import Node

BAG = "bag"
RUNTIME = "runtime"
RESULT_FILE = "result.json"
_REQUEST_FILE = "run.json"

# Number of ROS domain IDs used for runs: 1 to 231, without the default 0.
_DOMAINS = 231

SIMULATOR = "mujoco_sim"
_SET_PAUSE = "mujoco_ros2_control_msgs/srv/SetPause"

# Period in seconds of checks whether the launch has ended.
_LOOK_EVERY_S = 0.05
_BEGINS_WITHIN_S = 30.0
_ANSWER_WITHIN_S = 5.0
# Longest wait for the recorder's subscriptions; it has none to topics of unknown types.
_RECORDS_WITHIN_S = 2.0
# Time that the recorder may need to write its queued messages.
_ENDS_WITHIN_S = 30.0


@dataclass(frozen=True, slots=True, kw_only=True)
class RunRequest:
    """Request for one run of a sweep: launch file, arguments, varied parameters and duration.

    Attributes:
        number: Number of the run, starting at 1.
        file: Absolute path of the launch file.
        arguments: Launch arguments that are the same in each run.
        parameters: Varied values: launch arguments, and node parameters as ``node:parameter``.
        duration_s: Simulated seconds after which the run ends, or None.
        timeout_s: Seconds of wall time after which the run times out, start included; None for no
            timeout.
        stall_timeout_s: Seconds without progress after which the start has failed, or None for the
            default of `StartTimeouts`.
        after: Executables of the launch that must exit without error before the simulation begins.
        measures: Measures to compute, as `parse_measure` reads them.
    """

    number: int
    file: str
    arguments: dict[str, str]
    parameters: dict[str, str]
    duration_s: float | None = None
    timeout_s: float | None = None
    stall_timeout_s: float | None = None
    after: list[str] = field(default_factory=list)
    measures: list[str] = field(default_factory=list)

    def save(self, folder: Path) -> None:
        """Write the request to ``run.json`` in a run's folder."""
        (folder / _REQUEST_FILE).write_text(json.dumps(asdict(self), indent=1), encoding="utf-8")


def load_request(folder: Path) -> RunRequest:
    """Return the `RunRequest` read from ``run.json`` in a run's folder."""
    return RunRequest(**json.loads((folder / _REQUEST_FILE).read_text(encoding="utf-8")))


@dataclass(frozen=True, slots=True, kw_only=True)
class RunResult:
    """Result of one run of a sweep: outcome, measures and times.

    Attributes:
        number: Number of the run.
        parameters: Varied values of the run.
        result: ``done``, ``failed`` or ``timed out``.
        error: Reason of a failure, or error of the first failed measure; empty otherwise.
        wall_s: Duration of the run, in seconds of wall time.
        simulated_s: Last simulated time in seconds, or None without simulated time.
        measures: Value of each measure; None for a failed one.
        folder: Path of the folder with the bag and logs.
        machine: Name of the cluster worker that executed the run; empty for this machine.
    """

    number: int
    parameters: dict[str, str]
    result: str
    error: str
    wall_s: float
    simulated_s: float | None
    measures: dict[str, float | None]
    folder: str
    machine: str = ""

    @property
    def is_done(self) -> bool:
        """Whether the run ended without failure or timeout, even if a measure failed."""
        return self.result == "done"

    def save(self) -> None:
        """Write the result to ``result.json`` in the run's folder, atomically."""
        file = Path(self.folder) / RESULT_FILE
        draft = file.with_suffix(".new")
        draft.write_text(json.dumps(asdict(self), indent=1), encoding="utf-8")
        draft.replace(file)


def load_result(folder: Path) -> RunResult | None:
    """Return the `RunResult` read from a run's folder; None if the file is missing or invalid."""
    try:
        return RunResult(**json.loads((folder / RESULT_FILE).read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError):
        return None


def launch_arguments(request: RunRequest) -> dict[str, str]:
    """Return a run's launch arguments: common and varied ones, without varied node parameters."""
    varied = {name: value for name, value in request.parameters.items() if ":" not in name}
    return request.arguments | varied


def run_once(folder: Path) -> RunResult:
    """Launch, record and measure the run that a folder's request describes; return the result.

    Raises:
        KeyboardInterrupt: The run was stopped; no result is written.
    """
    request = load_request(folder)
    started = time.monotonic()
    result, error = "done", ""
    try:
        _launch(request, folder)
    except TimeoutError:
        result, error = "timed out", f"it took longer than {request.timeout_s:g} s"
    except TeleopctlError as failure:
        result, error = "failed", failure.message
    finally:
        for record in background.records():
            with contextlib.suppress(SystemFailureError):
                background.stop(record)
    simulated_s, measures, missing = _read_bag(folder / BAG, request.measures)
    outcome = RunResult(
        number=request.number,
        parameters=request.parameters,
        result=result,
        error=error or missing,
        wall_s=time.monotonic() - started,
        simulated_s=simulated_s,
        measures=measures,
        folder=str(folder),
    )
    outcome.save()
    return outcome


def _launch(request: RunRequest, folder: Path) -> None:
    from teleopctl.launch import LaunchRequest, start_in_background

    # The simulation starts paused, and begins when the launch is up: start-up times do not matter.
    simulator = ["-p", "paused:=true", "-p", "real_time_factor:=0.0"]
    if request.duration_s is not None:
        simulator += ["-p", f"end_time:={request.duration_s:f}"]
    varied = [(name, value) for name, value in request.parameters.items() if ":" in name]
    simulators: list[str] = []
    programs: set[str] = set()

    def note(process: ProcessStatus, node: str | None) -> None:
        programs.add(_program(process.name))
        if SIMULATOR in process.command:
            simulators.append(node or process.node_name or f"/{SIMULATOR}")

    wanted = LaunchRequest(
        file=request.file,
        arguments=launch_arguments(request),
        exit_status=True,
        record_into=str(folder / BAG),
        ros_arguments={
            SIMULATOR: simulator,
            "": [word for name, value in varied for word in ("-p", f"{name}:={value}")],
        },
        required=[SIMULATOR],
    )
    deadline = time.monotonic() + (request.timeout_s or float("inf"))
    try:
        record = start_in_background(wanted, "run", note, print, _timeouts(request), print)
    except TeleopctlError:
        if time.monotonic() >= deadline:
            raise TimeoutError from None
        raise
    try:
        _await_ends(request.after, programs, deadline)
        if simulators:
            _begin(simulators, record)
        elif request.duration_s is not None:
            raise LaunchError(f"It has no node '{SIMULATOR}' whose time could end")
        _wait(record, deadline)
    finally:
        background.stop(record, patience_s=_ENDS_WITHIN_S)


def _timeouts(request: RunRequest) -> StartTimeouts:
    timeouts = StartTimeouts()
    if request.timeout_s is not None:
        timeouts = timeouts._replace(total_s=request.timeout_s)
    if request.stall_timeout_s is not None:
        timeouts = timeouts._replace(stall_s=request.stall_timeout_s)
    return timeouts


def _program(process: str) -> str:
    """Return the executable of a launch process, whose name is ``exec-N``."""
    return process.rpartition("-")[0]


def _await_ends(names: list[str], programs: set[str], deadline: float) -> None:
    """Wait until these programs have ended; raise if one is unknown or has failed."""
    from teleopctl.launch import died, running

    for name in names:
        if name not in programs:
            known = ", ".join(sorted(programs))
            raise LaunchError(f"No process of it is called '{name}'", hint=f"There are {known}.")
        while any(_program(entry.record.name) == name for entry in running() if entry.launch):
            if time.monotonic() > deadline:
                raise TimeoutError
            time.sleep(_LOOK_EVERY_S)
        if dead := [entry for entry in died() if _program(entry.record.name) == name]:
            raise LaunchError(_failure_text(dead[0]))


def _begin(simulators: list[str], record: ProcessRecord) -> None:
    """Unpause these simulators by their service ``set_pause``, unless the launch ends before."""
    from teleopctl.interfaces import get_service
    from teleopctl.node import Node, init

    service = get_service(_SET_PAUSE)
    with init(args=[]) as context, Node("sweep", context=context) as node:
        # Simulated time may be over before the recorder has found a topic.
        context.wait_for_change(lambda: _records_all(node), _RECORDS_WITHIN_S)
        for simulator in simulators:
            client = node.create_client(service, f"{simulator}/set_pause")
            deadline, reason = time.monotonic() + _BEGINS_WITHIN_S, "no answer"
            while background.exit_status(record) is None:
                if time.monotonic() > deadline:
                    raise UnavailableError(f"{simulator} does not begin: {reason}")
                if not client.wait_for_service(_LOOK_EVERY_S):
                    continue
                answer = client.call(service.Request(paused=False), _ANSWER_WITHIN_S)
                if answer is not None and answer.success:
                    break
                # The simulator rejects the request until its robot is loaded.
                reason = answer.message if answer else reason
                time.sleep(_LOOK_EVERY_S)


def _records_all(node: Node) -> bool:
    """Return whether the recorder subscribes to all topics that have publishers."""
    from teleopctl.launch import RECORDER
    from teleopctl.node import NodeNameNonExistentError

    try:
        recorded = node.get_subscriber_names_and_types_by_node(RECORDER, "/")
    except NodeNameNonExistentError:
        return False
    published = {
        name
        for name, _ in node.get_topic_names_and_types()
        if node.count_publishers(name) and not any(part.startswith("_") for part in name.split("/"))
    }
    return published <= {name for name, _ in recorded}


def _wait(record: ProcessRecord, deadline: float) -> None:
    """Wait until a launch has ended; raise if its exit status is not 0."""
    from teleopctl.launch import died

    while (status := background.exit_status(record)) is None:
        if time.monotonic() > deadline:
            raise TimeoutError
        time.sleep(_LOOK_EVERY_S)
    if status != 0:
        ends = [_failure_text(entry) for entry in died() if entry.launch]
        raise LaunchError("\n".join(ends) or f"the launch ended with exit status {status}")


def _failure_text(entry: Running) -> str:
    from teleopctl.launch import log_tail

    last_progress = progress.read(entry.record.log_file)
    if last_progress is not None and last_progress.reason:
        return f"{entry.record.name}: {last_progress.reason}"
    return f"{entry.record.name} has {entry.ending}:\n{log_tail(entry.record.log_file)}"


def _read_bag(bag: Path, measures: list[str]) -> tuple[float | None, dict[str, float | None], str]:
    """Return the last simulated time, the measures, and the error of the first failed one."""
    from teleopctl.sweep.measure import measure_bag, parse_measure

    simulated_s, error = None, ""
    values: dict[str, float | None] = dict.fromkeys(measures)
    try:
        whole_s = measure_bag(bag, parse_measure("/clock/clock/sec"))
        simulated_s = whole_s + 1e-9 * measure_bag(bag, parse_measure("/clock/clock/nanosec"))
    except TeleopctlError:
        pass  # the bag has no /clock
    for text in measures:
        try:
            values[text] = measure_bag(bag, parse_measure(text))
        except TeleopctlError as failure:
            error = error or failure.message
    return simulated_s, values, error


def environment(folder: Path, domain_index: int, port: int) -> Mapping[str, str]:
    """Return this process's environment variables, with a run's own router, folders and ROS domain.

    Args:
        folder: Folder of the run.
        domain_index: Number that differs between simultaneous runs; selects the ROS domain.
        port: TCP port of the run's router on the loopback interface.
    """
    return os.environ | {
        "TELEOPCTL_ROUTER": f"tcp/127.0.0.1:{port}",
        "TELEOPCTL_VIEWER": "false",
        "TELEOPCTL_RUNTIME_DIR": str(folder / RUNTIME),
        "ROS_LOG_DIR": str(folder / "log"),
        # Isolates the run even if another router has taken that port.
        "ROS_DOMAIN_ID": str(1 + domain_index % _DOMAINS),
    }
