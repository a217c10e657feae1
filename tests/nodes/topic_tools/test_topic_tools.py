"""Topics are relayed, thinned out, delayed, selected and transformed, as by ROS 2's topic_tools."""

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import pytest

from teleopctl import plugins
from teleopctl.errors import InvalidMessageError, UsageError
from teleopctl.interfaces import get_message, serialize
from teleopctl.node import Node, SingleThreadedExecutor, init, raw_message_class
from teleopctl.nodes.topic_tools import serialized
from teleopctl.nodes.topic_tools.expressions import field_function, transform_function
from teleopctl.testing import RosGraph, eventually

String = get_message("std_msgs/msg/String")
HELLO = bytes(serialize(String(data="hello")))


@pytest.fixture
def user(ros: RosGraph) -> Iterator[Node]:
    del ros
    with init(args=[]), Node("user") as node:
        yield node


def sent_by(tool: Any) -> list[bytes]:
    """Return the list to which a tool's messages go from now on."""
    sent: list[bytes] = []
    tool.publish = sent.append
    return sent


def test_a_topic_of_an_unknown_type_is_relayed_with_its_qos(user):
    strange = raw_message_class("strange_msgs/msg/Thing", "RIHS01_" + "1" * 64)
    publisher = user.create_publisher(strange, "things", 10)
    got: list[bytes] = []
    user.create_subscription(strange, "copies", got.append, 10, raw=True)
    relay = serialized.Relay({"input_topic": "things", "output_topic": "copies"})
    executor = SingleThreadedExecutor()
    for node in (user, relay):
        executor.add_node(node)

    def arrives() -> bool:
        publisher.publish(HELLO)
        executor.spin_once(0.01)
        return bool(got)

    eventually(arrives)
    assert got[0] == HELLO
    # Without a publisher, nothing is left.
    user.destroy_publisher(publisher)

    def is_gone() -> bool:
        relay.look()
        return relay.count_publishers("copies") == 0

    eventually(is_gone)
    relay.destroy_node()
    executor.shutdown()


def test_containers_load_each_tool_by_its_name_in_ros2(user):
    names = [name for name in plugins.COMPONENTS.builtin if name.startswith("topic_tools::")]
    tools = ("Delay", "Demux", "Drop", "Mux", "Relay", "Throttle")
    assert sorted(names) == [f"topic_tools::{tool}Node" for tool in tools]
    for name in names:
        # A container gives the parameters beside the constructor; without them, one is missing.
        with pytest.raises(UsageError, match="needs the parameter"):
            plugins.load(plugins.COMPONENTS, name)()


def test_drop_leaves_out_the_first_x_of_y(user):
    tool = serialized.Drop({"input_topic": "a", "X": 1, "Y": 3})
    sent = sent_by(tool)
    for number in range(6):
        tool.process(bytes([number]))
    assert [message[0] for message in sent] == [1, 2, 4, 5]
    tool.destroy_node()


@pytest.mark.parametrize(
    ("parameters", "kept"),
    [
        ({"throttle_type": "messages", "msgs_per_sec": 2.0}, [5, 10]),
        # Three bytes each: two of them in any window of 0.5 s.
        ({"throttle_type": "bytes", "bytes_per_sec": 4, "window": 0.5}, [0, 1, 6, 7]),
    ],
)
def test_throttle_limits_messages_or_bytes(user, parameters, kept):
    tool = serialized.Throttle({"input_topic": "a", **parameters})
    sent = sent_by(tool)
    begin = tool._last_ns
    for tenths in range(11):
        now = SimpleNamespace(nanoseconds=begin + tenths * 100_000_000)
        tool._clock = SimpleNamespace(now=lambda now=now: now)
        tool.process(bytes([tenths, 0, 0]))
    assert [message[0] for message in sent] == kept
    tool.destroy_node()


def test_delay_publishes_later(user):
    tool = serialized.TopicDelay({"input_topic": "a", "delay": 0.01})
    sent = sent_by(tool)
    tool.process(HELLO)
    assert not sent
    executor = SingleThreadedExecutor()
    executor.add_node(tool)

    def came() -> bool:
        executor.spin_once(0.01)
        return bool(sent)

    eventually(came)
    assert sent == [HELLO]
    executor.shutdown()
    tool.destroy_node()


