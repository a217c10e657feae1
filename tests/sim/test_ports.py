"""What the simulator publishes at each control tick, as bytes."""

from __future__ import annotations

import math
from typing import Any, cast

import pytest

from teleopctl.interfaces import Message, to_nanoseconds
from teleopctl.interfaces.cdr import deserialize
from teleopctl.node import Node
from teleopctl.sim.ports import VIEW_TOPIC, TopicPorts
from teleopctl.sim.simulation import Simulation
from tests.sim.robots import control, joint, link, model
from tests.sim.test_sensor_interfaces import WRENCH, Hand, sensor

TICK_NS = 10_000_000
STATES = "/states"


class Publisher:
    """Remembers what was published, as whoever receives it has it."""

    def __init__(self, message_type: type[Message], sent: list[Any]) -> None:
        self._type, self._sent = message_type, sent

    def publish(self, message: Message | bytearray) -> None:
        """Take a message."""
        if isinstance(message, bytearray):
            message = deserialize(bytes(message), self._type)
        self._sent.append(message)

    def get_subscription_count(self) -> int:
        """Somebody listens."""
        return 1


class Graph:
    """A node without a graph."""

    def __init__(self) -> None:
        self.sent: dict[str, list[Any]] = {}

    def create_publisher(self, message_type: type[Message], topic: str, _qos: object) -> Publisher:
        """A publisher."""
        return Publisher(message_type, self.sent.setdefault(topic, []))

    def get_logger(self) -> None:
        """Nothing is logged."""


@pytest.fixture
def graph() -> Graph:
    return Graph()


def ports(graph: Graph, simulation: Simulation, interfaces=None) -> TopicPorts:
    return TopicPorts(cast("Node", graph), simulation, STATES, interfaces)


def test_a_tick_tells_the_joints_that_have_states_and_a_viewer_all(graph: Graph) -> None:
    # The middle one is not described to have states: what is told is not what lies side by side.
    robot = model(
        link("base", ""), link("a"), link("b"), link("c"),
        joint("first", "base", "a", xyz="0 1 0"),
        joint("second", "base", "b", xyz="0 2 0"),
        joint("third", "base", "c", xyz="0 3 0"),
        control(first="position", third="velocity"),
    )  # fmt: skip
    simulation = Simulation(robot, control_period_ns=TICK_NS)
    topics = ports(graph, simulation)
    for _ in range(3):
        simulation.apply(["first", "third"], position=[0.3, math.nan], velocity=[math.nan, 0.5])
        simulation.step(10)
        simulation.read()
        topics.publish_state(simulation.time_ns)
        topics.publish_view(simulation.time_ns)

        told, seen = graph.sent[STATES][-1], graph.sent[VIEW_TOPIC][-1]
        assert to_nanoseconds(told.header.stamp) == to_nanoseconds(seen.header.stamp)
        assert to_nanoseconds(told.header.stamp) == simulation.time_ns
        assert told.name == ["first", "third"]
        assert list(told.position) == simulation.positions[[0, 2]].tolist()
        assert list(told.velocity) == simulation.velocities[[0, 2]].tolist()
        assert list(told.effort) == simulation.efforts[[0, 2]].tolist()
        assert seen.name == ["first", "second", "third"]
        assert list(seen.position) == simulation.positions.tolist()
        assert list(seen.effort) == simulation.efforts.tolist()
    assert told.position[0] > 0.03


def test_the_state_after_a_reset_says_so_once(graph: Graph) -> None:
    simulation = Hand().robot.simulation
    topics = ports(graph, simulation)
    topics.publish_state(0)
    simulation.reset()
    topics.publish_state(0)
    topics.publish_state(TICK_NS)
    assert [message.header.frame_id for message in graph.sent[STATES]] == ["", "reset", ""]


def test_what_sensors_measure_stands_behind_the_joints(graph: Graph) -> None:
    hand = Hand(sensors=sensor("wrist", WRENCH, "tip"))
    simulation = hand.robot.simulation
    topics = ports(graph, simulation, hand.robot.interfaces)
    simulation.read()
    topics.publish_state(simulation.time_ns)

    (told,) = graph.sent[STATES]
    assert told.name == ["hinge", *hand.values]
    assert list(told.position) == [*simulation.positions, *hand.values.values()]
    assert all(math.isnan(number) for number in (*told.velocity[1:], *told.effort[1:]))
    assert len(told.velocity) == len(told.effort) == len(told.name)
