"""World files: the objects around a robot in simulation.

A world is a file of its own, so that the robot's description is the same as on the real robot.
It is URDF or xacro, in which links on fixed joints are static, links on floating joints from
`world` move freely, and links on other joints move when pushed, like a door. Or it is SDF, as in
Gazebo, an MJCF scene, which MuJoCo reads, or this project's world YAML.
"""

from __future__ import annotations

import contextlib
import re
from dataclasses import dataclass, field, replace
from pathlib import Path

from lxml import etree

from teleopctl.errors import InvalidDescriptionError, NotFoundError, UnknownFormatError
from teleopctl.robot.description import RobotDescription
from teleopctl.robot.elements import XmlElement, parse, parse_file
from teleopctl.robot.model_file import model_kind
from teleopctl.robot.repair import repair_urdf
from teleopctl.robot.scene.scene import Scene
from teleopctl.robot.scene.yaml_world import read_yaml_world
from teleopctl.robot.sdf.includes import find_file, model_file
from teleopctl.robot.sdf.reading import SDF_ROOTS
from teleopctl.robot.sdf.sdf_file import read_sdf, read_sdf_text
from teleopctl.robot.xacro.expansion import read_xacro
from teleopctl.robot.xacro.source_lines import Places

_SOLIDS = ".//geometry/*"
_SIZES = ("size", "radius", "length")
_YAML = frozenset({".yaml", ".yml"})
# A line that every world YAML has and XML does not.
_OURS = re.compile(r"^\s*things\s*:", re.MULTILINE)
_XACRO = b"http://www.ros.org/wiki/xacro"


@dataclass(frozen=True)
class World:
    """World file that was read: an SDF or YAML scene, a URDF description, or MJCF, not parsed.

    Attributes:
        path: Path of the file.
        description: Description in a URDF or xacro file; None for other formats.
        text: Text of the world, if it was not read from a file; else empty.
        name: Name of the world in the file.
        scene: Scene in an SDF or YAML file; else None.
        places: Source file and line of each line of the description, if it was made by xacro.
    """

    path: Path
    description: RobotDescription | None
    text: str = ""
    name: str = ""
    scene: Scene | None = None
    places: Places = field(default_factory=dict)

    @property
    def origin(self) -> tuple[float, float, float] | None:
        """World origin on the earth: latitude and longitude (deg), height (m); None if unset."""
        return None if self.scene is None else self.scene.origin

    @property
    def moves(self) -> bool:
        """Whether the file is a single object that moves freely."""
        return self.description is not None and self.description.root != "world"


def find_world(uri: str, folder: Path) -> Path:
    """Return the file that Gazebo would find for a world's or model's name or URI.

    Args:
        uri: Path, or a URI of a kind that SDF files have.
        folder: Folder that relative paths start from, before those of Gazebo's environment
            variables.

    Raises:
        NotFoundError: The file is not found.
    """
    try:
        return model_file(find_file(uri, folder)).absolute()
    except NotFoundError as error:
        raise NotFoundError(f"World {uri} is not found: {error.message}") from error


def is_world(path: Path) -> bool:
    """Return whether a file is a world and not a robot: world YAML, or SDF with several models."""
    if path.suffix.lower() in _YAML:
        return True
    try:
        world = read_world(path) if model_kind(path) == "sdf" else None
    except InvalidDescriptionError:
        return False  # the reader of robots reports the fault
    return world is not None and world.scene is not None and not world.scene.is_model


