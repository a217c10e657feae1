"""Links that move freely: on a ``floating`` joint from the world, or as a robot's root link."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import mujoco

from teleopctl.errors import InvalidDescriptionError

if TYPE_CHECKING:
    from teleopctl.robot import RobotDescription


@dataclass(frozen=True)
class FreeBody:
    """A link on a floating joint.

    Attributes:
        link: The link, whose pose is that of the joint.
        joint: The joint.
        parent: The frame that the joint starts at, which stands still at the world's origin.
    """

    link: str
    joint: str
    parent: str


def free_bodies(description: RobotDescription) -> list[FreeBody]:
    """Return the bodies on floating joints, in the order of the URDF.

    Raises:
        InvalidDescriptionError: If a floating joint starts at a link that is not ``world``.
    """
    found = [
        FreeBody(joint.child, joint.name, joint.parent)
        for joint in description.joints.values()
        if joint.type == "floating"
    ]
    for body in found:
        if body.parent != "world":
            raise InvalidDescriptionError(
                f"Joint '{body.joint}' is floating but starts at link '{body.parent}'",
                hint="What moves freely starts at a root link named 'world'.",
            )
    return found


def free_root(model: mujoco.MjModel, body: int) -> int:
    """Return the free body that carries a body; 0 for the world.

    Args:
        model: The ``mujoco.MjModel``.
        body: Number of the body.
    """
    # MuJoCo takes a free joint below the world only.
    root = int(model.body_rootid[body])
    first, count = model.body_jntadr[root], model.body_jntnum[root]
    return root if count and model.jnt_type[first] == mujoco.mjtJoint.mjJNT_FREE else 0
