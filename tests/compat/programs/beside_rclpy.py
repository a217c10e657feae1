"""Packages other than rclpy that programs import, used as in their documentation."""

import message_filters
import numpy as np
import rclpy
import tf2_ros
import tf2_sensor_msgs  # noqa: F401 -- registers the type with buffers
from geometry_msgs.msg import PointStamped, TransformStamped
from message_filters import ApproximateTimeSynchronizer, Cache, SimpleFilter, TimeSynchronizer
from rclpy.clock import ClockType, JumpThreshold, ROSClock
from rclpy.duration import Duration
from rclpy.exceptions import InvalidHandle
from rclpy.task import Task
from rclpy.time import Time
from rclpy.time_source import TimeSource
from rosidl_parser.definition import BoundedSequence, NamespacedType, UnboundedString
from rosidl_runtime_py import (
    get_message_interfaces,
    message_to_ordereddict,
    message_to_yaml,
    set_message_fields,
)
from rosidl_runtime_py.utilities import get_message, get_service, is_message, is_service
from sensor_msgs.msg import JointState, PointCloud2, PointField
from sensor_msgs_py import point_cloud2
from std_msgs.msg import Header, String


def at(seconds):
    return Time(seconds=seconds, clock_type=ClockType.ROS_TIME)


def point(seconds, x):
    made = PointStamped()
    made.header.stamp = at(seconds).to_msg()
    made.point.x = x
    return made


def synchronizing():
    left, right, got = SimpleFilter(), SimpleFilter(), []
    TimeSynchronizer([left, right], 10).registerCallback(lambda a, b: got.append((a, b)))
    left.signalMessage(point(1.0, 1.0))
    right.signalMessage(point(2.0, 2.0))
    right.signalMessage(point(1.0, 3.0))
    assert [(a.point.x, b.point.x) for a, b in got] == [(1.0, 3.0)]

    left, right, got = SimpleFilter(), SimpleFilter(), []
    nearly = ApproximateTimeSynchronizer([left, right], 10, slop=0.1)
    nearly.registerCallback(lambda a, b, tag: got.append((a.point.x, b.point.x, tag)), "tag")
    left.signalMessage(point(1.0, 1.0))
    left.signalMessage(point(1.06, 2.0))
    right.signalMessage(point(1.2, 3.0))
    right.signalMessage(point(1.05, 4.0))
    assert got == [(2.0, 4.0, "tag")], got

    source = SimpleFilter()
    cache = Cache(source, 2)
    for seconds in (1.0, 2.0, 3.0):
        source.signalMessage(point(seconds, seconds))
    assert [m.point.x for m in cache.getInterval(at(0), at(9))] == [2.0, 3.0]
    assert cache.getElemAfterTime(at(2.5)).point.x == 3.0
    assert cache.getElemBeforeTime(at(2.5)).point.x == 2.0
    assert cache.getOldestTime() == at(2.0)
    source.signalMessage(String())  # has no time
    assert cache.getLast().point.x == 3.0


def subscribing(node):
    got = []
    subscriber = message_filters.Subscriber(node, PointStamped, "points")
    subscriber.registerCallback(got.append)
    assert subscriber.getTopic() == "points"
    assert subscriber.topic_name == "/points"
    publisher = node.create_publisher(PointStamped, "points", 10)
    publisher.publish(point(1.0, 5.0))
    while not got:
        rclpy.spin_once(node)
    assert got[0].point.x == 5.0


def borrowed():
    """Check names that programs import from modules that merely import them."""
    from rclpy.action.client import Future
    from rclpy.clock import Duration as SameDuration
    from rclpy.node import MsgType, MutuallyExclusiveCallbackGroup, SetParametersResult
    from rclpy.parameter import ParameterType, get_parameter_value
    from tf2_geometry_msgs import PointStamped as SamePoint

    assert tf2_ros.TransformStamped is TransformStamped
    assert tf2_ros.Duration is SameDuration is Duration
    assert SamePoint is PointStamped
    assert SetParametersResult(successful=True).successful
    assert ParameterType.PARAMETER_STRING == 4
    assert isinstance(MutuallyExclusiveCallbackGroup, type)
    assert MsgType is not None
    assert not Future().done()
    assert not hasattr(rclpy.node, "Nodes")
    assert get_parameter_value(string_value="[1, 2]").integer_array_value.tolist() == [1, 2]
    assert BoundedSequence(UnboundedString(), 3).has_maximum_size()
    assert not UnboundedString().has_maximum_size()


