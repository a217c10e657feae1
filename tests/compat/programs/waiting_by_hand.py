"""Wait sets without an executor, and an executor that waits for an event of a publisher."""

import rclpy
import rclpy.clock
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.event_handler import EventHandler, QoSPublisherEventType, QoSPublisherMatchedInfo
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerGuardCondition
from rclpy.waitable import Waitable
from std_msgs.msg import String
from std_srvs.srv import Trigger


def wait_for_one(node, publisher):
    subscription = node.create_subscription(String, "chatter", print, QoSProfile(depth=1))
    with node.context.handle, subscription.handle:
        wait_set = _rclpy.WaitSet(1, 1, 1, 0, 0, 0, node.context.handle)
        wait_set.add_subscription(subscription.handle)
        wait_set.add_guard_condition(SignalHandlerGuardCondition(context=node.context).handle)
        publisher.publish(String(data="one"))
        wait_set.wait(10 * 10**9)
        assert not wait_set.get_ready_entities("guard_condition")
        assert subscription.handle.pointer in wait_set.get_ready_entities("subscription")
        message, info = subscription.handle.take_message(String, False)
    assert (message.data, info["publication_sequence_number"]) == ("one", 1)


def wait_for_tick(node):
    clock = rclpy.clock.Clock(clock_type=rclpy.clock.ClockType.STEADY_TIME)
    with clock.handle, node.context.handle:
        timer = _rclpy.Timer(clock.handle, node.context.handle, 1000, True)
        wait_set = _rclpy.WaitSet(0, 0, 1, 0, 0, 0, node.context.handle)
        index = wait_set.add_timer(timer)
        wait_set.wait(-1)
        assert wait_set.is_ready("timer", index)
        timer.call_timer()


def serve_and_call(node):
    qos = QoSProfile(depth=10).get_c_qos_profile()
    with node.handle, node.context.handle:
        server = _rclpy.Service(node.handle, Trigger, "go", qos)
        client = _rclpy.Client(node.handle, Trigger, "go", qos)
        wait_set = _rclpy.WaitSet(0, 0, 0, 1, 1, 0, node.context.handle)
        wait_set.add_service(server)
        wait_set.add_client(client)
        number = client.send_request(Trigger.Request())
        wait_set.wait(10 * 10**9)
        request, header = server.service_take_request(Trigger.Request)
        assert isinstance(request, Trigger.Request)
        server.service_send_response(Trigger.Response(success=True), header)
        wait_set.wait(10 * 10**9)
        info, response = client.take_response(Trigger.Response)
    assert (info.request_id.sequence_number, response.success) == (number, True)


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
    wait_for_tick(node)
    serve_and_call(node)
    wait_for_match(node, publisher)
    node.destroy_node()
print("done")
