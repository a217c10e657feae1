"""Types that a text defines, apart from those of this process."""

import pytest

from teleopctl.errors import InvalidDefinitionError, InvalidMessageError, InvalidTypeNameError
from teleopctl.interfaces import (
    complete_definition_text,
    deserialize,
    get_message,
    hash_of_text,
    list_types,
    message_of_text,
    serialize,
    type_hash,
)

PART = "=" * 80
NEWER_POINT = f"""\
float64 x
float64 y
float64 z
string frame
{PART}
MSG: geometry_msgs/Vector3
float64 x
"""


def test_what_is_known_here_with_the_same_fields_is_the_class_of_this_process():
    for name in list_types("msg")[::20]:
        assert message_of_text(name, complete_definition_text(name)) is get_message(name)


def test_another_version_of_a_known_type_is_read_by_its_text_and_the_known_one_stays():
    newer = message_of_text("geometry_msgs/msg/Point", NEWER_POINT)
    sent = newer(x=1.0, y=2.0, z=3.0, frame="tool")
    read = deserialize(serialize(sent), newer)
    assert read == sent
    assert read.frame == "tool"
    assert not hasattr(get_message("geometry_msgs/msg/Point")(), "frame")


def test_a_type_that_uses_another_version_of_a_known_type_gets_that_version():
    text = f"geometry_msgs/Point[] points\n{PART}\nMSG: geometry_msgs/Point\n{NEWER_POINT}"
    cloud = message_of_text("my_robot/msg/Cloud", text)
    point = message_of_text("geometry_msgs/msg/Point", NEWER_POINT)(x=1.5, frame="map")
    empty = cloud()
    assert deserialize(serialize(empty), cloud) == empty
    received = bytes(serialize(empty)[:4]) + (1).to_bytes(8, "little") + bytes(serialize(point)[4:])
    assert deserialize(received, cloud).points[0].frame == "map"


def test_an_unknown_type_may_use_types_of_this_process_that_its_text_leaves_out():
    stamped = message_of_text("my_robot/msg/Stamped", "std_msgs/Header header\nint8[] values")
    message = stamped(values=[1, -2])
    message.header.frame_id = "base"
    assert deserialize(serialize(message), stamped) == message


def test_types_without_a_part_of_their_own_are_named_when_they_are_used():
    lost = message_of_text("my_robot/msg/Lost", "my_robot/Missing inner")
    with pytest.raises(InvalidMessageError, match="my_robot/msg/Missing"):
        lost()


def test_idl_is_read_as_well():
    text = f"""\
{PART}
IDL: my_robot/msg/Grip
module my_robot {{ module msg {{
  struct Grip {{ double force; sequence<string> fingers; my_robot::msg::Tip tip; }};
}}; }};
{PART}
IDL: my_robot/msg/Tip
module my_robot {{ module msg {{ struct Tip {{ float at[3]; boolean is_soft; }}; }}; }};
"""
    grip = message_of_text("my_robot/msg/Grip", text, "ros2idl")
    message = grip(force=2.5, fingers=["left", "right"])
    message.tip.is_soft = True
    assert deserialize(serialize(message), grip) == message


@pytest.mark.parametrize(
    ("name", "text", "encoding", "error"),
    [
        ("my_robot/msg/A", "no such line", "ros2msg", InvalidDefinitionError),
        ("my_robot/msg/A", f"{PART}\nMSG: my_robot/B\nint8 b", "ros2msg", InvalidDefinitionError),
        ("my_robot/msg/A", "struct {", "ros2idl", InvalidDefinitionError),
        ("my_robot/msg/A", "message A {}", "protobuf", InvalidDefinitionError),
        ("my_robot/msg/A", f"int8 a\n{PART}\nMSG: ../x\n", "ros2msg", InvalidTypeNameError),
        ("A", "int8 a", "ros2msg", InvalidTypeNameError),
    ],
)
def test_texts_that_define_nothing_are_refused(name, text, encoding, error):
    with pytest.raises(error):
        message_of_text(name, text, encoding)


def test_a_type_that_contains_itself_is_refused_when_bytes_are_read():
    loop = message_of_text("my_robot/msg/Loop", "my_robot/Loop[] loops")
    with pytest.raises(InvalidMessageError, match="contains itself"):
        deserialize(b"\0\1\0\0\0\0\0\0", loop)


def test_the_file_of_a_service_defines_its_events_as_rosbag2_writes_it():
    here = "example_interfaces/srv/AddTwoInts_Event"
    text = "int64 a\nint64 b\n---\nint64 sum\n"
    assert message_of_text(here, text) is get_message(here)
    assert hash_of_text(here, text) == type_hash(here)
    nested = f"my_robot/Finger finger\n---\nbool done\n{PART}\nMSG: my_robot/Finger\nfloat64 angle"
    event = message_of_text("my_robot/srv/Grip_Event", nested)
    assert deserialize(serialize(event()), event) == event()
