"""The cameras of an MJCF file, as the ``<sensor>`` tags that cameras of a robot have.

A camera of MuJoCo's looks along its negative z axis, with x to the right and y up; a sensor of a
description looks along its x axis, with y to the left and z up.
"""

from __future__ import annotations

import math
from typing import Any

import mujoco
from lxml import etree

from teleopctl.robot.mjcf.mjcf_file import Mjcf
from teleopctl.robot.urdf_text import numbers, pose_text, topic_name, transform
from teleopctl.tf import Transform

# The sensor's axes in the camera's, x y z w.
_SENSOR_IN_CAMERA = Transform(rotation=(-0.5, 0.5, 0.5, 0.5))
_RATE_HZ = 30
_FIXED = int(mujoco.mjtCamLight.mjCAMLIGHT_FIXED)
_PERSPECTIVE = int(mujoco.mjtProjection.mjPROJ_PERSPECTIVE)
_COLOURS = int(mujoco.mjtCamOutBit.mjCAMOUT_RGB)


def camera_tags(mjcf: Mjcf) -> tuple[list[etree._Element], list[str]]:
    """Return the cameras of an MJCF file as ``<sensor>`` tags.

    Returns:
        A ``<gazebo>`` for each, and a sentence for each other.
    """
    m = mjcf.model
    tags, remarks = [], []
    for number in range(m.ncam):
        name, body = m.camera(number).name, int(m.cam_bodyid[number])
        place = mjcf.place(body)
        if m.cam_mode[number] != _FIXED:
            why = "it follows something, and only what is fixed has a frame"
        elif m.cam_projection[number] != _PERSPECTIVE:
            why = "its projection is orthographic, which camera_info cannot say"
        elif place is None:
            why = f"'{m.body(body).name}' is not of the robot, and moves"
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


# Any: as above.
def _size(m: Any, number: int) -> tuple[int, int]:
    """The image's, which is that of MuJoCo's own pictures where the camera says none (1 x 1)."""
    width, height = (int(side) for side in m.cam_resolution[number])
    if width > 1 and height > 1:
        return width, height
    return int(m.vis.global_.offwidth), int(m.vis.global_.offheight)


# Any: as above.
def _pinhole(m: Any, number: int, width: int, height: int) -> tuple[float, float, float, float]:
    """Focal lengths and principal point in pixels; (0, 0) is the centre of the upper left one."""
    across, down = (float(side) for side in m.cam_sensorsize[number])
    if not (across and down):
        f = height / 2.0 / math.tan(math.radians(float(m.cam_fovy[number])) / 2.0)
        return f, f, (width - 1) / 2.0, (height - 1) / 2.0
    fx, fy, left, up = (float(length) for length in m.cam_intrinsic[number])
    # As MuJoCo draws it: the principal point is that far to the left of the middle, and above it.
    cx = width * (0.5 - left / across) - 0.5
    cy = height * (0.5 - up / down) - 0.5
    return fx * width / across, fy * height / down, cx, cy
