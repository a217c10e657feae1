"""``teleopctl robot check``: check_urdf's text, what was ignored, and whether it stands."""

import itertools
import json
import sys
from pathlib import Path
from typing import Any

import pytest

from teleopctl.cli import main
from teleopctl.nodes.robot_check import report
from tests.sim.robots import box, control, joint, link

INERTIAL = """<inertial><mass value="1"/>
  <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>"""
# A table of four legs' width that stands, and the same on a knife's edge, which does not.
STANDS = box("collision", "0.4 0.4 0.1") + INERTIAL
FALLS = box("collision", "0.02 0.02 1") + INERTIAL.replace("<mass", '<origin xyz="0.1 0 0"/><mass')
ARM = (
    link("world", ""),
    link("base", box("visual", "0.1 0.1 0.1")),
    link("upper"),
    link("tool"),
    joint("weld", "world", "base", kind="fixed"),
    joint("b_shoulder", "base", "upper"),
    joint("a_camera", "base", "tool", kind="fixed"),
    control(b_shoulder="position"),
)


def write(file: Path, *parts: str) -> Path:
    file.write_text(f'<robot name="{file.stem}">{"".join(parts)}</robot>')
    return file


def test_a_file_is_told_as_check_urdf_does_and_then_what_the_simulator_makes_of_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mesh = '<visual><geometry><mesh filename="package://no_such/x.stl"/></geometry></visual>'
    strange = '<gazebo reference="upper"><kp>1e6</kp></gazebo><sponsor/>'
    file = write(tmp_path / "arm.urdf", *ARM, link("flag", mesh), strange)
    file.write_text(
        file.read_text().replace("</robot>", joint("j", "tool", "flag", kind="fixed") + "</robot>")
    )

    assert main.run(["robot", "check", str(file), "--simulate"]) == 1

    assert capsys.readouterr().out.splitlines() == [
        "robot name is: arm",
        "---------- Successfully Parsed XML ---------------",
        "root Link: world has 1 child(ren)",
        "    child(1):  base",
        "        child(1):  tool",
        "            child(1):  flag",
        "        child(2):  upper",
        "",
        "5 links, 4 joints (3 fixed, 1 revolute)",
        "Mass: 1 kg",
        "Package no_such: not found",
        "Meshes: 0 of 1 found",
        "  not found: package://no_such/x.stl",
        "<ros2_control> hardware (mock_components/GenericSystem):",
        "  b_shoulder: commands position; states position",
        "Guessed or left out:",
        "  The simulator is the hardware of 'hardware' (mock_components/GenericSystem)",
        "  Mesh 'package://no_such/x.stl' is left out: Package 'no_such' not found",
        "  Rotor inertias are assumed, in kg m^2 or kg: b_shoulder 0.02; "
        '<param name="armature"> of a joint in <ros2_control> sets one',
        "Without effect:",
        "  <kp> of 'upper' (line 7) has no effect: contacts are as stiff as steps of physics "
        "allow, and DART does not read it",
        "Unknown:",
        "  <sponsor> in <robot> is unknown (line 7)",
        "yourdfpy reads the same tree, limits, shapes and poses",
        "In simulation it stands",
        "1 of 1 joints follow a command",
        "By controllers that any robot gets:",
        "  joint_trajectory_controller (joint_trajectory_controller/JointTrajectoryController): "
        "1 joints reach their targets, to 0.0000",
        "5 of 5 links have a frame on /tf in simulation",
    ]


