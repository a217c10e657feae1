"""Waits without an executor for a message, and with one for an event of its own making."""

import rclpy
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.event_handler import EventHandler, QoSPublisherEventType, QoSPublisherMatchedInfo
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerGuardCondition
from rclpy.waitable import Waitable
from std_msgs.msg import String


def wait_for_one(node, publisher):
    subscription = node.create_subscription(String, "chatter", print, QoSProfile(depth=1))
    with node.context.handle, subscription.handle:
        wait_set = _rclpy.WaitSet(1, 1, 0, 0, 0, 0, node.context.handle)
        wait_set.add_subscription(subscription.handle)
        wait_set.add_guard_condition(SignalHandlerGuardCondition(context=node.context).handle)
        publisher.publish(String(data="one"))
        wait_set.wait(10 * 10**9)
        assert not wait_set.get_ready_entities("guard_condition")
        assert subscription.handle.pointer in wait_set.get_ready_entities("subscription")
        message, info = subscription.handle.take_message(String, False)
    assert (message.data, info["publication_sequence_number"]) == ("one", 1)


def wait_for_match(node, publisher):
    matched = rclpy.Future()
    handler = EventHandler(
        callback_group=ReentrantCallbackGroup(),
        callback=matched.set_result,
        event_type=QoSPublisherEventType.RCL_PUBLISHER_MATCHED,
        parent_impl=publisher.handle,
    )
    assert isinstance(handler, Waitable)
    node.add_waitable(handler)
    node.create_subscription(String, "chatter", print, 1)
    rclpy.spin_until_future_complete(node, matched, timeout_sec=10)
    assert isinstance(matched.result(), QoSPublisherMatchedInfo)
    node.remove_waitable(handler)


with rclpy.init():
    node = rclpy.create_node("waiting_by_hand")
    publisher = node.create_publisher(String, "chatter", 10)
    wait_for_one(node, publisher)
    wait_for_match(node, publisher)
    node.destroy_node()
print("done")
