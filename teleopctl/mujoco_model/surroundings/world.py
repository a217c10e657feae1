"""The world around a robot: read from its file and added to the robot's spec."""

from __future__ import annotations

from collections.abc import Container, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from teleopctl.errors import InvalidDescriptionError
from teleopctl.mujoco_model.assets import resolve_meshes
from teleopctl.mujoco_model.base import FreeBody
from teleopctl.mujoco_model.drives import add_mimic
from teleopctl.mujoco_model.inertia import repair_inertias
from teleopctl.mujoco_model.surroundings.scene_spec import ACROSS_LEFT_OUT, scene_spec
from teleopctl.mujoco_model.tag_support import unsupported_tags
from teleopctl.mujoco_model.urdf_import import apply_gazebo, import_urdf
from teleopctl.robot import Joints, check_mjcf, check_mjcf_text, unknown_tags, with_source_places

if TYPE_CHECKING:
    from pathlib import Path

    from teleopctl.robot import RobotDescription, Scene, World

# Prefix of the names of all parts of the world except bodies, whose names are frames.
WORLD_PREFIX = "world/"

# Left-out elements of a MuJoCo scene: they are for a robot that is not part of the world.
_LEFT_OUT = {
    "actuators": "actuators",
    "sensors": "sensors",
    "equalities": "equalities",
    "tendons": "tendons",
    "excludes": "excludes",
    "pairs": "contact pairs",
    "cameras": "cameras",
}
# Settings of the whole simulation, which the robot's spec decides.
_OF_ALL = ("option", "visual", "stat", "memory", "njmax", "nconmax", "nstack", "nuserdata")


def add_world(spec: mujoco.MjSpec, world: World, frame: str) -> tuple[list[FreeBody], list[str]]:
    """Add a world and its gravity to a robot's spec; return the world's free bodies, and warnings.

    Args:
        spec: The ``mujoco.MjSpec`` of the robot.
        world: World to add.
        frame: Name of the frame at the world's origin.

    Returns:
        Freely moving bodies of the world, and a warning for each part that was repaired or left
        out.

    Raises:
        InvalidDescriptionError: MuJoCo cannot simulate the world, or a link of the robot has the
            name of a body of the world.
    """
    things, warnings = read_objects(world)
    spec.option.gravity = things.option.gravity
    if things.option.magnetic.tolist() != mujoco.MjOption().magnetic.tolist():
        spec.option.magnetic = things.option.magnetic
    bodies = attach_objects(spec, things, str(world.path), frame)
    # Warnings about SDF have a file and line already.
    remarks = () if world.scene is None else world.scene.remarks
    return bodies, [*remarks, *(f"{world.path.name}: {warning}" for warning in warnings)]


def read_objects(world: World) -> tuple[mujoco.MjSpec, list[str]]:
    """Return the ``mujoco.MjSpec`` of a world's file or text, and warnings; raise if invalid.

    Raises:
        InvalidDescriptionError: MuJoCo cannot simulate the world.
    """
    if world.scene is not None:
        return _build(world.path, world.scene)
    if world.description is not None:
        things, warnings = _read_urdf(world.path, world.description)
        return things, [with_source_places(warning, world.places) for warning in warnings]
    things = _read_scene(world)
    warnings = _only_things(things)
    _check_compiles(things, world.path)
    return things, warnings


