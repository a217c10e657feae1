"""Graph queries, and imports of less common modules; ends by itself."""

import sys

import rclpy
import rclpy.context
import rclpy.utilities
from action_msgs.srv import CancelGoal, CancelGoal_Response
from rcl_interfaces.srv import GetParameters
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.impl.rcutils_logger import RcutilsLogger
from rclpy.node import NodeNameNonExistentError
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSPresetProfiles, QoSProfile, QoSReliabilityPolicy
from rclpy.qos_event import PublisherEventCallbacks as OldName
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.serialization import deserialize_message, serialize_message
from rclpy.topic_endpoint_info import TopicEndpointTypeEnum
from rclpy.type_support import check_for_type_support
from rclpy.wait_for_message import wait_for_message
from ros2action.api import get_action_names
from ros2cli.node.strategy import NodeStrategy
from ros2node.api import NodeName, get_node_names, get_publisher_info, parse_node_name
from ros2param.api import call_get_parameters, call_set_parameters, get_value
from ros2service.api import get_service_class
from ros2topic.api import get_msg_class, get_topic_names, qos_profile_from_short_keys
from std_msgs.msg import String


def in_a_context_of_its_own(latched):
    context = rclpy.context.Context()
    rclpy.init(context=context)
    node = rclpy.create_node("apart", context=context)
    got, message = wait_for_message(
        String, node, "/other/spoken", qos_profile=latched, time_to_wait=10.0
    )
    assert (got, message.data) == (True, "kept")
    assert wait_for_message(String, node, "silent", time_to_wait=0.05) == (False, None)
    node.destroy_node()
    rclpy.shutdown(context=context)


def as_tools_of_ros2cli_do(node):
    assert parse_node_name("deep/asker").namespace == "/deep"
    assert NodeName("renamed", "/other", "/other/renamed") in get_node_names(node=node)
    (info,) = get_publisher_info(node=node, remote_node_name="/other/renamed")[:1]
    assert (info.name, info.types) == ("/other/spoken", ["std_msgs/msg/String"])
    assert "/other/spoken" in get_topic_names(node=node)
    assert get_msg_class(node, "spoken") is String
    assert get_msg_class(node, "/other/spoken") is String
    assert get_service_class(node, "/other/renamed/get_parameters", False) is GetParameters
    assert qos_profile_from_short_keys("sensor_data", depth=3).depth == 3
    assert get_action_names(node=node) == []
    call_set_parameters(
        node=node, node_name="/other/renamed", parameters=[Parameter("use_sim_time", value=False)]
    )
    (value,) = call_get_parameters(
        node=node, node_name="/other/renamed", parameter_names=["use_sim_time"]
    ).values
    assert get_value(parameter_value=value) is False
    with NodeStrategy(None) as tool:
        assert "/other/spoken" in get_topic_names(node=tool)
    assert rclpy.ok()


def main():
    rclpy.init(args=sys.argv)
    assert rclpy.utilities.remove_ros_args(sys.argv)[1:] == ["mine"]
    node = rclpy.create_node("asker", namespace="/deep")
    assert node.get_fully_qualified_name() == "/other/renamed"
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    publisher = node.create_publisher(
        String,
        "chatter",
        latched,
        event_callbacks=PublisherEventCallbacks(),
        qos_overriding_options=QoSOverridingOptions.with_default_policies(),
    )
    assert OldName is PublisherEventCallbacks
    node.create_subscription(
        String, "chatter", lambda m: None, 10, event_callbacks=SubscriptionEventCallbacks()
    )
    assert publisher.topic_name == "/other/spoken"
    (info,) = node.get_publishers_info_by_topic("chatter")
    assert (info.node_name, info.node_namespace) == ("renamed", "/other")
    assert info.topic_type == "std_msgs/msg/String"
    assert info.endpoint_type == TopicEndpointTypeEnum.PUBLISHER
    assert bytes(info.endpoint_gid) == publisher.gid
    assert info.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
    assert info.qos_profile.reliability == QoSReliabilityPolicy.RELIABLE
    assert publisher.get_subscription_count() == node.count_subscribers("chatter") == 1
    assert ("renamed", "/other") in node.get_node_names_and_namespaces()
    assert ("/other/spoken", ["std_msgs/msg/String"]) in node.get_topic_names_and_types()
    assert node.get_publisher_names_and_types_by_node("renamed", "/other")
    try:
        node.get_client_names_and_types_by_node("renamed", "/")
    except NodeNameNonExistentError as error:
        assert "'/renamed'" in str(error)
    else:
        raise AssertionError
    assert CancelGoal_Response is CancelGoal.Response
    assert [s.topic_name for s in node.subscriptions if s.topic_name == "/other/spoken"]
    publisher.publish(String(data="kept"))
    got, message = wait_for_message(String, node, "chatter", qos_profile=latched, time_to_wait=10.0)
    assert got
    assert message.data == "kept"
    in_a_context_of_its_own(latched)
    again = deserialize_message(serialize_message(message), String)
    assert again == message
    check_for_type_support(String)
    assert QoSPresetProfiles.SENSOR_DATA.value.depth == 5
    assert isinstance(node.get_logger(), RcutilsLogger)
    as_tools_of_ros2cli_do(node)
    print("done")
    # No destroy_node, no shutdown: the process must still end without errors.


if __name__ == "__main__":
    main()
