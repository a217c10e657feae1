"""The tutorial's pages about the moving arm, typed in their order, give the numbers they show."""

import re
import shlex

import pytest

from teleopctl.testing import RosGraph, eventually
from tests import ROOT
from tests.test_docs import BLOCK, text_of, whole_lines

STEPS = ("## 8. Moving the arm", "## 10. The daemon")
TOLERANCE = 2e-3  # Of numbers that are printed with three digits.


def commands():
    """The command lines of the steps, each with the output that the page shows."""
    steps = text_of(ROOT / "docs" / "tutorial.md").partition(STEPS[0])[2].partition(STEPS[1])[0]
    for language, text in BLOCK.findall(steps):
        assert language == "console"
        lines = list(whole_lines(text.splitlines(), prompt="$ "))
        shown = re.split(r"^\$ (?:.*\\\n)?(?:.*,\n)*.*\n", text, flags=re.MULTILINE)[1:]
        yield from zip(lines, shown, strict=True)


def numbers(text):
    """The numbers of an output, without times and what is left out on the page."""
    text = re.sub(r"(?m)^At time.*$|^ +(?:sec|nanosec): .*$|\[\d{10}\.\d{9}\]", "", text)
    return [float(number) for number in re.findall(r"(?<!\w)-?\d+\.\d+", text)]


def settles(ros: RosGraph, words: list[str], shown: str) -> None:
    """Ask until the arm is where the page has it."""
    expected = numbers(shown.partition("At time 16")[0])
    assert len(expected) >= 5

    def is_there() -> bool:
        said = numbers(ros.run(words).stdout)
        return bool(said[: len(expected)] == pytest.approx(expected, abs=TOLERANCE))

    eventually(is_there, what=f"{words} does not show {expected}")


def test_the_steps_in_their_order_give_the_numbers_they_show(ros):
    ros.launch("sim.yaml", "camera:=false")
    compared = 0
    for line, shown in commands():
        words = shlex.split(line)[1:]
        if words[0] == "run":  # The same text, once a second until Ctrl-C.
            assert words[1:3] == ["tf2_ros", "tf2_echo"]
            words = ["tf", "echo", *words[3:], "--once"]
        if words[0] == "logs":
            assert "position 1.75 is clamped to 1.5708" in shown
            assert "position 1.75 is clamped to 1.5708" in ros.run(words).stdout
        elif "pub" in words:
            assert ros.run(words).returncode == 0
        else:
            settles(ros, words, shown)
            compared += 1
    assert compared == 4
