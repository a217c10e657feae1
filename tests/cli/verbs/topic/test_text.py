"""Fields and messages as ``topic echo`` writes them."""

import array
import json
import math

import numpy as np
import pytest

from teleopctl.cli.verbs.topic.text import TextStyle, json_value
from teleopctl.interfaces.store import get_message

String = get_message("std_msgs/msg/String")


def test_a_message_is_yaml_and_a_field_is_what_python_prints():
    style = TextStyle()
    assert style.yaml(String(data="Hello")) == "data: Hello\n"
    assert style.yaml("Hello") == "Hello\n"
    assert style.yaml(2.5) == "2.5\n"


def test_csv_of_messages_lists_and_fields():
    style = TextStyle()
    assert style.csv(get_message("geometry_msgs/msg/Point")(x=1.0)) == "1.0,0.0,0.0"
    assert style.csv(array.array("d", [1, 2])) == "1.0,2.0"
    assert style.csv("Hello") == "Hello"


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (String(data="ä"), {"data": "ä"}),
        (array.array("i", [1, 2]), [1, 2]),
        (np.zeros(2), [0.0, 0.0]),
        (b"\x01\x02", [1, 2]),
        (math.nan, "NaN"),
        (-math.inf, "-Infinity"),
        ([String(data="a")], [{"data": "a"}]),
        (True, True),
    ],
)
def test_everything_has_a_form_in_json(value, expected):
    assert json_value(value) == expected
    json.dumps(json_value(value), allow_nan=False)
