"""Rotations and translations in plain floats.

Quaternions are tuples (x, y, z, w), as ROS messages order them. For two or three rotations at a
time plain Python is several times faster than array arithmetic, and costs no import.
"""

import math
from dataclasses import dataclass

Vector3 = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
# Translation and rotation.
Pose7 = tuple[float, float, float, float, float, float, float]
Matrix3 = tuple[Vector3, Vector3, Vector3]

IDENTITY_ROTATION: Quaternion = (0.0, 0.0, 0.0, 1.0)

# Below this angle (rad) between two rotations, slerp's formula divides by almost nothing.
_SMALL_ANGLE = 1e-6


@dataclass(frozen=True, slots=True)
class Transform:
    """Transform from a child frame to its parent: rotate by ``rotation``, then translate.

    ``a @ b`` is the transform of b's child in a's parent, where b's parent is a's child.
    """

    translation: Vector3 = (0.0, 0.0, 0.0)
    rotation: Quaternion = IDENTITY_ROTATION

    def __matmul__(self, other: "Transform") -> "Transform":
        x, y, z = rotate(self.rotation, other.translation)
        tx, ty, tz = self.translation
        return Transform((tx + x, ty + y, tz + z), multiply(self.rotation, other.rotation))

    def inverse(self) -> "Transform":
        """Return the inverse transform, from the parent to the child frame."""
        back = conjugate(self.rotation)
        x, y, z = rotate(back, self.translation)
        return Transform((-x, -y, -z), back)


IDENTITY = Transform()


def multiply(a: Quaternion, b: Quaternion) -> Quaternion:
    """Return the product of two quaternions: rotate by b, then by a."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def conjugate(q: Quaternion) -> Quaternion:
    """Return the conjugate of a quaternion."""
    x, y, z, w = q
    return (-x, -y, -z, w)


def normalize(q: Quaternion) -> Quaternion:
    """Return a quaternion scaled to unit length.

    Raises:
        ZeroDivisionError: All four components are zero.
    """
    x, y, z, w = q
    length = math.hypot(x, y, z, w)
    return (x / length, y / length, z / length, w / length)


def rotate(q: Quaternion, v: Vector3) -> Vector3:
    """Return a vector rotated by a unit quaternion."""
    x, y, z, w = q
    vx, vy, vz = v
    # v + w t + cross(q, t), where t = 2 cross(q, v)
    tx, ty, tz = 2 * (y * vz - z * vy), 2 * (z * vx - x * vz), 2 * (x * vy - y * vx)
    return (
        vx + w * tx + y * tz - z * ty,
        vy + w * ty + z * tx - x * tz,
        vz + w * tz + x * ty - y * tx,
    )


def interpolate(a: Transform, b: Transform, fraction: float) -> Transform:
    """Return the transform between two: linear translation, spherical rotation.

    Args:
        a: Transform at fraction 0.
        b: Transform at fraction 1.
        fraction: Position between the two, from 0 to 1.
    """
    ax, ay, az = a.translation
    bx, by, bz = b.translation
    moved = (
        ax + (bx - ax) * fraction,
        ay + (by - ay) * fraction,
        az + (bz - az) * fraction,
    )
    return Transform(moved, slerp(a.rotation, b.rotation, fraction))


def slerp(a: Quaternion, b: Quaternion, fraction: float) -> Quaternion:
    """Return the spherical linear interpolation of two quaternions, the shorter way."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    cosine = ax * bx + ay * by + az * bz + aw * bw
    if cosine < 0.0:
        bx, by, bz, bw, cosine = -bx, -by, -bz, -bw, -cosine
    angle = math.acos(min(cosine, 1.0))
    if angle < _SMALL_ANGLE:
        near, far = 1.0 - fraction, fraction
    else:
        sine = math.sin(angle)
        near = math.sin((1.0 - fraction) * angle) / sine
        far = math.sin(fraction * angle) / sine
    return normalize(
        (near * ax + far * bx, near * ay + far * by, near * az + far * bz, near * aw + far * bw)
    )


def quaternion_from_rpy(roll: float, pitch: float, yaw: float) -> Quaternion:
    """Return the quaternion of roll, pitch and yaw about fixed axes, in radians."""
    sr, cr = math.sin(roll / 2), math.cos(roll / 2)
    sp, cp = math.sin(pitch / 2), math.cos(pitch / 2)
    sy, cy = math.sin(yaw / 2), math.cos(yaw / 2)
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )


def quaternion_from_axis_angle(axis: Vector3, angle: float) -> Quaternion:
    """Return the quaternion of a rotation about a unit axis by an angle in radians."""
    x, y, z = axis
    sine = math.sin(angle / 2)
    return (x * sine, y * sine, z * sine, math.cos(angle / 2))


def matrix_from_quaternion(q: Quaternion) -> Matrix3:
    """Return the rotation matrix of a unit quaternion."""
    x, y, z, w = q
    return (
        (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
        (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
        (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
    )


def rpy_from_quaternion(q: Quaternion) -> Vector3:
    """Return (roll, pitch, yaw) about fixed axes, in radians, of a unit quaternion.

    At a pitch of ±π/2 only the sum or difference of roll and yaw is defined; the yaw is then zero.
    """
    rows = matrix_from_quaternion(q)
    sine = rows[2][0]
    if sine >= 1.0 - 1e-12:
        return (math.atan2(-rows[0][1], -rows[0][2]), -math.pi / 2, 0.0)
    if sine <= -1.0 + 1e-12:
        return (math.atan2(rows[0][1], rows[0][2]), math.pi / 2, 0.0)
    return (
        math.atan2(rows[2][1], rows[2][2]),
        -math.asin(sine),
        math.atan2(rows[1][0], rows[0][0]),
    )


ECHO_DIGITS = 3
"""Number of decimals that ``tf2_echo`` prints."""


def pose_text(transform: Transform, digits: int = ECHO_DIGITS) -> str:
    """Return a transform as ``tf2_echo`` prints it below the time: translation, rotation, matrix.

    Args:
        transform: The transform.
        digits: Number of decimals.
    """

    def listed(values: tuple[float, ...]) -> str:
        return ", ".join(f"{value:.{digits}f}" for value in values)

    angles = rpy_from_quaternion(transform.rotation)
    rows = [
        (*row, moved)
        for row, moved in zip(
            matrix_from_quaternion(transform.rotation), transform.translation, strict=True
        )
    ]
    rows.append((0.0, 0.0, 0.0, 1.0))
    return "\n".join(
        [
            f"- Translation: [{listed(transform.translation)}]",
            f"- Rotation: in Quaternion (xyzw) [{listed(transform.rotation)}]",
            f"- Rotation: in RPY (radian) [{listed(angles)}]",
            f"- Rotation: in RPY (degree) [{listed(tuple(map(math.degrees, angles)))}]",
            "- Matrix:",
            # A blank and the number, padded to a sign, a digit and the point: " 12.250", "  1.000".
            *("".join(f" {value:{digits + 3}.{digits}f}" for value in row) for row in rows),
        ]
    )
