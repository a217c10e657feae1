"""Managed nodes, as their own code, other nodes and the graph see them."""

from typing import Any

import pytest

from teleopctl.interfaces import get_message, get_service
from teleopctl.node import (
    LifecycleNode,
    LifecycleNodeMixin,
    LifecycleState,
    ManagedEntity,
    Node,
    RCLError,
    SimpleManagedEntity,
    TransitionCallbackReturn,
)
from teleopctl.wire.qos import format_qos

SUCCESS, FAILURE, ERROR = TransitionCallbackReturn
STRING = get_message("std_msgs/msg/String")
CHANGE = get_service("lifecycle_msgs/srv/ChangeState")
EVENT = get_message("lifecycle_msgs/msg/TransitionEvent")


@pytest.fixture
def make(context, executor):
    """Make managed nodes that the executor serves."""
    nodes = []

    def make(class_=LifecycleNode, name="arm", **options):
        nodes.append(class_(name, context=context, **options))
        executor.add_node(nodes[-1])
        return nodes[-1]

    yield make
    for node in nodes:
        node.destroy_node()


class Told(LifecycleNode):
    """Does in each callback what it was told, and notes it."""

    def __init__(self, *args, **kwargs):
        super().__init__(*args, **kwargs)
        self.called: list[Any] = []
        self.orders: dict[str, Any] = {}

    def _do(self, name, state):
        self.called.append((name, state.label))
        order = self.orders.get(name, SUCCESS)
        if isinstance(order, Exception):
            raise order
        return order

    def on_configure(self, state):
        return self._do("configure", state)

    def on_shutdown(self, state):
        return self._do("shutdown", state)

    def on_error(self, state):
        return self._do("error", state)


def state_of(node):
    return node._state_machine.current_state[1]


def test_it_makes_its_endpoints_after_a_nodes_own_in_the_order_of_ros_2(make):
    node = make()
    own = [endpoint for endpoint in node._endpoints if "lifecycle_msgs" in endpoint.type_name]
    assert own == node._endpoints[-6:]
    assert [(endpoint.name, endpoint.type_name.rpartition("/")[2]) for endpoint in own] == [
        ("/arm/transition_event", "TransitionEvent"),
        ("/arm/change_state", "ChangeState"),
        ("/arm/get_state", "GetState"),
        ("/arm/get_available_states", "GetAvailableStates"),
        ("/arm/get_available_transitions", "GetAvailableTransitions"),
        ("/arm/get_transition_graph", "GetAvailableTransitions"),
    ]
    assert {format_qos(endpoint.qos_profile.to_wire()) for endpoint in own} == {"::,10:,:,:,,"}


def test_without_the_interface_it_has_its_states_alone(make):
    node = make(enable_communication_interface=False)
    assert not [e for e in node._endpoints if "lifecycle_msgs" in e.type_name]
    assert (node.trigger_configure(), state_of(node)) == (SUCCESS, "inactive")
    with pytest.raises(TypeError, match="must be a bool"):
        make(name="other", enable_communication_interface="yes")


@pytest.mark.parametrize(
    ("order", "on_error", "outcome", "state"),
    [
        (SUCCESS, SUCCESS, SUCCESS, "inactive"),
        (FAILURE, SUCCESS, FAILURE, "unconfigured"),
        (ERROR, SUCCESS, ERROR, "unconfigured"),
        (ERROR, FAILURE, ERROR, "finalized"),
        (ERROR, ERROR, ERROR, "finalized"),
        (ValueError("no camera"), SUCCESS, ERROR, "unconfigured"),
        (ValueError("no camera"), ValueError("again"), ERROR, "finalized"),
        (None, SUCCESS, ERROR, "unconfigured"),
    ],
)
def test_what_a_callback_returns_or_raises_decides_on_the_state(
    make, monkeypatch, order, on_error, outcome, state
):
    node, logged = make(Told), list[str]()
    monkeypatch.setattr(node.get_logger(), "error", logged.append)
    node.orders.update(configure=order, error=on_error)
    assert node.trigger_configure() is outcome
    assert state_of(node) == state
    error_called = [("error", "unconfigured")] if outcome is ERROR else []
    assert node.called == [("configure", "unconfigured"), *error_called]
    log = "".join(logged)
    assert ("ValueError: no camera" in log) == isinstance(order, ValueError)
    assert ("on_configure() returned None" in log) == (order is None)


def test_what_is_not_possible_says_what_is(make):
    node = make()
    with pytest.raises(RCLError, match=r"deactivate is not .* possible: configure \(1\), shutdown"):
        node.trigger_deactivate()
    node.trigger_shutdown()
    with pytest.raises(RCLError, match="possible: none"):
        node.trigger_shutdown()


def test_managed_entities_follow_in_the_order_in_which_they_were_added(make):
    node, called = make(), []

    class Part(ManagedEntity):
        def __init__(self, name, outcome=SUCCESS):
            self.name, self.outcome = name, outcome

        def on_configure(self, state):
            called.append((self.name, state))
            return self.outcome

    for part in (Part("first"), Part("second", FAILURE), Part("third")):
        node.add_managed_entity(part)
    assert node.trigger_configure() is FAILURE
    before = LifecycleState("unconfigured", 1)
    assert called == [("first", before), ("second", before)]
    with pytest.raises(TypeError):
        node.add_managed_entity("a part")