def attach_objects(
    spec: mujoco.MjSpec,
    things: mujoco.MjSpec,
    where: str,
    frame: str,
    *,
    prefix: str = WORLD_PREFIX,
    holder: mujoco.MjsBody | None = None,
    origin: tuple[np.ndarray, np.ndarray] | None = None,
) -> list[FreeBody]:
    """Attach a world's spec to a robot's spec; return the freely moving bodies.

    Args:
        spec: The ``mujoco.MjSpec`` of the robot.
        things: The ``mujoco.MjSpec`` of the objects, not to be used afterwards.
        where: Name of the world in error messages, such as its path.
        frame: Name of the frame at the world's origin.
        prefix: Prefix of the names of all parts except bodies, whose names are frames.
        holder: Body that the objects are attached to; the world by default.
        origin: Pose of the objects' origin in ``holder``: (3,) in metres, and (4,), w x y z.

    Raises:
        InvalidDescriptionError: The robot's spec has a body of the same name.
    """
    for name in _OF_ALL:
        setattr(things, name, getattr(spec, name))
    free = _name_parts(things)
    names = [body.name for body in things.bodies if body.name != "world"]
    taken = {body.name for body in spec.bodies}.intersection(names)
    if taken:
        raise InvalidDescriptionError(
            f"{where}: '{min(taken)}' is in the world, and is a link of the robot",
            hint="Rename one of them, or choose another world.",
        )
    if any(len(geom.userdata) for geom in things.geoms):
        spec.nuser_geom = -1  # automatic: as many as the shapes have
    spec.compiler.balanceinertia |= things.compiler.balanceinertia
    # All objects can be removed with this named frame at once, which for hundreds takes MuJoCo
    # milliseconds instead of seconds.
    base = (holder or spec.worldbody).add_frame(name=prefix)
    if origin is not None:
        base.pos, base.quat = origin
    spec.attach(things, prefix=prefix, frame=base)
    for name in names:
        spec.body(f"{prefix}{name}").name = name
    _find_bodies(spec, prefix, "world" if holder is None else holder.name)
    if free:
        # Sleeping objects cost no time until something touches or moves them.
        spec.option.enableflags |= mujoco.mjtEnableBit.mjENBL_SLEEP
    return [FreeBody(link, f"{prefix}{joint}", frame) for link, joint in free]


def _find_bodies(spec: mujoco.MjSpec, prefix: str, world: str) -> None:
    """Remove a prefix from the body names in contact exclusions and equality constraints."""
    names = ("bodyname1", "bodyname2")
    referring = [(pair, name) for pair in spec.excludes for name in names]
    referring += [
        (tie, name)
        for tie in spec.equalities
        if tie.objtype == mujoco.mjtObj.mjOBJ_BODY
        for name in ("name1", "name2")
    ]
    for element, name in referring:
        referred = getattr(element, name)
        if referred.startswith(prefix):
            found = referred.removeprefix(prefix)
            setattr(element, name, world if found == "world" else found)


def world_geoms(model: mujoco.MjModel, bodies: Container[str] = ()) -> tuple[int, ...]:
    """Return the indices of the geoms that belong to the world, not to the robot.

    Args:
        model: The ``mujoco.MjModel``.
        bodies: Names of further bodies whose geoms belong to the world.
    """
    geoms = [model.geom(n) for n in range(model.ngeom)]
    return tuple(
        geom.id
        for geom in geoms
        if geom.name.startswith(WORLD_PREFIX) or model.body(geom.bodyid[0]).name in bodies
    )


def _read_urdf(path: Path, description: RobotDescription) -> tuple[mujoco.MjSpec, list[str]]:
    things, warnings = _import(path, description)
    try:
        _check_compiles(things, path)
    except InvalidDescriptionError:
        # Leave out only the broken mesh, not the whole world.
        things, warnings = _import(path, description, try_each_mesh=True)
        _check_compiles(things, path)
    return things, warnings


def _build(path: Path, scene: Scene) -> tuple[mujoco.MjSpec, list[str]]:
    try:
        things, warnings = scene_spec(scene)
    except ValueError as error:  # two bodies have the same name
        raise _refusal(path, error) from error
    try:
        _check_compiles(things, path)
    except InvalidDescriptionError:
        things, warnings = scene_spec(scene, try_each=True)
        _check_compiles(things, path)
    return things, warnings


