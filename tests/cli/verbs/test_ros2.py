"""The word ``ros2``: scripts of this environment, never in the way of a real ros2."""

import json
import os
import stat
import subprocess

import pytest

from teleopctl.cli import main
from teleopctl.cli.completion import shells
from teleopctl.cli.verbs import ros2

pytestmark = pytest.mark.skipif(os.name == "nt", reason="scripts of POSIX")


@pytest.fixture
def scripts(tmp_path, monkeypatch):
    """The folder of the environment's programs, and the only one on the PATH."""
    folder = tmp_path / "a bin"
    folder.mkdir()
    monkeypatch.setattr(ros2, "_folder", lambda: folder)
    monkeypatch.setenv("PATH", str(folder))
    return folder


def put(folder, name):
    folder.mkdir(exist_ok=True)
    program = folder / name
    program.write_text("#!/bin/sh\necho real\n")
    program.chmod(0o755)
    return program


def test_ros2_starts_teleopctl_under_its_own_name_and_goes_again(scripts, capsys, monkeypatch):
    assert main.run(["ros2", "install"]) == 0
    names = ["ros2", "rqt", "rqt_console", "rqt_graph", "rqt_plot", "rviz2"]
    assert capsys.readouterr().out.splitlines() == [str(scripts / name) for name in names]
    assert all(stat.S_IXUSR & (scripts / name).stat().st_mode for name in names)
    monkeypatch.delenv("PATH")
    done = subprocess.run(
        [scripts / "ros2", "topic", "ecco"], capture_output=True, text=True, check=False, timeout=60
    )
    assert done.returncode == 2
    assert done.stderr == (
        "ros2: No such command 'ecco'\n  Did you mean echo? See `ros2 topic --help`.\n"
    )
    assert main.run(["ros2", "install", "--only-ros2", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"made": [str(scripts / "ros2")], "kept": []}
    assert main.run(["ros2", "remove", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["removed"] == [str(scripts / n) for n in names]
    assert not list(scripts.iterdir())
    assert main.run(["ros2", "remove"]) == 0
    assert capsys.readouterr().err == "Nothing of `teleopctl ros2 install` is here.\n"


@pytest.mark.parametrize("place", ["here", "elsewhere"])
def test_a_real_ros2_is_neither_replaced_nor_hidden(scripts, tmp_path, place, capsys, monkeypatch):
    folder = scripts if place == "here" else tmp_path / "opt"
    real = put(folder, "ros2")
    monkeypatch.setenv("PATH", os.pathsep.join((str(scripts), str(folder))))
    assert main.run(["ros2", "install"]) == 1
    assert capsys.readouterr().err.startswith(f"teleopctl: ros2 is here already: {real}\n")
    assert main.run(["ros2", "remove"]) == 0
    assert "real" in real.read_text()
    assert list(scripts.iterdir()) == ([real] if place == "here" else [])


def test_another_tool_of_ros2_stays_as_it_is(scripts, tmp_path, capsys, monkeypatch):
    real = put(tmp_path / "opt", "rviz2")
    monkeypatch.setenv("PATH", os.pathsep.join((str(scripts), str(real.parent))))
    assert main.run(["ros2", "install"]) == 0
    assert capsys.readouterr().err == f"{real} stays as it is.\n"
    assert not (scripts / "rviz2").exists()


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish", "powershell"])
def test_the_completion_of_ros2_calls_teleopctl_and_has_names_of_its_own(shell, capsys):
    assert main.run(["completion", shell, "--as", "ros2"]) == 0
    text = capsys.readouterr().out
    assert text == f"{shells.script(shell, 'ros2')}\n"
    ours = shells.script(shell)
    assert "NAME" not in text + ours
    assert "CALL" not in text + ours
    # An alias is no program that a script could call.
    assert "teleopctl" in text
    for line in text.splitlines():
        if "complet" in line and "COMPLETE" not in line:
            assert "teleopctl_" not in line
            assert "_teleopctl" not in line
