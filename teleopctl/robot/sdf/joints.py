"""Joints of SDF models; joints with two axes, and screws, become two joints.

A universal joint and a ``revolute2`` are two hinges in series, the first along ``<axis>`` and fixed
to the parent, the second along ``<axis2>`` and fixed to the child. A screw is a hinge, which keeps
its name, and a prismatic joint that mimics it. Between the two joints is a link of negligible mass.
A gearbox between two links with hinges is no joint: one hinge mimics the other.
"""

from __future__ import annotations

import math
from collections.abc import Container, Iterable
from dataclasses import dataclass, field, replace
from typing import Any

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot.scene.scene import (
    JointKind,
    SceneBody,
    SceneInertial,
    SceneJoint,
    SceneSensor,
    Vector3,
)
from teleopctl.robot.sdf.reading import MODEL, SdfFile, SdfFrames, relative_to
from teleopctl.robot.tags import sdf as tags
from teleopctl.robot.urdf import Mimic
from teleopctl.tf import Transform, conjugate, rotate

_KINDS: dict[str, JointKind] = {
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "fixed": "fixed",
    "ball": "ball",
    "screw": "revolute",
}
# Joint types with two axes, and the default axes, as in DART.
_OF_TWO = frozenset({"universal", "revolute2"})
_UNSAID_AXES: tuple[Vector3, Vector3] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
# Negligible, but not zero for MuJoCo.
_NO_MASS = SceneInertial(1e-9, (1e-12, 0.0, 0.0, 1e-12, 0.0, 1e-12))
_TABLES = {
    "universal": tags.JOINT_OF_TWO,
    "revolute2": tags.JOINT_OF_TWO,
    "screw": tags.SCREW,
    "gearbox": tags.GEARBOX,
}
# From this value on, SDF means that a joint has no limit.
_NO_LIMIT = 1e15
# Smallest cosine of the angle between a gearbox's axis and that of a hinge.
_ALONG = 0.999


# Any, here and below: lxml elements, whose class has no types.
@dataclass
class SdfJoints:
    """Reader of an SDF model's joints; a joint with two axes becomes two with a link between.

    Attributes:
        file: SDF file of the model.
        frames: Frames of the model.
        joints: Joints that were read, without those of nested models.
        between: Links added between the two joints that replace one.
    """

    file: SdfFile
    frames: SdfFrames
    joints: list[SceneJoint] = field(default_factory=list)
    between: list[SceneBody] = field(default_factory=list)

    def read(self, element: Any, links: Container[str]) -> None:
        """Append the joints of a ``<model>`` element, except gearboxes, to ``joints``.

        Args:
            element: ``<model>`` element.
            links: Names of the model's links.

        Raises:
            InvalidDescriptionError: A joint is invalid.
        """
        elements = element.findall("joint")
        of_two = {one.get("name") or "" for one in elements if one.get("type") in _OF_TWO}
        held = {
            (one.findtext("child") or "").strip()
            for one in elements
            if one.get("type") != "gearbox"
        }
        for one in elements:
            self.file.check_tags(one, _TABLES.get(one.get("type") or "", tags.JOINT))
            child = (one.findtext("child") or "").strip()
            if one.get("type") != "gearbox" or child not in held:
                self._add(one, links, of_two)

    def _add(self, element: Any, links: Container[str], of_two: Container[str]) -> None:
        file, name, said = self.file, element.get("name") or "", element.get("type") or ""
        kind = "fixed" if said in _OF_TWO else _KINDS.get(said)
        ends = [(element.findtext(tag) or "").strip() for tag in ("parent", "child")]
        if kind is None:
            words = f"<joint> of the type {element.get('type')} is treated as fixed"
            file.remarks.add(file.path, element.sourceline or 0, words)
            kind = "fixed"
        parent, child = map(self.frames.link_of, ends)
        for end, link in zip(ends, (parent, child), strict=True):
            if link != "world" and link not in links:
                raise InvalidDescriptionError(
                    f"{file.place(element)}: joint '{name}' is at '{end}', which is not a link"
                )
        bare = SceneJoint(
            name,
            kind,
            parent,
            child,
            self.frames.pose_of(frame_of_joint(element), element),
            sensors=read_sensors(file, element, self.frames),
            place=file.place(element),
        )
        if said in _OF_TWO:
            self._add_two(element, replace(bare, kind="revolute"), of_two)
            return
        joint = _along(file, element.find("axis"), self.frames, bare, of_two)
        if said == "continuous":
            joint = replace(joint, lower=-math.inf, upper=math.inf)
        if said == "screw":
            self._add_screw(element, joint)
        else:
            self.joints.append(joint)

    def _add_two(self, element: Any, bare: SceneJoint, of_two: Container[str]) -> None:
        """Add the two hinges of a joint with two axes, with a link between them."""
        link = self._between(bare)
        first, second = (
            _along(self.file, element.find(tag), self.frames, replace(bare, axis=usual), of_two)
            for tag, usual in zip(("axis", "axis2"), _UNSAID_AXES, strict=True)
        )
        said = f"{element.get('type')} joint '{bare.name}'"
        self.joints += [
            replace(first, name=f"{bare.name}_1", child=link, sensors=(), part_of=said),
            replace(second, name=f"{bare.name}_2", parent=link, part_of=said),
        ]

    def _add_screw(self, element: Any, turning: SceneJoint) -> None:
        """Add the hinge of a screw, and the prismatic joint that mimics the hinge."""
        link = self._between(turning)
        pitch = self.file.number(element, "screw_thread_pitch", math.nan)
        if math.isnan(pitch):
            # <thread_pitch> is in radians per metre, and positive for a left-handed thread.
            turns = self.file.number(element, "thread_pitch", -math.tau)
            if not turns:
                raise InvalidDescriptionError(
                    f"{self.file.place(element)}: the screw joint '{turning.name}' has a "
                    "<thread_pitch> of 0, which would be infinite"
                )
            pitch = -math.tau / turns
        said = f"screw joint '{turning.name}'"
        slide = SceneJoint(
            f"{turning.name}_slide",
            "prismatic",
            turning.parent,
            link,
            turning.pose,
            turning.axis,
            mimic=Mimic(turning.name, pitch / math.tau),
            place=turning.place,
            part_of=said,
        )
        self.joints += [slide, replace(turning, parent=link, part_of=said)]

    def _between(self, joint: SceneJoint) -> str:
        """Add a link of negligible mass at a joint; return the link's name."""
        name = f"{joint.name}_link"
        self.between.append(SceneBody(name, joint.pose, (), _NO_MASS))
        return name


