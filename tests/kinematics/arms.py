"""Small robots as URDF text, for tests of kinematics: chains of cylinders."""

from collections.abc import Sequence

from teleopctl.kinematics import GroupKinematics, KinematicModel, find_groups
from teleopctl.robot import RobotDescription

X, Y, Z = "1 0 0", "0 1 0", "0 0 1"
# Axis of each joint, and length of the link that it moves, in metres.
THREE = ((Z, 0.1), (Y, 0.3), (Y, 0.25))
FIVE = ((Z, 0.1), (Y, 0.25), (Y, 0.25), (Y, 0.1), (Z, 0.08))
SIX = ((Z, 0.15), (Y, 0.4), (Y, 0.35), (Y, 0.1), (Z, 0.1), (Y, 0.1))
SEVEN = ((Z, 0.15), (Y, 0.2), (Z, 0.2), (Y, 0.2), (Z, 0.2), (Y, 0.1), (Z, 0.1))


def arm_urdf(
    links: Sequence[tuple[str, float]],
    *,
    name: str = "arm",
    limit: float = 2.6,
    velocity: float = 2.0,
    radius: float = 0.03,
    extra: str = "",
) -> str:
    """Return the URDF of a chain: joints ``joint_1``, … with axes through the ends of cylinders.

    Links are ``base``, ``link_1``, … and ``tool0``, each cylinder along its link's z axis.

    Args:
        links: Axis and length of each link.
        name: Name of the robot.
        limit: Largest position of each joint to either side, rad.
        velocity: Velocity limit, rad/s.
        radius: Radius of the cylinders, m.
        extra: Further tags of ``<robot>``.
    """
    text = [f'<robot name="{name}"><link name="base"/>']
    at = 0.0
    for number, (axis, length) in enumerate(links, 1):
        parent = "base" if number == 1 else f"link_{number - 1}"
        # Shorter than its link, so that only links with another one between can touch.
        solid = f'<cylinder radius="{radius}" length="{0.8 * length:.6g}"/>'
        text.append(
            f'<link name="link_{number}"><collision><origin xyz="0 0 {length / 2:.6g}"/>'
            f"<geometry>{solid}</geometry></collision></link>"
            f'<joint name="joint_{number}" type="revolute"><parent link="{parent}"/>'
            f'<child link="link_{number}"/><origin xyz="0 0 {at:.6g}"/><axis xyz="{axis}"/>'
            f'<limit lower="{-limit}" upper="{limit}" velocity="{velocity}" effort="100"/></joint>'
        )
        at = length
    text.append(
        f'<link name="tool0"/><joint name="tool" type="fixed"><parent link="link_{len(links)}"/>'
        f'<child link="tool0"/><origin xyz="0 0 {at:.6g}"/></joint>{extra}</robot>'
    )
    return "".join(text)


def arm(links: Sequence[tuple[str, float]], **options: object) -> GroupKinematics:
    """Return the kinematics of the arm of `arm_urdf`."""
    description = RobotDescription.from_urdf(arm_urdf(links, **options))  # type: ignore[arg-type]
    return GroupKinematics(KinematicModel(description), find_groups(description).group())
