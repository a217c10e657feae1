"""From where a robot fills the picture, whatever its size, and from where somebody looks."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from itertools import product
from typing import TYPE_CHECKING

from teleopctl.robot import Joints, JointSet, RobotDescription, SegmentTree
from teleopctl.tf import Transform, Vector3, quaternion_from_rpy
from teleopctl.viewer.rviz_file import View
from teleopctl.viewer.scene.mesh_files import MeshFile
from teleopctl.viewer.scene.shapes import box_around

if TYPE_CHECKING:
    import viser

# From the front, from the right, and from above.
_DIRECTION = (0.66, -0.6, 0.45)
# How many radii away the whole robot is seen beside the panels, with some air around it.
_RADII = 2.0
_SMALLEST_RADIUS_M = 0.02
_LARGEST_RADIUS_M = 1000.0
# viser's cameras are as OpenCV's: x right, y down, z ahead.
_AHEAD_OF_OPTICAL = Transform(rotation=(0.5, -0.5, 0.5, 0.5))


def view_of(description: RobotDescription, meshes: Mapping[str, MeshFile]) -> tuple[View, float]:
    """Return a camera view of a robot in its rest position.

    Args:
        description: The robot.
        meshes: The files of its meshes, by URI.

    Returns:
        The view in the frame of the robot's root link, and the robot's radius in metres.
    """
    points = list(_corners(description, meshes)) or [(0.0, 0.0, 0.0)]
    xs, ys, zs = zip(*points, strict=True)
    low, high = (min(xs), min(ys), min(zs)), (max(xs), max(ys), max(zs))
    x, y, z = ((least + most) / 2 for least, most in zip(low, high, strict=True))
    radius = min(max(math.dist(low, high) / 2, _SMALLEST_RADIUS_M), _LARGEST_RADIUS_M)
    dx, dy, dz = (_RADII * radius * step for step in _DIRECTION)
    return View((x + dx, y + dy, z + dz), (x, y, z)), radius


def seen_from(cameras: Iterable[viser.CameraHandle]) -> Transform | None:
    """Return the pose of the camera that moved last (x ahead, y left, z up), or None."""
    camera = max(cameras, key=lambda one: one.update_timestamp, default=None)
    if camera is None:
        return None
    w, x, y, z = (float(part) for part in camera.wxyz)
    px, py, pz = (float(part) for part in camera.position)
    return Transform((px, py, pz), (x, y, z, w)) @ _AHEAD_OF_OPTICAL


def round_number(number: float) -> float:
    """The next lower of 1, 2, 5, 10, … with any number of zeros."""
    power = 10.0 ** math.floor(math.log10(number))
    return power * max(step for step in (1, 2, 5) if step * power <= number * (1 + 1e-9))


def _corners(description: RobotDescription, meshes: Mapping[str, MeshFile]) -> Iterator[Vector3]:
    """The corners of boxes around everything that is drawn."""
    poses = _poses_at_rest(description)
    for name, link in description.links.items():
        for visual in link.visuals:
            box = box_around(visual.geometry, meshes)
            origin = Transform(visual.origin.xyz, quaternion_from_rpy(*visual.origin.rpy))
            for x, y, z in product(*zip(*box, strict=True)) if box is not None else ():
                yield (poses[name] @ origin @ Transform((x, y, z))).translation


def _poses_at_rest(description: RobotDescription) -> dict[str, Transform]:
    joints = Joints.for_display(description, lambda _warning: None)
    rest = JointSet(joints)
    tree = SegmentTree(description, joints)
    local = {segment.joint.child: segment.origin for segment in tree.fixed}
    positions = dict(zip(rest.names, rest.positions(), strict=True))
    for joint, transform in tree.transforms(positions):
        local[joint.child] = transform
    poses = {description.root: Transform()}
    for joint in description.tree:
        poses[joint.child] = poses[joint.parent] @ local.get(joint.child, Transform())
    return poses
