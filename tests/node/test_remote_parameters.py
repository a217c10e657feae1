"""Other nodes' parameters: the client, the handler of events, files, and QoS overrides."""

import threading
import time
from typing import Any

import pytest

from teleopctl.errors import TeleopctlError, UnavailableError
from teleopctl.interfaces import parameter_value_to_python
from teleopctl.interfaces.store import get_message
from teleopctl.node import Node, Parameter, QoSProfile, ReliabilityPolicy
from teleopctl.node.endpoints.qos_overrides import InvalidQosOverridesError, QoSOverridingOptions
from teleopctl.node.parameters.client import AsyncParameterClient, call_parameter_services
from teleopctl.node.parameters.events import ParameterEventHandler
from teleopctl.node.parameters.store import result
from teleopctl.node.values.exceptions import ParameterNotDeclaredException
from teleopctl.node.values.parameter_file import parameter_messages

STRING = get_message("std_msgs/msg/String")
VALUE = get_message("rcl_interfaces/msg/ParameterValue")


@pytest.fixture
def robot(make_node):
    node = make_node("robot")
    node.declare_parameter("arm.speed", 1.5)
    node.declare_parameter("arm.wrist.name", "left")
    with pytest.warns(UserWarning, match="by its name only"):
        node.declare_parameter("free")
    return node


@pytest.fixture
def ask(make_node, robot, executor):
    client = AsyncParameterClient(make_node("asker"), "robot")
    assert client.wait_for_services(10.0)
    assert client.services_are_ready()

    def ask(method, *args):
        future = getattr(client, method)(*args)
        executor.spin_until_future_complete(future, 10.0)
        return future.result()

    return ask


def test_a_client_reads_what_another_node_has(ask):
    values = ask("get_parameters", ["arm.speed", "arm.wrist.name"]).values
    assert [parameter_value_to_python(value) for value in values] == [1.5, "left"]
    assert list(ask("get_parameter_types", ["arm.speed"]).types) == [Parameter.Type.DOUBLE]
    assert ask("describe_parameters", ["arm.speed"]).descriptors[0].name == "arm.speed"
    listed = ask("list_parameters", ["arm"], 1).result
    assert (listed.names, listed.prefixes) == (["arm.speed"], ["arm"])


def test_a_client_sets_and_takes_away(ask, robot):
    results = ask("set_parameters", [Parameter("arm.speed", value=2.0), Parameter("x", value=1)])
    assert [each.successful for each in results.results] == [True, False]
    assert ask("set_parameters_atomically", [Parameter("free", value=3)]).result.successful
    assert (robot.get_parameter("arm.speed").value, robot.get_parameter("free").value) == (2.0, 3)
    assert ask("delete_parameters", ["free"]).results[0].successful
    assert not robot.has_parameter("free")


def test_a_client_waits_no_longer_than_it_is_told(make_node):
    assert not AsyncParameterClient(make_node(), "nobody").wait_for_services(0.0)


def test_many_nodes_are_asked_at_once_and_each_answers_for_itself(context, make_node, executor):
    make_node("left").declare_parameter("side", "l")
    make_node("right").declare_parameter("side", "r")
    asker = Node("asker", context=context)
    hanging = [Node(f"hanging_{number}", context=context) for number in range(3)]
    spinner = threading.Thread(target=executor.spin)
    spinner.start()
    names = ["/left", "/right", "/nobody", *(node.get_fully_qualified_name() for node in hanging)]
    began = time.monotonic()
    answers: dict[str, Any] = call_parameter_services(
        asker, names, lambda remote: remote.get_parameters(["side"]), 1.0
    )
    # One deadline for all: three that hang do not take three seconds.
    assert time.monotonic() - began < 2.5
    assert list(answers) == names
    sides = [parameter_value_to_python(answers[name].values[0]) for name in names[:2]]
    assert sides == ["l", "r"]
    assert all(isinstance(answers[name], UnavailableError) for name in names[2:])
    assert "no server" in answers["/nobody"].message
    assert answers["/hanging_0"].message == "Node '/hanging_0' did not answer within 1 s"
    context.shutdown()
    spinner.join(10.0)


def test_a_client_has_no_more_in_the_graph_than_it_uses(context, make_node):
    asker = make_node("asker")
    client = AsyncParameterClient(asker, "robot")

    def asked():
        return {token.name for token in asker.graph().endpoints if token.kind.name == "SC"}

    assert asked() == set()
    client.get_parameters(["x"])
    assert asked() == {"/robot/get_parameters"}
    client.services_are_ready()
    assert len(asked()) == 6


def test_a_file_is_set_with_and_without_the_section_for_every_node(ask, robot, tmp_path):
    file = tmp_path / "robot.yaml"
    file.write_text(
        "robot:\n  ros__parameters:\n    arm:\n      speed: 4.0\n"
        "/**:\n  ros__parameters:\n    arm.speed: 9.0\n    free: 7\n"
    )
    assert list(parameter_messages(file)) == ["arm.speed"]
    assert list(parameter_messages(file, namespace="left")) == ["left.arm.speed"]
    assert all(each.successful for each in ask("load_parameter_file", file, True).results)
    assert (robot.get_parameter("arm.speed").value, robot.get_parameter("free").value) == (4.0, 7)
    with pytest.raises(TeleopctlError, match="has none for /other"):
        parameter_messages(file, target_nodes=["other"])


