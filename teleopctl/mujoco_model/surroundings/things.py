"""Objects around a robot, and models with added or removed objects or another world.

A model never changes: each function here returns a new model of the same robot, whose elements
come first and keep their indices. An error is raised before the old model is affected.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any
from warnings import catch_warnings, simplefilter

import mujoco
import numpy as np

from teleopctl.errors import InvalidDescriptionError, NotFoundError
from teleopctl.mujoco_model.surroundings.scene import add_default_sun, add_ground, remove_ground
from teleopctl.mujoco_model.surroundings.surfaces import add_contact_pairs
from teleopctl.mujoco_model.surroundings.world import (
    WORLD_PREFIX,
    WorldObject,
    add_world,
    attach_objects,
    objects_since,
    read_objects,
    world_geoms,
)

if TYPE_CHECKING:
    from teleopctl.mujoco_model.base import FreeBody
    from teleopctl.mujoco_model.model import RobotModel
    from teleopctl.robot import World

# Elements of an object other than bodies, all named with the object's prefix.
_ASSETS = ("meshes", "textures", "materials", "hfields")
_IN_THE_WORLD = ("geoms", "lights", "sites", "cameras")


class NewObject:
    """Object to be spawned into a running model: its spec, name and pose.

    The object moves freely unless its file makes it part of the world: by a root link named
    ``world``, or, for MuJoCo's scenes, by a body without a free joint. A file with several parts of
    which some move freely becomes as many objects, ``NAME/part``, each at its pose in the file
    relative to the given pose.

    Args:
        world: The object, as a world of its own.
        name: Name of the object; its other bodies are named ``NAME/body``.
        place: Position of the topmost body in the world, (3,), in metres.
        turn: Rotation of the topmost body in the world, (4,), w x y z.
        own_pose: Whether the object keeps its pose in the file, relative to ``place`` and ``turn``.

    Attributes:
        name: Name of the object.
        names: Names of the objects that the file becomes.
        warnings: Parts that were repaired or left out, one sentence each.

    Raises:
        InvalidDescriptionError: MuJoCo cannot simulate the object.
    """

    def __init__(
        self,
        world: World,
        name: str,
        place: np.ndarray,
        turn: np.ndarray,
        *,
        own_pose: bool = False,
    ) -> None:
        self.name, self._where = name, str(world.path)
        self._things, warnings = read_objects(world)
        self._place, self._turn = place, turn
        self._parts_are_placed = self._held = False
        names = [name]
        tops = list(self._things.worldbody.bodies)
        if len(tops) == 1 and not list(self._things.worldbody.geoms):
            _put(tops[0], *(_from(place, turn, self._things) if own_pose else (place, turn)))
            if world.moves and not list(tops[0].joints):
                tops[0].add_freejoint()
            _rename(self._things, tops[0].name, name)
        elif any(joint.type == mujoco.mjtJoint.mjJNT_FREE for joint in self._things.joints):
            for number, top in enumerate(tops, 1):
                top.name = top.name or f"part{number}"
            names = [f"{name}/{top.name}" for top in tops]
            self._parts_are_placed = True
            _rename(self._things, None, name)
        elif not tops and not list(self._things.worldbody.geoms):
            raise InvalidDescriptionError(f"{world.path}: it is empty")
        else:
            self._held = True
            _rename(self._things, None, name)
        self.names, self.warnings = tuple(names), tuple(warnings)

    def add_to(self, spec: mujoco.MjSpec, prefix: str, frame: str) -> list[FreeBody]:
        """Add the object to a robot's spec; return its freely moving bodies.

        Args:
            spec: The ``mujoco.MjSpec``.
            prefix: Prefix of the names of all parts except bodies.
            frame: Name of the frame at the world's origin.

        Raises:
            InvalidDescriptionError: The spec has a body of the same name.
        """
        if spec.body(self.name) is not None:
            raise InvalidDescriptionError(f"There is '{self.name}' already")
        holder, origin = None, None
        if self._held:
            holder = spec.worldbody.add_body(name=self.name)
            _put(holder, self._place, self._turn)
        if self._parts_are_placed:
            origin = self._place, self._turn
        return attach_objects(
            spec, self._things, self._where, frame, prefix=prefix, holder=holder, origin=origin
        )


def with_objects(model: RobotModel, coming: Sequence[NewObject]) -> RobotModel:
    """Return a newly compiled model with spawned objects added; raise if a name is taken.

    MuJoCo compiles the whole model again, in a time that grows with the square of the number of
    freely moving bodies: 0.5 s for a thousand.

    Args:
        model: The present model.
        coming: Objects to add, none of which has been added before.

    Raises:
        InvalidDescriptionError: MuJoCo cannot simulate an object, or its name is taken.
    """
    spec = model.spec.copy()
    last = max(
        (int(thing.prefix.split("/")[1]) for thing in model.things if thing.spawned), default=0
    )
    moving, things = list(model.free_bodies), list(model.things)
    for serial, each in enumerate(coming, last + 1):
        prefix = f"{WORLD_PREFIX}{serial}/"
        bodies = each.add_to(spec, prefix, model.world_frame)
        joints = {body.link: body.joint for body in bodies}
        moving += bodies
        things += [
            WorldObject(name, joints.get(name, ""), prefix, spawned=True) for name in each.names
        ]
    where = ", ".join(each.name for each in coming)
    made = _compiled(model, spec, where)
    warnings = [warning for each in coming for warning in each.warnings]
    return replace(
        made,
        free_bodies=tuple(moving),
        things=tuple(things),
        warnings=(*warnings, *made.warnings),
    )


def without_objects(model: RobotModel, names: Iterable[str]) -> RobotModel:
    """Return a newly compiled model with the named objects removed; raise if one is unknown.

    Raises:
        NotFoundError: There is no object of a given name.
    """
    leaving = []
    for name in names:
        thing = next((thing for thing in model.things if thing.name == name), None)
        if thing is None:
            raise NotFoundError(f"There is no object '{name}' in the world")
        leaving.append(thing)
    spec = model.spec.copy()
    remaining = tuple(thing for thing in model.things if thing not in leaving)
    for prefix in {thing.prefix for thing in leaving}.difference(t.prefix for t in remaining):
        if prefix:
            _clear(spec, prefix)
    for thing in leaving:
        if (body := spec.body(thing.name)) is not None:
            spec.delete(body)
    names = {body.name for body in spec.bodies}
    return replace(
        _compiled(model, spec, "the world"),
        free_bodies=tuple(body for body in model.free_bodies if body.link in names),
        things=remaining,
        warnings=(),
    )


def with_world(model: RobotModel, world: World | None) -> RobotModel:
    """Return a newly compiled model with the world replaced, and without spawned objects.

    Objects of the robot's own file stay.

    Args:
        model: The present model.
        world: The new world; None for the ground alone.

    Raises:
        InvalidDescriptionError: MuJoCo cannot simulate the world, or a link of the robot has the
            name of a body of the world.
    """
    bare = without_objects(model, [thing.name for thing in model.things if thing.prefix])
    spec = bare.spec
    _clear(spec, WORLD_PREFIX)  # a world of lights and sites alone has no objects
    remove_ground(spec)
    before = {body.name for body in spec.worldbody.bodies}
    free: list[FreeBody] = []
    warnings: list[str] = []
    if world is not None:
        free, warnings = add_world(spec, world, model.world_frame)
    things = objects_since(before, spec, free)
    add_ground(spec)
    add_default_sun(spec, lit=model.start is not None)
    made = _compiled(model, spec, str(world.path) if world is not None else "the empty world")
    return replace(
        made,
        free_bodies=(*bare.free_bodies, *free),
        things=(*bare.things, *things),
        warnings=(*warnings, *made.warnings),
    )


def _from(
    place: np.ndarray, turn: np.ndarray, things: mujoco.MjSpec
) -> tuple[np.ndarray, np.ndarray]:
    """Return the world pose of a file's only object, with its own pose relative to a given one."""
    body = things.compile().body(1)
    found, rotation = np.zeros(3), np.zeros(4)
    mujoco.mju_rotVecQuat(found, body.pos, turn)
    mujoco.mju_mulQuat(rotation, turn, body.quat)
    return place + found, rotation


