"""Small robots for tests, as URDF text."""

from teleopctl.mujoco_model.model import RobotModel, build_model
from teleopctl.robot.description import RobotDescription

INERTIAL = """<inertial><origin xyz="0 0 0.25"/><mass value="0.5"/>
  <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.001"/></inertial>"""


def link(name: str, content: str = INERTIAL) -> str:
    return f'<link name="{name}">{content}</link>'


def box(kind: str, size: str, xyz: str = "0 0 0") -> str:
    return f'<{kind}><origin xyz="{xyz}"/><geometry><box size="{size}"/></geometry></{kind}>'


def joint(
    name: str,
    parent: str,
    child: str,
    *,
    kind: str = "revolute",
    xyz: str = "0 0 0.5",
    axis: str = "1 0 0",
    limit: str = 'lower="-2" upper="2" effort="20" velocity="3"',
    content: str = "",
) -> str:
    bounds = f"<limit {limit}/>" if limit and kind != "fixed" else ""
    return f"""<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>
      <origin xyz="{xyz}"/><axis xyz="{axis}"/>{bounds}{content}</joint>"""


def control(**interfaces: str) -> str:
    """Return a ``<ros2_control>`` tag; keywords map joints to names of command interfaces."""
    joints = "".join(
        f'<joint name="{name}">'
        + "".join(f'<command_interface name="{word}"/>' for word in words.split())
        + '<state_interface name="position"/></joint>'
        for name, words in interfaces.items()
    )
    return f"""<ros2_control name="hardware" type="system">
      <hardware><plugin>mock_components/GenericSystem</plugin></hardware>{joints}</ros2_control>"""


def robot(*parts: str) -> RobotDescription:
    return RobotDescription.from_urdf(f'<robot name="test">{"".join(parts)}</robot>')


def model(*parts: str) -> RobotModel:
    """Return the model of a robot with a fixed root link."""
    return build_model(robot(*parts), fixed_base=True)


def pendulum(commands: str = "position", content: str = "", **options: str) -> RobotModel:
    """Return the model of a 0.5 kg link that stands upright on a horizontal hinge."""
    return model(
        link("base", ""),
        link("rod"),
        joint("hinge", "base", "rod", **options),
        control(hinge=commands),
        content,
    )
