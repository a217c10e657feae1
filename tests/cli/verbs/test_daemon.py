"""``daemon stop`` does not take the router from running launches without a word."""

from pathlib import Path

import pytest

from teleopctl.base import background
from teleopctl.base.background import ProcessRecord, StartTime
from teleopctl.cli import main
from teleopctl.wire import router


@pytest.fixture
def stopped(monkeypatch) -> list[str]:
    """What is stopped, while a launch runs in a terminal."""
    of_router = ProcessRecord("router", 1, StartTime(), (), Path("router.log"), "router")
    launch = ProcessRecord("sim", 2, StartTime(), (), Path("sim.log"), background.FOREGROUND_LAUNCH)
    names: list[str] = []
    # The door first: it takes the name from the module when it is first used.
    monkeypatch.setattr("teleopctl.wire.find_router", lambda: of_router, raising=False)
    monkeypatch.setattr(router, "find_router", lambda: of_router)
    monkeypatch.setattr(background, "records", list)
    monkeypatch.setattr(background, "foreground_launches", lambda: [launch])
    monkeypatch.setattr(background, "stop", lambda record: names.append(record.name))
    return names


def test_under_a_launch_it_is_refused_where_nobody_can_be_asked(stopped, capsys):
    assert main.run(["daemon", "stop"]) == 1
    assert capsys.readouterr().err.startswith("teleopctl: sim would lose the router")
    assert not stopped


def test_with_yes_it_is_done(stopped, capsys):
    assert main.run(["daemon", "stop", "--yes"]) == 0
    assert capsys.readouterr().out == "The daemon has been stopped\n"
    assert stopped == ["router"]
