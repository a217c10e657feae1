"""Cameras and sensors of an MJCF file as ``<sensor>`` tags of a URDF.

A MuJoCo camera looks along its negative z axis, with x to the right and y up; a ``<sensor>`` looks
along its x axis, with y to the left and z up.

Several MuJoCo sensors on one site become one: a gyro and an accelerometer are an IMU, a force and a
torque sensor a wrench. Sensors of joints and actuators are joint states. Each other sensor has a
topic of its own, with a number, a vector, a point or a rotation.
"""

from __future__ import annotations

import math
from typing import Any

import mujoco
from lxml import etree

from teleopctl.robot.mjcf.mjcf_file import WORLD, Mjcf, sensor_type
from teleopctl.robot.urdf_text import add_origin, numbers, pose_text, topic_name, transform
from teleopctl.tf import Transform, quaternion_from_rpy

# The sensor's axes in the camera's, x y z w.
_SENSOR_IN_CAMERA = Transform(rotation=(-0.5, 0.5, 0.5, 0.5))
_RATE_HZ = 30
_FIXED = int(mujoco.mjtCamLight.mjCAMLIGHT_FIXED)
_PERSPECTIVE = int(mujoco.mjtProjection.mjPROJ_PERSPECTIVE)
_COLOURS = int(mujoco.mjtCamOutBit.mjCAMOUT_RGB)


def camera_tags(mjcf: Mjcf) -> tuple[list[etree._Element], list[str]]:
    """Return tags of an MJCF file's fixed perspective cameras, and sentences about the others.

    Returns:
        A ``<gazebo>`` element for each camera, and a sentence for each camera that is left out.
    """
    m = mjcf.model
    tags, remarks = [], []
    for number in range(m.ncam):
        name, body = m.camera(number).name, int(m.cam_bodyid[number])
        place = mjcf.place(body)
        if m.cam_mode[number] != _FIXED:
            why = "it tracks a body, and only fixed cameras have a frame"
        elif m.cam_projection[number] != _PERSPECTIVE:
            why = "its projection is orthographic, which camera_info cannot describe"
        elif place is None:
            why = f"'{m.body(body).name}' is not part of the robot, and moves"
        else:
            tags.append(_tag(m, number, *place))
            if m.cam_output[number] != _COLOURS:
                remarks.append(f"Camera '{name}' shows colours, and no other output")
            continue
        remarks.append(f"Camera '{name}' is left out: {why}")
    return tags, remarks


# Any: MuJoCo's model.
def _tag(m: Any, number: int, link: str, place: Transform) -> etree._Element:
    name = m.camera(number).name
    width, height = _size(m, number)
    fx, fy, cx, cy = _pinhole(m, number, width, height)
    gazebo = etree.Element("gazebo", reference=link)
    sensor = etree.SubElement(gazebo, "sensor", name=name, type="camera")
    own = place @ transform(m.cam_pos[number], m.cam_quat[number]) @ _SENSOR_IN_CAMERA
    topic = topic_name(name)
    for tag, text in (
        ("topic", f"{topic}/image_raw"),
        ("optical_frame_id", f"{topic}_optical"),
        ("update_rate", str(_RATE_HZ)),
        ("pose", pose_text(own)),
    ):
        etree.SubElement(sensor, tag).text = text
    lens = etree.SubElement(sensor, "camera")
    angle = 2.0 * math.atan(width / 2.0 / fx)
    etree.SubElement(lens, "horizontal_fov").text = numbers(angle)
    image = etree.SubElement(lens, "image")
    etree.SubElement(image, "width").text = str(width)
    etree.SubElement(image, "height").text = str(height)
    clip = etree.SubElement(lens, "clip")
    extent = float(m.stat.extent)
    etree.SubElement(clip, "near").text = numbers(extent * float(m.vis.map.znear))
    etree.SubElement(clip, "far").text = numbers(extent * float(m.vis.map.zfar))
    intrinsics = etree.SubElement(etree.SubElement(lens, "lens"), "intrinsics")
    for tag, value in (("fx", fx), ("fy", fy), ("cx", cx), ("cy", cy)):
        etree.SubElement(intrinsics, tag).text = numbers(value)
    return gazebo


# Any: MuJoCo's model.
def _size(m: Any, number: int) -> tuple[int, int]:
    """Return a camera's image size, or MuJoCo's offscreen size if the file has none (1 x 1)."""
    width, height = (int(side) for side in m.cam_resolution[number])
    if width > 1 and height > 1:
        return width, height
    return int(m.vis.global_.offwidth), int(m.vis.global_.offheight)


