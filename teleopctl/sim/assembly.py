"""Assembly of a simulator from a node's parameters: simulation, topics, sensors and loop.

`MujocoSim` is assembled on a node of the graph, `SimulationReplay` in memory.
"""

from __future__ import annotations

from typing import NamedTuple

from teleopctl.errors import InvalidParameterError
from teleopctl.interfaces import get_message
from teleopctl.node import Node, Parameter
from teleopctl.robot import COMMANDS_TOPIC, STATES_TOPIC
from teleopctl.sim.building import SimulatedRobot, simulate
from teleopctl.sim.lockstep import LockstepLoop, Ports
from teleopctl.sim.ports import HostedController, TopicPorts
from teleopctl.sim.sensors.contact import SceneContacts
from teleopctl.sim.sensors.publishing import SensorPublisher
from teleopctl.sim.sensors.settings import (
    base_settings,
    declare_base_settings,
    declare_sensor_settings,
    float_list_parameter,
    sensor_settings,
)

_ParameterDescriptor = get_message("rcl_interfaces/msg/ParameterDescriptor")

# Beyond these limits, time is no longer exact in nanoseconds, or a wait or a mass cannot be
# represented.
RANGES = {
    "update_rate": (1.0, 1e5),
    "timestep": (0.0, 1e3),
    "real_time_factor": (0.0, 1e6),
    "lockstep_timeout": (0.0, 1e6),
    "state_rate": (1.0, 1e5),
    "mass_scale": (1e-6, 1e6),
    "friction_scale": (0.0, 1e6),
    "end_time": (0.0, 1e9),
}
"""Least and greatest value of each numeric parameter."""

_LEAST_TIMESTEP_S = 1e-5


def declare_parameters(node: Node) -> None:
    """Declare the simulator's parameters, except ``gravity``, on a node; raise if one is invalid.

    Raises:
        InvalidParameterError: A number is out of its range.
    """
    # Numbers may be integers or floats: launch arguments may be `0` or `1.5`.
    number = _ParameterDescriptor(dynamic_typing=True)
    node.declare_parameter("robot_description", "")
    at_start = _ParameterDescriptor(read_only=True)
    node.declare_parameter("world", "", at_start)
    declare_base_settings(node)
    for name, value in (("mass_scale", 1.0), ("friction_scale", 1.0), ("end_time", 0.0)):
        fixed = _ParameterDescriptor(read_only=True, dynamic_typing=True)
        node.declare_parameter(name, value, fixed)
    node.declare_parameter("publish_base_tf", False)
    node.declare_parameter("update_rate", 10)
    node.declare_parameter("timestep", 0.0, number)
    node.declare_parameter("real_time_factor", 1.0, number)
    node.declare_parameter("paused", False)
    node.declare_parameter("lockstep_timeout", 1.0, number)
    node.declare_parameter("state_rate", 60, number)
    declare_sensor_settings(node)
    node.declare_parameter("joint_states_topic", STATES_TOPIC)
    node.declare_parameter("joint_commands_topic", COMMANDS_TOPIC)
    for name in RANGES:
        number_of(node, name)


def number_of(node: Node, name: str) -> float:
    """Return a numeric parameter of the simulator's node as a float; raise if out of its range.

    Raises:
        InvalidParameterError: The value is not a number, or out of range.
    """
    return checked_number(node.get_parameter(name))


def checked_number(parameter: Parameter) -> float:
    """Return a simulator parameter's number, possibly not set yet; raise if out of its range.

    Raises:
        InvalidParameterError: The value is not a number, or out of range.
    """
    value, (least, most) = parameter.value, RANGES[parameter.name]
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InvalidParameterError(f"Parameter '{parameter.name}' is '{value}', expected a number")
    if parameter.name == "timestep" and value:
        least = _LEAST_TIMESTEP_S
    if not least <= value <= most:
        raise InvalidParameterError(
            f"Parameter '{parameter.name}' is {value}, expected a number of at least {least:g} "
            f"and at most {most:g}"
        )
    return float(value)


class Assembly(NamedTuple):
    """A robot's simulation with the objects that publish its state and its sensors.

    Attributes:
        robot: The robot, its model and the simulation.
        ports: Publishers of the simulation's state.
        sensors: Publisher of the sensors.
    """

    robot: SimulatedRobot
    ports: TopicPorts
    sensors: SensorPublisher

    def loop(self, node: Node, ports: Ports | None = None) -> LockstepLoop:
        """Return a new LockstepLoop, not yet running, for the simulation and a node's parameters.

        Args:
            node: Node with the simulator's parameters.
            ports: Outputs of the loop; by default `ports` of this assembly.
        """
        return LockstepLoop(
            self.robot.simulation,
            self.ports if ports is None else ports,
            real_time_factor=number_of(node, "real_time_factor"),
            lockstep_timeout_s=number_of(node, "lockstep_timeout"),
            view_rate_hz=number_of(node, "state_rate"),
            paused=bool(node.get_parameter("paused").value),
            sampler=self.sensors,
            end_ns=round(number_of(node, "end_time") * 1e9) or None,
        )


def build_robot(node: Node, urdf: str) -> SimulatedRobot:
    """Return the simulation of a robot in its world, built from URDF and the node's parameters.

    Raises:
        InvalidDescriptionError: The robot or the world cannot be simulated.
        InvalidParameterError: A parameter is invalid.
        NotFoundError: The world's file does not exist.
    """
    return simulate(
        urdf,
        world=str(node.get_parameter("world").value),
        mass_scale=number_of(node, "mass_scale"),
        friction_scale=number_of(node, "friction_scale"),
        control_period_ns=round(1e9 / int(number_of(node, "update_rate"))),
        timestep_ns=round(number_of(node, "timestep") * 1e9),
        warn=node.get_logger().warning,
        **base_settings(node),
        **sensor_settings(node),
    )


def assemble(
    node: Node, robot: SimulatedRobot, controller: HostedController | None = None
) -> Assembly:
    """Create a simulation's publishers on a node and return them; declare and apply ``gravity``.

    Args:
        node: Node of the publishers, with the simulator's parameters.
        robot: Robot as `build_robot` returns it.
        controller: Controller in this process; None for controllers elsewhere.

    Raises:
        InvalidParameterError: A parameter is invalid.
    """
    simulation = robot.simulation
    states_topic = str(node.get_parameter("joint_states_topic").value)
    ports = TopicPorts(node, simulation, states_topic, robot.interfaces, controller)
    ports.show_base(bool(node.get_parameter("publish_base_tf").value))
    contacts = SceneContacts(number_of(node, "state_rate"))
    sensors = SensorPublisher(node, simulation, [*robot.sensors, contacts])
    # Declared only now: the default is the gravity of the world.
    number = _ParameterDescriptor(dynamic_typing=True)
    node.declare_parameter("gravity", simulation.gravity, number)
    gravity = float_list_parameter(node, "gravity", "x", "y", "z")
    if gravity != simulation.gravity:
        simulation.set_gravity(gravity)
    return Assembly(robot, ports, sensors)
