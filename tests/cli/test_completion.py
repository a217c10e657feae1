"""Completion: scripts for the shells, and candidates."""

import pytest

from teleopctl.cli import completion, main


@pytest.mark.parametrize(
    ("shell", "mark"),
    [
        ("bash", "complete -o default"),
        ("zsh", "#compdef teleopctl"),
        ("fish", "complete --command teleopctl"),
        ("powershell", "Register-ArgumentCompleter"),
    ],
)
def test_each_shell_has_a_script(capsys, monkeypatch, shell, mark):
    monkeypatch.setenv(completion.VARIABLE, "")
    monkeypatch.delenv(completion.VARIABLE)
    with pytest.raises(SystemExit) as end:
        main.run(["completion", shell])
    assert not end.value.code
    script = capsys.readouterr().out
    assert mark in script
    assert completion.VARIABLE in script


def candidates(monkeypatch, capsys, line: str) -> list[str]:
    words = line.split(" ")
    monkeypatch.setenv(completion.VARIABLE, "complete_bash")
    monkeypatch.setenv("COMP_WORDS", line)
    monkeypatch.setenv("COMP_CWORD", str(len(words) - 1))
    with pytest.raises(SystemExit):
        main.run([])
    return capsys.readouterr().out.split()


def test_verbs_and_options_are_completed(monkeypatch, capsys):
    assert candidates(monkeypatch, capsys, "teleopctl to") == ["topic"]
    assert "echo" in candidates(monkeypatch, capsys, "teleopctl topic ")
    assert candidates(monkeypatch, capsys, "teleopctl topic list --sh") == ["--show-types"]


def test_without_a_router_nothing_is_offered(monkeypatch, capsys):
    monkeypatch.setenv("TELEOPCTL_ROUTER", "tcp/127.0.0.1:1")
    assert candidates(monkeypatch, capsys, "teleopctl topic info /") == []