# Any: MuJoCo's model.
def _pinhole(m: Any, number: int, width: int, height: int) -> tuple[float, float, float, float]:
    """Return fx, fy, cx, cy in pixels; (0, 0) is the centre of the upper left pixel."""
    across, down = (float(side) for side in m.cam_sensorsize[number])
    if not (across and down):
        f = height / 2.0 / math.tan(math.radians(float(m.cam_fovy[number])) / 2.0)
        return f, f, (width - 1) / 2.0, (height - 1) / 2.0
    fx, fy, left, up = (float(length) for length in m.cam_intrinsic[number])
    # As MuJoCo renders: the principal point is offset to the left of the middle and upwards.
    cx = width * (0.5 - left / across) - 0.5
    cy = height * (0.5 - up / down) - 0.5
    return fx * width / across, fy * height / down, cx, cy


_Kind = mujoco.mjtSensor
_GYRO, _ACCELEROMETER = int(_Kind.mjSENS_GYRO), int(_Kind.mjSENS_ACCELEROMETER)
_QUATERNION = int(_Kind.mjSENS_FRAMEQUAT)
_FORCE, _TORQUE = int(_Kind.mjSENS_FORCE), int(_Kind.mjSENS_TORQUE)
_MAGNETOMETER, _RANGE = int(_Kind.mjSENS_MAGNETOMETER), int(_Kind.mjSENS_RANGEFINDER)
_TOUCH = int(_Kind.mjSENS_TOUCH)


def _kinds(*names: str) -> frozenset[int]:
    return frozenset(int(getattr(_Kind, f"mjSENS_{name}")) for name in names)


# Joint states have the values of these sensors already, and /clock has the time.
_OF_JOINTS = _kinds("JOINTPOS", "JOINTVEL", "JOINTACTFRC", "BALLQUAT", "BALLANGVEL")
_OF_ACTUATORS = _kinds("ACTUATORPOS", "ACTUATORVEL", "ACTUATORFRC")
_CLOCK = int(_Kind.mjSENS_CLOCK)
_ON_JOINTS = frozenset(map(int, (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)))
# Sensors that MuJoCo does not compute: user callbacks set their values.
_UNMEASURED = _kinds("USER")
_SITE, _BODY = int(mujoco.mjtObj.mjOBJ_SITE), int(mujoco.mjtObj.mjOBJ_XBODY)
_BODY_AT_CENTRE = int(mujoco.mjtObj.mjOBJ_BODY)
_SHAPE, _CAMERA = int(mujoco.mjtObj.mjOBJ_GEOM), int(mujoco.mjtObj.mjOBJ_CAMERA)
# Message types of sensors without a ROS message of their own, as in other MuJoCo bridges.
_POINT, _ROTATION, _VECTOR = (
    f"geometry_msgs/msg/{name}Stamped" for name in ("Point", "Quaternion", "Vector3")
)
_NUMBER, _NUMBERS = "std_msgs/msg/Float64", "std_msgs/msg/Float64MultiArray"
_POINTS = _kinds("FRAMEPOS", "SUBTREECOM")
_ROTATIONS = _kinds("FRAMEQUAT", "BALLQUAT")
# Unit vectors: noise would change their length.
_DIRECTIONS = _kinds("FRAMEXAXIS", "FRAMEYAXIS", "FRAMEZAXIS", "GEOMNORMAL")
_VECTORS = _DIRECTIONS | _kinds(
    "VELOCIMETER", "GYRO", "ACCELEROMETER", "FORCE", "TORQUE", "MAGNETOMETER", "FRAMELINVEL",
    "FRAMEANGVEL", "FRAMELINACC", "FRAMEANGACC", "SUBTREELINVEL", "SUBTREEANGMOM", "BALLANGVEL",
)  # fmt: skip
# Vectors along the axes of the sensor's site; others are along those of the world or another frame.
_IN_THEIR_SITE = _kinds("VELOCIMETER", "GYRO", "ACCELEROMETER", "FORCE", "TORQUE", "MAGNETOMETER")
# Sensors whose values in the world frame are part of a link's odometry.
_OF_ODOMETRY = frozenset(
    int(getattr(_Kind, f"mjSENS_FRAME{name}")) for name in ("POS", "QUAT", "LINVEL", "ANGVEL")
)
# Path of the noise in the tag, by MuJoCo sensor type.
_NOISE = {
    _GYRO: "imu/angular_velocity",
    _ACCELEROMETER: "imu/linear_acceleration",
    _FORCE: "force_torque/force",
    _TORQUE: "force_torque/torque",
    _MAGNETOMETER: "magnetometer",
}
# MuJoCo's rays are along z, those of sensor_msgs/Range along x.
_Z_FORWARD = Transform(rotation=quaternion_from_rpy(0.0, -math.pi / 2.0, 0.0))


