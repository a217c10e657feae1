"""SDF's screws, joints with two axes and gearboxes, by their closed forms; mimics in worlds."""

import math
from pathlib import Path

import numpy as np
import pytest

from teleopctl.mujoco_model import RobotModel, build_model
from teleopctl.robot import RobotDescription, read_model, read_world, simulated
from teleopctl.sim.simulation import Simulation
from tests.sim.robots import joint as urdf_joint, link as urdf_link, robot

G = 9.81
MASS, MOMENT = 2.0, 0.003
STILL = robot(urdf_link("world", ""))


def link(name: str, z: float, moment: float = MOMENT) -> str:
    moments = "".join(f"<i{axes}>{moment}</i{axes}>" for axes in ("xx", "yy", "zz"))
    return (
        f"<link name='{name}'><pose>0 0 {z} 0 0 0</pose><inertial><mass>{MASS}</mass>"
        f"<inertia>{moments}</inertia></inertial></link>"
    )


def joint(name: str, kind: str, parent: str, child: str, content: str) -> str:
    return (
        f"<joint name='{name}' type='{kind}'><parent>{parent}</parent><child>{child}</child>"
        f"{content}</joint>"
    )


def in_world(tmp_path: Path, *parts: str) -> RobotModel:
    file = tmp_path / "world.sdf"
    model = f"<model name='m'>{''.join(parts)}</model>"
    file.write_text(f"<sdf version='1.11'><world name='w'>{model}</world></sdf>")
    built = build_model(STILL, world=read_world(file))
    assert built.warnings == ()
    return built


def as_robot(tmp_path: Path, *parts: str, control: str = "") -> RobotModel:
    file = tmp_path / "model.sdf"
    file.write_text(f"<sdf version='1.11'><model name='m'>{''.join(parts)}</model></sdf>")
    text = read_model(file).text.replace("</robot>", f"{control}</robot>")
    return build_model(RobotDescription.from_urdf(simulated(text)[0]))


def control(joint: str, command: str, more: str = "") -> str:
    return (
        '<ros2_control name="h" type="system"><hardware><plugin>mock_components/GenericSystem'
        f'</plugin></hardware><joint name="{joint}"><param name="armature">0</param>'
        f'<command_interface name="{command}"/><state_interface name="position"/>'
        f'<state_interface name="velocity"/></joint>{more}</ros2_control>'
    )


def positions(simulation: Simulation) -> dict[str, float]:
    """Where the joints of a world are, by the ends of their names."""
    model, data = simulation.observe()
    return {
        model.joint(number).name.rpartition("/")[2]: float(data.qpos[model.jnt_qposadr[number]])
        for number in range(model.njnt)
    }


@pytest.mark.parametrize(
    ("thread", "pitch_m"),
    [
        ("<screw_thread_pitch>0.1</screw_thread_pitch>", 0.1),
        (f"<thread_pitch>{math.tau / 0.1}</thread_pitch>", -0.1),
    ],
    ids=["right-handed", "left-handed"],
)
def test_a_nut_falls_along_its_screw_as_its_turning_lets_it(
    tmp_path: Path, thread: str, pitch_m: float
) -> None:
    screw = joint("s", "screw", "world", "nut", f"{thread}<axis><xyz>0 0 1</xyz></axis>")
    simulation = Simulation(
        in_world(tmp_path, link("nut", 3.0), screw), control_period_ns=1_000_000
    )
    simulation.step(1_000)
    found = positions(simulation)
    # Its turning adds to its mass: for each metre it turns by 2 pi / pitch.
    acceleration = MASS * G / (MASS + MOMENT * (math.tau / pitch_m) ** 2)
    slid, turned = found["m_s_slide"], found["nut_s"]
    assert slid == pytest.approx(-acceleration / 2.0, rel=0.01)
    assert turned == pytest.approx(slid * math.tau / pitch_m, rel=0.001)


def test_a_screw_that_is_driven_advances_by_its_pitch_each_turn(tmp_path: Path) -> None:
    screw = joint(
        "s",
        "screw",
        "world",
        "nut",
        "<screw_thread_pitch>0.02</screw_thread_pitch><axis><xyz>0 0 1</xyz></axis>",
    )
    built = as_robot(tmp_path, link("nut", 1.0), screw, control=control("s", "position"))
    simulation = Simulation(built, control_period_ns=10_000_000)
    start = simulation.link_pose("nut").position[2]
    simulation.apply(["s"], [5.0 * math.tau])
    simulation.step(3_000)
    simulation.read()
    assert simulation.positions[simulation.joint_names.index("s")] == pytest.approx(
        5.0 * math.tau, abs=1e-3
    )
    assert simulation.link_pose("nut").position[2] - start == pytest.approx(0.1, abs=1e-4)


@pytest.mark.parametrize("kind", ["universal", "revolute2"])
@pytest.mark.parametrize("axis", [1, 2])
def test_what_hangs_on_a_joint_with_two_axes_swings_about_each(
    tmp_path: Path, kind: str, axis: int
) -> None:
    length = 0.5
    axes = (
        f"<pose>0 0 {length} 0 0 0</pose><axis><xyz>1 0 0</xyz></axis>"
        "<axis2><xyz>0 1 0</xyz></axis2>"
    )
    hung = joint("j", kind, "world", "bob", axes)
    built = as_robot(tmp_path, link("bob", 2.0), hung, control=control("j_1", "effort"))
    simulation = Simulation(built, control_period_ns=1_000_000)
    amplitude = 0.05
    simulation.reset_state({f"j_{axis}": amplitude})
    simulation.apply(["j_1"], effort=[0.0])
    period = math.tau * math.sqrt((MOMENT + MASS * length**2) / (MASS * G * length))
    simulation.step(round(period / 2.0 * 1e3))
    simulation.read()
    found = dict(zip(simulation.joint_names, simulation.positions, strict=True))
    assert found[f"j_{axis}"] == pytest.approx(-amplitude, rel=0.002)
    assert found[f"j_{3 - axis}"] == pytest.approx(0.0, abs=1e-6)


