"""Received bytes and messages that are not as they should be."""

import struct
import traceback
import tracemalloc
from random import Random
from typing import Any

import pytest
from hypothesis import given, strategies as st

from teleopctl.errors import TeleopctlError
from teleopctl.interfaces.cdr import deserialize, serialize
from teleopctl.interfaces.cdr.codec import Codecs
from teleopctl.interfaces.message import make_class
from teleopctl.interfaces.parser import parse
from teleopctl.interfaces.store import add_definition_text, get_message
from tests.interfaces.cdr.test_oracle import KNOWN, SEED, type_names
from tests.interfaces.messages import random_message

TYPE_NAMES = KNOWN["msg"]
# Of a message of a hundred bytes: its object, lists, and the texts of an error.
MOST_BYTES = 200_000
LITTLE = b"\0\1\0\0"

add_definition_text("hostile_msgs/msg/Texts", "string[] data\n")
add_definition_text("hostile_msgs/msg/Empty", "")
add_definition_text("hostile_msgs/msg/Empties", "Empty[] data\n")
add_definition_text(
    "hostile_msgs/msg/Bounded",
    "int16[<=2] numbers\nstring[<=2] texts\nEmpty[<=2] messages\nstring<=2 text\n",
)
add_definition_text("hostile_msgs/msg/Lists", "byte[] octets\nbool[2] bools\nfloat64[2] numbers\n")
EMPTY = get_message("hostile_msgs/msg/Empty")()


def check(data, message_class):
    """Read bytes; a result must be able to be sent, and to be read again as the same."""
    try:
        message = deserialize(data, message_class)
    except TeleopctlError as error:
        assert message_class.TYPE_NAME in error.message
        return
    again = serialize(message)
    assert serialize(deserialize(again, message_class)) == again


@given(st.sampled_from(TYPE_NAMES), st.binary(max_size=300), st.booleans())
def test_nonsense_of_any_type_is_a_message_or_an_error(type_name, content, little):
    check(bytes((0, little, 0, 0)) + content, get_message(type_name))


@given(st.sampled_from(TYPE_NAMES), st.integers(0, 2**32), st.booleans(), st.data())
def test_damage_of_any_type_is_a_message_or_an_error(type_name, seed, little, data):
    payload = serialize(random_message(Random(seed), type_name))
    payload[1] = little  # else everything is read in the wrong byte order
    for _ in range(data.draw(st.integers(1, 3))):
        at = data.draw(st.integers(4, len(payload) - 1))
        new = data.draw(st.sampled_from([b"\0", b"\xff", b"\xff\xff\xff\xff", b"\1", b"\x7f"]))
        payload[at : at + len(new)] = new
    check(payload, get_message(type_name))
    check(payload[: data.draw(st.integers(0, len(payload)))], get_message(type_name))


def spoilt(source: Random, payload: bytes) -> list[bytes]:
    """What may come instead of a payload: a part of it, chance, and counts beyond reason."""
    cut = source.randrange(len(payload))
    at = source.randrange(4, len(payload) + 1)
    return [
        payload[:cut],
        payload[:-1],
        LITTLE + source.randbytes(60),
        payload[:at] + b"\xff\xff\xff\x7f" + payload[at + 4 :],
        payload[:at] + b"\xff\xff\0\0" + payload[at + 4 :],
    ]


def test_no_bytes_for_a_type_raise_anything_else_or_take_much_memory():
    for name in type_names():
        message_class, source = get_message(name), Random(SEED or name)
        for _ in range(1 if SEED is None else 20):
            payload = bytes(serialize(random_message(source, name)))
            check(payload, message_class)  # what is made once stays out of the measurement
            tracemalloc.start()
            for data in spoilt(source, payload):
                check(data, message_class)
            _, most = tracemalloc.get_traced_memory()
            tracemalloc.stop()
            assert most < MOST_BYTES + 100 * len(payload), name


