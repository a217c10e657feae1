"""``RobotModel``: the links of a robot description, standing on their frames."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from teleopctl.errors import TeleopctlError
from teleopctl.robot import Geometry, Material, Pose, RobotDescription
from teleopctl.viewer.displays.base import ERROR, OK, WARN, Display
from teleopctl.viewer.displays.properties import Property
from teleopctl.viewer.scene.mesh_files import MeshFile, load_mesh
from teleopctl.viewer.scene.shapes import draw_shape, mesh_uris

# A collision shape is seen through, since it lies around the visual one.
_COLLISION_ALPHA = 0.5


class RobotModel(Display):
    """The robot: visual and collision geometry, each link a child of its frame's node."""

    rviz_class = "RobotModel"
    message_type = "std_msgs/msg/String"
    topic_key = "Description Topic"
    latched = True
    properties: ClassVar[tuple[Property, ...]] = (
        Property("Visual Enabled", True, hint="Draw what the robot looks like"),
        Property("Collision Enabled", False, hint="Draw what the robot collides with"),
        Property("Alpha", 1.0, low=0.0, high=1.0, hint="1 is opaque"),
        Property("TF Prefix", "", hint="What stands before the links' names in tf"),
    )

    # Any, here and below: the base class checks its own; messages are of its topic's type.
    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._description: RobotDescription | None = None
        self._meshes: dict[str, MeshFile] = {}
        self._faults: list[str] = []
        self._reported: set[str] = set()
        self._nodes: list[Any] = []
        self._turn = 0

    @property
    def description(self) -> RobotDescription | None:
        """The robot that is drawn."""
        return self._description

    @property
    def meshes(self) -> Mapping[str, MeshFile]:
        """The files of its meshes, by URI."""
        return self._meshes

    def received(self, message: Any) -> None:
        """Take a description and read its meshes, while the old one stays in the picture."""
        try:
            description = RobotDescription.from_urdf(message.data)
        except TeleopctlError as error:
            self.say(ERROR, f"The description is not used: {error.message}")
            return
        uris = mesh_uris(_shapes(description))
        self._turn += 1
        turn = self._turn
        self.say(OK, f"Reading {len(uris)} meshes" if uris else "")
        self.stage.work(lambda: _load(uris), lambda loaded: self._loaded(turn, description, loaded))

    def _loaded(self, turn: int, description: RobotDescription, loaded: Any) -> None:
        if turn != self._turn or not self.is_drawn:
            return
        if isinstance(loaded, BaseException):
            raise loaded
        self._description = description
        self._meshes, self._faults = loaded
        for fault in self._faults:
            if fault not in self._reported:
                self._reported.add(fault)
                self.stage.node.get_logger().warning(fault)
        self.stopped()
        self.started()

    def started(self) -> None:
        """Draw the links."""
        description = self._description
        if description is None:
            return
        if self._faults:
            self.say(WARN, "; ".join(self._faults))
        else:
            self.say(OK)
        alpha = self.values.number("Alpha")
        prefix = self.values.text("TF Prefix").strip("/")
        for link in description.links.values():
            frame = f"{prefix}/{link.name}" if prefix else link.name
            if not link.visuals and not link.collisions:
                continue
            above = f"{self.stage.frames.node_of(frame)}{self.root}"
            if self.values.flag("Visual Enabled"):
                for number, visual in enumerate(link.visuals):
                    shape = (visual.geometry, visual.origin, visual.material)
                    self._draw(f"{above}/visual{number}", shape, alpha)
            if self.values.flag("Collision Enabled"):
                for number, collision in enumerate(link.collisions):
                    around = (collision.geometry, collision.origin, None)
                    self._draw(f"{above}/collision{number}", around, alpha * _COLLISION_ALPHA)

    def _draw(self, path: str, what: tuple[Geometry, Pose, Material | None], alpha: float) -> None:
        node = draw_shape(self.stage.scene, path, *what, self._meshes, alpha)
        if node is not None:
            self._nodes.append(node)

    def stopped(self) -> None:
        """Take the links out of the picture."""
        for node in self._nodes:
            node.remove()
        self._nodes.clear()

    def time_jumped_back(self) -> None:
        """A robot is of no time."""


def _shapes(description: RobotDescription) -> list[Geometry]:
    links = description.links.values()
    return [visual.geometry for link in links for visual in link.visuals] + [
        collision.geometry for link in links for collision in link.collisions
    ]


def _load(uris: list[str]) -> tuple[dict[str, MeshFile], list[str]]:
    meshes: dict[str, MeshFile] = {}
    faults: list[str] = []
    for uri in uris:
        try:
            meshes[uri] = load_mesh(uri)
        except TeleopctlError as error:
            faults.append(error.message)
    return meshes, faults