def with_gearboxes(
    file: SdfFile, model: Any, frames: SdfFrames, joints: Iterable[SceneJoint]
) -> list[SceneJoint]:
    """Return a model's joints, with its gearboxes as mimic relations.

    The angle of the child about ``<axis2>`` is minus ``<gearbox_ratio>`` times that of the parent
    about ``<axis>``, both against the reference body.

    Args:
        file: SDF file of the model.
        model: ``<model>`` element.
        frames: Frames of the model.
        joints: All joints of the model, including those of nested models.
    """
    found = {joint.name: joint for joint in joints}
    for element in model.findall("joint"):
        if element.get("type") != "gearbox" or element.get("name") in found:
            continue
        reference, parent, child = (
            frames.link_of((element.findtext(tag) or "").strip())
            for tag in ("gearbox_reference_body", "parent", "child")
        )
        place = frames.pose_of(frame_of_joint(element), element)
        ends = []
        for tag, link in (("axis", parent), ("axis2", child)):
            axis = element.find(tag)
            xyz = (0.0, 0.0, 1.0) if axis is None else _axis(file, axis, frames, place)
            ends.append(_hinge(found.values(), reference, link, rotate(place.rotation, xyz)))
        (leader, turn), (follower, turned) = ends
        if leader is None or follower is None or follower.mimic is not None:
            file.leave_out(
                element,
                f"is left out: it needs hinges between its links and '{reference}', along its axes",
            )
            continue
        ratio = file.number(element, "gearbox_ratio", 1.0)
        found[follower.name] = replace(follower, mimic=Mimic(leader.name, -ratio * turn * turned))
    return list(found.values())


def _hinge(
    joints: Iterable[SceneJoint], reference: str, link: str, axis: Vector3
) -> tuple[SceneJoint | None, float]:
    """Return the hinge between two links along an axis, or None, and its direction: 1 or -1."""
    for joint in joints:
        if joint.kind != "revolute" or {joint.parent, joint.child} != {reference, link}:
            continue
        own = rotate(joint.pose.rotation, joint.axis)
        cosine = sum(a * b for a, b in zip(own, axis, strict=True)) / (
            math.hypot(*own) * math.hypot(*axis)
        )
        if abs(cosine) > _ALONG:
            return joint, math.copysign(1.0, cosine if joint.child == link else -cosine)
    return None, 1.0


