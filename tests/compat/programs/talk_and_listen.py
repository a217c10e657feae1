"""A publisher and a subscriber in one process, class style and lambda style; ends by itself."""

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy, qos_profile_sensor_data
from std_msgs.msg import String


class MinimalPublisher(Node):
    def __init__(self):
        super().__init__("minimal_publisher")
        self.publisher_ = self.create_publisher(String, "topic", 10)
        self.timer = self.create_timer(0.01, self.timer_callback)
        self.i = 0

    def timer_callback(self):
        msg = String()
        msg.data = f"Hello World: {self.i}"
        self.publisher_.publish(msg)
        self.get_logger().info(f'Publishing: "{msg.data}"', throttle_duration_sec=1)
        self.i += 1


class MinimalSubscriber(Node):
    def __init__(self):
        super().__init__("minimal_subscriber")
        self.subscription = self.create_subscription(String, "topic", self.listener_callback, 10)
        self.heard = 0

    def listener_callback(self, msg):
        self.get_logger().info(f'I heard: "{msg.data}"')
        self.heard += 1
        if self.heard == 3:
            rclpy.shutdown()


def main(args=None):
    try:
        rclpy.init(args=["talk", "Ragnar\udcc3"])
    except UnicodeEncodeError:
        rclpy.init(args=args)
    executor = rclpy.executors.SingleThreadedExecutor()
    publisher = MinimalPublisher()
    subscriber = MinimalSubscriber()
    seen = []
    node = rclpy.create_node("lambda_listener")
    node.create_subscription(String, "topic", lambda msg: seen.append(msg.data), 10)
    node.create_subscription(String, "topic", seen.append, qos_profile_sensor_data)
    best_effort = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
    assert (best_effort.depth, best_effort.reliability) == (5, ReliabilityPolicy.BEST_EFFORT)
    for each in (publisher, subscriber, node):
        executor.add_node(each)
    try:
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        for each in (publisher, subscriber, node):
            each.destroy_node()
        rclpy.try_shutdown()
    assert subscriber.heard == 3
    assert seen
    print("done")


if __name__ == "__main__":
    main()
