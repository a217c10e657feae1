"""``rclpy.time_source``. Time source for clocks of a program: follows ``/clock`` as a node does."""

from typing import TYPE_CHECKING

from teleopctl.interfaces import get_message
from teleopctl.node import ClockType, Node, Parameter, QoSProfile, ReliabilityPolicy, ROSClock, Time

if TYPE_CHECKING:
    from rosgraph_msgs.msg import Clock

    from teleopctl.node import Subscription

__all__ = ["CLOCK_TOPIC", "USE_SIM_TIME_NAME", "TimeSource"]

CLOCK_TOPIC = "/clock"
USE_SIM_TIME_NAME = "use_sim_time"


class TimeSource:
    """Sets clocks to ``/clock`` while a node's ``use_sim_time`` is true.

    A node's own clock needs none.

    Args:
        node: The node whose parameter is followed, and which subscribes.
    """

    def __init__(self, *, node: Node | None = None) -> None:
        self._node: Node | None = None
        self._clocks: list[ROSClock] = []
        self._active = False
        self._last = Time(clock_type=ClockType.ROS_TIME)
        self._subscription: Subscription[Clock] | None = None
        if node is not None:
            self.attach_node(node)

    @property
    def ros_time_is_active(self) -> bool:
        """Whether the clocks follow ``/clock``."""
        return self._active

    @ros_time_is_active.setter
    def ros_time_is_active(self, enabled: bool) -> None:
        if enabled == self._active:
            return
        self._active = enabled
        for clock in self._clocks:
            clock.set_simulated(enabled)
        self._subscribe()

    def attach_node(self, node: Node) -> None:
        """Follow the parameter ``use_sim_time`` of a node, instead of the previous one.

        Raises:
            TypeError: It is no `Node`.
        """
        if not isinstance(node, Node):
            raise TypeError("Node must be of type rclpy.node.Node")
        if self._node is not None:
            self.detach_node()
        self._node = node
        if not node.has_parameter(USE_SIM_TIME_NAME):
            node.declare_parameter(USE_SIM_TIME_NAME, False)
        self._active = bool(node.get_parameter(USE_SIM_TIME_NAME).value)
        for clock in self._clocks:
            clock.set_simulated(self._active)
        self._subscribe()
        node.add_post_set_parameters_callback(self._follow)

    def detach_node(self) -> None:
        """Follow no node; the clocks keep their times."""
        node, self._node = self._node, None
        if node is not None:
            node.remove_post_set_parameters_callback(self._follow)
            if self._subscription is not None:
                node.destroy_subscription(self._subscription)
        self._subscription = None

    def attach_clock(self, clock: ROSClock) -> None:
        """Set a clock from now on.

        Raises:
            ValueError: It is no `ROSClock`.
        """
        if not isinstance(clock, ROSClock):
            raise ValueError("Only clocks with type ROS_TIME can be attached.")
        clock.set_ros_time_override(self._last)
        clock.set_simulated(self._active)
        self._clocks.append(clock)

    def clock_callback(self, msg: "Clock") -> None:
        """Set the clocks to the time of a message."""
        self._last = Time.from_msg(msg.clock)
        for clock in self._clocks:
            clock.set_ros_time_override(self._last)

    def _follow(self, parameters: list[Parameter]) -> None:
        for parameter in parameters:
            if parameter.name == USE_SIM_TIME_NAME:
                self.ros_time_is_active = bool(parameter.value)

    def _subscribe(self) -> None:
        if self._node is None:
            return
        if self._active and self._subscription is None:
            self._subscription = self._node.create_subscription(
                get_message("rosgraph_msgs/msg/Clock"),
                CLOCK_TOPIC,
                self.clock_callback,
                QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT),
            )
        elif not self._active and self._subscription is not None:
            self._node.destroy_subscription(self._subscription)
            self._subscription = None
