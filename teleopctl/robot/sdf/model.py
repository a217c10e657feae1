"""Models of SDF: links, joints and included models, converted to one frame."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from teleopctl.errors import InvalidDescriptionError, NotFoundError
from teleopctl.robot.scene.scene import (
    SceneBody,
    SceneModel,
)
from teleopctl.robot.sdf.includes import find_file, model_file
from teleopctl.robot.sdf.joints import (
    SdfJoints,
    frame_of_joint,
    in_outer_model,
    pose_in,
    read_sensors,
    with_gearboxes,
)
from teleopctl.robot.sdf.reading import MODEL, Remarks, SdfFile, SdfFrames, parse_sdf
from teleopctl.robot.sdf.shapes import read_inertial, read_shape
from teleopctl.robot.tags import sdf as tags
from teleopctl.tf import Transform

# Limits that stop an include that includes itself.
_DEEPEST, _MOST_MODELS = 16, 20_000
# Gazebo writes this file name for a plug-in of its own.
_NO_PLUGIN = "__default__"


# Any, here and below: lxml elements, whose class has no types.
@dataclass
class SdfReader:
    """Reader of the models in an SDF file and in the files that it includes.

    Attributes:
        remarks: Elements that were left out.
        files: Files that were read.
        models: Number of models that were read.
    """

    remarks: Remarks = field(default_factory=Remarks)
    files: list[Path] = field(default_factory=list)
    models: int = 0

    def include(self, file: SdfFile, element: Any, depth: int) -> SceneModel | None:
        """Return the model that an SDF ``<include>`` names; None, with a remark, if not found.

        Raises:
            InvalidDescriptionError: The included file is invalid, or includes itself.
        """
        file.check_tags(element, tags.INCLUDE)
        uri = (element.findtext("uri") or "").strip()
        if not uri:
            file.leave_out(element, "is left out: it has no <uri>")
            return None
        try:
            path = model_file(find_file(uri, file.path.parent)).absolute()
        except NotFoundError as error:
            file.leave_out(element, f"is left out: {error.message}")
            return None
        if depth > _DEEPEST:
            raise InvalidDescriptionError(
                f"{file.place(element)}: {_DEEPEST} files include one another"
            )
        root, inner = self.parse_file(path)
        top = root.find("model")
        if top is None:
            file.leave_out(element, f"is left out: there is no model in {path}")
            return None
        pose = element.find("pose")
        model = self.model(
            inner,
            top,
            depth + 1,
            pose=None if pose is None else file.pose(pose),
            placement=(element.findtext("placement_frame") or "").strip(),
        )
        name = (element.findtext("name") or "").strip()
        return replace(
            model,
            name=name or model.name,
            static=file.flag(element, "static", default=model.static),
            plugins=(*model.plugins, *element.findall("plugin")),
        )

    def parse_file(self, path: Path) -> tuple[Any, SdfFile]:
        """Parse an SDF file; return its root element and its `SdfFile`.

        Raises:
            InvalidDescriptionError: The file cannot be read, or is no SDF.
        """
        try:
            content = path.read_bytes()
        except OSError as error:
            raise InvalidDescriptionError(f"Cannot read {path}: {error.strerror}") from error
        if path not in self.files:
            self.files.append(path)
        return parse_sdf(path, content, self.remarks)

    def model(
        self,
        file: SdfFile,
        element: Any,
        depth: int = 0,
        *,
        pose: Transform | None = None,
        placement: str = "",
    ) -> SceneModel:
        """Read a ``<model>`` element with its nested models; return it as a `SceneModel`.

        Args:
            file: SDF file of the model.
            element: ``<model>`` element.
            depth: Number of models or includes around the model.
            pose: Pose of the model; None for the model's own ``<pose>``.
            placement: Frame of the model that ``pose`` applies to; by default the model's
                ``placement_frame``.

        Raises:
            InvalidDescriptionError: The model is invalid.
        """
        self.models += 1
        if self.models > _MOST_MODELS:
            raise InvalidDescriptionError(
                f"{file.place(element)}: more than {_MOST_MODELS} models in one another"
            )
        file.check_tags(element, tags.MODEL)
        for tag in ("link", "joint", "frame"):
            _check_names(file, element.findall(tag))
        frames = SdfFrames(file)
        for link in element.findall("link"):
            frames.add(link.get("name") or "", link)
        for frame in element.findall("frame"):
            name, holder = frame.get("name") or "", frame.get("attached_to") or MODEL
            frames.add(name, frame, holder)
            frames.attached[name] = holder
        for joint in element.findall("joint"):
            child = (joint.findtext("child") or "").strip()
            name = frame_of_joint(joint)
            frames.add(name, joint, child)
            frames.attached[name] = child
        parts = self._nested(file, element, frames, depth)
        still = file.flag(element, "static")
        collides = file.flag(element, "self_collide", default=True)
        bodies = {
            link.get("name") or "": _body(file, link, frames, weighs=not still, collides=collides)
            for link in element.iterfind("link")
        }
        for prefix, place, part in parts:
            for body in part.bodies.values():
                name = f"{prefix}{body.name}"
                bodies[name] = replace(body, name=name, pose=place @ body.pose)
        # A model's frame is fixed to its canonical link, by default the first link.
        canonical = element.get("canonical_link") or ""
        if canonical and canonical not in bodies:
            file.leave_out(element, f"has no link '{canonical}': its first one is canonical")
            canonical = ""
        frames.attached[MODEL] = canonical or next(iter(bodies), "")
        own = SdfJoints(file, frames)
        own.read(element, bodies.keys())
        bodies |= {body.name: body for body in own.between}
        for prefix, place, part in parts:
            own.joints += [in_outer_model(joint, prefix, place) for joint in part.joints]
        joints = with_gearboxes(file, element, frames, own.joints)
        plugins = [p for p in element.findall("plugin") if p.get("filename") != _NO_PLUGIN]
        for _, _, part in parts:
            plugins += part.plugins
        static = still or (
            bool(parts) and not element.findall("link") and all(part.static for *_, part in parts)
        )
        where = file.pose(element.find("pose")) if pose is None else pose
        if placed := placement or element.get("placement_frame"):
            where = where @ frames.pose_of(placed, element).inverse()
        return SceneModel(
            element.get("name") or "",
            where,
            bodies,
            tuple(joints),
            static,
            tuple(plugins),
            {name: (frames.link_of(name), frames.pose_of(name, element)) for name in frames},
        )

    def _nested(
        self, file: SdfFile, element: Any, frames: SdfFrames, depth: int
    ) -> list[tuple[str, Transform, SceneModel]]:
        """Return prefix, pose and content of each model nested or included in a model."""
        found: list[tuple[Any, SceneModel]] = []
        for child in (*element.findall("model"), *element.findall("include")):
            if child.tag == "include":
                included = self.include(file, child, depth)
                if included is not None:
                    found.append((child, included))
            else:
                found.append((child, self.model(file, child, depth + 1)))
        parts = []
        for child, part in found:
            prefix = "" if child.get("merge") == "true" else f"{part.name}::"
            frames.add_model(part, child, prefix)
            parts.append((prefix, part, child))
        return [(prefix, frames.pose_of(part.name, child), part) for prefix, part, child in parts]


def _check_names(file: SdfFile, elements: list[Any]) -> None:
    """Raise unless each element has a unique name."""
    taken: set[str] = set()
    for element in elements:
        name = element.get("name") or ""
        if not name or name in taken:
            what = f"name '{name}' is given twice" if name else "it has no name"
            raise InvalidDescriptionError(f"{file.place(element)}: <{element.tag}>: {what}")
        taken.add(name)


def _body(
    file: SdfFile, link: Any, frames: SdfFrames, *, weighs: bool, collides: bool
) -> SceneBody:
    file.check_tags(link, tags.LINK)
    name = link.get("name") or ""
    shapes = [
        read_shape(file, element, pose_in(file, element, name, frames))
        for element in (*link.findall("visual"), *link.findall("collision"))
    ]
    inertial = link.find("inertial")
    at = Transform() if inertial is None else pose_in(file, inertial, name, frames)
    return SceneBody(
        name,
        frames.pose_of(name, link),
        tuple(shape for shape in shapes if shape is not None),
        read_inertial(file, link, at) if weighs else None,
        file.flag(link, "gravity", default=True),
        file.flag(link, "self_collide", default=collides),
        read_sensors(file, link, frames),
    )
