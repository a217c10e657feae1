"""``teleopctl ps``."""

import time
from pathlib import Path

import pytest

from teleopctl.base.background import ProcessRecord, StartTime
from teleopctl.cli.verbs import ps
from teleopctl.launch import Running


def test_a_robot_description_on_a_command_line_does_not_fill_the_list(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ("create", "-string", "<robot>" * 1000, "-z", "1")
    record = ProcessRecord("robot", 1, StartTime(time.time()), command, Path("robot.log"), "node")
    monkeypatch.setattr(ps, "running", lambda: [Running(record)])
    monkeypatch.setattr(ps, "died", list)
    assert ps.ps() == 0
    printed = capsys.readouterr().out
    assert "create -string '<robot>" in printed
    assert "…' -z 1" in printed
    assert len(printed) < 600
