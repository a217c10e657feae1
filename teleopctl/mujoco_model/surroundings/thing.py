"""What stands or lies around a robot, by name."""

from __future__ import annotations

from collections.abc import Container, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from teleopctl.mujoco_model.surroundings.world import WORLD_PREFIX

if TYPE_CHECKING:
    import mujoco

    from teleopctl.mujoco_model.free_bodies import FreeBody


@dataclass(frozen=True)
class Thing:
    """An object of the world besides the robot.

    Attributes:
        name: Its topmost body.
        joint: The free joint that it moves on; empty where it stands still.
        prefix: In front of the names of its parts; empty for what is of the robot's own file.
        spawned: Whether it came in while the simulation ran.
    """

    name: str
    joint: str
    prefix: str
    spawned: bool = False


def things_since(
    before: Container[str],
    spec: mujoco.MjSpec,
    free: Iterable[FreeBody],
    *,
    prefix: str = WORLD_PREFIX,
) -> tuple[Thing, ...]:
    """Return the objects that were added to a spec since a list of its bodies was made.

    Args:
        before: The topmost bodies that it had before.
        spec: The ``mujoco.MjSpec``.
        free: What moves freely of the world.
        prefix: In front of the names of their parts.
    """
    joints = {body.link: body.joint for body in free}
    return tuple(
        Thing(body.name, joints.get(body.name, ""), prefix)
        for body in spec.worldbody.bodies
        if body.name not in before
    )
