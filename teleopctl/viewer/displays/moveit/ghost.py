"""A robot that stands elsewhere than the real one: in a planned state, at a goal.

Its description is drawn again, and its links stand where its own forward kinematics put them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from teleopctl.robot import Joints, JointSet, Material, RobotDescription, SegmentTree
from teleopctl.tf import Transform
from teleopctl.viewer.displays.reading import rgba_of
from teleopctl.viewer.displays.robot_parts import Parts, load_parts
from teleopctl.viewer.scene.mesh_files import MeshFile, load_mesh
from teleopctl.viewer.scene.shapes import ShapeDrawing

if TYPE_CHECKING:
    import viser

# Any stands for viser's handles.

# Differences that can be seen: 1 mm, and 2 mrad.
_SEEN_M = 1e-3
_SEEN_COSINE = math.cos(1e-3)

Color = tuple[int, int, int]


@dataclass(frozen=True, slots=True)
class OverlayModel:
    """A robot's description, kinematics, meshes and textures, to draw it in any state.

    Attributes:
        description: The robot.
        kinematics: Its forward kinematics.
        rest: Where its joints stand as long as nothing else is known.
        parts: Its meshes and textures.
        bare: Those meshes that bring materials, without them, so that they can be tinted.
    """

    description: RobotDescription
    kinematics: SegmentTree
    rest: dict[str, float]
    parts: Parts
    bare: dict[str, MeshFile]

    @classmethod
    def of(cls, urdf: str, folder: Path | None = None) -> OverlayModel:
        """Read a robot description and its meshes; takes long.

        Args:
            urdf: The description.
            folder: Where it is from, for paths that are relative to it.

        Raises:
            TeleopctlError: The description makes no sense.
        """
        description = RobotDescription.from_urdf(urdf)
        joints = Joints.for_display(description, lambda _warning: None)
        rest = {name: joint.zero for name, joint in JointSet(joints).free.items()}
        parts = load_parts(description, Parts(), folder)
        bare = {
            uri: load_mesh(uri, folder, bare=True) for uri, mesh in parts.meshes.items() if mesh.glb
        }
        return cls(description, SegmentTree(description, joints), rest, parts, bare)

    def poses(self, positions: Mapping[str, float]) -> dict[str, Transform]:
        """Return the pose of each link in the frame of the root link.

        Args:
            positions: Of joints, by name; the others rest, and those that follow one follow.
        """
        known = {**self.rest, **positions}
        moving = {
            joint.child: (joint.parent, transform)
            for joint, transform in self.kinematics.transforms(known)
        }
        fixed = {
            segment.joint.child: (segment.joint.parent, segment.origin)
            for segment in self.kinematics.fixed
        }
        steps = fixed | moving
        poses = {self.description.root: Transform()}
        # Parents come before their children.
        for joint in self.description.tree:
            if joint.child in steps and joint.parent in poses:
                poses[joint.child] = poses[joint.parent] @ steps[joint.child][1]
        return poses


class RobotOverlay:
    """A drawing of the robot in a given state, beside the real one.

    Args:
        scene: Where to draw.
        path: The name of the node below which it stands; that is the robot's root.
        model: What to draw.
        alpha: From 0, invisible, to 1.
        color: The colour of all its links; None is their own.
    """

    def __init__(
        self,
        scene: viser.SceneApi,
        path: str,
        model: OverlayModel,
        alpha: float,
        color: Color | None = None,
    ) -> None:
        self._model = model
        self._poses: dict[str, Transform] = {}
        self._root: Any = scene.add_frame(path, show_axes=False)
        self._links: dict[str, Any] = {}
        parts = model.parts
        tint = None if color is None else Material(rgba=rgba_of(color))
        meshes = parts.meshes if tint is None else {**parts.meshes, **model.bare}
        shapes = ShapeDrawing(scene, meshes, parts.textures)
        for number, link in enumerate(model.description.links.values()):
            if not link.visuals or alpha <= 0.0:
                continue
            name = f"{path}/link{number}"
            self._links[link.name] = scene.add_frame(name, show_axes=False)
            for index, visual in enumerate(link.visuals):
                material = tint or visual.material
                shapes.draw(f"{name}/{index}", visual.geometry, visual.origin, material, alpha)

    def stand(
        self, positions: Mapping[str, float], besides: Mapping[str, Transform] | None = None
    ) -> None:
        """Set the joint positions, and thereby the pose of each link.

        Args:
            positions: Of joints, by name; the others rest.
            besides: Where the links of another robot stand in the root. A link that stands in the
                same place is not drawn: of two surfaces in one place a browser draws stripes.
        """
        poses = self._model.poses(positions)
        for name, node in self._links.items():
            pose = poses.get(name)
            if pose is None:
                continue
            if pose != self._poses.get(name):
                x, y, z, w = pose.rotation
                node.position, node.wxyz = pose.translation, (w, x, y, z)
            other = besides.get(name) if besides else None
            apart = other is None or _are_apart(pose, other)
            if node.visible != apart:
                node.visible = apart
        self._poses = poses
        self.show(shown=True)

    @property
    def poses(self) -> Mapping[str, Transform]:
        """Poses of the links in the frame of the root link."""
        return self._poses

    def show(self, *, shown: bool) -> None:
        """Show or hide the robot."""
        if self._root.visible != shown:
            self._root.visible = shown

    def remove(self) -> None:
        """Remove the robot from the scene."""
        self._root.remove()


def _are_apart(one: Transform, other: Transform) -> bool:
    """Whether two poses differ so much that it can be seen."""
    step = one.inverse() @ other
    return math.hypot(*step.translation) > _SEEN_M or abs(step.rotation[3]) < _SEEN_COSINE
