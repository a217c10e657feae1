"""``<sensor>`` of a link, with ``<camera>``, ``<lens>``, ``<ray>``, ``<noise>`` and plug-ins."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TypeVar

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot.elements import XmlElement, boolean, child_text, describe, required, to_number
from teleopctl.robot.urdf import Pose

WIDE_ANGLE_TYPES = frozenset(("wideanglecamera", "wide_angle_camera"))

# SDF's lens functions and their derivatives.
_FUNCTIONS: dict[str, tuple[Callable[[float], float], Callable[[float], float]]] = {
    "tan": (math.tan, lambda angle: 1.0 + math.tan(angle) ** 2),
    "sin": (math.sin, math.cos),
    "id": (float, lambda _: 1.0),
}
# c1, c2 and the function of SDF's named projections.
_TYPES = {
    "stereographic": (2.0, 2.0, "tan"),
    "equidistant": (1.0, 1.0, "id"),
    "equisolid_angle": (2.0, 2.0, "sin"),
    "orthographic": (1.0, 1.0, "sin"),
}
# Names of the pinhole projection.
_STRAIGHT = ("gnomonical", "gnomonic")
# SDF's default, in radians from the axis.
_CUTOFF = 1.5707
_TRUE = ("true", "1")


@dataclass(frozen=True, slots=True)
class Lens:
    """Wide angle lens: r = c1 f fun(theta / c2 + c3) for the angle theta from the axis.

    r is 1 at the left and right edge of the image.

    Attributes:
        c1: Factor of the result.
        c2: Divisor of the angle.
        c3: Offset of the angle, in radians.
        f: Scale of the result.
        fun: Name of the function: ``tan``, ``sin`` or ``id``.
        cutoff: Largest visible angle from the axis, in radians.
    """

    c1: float
    c2: float
    c3: float
    f: float
    fun: str
    cutoff: float

    def radius(self, theta: float) -> float:
        """Return the distance from the image centre of a direction theta from the axis."""
        return self.c1 * self.f * _FUNCTIONS[self.fun][0](theta / self.c2 + self.c3)

    @property
    def focal_length(self) -> float:
        """Derivative of the image radius by the angle at the optical axis, per radian."""
        return self.c1 * self.f / self.c2 * _FUNCTIONS[self.fun][1](self.c3)


def read_lens(element: XmlElement | None, horizontal_fov: float, where: XmlElement) -> Lens | None:
    """Return the lens of a wide angle camera's ``<lens>``; None for a pinhole projection.

    Args:
        element: ``<lens>`` tag; None for SDF's default lens.
        horizontal_fov: Horizontal field of view of the image, in radians.
        where: Camera element, for error messages.

    Returns:
        The lens; None for a pinhole projection that is scaled to the field of view.

    Raises:
        InvalidDescriptionError: The lens type or function is unknown, or the lens cannot cover the
            field of view.
    """
    kind = "stereographic" if element is None else child_text(element, "type", "stereographic")
    scaled = element is None or child_text(element, "scale_to_hfov", "true").lower() in _TRUE
    if kind in _STRAIGHT and scaled:
        return None
    c3, f = 0.0, 1.0
    own = None if element is None else element.find("custom_function")
    if kind == "custom":
        c1, c2, c3, f = (
            _number(own, tag, usual)
            for tag, usual in (("c1", 1.0), ("c2", 1.0), ("c3", 0.0), ("f", 1.0))
        )
        fun = "tan" if own is None else child_text(own, "fun", "tan")
    elif kind in _TYPES:
        c1, c2, fun = _TYPES[kind]
    else:
        raise InvalidDescriptionError(
            f"{describe(where)}: <lens> is of the type '{kind}': one of custom, "
            f"{', '.join(_TYPES)}; gnomonical where it is scaled"
        )
    if fun not in _FUNCTIONS:
        raise InvalidDescriptionError(
            f"{describe(where)}: <fun> is '{fun}': one of {', '.join(_FUNCTIONS)}"
        )
    if scaled:
        edge = Lens(c1, c2, c3, 1.0, fun, math.pi).radius(horizontal_fov / 2.0)
        f = 1.0 / edge if edge else 0.0
    # Beyond a right angle the sine decreases and the tangent changes sign.
    rises = fun == "id" or 0.0 <= c3 <= horizontal_fov / 2.0 / c2 + c3 < math.pi / 2.0
    if not (rises and c1 * f > 0.0 and c2 > 0.0 and 0.0 < horizontal_fov <= 2.0 * math.pi):
        raise InvalidDescriptionError(
            f"{describe(where)}: such a <lens> does not see {horizontal_fov:g} rad"
        )
    return Lens(c1, c2, c3, f, fun, _number(element, "cutoff_angle", _CUTOFF))


def _number(element: XmlElement | None, tag: str, usual: float) -> float:
    text = "" if element is None else child_text(element, tag)
    value = to_number(text) if text else usual
    if value is None or not math.isfinite(value):
        raise InvalidDescriptionError(f"<{tag}> of <lens> should be a number, got '{text}'")
    return value


@dataclass(frozen=True, slots=True)
class PluginTag:
    """``<plugin>`` of Gazebo, with file name and parameters.

    ``parameters`` maps the path of each element without children (``camera_name``,
    ``ros/remapping``) to the texts of all elements at this path. ``line`` is the tag's line in the
    URDF; 0 if unknown.
    """

    name: str
    filename: str
    parameters: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    line: int = 0

    @property
    def runs_controllers(self) -> bool:
        """Whether the plug-in is ros2_control's, which runs a controller manager."""
        return "ros2_control" in self.filename

    def parameter(self, path: str, default: str = "") -> str:
        """Return the first text of the plug-in's parameter at a path, or the default."""
        return self.parameters.get(path, (default,))[0]


