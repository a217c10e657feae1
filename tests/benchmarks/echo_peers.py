"""The other side of the transport benchmark: tells when messages have come.

``python echo_peers.py raw|node TYPE COUNT EVERY`` subscribes so many times and runs until its
standard input closes. ``raw`` is plain zenoh, ``node`` our node receiving messages of TYPE; of each
EVERY messages a subscription answers the last one, with the time at which it was decoded.
"""

import itertools
import sys
import threading
import time

PING_KEY, PONG_KEY = "benchmark/ping", "benchmark/pong"


def open_raw():
    """A peer session with nothing of ours but the address of the router."""
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
    {"raw": raw, "node": node}[sys.argv[1]](sys.argv[2], int(sys.argv[3]), int(sys.argv[4]))
