"""Tab in real shells: what is completed arrives as the word that it should be."""

import os
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from teleopctl.cli.completion import shells
from tests.samples import sample
from tests.system.terminal import Terminal

pytestmark = pytest.mark.skipif(os.name == "nt", reason="a terminal of POSIX")

# Shells want a terminal to be theirs alone.
TAKE_TERMINAL = """
import fcntl, os, sys, termios
fcntl.ioctl(0, termios.TIOCSCTTY, 0)
os.execvp(sys.argv[1], sys.argv[1:])
"""
# What makes each shell listen, without the user's own settings; then its name for the prompt.
STARTS = {
    "bash": (["bash", "--noprofile", "--norc", "-i"], "bind 'set bell-style none'; PS1=READY; "),
    "zsh": (["zsh", "-f", "-i"], "autoload -Uz compinit; compinit -D; PS1=READY; "),
    "fish": (["fish", "--no-config", "-i"], "function fish_prompt; echo READY; end; "),
}
EVAL = {
    "bash": 'eval "$(teleopctl completion bash)"',
    "zsh": 'eval "$(teleopctl completion zsh)"',
    "fish": "teleopctl completion fish | source",
}
# Asked by a shell, it is teleopctl; run by hand, it shows the words that it was given.
PROGRAM = f"""#!/bin/sh
if [ -n "$_TELEOPCTL_COMPLETE" ] || [ "$1" = completion ]; then
    exec {shlex.quote(sys.executable)} -m teleopctl "$@"
fi
printf 'GIVEN('
printf '<%s>' "$@"
printf ')\\n'
"""

# What is typed before Tab and behind it, and the words that come of it.
LINES = {
    "a verb": ("teleopctl servi", "x", ["service", "x"]),
    "an option": ("teleopctl topic echo /x --flow", "", ["topic", "echo", "/x", "--flow-style"]),
    "a choice": (
        "teleopctl topic echo /x --qos-reliability rel",
        "",
        ["topic", "echo", "/x", "--qos-reliability", "reliable"],
    ),
    "a message": (
        "teleopctl topic pub /x geometry_msgs/msg/Point ",
        "",
        ["topic", "pub", "/x", "geometry_msgs/msg/Point", "{x: 0.0, y: 0.0, z: 0.0}"],
    ),
    "a message with quotes": (
        "teleopctl topic pub /x std_msgs/msg/String ",
        "",
        ["topic", "pub", "/x", "std_msgs/msg/String", "{data: ''}"],
    ),
    "a word with colons": (
        "teleopctl launch sim.yaml paus",
        "true",
        ["launch", "sim.yaml", "paused:=true"],
    ),
    "a file with a blank and a quote": ("teleopctl run ./it", "", ["run", "./it's here.py"]),
    "the same in quotes": ('teleopctl run "./it', "", ["run", "./it's here.py"]),
    "what stands in quotes before": (
        "teleopctl run './it'\\''s here.py' dat",
        "",
        ["run", "./it's here.py", "data.csv"],
    ),
    "a folder to be gone on in": ("teleopctl run ./fold", "in", ["run", "./folder/in"]),
}


class Shell:
    """An interactive shell that has our script."""

    def __init__(self, name: str, folder: Path) -> None:
        programs = folder / "bin"
        programs.mkdir()
        (programs / "teleopctl").write_text(PROGRAM)
        (programs / "teleopctl").chmod(0o755)
        argv, start = STARTS[name]
        argv = [sys.executable, "-c", TAKE_TERMINAL, *argv]
        path = f"{programs}:{os.environ['PATH']}"
        env = {**os.environ, "PATH": path, "HOME": str(folder), "XDG_CONFIG_HOME": str(folder)}
        self.terminal = Terminal(argv, env, folder)
        self.terminal.press(f"{start}{EVAL[name]}; echo IS_'READY'\r")
        self.terminal.until("IS_READY")

    def given(self, before: str, behind: str) -> list[str]:
        """The words that teleopctl is given when Tab is pressed between two texts."""
        self.terminal.text = ""
        self.terminal.press(f"{before}\t{behind}\r")
        words = self.terminal.until(r"GIVEN\((.*?)\)\r").group(1)
        return str(words)[1:-1].split("><")


@pytest.fixture(scope="module", params=STARTS)
def shell(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Shell]:
    if shutil.which(request.param) is None:
        pytest.skip(f"{request.param} is not installed")
    folder = tmp_path_factory.mktemp(request.param)
    (folder / "it's here.py").touch()
    (folder / "data.csv").touch()
    (folder / "folder").mkdir()
    started = Shell(request.param, folder)
    yield started
    started.terminal.kill()


@pytest.mark.parametrize("what", sample(LINES, 2))
def test_what_tab_completes_is_the_word_that_teleopctl_is_given(shell, what):
    before, behind, words = LINES[what]
    assert shell.given(before, behind) == words


@pytest.mark.parametrize(
    ("word", "meant"),
    [
        ("", ""),
        ("--once", "--once"),
        (".\\folder\\da", ".\\folder\\da"),
        ('"./it"', "./it"),
        ("'it's'", "it's"),
        ("'", ""),
    ],
)
def test_a_word_of_powershell_loses_its_quotes_and_nothing_else(word, meant, monkeypatch):
    monkeypatch.setenv("_TELEOPCTL_WORDS", f"run\x1f{word}")
    asked = shells.parse_request("powershell", [])
    assert asked is not None
    assert (asked.words, asked.incomplete) == (["run"], meant)


@pytest.mark.skipif(shutil.which("pwsh") is None, reason="PowerShell is not installed")
@pytest.mark.parametrize("what", [what for what in LINES if "stands in" not in what])
def test_powershell_completes_the_same_words(what, tmp_path, monkeypatch):
    before, behind, words = LINES[what]
    (tmp_path / "it's here.py").touch()
    (tmp_path / "data.csv").touch()
    (tmp_path / "folder").mkdir()
    line = before.replace("'", "''")
    monkeypatch.setenv("PATH", str(Path(sys.executable).parent), prepend=os.pathsep)
    program = (
        f"{shells.script('powershell')}\n$line = '{line}'\n"
        "$found = [System.Management.Automation.CommandCompletion]::CompleteInput($line, "
        "$line.Length, $null)\n"
        "$line = $line.Substring(0, $found.ReplacementIndex) + $found.CompletionMatches[0]"
        f".CompletionText + '{behind}'\n"
        'function teleopctl { $args | ForEach-Object { "<$_>" } }\nInvoke-Expression $line'
    )
    done = subprocess.run(
        ["pwsh", "-NoProfile", "-NonInteractive", "-Command", program],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    assert done.stdout.splitlines() == [f"<{word}>" for word in words]