def sensor_tags(mjcf: Mjcf) -> tuple[list[etree._Element], list[str]]:
    """Return URDF tags of an MJCF file's cameras and sensors, and sentences about those left out.

    Returns:
        URDF elements for cameras, sensors and the links of their frames, and a sentence for each
        sensor or property without effect.
    """
    cameras, remarks = camera_tags(mjcf)
    sensors = _Sensors(mjcf)
    return [*cameras, *sensors.tags], [*remarks, *sensors.remarks]


class _Sensors:
    """Builder of the tags of an MJCF file's sensors."""

    def __init__(self, mjcf: Mjcf) -> None:
        self._mjcf = mjcf
        self._m = mjcf.model
        self.tags: list[etree._Element] = []
        self.remarks: list[str] = []
        self._frames: dict[tuple[int, int, str], str] = {}
        self._links = {self._m.body(body).name for body in range(self._m.nbody)}
        self._links |= {f"{self._m.joint(n).name}_link" for n in range(self._m.njnt)}
        self._topics: set[str] = set()
        self._weak: list[str] = []
        self._left = [n for n in range(self._m.nsensor) if not self._is_joint_state(n)]
        self._in_joint_states = [n for n in range(self._m.nsensor) if n not in self._left]
        self._add_all()

    # Any: numpy's scalars.
    def _kind(self, number: int) -> int:
        return int(self._m.sensor_type[number])

    def _is_joint_state(self, number: int) -> bool:
        """Return whether a sensor's value is, without noise, in joint states or /clock."""
        m, kind = self._m, self._kind(number)
        if kind == _CLOCK:
            return True
        of = int(m.sensor_objid[number])
        on_joint = kind in _OF_JOINTS or (
            kind in _OF_ACTUATORS and int(m.actuator_trntype[of]) in _ON_JOINTS
        )
        return on_joint and not (self._noise(number) or m.sensor_cutoff[number])

    def _add_all(self) -> None:
        m = self._m
        for site in range(m.nsite):
            own = {
                self._kind(number): number
                for number in reversed(self._left)
                if self._is_on(number, site)
            }
            if own.keys() >= {_GYRO, _ACCELEROMETER}:
                self._add_imu(site, own)
            if own.keys() >= {_FORCE, _TORQUE}:
                self._add_wrench(site, own)
        for number in list(self._left):
            if int(m.sensor_objtype[number]) != _SITE:
                continue
            site, kind = int(m.sensor_objid[number]), self._kind(number)
            if kind == _MAGNETOMETER:
                self._add(site, "magnetometer", m.sensor(number).name, [number])
            elif kind == _TOUCH:
                self._add_mujoco_sensor(site, "touch", number)
            elif kind == _RANGE and m.sensor_dim[number] == 1:
                self._add_mujoco_sensor(site, "rangefinder", number, _Z_FORWARD)
        odometries: dict[str, list[int]] = {}
        for number in self._left:
            link = self._link_of_frame(number)
            if link:
                odometries.setdefault(link, []).append(number)
        for link, parts in odometries.items():
            self._add_odometry(link, parts)
        for number in list(self._left):
            if self._kind(number) not in _UNMEASURED:
                self._add_published(number)
        if self._left:
            listed = ", ".join(
                f"'{m.sensor(n).name}' ({sensor_type(self._kind(n))})" for n in self._left
            )
            self.remarks.append(f"Sensors of the file without a topic: {listed}")
        self._weak += [
            f"noise of '{m.sensor(n).name}'" for n in self._in_joint_states if self._noise(n)
        ]
        if self._weak:
            self.remarks.append(f"Without effect on topics: {', '.join(self._weak)}")

    def _is_on(self, number: int, site: int) -> bool:
        m = self._m
        is_of_site = int(m.sensor_objtype[number]) == _SITE and m.sensor_objid[number] == site
        return bool(is_of_site and m.sensor_refid[number] < 0)

    def _noise(self, number: int) -> float:
        return float(self._m.sensor_noise[number])

    def _add_imu(self, site: int, own: dict[int, int]) -> None:
        parts = [own[kind] for kind in (_GYRO, _ACCELEROMETER, _QUATERNION) if kind in own]
        tag = self._add(site, "imu", self._m.site(site).name, parts)
        if tag is not None and _QUATERNION not in own:
            _descend(tag, "imu/enable_orientation").text = "false"

    def _add_wrench(self, site: int, own: dict[int, int]) -> None:
        name = self._m.site(site).name
        tag = self._add(site, "force_torque", name, [own[_FORCE], own[_TORQUE]])
        if tag is not None:
            _descend(tag, "force_torque/frame").text = "site"
            _descend(tag, "force_torque/measure_direction").text = "parent_to_child"

    def _add_mujoco_sensor(
        self, site: int, kind: str, number: int, turn: Transform | None = None
    ) -> None:
        """Add a touch or range sensor, whose value MuJoCo computes, with zone and cutoff."""
        name = self._m.sensor(number).name
        tag = self._add(site, kind, name, [number], turn)
        if tag is not None:
            _descend(tag, f"{kind}/sensor").text = name
            if self._noise(number):
                _add_noise(_descend(tag, kind), self._noise(number))

    def _add(
        self, site: int, kind: str, name: str, parts: list[int], turn: Transform | None = None
    ) -> etree._Element | None:
        """Add a sensor for some of the file's on a site; None if no link has the site."""
        m = self._m
        place = self._mjcf.place(int(m.site_bodyid[site]))
        if place is None or (place[0] == WORLD and self._mjcf.root != WORLD):
            return None
        link = place[0]
        pose = place[1] @ transform(m.site_pos[site], m.site_quat[site]) @ (turn or Transform())
        frame = self._frame((_SITE, site), link, pose, name if turn else m.site(site).name)
        tag = self._tag(link, kind, name, frame, parts)
        etree.SubElement(tag, "pose").text = pose_text(pose)
        return tag

    def _tag(self, link: str, kind: str, name: str, frame: str, parts: list[int]) -> etree._Element:
        """Add the tag of a sensor for some of the file's sensors."""
        m, gazebo = self._m, etree.Element("gazebo", reference=link)
        tag = etree.SubElement(gazebo, "sensor", name=name, type=kind)
        etree.SubElement(tag, "topic").text = self._topic(name, kind)
        if frame:
            etree.SubElement(tag, "frame_id").text = frame
        periods = [float(m.sensor_interval[number][0]) for number in parts]
        if max(periods) > 0.0:
            etree.SubElement(tag, "update_rate").text = numbers(1.0 / max(periods))
        for number in parts:
            self._left.remove(number)
            self._add_noises(tag, number, kind)
        self.tags.append(gazebo)
        return tag

    def _add_published(self, number: int) -> None:
        """Add a sensor that is published by itself, in a message of its dimension."""
        m, kind = self._m, self._kind(number)
        message, frame = _message(kind, int(m.sensor_dim[number])), ""
        if message in (_POINT, _ROTATION, _VECTOR):
            frame = self._frame_of(number)
        name = m.sensor(number).name
        tag = self._tag(self._mjcf.root, "mujoco", name, frame, [number])
        _descend(tag, "mujoco/sensor").text = name
        _descend(tag, "mujoco/message").text = message
        if self._noise(number) and not _is_exact(kind, message):
            _add_noise(_descend(tag, "mujoco"), self._noise(number))

    def _frame_of(self, number: int) -> str:
        """Return the frame of a sensor's vector, which is added to the robot if needed."""
        m = self._m
        kind, of = int(m.sensor_reftype[number]), int(m.sensor_refid[number])
        if self._kind(number) in _IN_THEIR_SITE:
            kind, of = _SITE, int(m.sensor_objid[number])
        if of < 0:
            return WORLD
        if kind == _SITE:
            body, place = m.site_bodyid[of], transform(m.site_pos[of], m.site_quat[of])
        elif kind == _SHAPE:
            body, place = m.geom_bodyid[of], transform(m.geom_pos[of], m.geom_quat[of])
        elif kind == _CAMERA:
            body, place = m.cam_bodyid[of], transform(m.cam_pos[of], m.cam_quat[of])
        elif kind == _BODY_AT_CENTRE:
            body, place = of, transform(m.body_ipos[of], m.body_iquat[of])
        else:
            body, place = of, Transform()
        name = mujoco.mj_id2name(m, kind, of) or f"{m.body(int(body)).name}_frame"
        found = self._mjcf.place(int(body))
        if found is None or (found[0] == WORLD and self._mjcf.root != WORLD):
            return str(name)
        return self._frame((kind, of), found[0], found[1] @ place, str(name))

    def _link_of_frame(self, number: int) -> str:
        """Return the link whose pose or velocity in the world a sensor measures, else ""."""
        m, of = self._m, int(self._m.sensor_objid[number])
        kind = int(m.sensor_objtype[number])
        if self._kind(number) not in _OF_ODOMETRY or m.sensor_refid[number] >= 0:
            return ""
        if kind == _SITE:
            body, place = int(m.site_bodyid[of]), transform(m.site_pos[of], m.site_quat[of])
        elif kind == _BODY_AT_CENTRE:
            body, place = of, transform(m.body_ipos[of], m.body_iquat[of])
        elif kind == _BODY:
            body, place = of, Transform()
        else:
            return ""
        name = str(m.body(body).name)
        is_link = name != WORLD and self._mjcf.place(body) == (name, Transform())
        return name if is_link and place == Transform() else ""

    def _add_odometry(self, link: str, parts: list[int]) -> None:
        """Add Gazebo Classic's plug-in that publishes the odometry of a link."""
        gazebo = etree.Element("gazebo")
        plugin = etree.SubElement(
            gazebo, "plugin", name=f"{link}_odometry", filename="libgazebo_ros_p3d.so"
        )
        etree.SubElement(plugin, "body_name").text = link
        etree.SubElement(plugin, "topic_name").text = f"{topic_name(link)}/odom"
        self.tags.append(gazebo)
        for number in parts:
            self._left.remove(number)
            self._add_noises(gazebo, number, "odometry")

    def _add_noises(self, tag: etree._Element, number: int, kind: str) -> None:
        m, name = self._m, self._m.sensor(number).name
        of_file = kind in ("touch", "rangefinder", "mujoco")
        path = None if of_file else _NOISE.get(self._kind(number))
        if self._noise(number) and path is not None:
            for axis in "xyz":
                _add_noise(_descend(tag, f"{path}/{axis}"), self._noise(number))
        message = _message(self._kind(number), int(m.sensor_dim[number]))
        if (
            self._noise(number)
            and path is None
            and not (of_file and not _is_exact(self._kind(number), message))
        ):
            self._weak.append(f"noise of '{name}'")
        if m.sensor_cutoff[number] > 0.0 and not of_file:
            self._weak.append(f"cutoff of '{name}'")
        if m.sensor_delay[number] > 0.0:
            self._weak.append(f"delay of '{name}'")

    def _frame(self, of: tuple[int, int], link: str, pose: Transform, wanted: str) -> str:
        """Return a frame at a pose in a link: the link itself, or a link added for it."""
        if not any((*pose.translation, *pose.rotation[:3])):
            return link
        known = self._frames.get((*of, wanted))
        if known is None:
            known = _free(wanted, "frame", self._links)
            self._frames[*of, wanted] = known
            self.tags.append(etree.Element("link", name=known))
            joint = etree.Element("joint", name=f"{link}_to_{known}", type="fixed")
            add_origin(joint, pose)
            etree.SubElement(joint, "parent", link=link)
            etree.SubElement(joint, "child", link=known)
            self.tags.append(joint)
        return known

    def _topic(self, name: str, kind: str) -> str:
        return _free(topic_name(name), kind, self._topics)