def read_world(path: Path) -> World:
    """Read a world file (YAML, SDF, URDF, xacro or MJCF); return it as a `World`.

    Args:
        path: Path of the file: world YAML by its suffix; URDF, xacro, SDF or MJCF by its root
            element.

    Raises:
        InvalidDescriptionError: The file is missing, broken or of another kind, or has invalid
            sizes or poses, or a floating joint that does not start at ``world``. The message names
            the file and, unless it is xacro, the line.
    """
    path = path.absolute()
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InvalidDescriptionError(f"Cannot read {path}: {error.strerror}") from error
    if path.suffix.lower() in _YAML:
        return _staged(path, read_yaml_world(path, _decoded(path, content)))
    root = _parse(path, content)
    if root.tag in SDF_ROOTS:
        return _staged(path, read_sdf(path))
    if root.tag == "mujoco":
        return World(path, None, name=root.get("model") or "")
    if _XACRO in content:
        # Expansion changes the line numbers.
        read = read_xacro(path, places=True)
        world = _described(path, _checked(path, read.text, has_lines=False))
        return replace(world, places=read.places)
    return _described(path, _checked(path, _decoded(path, content), has_lines=True))


def read_world_text(text: str, where: str) -> World:
    """Read a world's text (YAML, SDF, URDF or MJCF); return it as a `World`.

    Args:
        text: URDF, SDF, MJCF or world YAML.
        where: Name of the text in error messages.

    Raises:
        InvalidDescriptionError: As for `read_world`.
    """
    path, content = Path(where), text.encode(errors="surrogatepass")
    if _OURS.search(text):
        return _staged(path, read_yaml_world(path, text), text)
    root = _parse(path, content)
    if root.tag in SDF_ROOTS:
        return _staged(path, read_sdf_text(text, path), text)
    if root.tag == "mujoco":
        return World(path, None, text, root.get("model") or "")
    if _XACRO in content:
        raise UnknownFormatError(f"{where}: xacro is not expanded here: pass the expanded file")
    return _described(path, _checked(path, text, has_lines=True), text)


def _staged(path: Path, scene: Scene, text: str = "") -> World:
    return World(path, None, text, scene.name, scene)


def _described(path: Path, description: RobotDescription, text: str = "") -> World:
    return World(path, description, text, description.name)


def _decoded(path: Path, content: bytes) -> str:
    try:
        return content.decode()
    except UnicodeDecodeError as error:
        raise InvalidDescriptionError(f"{path} is not text in UTF-8") from error


def _parse(path: Path, content: bytes) -> XmlElement:
    # MuJoCo accepts what XML forbids, such as two hyphens in a comment, and reports other faults.
    parser = etree.XMLParser(recover=True, resolve_entities=False, remove_comments=True)
    with contextlib.suppress(etree.XMLSyntaxError):
        scene: XmlElement | None = etree.fromstring(content, parser)
        if scene is not None and scene.tag == "mujoco":
            return scene
    root = parse_file(path, content)
    if root.tag not in ("robot", "mujoco", *SDF_ROOTS):
        raise UnknownFormatError(
            f"{path}:{root.sourceline}: <{root.tag}> is no world",
            hint="A world is URDF or xacro (<robot>), SDF (<sdf>) or MuJoCo's own (<mujoco>).",
        )
    return root


def _checked(path: Path, text: str, *, has_lines: bool) -> RobotDescription:
    try:
        description = RobotDescription.from_urdf(text)
    except InvalidDescriptionError as error:
        raise error.at(str(path)) from error
    robot = parse(text)
    repair_urdf(robot)
    for element in (*robot.findall("joint"), *robot.findall(_SOLIDS)):
        place = f"{path}:{element.sourceline}" if has_lines else str(path)
        if element.tag == "joint":
            _check_joint(element, place)
        else:
            _check_sizes(element, place)
    return description


def _check_sizes(element: XmlElement, place: str) -> None:
    """Raise if a size is not positive; that sizes are finite numbers is checked before."""
    for attribute in _SIZES:
        text = element.get(attribute) or ""
        if min(map(float, text.split()), default=1.0) <= 0.0:
            raise InvalidDescriptionError(f'{place}: {attribute}="{text}" is no size')


def _check_joint(joint: XmlElement, place: str) -> None:
    name, kind, parent = joint.get("name"), joint.get("type"), joint.find("parent")
    start = None if parent is None else parent.get("link")
    if kind == "floating" and start != "world":
        raise InvalidDescriptionError(
            f"{place}: joint '{name}' is floating but starts at link '{start}'",
            hint="A floating joint must start at a root link named 'world'.",
        )