def read_plugin(element: XmlElement) -> PluginTag:
    """Return a ``<plugin>`` element as a `PluginTag`."""
    parameters: dict[str, list[str]] = {}

    def collect(parent: XmlElement, prefix: str) -> None:
        for child in parent:
            path = f"{prefix}{child.tag}"
            if next(iter(child), None) is None:
                parameters.setdefault(path, []).append((child.text or "").strip())
            else:
                collect(child, f"{path}/")

    collect(element, "")
    return PluginTag(
        name=element.get("name") or "",
        filename=required(element, "filename"),
        parameters={path: tuple(texts) for path, texts in parameters.items()},
        line=element.sourceline or 0,
    )


Default = TypeVar("Default", bound=float | None)

# Tags with a sensor's frame: of Gazebo, of Gazebo under its name Ignition, and of SDF. A camera's
# optical frame has precedence.
_FRAME_TAGS = ("gz_frame_id", "ignition_frame_id", "frame_id")
_OPTICAL_FRAME_TAGS = ("camera/optical_frame_id", "optical_frame_id")
_RAY_TAGS = ("ray", "lidar", "gpu_ray", "gpu_lidar")
_FORCE_TORQUE = {
    "frame": ("child", "parent", "sensor", "site"),
    "measure_direction": ("child_to_parent", "parent_to_child"),
}
_FORCE_TORQUE_PLUGIN = "gazebo_ros_ft_sensor"
_TEXTS = (
    "camera/camera_info_topic",
    "camera/segmentation_type",
    "camera/box_type",
    "imu/orientation_reference_frame/localization",
    "imu/orientation_reference_frame/custom_rpy",
)
# A gigabyte of rays is a mistake in the description. OpenGL does not render larger images.
_MOST_RAYS = 4_000_000
_MOST_PIXELS = 16_384


@dataclass(frozen=True, slots=True)
class CameraTag:
    """Content of a ``<camera>``: image, field of view, lens distortion (plumb_bob), limits.

    Pixels are square, so that ``horizontal_fov`` and the image size determine the focal lengths.
    ``intrinsics`` are fx, fy, cx, cy of ``<lens>`` in pixels, or None, and have precedence over
    ``horizontal_fov``. ``projection`` has fx, fy, cx, cy, tx, ty of the projection matrix for
    rectified images, or None. ``lens`` is the lens of a wide angle camera; None for a pinhole.
    """

    name: str
    horizontal_fov: float
    width: int
    height: int
    format: str = "R8G8B8"
    near: float = 0.1
    far: float = 100.0
    k1: float = 0.0
    k2: float = 0.0
    k3: float = 0.0
    p1: float = 0.0
    p2: float = 0.0
    intrinsics: tuple[float, float, float, float] | None = None
    projection: tuple[float, float, float, float, float, float] | None = None
    lens: Lens | None = None


