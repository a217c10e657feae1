"""``teleopctl view``: what a path names decides what is started."""

import pytest

from teleopctl.cli.verbs import view as verb
from teleopctl.cli.verbs.bag import view as bag_view
from teleopctl.errors import TeleopctlError


@pytest.fixture
def started(tmp_path, monkeypatch):
    """What would be started, in a folder with a file of each kind."""
    calls: list[object] = []
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("TELEOPCTL_OPEN", "")
    for folder in ("session", "empty"):
        (tmp_path / folder).mkdir()
    (tmp_path / "session" / "metadata.yaml").touch()
    for name in ("arm.urdf.xacro", "arm.rviz", "mine.yaml", "one.mcap", "notes.txt"):
        (tmp_path / name).touch()
    monkeypatch.setattr("teleopctl.cli.verbs.run.run", calls.append)
    monkeypatch.setattr("teleopctl.cli.verbs.launch.launch", calls.append)
    monkeypatch.setattr(bag_view, "view", lambda path, **_: calls.append(path))
    return calls


PAGE = ["rviz2", "rviz2", "--host", "127.0.0.1", "--open"]


@pytest.mark.parametrize(
    ("thing", "what"),
    [
        (None, PAGE),
        ("arm.rviz", [*PAGE, "-d", "arm.rviz"]),
        ("mine.yaml", [*PAGE, "--layout", "mine.yaml"]),
        ("arm.urdf.xacro", ["display.yaml", "model:=arm.urdf.xacro"]),
        ("session", "session"),
        ("one.mcap", "one.mcap"),
    ],
)
def test_each_thing_is_opened_by_the_command_for_it(started, thing, what):
    verb.view(thing)
    assert started == [what]


@pytest.mark.parametrize(
    ("thing", "words"),
    [
        ("missing.rviz", "missing.rviz: no such file"),
        ("empty", "a folder without a bag"),
        ("notes.txt", "neither a bag nor a robot's file"),
    ],
)
def test_what_cannot_be_opened_is_named(started, thing, words):
    with pytest.raises(TeleopctlError, match=words):
        verb.view(thing)
    assert not started


def test_an_option_without_an_effect_is_refused(started):
    for thing in ("session", "mine.yaml"):
        with pytest.raises(TeleopctlError, match="--layout control"):
            verb.view(thing, layout="control")
    with pytest.raises(TeleopctlError, match="whose page is on this machine"):
        verb.view("arm.urdf.xacro", host="0.0.0.0")
    with pytest.raises(TeleopctlError, match="a bag is shown over another bag"):
        verb.view("arm.urdf.xacro", over="one.mcap")
    assert not started


def test_a_second_bag_lies_over_the_first(started, monkeypatch):
    monkeypatch.setattr(bag_view, "view", lambda path, over, **_: started.append((path, over)))
    verb.view("session", over="one.mcap")
    assert started == [("session", "one.mcap")]
