import pytest

from teleopctl.interfaces.store import get_message, get_service
from teleopctl.node import qos_profile_latched
from teleopctl.testing import RosGraph

STRING = get_message("std_msgs/msg/String")
EMPTY = "std_srvs/srv/Empty"


def test_a_message_that_a_program_sends_is_waited_for(ros_graph):
    ros_graph.spawn("topic pub --rate 50 /chatter std_msgs/msg/String '{data: hello}'")
    assert ros_graph.wait_for_message(STRING, "/chatter").data == "hello"


def test_what_does_not_match_is_passed_over_and_stands_in_the_failure(ros_graph):
    ros_graph.spawn("topic pub --rate 50 /chatter std_msgs/msg/String '{data: hello}'")
    ros_graph.wait_for_message(STRING, "/chatter")
    with pytest.raises(AssertionError, match=r"no message on /chatter within 1 s: .*data='hello'"):
        ros_graph.wait_for_message(STRING, "/chatter", lambda m: m.data == "bye", timeout_s=1)
    with pytest.raises(AssertionError, match=r"no message on /silence .*: none came"):
        ros_graph.wait_for_message(STRING, "/silence", timeout_s=0.1)


def test_a_latched_message_is_heard_afterwards(ros_graph):
    publisher = ros_graph.node.create_publisher(STRING, "/latched", qos_profile_latched)
    publisher.publish(STRING(data="kept"))
    received = ros_graph.wait_for_message(STRING, "/latched", qos=qos_profile_latched)
    assert received.data == "kept"


def test_nodes_are_waited_for_and_those_that_are_there_are_named(ros_graph):
    ros_graph.spawn("run teleop_py_pkg simple_publisher")
    ros_graph.wait_for_nodes("/simple_publisher")
    with pytest.raises(AssertionError, match=r"no node /ghost within 0\.1 s; .*/simple_publisher"):
        ros_graph.wait_for_nodes("/simple_publisher", "/ghost", timeout_s=0.1)


def test_the_node_of_the_test_is_served_while_the_test_waits(ros_graph):
    ros_graph.node.create_service(get_service(EMPTY), "/nothing", lambda _, response: response)
    assert ros_graph.run(f"service call /nothing {EMPTY}").returncode == 0


def test_what_a_callback_of_the_test_raises_fails_the_next_wait(ros_graph):
    def fail(_):
        raise ValueError("mine")

    ros_graph.node.create_subscription(STRING, "/chatter", fail, 10)
    ros_graph.spawn("topic pub --rate 50 /chatter std_msgs/msg/String '{data: hello}'")
    with pytest.raises(ValueError, match="mine"):
        ros_graph.wait_for_message(STRING, "/silence")


def test_a_process_that_is_not_in_the_graph_is_told_so(tmp_path, monkeypatch):
    graph = RosGraph(tmp_path)
    with pytest.raises(RuntimeError, match="not in the graph"):
        graph.wait_for_nodes("/simple_publisher")
    # Nor is one in a graph that had the same port.
    monkeypatch.setenv("TELEOPCTL_ROUTER", graph.router)
    with pytest.raises(RuntimeError, match="not in the graph"):
        graph.wait_for_nodes("/simple_publisher")
