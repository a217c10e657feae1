"""Keys count as held as far as a terminal says so."""

from teleopctl.base.keyboard import UP, Key
from teleopctl.teleop import HeldKeys
from teleopctl.teleop.held_keys import FIRST_HOLD_S, REPEAT_HOLD_S


def test_a_first_press_lasts_until_the_terminal_repeats_it():
    keys = HeldKeys()
    keys.on_key(Key(UP), 10.0)
    assert keys.held(10.0 + FIRST_HOLD_S - 0.01) == {UP}
    assert keys.held(10.0 + FIRST_HOLD_S + 0.01) == frozenset()


def test_a_repeat_ends_soon_after_the_last_one():
    keys = HeldKeys()
    for time_s in (10.0, 10.5, 10.53, 10.56):
        keys.on_key(Key(UP), time_s)
    assert keys.held(10.56 + REPEAT_HOLD_S - 0.01) == {UP}
    assert keys.held(10.56 + REPEAT_HOLD_S + 0.01) == frozenset()


def test_another_key_ends_the_one_before():
    keys = HeldKeys()
    keys.on_key(Key(UP), 10.0)
    keys.on_key(Key("u"), 10.1)
    assert keys.held(10.1) == {"u"}


def test_where_the_terminal_reports_releases_several_keys_are_held_until_then():
    keys = HeldKeys()
    keys.on_key(Key(UP, reports_release=True), 10.0)
    keys.on_key(Key("u", reports_release=True), 10.1)
    assert keys.held(99.0) == {UP, "u"}
    keys.on_key(Key(UP, is_released=True, reports_release=True), 99.1)
    assert keys.held(99.1) == {"u"}
    keys.release_all()
    assert keys.held(99.1) == frozenset()
