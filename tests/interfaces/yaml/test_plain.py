"""What is read and written without PyYAML is what PyYAML makes of it."""

from __future__ import annotations

from random import Random
from typing import Any

import pytest
import yaml
from hypothesis import example, given, strategies as st

from teleopctl.interfaces.yaml import message_to_yaml
from teleopctl.interfaces.yaml.dumping import dump
from teleopctl.interfaces.yaml.output import message_values
from teleopctl.interfaces.yaml.plain import read_plain, write_plain
from tests.interfaces.messages import REPRESENTATIVE_TYPES, random_message

# Short pieces, so that what is nearly plain comes up as often as what is.
PIECES = st.sampled_from(
    [
        *"{}[],:'\" -_#&*!|>%@`\\\n\t.~=?/",
        *(": ", ", ", "a b"),
        *[
            "x",
            "y",
            "no",
            "True",
            "null",
            "auto",
            "0",
            "1",
            "-5",
            "2.50",
            "1e5",
            "010",
            "0x1",
            "1_0",
            "1:30",
            "2001-01-01",
            ".inf",
            "<<",
            "é",
        ],
    ]
)
WORDS = [
    "x",
    "y",
    "n",
    "on",
    "No",
    "true",
    "NULL",
    "/map",
    "a/b.c",
    "a-b",
    "a:",
    "~",
    "1",
    "1e5",
    "é",
    "---",
    "...",
    "a...",
    "_",
    "=",
    "<<",
    "/",
]
TEXTS = st.sampled_from([*WORDS, "", " ", "a b", "a  b"])
SCALARS = st.booleans() | st.integers() | st.floats() | TEXTS | st.text("aé: #'\n", max_size=3)
VALUES = st.recursive(
    SCALARS,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(TEXTS, inner, max_size=3),
    max_leaves=8,
)


def read_by_library(text: str) -> Any:
    return yaml.load(text, yaml.CSafeLoader)


@given(st.lists(PIECES, max_size=12).map("".join))
@example("{data: -0}")
@example("{data: 1234567890123456.1234567890123456}")
def test_what_is_read_without_the_library_is_what_it_reads(text):
    values = read_plain(text)
    if values is not None:
        assert repr(values) == repr(read_by_library(text))


@given(st.dictionaries(st.sampled_from(["x", "y", "on", "name_2"]), VALUES, max_size=4))
def test_flow_style_that_the_library_writes_is_read_as_it_reads_it(values):
    text = yaml.safe_dump(values, default_flow_style=True, width=10**6).rstrip("\n")
    read = read_plain(text)
    assert read is None or repr(read) == repr(read_by_library(text))


@pytest.mark.parametrize(
    "text",
    [
        *("{}", "data: x", "data: Hello World 5", "{data: 'a: b'}", '{data: "5"}', "{ x: 1 }"),
        *("{linear: {x: 2.0, y: -0.5}, angular: {z: 1.8}}", "{data: [1, 2.5, true]}", "x: {y: 1}"),
    ],
)
def test_what_people_type_needs_no_library(text):
    assert read_plain(text) == read_by_library(text)


@given(st.dictionaries(TEXTS, VALUES, max_size=4), st.booleans())
@example({"a": 1e16, "b": 1e-7, "c": 1.5e300, "d": -0.0}, False)
def test_what_is_written_without_the_library_is_what_it_writes(values, flow):
    text = write_plain(values, flow=flow)
    assert text is None or text == dump(values, flow=flow)


@pytest.mark.parametrize("flow", [False, True])
def test_messages_look_as_the_library_writes_them(flow):
    plain = 0
    for name in REPRESENTATIVE_TYPES:
        for seed in range(5):
            message = random_message(Random(seed), name)
            values = message_values(message, truncate=2)
            assert message_to_yaml(message, truncate=2, flow=flow) == dump(values, flow=flow)
            plain += write_plain(values, flow=flow) is not None
    assert plain > 20
