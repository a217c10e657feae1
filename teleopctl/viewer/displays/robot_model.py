"""RViz's ``RobotModel``: the links of a robot description, drawn below their tf frames."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

from teleopctl.errors import TeleopctlError
from teleopctl.robot import Geometry, Material, Mesh, Pose, RobotDescription, read_model
from teleopctl.viewer.displays.base import ERROR, OK, WARN, Display
from teleopctl.viewer.displays.properties import Property
from teleopctl.viewer.scene.assets import (
    MeshFile,
    as_glb,
    file_stamp,
    load_mesh,
    load_texture,
)
from teleopctl.viewer.scene.gltf import Texture
from teleopctl.viewer.scene.shapes import ShapeDrawing, is_undrawable, mesh_uris

# A mesh with at least this many uses is sent as glTF: viser compresses equal glTF files to one.
_MANY_USES = 4


@dataclass(frozen=True, slots=True)
class RobotAssets:
    """Loaded meshes and textures of a robot description, and faults found while loading.

    Attributes:
        meshes: Meshes by URI.
        textures: The URDF's textures by URI.
        faults: Sentences about parts that cannot be drawn.
    """

    meshes: dict[str, MeshFile] = field(default_factory=dict)
    textures: dict[str, Texture] = field(default_factory=dict)
    faults: tuple[str, ...] = ()

    def __eq__(self, other: object) -> bool:
        # `==` of arrays returns no bool; the mesh of an unchanged file is the same object.
        return (
            isinstance(other, RobotAssets)
            and self.faults == other.faults
            and self.textures == other.textures
            and self.meshes.keys() == other.meshes.keys()
            and all(self.meshes[uri] is other.meshes[uri] for uri in self.meshes)
        )

    __hash__ = None  # type: ignore[assignment]


def load_assets(
    description: RobotDescription, loaded: RobotAssets, folder: Path | None = None
) -> RobotAssets:
    """Load a robot's meshes and textures; reuse those in ``loaded`` whose files are unchanged.

    Args:
        description: Description of the robot.
        loaded: Assets that were loaded before.
        folder: Folder of the description's file, for relative paths.
    """
    meshes: dict[str, MeshFile] = {}
    textures: dict[str, Texture] = {}
    faults = list(description.repairs)
    shapes = shapes_of(description)
    uses = Counter(shape.uri for shape in shapes if isinstance(shape, Mesh))
    for uri in mesh_uris(shapes):
        old = loaded.meshes.get(uri)
        if old is not None and _is_unchanged(old):
            meshes[uri] = old
        else:
            try:
                meshes[uri] = load_mesh(uri, folder)
            except TeleopctlError as error:
                faults.append(error.message)
                continue
        if uses[uri] >= _MANY_USES:
            meshes[uri] = as_glb(meshes[uri])
        faults += meshes[uri].faults
    for uri in _texture_uris(description):
        before = loaded.textures.get(uri)
        if before is not None and _is_unchanged(before):
            textures[uri] = before
            continue
        try:
            textures[uri] = load_texture(uri, folder)
        except TeleopctlError as error:
            faults.append(error.message)
    if strange := _links_with_undrawable_shapes(description):
        more = f" and {len(strange) - 1} more links" if len(strange) > 1 else ""
        faults.append(
            f"Shapes of link '{strange[0]}'{more} are not drawn: "
            "their sizes must be positive, finite numbers"
        )
    return RobotAssets(meshes, textures, tuple(dict.fromkeys(faults)))


def _is_unchanged(file: MeshFile | Texture) -> bool:
    try:
        return file.path is not None and file_stamp(file.path) == file.stamp
    except OSError:
        return False


def shapes_of(description: RobotDescription) -> list[Geometry]:
    """Return the geometries of all links of a robot, visual before collision ones."""
    links = description.links.values()
    return [visual.geometry for link in links for visual in link.visuals] + [
        collision.geometry for link in links for collision in link.collisions
    ]


def _links_with_undrawable_shapes(description: RobotDescription) -> list[str]:
    return [
        link.name
        for link in description.links.values()
        if any(is_undrawable(one.geometry, one.origin) for one in link.visuals)
        or any(is_undrawable(one.geometry, one.origin) for one in link.collisions)
    ]


def _texture_uris(description: RobotDescription) -> list[str]:
    found: dict[str, None] = {}
    for link in description.links.values():
        for visual in link.visuals:
            if visual.material is not None and visual.material.texture is not None:
                found[visual.material.texture] = None
    return list(found)


def _gazebo_materials(description: RobotDescription) -> dict[str, Material]:
    """Return the colours of links in ``<gazebo>``, which the simulation draws them in."""
    try:
        links = description.gazebo.links
    except TeleopctlError:
        # The simulation refuses the description; the page shows what can be shown.
        return {}
    return {
        name: Material(rgba=physics.rgba)
        for name, physics in links.items()
        if physics.rgba is not None
    }


# Any: messages and viser's nodes.

# Collision shapes are transparent, since they enclose the visual ones.
_COLLISION_ALPHA = 0.5
# The status lists only the first faults.
_MOST_FAULTS = 3
_TICKS_PER_FRAME_CHECK = 10


class RobotModelDisplay(Display):
    """RViz's ``RobotModel`` display: visual and collision geometry of links, below tf frames.

    Attributes:
        on_pick: Function called with viser's browser, the display and the name of a clicked link.
    """

    rviz_class = "RobotModel"
    message_type = "std_msgs/msg/String"
    topic_key = "Description Topic"
    latched = True
    properties: ClassVar[tuple[Property, ...]] = (
        Property(
            "Description Source",
            "Topic",
            ("Topic", "File"),
            hint="Whether the robot comes from the topic or from a file",
        ),
        Property("Description File", "", hint="A URDF, xacro or MJCF file, for the source File"),
        Property("Visual Enabled", True, hint="Draw the visual geometry"),
        Property("Collision Enabled", False, hint="Draw the collision geometry"),
        Property("Alpha", 1.0, low=0.0, high=1.0, hint="1 is opaque"),
        Property("TF Prefix", "", hint="Prefix of the links' frames in tf"),
    )

    def _prepare(self) -> None:
        # Files of ROS 1 contain the parameter's name, which is the topic's name in ROS 2.
        said = self.values.given.get("Robot Description")
        if not self.topic and isinstance(said, str):
            self.topic = said
        self._description: RobotDescription | None = None
        self._parts = RobotAssets()
        self._reported: set[str] = set()
        self._nodes: list[Any] = []
        self._links_of_nodes: list[str] = []
        self._is_pickable = True
        self._frames: list[str] = []
        self._missing: list[str] = []
        self._turn = 0
        self._ticks = 0
        self._refused = ""
        self.on_pick: Callable[[Any, RobotModelDisplay, str], object] | None = None

    @property
    def description(self) -> RobotDescription | None:
        """Robot description that is drawn; None before one is loaded."""
        return self._description

    @property
    def meshes(self) -> Mapping[str, MeshFile]:
        """Loaded meshes of the robot, by URI."""
        return self._parts.meshes

    def received(self, message: Any) -> None:
        """Load a received description in another thread and draw it, if the source is the topic."""
        if self.values.text("Description Source") == "Topic":
            text = message.data
            self._load(lambda: text)
        else:
            self._update_status()

    def changed(self, name: str) -> None:
        """Redraw; after a change of a ``Description …`` property load the robot again."""
        self.stopped()
        self._draw_links()
        if name.startswith("Description"):
            self._read_file()
            self._unsubscribe()
            self._subscribe()

    def reload(self) -> None:
        """Load changed meshes and textures again in another thread; redraw if any changed."""
        if self._description is not None:
            text = self._description.urdf
            self._load(lambda: text)

    def _read_file(self) -> None:
        path = self.values.text("Description File").strip()
        if self.values.text("Description Source") == "File" and path:
            self._load(lambda: read_model(Path(path).expanduser()).text)

    def _load(self, read: Callable[[], str]) -> None:
        self._turn += 1
        turn, known = self._turn, self._parts
        folder = self.stage.robot_folder
        if self.values.text("Description Source") == "File":
            folder = Path(self.values.text("Description File")).expanduser().parent

        def task() -> tuple[RobotDescription, RobotAssets]:
            description = RobotDescription.from_urdf(read())
            return description, load_assets(description, known, folder)

        if self._description is None:
            self.set_status(OK, "Loading the robot")
        self.stage.run_in_background(task, lambda result: self._loaded(turn, result))

    def _loaded(self, turn: int, result: Any) -> None:
        if turn != self._turn or not self.is_drawn:
            return
        if isinstance(result, TeleopctlError):
            self._refused = f"The description is not used: {result.message}"
            self._update_status()
            return
        if isinstance(result, BaseException):
            raise result
        self._refused = ""
        description, parts = result
        same = self._description is not None and self._description.urdf == description.urdf
        if same and parts == self._parts:
            self._update_status()
            return
        self._description, self._parts = description, parts
        for fault in parts.faults:
            if fault not in self._reported:
                self._reported.add(fault)
                self.stage.node.get_logger().warning(fault)
        self.stopped()
        self._draw_links()

    def started(self) -> None:
        """Draw the links of a known description; start loading the file if it is the source."""
        self._draw_links()
        self._read_file()

    def _draw_links(self) -> None:
        description = self._description
        if description is None:
            return
        alpha = self.values.number("Alpha")
        shapes = ShapeDrawing(self.stage.scene, self._parts.meshes, self._parts.textures)
        material_of = partial(self._material_of, _gazebo_materials(description))
        self._frames = []
        for link in description.links.values():
            frame = self.frame_of(link.name)
            its_alpha = alpha * self._alpha_of(link.name)
            if not (link.visuals or link.collisions) or its_alpha <= 0.0:
                continue
            self._frames.append(frame)
            above = f"{self.stage.frames.node_path(frame)}{self.root}"
            wanted: list[tuple[str, tuple[Geometry, Pose, Material | None], float]] = []
            if self.values.flag("Visual Enabled"):
                wanted += [
                    (
                        f"visual{number}",
                        (
                            one.geometry,
                            one.origin,
                            material_of(link.name, one.geometry, one.material),
                        ),
                        its_alpha,
                    )
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
                node: Any = shapes.draw(f"{above}/{name}", *what, opacity)
                if node is not None:
                    self._nodes.append(node)
                    self._links_of_nodes.append(link.name)
        if self._is_pickable:
            self._listen()
        self._missing = self._frames_without_pose()
        self._update_status()

    @staticmethod
    def _material_of(
        painted: Mapping[str, Material], link: str, shape: Geometry, own: Material | None
    ) -> Material | None:
        """Return a visual's material; without a colour, that of the link in ``<gazebo>``."""
        if own is not None and (own.rgba is not None or own.texture is not None):
            return own
        if isinstance(shape, Mesh) and not shape.uri.lower().endswith(".stl"):
            # The file may have colours of its own.
            return own
        return painted.get(link, own)

    @property
    def is_pickable(self) -> bool:
        """Whether links can be clicked; set it to False for handles that lie in front of them."""
        return self._is_pickable

    @is_pickable.setter
    def is_pickable(self, pickable: bool) -> None:
        if pickable == self._is_pickable:
            return
        self._is_pickable = pickable
        if pickable:
            self._listen()
        else:
            for node in self._nodes:
                node.remove_click_callback()

    def _listen(self) -> None:
        for node, link in zip(self._nodes, self._links_of_nodes, strict=True):
            node.on_click(self.stage.on_node_thread(partial(self._clicked, link)))

    # Any: viser's event.
    def _clicked(self, link: str, event: Any) -> None:
        if self.on_pick is not None:
            self.on_pick(event.client, self, link)

    def frame_of(self, link: str) -> str:
        """Return the name of a link's tf frame."""
        prefix = self.values.text("TF Prefix").strip("/")
        return f"{prefix}/{link}" if prefix else link

    def hidden_links(self) -> list[str]:
        """Return the links that are not drawn because the ``.rviz`` document hides them."""
        links = self._description.links if self._description is not None else {}
        return [link for link in links if self._alpha_of(link) <= 0.0]

    def show_link(self, link: str, *, shown: bool) -> None:
        """Show or hide a link, also in the ``.rviz`` document.

        Args:
            link: Name of the link.
            shown: Whether the link is drawn.
        """
        links = self.values.given.get("Links")
        if not isinstance(links, dict):
            links = self.values.given["Links"] = {}
        given = links.get(link)
        links[link] = {**(given if isinstance(given, dict) else {}), "Value": shown}
        self.stopped()
        self._draw_links()

    def _alpha_of(self, link: str) -> float:
        """Return a link's opacity in the ``.rviz`` file; 0 if hidden, 1 if not in the file."""
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
        """Update the status if the list of links without transform has changed."""
        self._ticks += 1
        if self._ticks % _TICKS_PER_FRAME_CHECK or self._description is None:
            return
        missing = self._frames_without_pose()
        if missing != self._missing:
            self._missing = missing
            self._update_status()

    def _frames_without_pose(self) -> list[str]:
        frames = self.stage.frames
        return [
            name
            for name in self._frames
            if (frame := frames.by_name.get(name)) is None
            or (frame.pose is None and name != frames.fixed)
        ]

    def _update_status(self) -> None:
        """Set the status: missing transforms, faults of files, a rejected description."""
        sentences = list(self._parts.faults)
        if self._missing:
            sentences.insert(
                0, f"No transform from [{self._missing[0]}] to [{self.stage.frames.fixed}]"
            )
            if len(self._missing) > 1:
                sentences[0] += f", and from {len(self._missing) - 1} more links"
        if self._refused:
            sentences.insert(0, self._refused)
        more = len(sentences) - _MOST_FAULTS
        text = "; ".join(sentences[:_MOST_FAULTS]) + (f"; and {more} more" if more > 0 else "")
        self.set_status(ERROR if self._refused else WARN if text else OK, text)

    def stopped(self) -> None:
        """Remove all links from the scene; called when the display stops."""
        for node in self._nodes:
            node.remove()
        self._nodes.clear()
        self._links_of_nodes.clear()

    def time_jumped_back(self) -> None:
        """Do nothing when ROS time jumps back: a robot description has no stamp."""
