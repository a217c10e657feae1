"""Motion of mobile bases in a robot check, and the check of Gazebo's planar-move plug-ins."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

from teleopctl.interfaces import get_message
from teleopctl.nodes.robot_check.stability import CONTROL_PERIOD_NS

if TYPE_CHECKING:
    from teleopctl.sim import SimulatedRobot, Simulation

SPEED = 0.3
"""Commanded speed of a base, in m/s."""
TURN = 0.5
"""Commanded turning speed of a base, in rad/s."""
MOVING_S = 2.0
"""Duration of each motion, in s."""
ENOUGH = 0.5
"""Smallest fraction of the commanded distance that passes the check."""
# A base that turns by sliding turns by less than commanded, see docs/physics.md.
_ENOUGH_TURN = 0.15


class BasePose(NamedTuple):
    """Position (m) and heading (rad) of a mobile base in the world."""

    x: float
    y: float
    heading: float


def base_pose(simulation: Simulation, link: str) -> BasePose:
    """Return the `BasePose` of a robot's base link in a simulation."""
    pose = simulation.link_pose(link)
    x, y, _ = map(float, pose.position)
    return BasePose(x, y, math.atan2(pose.rotation[1, 0], pose.rotation[0, 0]))


class BaseMotion(NamedTuple):
    """Measured motion of a mobile base in a robot check: distance ahead, then angle turned.

    Attributes:
        ahead: Distance driven ahead, in m.
        turned: Angle turned afterwards, in rad.
        speed_factor: Commanded velocity as a fraction of `SPEED` and `TURN`.
    """

    ahead: float
    turned: float
    speed_factor: float = 1.0

    @classmethod
    def between(
        cls, start: BasePose, middle: BasePose, end: BasePose, speed_factor: float = 1.0
    ) -> BaseMotion:
        """Return the motion between a base's poses before and after driving and after turning."""
        along, across = middle.x - start.x, middle.y - start.y
        ahead = along * math.cos(start.heading) + across * math.sin(start.heading)
        return cls(ahead, math.remainder(end.heading - middle.heading, math.tau), speed_factor)

    @property
    def is_enough(self) -> bool:
        """Whether the base covered the required part of the commanded distance and angle."""
        turn = _ENOUGH_TURN * TURN * MOVING_S
        far = self.ahead >= ENOUGH * self.speed_factor * SPEED * MOVING_S
        return far and abs(self.turned) >= self.speed_factor * turn

    @property
    def summary(self) -> str:
        """Distance and angle that the base moved, compared with the commanded ones, as text."""
        commanded, turn = self.speed_factor * SPEED * MOVING_S, self.speed_factor * TURN * MOVING_S
        turned = f"turned {self.turned:.3f} of {turn:.2g} rad"
        return f"ahead {self.ahead:.3f} of {commanded:.2g} m, {turned}"


def planar_move_motions(robot: SimulatedRobot) -> dict[str, BaseMotion]:
    """Command each planar-move plug-in in a new simulation; return the `BaseMotion` per topic.

    Args:
        robot: Simulated robot, whose model is used for the new simulation.
    """
    from teleopctl.sim import Simulation

    motions: dict[str, BaseMotion] = {}
    simulation = Simulation(robot.model, control_period_ns=CONTROL_PERIOD_NS)
    simulation.movers = robot.simulation.movers
    simulation.hold()
    base = robot.model.base
    for mover in simulation.movers if base is not None else ():
        assert base is not None
        places = [base_pose(simulation, base.body.link)]
        for x, turn in ((SPEED, 0.0), (0.0, TURN)):
            twist: Any = get_message("geometry_msgs/msg/Twist")()
            twist.linear.x, twist.angular.z = x, turn
            mover.receive(twist)
            simulation.step_to(simulation.time_ns + round(MOVING_S * 1e9))
            places.append(base_pose(simulation, base.body.link))
        mover.stop()
        motions[mover.topic] = BaseMotion.between(places[0], places[1], places[2])
    return motions
