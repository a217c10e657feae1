"""Conversion of Gazebo's and our own scenes to a ``mujoco.MjSpec``."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from teleopctl.mujoco_model.assets import resolve_meshes
from teleopctl.mujoco_model.contacts import set_friction
from teleopctl.mujoco_model.convex import surface_slabs
from teleopctl.mujoco_model.drives import add_mimic, finite_range
from teleopctl.mujoco_model.inertia import repair_inertias
from teleopctl.mujoco_model.joints import close_loop
from teleopctl.mujoco_model.surroundings.surfaces import store_surface
from teleopctl.mujoco_model.urdf_import import (
    COLLISION_GROUP,
    VISUAL_GROUP,
    show_bare_collisions,
)
from teleopctl.robot import loop_of, tree_and_loops
from teleopctl.tf import Transform, matrix_from_quaternion, rotate

if TYPE_CHECKING:
    from collections.abc import Iterable

    from teleopctl.robot import (
        Scene,
        SceneBody,
        SceneInertial,
        SceneJoint,
        SceneLight,
        SceneModel,
        SceneShape,
    )

_GEOM = mujoco.mjtGeom
_KINDS = {
    "box": _GEOM.mjGEOM_BOX,
    "sphere": _GEOM.mjGEOM_SPHERE,
    "cylinder": _GEOM.mjGEOM_CYLINDER,
    "capsule": _GEOM.mjGEOM_CAPSULE,
    "ellipsoid": _GEOM.mjGEOM_ELLIPSOID,
    "plane": _GEOM.mjGEOM_PLANE,
    "mesh": _GEOM.mjGEOM_MESH,
    "heightmap": _GEOM.mjGEOM_HFIELD,
}
_LIGHTS = {
    "directional": mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
    "point": mujoco.mjtLightType.mjLIGHT_POINT,
    "spot": mujoco.mjtLightType.mjLIGHT_SPOT,
}
ACROSS_LEFT_OUT = "<mu2> of '{}' has no effect: in a world friction is the same in all directions"
# MuJoCo draws no more lights than this.
_MOST_LIGHTS = 90
# Thickness of a heightmap below its lowest point, in metres.
_BASE_M = 0.1


def scene_spec(scene: Scene, *, try_each: bool = False) -> tuple[mujoco.MjSpec, list[str]]:
    """Return the ``mujoco.MjSpec`` of a scene (SDF or YAML world), and warnings.

    Args:
        scene: Models and lights of the world.
        try_each: Whether to drop meshes that MuJoCo rejects, see `resolve_meshes`.

    Returns:
        The ``mujoco.MjSpec``, and a warning for each part that was repaired or left out.
    """
    builder = _Builder()
    if scene.gravity is not None:
        builder.spec.option.gravity = scene.gravity
    if scene.magnetic_field is not None:
        builder.spec.option.magnetic = scene.magnetic_field
    for model in scene.models:
        builder.add_model(model)
    for light in scene.lights[:_MOST_LIGHTS]:
        _add_light(builder.spec, light)
    if len(scene.lights) > _MOST_LIGHTS:
        builder.warnings.append(f"{len(scene.lights) - _MOST_LIGHTS} lights are left out")
    spec = builder.spec
    builder.warnings += resolve_meshes(spec, try_each=try_each)
    builder.warnings += repair_inertias(spec, builder.weighed_by_shape)
    show_bare_collisions(spec)
    return spec, builder.warnings


class _Builder:
    def __init__(self) -> None:
        self.spec = mujoco.MjSpec()
        self.spec.compiler.degree = False
        self.warnings: list[str] = []
        self._friction = float(self.spec.default.geom.friction[0])
        self._assets: dict[tuple[object, ...], str] = {}
        self._parts: dict[tuple[object, ...], list[str]] = {}
        # Names in the spec of the present model's moving joints, by their names in the model.
        self._names: dict[str, str] = {}
        # Bodies of the present model by link, with the poses of their frames in the model.
        self._made: dict[str, tuple[str, Transform]] = {}
        # Bodies whose mass is that of their shapes.
        self.weighed_by_shape: set[str] = set()

    def add_model(self, model: SceneModel) -> None:
        """Add a model of the scene to the spec: one body if static, else one per link."""
        self._report_left_out(model)
        if model.static:
            body = self.spec.worldbody.add_body(name=model.name)
            _put(body, model.pose)
            for part in model.bodies.values():
                self._add_shapes(body, part, part.pose, still=True)
            return
        self._names = {}
        self._made = {"world": ("world", Transform())}
        tree, closing = tree_and_loops(model.joints, model.bodies)
        joints = {joint.child: joint for joint in tree}
        roots = [name for name in model.bodies if _starts(joints.get(name), model)]
        for root in roots:
            # The body of a model with one root has the pose of the model, not of its first link.
            alone = len(roots) == 1
            name = model.name if alone else f"{model.name}/{root}"
            frame = Transform() if alone else model.bodies[root].pose
            body = self.spec.worldbody.add_body(name=name)
            _put(body, model.pose @ frame)
            held = joints.get(root)
            if held is None:
                body.add_freejoint()
            else:
                self._add_joint(body, held, frame)
            self._fill(body, model, root, frame, joints, still=held is not None)
        self._tie(model, joints.values())
        for joint in closing:
            self._close(model, joint)

    def _fill(
        self,
        body: Any,
        model: SceneModel,
        name: str,
        frame: Transform,
        joints: dict[str, SceneJoint],
        *,
        still: bool,
    ) -> None:
        """Add the shapes and the mass of a link to a MuJoCo body, and the link's descendants.

        Args:
            body: MuJoCo's body of the link.
            model: Model of the link.
            name: Name of the link.
            frame: Pose of the body in the model.
            joints: Joints of the model by child link.
            still: Whether the parent of the link is fixed to the world.
        """
        pending = [(body, name, frame, still)]
        for body, name, frame, still in pending:
            self._made[name] = (body.name, frame)
            part, joint = model.bodies[name], joints.get(name)
            here = frame.inverse() @ part.pose
            still = still and (joint is None or joint.kind == "fixed")
            self._add_shapes(body, part, here, still=still)
            if part.inertial is not None and not still:
                _weigh(body, part.inertial, here)
            elif not still and any(shape.touches for shape in part.shapes):
                self.weighed_by_shape.add(body.name)
            body.gravcomp = 0.0 if part.gravity else 1.0
            for child, link in joints.items():
                if link.parent == name:
                    own = model.bodies[child].pose
                    below = body.add_body(name=f"{model.name}/{child}")
                    _put(below, frame.inverse() @ own)
                    self._add_joint(below, link, own)
                    pending.append((below, child, own, still))

    def _add_joint(self, body: Any, joint: SceneJoint, frame: Transform) -> None:
        if joint.kind == "fixed":
            return
        place = frame.inverse() @ joint.pose
        name = self._names[joint.name] = f"{body.name}_{joint.name}"
        if joint.kind == "ball":
            body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_BALL, pos=list(place.translation))
            return
        turns = joint.kind == "revolute"
        made = body.add_joint(
            name=name,
            type=mujoco.mjtJoint.mjJNT_HINGE if turns else mujoco.mjtJoint.mjJNT_SLIDE,
            pos=list(place.translation),
            axis=list(rotate(place.rotation, joint.axis)),
            frictionloss=joint.friction,
        )
        made.damping[0], made.stiffness[0] = joint.damping, joint.stiffness
        made.springref = joint.relaxed
        if math.isfinite(joint.lower) or math.isfinite(joint.upper):
            made.limited = mujoco.mjtLimited.mjLIMITED_TRUE
            made.range = finite_range(joint.lower, joint.upper)

    def _close(self, model: SceneModel, joint: SceneJoint) -> None:
        """Add the constraint of a joint that closes a kinematic loop."""
        if joint.child not in self._made or joint.parent not in self._made:
            return
        child, frame = self._made[joint.child]
        loop = loop_of(joint, frame)
        if loop is None:
            self.warnings.append(
                f"Joint '{joint.name}' of '{model.name}' is left out: it slides and closes a loop"
            )
        else:
            close_loop(self.spec, loop, child, self._made[joint.parent][0])

    def _tie(self, model: SceneModel, joints: Iterable[SceneJoint]) -> None:
        """Add the constraints of mimic joints."""
        known = {joint.name for joint in model.joints}
        for joint in joints:
            if joint.mimic is None or joint.name not in self._names:
                continue
            leader = self._names.get(joint.mimic.joint, "")
            if joint.mimic.joint not in known or leader == self._names[joint.name]:
                self.warnings.append(
                    f"The <mimic> of joint '{joint.name}' is left out: there is no other joint "
                    f"'{joint.mimic.joint}'"
                )
                continue
            add_mimic(self.spec, self._names[joint.name], leader, joint.mimic)

    def _add_shapes(self, body: Any, part: SceneBody, frame: Transform, *, still: bool) -> None:
        for shape in part.shapes:
            if shape.kind in ("plane", "heightmap") and not still:
                self.warnings.append(
                    f"A {shape.kind} of '{body.name}' is left out: only static models may have one"
                )
                continue
            slabs = self._slabs(shape) if still and shape.touches else []
            for asset in slabs or [""]:
                self._add_shape(body, shape, frame, asset)

    def _add_shape(self, body: Any, shape: SceneShape, frame: Transform, asset: str = "") -> None:
        place, quat = _place(frame @ shape.pose)
        geom = body.add_geom(type=_KINDS[shape.kind], pos=place, quat=quat)
        a, b, c = shape.size
        match shape.kind:
            case "box":
                geom.size = [a / 2, b / 2, c / 2]
            case "cylinder" | "capsule":
                geom.size = [a, b / 2, 0.0]
            case "plane":
                geom.size = [a / 2, b / 2, 0.05]
            case "mesh":
                geom.meshname = asset or self._mesh(shape)
            case "heightmap":
                geom.hfieldname = self._heightmap(shape)
            case _:
                geom.size = [a, b, c]
        if shape.rgba is not None:
            geom.rgba = list(shape.rgba)
        geom.group = COLLISION_GROUP if shape.touches else VISUAL_GROUP
        if not shape.touches:
            geom.contype = geom.conaffinity = 0
            geom.density = 0.0
        else:
            if shape.friction is not None:
                set_friction(geom, shape.friction, self._friction)
            if shape.across is not None:
                self.warnings.append(ACROSS_LEFT_OUT.format(body.name))
            if shape.surface is not None:
                store_surface(geom, shape.surface)
            if shape.mass is not None:
                geom.mass = shape.mass
            if shape.density is not None:
                geom.density = shape.density

    def _mesh(self, shape: SceneShape) -> str:
        # Visual shapes are coloured and collision shapes are cut, so that they share no mesh.
        key = ("mesh", shape.file, shape.size, shape.touches)
        if key not in self._assets:
            self._assets[key] = f"mesh{len(self._assets)}"
            self.spec.add_mesh(name=self._assets[key], file=str(shape.file), scale=list(shape.size))
        return self._assets[key]

    def _slabs(self, shape: SceneShape) -> list[str]:
        """Return the names of the slab meshes that replace a hollow mesh; none if it needs none."""
        if shape.kind != "mesh" or shape.file is None:
            return []
        key = ("slabs", shape.file, shape.size)
        if key not in self._parts:
            number = len(self._parts)
            names: list[str] = []
            for corners in surface_slabs(shape.file, shape.size):
                names.append(f"slab{number}_{len(names)}")
                self.spec.add_mesh(name=names[-1], uservert=corners.ravel().tolist())
            self._parts[key] = names
        return self._parts[key]

    def _heightmap(self, shape: SceneShape) -> str:
        key = ("heightmap", shape.file, shape.size)
        if key not in self._assets:
            self._assets[key] = f"heightmap{len(self._assets)}"
            width, depth, height = shape.size
            self.spec.add_hfield(
                name=self._assets[key],
                file=str(shape.file),
                size=[width / 2, depth / 2, height, _BASE_M],
            )
        return self._assets[key]

    def _report_left_out(self, model: SceneModel) -> None:
        bodies = model.bodies.values()
        if len(bodies) > 1 and not (model.static or all(body.self_collides for body in bodies)):
            self.warnings.append(
                f"The parts of '{model.name}' collide with one another; <self_collide> is ignored"
            )
        sensors = [sensor.element for body in bodies for sensor in body.sensors]
        sensors += [sensor.element for joint in model.joints for sensor in joint.sensors]
        for words, elements in (("sensors", sensors), ("plug-ins", model.plugins)):
            if elements:
                names = ", ".join(dict.fromkeys(str(e.get("name") or e.tag) for e in elements))
                self.warnings.append(
                    f"'{model.name}' has {words} ({names}) that are left out: {words} are for "
                    "robots only"
                )


def _starts(joint: SceneJoint | None, model: SceneModel) -> bool:
    return joint is None or joint.parent == "world" or joint.parent not in model.bodies


# Any stands for MuJoCo's elements, which have no types.
def _put(body: Any, pose: Transform) -> None:
    body.pos, body.quat = _place(pose)


def _place(pose: Transform) -> tuple[list[float], list[float]]:
    x, y, z, w = pose.rotation
    return list(pose.translation), [w, x, y, z]


def _weigh(body: Any, inertial: SceneInertial, here: Transform) -> None:
    """Set the mass and inertia of a body, with the moments rotated to the body's axes."""
    pose = here @ inertial.pose
    rotation = np.array(matrix_from_quaternion(pose.rotation))
    xx, xy, xz, yy, yz, zz = inertial.moments
    moments = rotation @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ rotation.T
    body.explicitinertial = True
    body.mass, body.ipos = inertial.mass, list(pose.translation)
    body.fullinertia = [*np.diag(moments), moments[0, 1], moments[0, 2], moments[1, 2]]


def _add_light(spec: mujoco.MjSpec, light: SceneLight) -> None:
    spec.worldbody.add_light(
        type=_LIGHTS[light.kind],
        pos=list(light.pose.translation),
        dir=list(rotate(light.pose.rotation, light.direction)),
        diffuse=list(light.color),
        specular=list(light.specular),
        attenuation=list(light.attenuation),
        castshadow=light.shadows,
        cutoff=math.degrees(light.angle),
    )
