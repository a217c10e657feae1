"""Keys of a terminal come one by one, and the terminal is as before afterwards."""

import os
import queue
import signal
import sys

import pytest
from hypothesis import given
from hypothesis.strategies import text

from teleopctl.base.keyboard import (
    DOWN,
    LEFT,
    RIGHT,
    SPACE,
    UP,
    Key,
    Keyboard,
    parse_key_events,
    parse_keys,
)

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


@pytest.mark.parametrize(
    ("text", "keys"),
    [
        ("a", [Key("a")]),
        ("\t", [Key("TAB")]),
        ("\x1b[5~\x1b[6~", [Key("PAGE_UP"), Key("PAGE_DOWN")]),
        # The protocol of Kitty: press, repeat and release, of a letter, space and an arrow.
        ("\x1b[97;1:1u", [Key("a", reports_release=True)]),
        ("\x1b[97u", [Key("a")]),
        ("\x1b[97;1:2u", [Key("a", reports_release=True)]),
        ("\x1b[97;1:3u", [Key("a", is_released=True, reports_release=True)]),
        ("\x1b[97:65;2:1u", [Key("A", reports_release=True)]),
        ("\x1b[32;1:1u", [Key(SPACE, reports_release=True)]),
        ("\x1b[1;1:1A", [Key(UP, reports_release=True)]),
        ("\x1b[1;1:3A", [Key(UP, is_released=True, reports_release=True)]),
        ("\x1b[5;1:3~", [Key("PAGE_UP", is_released=True, reports_release=True)]),
        # Keys without a character, answers of the terminal, other modifiers.
        ("\x1b[57441;2:1u", []),
        ("\x1b[?11u", []),
        ("\x1b[97;5:1u", []),
        ("\x1b[9x", []),
    ],
)
def test_terminals_that_report_releases_are_understood(text, keys):
    assert parse_key_events(text) == keys


@given(text())
def test_no_input_of_a_terminal_is_too_strange(sent):
    parse_key_events(sent)


def test_ctrl_c_interrupts_where_the_terminal_sends_it_as_a_key(terminal):
    interrupted: queue.Queue[bool] = queue.Queue()
    before = signal.signal(signal.SIGINT, lambda *_: interrupted.put(True))
    try:
        with Keyboard(key=lambda _: None):
            os.write(terminal, b"\x1b[99;5:1u")
            assert interrupted.get(timeout=20)
    finally:
        signal.signal(signal.SIGINT, before)
