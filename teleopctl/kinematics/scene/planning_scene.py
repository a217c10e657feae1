"""Planning scene: a robot, objects around it or attached to it, and allowed collisions."""

from __future__ import annotations

import copy
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import mujoco
import numpy as np

from teleopctl.errors import InvalidDescriptionError, NotFoundError, UsageError
from teleopctl.kinematics.clearance import ClearanceChecker
from teleopctl.kinematics.model import KinematicModel
from teleopctl.kinematics.poses import Array, invert_pose
from teleopctl.kinematics.scene.allowed_collisions import AllowedCollisions
from teleopctl.kinematics.scene.shapes import CollisionShape, ShapeKind, add_geoms, plane_side

# Prefix of the names of bodies and geoms that a scene adds to the model.
_PREFIX = "scene/"
# Density of what a link carries, kg/m³, where its mass is not given: water's, MuJoCo's default.
_DENSITY = 1000.0
# Distance, m, from which a held object counts as lying on something.
_RESTS_M = 2e-3


@dataclass(frozen=True)
class CollisionBody:
    """Object of a planning scene.

    Attributes:
        name: Name of the object.
        pose: Pose in the root link's frame, or for an attached object in its link's, (4, 4).
        shapes: Shapes.
        shape_poses: Pose of each shape in the object's frame, (4, 4).
        subframes: Further frames by name: their poses in the object's frame, (4, 4).
        type: Key and database of the kind of object, as of ``object_recognition_msgs``.
        is_free: Whether it moves freely in the simulation, so that a gripper may grasp it.
        is_simulated: Whether it is there because the simulator's world has it.
    """

    name: str
    pose: Array
    shapes: tuple[CollisionShape, ...]
    shape_poses: tuple[Array, ...]
    subframes: Mapping[str, Array] = field(default_factory=dict)
    type: tuple[str, str] = ("", "")
    is_free: bool = False
    is_simulated: bool = False


@dataclass(frozen=True)
class AttachedBody:
    """Object that is attached to a link.

    Attributes:
        object: The object, with its pose in the link's frame.
        link: Name of the link.
        touch_links: Links that may touch it.
        weight: Its mass, kg; 0 for that of water in its shapes.
        detach_posture: Message of the gripper's motion that releases it; None if not given.
    """

    object: CollisionBody
    link: str
    touch_links: frozenset[str] = frozenset()
    weight: float = 0.0
    # Any: the message is passed on as it is.
    detach_posture: Any = None


@dataclass(frozen=True, slots=True)
class CompiledScene:
    """Compiled planning scene: a model with all objects, and its collision check.

    Attributes:
        model: Model of the robot, with the objects; its state is its own.
        clearance: Collision check of the model.
        version: Version of the scene that was compiled.
    """

    model: KinematicModel
    clearance: ClearanceChecker
    version: int

    def mass(self, attached: str) -> float:
        """Return the mass of an attached object, kg."""
        return float(self.model.mj_model.body(f"{_PREFIX}{attached}").mass[0])


