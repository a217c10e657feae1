"""Lifecycle node as in ROS 2's tutorials; fails to configure if ``stubborn`` is true."""

import contextlib

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from std_msgs.msg import String


class Lively(LifecycleNode):
    def __init__(self):
        super().__init__("lively")
        self.declare_parameter("stubborn", False)

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        if self.get_parameter("stubborn").value:
            return TransitionCallbackReturn.FAILURE
        self.publisher = self.create_lifecycle_publisher(String, "chatter", 10)
        self.timer = self.create_timer(0.05, self.talk)
        return super().on_configure(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        self.destroy_timer(self.timer)
        self.destroy_lifecycle_publisher(self.publisher)
        return super().on_cleanup(state)

    def talk(self):
        self.publisher.publish(String(data=f"active: {self.publisher.is_activated}"))


rclpy.init()
with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
    rclpy.spin(Lively())
