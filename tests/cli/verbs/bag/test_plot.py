"""``teleopctl bag plot`` draws in the terminal, or into a file."""

from __future__ import annotations

import sys

import pytest

from teleopctl.bag import BagWriter
from teleopctl.cli import main
from tests.bag.bags import message, topic

FLOAT = "std_msgs/msg/Float32"


@pytest.fixture
def session(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with BagWriter(tmp_path / "session") as writer:
        writer.add_topic(topic("/load", FLOAT))
        writer.add_topic(topic("/text"))
        for number in range(2000):
            writer.write(message("/load", number, FLOAT, data=100.0 + number % 500))
    return tmp_path / "session"


def test_without_a_file_the_curves_are_drawn_with_characters(session, capsys):
    assert main.run(["bag", "plot", "session", "/load/data"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert "/load/data" in lines[-1]
    assert max(map(len, lines)) <= 80
    # The axis is the time since the start of the bag.
    assert lines[-2].split()[:3] == ["0.0", "s", "0.5"]


def test_a_part_of_the_time_may_be_drawn(session, capsys):
    line = ["bag", "plot", "session", "/load/data", "--start-offset", "1", "--duration", "0.4"]
    assert main.run(line) == 0
    assert capsys.readouterr().out.splitlines()[-2].split()[0] == "1.0"


def test_a_file_is_a_picture_by_its_name(session, capsys):
    assert main.run(["bag", "plot", "session", "load/data", "-o", "load.svg"]) == 0
    assert 'id="/load/data"' in (session.parent / "load.svg").read_text(encoding="utf-8")
    assert capsys.readouterr().out == ""
    assert main.run(["bag", "plot", "session", "/load/data", "-o", "load.txt"]) == 2
    assert "'load.txt' must end in .png, .svg, .pdf" in capsys.readouterr().err


def test_what_cannot_be_drawn_is_named_with_what_can(session, capsys):
    assert main.run(["bag", "plot", "session", "/load"]) == 2
    assert "Its fields are data." in capsys.readouterr().err
    assert main.run(["bag", "plot", "session", "/text/data"]) == 1
    assert "no message of /text" in capsys.readouterr().err
    assert main.run(["bag", "plot", "session", "/load/data", "--duration", "0"]) == 2


def test_a_missing_library_is_named_with_its_line(session, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.setitem(sys.modules, "uniplot", None)
    assert main.run(["bag", "plot", "session", "/load/data", "-o", "a.png"]) == 1
    assert "This needs matplotlib, which is not installed" in capsys.readouterr().err
    assert main.run(["bag", "plot", "session", "/load/data"]) == 1
    assert "This needs uniplot, which is not installed" in capsys.readouterr().err