# Any stands for MuJoCo's bodies, whose classes have no types.
def _put(body: Any, place: np.ndarray, turn: np.ndarray) -> None:
    body.pos, body.quat = place, turn
    body.alt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT


def _rename(things: mujoco.MjSpec, top: str | None, name: str) -> None:
    for body in things.bodies:
        if body.name == top:
            body.name = name
        elif body.name and body.name != "world":
            body.name = f"{name}/{body.name}"


def _clear(spec: mujoco.MjSpec, prefix: str) -> None:
    """Remove all elements that were added with a prefix, except the bodies that hold them."""
    if (frame := spec.frame(prefix)) is not None:
        spec.delete(frame)
    own = (getattr(spec.worldbody, kind) for kind in _IN_THE_WORLD)
    assets = (getattr(spec, kind) for kind in _ASSETS)
    for elements in (*own, *assets):
        for element in list(elements):
            if _belongs(element.name, prefix):
                spec.delete(element)


def _belongs(name: str, prefix: str) -> bool:
    """Whether a part belongs to a prefix; parts of ``world/1/`` do not belong to ``world/``."""
    rest = name.removeprefix(prefix)
    return rest != name and not (prefix == WORLD_PREFIX and rest.split("/")[0].isdigit())


def _compiled(model: RobotModel, spec: mujoco.MjSpec, where: str) -> RobotModel:
    warnings = add_contact_pairs(spec)
    try:
        with catch_warnings():
            # MuJoCo passes these warnings to `mujoco.set_mju_user_warning` too.
            simplefilter("ignore", UserWarning)
            compiled = spec.compile()
    except ValueError as error:
        raise InvalidDescriptionError(f"{where}: {' '.join(str(error).split())}") from error
    around = {model.mj_model.geom(geom).bodyid[0] for geom in model.world_geoms}
    bodies = {model.mj_model.body(body).name for body in around}
    return replace(
        model,
        spec=spec,
        mj_model=compiled,
        world_geoms=world_geoms(compiled, bodies),
        warnings=tuple(warnings),
    )
