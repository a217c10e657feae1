"""Which processes of a launch are up, by the graph and their progress files."""

import time
from pathlib import Path
from typing import Any

import pytest

from teleopctl.base import progress
from teleopctl.base.background import StartTime
from teleopctl.launch.execution.judgement import UpProcesses, find_up_processes, own_nodes
from teleopctl.launch.execution.status import ProcessStatus, State
from teleopctl.wire import Graph


@pytest.mark.parametrize(
    ("reported", "is_up"),
    [
        (None, True),
        ("started", True),
        ("starting parsing", False),
        ("ready", True),
        ("failed no such joint", False),
        # Its node leaves the graph later, and its exit status is known later.
        ("ended 1 no such joint", False),
        ("ended 0", True),
    ],
)
def test_a_node_in_the_graph_is_up_unless_it_reports_that_it_starts_or_has_failed(
    tmp_path: Path, reported: str | None, is_up: bool
) -> None:
    up = _up_by(tmp_path, reported, "running")
    assert up.names == ({"arm-1": "/arm"} if is_up else {})
    assert up.waiting == {}


def test_a_process_that_finished_is_up_whatever_step_it_reported_last(tmp_path: Path) -> None:
    assert _up_by(tmp_path, "starting activating arm", "finished").names == {"arm-1": None}


def test_a_command_that_loads_a_controller_is_up_only_when_it_has_ended(tmp_path: Path) -> None:
    loads = {"is_node": False, "ends_by_itself": True, "start": StartTime(0.0)}
    assert _up_by(tmp_path, None, "running", **loads).names == {}
    assert _up_by(tmp_path, None, "finished", **loads).names == {"arm-1": None}


NEW_NODES = {"other": ["/stranger"], "own": ["/arm", "/arm_helper"]}


@pytest.mark.parametrize(
    ("sessions", "found"),
    [
        (None, ([], False)),  # it has not begun
        (["own"], (["/arm", "/arm_helper"], True)),
        (["later"], ([], True)),  # its node is not in the graph yet, another one is
        ([], (["/stranger"], False)),  # perhaps that of a process that it has started
        ([progress.ANY_SESSION], (["/stranger"], True)),  # a program in another language
    ],
)
def test_a_process_has_the_nodes_of_the_sessions_that_it_names(
    sessions: list[str] | None, found: tuple[list[str], bool]
) -> None:
    said = None
    if sessions is not None:
        said = progress.Progress("started", "", 0.0, sessions=tuple(sessions))
    assert own_nodes(said, NEW_NODES) == found


def test_a_node_without_a_name_in_the_launch_file_is_found_by_its_session(tmp_path: Path) -> None:
    assert _up_by(tmp_path, "started\n\nsession", "running", node_name=None).names
    assert not _up_by(tmp_path, "started\n\nlater", "running", node_name=None).names


def _up_by(folder: Path, reported: str | None, state: State, **more: Any) -> UpProcesses:
    log_file = folder / "arm.log"
    if reported is not None:
        progress.progress_file(log_file).write_text(f"{reported}\n")
    status = ProcessStatus(
        name="arm-1",
        pid=1,
        start=StartTime(time.time()),
        state=state,
        exit_status=None if state == "running" else 0,
        ended_at=0.0,
        log_file=str(log_file),
        command=["arm"],
        node_name="/arm",
        is_node=True,
        ends_by_itself=False,
    )._replace(**more)
    return find_up_processes([status], {"session": ["/arm"]}, Graph())
