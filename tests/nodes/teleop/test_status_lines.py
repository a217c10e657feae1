"""Lines of a device in a terminal of 80 columns."""

import os
import re
from types import SimpleNamespace

import pytest

from teleopctl.nodes.teleop.status_lines import StatusLines


class Screen:
    """Screen of 80 columns that understands what the lines are written with."""

    def __init__(self):
        self.rows, self.row = [""], 0

    def write(self, text):
        for part in re.findall(r"\x1b\[\d*[A-Z]|\r\n|\r|[^\x1b\r]+", text):
            if found := re.fullmatch(r"\x1b\[(\d+)A", part):
                self.row -= int(found[1])
                assert self.row >= 0
            elif part == "\x1b[J":
                del self.rows[self.row + 1 :]
                self.rows[self.row] = ""
            elif part == "\r\n":
                self.row += 1
                self.rows[self.row :] = [""]
            elif part != "\r":
                assert len(part) < 80
                self.rows[self.row] = part

    def flush(self):
        pass


@pytest.fixture
def screen(monkeypatch):
    screen = Screen()
    out = SimpleNamespace(stdout=screen)
    monkeypatch.setattr("teleopctl.nodes.teleop.status_lines.sys", out)
    size = os.terminal_size((80, 24))
    monkeypatch.setattr(
        "teleopctl.nodes.teleop.status_lines.shutil.get_terminal_size", lambda: size
    )
    return screen


def test_each_part_has_its_lines_and_takes_the_place_of_the_former(screen):
    lines = StatusLines()
    lines.show(("keyboard: still", "no node drives", "", ""))
    assert screen.rows == ["keyboard: still", "no node drives"]
    sentence = "The arm is stretched to its end: move back towards its base"
    exact = (
        "Very close to a singularity, emergency stop: no motion along (0.65, 0.00, 0.76): the arm "
        "is at a singularity (the arm is stretched out)"
    )
    lines.show(("keyboard: moves x +1.00", "driven by /teleop_device (keyboard)", sentence, exact))
    assert screen.rows[:3] == [
        "keyboard: moves x +1.00",
        "driven by /teleop_device (keyboard)",
        sentence,
    ]
    assert " ".join(screen.rows[3:]) == exact
    lines.show(("keyboard: still", "no node drives", "", ""))
    assert screen.rows == ["keyboard: still", "no node drives"]


def test_what_is_too_long_for_two_lines_is_cut_at_a_word(screen):
    StatusLines().show(("word " * 60,))
    assert len(screen.rows) == 2
    assert screen.rows[1].endswith("word …")