@pytest.mark.parametrize("kind", ["mux", "demux"])
def test_topics_are_added_selected_listed_and_deleted(user, kind):
    make: Any = serialized.Mux if kind == "mux" else serialized.Demux
    several = "input_topics" if kind == "mux" else "output_topics"
    tool = make({several: ["/a", "b"]})
    responses = []

    def call(verb: str, topic: str) -> Any:
        response = SimpleNamespace(success=False, prev_topic="", topics=[])
        responses.append(response)
        return getattr(tool, f"_on_{verb}")(SimpleNamespace(topic=topic), response)

    assert tool.selected == "/a"
    assert call("select", "/b").success
    assert (tool.selected, responses[-1].prev_topic) == ("/b", "/a")
    assert not call("select", "/c").success
    assert not call("add", "/b").success
    assert not call("add", "__none").success
    assert call("add", "/c").success
    assert not call("delete", "b").success  # the selected one
    assert call("delete", "a").success
    assert call("list", "").topics == ["b", "/c"]
    assert call("select", "__none").success
    assert call("select", "c").prev_topic == ""
    tool.destroy_node()


def test_a_tool_without_its_parameter_names_it(user):
    with pytest.raises(UsageError, match="relay needs the parameter 'input_topic'"):
        serialized.Relay({})
    with pytest.raises(UsageError, match="Unknown throttle type 'x'"):
        serialized.Throttle({"input_topic": "a", "throttle_type": "x"})


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("relay", {}),
        ("relay a b", {"input_topic": "a", "output_topic": "b"}),
        ("drop a 1 2", {"input_topic": "a", "X": 1, "Y": 2}),
        ("delay a 0.5 b", {"input_topic": "a", "delay": 0.5, "output_topic": "b"}),
        (
            "throttle bytes a 1024 1.0",
            {"throttle_type": "bytes", "input_topic": "a", "bytes_per_sec": 1024, "window": 1.0},
        ),
        (
            "throttle messages a 2 b",
            {
                "throttle_type": "messages",
                "input_topic": "a",
                "msgs_per_sec": 2.0,
                "output_topic": "b",
            },
        ),
        ("mux out a b", {"output_topic": "out", "input_topics": ["a", "b"]}),
        ("demux in a", {"input_topic": "in", "output_topics": ["a"]}),
        ("drop a 1", "Incorrect number of arguments: a 1"),
        ("relay a b c", "Incorrect number of arguments: a b c"),
        ("mux out", "Incorrect number of arguments: out"),
        ("delay a soon", "delay is 'soon', expected a number"),
        ("throttle often a", "Unknown throttle type 'often'"),
    ],
)
def test_the_words_of_a_program_are_its_parameters(line, expected):
    program, *words = line.split()
    if isinstance(expected, dict):
        assert serialized.parse_words(program, words) == expected
    else:
        with pytest.raises(UsageError) as raised:
            serialized.parse_words(program, words)
        assert raised.value.message == expected
        assert (raised.value.hint or "").startswith(f"usage: {program} ")


def test_an_expression_makes_a_message_of_a_message_or_of_a_field():
    length = transform_function("[m, m * 2]", "data", ["math"])
    assert length(String(data="ab")) == ["ab", "abab"]
    square = transform_function("math.sqrt(len(m.data))", None, ["math"])
    assert square(String(data="abcd")) == [2.0]
    with pytest.raises(InvalidMessageError, match=r"Invalid field 'data\.x'"):
        transform_function("m", "data.x", [])(String())
    with pytest.raises(InvalidMessageError, match=r"Expression 'm\.nothing' failed"):
        transform_function("m.nothing", None, [])(String())
    with pytest.raises(UsageError, match=r"Wrong expression 'm \+'"):
        transform_function("m +", None, [])
    with pytest.raises(UsageError, match="Failed to import module: no_such_module"):
        transform_function("m", None, ["no_such_module"])


def test_fields_go_to_a_message_of_another_type_and_other_texts_stay():
    make = field_function("std_msgs/Header", "{stamp: {sec: 3}, frame_id: m.data}")
    (header,) = make(String(data="base"))
    assert (header.stamp.sec, header.frame_id) == (3, "base")
    assert field_function("std_msgs/String", "{data: base_link}")(String())[0].data == "base_link"
    with pytest.raises(InvalidMessageError, match="Invalid field"):
        field_function("std_msgs/String", "{data: m.nothing}")(String())
    with pytest.raises(UsageError, match="dictionary in YAML format"):
        field_function("std_msgs/String", "3")
