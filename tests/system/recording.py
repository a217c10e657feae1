"""Helpers of the tests of recording."""

from typing import Any

from rosbags.highlevel import AnyReader

from teleopctl.bag import RecorderOptions, Selection, open_bag
from teleopctl.interfaces import get_message, get_service
from teleopctl.node import HistoryPolicy, QoSProfile
from teleopctl.testing import eventually

String = get_message("std_msgs/msg/String")
SERVICES = "/rosbag2_recorder"


def select(*topics):
    """Return options that record only these topics."""
    return RecorderOptions(Selection(topics=topics), recording_metadata=False)


def contents(folder):
    """Return the messages of a bag by topic, decoded by rosbags."""
    found: dict[str, list[Any]] = {}
    with AnyReader([folder]) as reader:
        for connection, _, data in reader.messages():
            decoded = reader.deserialize(data, connection.msgtype)
            found.setdefault(connection.topic, []).append(getattr(decoded, "data", decoded))
    return found


# The publisher waits for a slow recorder instead of dropping messages.
PATIENT = QoSProfile(history=HistoryPolicy.KEEP_ALL)


def say(ros, topic, texts, qos=PATIENT, subscribers=1):
    """Wait for a number of subscribers, publish texts, and return the publisher."""
    publisher = ros.node.create_publisher(String, topic, qos)
    assert ros.node.wait_for_subscribers(topic, subscribers, 20)
    for text in texts:
        publisher.publish(String(data=text))
    return publisher


def call(ros, name, **fields):
    """Call a service of the recorder, and return the response."""
    service = get_service(f"rosbag2_interfaces/srv/{name}")
    snake = "".join(f"_{c.lower()}" if c.isupper() else c for c in name).lstrip("_")
    client = ros.node.create_client(service, f"{SERVICES}/{snake}")
    assert client.wait_for_service(20)
    answer = client.call_async(service.Request(**fields)).wait_for_response(20)
    assert answer is not None
    ros.node.destroy_client(client)
    return answer


def record(ros, *options):
    """Start a recorder, wait until it records, and return its process."""
    process = ros.spawn(["bag", "record", *options])
    process.wait_for_line("Recording...")
    return process


def stop(process):
    """Stop a recorder by Ctrl-C, and check its exit status and output."""
    process.interrupt()
    assert process.wait() == 0, process.report()
    assert "Recording stopped" in process.stderr


def wait_for_count(recorder, count):
    """Wait until a recorder has received a number of messages."""
    eventually(lambda: recorder.message_count == count)


def wait_until_written(folder, count):
    """Wait until a bag that is being written holds a number of messages."""
    eventually(lambda: written_count(folder) >= count)


def written_count(folder):
    """Return the number of messages in a bag that is being written."""
    with open_bag(folder) as bag:
        return sum(1 for _ in bag.messages())
