"""Runner of a documentation page: writes its files and runs its commands, in order.

A command must print the output that the page shows, except for numbers, times and paths. A command
that runs until Ctrl-C is interrupted after this output; a node or a launch in the foreground runs
until the next heading, as for a reader with two terminals.

A comment in the page, in the line above a block, marks exceptions:

- ``<!-- not typed: REASON -->``: a command that no test can run; `NOT_TYPED` of the test lists all.
- ``<!-- stays open -->``: a command in the foreground that runs to the end of the page.
- ``<!-- to the digit -->``: numbers must be equal too, except times.
"""

from __future__ import annotations

import os
import re
import shlex
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field

import pytest

from teleopctl.testing import Process, RosGraph, eventually
from teleopctl.wire.config import session_config
from teleopctl.wire.graph import query_graph
from teleopctl.wire.session import RouterNotRunning, open_configured
from tests.system.terminal import Terminal
from tests.test_docs import whole_lines

STEP = re.compile(
    r"^#+ (?P<heading>[^\n]+)$|^(?:<!-- (?P<remark>[^>\n]*) -->\n\n?)?"
    r"```(?P<language>\w*)\n(?P<text>.*?)^```$|^\|(?P<row>[^\n]*)\|$",
    re.MULTILINE | re.DOTALL,
)
FILE_NAME = re.compile(r"^(?:# |<!-- )([\w./]+\.\w+)(?: -->)?\n")
IN_TABLE = re.compile(r"`(teleopctl (?:[^`])+)`")

# Drawn text, in contrast to the escape sequence that hides the cursor.
A_WORD = r"[a-z_]{4}"

LONGEST_COMMAND_S = 90.0
TOLERANCE = 2e-3  # of numbers that are printed with three digits

# Output that differs in every run: folders, identifiers, numbers with their units.
CHANGES = re.compile(
    r"(?P<left_out>…)|(?P<path>/home/me\b[^\s:',)]*)|(?P<gid>(?:[0-9a-f]{2}\.){15}[0-9a-f]{2})"
    r"|(?P<number>(?<!\w)-?\d+(?:\.\d+)*(?:e[-+]\d+)?(?:m\d+)?s?(?!\w))|(?P<blank>\s+)"
)
STANDS_FOR = {
    "left_out": r".*",
    "path": r"\S+",
    "gid": r"[0-9a-f.]+",
    "number": r"-?[\d.][\w.+-]*",
    "blank": r"\s+",
}


@dataclass(frozen=True, slots=True)
class Step:
    """Step of a page: a command, a file or a heading.

    Attributes:
        line: Command line, which may have several lines.
        shown: Output lines that the page shows for the command.
        remark: Comment above the command's block; empty without a comment.
        file: Name and text of a file to write instead; None for a command.
        is_heading: Whether the step is a heading.
    """

    line: str = ""
    shown: tuple[str, ...] = ()
    remark: str = ""
    file: tuple[str, str] | None = None
    is_heading: bool = False

    @property
    def is_typed(self) -> bool:
        """Whether a test can run the command."""
        return not self.remark.startswith("not typed")

    @property
    def is_side_by_side(self) -> bool:
        """Whether the command may run in parallel: changes nothing, and the page has no output."""
        words = shlex.split(self.line, comments=True)
        looks = words[:1] == ["teleopctl"] and only_looks(words) and not goes_on(words)
        return looks and self.is_typed and not any(self.shown) and not self.line.endswith("&")

    def lacks(self, shown: tuple[str, ...], process: Process) -> list[str]:
        """Return the lines of the page that a process has not written."""
        # Messages name the source of the router's endpoint, which a reader does not set.
        output = (process.stdout + process.stderr).replace(" (from TELEOPCTL_ROUTER)", "")
        return missing(shown, output, numbers=self.remark == "to the digit")


def steps(text: str, *, tables: bool = False) -> Iterator[Step]:
    """Yield the steps of a page; with ``tables``, also the commands in its tables."""
    for match in STEP.finditer(text):
        if match["heading"] is not None:
            yield Step(is_heading=True)
        elif match["row"] is not None:
            if tables:
                for command in IN_TABLE.findall(match["row"]):
                    yield Step(line=command.replace("\\|", "|"))
        elif match["language"] in ("sh", "console"):
            yield from _commands(match["language"], match["text"], match["remark"] or "")
        elif name := FILE_NAME.match(match["text"]):
            yield Step(file=(name[1], match["text"]))


