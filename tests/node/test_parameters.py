"""Parameters: declaration, overrides, checks, callbacks, and the services that show them."""

from typing import Any

import pytest

from teleopctl.interfaces import parameter_value_to_python, scalar_parameter_value
from teleopctl.interfaces.store import get_message, get_service
from teleopctl.node import Node, Parameter
from teleopctl.node.parameters.store import result
from teleopctl.node.values.exceptions import (
    InvalidParameterTypeException,
    InvalidParameterValueException,
    ParameterAlreadyDeclaredException,
    ParameterNotDeclaredException,
)
from teleopctl.node.values.parameter import parameter_value_from_yaml


@pytest.fixture
def node(make_node):
    return make_node("robot")


@pytest.mark.parametrize(
    "text",
    ["5", "-5", "1.5", "true", "no", "fast", "'5'", "1e3", "[1, 2]", "a: b", "null", "", "#"],
)
def test_a_scalar_is_read_without_pyyaml_as_with_it(text):
    quick = scalar_parameter_value(text)
    assert quick in (None, parameter_value_from_yaml(text))
    assert (quick is not None) == (text in ("5", "-5", "1.5", "true", "fast", "'5'"))


def test_every_node_has_the_parameters_of_an_rclpy_node(node):
    assert node.has_parameter("use_sim_time")
    assert node.has_parameter("start_type_description_service")


def test_a_declared_parameter_has_its_default(node):
    assert node.declare_parameter("speed", 1.5).value == 1.5
    assert node.get_parameter("speed").type_ == Parameter.Type.DOUBLE


def test_a_parameter_is_declared_once(node):
    node.declare_parameter("speed", 1.5)
    with pytest.raises(ParameterAlreadyDeclaredException):
        node.declare_parameter("speed", 2.0)


def test_parameters_that_share_a_descriptor_keep_their_names_and_types(node):
    fixed = get_message("rcl_interfaces/msg/ParameterDescriptor")(read_only=True)
    node.declare_parameter("speed", 1.5, fixed)
    node.declare_parameter("label", "a", fixed)
    told = [node.describe_parameter(name) for name in ("speed", "label")]
    assert [(each.name, each.type, each.read_only) for each in told] == [
        ("speed", Parameter.Type.DOUBLE.value, True),
        ("label", Parameter.Type.STRING.value, True),
    ]


def test_an_undeclared_parameter_cannot_be_read(node):
    with pytest.raises(ParameterNotDeclaredException):
        node.get_parameter("nothing")


def test_an_override_of_the_command_line_replaces_the_default(make_node):
    node = make_node("robot", cli_args=["--ros-args", "-p", "speed:=2.5", "-p", "name:=arm"])
    assert node.declare_parameter("speed", 1.5).value == 2.5
    assert node.declare_parameter("name", "x").value == "arm"


def test_an_override_of_the_program_replaces_that_of_the_command_line(make_node):
    node = make_node(
        cli_args=["--ros-args", "-p", "speed:=1.5"],
        parameter_overrides=[Parameter("speed", value=2.5)],
    )
    assert node.declare_parameter("speed", 0.0).value == 2.5


def test_several_are_declared_together_or_not_at_all(node):
    node.declare_parameter("there", 1)
    with pytest.raises(ParameterAlreadyDeclaredException):
        node.declare_parameters("", [("new", 1), ("there", 2)])
    assert not node.has_parameter("new")
    declared = node.declare_parameters("arm", [("speed", 1.0), ("speed", 2.0)])
    assert [(one.name, one.value) for one in declared] == [("arm.speed", 2.0)] * 2
    with pytest.raises(TypeError, match="descriptor"):
        node.declare_parameters("", [("new", 1, "described")])


def test_an_override_of_another_type_is_refused(make_node):
    node = make_node("robot", cli_args=["--ros-args", "-p", "speed:=fast"])
    with pytest.raises(InvalidParameterTypeException):
        node.declare_parameter("speed", 1.5)