@dataclass(frozen=True, slots=True)
class ForceTorqueTag:
    """Content of a ``<force_torque>``: frame and direction of the measurement.

    ``frame`` names the axes of the measurement: ``child``, ``parent`` or ``sensor``; ``site`` means
    the sensor's axes, with the torque about the sensor's origin, as in MuJoCo, instead of the
    joint's. ``measure_direction`` is the link that acts on the other link: ``child_to_parent`` or
    ``parent_to_child``.
    """

    frame: str = "child"
    measure_direction: str = "child_to_parent"


@dataclass(frozen=True, slots=True)
class RaySweep:
    """Lidar rays in one plane: ``count`` of them, from angle ``first`` to angle ``last``."""

    count: int = 1
    first: float = 0.0
    last: float = 0.0

    @property
    def step(self) -> float:
        """Angle between two neighbouring rays, in radians; 0 for a single ray."""
        return (self.last - self.first) / (self.count - 1) if self.count > 1 else 0.0


@dataclass(frozen=True, slots=True)
class Rays:
    """Content of a ``<ray>`` or ``<lidar>``: angles and range limits of the rays.

    Objects nearer than ``near`` or farther than ``far`` are not detected, in metres.
    """

    horizontal: RaySweep
    vertical: RaySweep
    near: float
    far: float


@dataclass(frozen=True, slots=True)
class Noise:
    """Sensor noise: Gaussian, with a constant bias and a drifting one.

    The drifting bias is a Gauss-Markov process with standard deviation ``dynamic_bias_stddev`` and
    ``dynamic_bias_correlation_time`` in seconds. A ``precision`` above 0 rounds values to multiples
    of it.
    """

    mean: float = 0.0
    stddev: float = 0.0
    bias_mean: float = 0.0
    bias_stddev: float = 0.0
    dynamic_bias_stddev: float = 0.0
    dynamic_bias_correlation_time: float = 0.0
    precision: float = 0.0


@dataclass(frozen=True, slots=True)
class SensorTag:
    """``<sensor>`` of a link: type, rate, topic, and its pose in the link's frame.

    A force-torque sensor may name a joint instead: then ``link`` is the joint's child. ``noise``
    is keyed by the path of the parent element: ``imu/angular_velocity/x``, ``ray``. ``contact``
    has the names of collision shapes. ``texts`` has texts of elements that only this sensor type
    has, by path. ``line`` is the tag's line; 0 if unknown.
    """

    name: str
    type: str
    link: str
    update_rate: float = 0.0
    topic: str = ""
    frame: str = ""
    optical_frame: str = ""
    pose: Pose = field(default_factory=Pose)
    camera: CameraTag | None = None
    rays: Rays | None = None
    force_torque: ForceTorqueTag = ForceTorqueTag()
    noise: Mapping[str, Noise] = field(default_factory=dict)
    contact: tuple[str, ...] = ()
    plugins: tuple[PluginTag, ...] = ()
    texts: Mapping[str, str] = field(default_factory=dict)
    line: int = 0


def read_sensor(element: XmlElement, link: str) -> SensorTag:
    """Return a link's ``<sensor>`` element as a `SensorTag`.

    Raises:
        InvalidDescriptionError: When a value is no number, or a camera has no image.
    """
    camera = element.find("camera")
    rays = next((found for tag in _RAY_TAGS if (found := element.find(tag)) is not None), None)
    contact = element.find("contact")
    return SensorTag(
        name=required(element, "name"),
        type=required(element, "type"),
        link=link,
        update_rate=number_in(element, "update_rate", 0.0),
        topic=child_text(element, "topic") or child_text(element, "contact/topic"),
        frame=_first_text(element, _FRAME_TAGS),
        optical_frame=_first_text(element, _OPTICAL_FRAME_TAGS),
        pose=_read_pose(element),
        camera=None if camera is None else _read_camera(camera, element.get("type") or ""),
        rays=None if rays is None else _read_rays(rays),
        force_torque=_read_force_torque(element.find("force_torque")),
        noise=dict(_noises(element, "")),
        contact=()
        if contact is None
        else tuple((c.text or "").strip() for c in contact.findall("collision")),
        plugins=tuple(read_plugin(child) for child in element.findall("plugin")),
        texts=dict(_texts(element)),
        line=element.sourceline or 0,
    )


