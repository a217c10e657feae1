"""SDF files: Gazebo's worlds and models, read as scenes."""

from __future__ import annotations

import math
from collections.abc import Container
from dataclasses import replace
from pathlib import Path
from typing import Any

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot.scene.scene import (
    LightKind,
    Scene,
    SceneBody,
    SceneLight,
    SceneModel,
    ScenePose,
    SceneShape,
    Vector3,
)
from teleopctl.robot.sdf.model import SdfReader
from teleopctl.robot.sdf.reading import MODEL, SdfFile, SdfFrames, parse_sdf, relative_to
from teleopctl.robot.tags import sdf as tags
from teleopctl.robot.tags.table import local_name
from teleopctl.tf import Transform

_LIGHTS: dict[str, LightKind] = {"directional": "directional", "point": "point", "spot": "spot"}
# Children of <spherical_coordinates>: numbers that are read (None), and the only supported value.
_ON_EARTH: dict[str, str | None] = {
    "latitude_deg": None,
    "longitude_deg": None,
    "elevation": None,
    "surface_model": "EARTH_WGS84",
    "world_frame_orientation": "ENU",
    "heading_deg": "0",
}
# Gazebo systems whose function the simulator always has.
_SYSTEMS = (
    *("physics", "user-commands", "scene-broadcaster", "sensors", "imu", "contact", "navsat"),
    *("magnetometer", "altimeter", "forcetorque", "air-pressure", "logical", "apply-link-wrench"),
    *("particle", "libgazebo_ros_state", "libgazebo_ros_init", "libgazebo_ros_factory"),
)


def read_sdf(path: Path) -> Scene:
    """Read an SDF world or model file; return it as a `Scene`.

    Raises:
        InvalidDescriptionError: The file cannot be read, is no SDF or is invalid; the message names
            file and line.
    """
    reading = SdfReader()
    root, file = reading.parse_file(path.absolute())
    return _scene(reading, root, file)


def read_sdf_text(text: str, path: Path) -> Scene:
    """Read SDF text of a world or model; return it as a `Scene`.

    Args:
        text: SDF text.
        path: Path of the text in error messages; relative files start from its folder.

    Raises:
        InvalidDescriptionError: As for `read_sdf`.
    """
    reading = SdfReader()
    root, file = parse_sdf(path, text.encode(errors="surrogatepass"), reading.remarks)
    return _scene(reading, root, file)


# Any, here and below: lxml elements, whose class has no types.
def _scene(reading: SdfReader, root: Any, file: SdfFile) -> Scene:
    world = root.find("world")
    if world is None:
        file.check_tags(root, tags.ROOT)
        models: list[SceneModel] = []
        for element in root.findall("model"):
            model = reading.model(file, element)
            taken = {other.name for other in models}
            models.append(replace(model, name=_free_name(model.name or "model", taken)))
        if not models:
            raise InvalidDescriptionError(
                f"{file.path}:{root.sourceline}: there is neither a world nor a model in it"
            )
        lights = _lights(file, root, SdfFrames(file))
        return Scene(
            models[0].name,
            tuple(models),
            tuple(lights),
            None,
            reading.remarks.sentences(),
            tuple(reading.files),
            is_model=len(models) == 1,
        )
    file.check_tags(root, tags.ROOT)
    for other in root.findall("world")[1:]:
        file.leave_out(other, "is left out: of several worlds the first is used")
    file.check_tags(world, tags.WORLD)
    for joint in world.findall("joint"):
        file.leave_out(joint, "is left out: joints are within models")
    for plugin in world.findall("plugin"):
        filename = plugin.get("filename") or ""
        if not any(system in filename for system in _SYSTEMS):
            file.leave_out(plugin, f"({filename}) is left out")
            continue
        for setting in plugin:
            file.remarks.add_own(file.path, setting.sourceline or 0, local_name(setting.tag))
    frames, suns = SdfFrames(file), list[SceneLight]()
    models = _models(reading, file, world, suns, frames)
    lights = _lights(file, world, frames)
    poses = [
        ScenePose(name, frames.pose_of(name, element))
        for element in world.findall("frame")
        if (name := element.get("name") or "")
    ]
    # Until SDF 1.5 gravity was a child of <physics>.
    falls = next(filter(len, map(world.findall, ("gravity", "physics/gravity"))), ())
    field = world.find("magnetic_field")
    origin = _origin(file, world.find("spherical_coordinates"))
    return Scene(
        world.get("name") or "",
        tuple(_with_states(file, world, models)),
        (*lights, *suns),
        _vector(file, falls[0]) if falls else None,
        reading.remarks.sentences(),
        tuple(reading.files),
        origin=origin,
        poses=tuple(poses),
        magnetic_field=None if field is None else _vector(file, field),
    )


def _origin(file: SdfFile, element: Any | None) -> Vector3 | None:
    """Return latitude and longitude (deg) and height (m) of the world's origin; None if unset."""
    if element is None:
        return None
    for tag, usual in _ON_EARTH.items():
        said = element.find(tag)
        text = "" if said is None else (said.text or "").strip()
        if usual is not None and text and text != usual and not _is_zero(text):
            file.leave_out(said, f"is taken for {usual}")
    found = [element.find(tag) for tag in ("latitude_deg", "longitude_deg", "elevation")]
    north, east, up = (0.0 if one is None else file.numbers(one, 1)[0] for one in found)
    return north, east, up


