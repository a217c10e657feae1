"""Node that the commands of the start-up benchmark inspect, call and subscribe to.

Serves ``/trigger`` and the action ``/fibonacci``, publishes ``/chatter`` at 1 kHz, so that a
subscriber hardly waits for a message, and subscribes to ``/heard``.
"""

from teleopctl.interfaces import get_action, get_message, get_service
from teleopctl.node import ActionServer, Node, SingleThreadedExecutor, init


def main() -> None:
    init(args=[])
    node = Node("peer")
    string, trigger = get_message("std_msgs/msg/String"), get_service("std_srvs/srv/Trigger")
    publisher = node.create_publisher(string, "/chatter", 10)
    node.create_timer(0.001, lambda: publisher.publish(string(data="x")))
    node.create_subscription(string, "/heard", lambda _: None, 10)
    node.create_service(trigger, "/trigger", lambda _, response: response)
    ActionServer(node, get_action("example_interfaces/action/Fibonacci"), "/fibonacci", print)
    node.declare_parameter("rate", 5)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    print("ready", flush=True)
    executor.spin()


if __name__ == "__main__":
    main()
