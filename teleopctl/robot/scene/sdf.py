"""SDF files: worlds and models of Gazebo's, as scenes."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot.scene.scene import (
    LightKind,
    Scene,
    SceneBody,
    SceneLight,
    SceneModel,
    SceneShape,
    Vector3,
)
from teleopctl.robot.scene.sdf_frames import Frames
from teleopctl.robot.scene.sdf_model import Reading
from teleopctl.robot.scene.sdf_reading import SdfFile, parse_sdf
from teleopctl.tf import Transform

_LIGHTS: dict[str, LightKind] = {"directional": "directional", "point": "point", "spot": "spot"}
# What changes nothing here: Gazebo's window, its solver (the launch decides the step), its weather.
_WORLD = frozenset(
    {"model", "include", "light", "gravity", "state", "frame", "physics", "gui", "scene"}
    | {"magnetic_field", "atmosphere", "audio", "wind", "spherical_coordinates", "plugin", "joint"}
)
# What <spherical_coordinates> may say: numbers that are read, and what there is but one of here.
_ON_EARTH: dict[str, str | None] = {
    "latitude_deg": None,
    "longitude_deg": None,
    "elevation": None,
    "surface_model": "EARTH_WGS84",
    "world_frame_orientation": "ENU",
    "heading_deg": "0",
}
# Systems of Gazebo's that are here by themselves.
_SYSTEMS = (
    *("physics", "user-commands", "scene-broadcaster", "sensors", "imu", "contact", "navsat"),
    *("magnetometer", "altimeter", "forcetorque", "air-pressure", "logical", "apply-link-wrench"),
    *("particle", "libgazebo_ros_state", "libgazebo_ros_init", "libgazebo_ros_factory"),
)


def read_sdf(path: Path) -> Scene:
    """Read an SDF file.

    Raises:
        InvalidDescriptionError: It cannot be read, is no SDF, or means nothing somewhere; the
            message names file and line.
    """
    reading = Reading()
    root, file = reading.open(path.absolute())
    return _scene(reading, root, file)


def read_sdf_text(text: str, path: Path) -> Scene:
    """Read what could stand in an SDF file.

    Args:
        text: SDF.
        path: What errors call it; relative files start at its folder.

    Raises:
        InvalidDescriptionError: As of `read_sdf`.
    """
    reading = Reading()
    root, file = parse_sdf(path, text.encode(errors="surrogatepass"), reading.remarks)
    return _scene(reading, root, file)


# Any, here and below: elements of lxml, whose class has no types.
def _scene(reading: Reading, root: Any, file: SdfFile) -> Scene:
    world = root.find("world")
    if world is None:
        models = [reading.model(file, element) for element in root.findall("model")]
        if not models:
            raise InvalidDescriptionError(
                f"{file.path}:{root.sourceline}: there is neither a world nor a model in it"
            )
        lights = [_light(file, element) for element in root.findall("light")]
        return Scene(
            models[0].name,
            tuple(models),
            tuple(lights),
            None,
            reading.remarks.sentences(),
            tuple(reading.files),
            is_model=len(models) == 1,
        )
    file.leave_rest(world, _WORLD)
    for joint in world.findall("joint"):
        file.leave_out(joint, "is left out: joints are within models")
    for plugin in world.findall("plugin"):
        filename = plugin.get("filename") or ""
        if not any(system in filename for system in _SYSTEMS):
            file.leave_out(plugin, f"({filename}) is left out")
    lights = [_light(file, element) for element in world.findall("light")]
    models = _models(reading, file, world, lights)
    gravity = world.find("gravity")
    origin = _origin(file, world.find("spherical_coordinates"))
    return Scene(
        world.get("name") or "",
        tuple(_with_states(file, world, models)),
        tuple(lights),
        None if gravity is None else _vector(file, gravity),
        reading.remarks.sentences(),
        tuple(reading.files),
        origin=origin,
    )


def _origin(file: SdfFile, element: Any | None) -> Vector3 | None:
    """Where the world is on the earth; None where that is not said."""
    if element is None:
        return None
    file.leave_rest(element, _ON_EARTH)
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
    reading: Reading, file: SdfFile, world: Any, lights: list[SceneLight]
) -> list[SceneModel]:
    """The models of a world, each in its place and with a name of its own."""
    frames = Frames(file)
    for element in (*world.findall("frame"), *world.findall("model")):
        frames.put(element.get("name") or "", element)
    found: list[SceneModel] = []
    for element in world:
        model = None
        if element.tag == "model":
            model = reading.model(file, element)
            pose = element.find("pose")
        elif element.tag == "include":
            standard = _standard(file, element, lights)
            if standard is None and not _is_sun(element):
                model = reading.include(file, element, 0)
            else:
                model = standard
            pose = element.find("pose")
        if model is None:
            continue
        relative = None if pose is None else (pose.get("relative_to") or pose.get("frame"))
        place = model.pose if not relative else frames.find(relative, element) @ model.pose
        found.append(_named(model, place, {other.name for other in found}))
    return found


def _named(model: SceneModel, place: Transform, taken: set[str]) -> SceneModel:
    name, number = model.name or "model", 0
    while name in taken:
        number += 1
        name = f"{model.name or 'model'}_{number}"
    return SceneModel(name, place, model.bodies, model.joints, model.static, model.plugins)


def _is_sun(element: Any) -> bool:
    return _last_word(element) == "sun"


def _last_word(element: Any) -> str:
    uri = (element.findtext("uri") or "").strip().rstrip("/")
    return str(uri.rpartition("/")[2].replace("_", " ").replace("%20", " ").lower())


def _standard(file: SdfFile, element: Any, lights: list[SceneLight]) -> SceneModel | None:
    """What nearly all worlds include, and nobody has on the disk: the ground and the sun."""
    if _is_sun(element):
        lights.append(SceneLight("directional", Transform((0.0, 0.0, 10.0)), (-0.5, 0.1, -0.9)))
        return None
    if _last_word(element) != "ground plane":
        return None
    plane = SceneShape("plane", (0.0, 0.0, 0.0))
    seen = SceneShape("plane", (0.0, 0.0, 0.0), touches=False, rgba=(0.8, 0.8, 0.8, 1.0))
    body = SceneBody("link", Transform(), (plane, seen))
    name = (element.findtext("name") or "").strip() or "ground_plane"
    return SceneModel(name, file.pose(element.find("pose")), {"link": body}, static=True)


def _with_states(file: SdfFile, world: Any, models: list[SceneModel]) -> list[SceneModel]:
    """The models where a saved world says that they were."""
    places = {
        element.get("name"): file.pose(element.find("pose"))
        for element in world.iterfind("state/model")
        if element.find("pose") is not None
    }
    return [
        SceneModel(m.name, places.get(m.name, m.pose), m.bodies, m.joints, m.static, m.plugins)
        for m in models
    ]


def _light(file: SdfFile, element: Any) -> SceneLight:
    kind = _LIGHTS.get(element.get("type") or "", "point")
    parts = (element.findtext("diffuse") or "1 1 1 1").split()
    try:
        red, green, blue = (min(max(float(part), 0.0), 1.0) for part in parts[:3])
    except ValueError as error:
        raise InvalidDescriptionError(
            f"{file.place(element)}: the <diffuse> of a light is '{' '.join(parts)}'"
        ) from error
    return SceneLight(
        kind,
        file.pose(element.find("pose")),
        file.vector(element, "direction", (0.0, 0.0, -1.0)),
        (red, green, blue),
        min(max(file.number(element, "spot/outer_angle", 1.6) / 2.0, 0.0), math.pi / 2.0),
        file.flag(element, "cast_shadows"),
    )


def _vector(file: SdfFile, element: Any) -> Vector3:
    x, y, z = file.numbers(element, 3)
    return x, y, z
