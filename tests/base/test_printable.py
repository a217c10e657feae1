"""Control characters in texts of others are made visible, and nothing else is changed."""

import json
import unicodedata

import pytest
from hypothesis import given, strategies as st

from teleopctl.base.printable import printable_json, printable_line, printable_log, printable_text

CONTROLS = st.text(st.characters(categories=["Cc", "Zl", "Zp"]) | st.sampled_from("a\u202e\u2066"))
ANYTHING = st.text(st.characters(exclude_categories=["Cs"])) | CONTROLS


def controls_in(text, *, allowed):
    return {
        character
        for character in text
        if unicodedata.category(character) in ("Cc", "Zl", "Zp") and character not in allowed
    }


@given(ANYTHING)
def test_a_line_has_no_control_character_but_tabs(text):
    shown = printable_line(text)
    assert not controls_in(shown, allowed="\t")
    assert printable_line(shown) == shown


@given(ANYTHING)
def test_a_text_keeps_its_lines_and_has_no_other_control_character(text):
    shown = printable_text(text)
    assert not controls_in(shown.replace("\r\n", "\n"), allowed="\t\n")
    assert shown.count("\n") == text.count("\n")


@given(st.text(st.characters(exclude_categories=["C", "Z"], include_characters=" ")))
def test_text_without_control_characters_stays_as_it_is(text):
    assert printable_line(text) == printable_text(text) == printable_log(text) == text


@given(st.dictionaries(ANYTHING, ANYTHING))
def test_json_says_the_same_without_control_characters(document):
    shown = printable_json(json.dumps(document, ensure_ascii=False, indent=2))
    assert not controls_in(shown, allowed="\n")
    assert json.loads(shown) == document


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("a\x1b]0;title\x07b", "a\\x1b]0;title\\x07b"),
        ("a\nb\tc\rd\x7f\x9b1m", "a\\nb\tc\\rd\\x7f\\x9b1m"),
        ("left \u202eright", "left \\u202eright"),
        ("übung ✓ 腕 👩\u200d🔧", "übung ✓ 腕 👩\u200d🔧"),
    ],
)
def test_a_control_character_is_written_as_python_writes_it(text, shown):
    assert printable_line(text) == shown


def test_windows_line_breaks_are_line_breaks():
    assert printable_text("a\r\nb\rc\n") == "a\r\nb\\rc\n"


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("\x1b[92mgreen\x1b[0m\nb", "\x1b[92mgreen\x1b[0m\nb\x1b[0m"),
        ("\x1b[2Jgone\x1b[31m", "\\x1b[2Jgone\x1b[31m\x1b[0m"),
    ],
)
def test_a_log_message_may_be_coloured_until_its_end(text, shown):
    assert printable_log(text) == shown
