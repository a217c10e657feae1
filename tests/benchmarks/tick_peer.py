"""Subscriber of the physics benchmark: ``python tick_peer.py TOPIC``.

Receives joint states on TOPIC and on ``/raw_states``, without decoding them, until its standard
input closes.
"""

import sys

from teleopctl.interfaces import get_message
from teleopctl.node import Node, init

if __name__ == "__main__":
    with init(args=[]), Node("tick_peer") as node:
        for topic in (sys.argv[1], "/raw_states"):
            node.create_subscription(
                get_message("sensor_msgs/msg/JointState"),
                topic,
                lambda data: None,
                10,
                raw=True,
                immediate=True,
            )
        print("ready", flush=True)
        sys.stdin.read()