def _is_zero(text: str) -> bool:
    try:
        return float(text) == 0.0
    except ValueError:
        return False


def _models(
    reading: SdfReader, file: SdfFile, world: Any, suns: list[SceneLight], frames: SdfFrames
) -> list[SceneModel]:
    """Return the models of a world, with their poses in the world and unique names.

    Args:
        reading: Reader of the models.
        file: SDF file of the world.
        world: ``<world>`` element.
        suns: List that the light of an included sun is appended to.
        frames: Frames that those of the world and its models are added to.
    """
    for element in world.findall("frame"):
        frames.add(element.get("name") or "", element, element.get("attached_to") or MODEL)
    found: dict[str, tuple[SceneModel, Any]] = {}
    for element in world:
        model = None
        if element.tag == "model":
            model = reading.model(file, element)
        elif element.tag == "include" and _last_word(element) == "sun":
            suns.append(SceneLight("directional", Transform((0.0, 0.0, 10.0)), (-0.5, 0.1, -0.9)))
        elif element.tag == "include" and _last_word(element) == "ground plane":
            model = _ground(file, element)
        elif element.tag == "include":
            model = reading.include(file, element, 0)
        if model is not None:
            model = replace(model, name=_free_name(model.name or "model", found))
            found[model.name] = model, element
            frames.add_model(model, element, f"{model.name}::")
    return [replace(model, pose=frames.pose_of(model.name, e)) for model, e in found.values()]


def _free_name(wanted: str, taken: Container[str]) -> str:
    name, number = wanted, 0
    while name in taken:
        number += 1
        name = f"{wanted}_{number}"
    return name


def _last_word(element: Any) -> str:
    """Return the last part of an ``<include>``'s URI, for ground plane and sun, built in here."""
    uri = (element.findtext("uri") or "").strip().rstrip("/")
    return str(uri.rpartition("/")[2].replace("_", " ").replace("%20", " ").lower())


def _ground(file: SdfFile, element: Any) -> SceneModel:
    plane = SceneShape("plane", (0.0, 0.0, 0.0))
    seen = SceneShape("plane", (0.0, 0.0, 0.0), touches=False, rgba=(0.8, 0.8, 0.8, 1.0))
    body = SceneBody("link", Transform(), (plane, seen))
    name = (element.findtext("name") or "").strip() or "ground_plane"
    return SceneModel(name, file.pose(element.find("pose")), {"link": body}, static=True)


def _with_states(file: SdfFile, world: Any, models: list[SceneModel]) -> list[SceneModel]:
    """Return the models at the poses of a saved world's ``<state>``."""
    places = {
        element.get("name"): file.pose(element.find("pose"))
        for element in world.iterfind("state/model")
        if element.find("pose") is not None
    }
    moving = {model.name for model in models if len(model.bodies) > 1 and not model.static}
    for element in world.iterfind("state/model"):
        if element.get("name") in moving:
            file.leave_out(
                element, "of the saved state is where its parts are at their initial poses"
            )
    return [replace(model, pose=places.get(model.name, model.pose)) for model in models]


def _lights(file: SdfFile, holder: Any, frames: SdfFrames) -> list[SceneLight]:
    found = []
    for element in holder.findall("light"):
        file.check_tags(element, tags.LIGHT)
        if (kind := element.get("type") or "point") not in _LIGHTS:
            file.leave_out(element, f"of the type {kind} is treated as a point")
        if file.flag(element, "light_on", default=True):
            found.append(_light(file, element, frames))
    return found


def _light(file: SdfFile, element: Any, frames: SdfFrames) -> SceneLight:
    pose, fades = element.find("pose"), element.find("attenuation")
    constant, linear, quadratic = (
        max(0.0, file.number(element, f"attenuation/{part}", usual))
        for part, usual in (("constant", 1.0), ("linear", 1.0), ("quadratic", 0.0))
    )
    return SceneLight(
        _LIGHTS.get(element.get("type") or "", "point"),
        frames.pose_of(relative_to(pose), element) @ file.pose(pose),
        file.vector(element, "direction", (0.0, 0.0, -1.0)),
        _light_colour(file, element, "diffuse", "1 1 1 1"),
        min(max(file.number(element, "spot/outer_angle", 1.6) / 2.0, 0.0), math.pi / 2.0),
        file.flag(element, "cast_shadows"),
        _light_colour(file, element, "specular", "0.1 0.1 0.1 1"),
        (1.0, 0.0, 0.0)
        if fades is None or constant + linear + quadratic == 0.0
        else (constant, linear, quadratic),
    )


def _light_colour(file: SdfFile, element: Any, tag: str, usual: str) -> Vector3:
    """Return the red, green and blue of a light, 0 to 1."""
    parts = (element.findtext(tag) or usual).split()
    try:
        red, green, blue = (min(max(float(part), 0.0), 1.0) for part in parts[:3])
    except ValueError as error:
        raise InvalidDescriptionError(
            f"{file.place(element)}: the <{tag}> of a light is '{' '.join(parts)}'"
        ) from error
    return red, green, blue


def _vector(file: SdfFile, element: Any) -> Vector3:
    x, y, z = file.numbers(element, 3)
    return x, y, z