def _message(kind: int, count: int) -> str:
    """Return the message type of a sensor that is published by itself."""
    if kind in _POINTS:
        return _POINT
    if kind in _ROTATIONS:
        return _ROTATION
    if kind in _VECTORS:
        return _VECTOR
    return _NUMBER if count == 1 else _NUMBERS


def _is_exact(kind: int, message: str) -> bool:
    """Return whether noise on a sensor's value would be invalid, as on a rotation."""
    return kind in _DIRECTIONS or message in (_ROTATION, _NUMBERS)


def _free(name: str, suffix: str, taken: set[str]) -> str:
    """Return a name that is not taken, and add it to the taken ones."""
    wanted = (name, *(f"{name}_{suffix}{number or ''}" for number in range(len(taken) + 1)))
    found = next(candidate for candidate in wanted if candidate not in taken)
    taken.add(found)
    return found


def _descend(tag: etree._Element, path: str) -> etree._Element:
    """Return the element at a path, adding those that are missing."""
    for name in path.split("/"):
        found = tag.find(name)
        tag = etree.SubElement(tag, name) if found is None else found
    return tag


def _add_noise(part: etree._Element, deviation: float) -> None:
    noise = etree.SubElement(part, "noise", type="gaussian")
    etree.SubElement(noise, "stddev").text = numbers(deviation)
