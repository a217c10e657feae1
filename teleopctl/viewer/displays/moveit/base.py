"""Base of MoveIt's displays, and the robot that they draw in other states than the present one."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from teleopctl.node import qos_profile_latched
from teleopctl.robot import Joints, JointSet, Material, RobotDescription, SegmentTree
from teleopctl.tf import Transform
from teleopctl.viewer.displays.base import ERROR, OK, WARN, Display
from teleopctl.viewer.displays.conversions import rgba_of
from teleopctl.viewer.displays.properties import Property, read_property
from teleopctl.viewer.displays.robot_model import RobotAssets, load_assets
from teleopctl.viewer.scene.assets import MeshFile, load_mesh
from teleopctl.viewer.scene.shapes import ShapeDrawing

if TYPE_CHECKING:
    import viser

# Any: viser's handles.

# Smallest visible differences of poses: 1 mm and 2 mrad.
_SEEN_M = 1e-3
_SEEN_COSINE = math.cos(1e-3)

Color = tuple[int, int, int]


@dataclass(frozen=True, slots=True)
class OverlayModel:
    """Robot to draw by `RobotOverlay`: description, kinematics, meshes and textures.

    Attributes:
        description: Description of the robot.
        kinematics: Forward kinematics of the robot.
        rest: Resting positions of the independent joints, used for joints without a position.
        parts: Meshes and textures of the robot.
        bare: Meshes with materials, loaded without these to be drawn in one colour.
    """

    description: RobotDescription
    kinematics: SegmentTree
    rest: dict[str, float]
    parts: RobotAssets
    bare: dict[str, MeshFile]

    @classmethod
    def from_urdf(cls, urdf: str, folder: Path | None = None) -> OverlayModel:
        """Return the `OverlayModel` of a URDF, with its meshes loaded; may take seconds.

        Args:
            urdf: Text of the robot description.
            folder: Folder of the description's file, for relative paths of meshes.

        Raises:
            TeleopctlError: The description is invalid.
        """
        description = RobotDescription.from_urdf(urdf)
        joints = Joints.for_display(description, lambda _warning: None)
        rest = {name: joint.zero for name, joint in JointSet(joints).free.items()}
        parts = load_assets(description, RobotAssets(), folder)
        bare = {
            uri: load_mesh(uri, folder, bare=True) for uri, mesh in parts.meshes.items() if mesh.glb
        }
        return cls(description, SegmentTree(description, joints), rest, parts, bare)

    def poses(self, positions: Mapping[str, float]) -> dict[str, Transform]:
        """Return the pose of each link in the root link's frame, for joint positions by name.

        Args:
            positions: Positions of joints by name; other joints are at rest, mimic joints follow.
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
    """Drawing of the robot in a planned or goal state, in addition to the real robot.

    Args:
        scene: The viser scene.
        path: Scene path of the robot's root link.
        model: Robot to draw.
        alpha: Opacity, from 0 to 1.
        color: Colour of all links; None for their own colours.
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
        # Shown with the first positions: browsers may draw the parts before they get these.
        self._root: Any = scene.add_frame(path, show_axes=False, visible=False)
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

    def set_positions(
        self, positions: Mapping[str, float], other_poses: Mapping[str, Transform] | None = None
    ) -> None:
        """Draw the robot with these joint positions; hide links posed as in ``other_poses``.

        Args:
            positions: Positions of joints by name; other joints are at rest.
            other_poses: Poses of the links of another drawn robot, in the root's frame. Links with
                the same pose are hidden, since browsers draw stripes where two surfaces coincide.
        """
        poses = self._model.poses(positions)
        for name, node in self._links.items():
            pose = poses.get(name)
            if pose is None:
                continue
            if pose != self._poses.get(name):
                x, y, z, w = pose.rotation
                node.position, node.wxyz = pose.translation, (w, x, y, z)
            other = other_poses.get(name) if other_poses else None
            apart = other is None or _are_apart(pose, other)
            if node.visible != apart:
                node.visible = apart
        self._poses = poses
        self.show(shown=True)

    @property
    def poses(self) -> Mapping[str, Transform]:
        """Poses of the links in the root link's frame, as drawn last."""
        return self._poses

    def show(self, *, shown: bool) -> None:
        """Show or hide this drawing of the robot."""
        if self._root.visible != shown:
            self._root.visible = shown

    def remove(self) -> None:
        """Remove this drawing of the robot from the scene."""
        self._root.remove()