def sensor_of_plugin(plugin: PluginTag, children: Mapping[str, str]) -> SensorTag | None:
    """Return the sensor of a Gazebo Classic force-torque plug-in; None for other plug-ins.

    Args:
        plugin: Plug-in of the robot.
        children: Child link by joint name.
    """
    if _FORCE_TORQUE_PLUGIN not in plugin.filename:
        return None
    joint = plugin.parameter("joint_name")
    numbers = {
        tag: to_number(plugin.parameter(tag)) or 0.0 for tag in ("update_rate", "gaussian_noise")
    }
    noise = Noise(stddev=numbers["gaussian_noise"])
    parts = [f"force_torque/{part}/{axis}" for part in ("force", "torque") for axis in "xyz"]
    return SensorTag(
        name=plugin.name,
        type="force_torque",
        link=children.get(joint, joint) or plugin.parameter("body_name"),
        update_rate=numbers["update_rate"],
        noise=dict.fromkeys(parts, noise) if noise.stddev > 0.0 else {},
        plugins=(plugin,),
        line=plugin.line,
    )


def _first_text(element: XmlElement, paths: tuple[str, ...]) -> str:
    return next(filter(None, (child_text(element, path) for path in paths)), "")


def _texts(element: XmlElement) -> Iterator[tuple[str, str]]:
    """Yield paths and texts of elements specific to the sensor's type: ``imu/localization``."""
    own = element.find(element.get("type") or "")
    for path in _TEXTS:
        if text := child_text(element, path):
            yield path, text
    for child in own if own is not None else ():
        if text := (child.text or "").strip():
            yield f"{element.get('type')}/{child.tag}", text


def _noises(element: XmlElement, path: str) -> Iterator[tuple[str, Noise]]:
    for child in element:
        if child.tag == "noise":
            kind = child.get("type") or child_text(child, "type", "none")
            if kind in ("gaussian", "gaussian_quantized"):
                names = Noise.__dataclass_fields__
                values = {name: number_in(child, name, 0.0) for name in names}
                for name, value in values.items():
                    if value < 0.0 and "mean" not in name:
                        raise InvalidDescriptionError(
                            f"{describe(child)}: <{name}> should not be negative, got {value:g}"
                        )
                yield path, Noise(**values)
        elif child.tag != "plugin":
            yield from _noises(child, f"{path}/{child.tag}".lstrip("/"))


def _read_rays(element: XmlElement) -> Rays:
    def sweep(tag: str) -> RaySweep:
        found = element.find(f"scan/{tag}")
        count = number_in(found, "samples", 1.0) * number_in(found, "resolution", 1.0)
        if not count < _MOST_RAYS:
            raise InvalidDescriptionError(f"{describe(element)}: {count:g} rays are too many")
        first, last = number_in(found, "min_angle", 0.0), number_in(found, "max_angle", 0.0)
        return RaySweep(max(1, round(count)), first, last)

    rays = Rays(
        sweep("horizontal"),
        sweep("vertical"),
        near=number_in(element, "range/min", 0.0),
        far=number_in(element, "range/max", math.inf, finite=False),
    )
    if rays.horizontal.count * rays.vertical.count > _MOST_RAYS:
        raise InvalidDescriptionError(f"{describe(element)}: more than {_MOST_RAYS} rays")
    return rays


def _read_force_torque(element: XmlElement | None) -> ForceTorqueTag:
    if element is None:
        return ForceTorqueTag()
    values = {
        "frame": child_text(element, "frame", "child"),
        "measure_direction": child_text(element, "measure_direction", "child_to_parent"),
    }
    for name, allowed in _FORCE_TORQUE.items():
        if values[name] not in allowed:
            raise InvalidDescriptionError(
                f"{describe(element)}: <{name}> is '{values[name]}': one of {', '.join(allowed)}"
            )
    return ForceTorqueTag(**values)


