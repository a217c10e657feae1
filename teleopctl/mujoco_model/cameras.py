"""Cameras of a robot for the simulation: topics, frames, image size, lens and noise.

A plug-in of Gazebo classic publishes below the camera's name, with its remappings applied. A camera
of gz publishes on its ``<topic>``; its other topics are in the same namespace or below that topic,
depending on the kind of camera.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from teleopctl.robot import Lens, Noise, Pose, RosNames, ros_topic
from teleopctl.tf import Quaternion, Transform, multiply, quaternion_from_rpy

if TYPE_CHECKING:
    from teleopctl.robot import CameraTag, Pose, RobotDescription, SensorTag

_KINDS = {
    "camera": "camera",
    "depth": "depth",
    "depth_camera": "depth",
    "rgbd": "rgbd",
    "rgbd_camera": "rgbd",
    "segmentation": "segmentation",
    "segmentation_camera": "segmentation",
    "wide_angle_camera": "camera",
    "wideanglecamera": "camera",
    "boundingbox": "boxes",
    "boundingbox_camera": "boxes",
}
CAMERA_TYPES = frozenset(_KINDS)

# Default topics of a Gazebo classic plug-in, and the tags of older plug-ins that rename them.
_OF_PLUGIN = {
    "image": ("image_raw", "imageTopicName"),
    "info": ("camera_info", "cameraInfoTopicName"),
    "depth": ("depth/image_raw", "depthImageTopicName"),
    "depth_info": ("depth/camera_info", "depthImageCameraInfoTopicName"),
    "points": ("points", "pointCloudTopicName"),
}
PLUGIN_TOPIC_TAGS = frozenset(tag for _, tag in _OF_PLUGIN.values())


def camera_topics(sensor: SensorTag, name: str, *, alone: bool) -> dict[str, str]:
    """Return a camera's topic names by kind of data (image, depth, points, …).

    Args:
        sensor: The camera's ``<sensor>`` tag.
        name: The camera's name.
        alone: Whether it is the robot's only camera, whose topics need no name.

    Returns:
        Topic names by kind of data; for the kinds see `CameraModel`.
    """
    kind, names = _KINDS[sensor.type], RosNames(sensor)
    if not names.topic_decides:
        seen = ("image", "info") if kind == "camera" else tuple(_OF_PLUGIN)
        if kind not in ("segmentation", "boxes"):
            return {what: _of_plugin(names, sensor, what) for what in seen}
    info = sensor.texts.get("camera/camera_info_topic", "")
    topic = names.topic
    if kind == "camera":
        topic = topic or ("image_raw" if alone else f"{name}/image_raw")
        return {"image": topic, "info": info or _beside(topic, "camera_info")}
    if kind == "depth":
        topic = topic or f"{name}/depth_image"
        return {
            "depth": topic,
            "points": f"{topic}/points",
            "depth_info": info or _beside(topic, "camera_info"),
        }
    topic = topic or name
    if kind == "boxes":
        info = info or _beside(topic, "camera_info")
        return {"boxes": topic, "boxed_image": f"{topic}_image", "info": info}
    inside = {"info": info or f"{topic}/camera_info"}
    if kind == "rgbd":
        return inside | {
            "image": f"{topic}/image",
            "depth": f"{topic}/depth_image",
            "points": f"{topic}/points",
        }
    return inside | {"labels": f"{topic}/labels_map", "coloured": f"{topic}/colored_map"}


def _of_plugin(names: RosNames, sensor: SensorTag, what: str) -> str:
    default, tag = _OF_PLUGIN[what]
    camera = names.setting("camera_name", "cameraName") or sensor.name
    # ROS 2's plug-ins remap `CAMERA/image_raw`; many descriptions remap the other names.
    for name in (f"{camera}/{default}", f"~/{default}", default):
        if target := names.remapped(name):
            return target
    renamed = names.setting(tag, f"ros/{tag}") or default
    return names.of_plugin(renamed if renamed.startswith("/") else f"{camera}/{renamed}")


def _beside(topic: str, name: str) -> str:
    """Return a name in the same namespace as a topic."""
    above, slash, _ = topic.rpartition("/")
    return f"{above}{slash}{name}"


# Rotation of the optical frame in the sensor's frame, x y z w.
OPTICAL_ROTATION = (-0.5, 0.5, -0.5, 0.5)
# Descriptions round a quarter turn to two decimals: 1.57.
_TURNED_ALIKE_RAD = 0.01
# With a larger offset, an object 1 m ahead appears a pixel elsewhere in the image.
_IN_ONE_PLACE_M = 0.001


def optical_frame(sensor: SensorTag, description: RobotDescription) -> tuple[str, str]:
    """Return a camera's optical frame, and a warning, empty unless another frame was named."""
    if sensor.optical_frame:
        return sensor.optical_frame, ""
    named = RosNames(sensor).setting("frame_name", "frameName") or sensor.frame
    if named and (named not in description.links or _is_optical(named, sensor, description)):
        return named, ""
    found = [
        link
        for link in description.links
        if "optical" in link
        and _is_optical(link, sensor, description)
        and _offset(link, sensor, description) < _IN_ONE_PLACE_M
    ]
    frame = next(iter(found), own_frame(sensor.link, sensor.name, description))
    if named in ("", sensor.link):
        return frame, ""
    return frame, (
        f"The frame '{named}' of camera '{sensor.name}' has another orientation than the camera: "
        f"its images are in '{frame}'"
    )


