"""Physics of a robot, stepped by a program, without nodes and without Zenoh."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from teleopctl.api.robot import Robot, load_robot
from teleopctl.errors import NotFoundError, UsageError
from teleopctl.sim import simulate

if TYPE_CHECKING:
    import mujoco

_MOST_HZ = 100_000.0


class RobotSimulation:
    """Simulation of a robot that the program steps itself, the same as in ``mujoco_sim``.

    Args:
        robot: The robot, or a description file for `load_robot`.
        world: World file around the robot (URDF, xacro, SDF, MJCF or YAML), or None.
        control_rate_hz: Control periods per simulated second; `step` advances by one period.
        timestep_s: Longest physics step in seconds; by default the model's, 1 ms.
        fixed_base: Whether the root link is fixed to the world; None decides by the robot's shape.

    Attributes:
        joint_names: Names of the joints, in the order of the model.

    Raises:
        InvalidDescriptionError: MuJoCo cannot simulate the robot or the world.
        NotFoundError: A file does not exist.
        UsageError: A rate or a step is out of range.

    Example:
        >>> simulation = RobotSimulation("package://teleop_description/urdf/teleop.urdf.xacro")
        >>> simulation.command({"joint_1": 0.5})
        >>> simulation.step(100)
        >>> round(simulation.positions["joint_1"], 3)
        0.5
    """

    def __init__(
        self,
        robot: Robot | Path | str,
        *,
        world: Path | str | None = None,
        control_rate_hz: float = 100.0,
        timestep_s: float | None = None,
        fixed_base: bool | None = None,
    ) -> None:
        if not 0 < control_rate_hz <= _MOST_HZ:
            raise UsageError(
                f"control_rate_hz is {control_rate_hz}, expected more than 0, at most {_MOST_HZ:g}"
            )
        if timestep_s is not None and timestep_s <= 0:
            raise UsageError(f"timestep_s is {timestep_s}, expected more than 0")
        if not isinstance(robot, Robot):
            robot = load_robot(robot)
        built = simulate(
            robot.urdf,
            world="" if world is None else str(world),
            fixed_base=fixed_base,
            control_period_ns=round(1e9 / control_rate_hz),
            timestep_ns=0 if timestep_s is None else round(timestep_s * 1e9),
        )
        self._simulation = built.simulation
        self.joint_names = list(self._simulation.joint_names)

    @property
    def time_s(self) -> float:
        """Simulated time since the last reset, in seconds."""
        return self._simulation.time_ns * 1e-9

    @property
    def positions(self) -> dict[str, float]:
        """Joint positions (rad or m) by name."""
        return self._by_name(self._simulation.positions)

    @property
    def velocities(self) -> dict[str, float]:
        """Joint velocities (rad/s or m/s) by name."""
        return self._by_name(self._simulation.velocities)

    @property
    def efforts(self) -> dict[str, float]:
        """Efforts of the joint drives (N m or N) by joint name."""
        return self._by_name(self._simulation.efforts)

    @property
    def mujoco(self) -> tuple[mujoco.MjModel, mujoco.MjData]:
        """Pair of the MuJoCo model and a copy of its data with the current sensor values."""
        return self._simulation.observe()

    def command(
        self,
        positions: Mapping[str, float] | None = None,
        *,
        velocities: Mapping[str, float] | None = None,
        efforts: Mapping[str, float] | None = None,
    ) -> None:
        """Set position, velocity or effort commands of joints; each holds until the next one.

        Args:
            positions: Target positions (rad or m) by joint.
            velocities: Target velocities (rad/s or m/s) by joint.
            efforts: Efforts (N m or N) by joint.

        Raises:
            NotFoundError: The robot has no such joint, or the joint takes no commands.
        """
        given = {"position": positions, "velocity": velocities, "effort": efforts}
        for kind, commands in given.items():
            for name in commands or ():
                if not self._simulation.commandable(name):
                    raise NotFoundError(
                        f"joint '{name}' takes no commands"
                        if name in self.joint_names
                        else f"the robot has no joint '{name}'",
                        hint=f"Its joints are {', '.join(self.joint_names) or 'none'}.",
                    )
            if commands:
                self._simulation.apply(list(commands), **{kind: list(commands.values())})

    def step(self, count: int = 1) -> None:
        """Advance the simulation by ``count`` control periods."""
        self._simulation.step(count * self._simulation.steps_per_period)
        self._simulation.read()

    def reset(self) -> None:
        """Reset the simulation to time zero and the initial positions, without commands."""
        self._simulation.reset()
        self._simulation.read()

    def T_world_link(self, link: str) -> npt.NDArray[np.float64]:  # noqa: N802 -- frames' names
        """Return the current pose of a link in the world as a (4, 4) matrix.

        Raises:
            NotFoundError: The simulation has no such link.
        """
        if not self._simulation.has_link(link):
            raise NotFoundError(f"the simulation has no link '{link}'")
        pose = self._simulation.link_pose(link)
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = pose.rotation, pose.position
        return matrix

    def _by_name(self, values: npt.NDArray[np.float64]) -> dict[str, float]:
        return dict(zip(self.joint_names, values.tolist(), strict=True))