def _commands(language: str, text: str, remark: str) -> Iterator[Step]:
    prompt = "$ " if language == "console" else ""
    lines = text.splitlines()
    typed = list(whole_lines(lines, prompt))
    if not prompt:
        yield from (Step(line=line, remark=remark) for line in typed)
        return
    # A prompt is followed by the command, which may have several lines, and its output.
    parts = [part.splitlines() for part in re.split(r"^\$ ", text, flags=re.MULTILINE)[1:]]
    for line, part in zip(typed, parts, strict=True):
        own = next(n for n in range(1, len(part) + 1) if _is_whole(part[:n]))
        yield Step(line=line, shown=tuple(part[own:]), remark=remark)


def _is_whole(lines: list[str]) -> bool:
    text = "\n".join(lines)
    if text.endswith("\\"):
        return False
    try:
        shlex.split(text, comments=True)
    except ValueError:
        return False
    return True


def goes_on(words: list[str]) -> bool:
    """Return whether a command runs until Ctrl-C."""
    options = {word for word in words if word.startswith("-")}
    match words[1:]:
        case ["launch", *_]:
            return not options & {"-d", "--detach", "-s", "--show-args", "-p", "--print"}
        case ["run", "-d" | "--detach" | "xacro", *_] | ["run", _, "view_frames", *_]:
            return False
        case ["topic", "echo", *_]:
            return not options & {"--once", "--timeout"}
        case ["topic", "pub", *_]:
            return not options & {"-1", "--once", "-t", "--times"}
        case ["tf", "echo", *_]:
            return "--once" not in options
        case ["logs", *_]:
            return "-f" in options
        case ["run" | "top", *_] | ["topic", "hz" | "bw" | "delay", *_]:
            return True
        case ["bag", "play" | "burst" | "record" | "view", *_] | ["episode", "record", *_]:
            return True
    return False


def stays(words: list[str]) -> bool:
    """Return whether a reader keeps the command running and continues in another terminal."""
    if words[1] == "bag":
        return "burst" in words or "--snapshot-mode" in words
    return words[1] in ("run", "launch") and "tf2_echo" not in words


def only_looks(words: list[str]) -> bool:
    """Return whether the command only reads, so that it may be repeated."""
    if words[1] == "bag":
        return words[2] in ("check", "info", "list")
    if words[1] == "sim":
        return words[2] == "list"
    changing = ["run", "launch", "stop", "start", "set", "load", "pub", "call", "send_goal", "rm"]
    return set(words).isdisjoint(changing)


def pattern(line: str) -> re.Pattern[str]:
    """Return a regular expression for an output line of a page, which matches any run."""
    parts, at = [], 0
    for match in CHANGES.finditer(line):
        parts += [re.escape(line[at : match.start()]), STANDS_FOR[match.lastgroup or ""]]
        at = match.end()
    return re.compile("".join([*parts, re.escape(line[at:])]))


def missing(shown: tuple[str, ...], output: str, *, numbers: bool = False) -> list[str]:
    """Return the lines of a page that an output lacks; all lines if ``numbers`` differ."""
    lines = [line.strip() for line in output.splitlines()]
    wanted = [line.strip().removeprefix("^C") for line in shown if line.strip()]
    if numbers:
        expected = _numbers("\n".join(wanted))
        if _numbers(output)[: len(expected)] != pytest.approx(expected, abs=TOLERANCE):
            return wanted
    return [line for line in wanted if not any(map(pattern(line).fullmatch, lines))]


def _numbers(text: str) -> list[float]:
    text = re.sub(r"(?m)^ *At time.*$|^ *(?:sec|nanosec): .*$|\[\d{10}\.\d{9}\]", "", text)
    return [float(number) for number in re.findall(r"(?<!\w)-?\d+\.\d+", text)]