def own_frame(link: str, name: str, description: RobotDescription) -> str:
    """Return a free default name for a camera's optical frame, after its link or the camera."""
    return next(
        (f"{base}_optical" for base in (link, name) if f"{base}_optical" not in description.links),
        f"{link}_{name}_optical",
    )


def optical_rotation(pose: Pose) -> Quaternion:
    """Return the optical frame's rotation (x, y, z, w) in the link, given the camera's pose."""
    return multiply(quaternion_from_rpy(*pose.rpy), OPTICAL_ROTATION)


def _is_optical(link: str, sensor: SensorTag, description: RobotDescription) -> bool:
    """Whether a link is fixed to a sensor's link and has the rotation of its optical frame."""
    between = _between(sensor.link, link, description)
    if between is None:
        return False
    wanted = optical_rotation(sensor.pose)
    alike = abs(sum(a * b for a, b in zip(wanted, between.rotation, strict=True)))
    return 2.0 * math.acos(min(1.0, alike)) < _TURNED_ALIKE_RAD


def _offset(link: str, sensor: SensorTag, description: RobotDescription) -> float:
    between = _between(sensor.link, link, description)
    return math.inf if between is None else math.dist(between.translation, sensor.pose.xyz)


def _between(source: str, target: str, description: RobotDescription) -> Transform | None:
    """Return the target's pose in the source link; None if a joint between them can move."""
    first, second = _in_rigid_root(source, description), _in_rigid_root(target, description)
    if first[0] != second[0]:
        return None
    return first[1].inverse() @ second[1]


def _in_rigid_root(link: str, description: RobotDescription) -> tuple[str, Transform]:
    """Return the link at the top of a chain of fixed joints, and the pose of this link in it."""
    above = {joint.child: joint for joint in description.joints.values()}
    pose = Transform((0.0, 0.0, 0.0))
    while link in above and above[link].type == "fixed":
        joint = above[link]
        pose = Transform(joint.origin.xyz, quaternion_from_rpy(*joint.origin.rpy)) @ pose
        link = joint.parent
    return link, pose


_DEFAULT_RATE_HZ = 30.0
# SDF's values of <box_type> for boxes around the visible part of an object.
_BOXES = ("2d", "visible_2d", "visible_box_2d")
_NO_DISTORTION = (0.0, 0.0, 0.0, 0.0, 0.0)

# Formats of Gazebo's images, other than red green blue, under both of their names.
_ENCODINGS = {"B8G8R8": "bgr8", "BGR_INT8": "bgr8", "L8": "mono8", "L_INT8": "mono8"}

# MuJoCo's camera axes expressed in the sensor's frame, quaternion w x y z.
_SENSOR_TO_MUJOCO = (0.5, 0.5, -0.5, -0.5)