def _import(
    path: Path, description: RobotDescription, *, try_each_mesh: bool = False
) -> tuple[mujoco.MjSpec, list[str]]:
    try:
        things = import_urdf(description.urdf)
        sensors = description.gazebo.sensors
        joints = Joints.of(description)
    except InvalidDescriptionError as error:
        raise error.at(str(path)) from error
    warnings = [*description.repairs]
    warnings += resolve_meshes(things, path.parent, try_each=try_each_mesh)
    warnings += repair_inertias(things) + unsupported_tags(description.urdf)
    warnings += unknown_tags(description.urdf)
    warnings += [
        f"<ros2_control> '{system.name}' is left out: models of a world have no controllers, and "
        "move only when pushed"
        for system in description.ros2_control
    ]
    warnings += [
        f"Sensor '{sensor.name}' is left out: only robots have sensors" for sensor in sensors
    ]
    warnings += [
        f"<selfCollide> of '{link}' has no effect: the parts of a world collide with one another"
        for link, physics in description.gazebo.links.items()
        if physics.self_collide is False
    ]
    warnings += [
        ACROSS_LEFT_OUT.format(link)
        for link, physics in description.gazebo.links.items()
        if physics.across is not None
    ]
    apply_gazebo(things, description)
    for name, joint in joints.items():
        if joint.mimic is not None:
            leader = joint.mimic.joint if joint.mimic.joint in joints else ""
            add_mimic(things, name, leader, joint.mimic)
    return things, warnings


def _read_scene(world: World) -> mujoco.MjSpec:
    try:
        if world.text:
            check_mjcf_text(world.text, world.path)
            return mujoco.MjSpec.from_string(world.text)
        check_mjcf(world.path)
        return mujoco.MjSpec.from_file(str(world.path))
    except ValueError as error:
        raise _refusal(world.path, error) from error


def _check_compiles(things: mujoco.MjSpec, path: Path) -> None:
    """Compile a world alone, so that its errors are not reported as the robot's."""
    try:
        m = things.compile()
    except ValueError as error:
        raise _refusal(path, error) from error
    numbers = (m.body_pos, m.body_quat, m.body_mass, m.geom_pos, m.geom_quat, m.geom_size)
    if not all(np.isfinite(values).all() for values in numbers):
        raise InvalidDescriptionError(f"{path}: a place, a size or a mass is not finite")


def _refusal(path: Path, error: ValueError) -> InvalidDescriptionError:
    return InvalidDescriptionError(f"{path}: {' '.join(str(error).split())}")


def _only_things(scene: mujoco.MjSpec) -> list[str]:
    """Remove everything from a scene that is not an object; return warnings."""
    warnings = []
    for attribute, word in _LEFT_OUT.items():
        found: list[Any] = list(getattr(scene, attribute))
        if found:
            warnings.append(f"{len(found)} {word} are left out")
        for element in found:
            scene.delete(element)
    for key in list(scene.keys):
        scene.delete(key)
    return warnings


def _name_parts(things: mujoco.MjSpec) -> list[tuple[str, str]]:
    """Name all unnamed parts; return the freely moving bodies, with their joints."""
    for kind, elements in (("object", things.bodies), ("shape", things.geoms)):
        taken = {element.name for element in elements}
        number = 0
        for element in elements:
            while not element.name:
                number += 1
                if f"{kind}{number}" not in taken:
                    element.name = f"{kind}{number}"
    free = []
    for body in things.bodies:
        for number, joint in enumerate(body.joints):
            joint.name = joint.name or f"{body.name}_joint{number or ''}"
            if joint.type == mujoco.mjtJoint.mjJNT_FREE:
                free.append((body.name, joint.name))
    return free


@dataclass(frozen=True)
class WorldObject:
    """Object of the world, not the robot: topmost body, free joint and name prefix.

    Attributes:
        name: Name of the object's topmost body.
        joint: Name of the object's free joint; empty if the object is fixed.
        prefix: Prefix of the names of its parts; empty for an object of the robot's own file.
        spawned: Whether the object was spawned into the running simulation.
    """

    name: str
    joint: str
    prefix: str
    spawned: bool = False


def objects_since(
    before: Container[str],
    spec: mujoco.MjSpec,
    free: Iterable[FreeBody],
    *,
    prefix: str = WORLD_PREFIX,
) -> tuple[WorldObject, ...]:
    """Return a `WorldObject` for each topmost body of a spec whose name is not in ``before``.

    Args:
        before: Names of the topmost bodies that the spec had before.
        spec: The ``mujoco.MjSpec``.
        free: Freely moving bodies of the world.
        prefix: Prefix of the names of the objects' parts.
    """
    joints = {body.link: body.joint for body in free}
    return tuple(
        WorldObject(body.name, joints.get(body.name, ""), prefix)
        for body in spec.worldbody.bodies
        if body.name not in before
    )
