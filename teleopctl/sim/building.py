"""Construction of a simulation from a robot description and a world."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

from teleopctl.base import progress
from teleopctl.mujoco_model import RobotModel, build_model
from teleopctl.packages import resolve_uri
from teleopctl.robot import Pose, RobotDescription, World, motion_plugins, read_world
from teleopctl.sim.gazebo_plugins import PlanarMove, add_movers, ground_truth
from teleopctl.sim.sensors.base import Sensor
from teleopctl.sim.sensors.geodesy import GeoPoint
from teleopctl.sim.sensors.interfaces import SensorInterfaces, sensor_interfaces
from teleopctl.sim.sensors.publishing import add_sensors, make_sensors
from teleopctl.sim.simulation import Simulation

if TYPE_CHECKING:
    import mujoco


class SimulatedRobot(NamedTuple):
    """A simulation with the description, model, sensors and world that it was built from.

    Attributes:
        description: Description of the robot.
        model: MuJoCo model of the robot and the world.
        simulation: The simulation, at its start.
        sensors: Sensors that are published on topics.
        interfaces: State interfaces of sensors, for controllers.
        world: World around the robot, or None.
    """

    description: RobotDescription
    model: RobotModel
    simulation: Simulation
    sensors: list[Sensor]
    interfaces: SensorInterfaces
    world: World | None


def simulate(
    urdf: str,
    *,
    world: str = "",
    fixed_base: bool | None = None,
    spawn_pose: Pose | None = None,
    mass_scale: float = 1.0,
    friction_scale: float = 1.0,
    control_period_ns: int,
    timestep_ns: int = 0,
    seed: int = 0,
    gps_origin: Sequence[float] = (),
    warn: Callable[[str], object] = lambda _: None,
) -> SimulatedRobot:
    """Build and return the simulation, at its start, of a robot in a world; nothing runs yet.

    Args:
        urdf: The robot description.
        world: File or URI of the world around the robot; empty for none.
        fixed_base: See `build_model`.
        spawn_pose: See `build_model`.
        mass_scale: Factor of all masses and inertias.
        friction_scale: Factor of all coefficients of friction.
        control_period_ns: Time between two control ticks, in nanoseconds.
        timestep_ns: Longest physics step, in nanoseconds; 0 for that of the model.
        seed: Seed of the sensors' noise.
        gps_origin: Position of the world's origin on the earth: latitude and longitude in degrees,
            metres above the ellipsoid; empty for that of the world's file, else (0, 0, 0).
        warn: Called with a sentence for each part that is simulated otherwise than described.

    Raises:
        InvalidDescriptionError: The robot or the world cannot be simulated.
        NotFoundError: The world's file does not exist.
    """
    progress.doing("reading the robot description")
    description = RobotDescription.from_urdf(urdf)
    plugins = motion_plugins(description)
    movers = [PlanarMove(topic, description.root) for topic in plugins.planar_topics]
    surroundings = read_world(resolve_uri(world)) if world else None
    place = gps_origin or (surroundings and surroundings.origin) or ()
    sensors = make_sensors(description.gazebo.sensors, warn, seed, GeoPoint(*place))
    sensors += ground_truth(plugins.truths)
    interfaces = sensor_interfaces(description, sensors, warn, seed, GeoPoint(*place))
    measuring = list(dict.fromkeys((*sensors, *interfaces.sensors)))

    def extend(spec: mujoco.MjSpec) -> None:
        add_sensors(spec, measuring, warn)
        add_movers(spec, movers, warn)

    model = build_model(
        description,
        extend,
        surroundings,
        fixed_base=fixed_base,
        spawn_pose=spawn_pose,
    )
    sensors = [sensor for sensor in sensors if sensor in measuring]
    for warning in model.warnings:
        # Corrections of the text are logged by the node that publishes it.
        if warning not in description.repairs:
            warn(warning)
    for first, second in model.excluded:
        warn(
            f"'{first}' and '{second}' overlap at the start: they collide once they have separated"
        )
    simulation = Simulation(
        model,
        control_period_ns=control_period_ns,
        timestep_ns=timestep_ns,
        mass_scale=mass_scale,
        friction_scale=friction_scale,
    )
    simulation.movers = movers
    return SimulatedRobot(
        description, model, simulation, sensors, interfaces.only(measuring), surroundings
    )