@dataclass(frozen=True)
class CameraModel:
    """Simulated camera: link, image size, field of view, lens, optical frame and topics.

    Attributes:
        name: Name of the camera, and of the MuJoCo camera.
        link: The link that the camera is fixed to.
        frame_id: The optical frame (REP 103, REP 105) in which images are published.
        width: Image width in pixels.
        height: Image height in pixels.
        horizontal_fov: Angle between the left and the right edge of the image, in radians.
        rate_hz: Images per second of simulated time.
        distortion: Plumb-bob coefficients k1, k2, p1, p2, k3 of the lens.
        pose: Pose of the sensor in its link.
        near: Distance of the near clip plane, in metres along the optical axis.
        far: Distance of the far clip plane, in metres along the optical axis.
        depth_limits: Least and greatest measured depth, in metres.
        focal: Focal lengths fx, fy and principal point cx, cy in pixels that the description gives,
            or None where the field of view decides.
        topics: Topics by kind of data: ``image``, ``depth``, ``points``, ``labels``, ``coloured``,
            ``boxes``, ``boxed_image``, and their ``camera_info`` as ``info`` and ``depth_info``.
        noise: Noise of the image, as a fraction of full white.
        encoding: Encoding of the images: ``rgb8``, ``bgr8`` or ``mono8``.
        baseline_m: Distance to the left camera of a stereo pair, in metres, for ``camera_info``.
        rectified: fx, fy, cx, cy, tx, ty of a projection matrix in the description, or None.
        lens: Lens of a wide angle camera; None for a pinhole camera.
    """

    name: str
    link: str
    frame_id: str
    width: int
    height: int
    horizontal_fov: float
    rate_hz: float
    distortion: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)
    pose: Pose = field(default_factory=Pose)
    near: float = 0.1
    far: float = 100.0
    depth_limits: tuple[float, float] = (0.0, math.inf)
    focal: tuple[float, float, float, float] | None = None
    topics: Mapping[str, str] = field(default_factory=dict)
    noise: Noise | None = None
    encoding: str = "rgb8"
    baseline_m: float = 0.0
    rectified: tuple[float, float, float, float, float, float] | None = None
    lens: Lens | None = None

    def sees(self, what: str) -> bool:
        """Return whether the camera publishes a kind of data, ``depth`` for example."""
        return what in self.topics

    @property
    def focal_length(self) -> float:
        """Focal length in pixels; pixels are square, the horizontal field of view decides.

        For a wide angle camera, the focal length at the optical axis.
        """
        if self.lens is not None:
            return self.width / 2.0 * self.lens.focal_length
        return self.width / 2.0 / math.tan(self.horizontal_fov / 2.0)

    @property
    def vertical_fov(self) -> float:
        """Vertical field of view of a pinhole camera, in radians."""
        return 2.0 * math.atan(self.height / 2.0 / self.focal_length)

    @property
    def _pinhole(self) -> tuple[float, float, float, float]:
        f = self.focal_length
        return self.focal or (f, f, (self.width - 1) / 2.0, (self.height - 1) / 2.0)

    @property
    def intrinsics(self) -> tuple[float, ...]:
        """Intrinsic matrix K (3 by 3) of ``camera_info``, row by row.

        Pixel (0, 0) is the centre of the upper left pixel, so the image centre lies half a
        pixel before width/2.
        """
        fx, fy, cx, cy = self._pinhole
        return (fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0)

    @property
    def projection(self) -> tuple[float, ...]:
        """Projection matrix P (3 by 4) of ``camera_info``, row by row."""
        fx, fy, cx, cy = self._pinhole
        if self.rectified is not None:
            fx, fy, cx, cy, tx, ty = self.rectified
        else:
            # As for the right camera of a stereo pair with this baseline.
            tx, ty = -fx * self.baseline_m, 0.0
        return (fx, 0.0, cx, tx, 0.0, fy, cy, ty, 0.0, 0.0, 1.0, 0.0)

    @property
    def optical_rotation(self) -> Quaternion:
        """Rotation of the optical frame in the camera's link, as x, y, z, w."""
        return optical_rotation(self.pose)


def camera_models(description: RobotDescription) -> tuple[list[CameraModel], list[str]]:
    """Return a description's cameras, and warnings about left-out ones, names, frames and topics.

    Returns:
        The cameras, each with a unique name, and a warning for each camera that is left out, or
        whose name, frame or topic differs from the description's.

    Raises:
        InvalidDescriptionError: If a ``<gazebo>`` tag is not well formed.
    """
    cameras: dict[str, CameraModel] = {}
    warnings = []
    sensors = [
        sensor
        for sensor in description.gazebo.sensors
        if sensor.type in CAMERA_TYPES
        and sensor.camera is not None
        and (sensor.link in description.links or _is_in_world(sensor, description))
    ]
    for sensor in sensors:
        if fault := _fault(sensor):
            warnings.append(f"Camera '{sensor.name}' (line {sensor.line}) is left out: {fault}")
            continue
        frame, warning = optical_frame(sensor, description)
        if warning:
            warnings.append(warning)
        camera = _camera(sensor, frame)
        name = camera.name
        while name in cameras:
            name = f"{camera.link}/{name}"
        if name != camera.name:
            warnings.append(f"Two cameras are named '{camera.name}': one is renamed to '{name}'")
        named = camera_topics(sensor, name, alone=len(sensors) == 1)
        topics = {what: ros_topic(topic) for what, topic in named.items()}
        if changed := [what for what, topic in topics.items() if topic != named[what]]:
            warnings.append(
                f"'{named[changed[0]]}' is not a valid topic name: camera '{name}' publishes on "
                f"'{topics[changed[0]]}'"
            )
        own = frame == own_frame(camera.link, sensor.name, description)
        if own and any(c.frame_id == frame and c.pose != camera.pose for c in cameras.values()):
            # Another camera on the same link has another pose.
            frame = f"{name.replace('/', '_')}_optical"
        cameras[name] = replace(camera, name=name, topics=topics, frame_id=frame)
    return list(cameras.values()), warnings


