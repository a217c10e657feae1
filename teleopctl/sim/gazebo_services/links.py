"""Names as Gazebo scopes them, ``model::link``, and how what they name moves."""

from __future__ import annotations

from typing import TYPE_CHECKING

import mujoco
import numpy as np
import numpy.typing as npt

from teleopctl.errors import NotFoundError
from teleopctl.sim.entities.entity import SimulatedEntity, entities

if TYPE_CHECKING:
    from teleopctl.sim.simulation import Simulation

Array = npt.NDArray[np.float64]

# What Gazebo's services take for the world's frame.
_WORLD = ("", "world", "map", "/map")


def link_of(simulation: Simulation, name: str) -> str:
    """Return the link for a link's name, an entity's name or ``entity::link``.

    Returns:
        The link; empty for a robot that stands in the world.

    Raises:
        NotFoundError: There is none.
    """
    known = entities(simulation)
    if name in known:
        return known[name].body
    if simulation.has_link(name):
        return name
    first, _, rest = name.partition("::")
    if first in known and rest:
        inner = rest.replace("::", "/")
        if simulation.has_link(f"{first}/{inner}"):
            return f"{first}/{inner}"
        if known[first].is_robot and simulation.has_link(inner):
            return inner
        if not known[first].is_robot and "/" not in inner and _is_alone(simulation, first):
            # Its only link is known by the thing's name; what its file called it is not.
            return first
    raise NotFoundError(f"There is no entity and no link '{name}'; there is {', '.join(known)}")


def entity_of(simulation: Simulation, name: str) -> SimulatedEntity:
    """Return the entity for its name or that of its topmost link.

    Raises:
        NotFoundError: There is none.
    """
    link = link_of(simulation, name)
    for entity in entities(simulation).values():
        if name == entity.name or (link and link == entity.body):
            return entity
    raise NotFoundError(f"'{name}' is a link: put its entity elsewhere")


def motion_of_link(simulation: Simulation, link: str) -> tuple[Array, Array]:
    """Return the pose of a link and the velocity of its frame's origin, in the world.

    Args:
        simulation: Where it is.
        link: As of `link_of`.

    Returns:
        Position (m) and rotation (w x y z), (7,); velocity (m/s) and angular velocity (rad/s),
        (6,).
    """
    if not link:
        return np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]), np.zeros(6)
    model, data = simulation.observe()
    number, velocity = model.body(link).id, np.zeros(6)
    kind = mujoco.mjtObj.mjOBJ_XBODY
    mujoco.mj_objectVelocity(model, data, kind, number, velocity, 0)
    pose = np.concatenate([data.xpos[number], data.xquat[number]])
    # MuJoCo has the angular part first.
    return pose, np.concatenate([velocity[3:], velocity[:3]])


def frame_link(simulation: Simulation, name: str) -> str:
    """Return the link of a reference frame; empty for the world.

    Raises:
        NotFoundError: There is none.
    """
    return "" if name in _WORLD else link_of(simulation, name)


def _is_alone(simulation: Simulation, thing: str) -> bool:
    """Whether a thing has one link."""
    m = simulation.present_model.mj_model
    return not any(m.body(number).name.startswith(f"{thing}/") for number in range(m.nbody))
