"""Peer process with zenoh-ros2-sdk, which shares no code with teleopctl.

``python foreign_peer.py talk|listen|serve|call PORT`` connects to the router at a TCP port. Type
definitions are passed to the SDK, so that it downloads none.
"""

import sys
import threading

from zenoh_ros2_sdk import ROS2Publisher, ROS2ServiceClient, ROS2ServiceServer, ROS2Subscriber

STRING = "std_msgs/msg/String"
STRING_HASH = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
ADD = "example_interfaces/srv/AddTwoInts"
ADD_HASH = "RIHS01_e118de6bf5eeb66a2491b5bda11202e7b68f198d6f67922cf30364858239c81a"
ADD_TEXTS = {
    "request_definition": "int64 a\nint64 b\n",
    "response_definition": "int64 sum\n",
    "type_hash": ADD_HASH,
}


def talk(**where):
    publisher = ROS2Publisher(
        "/chatter", STRING, "string data\n", "sdk_talker", type_hash=STRING_HASH, **where
    )
    print("ready", flush=True)
    pause = threading.Event()
    for number in range(200):
        publisher.publish(data=f"hello {number}")
        pause.wait(0.05)


def listen(**where):
    heard = threading.Event()

    def receive(message):
        print(f"heard {message.data}", flush=True)
        heard.set()

    ROS2Subscriber(
        "/chatter", STRING, receive, "string data\n", "sdk_listener", type_hash=STRING_HASH, **where
    )
    print("ready", flush=True)
    heard.wait(20)


def call(**where):
    client = ROS2ServiceClient(
        "/add_two_ints", ADD, node_name="sdk_client", timeout=2.0, **ADD_TEXTS, **where
    )
    # The SDK does not wait for the service: a request without a route in the router returns None.
    while (answer := client.call(a=20, b=22)) is None:
        pass
    print(f"sum {answer.sum}", flush=True)


def serve(**where):
    answered = threading.Event()

    def add(request):
        answered.set()
        return server.response_msg_class(sum=request.a + request.b)

    server = ROS2ServiceServer(
        "/add_two_ints", ADD, add, node_name="sdk_server", **ADD_TEXTS, **where
    )
    print("ready", flush=True)
    answered.wait(20)
    sys.stdin.read()


if __name__ == "__main__":
    roles = {"talk": talk, "listen": listen, "call": call, "serve": serve}
    roles[sys.argv[1]](router_ip="127.0.0.1", router_port=int(sys.argv[2]))
