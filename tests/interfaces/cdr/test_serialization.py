"""CDR against vectors from the wire, against rosbags, and against nonsense."""

import array
import contextlib
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st
from rosbags.typesys import Stores, get_typestore

from teleopctl.errors import TeleopctlError
from teleopctl.interfaces.cdr import as_numpy, deserialize, serialize
from teleopctl.interfaces.definition import Shape
from teleopctl.interfaces.store import (
    add_definition_text,
    get_action,
    get_message,
    get_service,
    list_types,
)
from tests.interfaces.messages import REPRESENTATIVE_TYPES, any_message, string_cdr
from tests.samples import sample

String = get_message("std_msgs/msg/String")
Image = get_message("sensor_msgs/msg/Image")
JointState = get_message("sensor_msgs/msg/JointState")
AddTwoInts = get_service("example_interfaces/srv/AddTwoInts")
Fibonacci = get_action("example_interfaces/action/Fibonacci")
UUID = get_message("unique_identifier_msgs/msg/UUID")
Time = get_message("builtin_interfaces/msg/Time")

VECTORS = [
    (String(data="hi"), "00010000 03000000 686900"),
    (String(data="hello 0"), "00010000 08000000 68656c6c6f203000"),
    (AddTwoInts.Request(a=20, b=22), "00010000 1400000000000000 1600000000000000"),
    (AddTwoInts.Response(sum=43), "00010000 2b00000000000000"),
    (get_service("std_srvs/srv/Trigger").Request(), "00010000 00"),
    (get_message("std_msgs/msg/Empty")(), "00010000 00"),
    (
        Fibonacci.Impl.SendGoalService.Request(
            goal_id=UUID(uuid=bytes(range(16))), goal=Fibonacci.Goal(order=5)
        ),
        "00010000 000102030405060708090a0b0c0d0e0f 05000000",
    ),
    (
        Fibonacci.Impl.SendGoalService.Response(accepted=True, stamp=Time(sec=1, nanosec=2)),
        "00010000 01 000000 01000000 02000000",
    ),
    (
        Fibonacci.Impl.GetResultService.Response(
            status=4, result=Fibonacci.Result(sequence=[0, 1, 1, 2])
        ),
        "00010000 04 000000 04000000 00000000 01000000 01000000 02000000",
    ),
    (JointState(), "00010000" + "00" * 8 + "01000000 00 000000" + "00000000" * 4),
]


@pytest.mark.parametrize(("message", "payload"), VECTORS, ids=lambda value: str(value)[:40])
def test_payloads_are_those_on_the_wire(message, payload):
    data = bytes.fromhex(payload)
    assert serialize(message) == data
    assert deserialize(data, type(message)) == message


def _foreign(message: Any, store: Any) -> Any:
    """Return the same message as an object of rosbags."""
    values = {}
    for field in message.__definition__.wire_fields:
        kind = field.type
        if not message.__definition__.fields:
            values[field.name] = 0
            continue
        value = getattr(message, field.attribute)
        if kind.is_nested:
            value = (
                _foreign(value, store)
                if kind.shape is Shape.SINGLE
                else [_foreign(element, store) for element in value]
            )
        elif kind.base == "byte":  # signed for rosbags
            value = np.frombuffer(b"".join([value] if kind.shape is Shape.SINGLE else value), "b")
            value = int(value[0]) if kind.shape is Shape.SINGLE else value
        elif kind.shape is not Shape.SINGLE and kind.base != "string":
            dtype = {"bool": np.bool_, "char": np.uint8}.get(kind.base, kind.base)
            value = np.array(value, dtype=dtype)
        values[field.attribute] = value
    return store.types[message.TYPE_NAME](**values)


@pytest.fixture(scope="module")
def foreign_store() -> Any:
    return get_typestore(Stores.ROS2_JAZZY)


@given(any_message(allow_nan=True))
def test_bytes_are_those_of_rosbags(foreign_store, message):
    foreign = _foreign(message, foreign_store)
    ours = bytes(serialize(message))
    assert ours == bytes(foreign_store.serialize_cdr(foreign, message.TYPE_NAME))
    big = foreign_store.serialize_cdr(foreign, message.TYPE_NAME, little_endian=False)
    assert bytes(serialize(deserialize(big, type(message)))) == ours


@given(any_message())
def test_a_message_survives_the_round_trip(message):
    data = serialize(message)
    received = deserialize(data, type(message))
    assert received == message
    assert repr(received) == repr(message)
    assert serialize(received) == data


@given(st.sampled_from(REPRESENTATIVE_TYPES), st.binary(max_size=200), st.booleans())
def test_nonsense_is_a_message_or_an_error(type_name, content, little):
    with contextlib.suppress(TeleopctlError):
        deserialize(bytes((0, little, 0, 0)) + content, get_message(type_name))


