"""Process with zenoh-ros2-sdk, an independent implementation of rmw_zenoh's wire protocol.

``sdk_program talker|listener PORT DOMAIN``: the talker publishes each line of its standard input on
``/chatter``; the listener prints the messages received on ``/chatter``.
"""

import sys

from zenoh_ros2_sdk import ROS2Publisher, ROS2Subscriber

role, port, domain = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
common = {
    "topic": "/chatter",
    "msg_type": "std_msgs/msg/String",
    "msg_definition": "string data\n",
    "namespace": "/",
    "node_name": f"sdk_{role}",
    "domain_id": domain,
    "router_port": port,
}
if role == "talker":
    publisher = ROS2Publisher(**common)
    print("up", flush=True)
    for line in sys.stdin:
        publisher.publish(data=line.strip())
else:
    subscriber = ROS2Subscriber(
        callback=lambda message: print(f"heard {message.data}", flush=True), **common
    )
    print("up", flush=True)
    sys.stdin.read()