def reflecting():
    assert (UnboundedString(),) == String.SLOT_TYPES
    assert JointState.SLOT_TYPES[0] == NamespacedType(["std_msgs", "msg"], "Header")
    assert str(JointState.SLOT_TYPES[2]).startswith("UnboundedSequence(")
    assert String(data="x", check_fields=False) == String(data="x")
    assert is_message(get_message("std_msgs/String"))
    assert is_service(get_service("std_srvs/srv/Trigger"))
    assert "msg/String" in get_message_interfaces(["std_msgs"])["std_msgs"]
    made = JointState()
    stamps = set_message_fields(
        made, {"header": "auto", "name": ["a"], "position": [1]}, expand_header_auto=True
    )
    stamps[0](Time(seconds=3).to_msg())
    assert (made.header.stamp.sec, made.name, list(made.position)) == (3, ["a"], [1.0])
    assert message_to_ordereddict(made)["name"] == ["a"]
    assert message_to_yaml(String(data="x")) == "data: x\n"
    for wrong, error in (({"nam": []}, AttributeError), ({"name": 3}, TypeError)):
        try:
            set_message_fields(made, wrong)
        except error:
            continue
        raise AssertionError(wrong)


def clouds():
    fields = [
        PointField(name=name, offset=4 * n, datatype=PointField.FLOAT32, count=1)
        for n, name in enumerate(("x", "y", "z", "intensity"))
    ]
    cloud = point_cloud2.create_cloud(Header(frame_id="lidar"), fields, [(1.0, 0.0, 0.0, 9.0)])
    step = TransformStamped(child_frame_id="lidar")
    step.header.frame_id = "base"
    step.transform.translation.z = 1.0
    step.transform.rotation.z = step.transform.rotation.w = 0.5**0.5
    buffer = tf2_ros.Buffer()
    buffer.set_transform_static(step, "test")
    moved = buffer.transform(cloud, "base")
    assert isinstance(moved, PointCloud2)
    assert moved.header.frame_id == "base"
    (got,) = point_cloud2.read_points(moved)
    assert np.allclose([*got], (0.0, 1.0, 1.0, 9.0), atol=1e-6), got


def entities(node):
    publisher = node.create_publisher(String, "words", 10)
    timer = node.create_timer(1.0, lambda: None)
    for entity in (node, publisher, timer):
        with entity.handle:
            pass
    assert publisher.logger_name == node.get_logger().name
    assert publisher.event_handlers == []
    publisher.destroy()
    try:
        with publisher.handle:
            raise AssertionError
    except InvalidHandle:
        pass
    task = Task(lambda x: x + 1, args=(1,))
    assert not task.executing()
    task()
    assert task.result() == 2


def clocks(node):
    clock, source, jumps = ROSClock(), TimeSource(node=node), []
    threshold = JumpThreshold(min_forward=Duration(seconds=1), min_backward=None)
    clock.create_jump_callback(threshold, post_callback=lambda jump: jumps.append(jump.delta))
    source.attach_clock(clock)
    node.set_parameters([rclpy.Parameter("use_sim_time", value=True)])
    assert clock.ros_time_is_active
    clock.set_ros_time_override(Time(seconds=5, clock_type=clock.clock_type))
    assert jumps[-1] == Duration(seconds=5)
    source.detach_node()


def main():
    rclpy.init()
    node = rclpy.create_node("programs")
    synchronizing()
    subscribing(node)
    borrowed()
    reflecting()
    clouds()
    entities(node)
    clocks(node)
    node.destroy_node()
    rclpy.shutdown()
    print("done")


main()