@dataclass
class Reader:
    """Runner of a page's steps in one folder, with several terminals.

    Attributes:
        ros: ROS graph of the commands; its folder is their working directory.
    """

    ros: RosGraph
    _asked: list[Callable[[], None]] = field(default_factory=list)
    _settings: list[str] = field(default_factory=list)
    _running: list[tuple[Process | Terminal, bool]] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Put scripts on PATH that run the `teleopctl` under test."""
        programs = self.ros.folder / "programs"
        programs.mkdir()
        for name in ("teleopctl", "pytest", "mypy"):
            script = f'#!/bin/sh\nexec "{sys.executable}" -m {name} "$@"\n'
            (programs / name).write_text(script, encoding="utf-8")
            (programs / name).chmod(0o755)
        # pip does nothing here: CI runs the install command of the README.
        (programs / "pip").write_text("#!/bin/sh\n", encoding="utf-8")
        (programs / "pip").chmod(0o755)
        self.ros.env["PATH"] = os.pathsep.join([str(programs), os.environ["PATH"]])

    def follow(self, text: str, *, tables: bool = False) -> None:
        """Run all steps of a page."""
        try:
            for step in steps(text, tables=tables):
                if not step.is_side_by_side:
                    self._read_answers()
                if step.is_heading:
                    self._close(final=False)
                elif step.file is not None:
                    self.write(*step.file)
                elif step.is_typed:
                    self._type(step)
            self._read_answers()
            self._close(final=True)
        finally:
            for process, _ in self._running:
                process.kill()

    def write(self, name: str, text: str) -> None:
        """Write a file of the page into the graph's folder."""
        path = self.ros.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")

    def _type(self, step: Step) -> None:
        words = shlex.split(step.line, comments=True)
        if words[0] in ("export", "unset", "cd"):
            self._settings.append(step.line)
            return
        command = step.line.removesuffix(" &")
        argv = ["bash", "-c", "\n".join([*self._settings, command])]
        stripped = words[words.index("teleopctl") :] if "teleopctl" in words else words
        if stripped[0] == "teleopctl" and goes_on(stripped) and not any(step.shown):
            self._unseen(step, argv, stripped)
            return
        process = self.ros.spawn_command(argv)
        if step.is_side_by_side:
            self._asked.append(lambda: self._to_the_end(step, process, argv, stripped))
        elif command != step.line:
            self._running.append((process, False))
        elif stripped[0] == "teleopctl" and goes_on(stripped) and not _shows_failure(step):
            self._until_shown(step, process, stripped)
        else:
            self._to_the_end(step, process, argv, stripped)

    def _unseen(self, step: Step, argv: list[str], words: list[str]) -> None:
        """Run a command without shown output until it is ready or has drawn something."""
        before = _nodes() if words[1] == "run" else []
        terminal = Terminal(argv, self.ros.env, self.ros.folder)
        self._running.append((terminal, step.remark == "stays open"))
        if words[1] == "run":
            eventually(lambda: _nodes() != before, LONGEST_COMMAND_S, step.line)
        else:
            terminal.until(r"Up: " if words[1] == "launch" else A_WORD, LONGEST_COMMAND_S)
        if words[1] == "top":
            terminal.press("q")
            assert terminal.wait() == 0, step.line
            self._running.pop()
        elif not stays(words):
            _press_ctrl_c(terminal)
            self._running.pop()

    def _until_shown(self, step: Step, process: Process, words: list[str]) -> None:
        shown = _of_this_command(step.shown)
        seen = -1

        def has_come() -> bool:
            nonlocal seen
            has_ended = process.returncode is not None
            if has_ended:
                process.wait()  # reads all output
            before, seen = seen, len(process.stdout) + len(process.stderr)
            if seen == before and not has_ended:
                return False
            if not step.lacks(shown, process):
                return True
            assert not has_ended, f"it ends by itself:\n{process.report()}"
            return False

        what = f"what the page shows of {step.line}, {shown}"
        eventually(has_come, LONGEST_COMMAND_S, what)
        if stays(words) and shown == step.shown:
            self._running.append((process, step.remark == "stays open"))
            return
        _press_ctrl_c(process)
        assert not step.lacks(step.shown, process), process.report()

    def _to_the_end(self, step: Step, process: Process, argv: list[str], words: list[str]) -> None:
        fails = _shows_failure(step)

        def is_right() -> bool:
            nonlocal process
            failed = process.wait(LONGEST_COMMAND_S) != 0
            if failed == fails and not step.lacks(step.shown, process):
                return True
            assert only_looks(words), process.report() + f"\nthe page shows {step.shown}"
            process = self.ros.spawn_command(argv)
            return False

        what = f"what the page shows of {step.line}, {step.shown}"
        eventually(is_right, LONGEST_COMMAND_S, what)

    def _read_answers(self) -> None:
        """Wait for the commands that run in parallel, and check them."""
        for answer in self._asked:
            answer()
        self._asked.clear()

    def _close(self, *, final: bool) -> None:
        while self._running and (final or not self._running[-1][1]):
            _press_ctrl_c(self._running[-1][0])
            self._running.pop()


def _nodes() -> list[str]:
    """Return the names of the nodes in the graph; none if no router runs."""
    try:
        with open_configured(session_config("client")) as session:
            return query_graph(session).node_names()
    except RouterNotRunning:
        return []


def _shows_failure(step: Step) -> bool:
    return any(re.search(r"^teleopctl: |: error: |^\w+Error: ", line) for line in step.shown)


def _of_this_command(shown: tuple[str, ...]) -> tuple[str, ...]:
    """Return the shown lines before Ctrl-C."""
    end = next((n for n, line in enumerate(shown) if line.startswith("^C")), len(shown))
    return shown[:end]


def _press_ctrl_c(process: Process | Terminal) -> None:
    with suppress(ProcessLookupError):  # the process may have ended
        os.killpg(process.pid, signal.SIGINT)
    assert process.wait() in (0, 130, -signal.SIGINT), process.report()