def test_a_handler_calls_back_for_one_parameter_and_for_all(make_node, robot, spin_until):
    order: list[tuple[str, object]] = []
    handler = ParameterEventHandler(make_node("watcher"))
    handler.add_parameter_callback("arm.speed", "robot", lambda p: order.append(("first", p.name)))
    newer = handler.add_parameter_callback(
        "arm.speed", "/robot", lambda p: order.append(("newer", p.value.double_value))
    )
    handler.add_parameter_callback("arm.speed", "", lambda p: order.append(("own", p.name)))
    handler.add_parameter_event_callback(lambda event: order.append(("event", event.node)))
    robot.set_parameters([Parameter("arm.speed", value=2.5)])
    spin_until(lambda: ("event", "/robot") in order)
    assert order == [("newer", 2.5), ("first", "arm.speed"), ("event", "/robot")]
    handler.remove_parameter_callback(newer)
    with pytest.raises(RuntimeError, match="doesn't exist"):
        handler.remove_parameter_callback(newer)


def test_a_value_may_be_given_as_a_message(robot):
    value = VALUE(type=int(Parameter.Type.INTEGER), integer_value=3)
    assert robot.declare_parameter("count", value).value == 3


def test_setting_what_was_not_declared_raises(robot):
    with pytest.raises(ParameterNotDeclaredException):
        robot.set_parameters([Parameter("unknown", value=1)])
    with pytest.raises(ParameterNotDeclaredException):
        robot.set_parameters_atomically([Parameter("unknown", value=1)])


def test_a_node_lists_its_parameters(robot):
    listed = robot.list_parameters(["arm"], 0)
    assert (listed.names, listed.prefixes) == (
        ["arm.speed", "arm.wrist.name"],
        ["arm", "arm.wrist"],
    )


def test_a_parameter_without_a_value_keeps_its_type_and_has_no_value(ask, robot):
    robot.declare_parameter("goal", Parameter.Type.STRING)
    assert ask("describe_parameters", ["goal"]).descriptors[0].type == Parameter.Type.STRING
    assert ask("get_parameters", ["goal"]).values == []


def test_parameters_override_the_quality_of_service(make_node):
    node = make_node(
        parameter_overrides=[
            Parameter("qos_overrides./chatter.subscription_mine.reliability", value="best_effort"),
            Parameter("qos_overrides./chatter.subscription_mine.depth", value=3),
        ]
    )
    profile = QoSProfile(depth=10)
    options = QoSOverridingOptions.with_default_policies(entity_id="mine")
    made = node.create_subscription(
        STRING, "chatter", print, profile, qos_overriding_options=options
    )
    assert made.qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT
    assert (made.qos_profile.depth, profile.depth) == (3, 10)
    assert node.get_parameter("qos_overrides./chatter.subscription_mine.history").value == (
        "keep_last"
    )


@pytest.mark.parametrize("value", ["sometimes", "reliable"])
def test_an_override_that_is_wrong_or_refused_raises(make_node, value):
    node = make_node(
        parameter_overrides=[
            Parameter("qos_overrides./chatter.publisher.reliability", value=value),
        ]
    )
    options = QoSOverridingOptions.with_default_policies(
        callback=lambda profile: result(False, "not for us")
    )
    with pytest.raises(InvalidQosOverridesError, match=r"sometimes|not for us"):
        node.create_publisher(STRING, "chatter", 10, qos_overriding_options=options)


SECTIONS = """
/**: {ros__parameters: {everywhere: 1, own: 1}}
/one: {ros__parameters: {absolute: 1, own: 2}}
one: {ros__parameters: {relative: 1}}
/left/two: {ros__parameters: {joined: 1}}
/left: {two: {ros__parameters: {nested: 1}}}
/*: {two: {ros__parameters: {any_namespace: 1}}}
/**/two: {ros__parameters: {any_depth: 1}}
/a/b/two: {ros__parameters: {deep: 1}}
"""


@pytest.mark.parametrize(
    ("targets", "exact", "wild"),
    [
        ([], "absolute own relative joined nested deep", "everywhere any_namespace any_depth"),
        (["one"], "absolute own relative", "everywhere"),
        (["/left/two"], "joined nested", "everywhere own any_namespace any_depth"),
        (["/a/b/two"], "deep", "everywhere own any_depth"),
        (["one", "/a/b/two"], "absolute own relative deep", "everywhere any_depth"),
    ],
)
def test_sections_with_wildcards_are_meant_for_the_nodes_that_rclpy_takes(
    tmp_path, targets, exact, wild
):
    file = tmp_path / "p.yaml"
    file.write_text(SECTIONS)
    assert set(parameter_messages(file, False, targets)) == set(exact.split())
    assert set(parameter_messages(file, True, targets)) == set(f"{exact} {wild}".split())
    assert parameter_messages(file, True, ["one"])["own"].value.integer_value == 2