def _read_camera(element: XmlElement, kind: str) -> CameraTag:
    image = element.find("image")
    if image is None:
        raise InvalidDescriptionError(
            f"{describe(element)}: a camera needs an <image> with its size"
        )
    distortion, clip = element.find("distortion"), element.find("clip")
    coefficients = {
        name: number_in(distortion, name, 0.0) for name in ("k1", "k2", "k3", "p1", "p2")
    }
    fov, wide = _required_number(element, "horizontal_fov"), kind in WIDE_ANGLE_TYPES
    return CameraTag(
        name=element.get("name") or "",
        horizontal_fov=fov,
        width=_pixels(image, "width"),
        height=_pixels(image, "height"),
        format=child_text(image, "format", "R8G8B8"),
        # Rendering needs a near plane above zero.
        near=number_in(clip, "near", 0.0) or 0.1,
        far=number_in(clip, "far", 0.0) or 100.0,
        intrinsics=_read_intrinsics(element.find("lens/intrinsics")),
        projection=_read_projection(element.find("lens/projection")),
        lens=read_lens(element.find("lens"), fov, element) if wide else None,
        **coefficients,
    )


def _pixels(image: XmlElement, tag: str) -> int:
    value = _required_number(image, tag)
    if not 1.0 <= value <= _MOST_PIXELS:
        raise InvalidDescriptionError(
            f"{describe(image)}: <{tag}> should be 1 to {_MOST_PIXELS} pixels, got {value:g}"
        )
    return int(value)


def _read_intrinsics(element: XmlElement | None) -> tuple[float, float, float, float] | None:
    fx, fy, cx, cy = (number_in(element, tag, None) for tag in ("fx", "fy", "cx", "cy"))
    if fx is None or fy is None or cx is None or cy is None or min(fx, fy) <= 0.0:
        return None
    return fx, fy, cx, cy


def _read_projection(
    element: XmlElement | None,
) -> tuple[float, float, float, float, float, float] | None:
    if element is None:
        return None
    fx, fy, cx, cy, tx, ty = (
        number_in(element, tag, 0.0) for tag in ("p_fx", "p_fy", "p_cx", "p_cy", "tx", "ty")
    )
    return (fx, fy, cx, cy, tx, ty) if min(fx, fy) > 0.0 else None


def _read_pose(element: XmlElement) -> Pose:
    if element.find("pose") is None:
        return Pose()
    text = child_text(element, "pose")
    values = [value for part in text.split() if (value := to_number(part)) is not None]
    if not len(values) == len(text.split()) == 6 or not all(map(math.isfinite, values)):
        raise InvalidDescriptionError(
            f"{describe(element)}: <pose> should be 6 finite numbers, got '{text}'"
        )
    x, y, z, *turn = values
    pose = element.find("pose")
    if pose is not None and pose.get("degrees") in ("true", "1"):
        turn = list(map(math.radians, turn))
    return Pose((x, y, z), (turn[0], turn[1], turn[2]))


def number_in(
    element: XmlElement | None, tag: str, default: Default, *, finite: bool = True
) -> float | Default:
    """Return the number in a child's text or ``value``; the default if the child is missing.

    Args:
        element: Parent element, or None.
        tag: Path of the child element.
        default: Value for a missing child.
        finite: Whether infinity is an error.

    Raises:
        InvalidDescriptionError: When the child is no number.
    """
    child = None if element is None else element.find(tag)
    if element is None or child is None:
        return default
    text = (child.text or "").strip() or child.get("value") or ""
    value = to_number(text)
    if value is None or (finite and math.isinf(value)):
        kind = "a number" if value is None else "a finite number"
        raise InvalidDescriptionError(
            f"{describe(element)}: <{tag}> should be {kind}, got '{text}'"
        )
    return value


def _required_number(element: XmlElement, tag: str) -> float:
    value = number_in(element, tag, None)
    if value is None:
        raise InvalidDescriptionError(f"{describe(element)}: has no <{tag}>")
    return value


def flag(element: XmlElement, text: str) -> bool:
    """Return the text ``true``, ``false``, ``1`` or ``0`` as a bool; raise for other texts.

    Raises:
        InvalidDescriptionError: When the text is anything else.
    """
    if text in ("0", "1"):
        return text == "1"
    return boolean(text, describe(element))