def _is_in_world(sensor: SensorTag, description: RobotDescription) -> bool:
    """Whether a camera is fixed to the world in the robot's MJCF file."""
    return description.mjcf is not None and sensor.link == "world"


def _fault(sensor: SensorTag) -> str:
    """Return why a camera cannot be simulated; empty if it can."""
    camera = sensor.camera
    assert camera is not None
    if camera.lens is None and not 0.0 < camera.horizontal_fov < math.pi:
        return f"a pinhole camera cannot have a field of view of {camera.horizontal_fov:g} rad"
    if not 0.0 < camera.near < camera.far:
        return f"its clip range is empty: {camera.near:g} m and {camera.far:g} m"
    box = sensor.texts.get("camera/box_type", "2d")
    if box not in _BOXES:
        return f"its <box_type> is '{box}', and boxes are drawn around the visible part only: 2d"
    return ""


def _camera(sensor: SensorTag, frame: str) -> CameraModel:
    camera = sensor.camera
    assert camera is not None
    return CameraModel(
        name=_of_plugins(sensor, "camera_name") or camera.name or sensor.name,
        link=sensor.link,
        frame_id=frame,
        width=camera.width,
        height=camera.height,
        horizontal_fov=camera.horizontal_fov,
        rate_hz=sensor.update_rate or _DEFAULT_RATE_HZ,
        distortion=_NO_DISTORTION if camera.lens else _distortion(sensor, camera),
        pose=sensor.pose,
        near=camera.near,
        far=camera.far,
        depth_limits=_depth_limits(sensor, camera.near, camera.far),
        focal=None if camera.lens else camera.intrinsics,
        lens=camera.lens,
        noise=sensor.noise.get("camera"),
        encoding=_ENCODINGS.get(camera.format.upper(), "rgb8"),
        baseline_m=_plugin_number(sensor, "hack_baseline", "hackBaseline") or 0.0,
        rectified=camera.projection,
    )


def _distortion(sensor: SensorTag, camera: CameraTag) -> tuple[float, float, float, float, float]:
    """Return the coefficients of ``<distortion>``, with older plug-ins' tags in place of zeros."""
    k1, k2, p1, p2, k3 = (
        of_camera
        or _plugin_number(sensor, f"distortion_{name.lower()}", f"distortion{name}")
        or 0.0
        for of_camera, name in (
            (camera.k1, "K1"),
            (camera.k2, "K2"),
            (camera.p1, "T1"),
            (camera.p2, "T2"),
            (camera.k3, "K3"),
        )
    )
    return k1, k2, p1, p2, k3


def _depth_limits(sensor: SensorTag, near: float, far: float) -> tuple[float, float]:
    """Return the range of measured depths: that of the plug-in, within the clip distances."""
    least = _plugin_number(sensor, "min_depth", "pointCloudCutoff")
    most = _plugin_number(sensor, "max_depth", "pointCloudCutoffMax")
    return max(near, least or near), min(far, most or far)


def _plugin_number(sensor: SensorTag, *tags: str) -> float | None:
    """Return a number from the settings of the camera's plug-in; None without one."""
    with contextlib.suppress(ValueError):
        return float(RosNames(sensor).setting(*tags))
    return None


def _of_plugins(sensor: SensorTag, parameter: str) -> str:
    texts = (plugin.parameter(parameter) for plugin in sensor.plugins)
    return next((text for text in texts if text), "")


def add_camera(spec: mujoco.MjSpec, camera: CameraModel) -> None:
    """Add a camera of the description to its link's body in a ``mujoco.MjSpec``.

    Args:
        spec: The ``mujoco.MjSpec``, which has the camera's link as a body.
        camera: The camera to add.
    """
    rotation = np.zeros(4)
    mujoco.mju_mulQuat(rotation, _quaternion(camera.pose.rpy), np.array(_SENSOR_TO_MUJOCO))
    spec.body(camera.link).add_camera(
        name=camera.name,
        pos=list(camera.pose.xyz),
        quat=rotation,
        fovy=math.degrees(camera.vertical_fov),
        resolution=[camera.width, camera.height],
    )
    offscreen = spec.visual.global_
    offscreen.offwidth = max(offscreen.offwidth, camera.width)
    offscreen.offheight = max(offscreen.offheight, camera.height)


def _quaternion(rpy: tuple[float, float, float]) -> np.ndarray:
    """Return the quaternion w x y z of a rotation about the fixed axes x, y, z in this order."""
    quaternion = np.zeros(4)
    mujoco.mju_euler2Quat(quaternion, np.array(rpy), "XYZ")
    return quaternion