class CollisionScene:
    """Objects around a robot, and objects attached to it.

    Each change takes effect at the next `compiled`, which makes one model of robot and objects.

    Args:
        model: Model of the robot, at its present state; the scene does not move it.
        allowed: Pairs of links that may touch, such as those of an SRDF.

    Attributes:
        model: Model of the robot.
        name: Name of the scene.
        allowed: What may touch what.
        padding_m: Distance, m, by which links count as larger against objects, by link.
        scale: Factor by which links count as larger against objects, by link; at least 1.
        colors: Colours of objects and links: red, green, blue, alpha, 0 to 1.
        version: Number of changes.
    """

    def __init__(self, model: KinematicModel, allowed: Iterable[tuple[str, str]] = ()) -> None:
        self.model = model
        self.name = "(noname)"
        self.allowed = AllowedCollisions(allowed)
        self.padding_m: dict[str, float] = {}
        self.scale: dict[str, float] = {}
        self.colors: dict[str, tuple[float, float, float, float]] = {}
        self.version = 0
        self._objects: dict[str, CollisionBody] = {}
        self._attached: dict[str, AttachedBody] = {}
        self._compiled: CompiledScene | None = None

    @property
    def objects(self) -> Mapping[str, CollisionBody]:
        """Objects around the robot by name."""
        return self._objects

    @property
    def attached(self) -> Mapping[str, AttachedBody]:
        """Attached objects by name."""
        return self._attached

    def changed(self) -> None:
        """Count a change; to be called after one of `allowed`, `padding_m` or `scale`."""
        self.version += 1

    def copy(self) -> CollisionScene:
        """Return a copy of the scene, which changes independently."""
        other = copy.copy(self)
        other.allowed = self.allowed.copy()
        for name in ("padding_m", "scale", "colors", "_objects", "_attached"):
            setattr(other, name, dict(getattr(self, name)))
        return other

    def restore(self, before: CollisionScene) -> None:
        """Undo all changes since a `copy`."""
        self.allowed = before.allowed
        for name in ("padding_m", "scale", "colors", "_objects", "_attached"):
            setattr(self, name, getattr(before, name))
        self.changed()

    # --- objects --------------------------------------------------------------------------------

    def add(self, added: CollisionBody) -> None:
        """Add an object; one of the same name is replaced.

        Raises:
            UsageError: The name is empty, or the object has no shape.
        """
        if not added.name:
            raise UsageError("A collision object needs an id")
        if not added.shapes:
            raise UsageError(f"The collision object '{added.name}' has no shape")
        self._objects[added.name] = added
        self.changed()

    def append(self, added: CollisionBody) -> None:
        """Add shapes to an object; add the object if there is none of its name."""
        known = self._objects.get(added.name)
        if known is None:
            self.add(added)
            return
        self._objects[added.name] = _joined(known, added)
        self.changed()

    def move(self, name: str, pose: Array, shape_poses: Sequence[Array] = ()) -> None:
        """Move an object, and its shapes within it if poses of these are given.

        Raises:
            NotFoundError: There is no such object.
            UsageError: There is another number of poses than of shapes.
        """
        known = self._object(name)
        if len(shape_poses) not in (0, len(known.shapes)):
            raise UsageError(
                f"The collision object '{name}' has {len(known.shapes)} shapes, got "
                f"{len(shape_poses)} poses"
            )
        self._objects[name] = replace(
            known, pose=pose, shape_poses=tuple(shape_poses) or known.shape_poses
        )
        self.changed()

    def remove(self, name: str) -> None:
        """Remove an object, and its entries in the allowed collision matrix.

        Raises:
            NotFoundError: There is no such object.
        """
        self._object(name)
        del self._objects[name]
        self._forget(name)
        self.changed()

    def clear(self) -> None:
        """Remove all objects around the robot; attached ones stay."""
        for name in list(self._objects):
            self.remove(name)

    def _object(self, name: str) -> CollisionBody:
        try:
            return self._objects[name]
        except KeyError:
            known = ", ".join(self._objects) or "none"
            raise NotFoundError(
                f"There is no collision object '{name}'", hint=f"There are: {known}"
            ) from None

    def _forget(self, name: str) -> None:
        self.colors.pop(name, None)
        self.allowed.forget(name)

    # --- attached objects -----------------------------------------------------------------------

    def attach(self, attached: AttachedBody) -> list[str]:
        """Attach an object to a link; it replaces one of the same name around the robot.

        Returns:
            Names of the objects on which it lies and which it may therefore touch: only for what
            the simulator's world has.

        Raises:
            NotFoundError: There is no such link.
            UsageError: The object has no shape.
        """
        self.model.body(attached.link)
        name = attached.object.name
        if not attached.object.shapes:
            raise UsageError(f"The attached object '{name}' has no shape")
        under = self._lies_on(attached) if attached.object.is_simulated else []
        self._hold(attached)
        for other in under:
            self.allowed.set(name, other, is_allowed=True)
        self.changed()
        return under

    def take(self, name: str, link: str) -> CollisionBody:
        """Return an object around the robot as `attach` needs it, at its present pose from a link.

        Raises:
            NotFoundError: There is no such object or link.
        """
        known = self._object(name)
        return replace(known, pose=invert_pose(self.model.pose(link)) @ known.pose)

    def append_attached(self, attached: AttachedBody) -> None:
        """Add shapes to an attached object; attach it if there is none of its name."""
        known = self._attached.get(attached.object.name)
        if known is None:
            self.attach(attached)
            return
        self._attached[known.object.name] = replace(
            known,
            object=_joined(known.object, attached.object),
            touch_links=known.touch_links | attached.touch_links,
            detach_posture=attached.detach_posture or known.detach_posture,
        )
        self.changed()

    def detach(self, name: str) -> None:
        """Detach an object: it stays at its present pose, around the robot.

        Raises:
            NotFoundError: There is no such attached object.
        """
        if name not in self._attached:
            known = ", ".join(self._attached) or "none"
            raise NotFoundError(
                f"There is no attached object '{name}'", hint=f"Attached are: {known}"
            )
        one = self._attached.pop(name)
        if name not in self._objects:
            pose = self.model.pose(one.link) @ one.object.pose
            self._objects[name] = replace(one.object, pose=pose)
        self.changed()

    def drop(self, name: str) -> None:
        """Remove an attached object from the scene, if there is one of the name."""
        if self._attached.pop(name, None) is not None:
            self._forget(name)
            self.changed()

    def _lies_on(self, attached: AttachedBody) -> list[str]:
        """Return the objects that an object to be attached touches at its present pose."""
        name = attached.object.name
        probe = self.copy()
        probe._hold(replace(attached, touch_links=frozenset(self.model.links)))  # noqa: SLF001 - of this class
        touching = (one.bodies for one in probe.compile().clearance.near(_RESTS_M))
        under = {other for pair in touching if name in pair for other in pair}
        return sorted(under & probe.objects.keys())

    def _hold(self, attached: AttachedBody) -> None:
        self._objects.pop(attached.object.name, None)
        self._attached[attached.object.name] = attached

    # --- frames ---------------------------------------------------------------------------------

    def frame(self, name: str) -> Array | None:
        """Return the present pose of a frame in the root link's frame, (4, 4); None if unknown.

        Frames are links, objects, and ``OBJECT/SUBFRAME``.
        """
        if name in self.model.links:
            return self.model.pose(name)
        link = self.fixed_to(name)
        if link is not None:
            return np.asarray(self.model.pose(link[0]) @ link[1])
        found = _find(name, self._objects)
        return None if found is None else np.asarray(found[0].pose @ found[1])

    def fixed_to(self, name: str) -> tuple[str, Array] | None:
        """Return the link to which a frame of an attached object is fixed, and its pose there."""
        found = _find(name, {key: one.object for key, one in self._attached.items()})
        if found is None:
            return None
        known, subframe = found
        return self._attached[known.name].link, np.asarray(known.pose @ subframe)

    # --- compiled -------------------------------------------------------------------------------

    def compiled(self) -> CompiledScene:
        """Return the compiled scene, the same one until the scene changes."""
        if self._compiled is None or self._compiled.version != self.version:
            self._compiled = self.compile()
        return self._compiled

    def compile(self) -> CompiledScene:
        """Return a newly compiled scene at the present state, for a thread of its own.

        Raises:
            InvalidDescriptionError: MuJoCo cannot compile an object.
        """
        geoms: dict[str, list[str]] = {}

        def add(spec: Any) -> None:
            for one in self._objects.values():
                geoms[one.name] = _add(spec, spec.worldbody, self.model.to_world(one.pose), one)
            if self._attached:
                self._check_across_joints(spec)
            for attached in self._attached.values():
                one = attached.object
                body = spec.body(attached.link).add_body(name=f"{_PREFIX}{one.name}")
                geoms[one.name] = _add(spec, body, one.pose, one, _DENSITY)

        model = self.model.with_changes(add)
        for attached in self._attached.values():
            _weigh(model, f"{_PREFIX}{attached.object.name}", attached.weight)
        numbers = {
            name: [int(model.mj_model.geom(geom).id) for geom in names]
            for name, names in geoms.items()
        }
        touched = {name: one.touch_links for name, one in self._attached.items()}
        allowed = self.allowed.copy()

        def may_touch(first: str, second: str) -> bool:
            if second in touched.get(first, ()) or first in touched.get(second, ()):
                return True
            return allowed.is_allowed(first, second)

        clearance = ClearanceChecker(
            model,
            objects=numbers,
            may_touch=may_touch,
            padding_m=self._padding(model),
        )
        return CompiledScene(model, clearance, self.version)

    def _check_across_joints(self, spec: Any) -> None:
        """Add pairs of what a link carries and the links before the last joint to MuJoCo's checks.

        It leaves out all that is fixed to the two links of a joint; for links this is said instead
        by exclusions.
        """
        m = self.model.mj_model
        spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_FILTERPARENT
        numbers = list(self.model.links.items())
        for place, (first, a) in enumerate(numbers):
            for second, b in numbers[place + 1 :]:
                weld_a, weld_b = int(m.body_weldid[a]), int(m.body_weldid[b])
                above_a = int(m.body_weldid[m.body_parentid[weld_a]])
                above_b = int(m.body_weldid[m.body_parentid[weld_b]])
                if weld_a and weld_b and (weld_a == above_b or weld_b == above_a):
                    spec.add_exclude(bodyname1=first, bodyname2=second)

    def _padding(self, model: KinematicModel) -> Array | None:
        if not any(self.padding_m.values()) and all(s <= 1.0 for s in self.scale.values()):
            return None
        m = model.mj_model
        padding = np.zeros(m.ngeom)
        for link in self.padding_m.keys() | self.scale.keys():
            body = model.links.get(link)
            if body is None:
                continue
            own = m.geom_bodyid == body
            # No point of a shape moves farther than its radius grows.
            grown = max(self.scale.get(link, 1.0) - 1.0, 0.0) * m.geom_rbound[own]
            padding[own] = self.padding_m.get(link, 0.0) + grown
        return padding