def _are_apart(one: Transform, other: Transform) -> bool:
    """Return whether two poses differ visibly: by more than 1 mm or 2 mrad."""
    step = one.inverse() @ other
    return math.hypot(*step.translation) > _SEEN_M or abs(step.rotation[3]) < _SEEN_COSINE


# Any: messages, whose classes are created from definitions at run time.

# The status lists only the first faults.
_MOST_FAULTS = 3
_DESCRIPTION = "/robot_description"


class MoveItDisplay(Display):
    """Base of MoveIt's displays, which draw the robot of ``/robot_description`` once more.

    Attributes:
        default_topic: Topic if the ``.rviz`` file has none.
        model: Robot to draw; None until its description was received and loaded.
    """

    default_topic: ClassVar[str]

    def _prepare(self) -> None:
        self.values.given.setdefault("Class", f"moveit_rviz_plugin/{self.rviz_class}")
        said = read_property(Property(self.topic_key, self.default_topic), self.values.given)
        self.topic = self.topic or str(said) or self.default_topic
        self.model: OverlayModel | None = None
        self._end_description: Callable[[], None] | None = None
        self._turn = 0

    def set_topic(self, topic: str) -> None:
        """Set the topic, stored in the ``.rviz`` mapping as a plain text without QoS."""
        super().set_topic(topic)
        self.values.given[self.topic_key] = topic

    # --- overridden by displays ---------------------------------------------------------------

    def redraw(self) -> None:
        """Redraw everything; called after a new robot description or a changed property.

        Override.
        """

    def clear(self) -> None:
        """Remove everything from the scene, and drop the received state. Override."""

    # --- called by the viewer -----------------------------------------------------------------

    def started(self) -> None:
        """Subscribe to ``/robot_description``; called when the display starts."""
        self._end_description = self.stage.subscribe(
            _DESCRIPTION, "std_msgs/msg/String", self._receive_description, qos_profile_latched
        )

    def stopped(self) -> None:
        """Unsubscribe from the description, and remove everything from the scene."""
        if self._end_description is not None:
            self._end_description()
            self._end_description = None
        self._turn += 1
        self.model = None
        self.clear()

    def changed(self, name: str) -> None:  # noqa: ARG002 -- the same for every property
        """Redraw the received state after a property was set."""
        self.redraw()

    def time_jumped_back(self) -> None:
        """Do nothing when ROS time jumps back: states and paths are drawn without a stamp."""

    def _receive_description(self, message: Any) -> None:
        urdf, folder = message.data, self.stage.robot_folder
        self._turn += 1
        turn = self._turn
        self.stage.run_in_background(
            lambda: OverlayModel.from_urdf(urdf, folder), lambda done: self._set_model(turn, done)
        )

    def _set_model(self, turn: int, done: Any) -> None:
        if turn != self._turn or not self.is_drawn:
            return
        if isinstance(done, BaseException):
            self.set_status(ERROR, f"The description is not used: {done}")
            return
        self.model = done
        if done.parts.faults:
            self.set_status(WARN, "; ".join(done.parts.faults[:_MOST_FAULTS]))
        self.redraw()

    # --- for subclasses -----------------------------------------------------------------------

    def present_poses(self) -> dict[str, Transform]:
        """Return the poses of the robot's links by tf, in its root link's frame."""
        if self.model is None:
            return {}
        frames = self.stage.frames.by_name
        poses = {
            name: frame.pose
            for name in self.model.description.links
            if (frame := frames.get(name)) is not None and frame.pose is not None
        }
        if (root := poses.get(self.model.description.root)) is None:
            return {}
        to_root = root.inverse()
        return {name: to_root @ pose for name, pose in poses.items()}

    def add_overlay(
        self, name: str, alpha: float, color: Color | None = None
    ) -> RobotOverlay | None:
        """Add a drawing of the robot to the scene and return it; None without a description.

        Args:
            name: Last part of the drawing's scene path.
            alpha: Opacity, from 0 to 1.
            color: Colour of all links; None for their own colours.
        """
        if self.model is None:
            if self.status[0] == OK:
                self.set_status(WARN, f"No message received on {_DESCRIPTION} yet")
            return None
        above = self.stage.frames.node_path(self.model.description.root)
        return RobotOverlay(
            self.stage.scene, f"{above}{self.root}_{name}", self.model, alpha, color
        )
