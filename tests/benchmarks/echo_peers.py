"""Receiver of the transport benchmark: answers messages with the time of their arrival.

``python echo_peers.py raw|hand|node TYPE COUNT EVERY`` creates COUNT subscriptions and runs until
its standard input closes. ``raw`` is plain Zenoh, ``node`` a teleopctl node that receives messages
of TYPE. Each subscription answers every EVERY-th message with the time at which it was decoded.

``hand`` is plain Zenoh with handwritten code, for two types only, for what ROS 2 requires: CDR, the
attachment, and callbacks that run one after the other on the spinning thread.
"""

import itertools
import queue
import struct
import sys
import threading
import time

PING_KEY, PONG_KEY = "benchmark/ping", "benchmark/pong"
HAND_PING_KEY, HAND_PONG_KEY = "benchmark/hand/ping", "benchmark/hand/pong"
STRING = "std_msgs/msg/String"

_ATTACHMENT = struct.Struct("<qqB16s")
_CDR = bytes((0, 1, 0, 0))
# Stamp, frame, height, width, encoding, byte order and step; the size of the data follows.
_IMAGE = _CDR + bytes(36)


def attachment(number: int) -> bytes:
    return _ATTACHMENT.pack(number, time.time_ns(), 16, bytes(16))


def packed(content: str | bytes) -> bytes:
    """Return the CDR of a String with a text, or of an Image with bytes."""
    if isinstance(content, str):
        text = content.encode()
        return struct.pack(f"<4sI{len(text) + 1}s", _CDR, len(text) + 1, text)
    return b"".join((_IMAGE, len(content).to_bytes(4, "little"), content))


def unpacked(type_name: str, data: bytes) -> str | memoryview:
    if type_name == STRING:
        return data[8 : 7 + int.from_bytes(data[4:8], "little")].decode()
    return memoryview(data)[len(_IMAGE) + 4 :]


def packed_number(number: int) -> bytes:
    return struct.pack("<4sQ", _CDR, number)


def open_raw():
    """Open a Zenoh peer session without teleopctl's code, by the address of the router."""
    import os

    import zenoh

    config = zenoh.Config()
    config.insert_json5("mode", '"peer"')
    config.insert_json5("connect/endpoints", f'["{os.environ["TELEOPCTL_ROUTER"]}"]')
    config.insert_json5("listen/endpoints", '["tcp/localhost:0"]')
    config.insert_json5("scouting/multicast/enabled", "false")
    config.insert_json5("transport/shared_memory/enabled", "true")
    return zenoh.open(config)


def raw(_: str, count: int, every: int) -> None:
    session = open_raw()
    pong = session.declare_publisher(PONG_KEY)

    def subscribe():
        numbers = itertools.count(1)

        def answer(sample):
            sample.payload.to_bytes()
            if next(numbers) % every == 0:
                pong.put(time.monotonic_ns().to_bytes(8, "little"))

        return session.declare_subscriber(PING_KEY, answer)

    subscribers = [subscribe() for _ in range(count)]
    print("ready", flush=True)
    sys.stdin.read()
    del subscribers
    session.close()


def hand(type_name: str, count: int, every: int) -> None:
    session = open_raw()
    pong = session.declare_publisher(HAND_PONG_KEY)
    arrived: queue.SimpleQueue = queue.SimpleQueue()
    sent = itertools.count(1)

    def subscribe():
        numbers = itertools.count(1)

        def answer(sample):
            _ATTACHMENT.unpack(sample.attachment.to_bytes())
            unpacked(type_name, sample.payload.to_bytes())
            if next(numbers) % every == 0:
                pong.put(packed_number(time.monotonic_ns()), attachment=attachment(next(sent)))

        return session.declare_subscriber(
            HAND_PING_KEY, lambda sample: arrived.put((answer, sample))
        )

    subscribers = [subscribe() for _ in range(count)]

    def end_with_stdin():
        sys.stdin.read()
        arrived.put(None)

    threading.Thread(target=end_with_stdin, daemon=True).start()
    print("ready", flush=True)
    while (arrival := arrived.get()) is not None:
        callback, sample = arrival
        callback(sample)
    del subscribers
    session.close()


def node(type_name: str, count: int, every: int) -> None:
    from teleopctl.interfaces.store import get_message
    from teleopctl.node import Node, SingleThreadedExecutor, init, shutdown

    init(args=[])
    when = get_message("std_msgs/msg/UInt64")
    echo = Node("echo")
    pong = echo.create_publisher(when, "pong", 100)

    def subscribe() -> None:
        numbers = itertools.count(1)

        def answer(_: object) -> None:
            if next(numbers) % every == 0:
                pong.publish(when(data=time.monotonic_ns()))

        echo.create_subscription(get_message(type_name), "ping", answer, 100)

    for _ in range(count):
        subscribe()
    executor = SingleThreadedExecutor()
    executor.add_node(echo)

    def end_with_stdin():
        sys.stdin.read()
        executor.shutdown()

    threading.Thread(target=end_with_stdin, daemon=True).start()
    print("ready", flush=True)
    executor.spin()
    echo.destroy_node()
    shutdown()


if __name__ == "__main__":
    kind, name, subscriptions, answered = sys.argv[1:]
    {"raw": raw, "hand": hand, "node": node}[kind](name, int(subscriptions), int(answered))
