"""Check that a robot stays upright in simulation, and that its joints follow commands."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from teleopctl.nodes.robot_check.collision_free import free_targets

if TYPE_CHECKING:
    from teleopctl.mujoco_model import JointSpec
    from teleopctl.sim import SimulatedRobot, Simulation

CONTROL_PERIOD_NS = 10_000_000

AT_LIMIT = 0.99
"""Fraction of its effort limit from which a drive counts as at the limit."""

# A root link has fallen if it has tilted by this angle (rad), or sunk by this fraction of its
# height.
_FALLEN_RAD = 0.5
_SUNK = 0.3
# Smallest height of a root link for `_SUNK`, in metres: many root links are on the ground.
_LEAST_HEIGHT_M = 0.15
# A joint that moves by this much without a command, in rad or m, is not held by its drive.
_SAGGED = 0.1
# Duration of the joints' motion, in s; commanded distance, in rad or m, and speed, in rad/s or m/s;
# and the fraction of the commanded motion that passes.
_MOVING_S = 2.0
_STEP = 0.1
_SPEED = 0.5
_ENOUGH = 0.5


@dataclass(frozen=True)
class StabilityReport:
    """Result of simulating a robot without controllers: whether it stands and its joints move.

    Attributes:
        verdict: ``stands``, ``falls``, ``sags`` (a joint gives way) or ``diverges``.
        fault: Reason why the robot does not stand; empty if it stands.
        moved: Joints that followed a command.
        unmoved: Joints that did not follow a command.
        blocked: Joints that were not commanded: both directions meet the ground or another link.
        travelled_m: Horizontal distance that the free root link moved while the joints moved, in m;
            None for a fixed root link.
    """

    verdict: str
    fault: str = ""
    moved: tuple[str, ...] = ()
    unmoved: tuple[str, ...] = ()
    blocked: tuple[str, ...] = ()
    travelled_m: float | None = None


def check_stability(robot: SimulatedRobot, seconds: float) -> StabilityReport:
    """Simulate a robot that its drives hold, then move its joints; return a `StabilityReport`.

    Args:
        robot: Simulated robot at its start.
        seconds: Simulated time for which the robot has to stand, in s.
    """
    simulation = robot.simulation
    simulation.hold()
    start = simulation.positions.copy()
    if not _run(simulation, seconds):
        return StabilityReport(
            "diverges", f"physics diverged after {simulation.time_ns * 1e-9:.2f} s"
        )
    if fault := _fallen(robot):
        return StabilityReport("falls", fault)
    # No drive holds a joint with only effort commands, so its motion does not count.
    held = [bool({"position", "velocity"} & _takes(joint)) for joint in robot.model.joints]
    away = np.where(held, np.abs(simulation.positions - start), 0.0)
    if len(away) and away.max() > _SAGGED:
        row = int(away.argmax())
        joint, limit = simulation.joint_names[row], robot.model.joints[row].limits.effort
        fault = f"joint '{joint}' sagged by {away.max():.2f}"
        if abs(simulation.efforts[row]) >= AT_LIMIT * limit:
            fault += f" at its limit of effort, {limit:g}"
        return StabilityReport("sags", fault)
    return _moved(robot)


def _run(simulation: Simulation, seconds: float) -> bool:
    """Step the simulation for some seconds; return whether physics did not diverge."""
    end = simulation.time_ns + round(seconds * 1e9)
    while simulation.time_ns < end:
        simulation.step_to(min(end, simulation.time_ns + CONTROL_PERIOD_NS))
        simulation.read()
        if simulation.diverged or not np.isfinite(simulation.positions).all():
            return False
    return True


def _fallen(robot: SimulatedRobot) -> str:
    """Return how the robot's free root link has fallen; empty if it stands or is fixed."""
    base = robot.model.base
    if base is None:
        return ""
    if not base.can_touch:
        return "it has no collision shapes and falls through the ground"
    now = robot.simulation.link_pose(base.body.link)
    upright = float(np.clip(now.rotation[2, 2], -1.0, 1.0))
    if math.acos(upright) > _FALLEN_RAD:
        angle = math.degrees(math.acos(upright))
        return f"it tilted by {angle:.0f} degrees; fixed_base:=true holds its root link"
    sunk = base.height_m - float(now.position[2])
    if sunk > _SUNK * max(base.height_m, _LEAST_HEIGHT_M):
        return f"it sank by {sunk:.2f} m"
    return ""


def _moved(robot: SimulatedRobot) -> StabilityReport:
    simulation, base = robot.simulation, robot.model.base
    moving = [joint for joint in robot.model.joints if {"position", "velocity"} & _takes(joint)]
    sent = [joint for joint in moving if "position" in _takes(joint)]
    free = free_targets(simulation, sent, _STEP)
    commanded = [joint for joint in moving if joint not in sent or joint.name in free]
    rows = [simulation.joint_names.index(joint.name) for joint in commanded]
    before = simulation.positions[rows]
    place = np.zeros(3) if base is None else simulation.link_pose(base.body.link).position
    targets = [free.get(joint.name, math.nan) for joint in commanded]
    speeds = [math.nan if "position" in _takes(joint) else _SPEED for joint in commanded]
    names = [joint.name for joint in commanded]
    end = simulation.time_ns + round(_MOVING_S * 1e9)
    while simulation.time_ns < end:
        simulation.apply(names, targets, speeds)
        if not _run(simulation, CONTROL_PERIOD_NS * 1e-9):
            return StabilityReport("diverges", "physics diverged while its joints moved")
    after = simulation.positions[rows]
    wanted = [
        target - position if math.isfinite(target) else _SPEED * _MOVING_S
        for target, position in zip(targets, before, strict=True)
    ]
    has_moved = [
        abs(now - then) >= _ENOUGH * abs(commanded)
        for now, then, commanded in zip(after, before, wanted, strict=True)
    ]
    travelled = None
    if base is not None:
        ahead = simulation.link_pose(base.body.link).position - place
        travelled = round(float(np.hypot(ahead[0], ahead[1])), 4)
    return StabilityReport(
        "stands",
        moved=tuple(name for name, has in zip(names, has_moved, strict=True) if has),
        unmoved=tuple(name for name, has in zip(names, has_moved, strict=True) if not has),
        blocked=tuple(joint.name for joint in sent if joint.name not in free),
        travelled_m=travelled,
    )


def _takes(joint: JointSpec) -> set[str]:
    return set(joint.command_interfaces)