def _joined(known: CollisionBody, added: CollisionBody) -> CollisionBody:
    """Return an object with the shapes of another one too, which stay where they are."""
    moved = invert_pose(known.pose) @ added.pose
    return replace(
        known,
        shapes=known.shapes + added.shapes,
        shape_poses=(*known.shape_poses, *(moved @ pose for pose in added.shape_poses)),
        subframes={
            **known.subframes,
            **{name: moved @ pose for name, pose in added.subframes.items()},
        },
        type=added.type if any(added.type) else known.type,
    )


def _find(name: str, objects: Mapping[str, CollisionBody]) -> tuple[CollisionBody, Array] | None:
    """Return the object of a frame, and the frame's pose in the object's frame."""
    if name in objects:
        return objects[name], np.eye(4)
    before, _, subframe = name.rpartition("/")
    if before in objects and subframe in objects[before].subframes:
        return objects[before], objects[before].subframes[subframe]
    return None


def _weigh(model: KinematicModel, body: str, mass: float) -> None:
    """Set the mass of a compiled body, kg, with the same distribution; 0 changes nothing."""
    m = model.mj_model
    number = m.body(body).id
    before = float(m.body_mass[number])
    if mass > 0.0 and before > 0.0:
        m.body_mass[number] = mass
        m.body_inertia[number] *= mass / before


def _add(
    spec: Any, parent: Any, T_parent_object: Array, one: CollisionBody, density: float = 0.0
) -> list[str]:
    names: list[str] = []
    for number, (shape, pose) in enumerate(zip(one.shapes, one.shape_poses, strict=True)):
        placed = np.asarray(T_parent_object @ pose)
        if shape.kind is ShapeKind.PLANE:
            if parent is not spec.worldbody:
                raise InvalidDescriptionError(
                    f"The object '{one.name}' is a plane, which no link can carry"
                )
            shape = plane_side(shape, np.asarray(one.pose @ pose))
        prefix = f"{_PREFIX}{one.name}/{number}"
        names += add_geoms(spec, parent, shape, placed, prefix, density)
    return names
