"""``RobotModelDisplay``: the links of a robot description, standing on their frames."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, ClassVar

from teleopctl.errors import TeleopctlError
from teleopctl.robot import Geometry, Material, Pose, RobotDescription, read_model
from teleopctl.viewer.displays.base import ERROR, OK, WARN, Display
from teleopctl.viewer.displays.properties import Property
from teleopctl.viewer.displays.robot_parts import Parts, load_parts
from teleopctl.viewer.scene.mesh_files import MeshFile
from teleopctl.viewer.scene.shapes import ShapeDrawing

# Any stands for messages and for viser's nodes.

# A collision shape is seen through, since it lies around the visual one.
_COLLISION_ALPHA = 0.5
# Of many faults the status names the first.
_TOLD_FAULTS = 3
_TICKS_PER_LOOK_AT_FRAMES = 10


class RobotModelDisplay(Display):
    """Display of the robot: visual and collision geometry of each link."""

    rviz_class = "RobotModel"
    message_type = "std_msgs/msg/String"
    topic_key = "Description Topic"
    latched = True
    properties: ClassVar[tuple[Property, ...]] = (
        Property("Description Source", "Topic", ("Topic", "File"), hint="Where the robot is from"),
        Property("Description File", "", hint="A URDF, xacro or MJCF file, for the source File"),
        Property("Visual Enabled", True, hint="Draw what the robot looks like"),
        Property("Collision Enabled", False, hint="Draw what the robot collides with"),
        Property("Alpha", 1.0, low=0.0, high=1.0, hint="1 is opaque"),
        Property("TF Prefix", "", hint="What stands before the links' names in tf"),
    )

    def _prepare(self) -> None:
        # ROS 1's files name the parameter, which ROS 2 has as a topic.
        said = self.values.given.get("Robot Description")
        if not self.topic and isinstance(said, str):
            self.topic = said
        self._description: RobotDescription | None = None
        self._parts = Parts()
        self._reported: set[str] = set()
        self._nodes: list[Any] = []
        self._frames: list[str] = []
        self._missing: list[str] = []
        self._turn = 0
        self._ticks = 0
        self._refused = ""

    @property
    def description(self) -> RobotDescription | None:
        """The description of the drawn robot."""
        return self._description

    @property
    def meshes(self) -> Mapping[str, MeshFile]:
        """The robot's meshes, by URI."""
        return self._parts.meshes

    def received(self, message: Any) -> None:
        """Read a robot description and its meshes in another thread, then draw them."""
        if self.values.text("Description Source") == "Topic":
            text = message.data
            self._take_text(lambda: text)
        else:
            self._tell()

    def changed(self, name: str) -> None:
        """Redraw; after a change of the source, read the description again."""
        self.stopped()
        self._draw_links()
        if name.startswith("Description"):
            self._read_file()
            self._hush()
            self._listen()

    def reload(self) -> None:
        """Read changed mesh files of the robot again."""
        if self._description is not None:
            text = self._description.urdf
            self._take_text(lambda: text)

    def _read_file(self) -> None:
        path = self.values.text("Description File").strip()
        if self.values.text("Description Source") == "File" and path:
            self._take_text(lambda: read_model(Path(path).expanduser()).text)

    def _take_text(self, read: Callable[[], str]) -> None:
        self._turn += 1
        turn, known = self._turn, self._parts
        folder = self.stage.robot_folder
        if self.values.text("Description Source") == "File":
            folder = Path(self.values.text("Description File")).expanduser().parent

        def task() -> tuple[RobotDescription, Parts]:
            description = RobotDescription.from_urdf(read())
            return description, load_parts(description, known, folder)

        if self._description is None:
            self.say(OK, "Reading the robot")
        self.stage.work(task, lambda result: self._loaded(turn, result))

    def _loaded(self, turn: int, result: Any) -> None:
        if turn != self._turn or not self.is_drawn:
            return
        if isinstance(result, TeleopctlError):
            self._refused = f"The description is not used: {result.message}"
            self._tell()
            return
        if isinstance(result, BaseException):
            raise result
        self._refused = ""
        description, parts = result
        same = self._description is not None and self._description.urdf == description.urdf
        if same and parts == self._parts:
            self._tell()
            return
        self._description, self._parts = description, parts
        for fault in parts.faults:
            if fault not in self._reported:
                self._reported.add(fault)
                self.stage.node.get_logger().warning(fault)
        self.stopped()
        self._draw_links()

    def started(self) -> None:
        """Draw the links."""
        self._draw_links()
        self._read_file()

    def _draw_links(self) -> None:
        description = self._description
        if description is None:
            return
        alpha = self.values.number("Alpha")
        prefix = self.values.text("TF Prefix").strip("/")
        shapes = ShapeDrawing(self.stage.scene, self._parts.meshes, self._parts.textures)
        self._frames = []
        for link in description.links.values():
            frame = f"{prefix}/{link.name}" if prefix else link.name
            its_alpha = alpha * self._alpha_of(link.name)
            if not (link.visuals or link.collisions) or its_alpha <= 0.0:
                continue
            self._frames.append(frame)
            above = f"{self.stage.frames.node_of(frame)}{self.root}"
            wanted: list[tuple[str, tuple[Geometry, Pose, Material | None], float]] = []
            if self.values.flag("Visual Enabled"):
                wanted += [
                    (f"visual{number}", (one.geometry, one.origin, one.material), its_alpha)
                    for number, one in enumerate(link.visuals)
                ]
            if self.values.flag("Collision Enabled"):
                wanted += [
                    (
                        f"collision{number}",
                        (one.geometry, one.origin, None),
                        its_alpha * _COLLISION_ALPHA,
                    )
                    for number, one in enumerate(link.collisions)
                ]
            for name, what, opacity in wanted:
                node = shapes.draw(f"{above}/{name}", *what, opacity)
                if node is not None:
                    self._nodes.append(node)
        self._missing = self._frames_without_pose()
        self._tell()

    def _alpha_of(self, link: str) -> float:
        """The opacity that a file gives a link; 0 for one that is not shown."""
        links = self.values.given.get("Links")
        given = links.get(link) if isinstance(links, dict) else None
        if not isinstance(given, dict):
            return 1.0
        if given.get("Value") is False:
            return 0.0
        alpha = given.get("Alpha", 1.0)
        is_number = isinstance(alpha, int | float) and 0.0 <= alpha <= 1.0
        return float(alpha) if is_number else 1.0

    def tick(self) -> None:
        """Set the status by which links have no transform."""
        self._ticks += 1
        if self._ticks % _TICKS_PER_LOOK_AT_FRAMES or self._description is None:
            return
        missing = self._frames_without_pose()
        if missing != self._missing:
            self._missing = missing
            self._tell()

    def _frames_without_pose(self) -> list[str]:
        frames = self.stage.frames
        return [
            name
            for name in self._frames
            if (frame := frames.by_name.get(name)) is None
            or (frame.pose is None and name != frames.fixed)
        ]

    def _tell(self) -> None:
        """Say how it fares."""
        sentences = list(self._parts.faults)
        if self._missing:
            sentences.insert(
                0, f"No transform from [{self._missing[0]}] to [{self.stage.frames.fixed}]"
            )
            if len(self._missing) > 1:
                sentences[0] += f", and from {len(self._missing) - 1} more links"
        if self._refused:
            sentences.insert(0, self._refused)
        more = len(sentences) - _TOLD_FAULTS
        text = "; ".join(sentences[:_TOLD_FAULTS]) + (f"; and {more} more" if more > 0 else "")
        self.say(ERROR if self._refused else WARN if text else OK, text)

    def stopped(self) -> None:
        """Remove the links from the scene."""
        for node in self._nodes:
            node.remove()
        self._nodes.clear()

    def time_jumped_back(self) -> None:
        """Do nothing: a robot description has no time."""
