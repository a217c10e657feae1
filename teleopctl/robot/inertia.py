"""Inertia that a joint moves, from the masses in the robot description."""

from __future__ import annotations

from typing import TYPE_CHECKING

from teleopctl.tf import Transform, Vector3, quaternion_from_rpy, rotate

if TYPE_CHECKING:
    from teleopctl.robot.description import RobotDescription
    from teleopctl.robot.urdf import Inertial

_TURNING = ("revolute", "continuous")


def joint_inertias(description: RobotDescription) -> dict[str, float]:
    """Return the inertia of all that each joint moves, with all joints at 0.

    Rotors and gears are not in it, since descriptions have none.

    Args:
        description: Robot description.

    Returns:
        Inertia about the axis, kg m², of revolute and continuous joints, and mass, kg, of prismatic
        ones, by joint name; joints that move no mass are left out.
    """
    above = {joint.child: joint for joint in description.joints.values()}
    found: dict[str, float] = {}
    for link in description.links.values():
        body = link.inertial
        if body is None or body.mass <= 0.0:
            continue
        place = Transform(body.origin.xyz, quaternion_from_rpy(*body.origin.rpy))
        name = link.name
        while (joint := above.get(name)) is not None:
            moved = 0.0
            if joint.type in _TURNING:
                moved = _about_axis(body, place, joint.axis)
            elif joint.type == "prismatic":
                moved = body.mass
            if moved > 0.0:
                found[joint.name] = found.get(joint.name, 0.0) + moved
            place = Transform(joint.origin.xyz, quaternion_from_rpy(*joint.origin.rpy)) @ place
            name = joint.parent
    return found


def _about_axis(body: Inertial, place: Transform, axis: Vector3) -> float:
    """Return a body's inertia about an axis through the origin of the frame of its place, kg m²."""
    x, y, z, w = place.rotation
    a, b, c = rotate((-x, -y, -z, w), axis)
    own = a * a * body.ixx + b * b * body.iyy + c * c * body.izz
    own += 2.0 * (a * b * body.ixy + a * c * body.ixz + b * c * body.iyz)
    (ax, ay, az), (px, py, pz) = axis, place.translation
    lever = (ay * pz - az * py) ** 2 + (az * px - ax * pz) ** 2 + (ax * py - ay * px) ** 2
    return own + body.mass * lever
