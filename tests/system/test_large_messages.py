"""Messages of many megabytes between two processes."""

import threading

import psutil

from teleopctl.interfaces import get_message
from teleopctl.node import Context, Node
from teleopctl.testing import LONGEST_WAIT_S
from teleopctl.wire import EntityKind

IMAGE = "sensor_msgs/msg/Image"


def test_a_large_message_waits_for_a_receiver_that_is_busy_for_a_moment(ros, monkeypatch):
    # Through the socket, as the first ones go while shared memory is being set up.
    monkeypatch.setenv("ZENOH_CONFIG_OVERRIDE", "transport/shared_memory/enabled=false")
    listener = ros.spawn(["topic", "echo", "/image", IMAGE, "--once", "--field", "height"])
    context = Context()
    context.init([])
    try:
        with Node("talker", context=context) as node:
            publisher = node.create_publisher(get_message(IMAGE), "/image", 10)
            assert node.wait_for_match(EntityKind.MS, "/image", IMAGE, 1, LONGEST_WAIT_S)
            image = get_message(IMAGE)(height=7, data=bytes(30_000_000))
            process = psutil.Process(listener.pid)
            process.suspend()
            # More than the socket's buffers hold, and longer than Zenoh waits by itself.
            threading.Timer(0.15, process.resume).start()
            publisher.publish(image)
            listener.wait_for_line("7")
    finally:
        context.try_shutdown()