def _along(
    file: SdfFile, axis: Any | None, frames: SdfFrames, bare: SceneJoint, of_two: Container[str]
) -> SceneJoint:
    """Return a joint with the settings of an ``<axis>``: direction, limits, dynamics and mimic."""
    if axis is None:
        return bare
    lower, upper = _limits(file, axis)
    return replace(
        bare,
        axis=_axis(file, axis, frames, bare.pose),
        lower=lower,
        upper=upper,
        effort=_most(file.number(axis, "limit/effort", -1.0)),
        velocity=_most(file.number(axis, "limit/velocity", -1.0)),
        damping=max(0.0, file.number(axis, "dynamics/damping", 0.0)),
        friction=max(0.0, file.number(axis, "dynamics/friction", 0.0)),
        stiffness=max(0.0, file.number(axis, "dynamics/spring_stiffness", 0.0)),
        relaxed=file.number(axis, "dynamics/spring_reference", 0.0),
        mimic=_mimic(file, axis.find("mimic"), of_two),
    )


def pose_in(file: SdfFile, element: Any, name: str, frames: SdfFrames) -> Transform:
    """Return an element's ``<pose>`` in the frame of the link or joint that holds the element."""
    pose = element.find("pose")
    here, relative = file.pose(pose), relative_to(pose)
    if relative in ("", name):
        return here
    return frames.pose_of(name, element).inverse() @ frames.pose_of(relative, element) @ here


def read_sensors(file: SdfFile, holder: Any, frames: SdfFrames) -> tuple[SceneSensor, ...]:
    """Return the sensors of an SDF link or joint, with their poses."""
    name = holder.get("name") or ""
    return tuple(
        SceneSensor(sensor, pose_in(file, sensor, name, frames))
        for sensor in holder.iterfind("sensor")
    )


def frame_of_joint(joint: Any) -> str:
    """Return a name for a joint's frame that no link or frame of the model has."""
    name, model = joint.get("name") or "", joint.getparent()
    taken = {one.get("name") for tag in ("link", "frame") for one in model.findall(tag)}
    return f"{name} (joint)" if name in taken else name


def _limits(file: SdfFile, axis: Any) -> tuple[float, float]:
    """Return the lower and the upper limit of a joint's range; infinite for none."""
    lower = file.number(axis, "limit/lower", -math.inf)
    upper = file.number(axis, "limit/upper", math.inf)
    if lower > upper:
        file.leave_out(axis.find("limit"), "is left out: its lower end is above its upper one")
        return -math.inf, math.inf
    return (
        -math.inf if lower <= -_NO_LIMIT else lower,
        math.inf if upper >= _NO_LIMIT else upper,
    )


def _mimic(file: SdfFile, element: Any | None, of_two: Container[str]) -> Mimic | None:
    """Return the mimic relation of a ``<mimic>``: multiplier * (leader - reference) + offset."""
    if element is None:
        return None
    multiplier, offset, reference = (
        file.number(element, tag, usual)
        for tag, usual in (("multiplier", 1.0), ("offset", 0.0), ("reference", 0.0))
    )
    leader = element.get("joint") or ""
    if leader in of_two:
        leader += "_2" if element.get("axis") == "axis2" else "_1"
    return Mimic(leader, multiplier, offset - multiplier * reference)


def _axis(file: SdfFile, axis: Any, frames: SdfFrames, place: Transform) -> Vector3:
    """Return the axis of a joint in the joint's frame."""
    xyz = axis.find("xyz")
    vector = file.vector(axis, "xyz", (0.0, 0.0, 1.0))
    if not any(vector):
        raise InvalidDescriptionError(f"{file.place(axis)}: an axis of length 0")
    frame = (None if xyz is None else xyz.get("expressed_in")) or None
    # Before SDF 1.5 an axis was in the model's frame.
    old = axis.find("use_parent_model_frame") is None and file.version < (1, 5)
    if frame is None and (old or file.flag(axis, "use_parent_model_frame")):
        frame = MODEL
    if frame is None:
        return vector
    in_model = rotate(frames.pose_of(frame, axis).rotation, vector)
    return rotate(conjugate(place.rotation), in_model)


def _most(value: float) -> float:
    """Return a limit of effort or speed; infinite for negative or very large numbers."""
    return math.inf if value < 0.0 or value >= _NO_LIMIT else value


def in_outer_model(joint: SceneJoint, prefix: str, place: Transform) -> SceneJoint:
    """Return a nested model's joint as a joint of the outer model, with prefixed names.

    Args:
        joint: Joint of the nested model.
        prefix: Prefix of the nested model's names.
        place: Pose of the nested model.
    """
    parent = joint.parent if joint.parent == "world" else f"{prefix}{joint.parent}"
    mimic = joint.mimic and replace(joint.mimic, joint=f"{prefix}{joint.mimic.joint}")
    return replace(
        joint,
        name=f"{prefix}{joint.name}",
        mimic=mimic,
        parent=parent,
        child=f"{prefix}{joint.child}",
        pose=place @ joint.pose,
    )
