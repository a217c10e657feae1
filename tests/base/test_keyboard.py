"""Keys of a terminal come one by one, and the terminal is as before afterwards."""

import os
import queue
import sys

import pytest

from teleopctl.base.keyboard import DOWN, LEFT, RIGHT, SPACE, UP, Keyboard, parse_keys

termios = pytest.importorskip("termios")


@pytest.mark.parametrize(
    ("text", "keys"),
    [
        (" ", [SPACE]),
        ("\x1b[A\x1b[B\x1b[C\x1b[D", [UP, DOWN, RIGHT, LEFT]),
        ("\x1bOA", [UP]),
        ("q \x1b[Cx", ["q", SPACE, RIGHT, "x"]),
        ("\x1b[3~a", ["a"]),
        ("\x1b[1;5Ca", ["a"]),
        ("\x1b", []),
        ("\x1b[", []),
    ],
)
def test_keys_are_read_from_what_a_terminal_sends(text, keys):
    assert parse_keys(text) == keys


@pytest.fixture
def terminal(monkeypatch):
    """The other end of a terminal that is the standard input of this process."""
    ours, theirs = os.openpty()
    with open(theirs) as stream:  # noqa: PTH123 (a descriptor)
        monkeypatch.setattr(sys, "stdin", stream)
        # Of a terminal that controls nobody no group is in the foreground.
        monkeypatch.setattr(os, "tcgetpgrp", lambda _: os.getpgrp())
        yield ours
    os.close(ours)


def test_keys_are_handed_over_at_once_and_the_terminal_is_restored_after_a_failure(terminal):
    before = termios.tcgetattr(terminal)
    pressed: queue.Queue[str] = queue.Queue()
    with pytest.raises(RuntimeError), Keyboard(pressed.put):
        assert termios.tcgetattr(terminal) != before
        os.write(terminal, b" ")
        assert pressed.get(timeout=20) == SPACE
        os.write(terminal, b"\x1b[A")
        assert pressed.get(timeout=20) == UP
        raise RuntimeError
    assert termios.tcgetattr(terminal) == before


def test_no_key_is_read_where_input_is_no_terminal(monkeypatch, tmp_path):
    file = tmp_path / "input"
    file.write_text("  ")
    with file.open() as stream:
        monkeypatch.setattr(sys, "stdin", stream)
        with Keyboard(lambda _: pytest.fail("a key")):
            pass
        assert stream.read() == "  "
