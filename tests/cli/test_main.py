"""How a run of the command line ends: exit status, and what stands on stderr."""

import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Annotated

import pytest

from teleopctl import __version__, plugins
from teleopctl.cli import main, ros2_options
from teleopctl.cli.typer_app import command_tree
from teleopctl.cli.typer_line import typer_line
from teleopctl.cli.verb import Argument, Verb, VerbGroup
from teleopctl.errors import TeleopctlError, UsageError


def end(how: Annotated[str, Argument(help="How to end.")]) -> int | None:
    """End in some way.

    The second paragraph is for help.
    """
    match how:
        case "status":
            return 1
        case "fail":
            raise TeleopctlError("no such arm", hint="buy one")
        case "misuse":
            raise UsageError("not like this")
        case "interrupt":
            raise KeyboardInterrupt
        case "defect":
            raise ZeroDivisionError("by zero")
        case "denied":
            raise PermissionError(13, "Permission denied", "/the/file")
        case "pipe":
            raise BrokenPipeError
    return None


GROUP = VerbGroup("Sample verbs.", {"end": Verb(f"{__name__}:end", "End in some way.")})


@pytest.fixture
def sample(monkeypatch):
    monkeypatch.setitem(plugins.VERBS.builtin, "sample", f"{__name__}:GROUP")
    monkeypatch.setitem(plugins.VERBS.summaries, "sample", "Sample verbs.")
    monkeypatch.setattr("teleopctl.base.output.discard_output", lambda: None)
    monkeypatch.delenv("FORCE_COLOR", raising=False)


@pytest.mark.parametrize("leaves_nothing", [False, True])
def test_python_ends_in_order_unless_nothing_is_left_and_all_is_written_either_way(leaves_nothing):
    script = (
        "import atexit, sys\n"
        "from teleopctl import plugins\n"
        "from teleopctl.cli import main\n"
        f"from {__name__} import GROUP\n"
        f"GROUP.leaves_nothing = {leaves_nothing}\n"
        f"plugins.VERBS.builtin['sample'] = '{__name__}:GROUP'\n"
        "atexit.register(print, 'in order')\n"
        "print('written', end='.')\n"
        "sys.argv[1:] = ['sample', 'end', 'status']\n"
        "main.main()\n"
    )
    process = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=60, check=False
    )
    assert (process.returncode, process.stderr) == (1, "")
    assert process.stdout == ("written." if leaves_nothing else "written.in order\n")


@pytest.mark.parametrize(
    ("how", "status", "errors"),
    [
        ("well", 0, ""),
        ("status", 1, ""),
        ("fail", 1, "teleopctl: no such arm\n  buy one\n"),
        ("misuse", 2, "teleopctl: not like this\n"),
        ("denied", 1, "teleopctl: Cannot use /the/file: Permission denied\n"),
        ("interrupt", 130, ""),
        ("pipe", 0, ""),
    ],
)
@pytest.mark.parametrize("detour", [[], ["--"]], ids=["quick", "typer"])
def test_exit_status_and_stderr(sample, capsys, how, status, errors, detour):
    assert main.run(["sample", "end", *detour, how]) == status
    written = capsys.readouterr()
    assert (written.out, written.err) == ("", errors)


def test_a_defect_is_one_line_and_says_how_to_see_more(sample, capsys):
    assert main.run(["sample", "end", "defect"]) == 1
    assert "unexpected ZeroDivisionError: by zero" in capsys.readouterr().err


@pytest.mark.parametrize("how", ["fail", "defect"])
def test_debug_shows_the_traceback_before_the_message(sample, monkeypatch, capsys, how):
    status = main.run(["sample", "end", how])
    message = capsys.readouterr().err
    assert main.run(["--debug", "sample", "end", how]) == status
    errors = capsys.readouterr().err
    assert errors.startswith("Traceback")
    assert errors.endswith(message)
    monkeypatch.setenv("TELEOPCTL_DEBUG", "1")
    main.run(["sample", "end", how])
    assert capsys.readouterr().err.startswith("Traceback")


def test_a_wrong_command_line_ends_with_2_under_debug_too(sample):
    assert main.run(["--debug", "topc", "list"]) == 2


@pytest.mark.parametrize(
    ("line", "suggestion"),
    [("topc list", "mean topic"), ("topic lst", "mean list"), ("sample end well --halp", "--help")],
)
def test_a_misspelled_word_gets_a_suggestion_and_status_2(sample, capsys, line, suggestion):
    assert main.run(line.split()) == 2
    errors = capsys.readouterr().err
    assert suggestion in errors
    assert "--help`" in errors


def test_a_missing_argument_is_named(sample, capsys):
    assert main.run(["sample", "end"]) == 2
    assert "'HOW'" in capsys.readouterr().err


def test_version(capsys):
    assert main.run(["--debug", "--version"]) == 0
    assert capsys.readouterr().out == f"teleopctl {__version__}\n"
    project = Path(__file__).parents[2] / "pyproject.toml"
    assert tomllib.loads(project.read_text(encoding="utf-8"))["project"]["version"] == __version__


def test_a_reader_that_goes_away_is_no_error():
    writer = (
        "from teleopctl.cli import console, main\n"
        "main._dispatch = lambda *_: console.out('x' * 10_000_000)\n"
        "main.main()"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", writer], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    assert process.stdout is not None
    assert process.stderr is not None
    process.stdout.close()
    assert process.wait(timeout=60) == 0
    assert process.stderr.read() == b""
    process.stderr.close()


@pytest.mark.parametrize(
    "line",
    [
        "topic list --no-daemon",
        "node list --spin-time 3",
        "topic list --spin-time=3 --no-daemon",
        "topic list -s",
        "param list --use-sim-time",
        "--use-python-default-buffering topic list",
    ],
)
def test_options_of_ros2_without_a_meaning_here_are_accepted(ros, line):
    del ros
    assert main.run(line.split()) == 0


@pytest.mark.parametrize(
    ("line", "plain"),
    [
        ("topic --include-hidden-topics list -t", "topic list --include-hidden-topics -t"),
        ("topic --include-hidden-topics type /x", "topic type /x"),
        (
            "service --include-hidden-services find a/b",
            "service find --include-hidden-services a/b",
        ),
        ("service type --include-hidden-services /x", "service type /x"),
        ("topic --include-hidden-topics", "topic"),
        ("topic echo -s /x", "topic echo -s /x"),
        ("param set /n p -s", "param set /n p"),
    ],
)
def test_hidden_names_may_be_asked_for_before_the_verb(line, plain):
    assert ros2_options.without_ignored_options(line.split()) == plain.split()


@pytest.mark.parametrize(
    ("line", "whole"),
    [
        ("topic list --show-t", "topic list --show-types"),
        ("topic echo --trunc=1 /x", "topic echo --truncate-length=1 /x"),
        ("topic echo --qos-d 1 /x", "topic echo --qos-d 1 /x"),
        ("topic pub -w5 /x a/B", "topic pub -w5 /x a/B"),
        ("topic hz -- --al", "topic hz -- --al"),
        ("run --det pkg prog --det", "run --detach pkg prog --det"),
        (
            "control switch_controllers --deac a b",
            "control switch_controllers --deactivate a --deactivate b",
        ),
    ],
)
def test_options_may_be_shortened_while_it_is_clear_which_is_meant(line, whole):
    words = line.split()
    assert typer_line(command_tree(words), words) == whole.split()


def test_other_verbs_keep_such_words_for_their_programs():
    line = ["run", "pkg", "program", "--no-daemon"]
    assert ros2_options.without_ignored_options(line) == line