@given(any_message(), st.data())
def test_a_message_that_was_cut_or_changed_is_no_surprise(message, data):
    payload = serialize(message)
    position = data.draw(st.integers(0, len(payload) - 1))
    payload[position] ^= data.draw(st.integers(1, 255))
    for damaged in (payload, payload[:position]):
        with contextlib.suppress(TeleopctlError):
            deserialize(damaged, type(message))


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"", "encapsulation"),
        (b"\0\1", "early|struct|unpack"),
        (b"\0\3\0\0\0", "encapsulation 00030000"),
        (string_cdr(b"abc")[:-2], "string length"),
        (string_cdr(b"\xff\xfe"), "utf-8"),
        (b"\0\1\0\0\xff\xff\xff\xff", "string length"),
    ],
)
def test_bytes_that_are_no_message_are_refused(data, reason):
    with pytest.raises(TeleopctlError, match=reason) as caught:
        deserialize(data, String)
    assert "std_msgs/msg/String" in caught.value.message


@given(any_message(), st.binary(min_size=1, max_size=100))
def test_bytes_behind_a_message_do_not_count(message, behind):
    payload = serialize(message)
    assert serialize(deserialize(payload + behind, type(message))) == payload


def test_known_types_can_be_sent_and_received():
    classes = [get_message(name) for name in sample(list_types("msg"), 5)]
    for service in map(get_service, sample(list_types("srv"), 5)):
        classes += [service.Request, service.Response, service.Event]
    for action in map(get_action, sample(list_types("action"), 5)):
        classes += [action.Impl.FeedbackMessage, action.Impl.GetResultService.Response]
    for cls in classes:
        # A default such as 0.1 is another number as a float32.
        data = serialize(cls())
        assert serialize(deserialize(data, cls)) == data


def test_received_blocks_are_views_until_they_are_read():
    data = bytes(serialize(Image(data=bytes(range(100)))))
    message = deserialize(data, Image)
    view = as_numpy(message, "data")
    assert np.shares_memory(view, np.frombuffer(data, np.uint8))
    assert serialize(message) == data
    assert message.data == array.array("B", range(100))
    assert message.data is message.data


def test_assigned_blocks_are_not_copied_before_they_are_sent():
    picture = np.zeros((4, 4, 3), np.uint8)
    message = Image(data=picture)
    assert np.shares_memory(as_numpy(message, "data"), picture)


def test_a_received_fixed_array_can_be_changed():
    info = get_message("sensor_msgs/msg/CameraInfo")(k=range(9))
    received = deserialize(bytes(serialize(info)), type(info))
    received.k[0] = 100.0
    assert received.k.tolist() == [100.0, *range(1, 9)]


def test_numbers_in_numpy_form():
    assert as_numpy(JointState(position=[1, 2]), "position").tolist() == [1.0, 2.0]
    value = get_message("rcl_interfaces/msg/ParameterValue")(bool_array_value=[True, False])
    assert as_numpy(value, "bool_array_value").tolist() == [True, False]
    with pytest.raises(TeleopctlError, match="holds no numbers"):
        as_numpy(JointState(), "name")
    with pytest.raises(TeleopctlError, match="no field"):
        as_numpy(JointState(), "names")


@pytest.mark.parametrize(
    ("spoil", "where"),
    [
        (lambda m: m.transforms.append("x"), "transforms: element 1: expected geometry_msgs"),
        (lambda m: setattr(m.transforms[0].header, "frame_id", "\ud800"), "header.frame_id"),
    ],
)
def test_a_message_spoilt_after_assignment_names_the_field(spoil, where):
    transform = get_message("geometry_msgs/msg/TransformStamped")()
    message = get_message("tf2_msgs/msg/TFMessage")(transforms=[transform])
    spoil(message)
    with pytest.raises(TeleopctlError) as caught:
        serialize(message)
    assert caught.value.message.startswith("tf2_msgs/msg/TFMessage cannot be serialised: trans")
    assert where in caught.value.message


def test_only_messages_can_be_sent():
    with pytest.raises(TeleopctlError, match="not a message class"):
        serialize("text")  # type: ignore[arg-type]  # which is the question
    with pytest.raises(TeleopctlError, match="not a message class"):
        deserialize(b"", str)


def wide(**values):
    add_definition_text("wide_msgs/msg/Wide", "wstring data\nwstring<=3[] more\nuint8 last\n")
    return get_message("wide_msgs/msg/Wide")(**values)


def test_wide_strings_are_counted_utf_16_units_without_an_end():
    message = wide(data="h\u00e4\U0001f916", more=["", "x"], last=7)
    payload = bytes.fromhex(
        "00010000 04000000 6800 e400 3ed8 16dd 02000000 00000000 01000000 7800 07".replace(" ", "")
    )
    assert serialize(message) == payload
    assert deserialize(payload, type(message)) == message
    swapped = bytes.fromhex(
        "00000000 00000004 0068 00e4 d83e dd16 00000002 00000000 00000001 0078 07".replace(" ", "")
    )
    assert deserialize(swapped, type(message)) == message


@given(st.text(), st.lists(st.text(max_size=3)))
def test_wide_strings_come_back(text, more):
    message = wide(data=text, more=more)
    assert deserialize(serialize(message), type(message)) == message


@given(st.binary(max_size=40))
def test_nonsense_for_wide_strings_is_refused_or_can_be_printed(data):
    with contextlib.suppress(TeleopctlError):
        read = deserialize(b"\0\1\0\0" + data, type(wide()))
        str(read).encode()


def test_nan_is_kept():
    value = get_message("std_msgs/msg/Float32")(data=math.nan)
    assert math.isnan(deserialize(serialize(value), type(value)).data)
