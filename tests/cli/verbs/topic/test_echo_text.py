"""What ``topic echo`` prints besides the messages, and with several topics."""

import json

import pytest

from teleopctl.cli.verbs.topic.echo import LossReport, MessagePrinter
from teleopctl.cli.verbs.topic.sources import TopicSource
from teleopctl.cli.verbs.topic.text import TextStyle
from teleopctl.interfaces import get_message
from teleopctl.node import MessageInfo
from teleopctl.wire.qos import EndpointQos
from teleopctl.wire.tokens import EndpointToken, EntityKind

String = get_message("std_msgs/msg/String")


def info(number, publisher=b"1"):
    return MessageInfo(
        source_timestamp=5,
        received_timestamp=6,
        publication_sequence_number=number,
        reception_sequence_number=0,
        publisher_gid=publisher,
    )


def printer(form="yaml", fields=(), *, with_info=False, names_topics=False, clears=False):
    return MessagePrinter(
        TextStyle(),
        fields,
        form,
        with_info=with_info,
        names_topics=names_topics,
        clears=clears,
    )


def written(text, capsys):
    text.write("/x", text.selected_values(String(data="hi")), info(7))
    return capsys.readouterr().out


def test_lost_messages_are_told_in_the_words_of_ros2(capsys):
    report = LossReport()
    for number, publisher in [(1, b"1"), (9, b"2"), (2, b"1"), (4, b"1"), (12, b"2")]:
        report.add(info(number, publisher))
    assert capsys.readouterr().err == (
        "A message was lost!!!\n\ttotal count change:1\n\ttotal count: 1---\n"
        "A message was lost!!!\n\ttotal count change:2\n\ttotal count: 3---\n"
    )


def test_the_topic_of_each_message_can_be_told_in_every_form(capsys):
    assert written(printer(names_topics=True), capsys) == "# /x\ndata: hi\n---\n"
    assert written(printer("csv", names_topics=True, with_info=True), capsys) == "/x,5,6,7,0,hi\n"
    as_json = written(printer("json", ["data"], names_topics=True, with_info=True), capsys)
    assert json.loads(as_json) == {
        "topic": "/x",
        "info": {
            "source_timestamp": 5,
            "received_timestamp": 6,
            "publication_sequence_number": 7,
            "reception_sequence_number": 0,
        },
        "message": "hi",
    }


@pytest.mark.parametrize("is_terminal", [True, False])
def test_only_a_terminal_is_cleared(capsys, monkeypatch, is_terminal):
    monkeypatch.setattr("sys.stdout.isatty", lambda: is_terminal)
    clear = "\x1b[H\x1b[2J" if is_terminal else ""
    assert written(printer(clears=True), capsys) == f"{clear}data: hi\n---\n"


def publisher(**qos):
    ends = ("/", "talker", "/x", "std_msgs/msg/String", "RIHS01_1")
    return EndpointToken(0, "1", 0, 1, EntityKind.MP, "", *ends, EndpointQos(**qos))


def test_it_is_said_what_publishers_that_differ_cost(capsys):
    source = TopicSource("/x", String, [publisher(), publisher(reliability=2, durability=1)])
    source.compatible_qos(10)
    assert capsys.readouterr().err == (
        "Some, but not all, publishers are offering QoSReliabilityPolicy.RELIABLE. Falling back "
        "to QoSReliabilityPolicy.BEST_EFFORT as it will connect to all publishers\n"
        "Some, but not all, publishers are offering QoSDurabilityPolicy.TRANSIENT_LOCAL. Falling "
        "back to QoSDurabilityPolicy.VOLATILE as it will connect to all publishers\n"
    )
    TopicSource("/x", String, [publisher(), publisher()]).compatible_qos(10)
    assert capsys.readouterr().err == ""