def test_a_method_may_do_nothing_until_its_entity_is_activated():
    refused: list[int] = []

    class Counter(SimpleManagedEntity):
        @SimpleManagedEntity.when_enabled
        def plain(self, number):
            return number

        @SimpleManagedEntity.when_enabled(when_not_enabled=lambda: refused.append(1))
        def told(self, number):
            return number

    counter, state = Counter(), LifecycleState("inactive", 2)
    assert (counter.plain(3), counter.told(4), refused) == (None, None, [1])
    counter.on_activate(state)
    assert (counter.is_activated, counter.plain(3), counter.told(4)) == (True, 3, 4)
    counter.on_deactivate(state)
    assert counter.plain(3) is None


def test_a_lifecycle_publisher_is_in_the_graph_and_sends_only_while_active(
    make, make_node, spin_until
):
    node, got = make(), []
    publisher = node.create_lifecycle_publisher(STRING, "chatter", 10)
    listener = make_node("listener")
    listener.create_subscription(STRING, "/chatter", lambda m: got.append(m.data), 10)
    assert node.count_publishers("/chatter") == 1
    publisher.publish(STRING(data="too early"))
    node.trigger_configure()
    node.trigger_activate()
    publisher.publish(STRING(data="now"))
    node.trigger_deactivate()
    publisher.publish(STRING(data="too late"))
    node.trigger_activate()
    publisher.publish(STRING(data="again"))
    spin_until(lambda: len(got) == 2)
    assert got == ["now", "again"]
    assert node.destroy_lifecycle_publisher(publisher)
    assert node.trigger_deactivate() is SUCCESS


def test_what_it_takes_in_a_configuration_it_may_give_back_time_and_again(make):
    class Talker(LifecycleNode):
        timer: Any = None
        publisher: Any = None

        def on_configure(self, state):
            self.publisher = self.create_lifecycle_publisher(STRING, "chatter", 10)
            self.timer = self.create_timer(1.0, print)
            return super().on_configure(state)

        def on_cleanup(self, _state):
            # As ROS 2's demo has it, also before there is anything.
            self.destroy_timer(self.timer)
            self.destroy_publisher(self.publisher)
            return SUCCESS

        on_shutdown = on_cleanup

    node = make(Talker)
    for _ in range(3):
        assert node.trigger_configure() is SUCCESS
        assert node.trigger_cleanup() is SUCCESS
    assert len(node._managed_entities) == 1
    assert not node.timers
    assert make(Talker, "other").trigger_shutdown() is SUCCESS


def test_others_change_the_state_and_hear_of_every_step(make, make_node, spin_until):
    node, other, received = make(Told), make_node("manager"), []
    other.create_subscription(
        EVENT,
        "/arm/transition_event",
        lambda e: received.append((e.start_state.label, e.goal_state.label, e.transition.id)),
        10,
    )
    client = other.create_client(CHANGE, "/arm/change_state")
    assert client.wait_for_service(10.0)

    def ask(id_=0, label=""):
        request = CHANGE.Request()
        request.transition.id, request.transition.label = id_, label
        future = client.call_async(request)
        spin_until(future.done)
        return future.result().success

    node.orders["configure"] = ERROR
    assert not ask(1)
    node.orders["configure"] = SUCCESS
    assert ask(99, "configure"), "a label wins over the number"
    assert not ask(4), "a number that is not possible now is refused, and the node lives on"
    assert not ask(label="transition_success")
    assert ask(6)
    assert state_of(node) == "finalized"
    spin_until(lambda: len(received) == 7)
    assert received == [
        ("unconfigured", "configuring", 0),
        ("configuring", "errorprocessing", 0),
        ("errorprocessing", "unconfigured", 0),
        ("unconfigured", "configuring", 0),
        ("configuring", "inactive", 0),
        ("inactive", "shuttingdown", 0),
        ("shuttingdown", "finalized", 0),
    ]


def test_others_are_told_the_state_and_what_is_possible(make, make_node, spin_until):
    make()
    other = make_node("manager")

    def ask(type_, name):
        service = get_service(f"lifecycle_msgs/srv/{type_}")
        client = other.create_client(service, f"/arm/{name}")
        assert client.wait_for_service(10.0)
        future = client.call_async(service.Request())
        spin_until(future.done)
        return future.result()

    state = ask("GetState", "get_state").current_state
    assert (state.id, state.label) == (1, "unconfigured")
    states = ask("GetAvailableStates", "get_available_states").available_states
    assert [each.id for each in states] == [0, 1, 2, 3, 4, 10, 11, 12, 13, 14, 15]
    now = ask("GetAvailableTransitions", "get_available_transitions").available_transitions
    assert [(t.transition.id, t.goal_state.label) for t in now] == [
        (1, "configuring"),
        (5, "shuttingdown"),
    ]
    graph = ask("GetAvailableTransitions", "get_transition_graph").available_transitions
    assert len(graph) == 25


def test_a_life_cycle_needs_a_node():
    class Rootless(LifecycleNodeMixin):
        pass

    class Rooted(Node, LifecycleNodeMixin):
        def __init__(self, **options):
            Node.__init__(self, "rooted", **options)
            LifecycleNodeMixin.__init__(self, enable_communication_interface=False)

    with pytest.raises(TypeError, match=r"Rootless .* must be a Node"):
        Rootless()
    assert issubclass(Rooted, ManagedEntity)
