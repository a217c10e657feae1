"""The other side of the transport benchmark: answers each message with a small one.

``python echo_peers.py raw|node TYPE`` runs until its standard input closes. ``raw`` is plain
zenoh, ``node`` is our node receiving messages of TYPE; both answer on another topic as soon as the
message has been decoded.
"""

import sys
import threading

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
    return zenoh.open(config)


def raw(_: str) -> None:
    session = open_raw()
    pong = session.declare_publisher(PONG_KEY)

    def answer(sample):
        sample.payload.to_bytes()
        pong.put(b"ok")

    session.declare_subscriber(PING_KEY, answer)
    print("ready", flush=True)
    sys.stdin.read()
    session.close()


def node(type_name: str) -> None:
    from teleopctl.interfaces.store import get_message
    from teleopctl.node import Node, SingleThreadedExecutor, init, shutdown

    init(args=[])
    empty = get_message("std_msgs/msg/Empty")
    echo = Node("echo")
    pong = echo.create_publisher(empty, "pong", 10)
    echo.create_subscription(get_message(type_name), "ping", lambda _: pong.publish(empty()), 10)
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
    {"raw": raw, "node": node}[sys.argv[1]](sys.argv[2])
