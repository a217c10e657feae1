"""Models of SDF: links, joints and what they include, brought into one frame."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from teleopctl.errors import InvalidDescriptionError, NotFoundError
from teleopctl.robot.scene.scene import JointKind, SceneBody, SceneJoint, SceneModel, Vector3
from teleopctl.robot.scene.sdf_frames import MODEL, Frames
from teleopctl.robot.scene.sdf_includes import find_file, model_file
from teleopctl.robot.scene.sdf_reading import Remarks, SdfFile, parse_sdf
from teleopctl.robot.scene.sdf_shapes import read_inertial, read_shape
from teleopctl.tf import Transform, conjugate, rotate

_KINDS: dict[str, JointKind] = {
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "fixed": "fixed",
    "ball": "ball",
}
# What changes nothing here: how Gazebo lets things sleep, show themselves and feel the wind.
_MODEL = frozenset(
    {"static", "pose", "link", "joint", "frame", "model", "include", "plugin", "self_collide"}
    | {"allow_auto_disable", "enable_wind", "meta"}
)
_LINK = frozenset(
    {"pose", "inertial", "visual", "collision", "sensor", "gravity", "self_collide", "kinematic"}
    | {"velocity_decay", "enable_wind", "must_be_base_link"}
)
_JOINT = frozenset({"pose", "parent", "child", "axis", "sensor", "physics"})
_AXIS = frozenset(
    {"xyz", "limit", "dynamics", "use_parent_model_frame", "initial_position"},
)
# An include that includes itself ends here.
_DEEPEST, _MOST_MODELS = 16, 20_000
# What Gazebo writes where there was a plug-in of its own.
_NO_PLUGIN = "__default__"
# Where SDF writes that a joint has no limit.
_NO_LIMIT = 1e15


# Any, here and below: elements of lxml, whose class has no types.
@dataclass
class Reading:
    """One run through a file and all that it includes.

    Attributes:
        remarks: What is left out.
        files: The files that were read.
        models: How many models were met.
    """

    remarks: Remarks = field(default_factory=Remarks)
    files: list[Path] = field(default_factory=list)
    models: int = 0

    def include(self, file: SdfFile, element: Any, depth: int) -> SceneModel | None:
        """Read what an ``<include>`` names; None for what cannot be had, which is noted.

        Raises:
            InvalidDescriptionError: It is broken, or includes itself.
        """
        uri = (element.findtext("uri") or "").strip()
        path, error = None, ""
        try:
            path = model_file(find_file(uri, file.path.parent)).absolute()
        except NotFoundError as missing:
            error = missing.message
        if path is None:
            file.leave_out(element, f"is left out: {error}")
            return None
        if depth > _DEEPEST:
            raise InvalidDescriptionError(
                f"{file.place(element)}: {_DEEPEST} files include one another"
            )
        root, inner = self.open(path)
        top = root.find("model")
        if top is None:
            file.leave_out(element, f"is left out: there is no model in {path}")
            return None
        model = self.model(inner, top, depth + 1)
        name = (element.findtext("name") or "").strip()
        static = element.find("static")
        pose = element.find("pose")
        return replace(
            model,
            name=name or model.name,
            static=model.static if static is None else file.flag(element, "static"),
            pose=model.pose if pose is None else file.pose(pose),
            plugins=(*model.plugins, *element.findall("plugin")),
        )

    def open(self, path: Path) -> tuple[Any, SdfFile]:
        """Read a file.

        Raises:
            InvalidDescriptionError: It cannot be read, or is no SDF.
        """
        try:
            content = path.read_bytes()
        except OSError as error:
            raise InvalidDescriptionError(f"Cannot read {path}: {error.strerror}") from error
        if path not in self.files:
            self.files.append(path)
        return parse_sdf(path, content, self.remarks)

    def model(self, file: SdfFile, element: Any, depth: int = 0) -> SceneModel:
        """Read a ``<model>``, with the models in it.

        Raises:
            InvalidDescriptionError: Something in it means nothing, or has no sense.
        """
        self.models += 1
        if self.models > _MOST_MODELS:
            raise InvalidDescriptionError(
                f"{file.place(element)}: more than {_MOST_MODELS} models in one another"
            )
        file.leave_rest(element, _MODEL)
        frames = Frames(file)
        for link in element.findall("link"):
            frames.put(link.get("name") or "", link)
        for frame in element.findall("frame"):
            frames.put(frame.get("name") or "", frame)
        for joint in element.findall("joint"):
            child = (joint.findtext("child") or "").strip()
            frames.put(joint.get("name") or "", joint, child)
        parts = self._nested(file, element, frames, depth)
        still = file.flag(element, "static")
        bodies = {
            link.get("name") or "": _body(file, link, frames, weighs=not still)
            for link in element.iterfind("link")
        }
        joints = [
            read for joint in element.iterfind("joint") if (read := _joint(file, joint, frames))
        ]
        for prefix, place, part in parts:
            for body in part.bodies.values():
                name = f"{prefix}{body.name}"
                bodies[name] = replace(body, name=name, pose=place @ body.pose)
            joints += [_moved(joint, prefix, place) for joint in part.joints]
        plugins = [p for p in element.findall("plugin") if p.get("filename") != _NO_PLUGIN]
        for _, _, part in parts:
            plugins += part.plugins
        static = still or (
            bool(parts) and not element.findall("link") and all(part.static for *_, part in parts)
        )
        pose = file.pose(element.find("pose"))
        placed = element.get("placement_frame")
        if placed:
            pose = pose @ frames.find(placed, element).inverse()
        return SceneModel(
            element.get("name") or "", pose, bodies, tuple(joints), static, tuple(plugins)
        )

    def _nested(
        self, file: SdfFile, element: Any, frames: Frames, depth: int
    ) -> list[tuple[str, Transform, SceneModel]]:
        """The models in a model: what is in front of their names, where they are, and they."""
        found: list[tuple[Any, SceneModel]] = []
        for child in (*element.findall("model"), *element.findall("include")):
            if child.tag == "include":
                included = self.include(file, child, depth)
                if included is not None:
                    found.append((child, included))
            else:
                found.append((child, self.model(file, child, depth + 1)))
        for child, part in found:
            frames.put(part.name, child)
            if child.find("pose") is None and child.tag == "include":
                frames.put_fixed(part.name, part.pose)
        parts = []
        for child, part in found:
            place = frames.find(part.name, child)
            prefix = "" if child.get("merge") == "true" else f"{part.name}::"
            for body in part.bodies.values():
                frames.put_fixed(f"{prefix}{body.name}", place @ body.pose)
            parts.append((prefix, place, part))
        return parts


def _body(file: SdfFile, link: Any, frames: Frames, *, weighs: bool) -> SceneBody:
    file.leave_rest(link, _LINK)
    name = link.get("name") or ""
    place = frames.find(name, link)

    def within(element: Any) -> Transform:
        pose = element.find("pose")
        relative = None if pose is None else (pose.get("relative_to") or pose.get("frame"))
        here = file.pose(pose)
        if not relative or relative == name:
            return here
        return place.inverse() @ frames.find(relative, element) @ here

    shapes = [
        read_shape(file, element, within(element))
        for element in (*link.findall("visual"), *link.findall("collision"))
    ]
    return SceneBody(
        name,
        place,
        tuple(shape for shape in shapes if shape is not None),
        read_inertial(file, link, within) if weighs else None,
        file.flag(link, "gravity", default=True),
        tuple(link.findall("sensor")),
    )


def _joint(file: SdfFile, element: Any, frames: Frames) -> SceneJoint | None:
    file.leave_rest(element, _JOINT)
    name = element.get("name") or ""
    kind = _KINDS.get(element.get("type") or "")
    parent, child = ((element.findtext(tag) or "").strip() for tag in ("parent", "child"))
    if kind is None:
        file.leave_out(element, f"of the type {element.get('type')} is taken for a fixed one")
        kind = "fixed"
    for end in (parent, child):
        if end != "world" and end not in frames:
            raise InvalidDescriptionError(
                f"{file.place(element)}: joint '{name}' is at '{end}', which is no link"
            )
    place = frames.find(name, element)
    axis = element.find("axis")
    if axis is None:
        return SceneJoint(
            name,
            kind,
            parent,
            child,
            place,
            sensors=tuple(element.findall("sensor")),
            place=file.place(element),
        )
    file.leave_rest(axis, _AXIS)
    endless = element.get("type") == "continuous"
    lower = file.number(axis, "limit/lower", -math.inf)
    upper = file.number(axis, "limit/upper", math.inf)
    return SceneJoint(
        name,
        kind,
        parent,
        child,
        place,
        _axis(file, axis, frames, place),
        -math.inf if endless or lower <= -_NO_LIMIT else lower,
        math.inf if endless or upper >= _NO_LIMIT else upper,
        _most(file.number(axis, "limit/effort", -1.0)),
        _most(file.number(axis, "limit/velocity", -1.0)),
        max(0.0, file.number(axis, "dynamics/damping", 0.0)),
        max(0.0, file.number(axis, "dynamics/friction", 0.0)),
        tuple(element.findall("sensor")),
        file.place(element),
    )


def _axis(file: SdfFile, axis: Any, frames: Frames, place: Transform) -> Vector3:
    """The axis of a joint in the joint's own frame."""
    xyz = axis.find("xyz")
    vector = file.vector(axis, "xyz", (0.0, 0.0, 1.0))
    if not any(vector):
        raise InvalidDescriptionError(f"{file.place(axis)}: an axis of length 0")
    frame = None if xyz is None else xyz.get("expressed_in")
    # Until SDF 1.5 an axis was along those of the model.
    old = axis.find("use_parent_model_frame") is None and file.version < (1, 5)
    if frame is None and (old or file.flag(axis, "use_parent_model_frame")):
        frame = MODEL
    if frame is None:
        return vector
    in_model = rotate(frames.find(frame, axis).rotation, vector)
    return rotate(conjugate(place.rotation), in_model)


def _most(value: float) -> float:
    """A limit of effort or speed: negative numbers mean none."""
    return math.inf if value < 0.0 or value >= _NO_LIMIT else value


def _moved(joint: SceneJoint, prefix: str, place: Transform) -> SceneJoint:
    parent = joint.parent if joint.parent == "world" else f"{prefix}{joint.parent}"
    return replace(
        joint,
        name=f"{prefix}{joint.name}",
        parent=parent,
        child=f"{prefix}{joint.child}",
        pose=place @ joint.pose,
    )