def test_a_value_out_of_range_is_refused(node):
    descriptor = get_message("rcl_interfaces/msg/ParameterDescriptor")(
        integer_range=[
            get_message("rcl_interfaces/msg/IntegerRange")(from_value=0, to_value=10, step=2)
        ]
    )
    node.declare_parameter("count", 4, descriptor)
    assert not node.set_parameters([Parameter("count", value=12)])[0].successful
    assert not node.set_parameters([Parameter("count", value=5)])[0].successful
    assert node.set_parameters([Parameter("count", value=6)])[0].successful
    with pytest.raises(InvalidParameterValueException):
        node.declare_parameter("other", 11, descriptor)


def test_a_read_only_parameter_stays(node):
    descriptor = get_message("rcl_interfaces/msg/ParameterDescriptor")(read_only=True)
    node.declare_parameter("model", "x", descriptor)
    answer = node.set_parameters([Parameter("model", value="y")])[0]
    assert not answer.successful
    assert "read-only" in answer.reason
    assert node.get_parameter("model").value == "x"


def test_a_callback_refuses_and_its_reason_is_told(node):
    node.declare_parameter("speed", 1.0)
    node.add_on_set_parameters_callback(lambda parameters: result(False, "too fast"))
    answer = node.set_parameters([Parameter("speed", value=9.0)])[0]
    assert (answer.successful, answer.reason) == (False, "too fast")


@pytest.mark.parametrize("add", ["on_set", "pre_set"])
def test_a_callback_that_returns_nothing_refuses_the_change_and_is_warned_of(
    node, make_node, spin_until, add
):
    log: list[Any] = []
    make_node("listener").create_subscription(
        get_message("rcl_interfaces/msg/Log"), "/rosout", log.append, 10
    )
    node.declare_parameter("speed", 1.0)
    received: list[object] = []
    getattr(node, f"add_{add}_parameters_callback")(received.append)
    answer = node.set_parameters([Parameter("speed", value=9.0)])[0]
    assert (answer.successful, answer.reason) == (False, "Callback returned an invalid type")
    assert node.get_parameter("speed").value == 1.0
    assert len(received) == 1
    spin_until(lambda: any("list.append: Callback returned" in each.msg for each in log))


def test_together_means_all_or_none(node):
    node.declare_parameter("a", 1)
    node.declare_parameter("b", 1)
    answer = node.set_parameters_atomically([Parameter("a", value=2), Parameter("b", value="text")])
    assert not answer.successful
    assert node.get_parameter("a").value == 1


def test_another_node_reads_and_sets_them_by_service(node, make_node, executor):
    node.declare_parameter("speed", 1.5)
    client = make_node("asker")
    get = client.create_client(
        get_service("rcl_interfaces/srv/GetParameters"), "/robot/get_parameters"
    )
    assert get.wait_for_service(timeout_sec=10)
    future = get.call_async(get.srv_type.Request(names=["speed"]))
    executor.spin_until_future_complete(future, 10)
    assert parameter_value_to_python(future.result().values[0]) == 1.5

    set_ = client.create_client(
        get_service("rcl_interfaces/srv/SetParameters"), "/robot/set_parameters"
    )
    assert set_.wait_for_service(timeout_sec=10)
    wanted = Parameter("speed", value=2.5).to_parameter_msg()
    future = set_.call_async(set_.srv_type.Request(parameters=[wanted]))
    executor.spin_until_future_complete(future, 10)
    assert future.result().results[0].successful
    assert node.get_parameter("speed").value == 2.5


def test_an_unknown_name_is_answered_with_an_empty_list(node, make_node, executor):
    client = make_node("asker")
    get = client.create_client(
        get_service("rcl_interfaces/srv/GetParameters"), "/robot/get_parameters"
    )
    assert get.wait_for_service(timeout_sec=10)
    future = get.call_async(get.srv_type.Request(names=["use_sim_time", "nothing"]))
    executor.spin_until_future_complete(future, 10)
    assert list(future.result().values) == []