@pytest.mark.parametrize(
    "name",
    [
        "hostile_msgs/msg/Texts",
        "hostile_msgs/msg/Empties",
        "std_msgs/msg/String",
        "tf2_msgs/msg/TFMessage",
        "geometry_msgs/msg/Polygon",
        "example_interfaces/msg/Float64MultiArray",
    ],
)
@pytest.mark.parametrize("order", ["<", ">"])
def test_a_count_that_the_bytes_cannot_hold_is_refused_at_once(name, order):
    for count in (30, 2**31, 2**32 - 1):
        data = bytes((0, order == "<", 0, 0)) + struct.pack(f"{order}I", count) + bytes(20)
        with pytest.raises(TeleopctlError):
            deserialize(data, get_message(name))


def read(definitions, name):
    """Read zeros with types that nobody but this function knows."""
    classes: dict[str, Any] = {}
    for short, text in definitions.items():
        definition = parse(text, f"own_msgs/msg/{short}", "own_msgs")
        classes[definition.type_name] = make_class(definition, classes.__getitem__)
    data = LITTLE + bytes(1000)
    read_message = Codecs(classes.__getitem__).reader(f"own_msgs/msg/{name}", is_little=True)
    return read_message(data, memoryview(data), 4, len(data))


def test_an_array_that_the_bytes_cannot_hold_is_refused_at_once():
    with pytest.raises(ValueError, match="sequence length 1000000"):
        read({"Inner": "string data\n", "Outer": "Inner[1000000] data\n"}, "Outer")


def test_a_type_that_contains_itself_cannot_be_received():
    with pytest.raises(TeleopctlError, match="contains itself"):
        read({"Ring": "Circle[] data\n", "Circle": "Ring[] data\n"}, "Ring")


def test_a_type_that_is_nested_beyond_reason_cannot_be_received():
    chain = {f"N{number}": f"N{number + 1} data\n" for number in range(2000)}
    with pytest.raises(TeleopctlError, match="nested too deeply"):
        read({**chain, "N2000": "string data\n"}, "N0")


@pytest.mark.parametrize(
    ("field", "values", "spoil"),
    [
        ("numbers", [1, 2], lambda m: m.numbers.append(3)),
        ("texts", ["a", "b"], lambda m: m.texts.append("c")),
        ("messages", [], lambda m: m.messages.extend([EMPTY] * 3)),
    ],
)
def test_bounds_hold_for_what_is_sent(field, values, spoil):
    message = get_message("hostile_msgs/msg/Bounded")(**{field: values})
    serialize(message)
    spoil(message)
    with pytest.raises(TeleopctlError, match=f"{field}: expected .* got 3 elements"):
        serialize(message)


@pytest.mark.parametrize(
    "content",
    [
        struct.pack("<I3h2x2I", 3, 1, 2, 3, 0, 0) + struct.pack("<I", 1) + b"\0",
        struct.pack("<4I", 0, 0, 0, 4) + b"abc\0",
        struct.pack("<3I", 0, 0, 3) + bytes(4) + struct.pack("<I", 1) + b"\0",
    ],
)
def test_bounds_hold_for_what_is_received(content):
    with pytest.raises(TeleopctlError, match=r"length [34]"):
        deserialize(LITTLE + content, get_message("hostile_msgs/msg/Bounded"))


@pytest.mark.parametrize(
    "spoil",
    [
        lambda m: m.octets.append(b"ab"),
        lambda m: m.octets.append("a"),
        lambda m: m.bools.append(True),
    ],
)
def test_a_list_or_an_array_that_was_spoilt_is_not_sent(spoil):
    message = get_message("hostile_msgs/msg/Lists")()
    spoil(message)
    with pytest.raises(TeleopctlError, match="hostile_msgs/msg/Lists cannot be serialised"):
        serialize(message)


def test_every_buffer_can_be_read():
    data = bytes(serialize(get_message("std_msgs/msg/UInt8MultiArray")(data=b"abc")))
    for buffer in (bytearray(data), memoryview(data), memoryview(bytearray(data))):
        message = deserialize(buffer, get_message("std_msgs/msg/UInt8MultiArray"))
        assert message.data.tobytes() == b"abc"


def test_a_traceback_shows_the_generated_code():
    message = get_message("tf2_msgs/msg/TFMessage")(transforms=[])
    message.transforms.append("no transform")
    with pytest.raises(TeleopctlError) as caught:
        serialize(message)
    shown = "".join(traceback.format_exception(caught.value.__cause__))
    assert "cdr/geometry_msgs/msg/TransformStamped/write_nested.py" in shown
    assert "m_0 = m._header" in shown