def test_the_first_axis_is_fixed_to_the_parent_and_the_second_to_the_child(tmp_path: Path) -> None:
    axes = "<axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2>"
    built = as_robot(tmp_path, link("bob", 2.0), joint("j", "universal", "world", "bob", axes))
    simulation = Simulation(built, control_period_ns=1_000_000)
    first, second = 0.7, -0.4
    simulation.reset_state({"j_1": first, "j_2": second})
    _, data = simulation.observe()
    about_x = np.array(
        [
            [1.0, 0.0, 0.0],
            [0.0, math.cos(first), -math.sin(first)],
            [0.0, math.sin(first), math.cos(first)],
        ]
    )
    about_y = np.array(
        [
            [math.cos(second), 0.0, math.sin(second)],
            [0.0, 1.0, 0.0],
            [-math.sin(second), 0.0, math.cos(second)],
        ]
    )
    assert data.body("bob").xmat.reshape(3, 3) == pytest.approx(about_x @ about_y, abs=1e-9)


HINGE = "<axis><xyz>0 0 1</xyz></axis>"


def test_a_gearbox_has_its_ratio_and_the_motor_feels_the_load_by_its_square(
    tmp_path: Path,
) -> None:
    ratio, load = 5.0, 0.01
    gears = joint(
        "g",
        "gearbox",
        "input",
        "output",
        f"<gearbox_ratio>{ratio}</gearbox_ratio><gearbox_reference_body>base"
        f"</gearbox_reference_body>{HINGE}<axis2><xyz>0 0 1</xyz></axis2>",
    )
    no_rotor = (
        '<joint name="out"><param name="armature">0</param><state_interface name="position"/>'
        '<state_interface name="velocity"/></joint>'
    )
    built = as_robot(
        tmp_path,
        link("base", 1.0),
        link("input", 1.2),
        link("output", 1.4, load),
        joint("stand", "fixed", "world", "base", ""),
        joint("in", "revolute", "base", "input", HINGE),
        joint("out", "revolute", "base", "output", HINGE),
        gears,
        control=control("in", "effort", no_rotor),
    )
    simulation = Simulation(built, control_period_ns=10_000_000)
    torque = 0.2
    for _ in range(50):
        simulation.apply(["in"], effort=[torque])
        simulation.step(10)
    simulation.read()
    speeds = dict(zip(simulation.joint_names, simulation.velocities, strict=True))
    turned = dict(zip(simulation.joint_names, simulation.positions, strict=True))
    assert speeds["in"] == pytest.approx(torque * 0.5 / (MOMENT + ratio**2 * load), rel=0.005)
    assert speeds["out"] == pytest.approx(-ratio * speeds["in"], rel=0.001)
    assert turned["out"] == pytest.approx(-ratio * turned["in"], rel=0.001)


def test_what_follows_a_joint_in_a_world_follows_it(tmp_path: Path) -> None:
    """A falling arm turns another one, whose inertia it feels by the square of the ratio."""
    aside = "<pose>0 0.3 0 0 0 0</pose><axis><xyz>1 0 0</xyz></axis>"
    follows = "<axis><xyz>0 0 1</xyz><mimic joint='j'><multiplier>-2</multiplier></mimic></axis>"
    parts = (
        link("arm", 2.0),
        link("wheel", 2.0),
        joint(
            "j",
            "revolute",
            "world",
            "arm",
            aside,
        ),
        joint("k", "revolute", "world", "wheel", follows),
    )
    simulation = Simulation(in_world(tmp_path, *parts), control_period_ns=1_000_000)
    simulation.step(100)
    found = positions(simulation)
    inertia = MOMENT + MASS * 0.3**2 + 2.0**2 * MOMENT
    turned = MASS * G * 0.3 / inertia * 0.1**2 / 2.0
    assert abs(found["arm_j"]) == pytest.approx(turned, rel=0.03)
    assert found["wheel_k"] == pytest.approx(-2.0 * found["arm_j"], rel=0.001)


def test_a_mimic_of_urdf_holds_in_a_world_too(tmp_path: Path) -> None:
    mimic = '<mimic joint="j" multiplier="0.5" offset="0.1"/>'
    parts = (
        urdf_link("world", ""),
        urdf_link("one"),
        urdf_link("two"),
        urdf_joint("j", "world", "one", kind="continuous", limit="", xyz="0 0 2"),
        urdf_joint("k", "world", "two", kind="continuous", limit="", xyz="1 0 2", content=mimic),
    )
    file = tmp_path / "world.urdf"
    file.write_text(f'<robot name="w">{"".join(parts)}</robot>')
    built = build_model(STILL, world=read_world(file))
    assert built.warnings == ()
    simulation = Simulation(built, control_period_ns=1_000_000)
    simulation.step(2_000)
    found = positions(simulation)
    assert abs(found["j"]) > 0.1
    assert found["k"] == pytest.approx(0.1 + 0.5 * found["j"], abs=2e-3)