def test_a_folder_becomes_a_table_and_fails_with_the_first_robot_that_does(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write(tmp_path / "stands.urdf", link("table", STANDS))
    (tmp_path / "parts.xacro").write_text(
        '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:macro name="m"/></robot>'
    )
    (tmp_path / "package.xml").write_text("<package/>")
    (tmp_path / "ball.xml").write_text(
        '<mujoco><worldbody><body pos="0 0 0.1"><freejoint/><geom size="0.1"/></body></worldbody>'
        "</mujoco>"
    )
    assert main.run(["robot", "check", str(tmp_path), "-s"]) == 0
    capsys.readouterr()

    write(tmp_path / "falls.urdf", link("knife", FALLS), '<gazebo reference="knife"/>')
    (tmp_path / "broken.urdf").write_text(
        '<robot name="two"><link name="a"/><link name="b"/></robot>'
    )
    assert main.run(["robot", "check", str(tmp_path), "-s", "--json"]) == 1

    reports = {Path(one["file"]).name: one for one in json.loads(capsys.readouterr().out)}
    verdicts = {name: one["trial"] and one["trial"]["verdict"] for name, one in reports.items()}
    assert verdicts == {
        "ball.xml": "stands",
        "broken.urdf": None,
        "falls.urdf": "falls",
        "stands.urdf": "stands",
    }
    file = tmp_path / "broken.urdf"
    assert reports[file.name]["error"] == f"{file}: Two root links found: [a] and [b]"
    assert main.run(["robot", "check", str(tmp_path / "stands.urdf"), str(tmp_path), "-s"]) == 1
    table = capsys.readouterr().out.splitlines()
    titles = ["FILE", "PARSES", "COMPILES", "STANDS", "MOVES", "BY", "FRAMES", "WHY", "NOT"]
    assert table[0].split() == titles
    assert table[1].split()[1:] == ["yes", "yes", "yes", "-", "-", "1/1"]
    assert table[-2:] == [
        "4 parse, 4 compile, 3 stand, 0 of 0 with controllers of their own move by them, "
        "4 have every frame",
        "3 of 5 robots are fine",
    ]


def wheel(name: str, place: str, shape: str) -> str:
    """A wheel of 0.1 m on a base, and its joint, in `link` and `joint` of one text."""
    mass = """<inertial><mass value="0.5"/>
      <inertia ixx="2e-3" iyy="3e-3" izz="2e-3" ixy="0" ixz="0" iyz="0"/></inertial>"""
    return f"""<link name="{name}">{mass}{shape}</link>
      <joint name="{name}_joint" type="continuous"><parent link="base"/><child link="{name}"/>
      <origin xyz="{place}"/><axis xyz="0 1 0"/><limit effort="10" velocity="10"/></joint>"""


TYRE = """<collision><origin rpy="1.5708 0 0"/>
  <geometry><cylinder radius="0.1" length="0.04"/></geometry></collision>"""
# A caster that slides, behind the wheels.
CASTER = """<collision><origin xyz="-0.2 0 -0.05"/><geometry><sphere radius="0.05"/></geometry>
  </collision>"""
MANY = """
controller_manager:
  ros__parameters:
    update_rate: 50
    joint_state_broadcaster: {type: joint_state_broadcaster/JointStateBroadcaster}
    base_controller: {type: diff_drive_controller/DiffDriveController}
    arm_controller: {type: joint_trajectory_controller/JointTrajectoryController}
    lift_controller: {type: velocity_controllers/JointGroupVelocityController}
    hand_controller: {type: parallel_gripper_action_controller/GripperActionController}
    vendors_controller: {type: vendor/Controller}
base_controller:
  ros__parameters:
    left_wheel_names: [left_joint]
    right_wheel_names: [right_joint]
    wheel_separation: 0.4
    wheel_radius: 0.1
arm_controller:
  ros__parameters: {joints: [arm], command_interfaces: [position], state_interfaces: [position]}
lift_controller: {ros__parameters: {joints: [lift]}}
hand_controller: {ros__parameters: {joint: hand}}
"""


PLANAR = """<gazebo><plugin name="gliding" filename="libgazebo_ros_planar_move.so">
  <odometry_frame>odom</odometry_frame><robot_base_frame>base</robot_base_frame></plugin></gazebo>"""
STATES = '<state_interface name="position"/><state_interface name="velocity"/>'


def mobile(shape: str) -> tuple[str, ...]:
    """A base with two wheels that have a shape, and with four joints that hang on it."""
    inertial = INERTIAL.replace('"1"', '"5"').replace("<mass", '<origin xyz="-0.05 0 0"/><mass')
    wheels = control(left_joint="velocity", right_joint="velocity")
    rest = control(arm="position", lift="velocity", hand="position").replace("hardware", "rest", 1)
    return (
        link("base", CASTER + inertial),
        wheel("left", "0 0.2 0", shape),
        wheel("right", "0 -0.2 0", shape),
        *(link(f"of_{name}") for name in ("arm", "lift", "hand", "loose")),
        *(joint(name, "base", f"of_{name}") for name in ("arm", "lift", "hand", "loose")),
        (wheels + rest).replace('<state_interface name="position"/>', STATES),
    )


def test_a_file_that_meets_a_defect_keeps_the_others_results_from_nobody(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("fine.urdf", "odd.urdf"):
        write(tmp_path / name, link("table", STANDS))

    def checked(file: Path, arguments: dict[str, str], **options: Any) -> report.RobotReport:
        if file.name == "odd.urdf":
            raise AttributeError("no such thing")
        return check_robot(file, arguments, **options)

    check_robot = report.check_robot
    monkeypatch.setattr(report, "check_robot", checked)
    assert main.run(["robot", "check", str(tmp_path), "--json"]) == 1
    fine, odd = json.loads(capsys.readouterr().out)
    assert (fine["error"], fine["links"]) == (None, ["table"])
    assert "a defect of teleopctl, AttributeError: no such thing" in odd["error"]


def test_a_robot_is_moved_by_each_of_its_controllers_and_physics_says_how_far(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "controllers.yaml").write_text(MANY)
    given = f"controllers_file:={tmp_path / 'controllers.yaml'}"
    rolls = write(tmp_path / "rolls.urdf", *mobile(TYRE))
    slides = write(tmp_path / "slides.urdf", *mobile(""))
    glides = write(tmp_path / "glides.urdf", link("base", STANDS), PLANAR)

    assert main.run(["robot", "check", str(glides), "-s", "--json"]) == 0
    (motion,) = json.loads(capsys.readouterr().out)["driven"]["motions"]
    assert (motion["controller"], motion["moved"]) == ("/cmd_vel", True)
    assert motion["result"].startswith("ahead 0.60")

    floats = (link("world", ""), link("base", STANDS), joint("f", "world", "base", kind="floating"))
    assert main.run(["robot", "check", str(write(tmp_path / "floats.urdf", *floats)), "-s"]) == 0
    assert "2 of 2 links have a frame" in capsys.readouterr().out

    assert main.run(["robot", "check", str(rolls), given, "-s", "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    driven = report["driven"]
    assert (driven["own"], driven["verdict"], driven["fault"]) == (True, "yes", None)
    told = {motion["controller"]: motion["result"] for motion in driven["motions"]}
    # Controllers that forward commands start last.
    assert list(told) == ["base_controller", "arm_controller", "hand_controller", "lift_controller"]
    assert told["base_controller"].startswith("ahead 0.5")
    assert "(type 'vendor/Controller') not found." in driven["inactive"]["vendors_controller"]
    # Nobody commands the loose joint, and its link has a frame all the same.
    assert (report["frames"]["links"], report["frames"]["missing"]) == (7, [])
    assert report["frames"]["apart_m"] < 1e-9

    assert main.run(["robot", "check", str(slides), given, "-s"]) == 1
    out = capsys.readouterr().out
    assert "By its own controllers:\n  base_controller (diff_drive_controller/" in out
    assert "so they cannot collide: left, right" in out


CHAINED = """
controller_manager:
  ros__parameters:
    update_rate: 100
    states: {type: joint_state_broadcaster/JointStateBroadcaster}
    base: {type: diff_drive_controller/DiffDriveController}
    left: {type: pid_controller/PidController}
    right: {type: pid_controller/PidController}
    lift: {type: pid_controller/PidController}
base:
  ros__parameters:
    left_wheel_names: [left/left_joint]
    right_wheel_names: [right/right_joint]
    position_feedback: false
    wheel_separation: 0.4
    wheel_radius: 0.1
""" + "".join(
    f"{name}: {{ros__parameters: {{dof_names: [{joint}], command_interface: velocity, "
    "reference_and_state_interfaces: [velocity], enable_feedforward: true, "
    f"gains: {{{joint}: {{p: 0.2, i: 2.0, feedforward_gain: 1.0}}}}}}}}\n"
    for name, joint in (("left", "left_joint"), ("right", "right_joint"), ("lift", "lift"))
)


@pytest.mark.nightly
def test_a_base_drives_through_the_controllers_of_its_wheels(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "controllers.yaml").write_text(CHAINED)
    given = f"controllers_file:={tmp_path / 'controllers.yaml'}"
    rolls = write(tmp_path / "rolls.urdf", *mobile(TYRE))
    assert main.run(["robot", "check", str(rolls), given, "-s", "--json"]) == 0
    driven = json.loads(capsys.readouterr().out)["driven"]
    assert (driven["verdict"], driven["inactive"]) == ("yes", {})
    told = {motion["controller"]: motion["result"] for motion in driven["motions"]}
    # Those of the wheels are moved by the base's, the other one by its own references.
    assert sorted(told) == ["base", "lift"]
    assert told["base"].startswith("ahead 0.5")


YIELDING = """
controller_manager:
  ros__parameters:
    update_rate: 100
    states: {type: joint_state_broadcaster/JointStateBroadcaster}
    io: {type: gpio_controllers/GpioCommandController}
    soft: {type: admittance_controller/AdmittanceController}
io: {ros__parameters: {gpios: [pins], command_interfaces: {pins: {interfaces: [lamp]}}}}
soft:
  ros__parameters:
    joints: [slide]
    command_interfaces: [position]
    state_interfaces: [position]
    kinematics: {base: base, tip: tool}
    ft_sensor: {name: ft, frame: {id: tool}}
    control: {frame: {id: tool}}
    fixed_world_frame: {frame: {id: base}}
    gravity_compensation: {frame: {id: tool}, CoG: {pos: [0.0, 0.0, 0.0]}}
    admittance:
      selected_axes: [true, false, false, false, false, false]
      mass: [5.0, 1.0, 1.0, 1.0, 1.0, 1.0]
      damping_ratio: [1.0, 1.0, 1.0, 1.0, 1.0, 1.0]
      stiffness: [100.0, 1.0, 1.0, 1.0, 1.0, 1.0]
"""


def test_joint_references_move_an_admittance_controller_and_outputs_are_left_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "controllers.yaml").write_text(YIELDING)
    given = f"controllers_file:={tmp_path / 'controllers.yaml'}"
    states = "".join(
        f'<state_interface name="{part}.{axis}"/>' for part in ("force", "torque") for axis in "xyz"
    )
    hardware = (
        '<ros2_control name="s" type="system"><hardware><plugin>any/Hardware</plugin></hardware>'
        '<joint name="slide"><command_interface name="position"/><state_interface name="position"/>'
        '</joint><gpio name="pins"><command_interface name="lamp"/><state_interface name="lamp"/>'
        f'</gpio><sensor name="ft">{states}<param name="frame_id">tool</param></sensor>'
        "</ros2_control>"
    )
    slider = joint(
        "slide",
        "base",
        "arm",
        kind="prismatic",
        axis="1 0 0",
        limit='lower="-1" upper="1" effort="90" velocity="2"',
    )
    parts = (link("base", ""), link("arm"), link("tool"), slider)
    mount = joint("mount", "arm", "tool", kind="fixed")
    file = write(tmp_path / "soft.urdf", *parts, mount, hardware)
    assert main.run(["robot", "check", str(file), given, "-s", "--json"]) == 0
    driven = json.loads(capsys.readouterr().out)["driven"]
    assert driven["inactive"] == {}
    (motion,) = driven["motions"]
    assert (motion["controller"], motion["moved"]) == ("soft", True)


@pytest.mark.parametrize("rate", ["0", "-5", ".inf", "1000000000000", "fast", "true"])
def test_a_rate_of_control_that_is_none_is_the_robots_mistake(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], rate: str
) -> None:
    """One sentence, and whatever else is known of the robot."""
    controllers = tmp_path / "controllers.yaml"
    controllers.write_text(f"controller_manager: {{ros__parameters: {{update_rate: {rate}}}}}")
    file = write(tmp_path / "arm.urdf", *ARM)
    given = f"controllers_file:={controllers}"
    assert main.run(["robot", "check", str(file), given, "-s", "--json"]) == 1
    fault = json.loads(capsys.readouterr().out)["driven"]["fault"]
    assert fault.startswith(f"{controllers}: update_rate of '/controller_manager' is ")
    assert fault.endswith("expected a whole number from 1 to 100000")


def test_a_chain_of_links_may_be_longer_than_pythons_stack(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    names = [f"link_{number}" for number in range(450)]
    links = "".join(link(name, "") for name in names)
    joints = "".join(joint(two, one, two, kind="fixed") for one, two in itertools.pairwise(names))
    file = write(tmp_path / "chain.urdf", links, joints)
    main.run(["robot", "check", str(file)])  # with all that it imports
    usual = sys.getrecursionlimit()
    sys.setrecursionlimit(400)
    try:
        main.run(["robot", "check", str(file)])
    finally:
        sys.setrecursionlimit(usual)
    assert capsys.readouterr().out.count("450 links, 449 joints") == 2


def test_what_is_absurd_is_told_in_words(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("teleopctl.robot.meshes._MOST_BYTES_OF_OTHERS", 600)
    (tmp_path / "large.stl").write_bytes(bytes(684))
    mesh = f'<collision><geometry><mesh filename="{tmp_path}/large.stl"/></geometry></collision>'
    said = {
        link("base", mesh + INERTIAL): "large.stl has 0 MB; at most 0 MB are read",
        link(
            "base", STANDS.replace('ixx="', 'ixx="-')
        ): "-0.01, 0.01, 0.01, which must be positive",
        link("base", STANDS)
        + link("tip", box("collision", "1e20 1 1"))
        + joint("j", "base", "tip"): "MuJoCo: Inertia matrix",
        link("base", STANDS)
        + link("tip", STANDS)
        + joint("j", "base", "tip", limit='lower="1" upper="-1" effort="-5" velocity="2"'): "are "
        "ignored: lower 1 is above upper -1\n  Joint 'j': effort -5 limits nothing",
    }
    for number, (content, words) in enumerate(said.items()):
        file = write(tmp_path / f"robot{number}.urdf", content)
        # What is fixed to the world needs no inertia.
        main.run(["robot", "check", str(file), "fixed_base:=false"])
        assert words in capsys.readouterr().out


def test_what_a_xacro_file_says_in_vain_is_told_with_its_own_lines(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    namespace = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
    (tmp_path / "wheel.xacro").write_text(
        f"""<robot {namespace}><xacro:macro name="wheel" params="name">
<link name="${{name}}"><visual><geometry><sphere radius="1"/></geometry>
<glow/></visual></link>
<joint name="${{name}}_joint" type="fixed"><parent link="base"/><child link="${{name}}"/></joint>
</xacro:macro></robot>"""
    )
    file = tmp_path / "robot.xacro"
    file.write_text(
        f"""<robot name="r" {namespace}>
<xacro:include filename="wheel.xacro"/><xacro:arg name="colour" default="blue"/>
<link name="base"/>
<xacro:wheel name="a"/><xacro:wheel name="b"/>
<gazebo reference="base"><kp>1</kp>
<sensor name="s" type="imu"><visualize>true</visualize></sensor></gazebo>
</robot>"""
    )
    assert main.run(["robot", "check", str(file), "colur:=red", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["unknown"] == [
        f"<glow> in <visual> is unknown ({tmp_path / 'wheel.xacro'}:3)",
        "Argument 'colur' is unknown to the description: it takes colour (blue)",
    ]
    assert found["without_effect"] == [
        f"<kp> of 'base' ({file}:5) has no effect: contacts are as stiff as steps of physics "
        "allow, and DART does not read it",
        f"Without meaning outside of Gazebo's window, drawing and solver: <visualize> ({file}:6)",
    ]


def test_what_a_robot_of_sdf_says_in_vain_is_told_with_its_own_lines(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "model.sdf"
    sensor = '<sensor name="s" type="imu">\n<updat_rate>1</updat_rate></sensor>'
    file.write_text(f'<sdf version="1.9">\n<model name="m"><link name="l">{sensor}</link>'
                    "</model></sdf>")  # fmt: skip
    main.run(["robot", "check", str(file), "--json"])
    found = json.loads(capsys.readouterr().out)
    assert found["without_effect"] == [
        f"<updat_rate> of sensor 's' ({file}:3) is unknown (is it update_rate?)"
    ]


def test_a_robot_of_several_sdf_files_is_told_with_the_lines_of_each(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sensor = '<sensor name="{}" type="imu">{}<{}>1</{}></sensor>'
    mast, file = tmp_path / "mäst one.sdf", tmp_path / "model.sdf"
    mast.write_text(
        '<sdf version="1.9"><model name="mast"><link name="l">'
        + sensor.format("high", "\n\n", *("updat_rate",) * 2)
        + "</link></model></sdf>"
    )
    file.write_text(
        f'<sdf version="1.9">\n<model name="m"><include><uri>{mast.name}</uri></include>'
        "<joint name='j' type='fixed'><parent>base</parent><child>mast</child></joint>"
        '<link name="base">'
        + sensor.format("low", "\n", *("always_onn",) * 2)
        + "</link></model></sdf>"
    )
    main.run(["robot", "check", str(file), "--json"])
    found = json.loads(capsys.readouterr().out)
    assert sorted(found["without_effect"]) == [
        f"<always_onn> of sensor 'low' ({file}:3) is unknown (is it always_on?)",
        f"<updat_rate> of sensor 'high' ({mast}:3) is unknown (is it update_rate?)",
    ]


def test_a_world_is_told_by_what_is_in_it_and_what_it_says_in_vain(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    ours = tmp_path / "kitchen.yaml"
    ours.write_text(
        "things:\n  table: {shape: table, size: [1, 1, 1]}\n"
        "  cube: {shape: box, size: [1, 1, 1], at: [0, 0, 3], mass: 1}\n"
    )
    assert main.run(["robot", "check", str(ours)]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "world name is: kitchen",
        "2 things, 1 moving freely: table, cube",
        f"It compiles; sim.yaml world:={ours} puts a robot into it",
    ]
    ours.write_text("things:\n  table: {shape: table, size: [1, 1, 1], heigth: 3}\n")
    assert main.run(["robot", "check", str(ours)]) == 1
    assert "kitchen.yaml:2: 'table' has no 'heigth'" in capsys.readouterr().err

    file = tmp_path / "hall.sdf"
    model = '<model name="{}"><static>1</static>\n<link name="l"><glow/></link></model>'
    models = model.format("a") + model.format("b")
    file.write_text(f'<sdf version="1.9"><world name="hall">{models}</world></sdf>')
    assert main.run(["robot", "check", str(file), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["kind"], found["name"], found["links"]) == ("world", "hall", ["a", "b"])
    assert found["without_effect"] == [f"{file}:2, 3: <glow> in <link> is unknown"]