def test_a_change_is_an_event(node, make_node, spin_until):
    node.declare_parameter("speed", 1.5)
    events: list[Any] = []
    listener = make_node("listener")
    listener.create_subscription(
        get_message("rcl_interfaces/msg/ParameterEvent"), "/parameter_events", events.append, 10
    )
    node.set_parameters([Parameter("speed", value=2.5)])
    spin_until(lambda: any(event.changed_parameters for event in events))
    event = next(event for event in events if event.changed_parameters)
    assert event.node == "/robot"
    assert event.changed_parameters[0].name == "speed"


@pytest.mark.parametrize(
    ("word", "type_", "value"),
    [
        ("1", Parameter.Type.INTEGER, 1),
        ("1.0", Parameter.Type.DOUBLE, 1.0),
        ("1e-3", Parameter.Type.DOUBLE, 0.001),
        ("true", Parameter.Type.BOOL, True),
        ('"1"', Parameter.Type.STRING, "1"),
        ("hello", Parameter.Type.STRING, "hello"),
        ("[1, 2]", Parameter.Type.INTEGER_ARRAY, [1, 2]),
        ("[1, 2.5]", Parameter.Type.DOUBLE_ARRAY, [1.0, 2.5]),
        ("[a, b]", Parameter.Type.STRING_ARRAY, ["a", "b"]),
        ("[true, false]", Parameter.Type.BOOL_ARRAY, [True, False]),
        ("{a: 1}", Parameter.Type.STRING, "{a: 1}"),
    ],
)
def test_a_word_of_the_command_line_becomes_a_typed_value(word, type_, value):
    message = parameter_value_from_yaml(word)
    assert message.type == type_
    assert parameter_value_to_python(message) == value


def test_simulated_time_follows_the_clock_topic(make_node, spin_until, context):
    simulator = Node("simulator", context=context)
    clock = get_message("rosgraph_msgs/msg/Clock")
    publisher = simulator.create_publisher(clock, "/clock", 10)
    node = make_node("robot", cli_args=["--ros-args", "-p", "use_sim_time:=true"])
    assert node.get_clock().now().nanoseconds == 0
    assert simulator.wait_for_subscribers("/clock", 1, 10)
    ticks = []
    node.create_timer(1.0, lambda: ticks.append(node.get_clock().now().nanoseconds))
    message = clock()
    message.clock.sec = 1
    publisher.publish(message)
    spin_until(lambda: ticks)
    assert ticks == [1_000_000_000]
    simulator.destroy_node()


def test_callbacks_change_what_is_set_before_names_are_checked(make_node):
    node = make_node()
    node.declare_parameter("speed", 1.0)
    node.add_pre_set_parameters_callback(lambda asked: [*asked, Parameter("unknown", value=1)])
    with pytest.raises(ParameterNotDeclaredException):
        node.set_parameters([Parameter("speed", value=2.0)])
    assert node.get_parameter("speed").value == 1.0


def test_parameters_before_one_that_was_not_declared_are_set(make_node):
    node = make_node()
    node.declare_parameter("speed", 1.0)
    with pytest.raises(ParameterNotDeclaredException):
        node.set_parameters([Parameter("speed", value=2.0), Parameter("unknown", value=1)])
    assert node.get_parameter("speed").value == 2.0


@pytest.mark.parametrize(
    "arguments",
    [
        {"value": Parameter.Type.NOT_SET},
        {"descriptor": get_message("rcl_interfaces/msg/ParameterDescriptor")()},
    ],
)
def test_a_static_type_needs_a_value_or_a_type(make_node, arguments):
    with pytest.raises(ValueError, match="speed"):
        make_node().declare_parameter("speed", **arguments)
