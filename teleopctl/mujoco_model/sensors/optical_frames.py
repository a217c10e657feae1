"""Which frame the images of a camera are in (REP 103, REP 105): z forward, x right, y down.

A camera of Gazebo looks along the x axis of its link. Its images are in the frame that the
description names if that one is turned as an image is, or is no link of the robot; else in an
optical link of the robot in its place; else in a frame of our own, ``LINK_optical``.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from teleopctl.robot import RosNames
from teleopctl.tf import Quaternion, Transform, multiply, quaternion_from_rpy

if TYPE_CHECKING:
    from teleopctl.robot import Pose, RobotDescription, SensorTag

# The optical frame in the sensor's frame, x y z w.
OPTICAL_ROTATION = (-0.5, 0.5, -0.5, 0.5)
# Descriptions write a quarter of a turn with two digits: 1.57.
_TURNED_ALIKE_RAD = 0.01
# A picture from a place further away shows what is 1 m ahead a pixel elsewhere.
_IN_ONE_PLACE_M = 0.001


def optical_frame(sensor: SensorTag, description: RobotDescription) -> tuple[str, str]:
    """Return the name of a camera's optical frame.

    Returns:
        The frame, and a sentence for the log if the description names another, else empty.
    """
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
        f"The frame '{named}' of camera '{sensor.name}' does not look where the camera does: its "
        f"images are in '{frame}'"
    )


def own_frame(link: str, name: str, description: RobotDescription) -> str:
    """Return a default name for a camera's optical frame, after its link or the camera."""
    return next(
        (f"{base}_optical" for base in (link, name) if f"{base}_optical" not in description.links),
        f"{link}_{name}_optical",
    )


def optical_rotation(pose: Pose) -> Quaternion:
    """Return the optical frame's rotation in the camera's link, x y z w."""
    return multiply(quaternion_from_rpy(*pose.rpy), OPTICAL_ROTATION)


def _is_optical(link: str, sensor: SensorTag, description: RobotDescription) -> bool:
    """Whether a link is fixed to a sensor's and turned as its images are."""
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
    """The target's frame in the source's, where nothing moves between them."""
    first, second = _in_rigid_root(source, description), _in_rigid_root(target, description)
    if first[0] != second[0]:
        return None
    return first[1].inverse() @ second[1]


def _in_rigid_root(link: str, description: RobotDescription) -> tuple[str, Transform]:
    """The first link upwards that moves, and this one's frame in it."""
    above = {joint.child: joint for joint in description.joints.values()}
    pose = Transform((0.0, 0.0, 0.0))
    while link in above and above[link].type == "fixed":
        joint = above[link]
        pose = Transform(joint.origin.xyz, quaternion_from_rpy(*joint.origin.rpy)) @ pose
        link = joint.parent
    return link, pose
