"""Simple robots for tests of controllers and hardware components."""

from __future__ import annotations

from collections.abc import Sequence


def serial_robot(
    joints: int = 3,
    *,
    initial: Sequence[float] = (1.1, 2.1, 3.1),
    commands: Sequence[str] = ("position",),
    states: Sequence[str] = ("position",),
    plugin: str = "mock_components/GenericSystem",
    parameters: str = "",
    kind: str = "revolute",
    limits: str = 'lower="-100" upper="100" effort="1000" velocity="1000"',
    extra_joints: str = "",
    extra_control: str = "",
) -> str:
    """Return the URDF of a chain of ``joints`` joints (``joint1``, …) with ros2_control hardware.

    Args:
        joints: Number of joints.
        initial: Initial positions in rad or m, repeated if the robot has more joints.
        commands: Command interfaces of each joint.
        states: State interfaces of each joint.
        plugin: Hardware component: a plug-in name as in URDFs, or ``module:Class``.
        parameters: Parameters of the hardware component, as ``<param>`` tags.
        kind: Type of the joints.
        limits: Attributes of each joint's ``<limit>``.
        extra_joints: Further tags of ``<robot>``, such as joints.
        extra_control: Further tags of ``<ros2_control>``.
    """
    names = [f"joint{number}" for number in range(1, joints + 1)]
    links = "".join(f'<link name="link{number}"/>' for number in range(joints + 1))
    body = "".join(
        f'<joint name="{name}" type="{kind}"><parent link="link{number}"/>'
        f'<child link="link{number + 1}"/><axis xyz="0 0 1"/><limit {limits}/></joint>'
        for number, name in enumerate(names)
    )

    def state(name: str, value: float) -> str:
        text = f'<param name="initial_value">{value}</param>' if name == "position" else ""
        return f'<state_interface name="{name}">{text}</state_interface>'

    control = "".join(
        f'<joint name="{name}">'
        + "".join(f'<command_interface name="{command}"/>' for command in commands)
        + "".join(state(one, initial[number % len(initial)]) for one in states)
        + "</joint>"
        for number, name in enumerate(names)
    )
    return (
        f'<robot name="test">{links}{body}{extra_joints}'
        f'<ros2_control name="Hardware" type="system"><hardware><plugin>{plugin}</plugin>'
        f"{parameters}</hardware>{control}{extra_control}</ros2_control></robot>"
    )
