"""Actuators of MJCF files that move two joints together: commands go through a transmission."""

from pathlib import Path

import mujoco
import pytest
from hypothesis import given, strategies as st

from teleopctl.robot import DifferentialTransmission, FourBarLinkageTransmission, read_model
from teleopctl.robot.mjcf.actuators import actuator_pairs
from teleopctl.sim.building import SimulatedRobot, simulate

PERIOD_NS = 10_000_000
# A wrist: lengths of the tendons are 2 bend + turn and 6 bend - 3 turn.
WRIST = """
<mujoco model="wrist">
  <compiler angle="radian"/>
  <option timestep="0.001" gravity="0 0 0" integrator="implicitfast"/>
  <worldbody>
    <body name="hand" pos="0 0 1">
      <joint name="bend" axis="0 1 0" range="-1 1" limited="true" damping="0.1" armature="0.02"/>
      <geom type="box" size="0.05 0.05 0.1" mass="0.2"/>
      <body name="tool" pos="0 0 0.1">
        <joint name="turn" axis="0 0 1" damping="0.1" armature="0.02"/>
        <geom type="box" size="0.05 0.02 0.05" mass="0.1"/>
      </body>
    </body>
  </worldbody>
  <tendon>
    <fixed name="left">{left}</fixed>
    <fixed name="right">{right}</fixed>
  </tendon>
  <actuator>{actuators}</actuator>
</mujoco>
"""
SUM = '<joint joint="bend" coef="2"/><joint joint="turn" coef="1"/>'
DIFFERENCE = '<joint joint="bend" coef="2"/><joint joint="turn" coef="-1"/>'
SERVOS = """
<position name="first" tendon="left" kp="5" kv="0.2"/>
<position name="second" tendon="right" gear="3" kp="5" kv="0.2"/>"""
MIXED = """
<motor name="first" tendon="left"/>
<position name="second" tendon="right" gear="3" kp="5" kv="0.2"/>"""
MOTORS = '<motor name="first" tendon="left"/><motor name="second" tendon="right" gear="3"/>'
LINKAGE = """
<position name="first" joint="bend" gear="4" kp="5" kv="0.2"/>
<position name="second" tendon="left" kp="5" kv="0.2"/>"""


def simulated_wrist(
    folder: Path, actuators: str, right: str = DIFFERENCE, old: str = "", new: str = ""
) -> SimulatedRobot:
    file = folder / "wrist.xml"
    file.write_text(WRIST.format(actuators=actuators, left=SUM, right=right))
    urdf = read_model(str(file), {}).text
    assert old in urdf
    if old:
        urdf = urdf.replace(old, new)
    return simulate(urdf, control_period_ns=PERIOD_NS, warn=lambda _: None)


def go(robot: SimulatedRobot, seconds: float, **commands: float) -> list[float]:
    """Command positions until the joints rest; return the positions of bend and turn."""
    simulation = robot.simulation
    for _ in range(round(seconds * 1e9) // PERIOD_NS):
        simulation.apply(list(commands), position=list(commands.values()))
        simulation.step(simulation.steps_per_period)
    simulation.read()
    return [float(value) for value in simulation.positions]


def test_two_actuators_on_two_tendons_become_a_differential(tmp_path: Path) -> None:
    robot = simulated_wrist(tmp_path, SERVOS)
    (one,) = robot.description.transmissions
    assert one.type == "transmission_interface/DifferentialTransmission"
    assert [end.name for end in (*one.joints, *one.actuators)] == [
        "bend",
        "turn",
        "first",
        "second",
    ]
    assert [end.mechanical_reduction for end in one.joints] == [2.0, 1.0]
    assert [end.mechanical_reduction for end in one.actuators] == [1.0, 3.0]
    assert robot.model.warnings == ()


REDUCTION = st.floats(0.2, 9.0) | st.floats(-9.0, -0.2)


@given(st.tuples(REDUCTION, REDUCTION), st.tuples(REDUCTION, REDUCTION), st.booleans())
def test_lengths_of_the_actuators_are_those_of_the_transmission(
    joint_reductions: tuple[float, float],
    actuator_reductions: tuple[float, float],
    is_differential: bool,
) -> None:
    (m1, m2), (n1, n2) = joint_reductions, actuator_reductions
    kind = DifferentialTransmission if is_differential else FourBarLinkageTransmission
    rows = [[m1, m2], [m1, -m2]] if is_differential else [[m1, 0.0], [1.0, m2]]
    tendons = [
        "".join(
            f'<joint joint="{joint}" coef="{coefficient!r}"/>'
            for joint, coefficient in zip(("bend", "turn"), row, strict=True)
        )
        for row in rows
    ]
    text = WRIST.format(
        actuators=f'<position name="first" tendon="left" gear="{n1!r}"/>'
        f'<position name="second" tendon="right" gear="{n2!r}"/>',
        left=tendons[0],
        right=tendons[1],
    )
    (pair,) = actuator_pairs(mujoco.MjModel.from_xml_string(text))
    assert pair.kind == kind.__name__
    found = kind(pair.actuator_reductions, pair.joint_reductions, (0.0, 0.0))
    wanted = kind((n1, n2), (m1, m2), (0.0, 0.0))
    lengths = wanted.joint_to_actuator("position", (0.3, -0.7))
    assert found.joint_to_actuator("position", (0.3, -0.7)) == pytest.approx(lengths)


def test_joints_go_where_they_are_commanded_through_a_differential(tmp_path: Path) -> None:
    robot = simulated_wrist(tmp_path, SERVOS)
    assert go(robot, 2.0, bend=0.3, turn=-0.2) == pytest.approx([0.3, -0.2], abs=1e-3)
    formulas = DifferentialTransmission([1.0, 3.0], [2.0, 1.0], [0.0, 0.0])
    _, data = robot.simulation.observe()
    lengths = [float(data.actuator(name).length[0]) for name in ("first", "second")]
    assert lengths == pytest.approx(formulas.joint_to_actuator("position", [0.3, -0.2]), abs=5e-3)
    # A joint without a command keeps its own; one beyond its limit goes to the limit.
    assert go(robot, 2.0, turn=0.4) == pytest.approx([0.3, 0.4], abs=1e-3)
    assert go(robot, 2.0, bend=5.0) == pytest.approx([1.0, 0.4], abs=5e-3)


def test_efforts_of_the_joints_are_those_that_are_commanded(tmp_path: Path) -> None:
    simulation = simulated_wrist(tmp_path, MOTORS).simulation
    simulation.apply(["bend", "turn"], effort=[0.05, -0.02])
    simulation.step(1)
    simulation.read()
    assert simulation.efforts == pytest.approx([0.05, -0.02])
    _, data = simulation.observe()
    forces = [float(data.actuator(name).force[0]) for name in ("first", "second")]
    formulas = DifferentialTransmission([1.0, 3.0], [2.0, 1.0], [0.0, 0.0])
    assert forces == pytest.approx(formulas.joint_to_actuator("effort", [0.05, -0.02]))
    simulation.apply(["bend"], effort=[0.05])
    simulation.step(1)
    simulation.read()
    assert simulation.efforts == pytest.approx([0.05, 0.0])
    simulation.hold()
    simulation.step(1)
    simulation.read()
    assert simulation.efforts == pytest.approx([0.0, 0.0])


def test_a_motor_that_follows_another_joint_is_a_four_bar_linkage(tmp_path: Path) -> None:
    robot = simulated_wrist(tmp_path, LINKAGE)
    (one,) = robot.description.transmissions
    assert one.type == "transmission_interface/FourBarLinkageTransmission"
    assert go(robot, 2.0, bend=0.3, turn=-0.2) == pytest.approx([0.3, -0.2], abs=1e-3)
    formulas = FourBarLinkageTransmission([1.0, 2.0], [4.0, 0.5], [0.0, 0.0])
    _, data = robot.simulation.observe()
    lengths = [float(data.actuator(name).length[0]) for name in ("first", "second")]
    assert lengths == pytest.approx(formulas.joint_to_actuator("position", [0.3, -0.2]), abs=5e-3)


def test_the_reductions_of_the_description_are_those_that_are_applied(tmp_path: Path) -> None:
    """As on a robot: where they are not those of the tendons, the joints go elsewhere."""
    reduction = "<mechanical_reduction>{}</mechanical_reduction>"
    right, wrong = reduction.format("2.0"), reduction.format("4.0")
    robot = simulated_wrist(tmp_path, SERVOS, old=right, new=wrong)
    assert go(robot, 2.0, bend=0.3, turn=-0.2) == pytest.approx([0.6, -0.2], abs=1e-3)


def test_a_transmission_may_name_the_joint_of_an_actuator(tmp_path: Path) -> None:
    """As in mujoco_ros2_control: a motor with a rotor of its own, which turns twice as far."""
    file = tmp_path / "geared.xml"
    file.write_text("""
    <mujoco><compiler angle="radian"/><option gravity="0 0 0" integrator="implicitfast"/>
      <worldbody><body name="base">
        <geom size="0.1"/>
        <body><joint name="hinge" damping="0.1"/><geom size="0.1" pos="0 0 1" mass="0.1"/></body>
        <body pos="0 1 0"><joint name="rotor" armature="0.01"/><geom size="0.01"/></body>
      </body></worldbody>
      <equality><joint joint1="rotor" joint2="hinge" polycoef="0 2 0 0 0"/></equality>
      <actuator><position name="servo" joint="rotor" kp="20" kv="1"/></actuator>
    </mujoco>""")
    command, end = '<command_interface name="position"/>', "</ros2_control>"
    urdf = read_model(str(file), {}).text.replace(command, "")
    urdf = urdf.replace('<joint name="hinge">', f'<joint name="hinge">{command}')
    tag = """<transmission name="gear"><plugin>transmission_interface/SimpleTransmission</plugin>
      <actuator name="rotor" role="actuator1"/><joint name="hinge" role="joint1">
      <mechanical_reduction>2</mechanical_reduction></joint></transmission>"""
    robot = simulate(urdf.replace(end, tag + end), control_period_ns=PERIOD_NS, warn=lambda _: None)
    assert robot.model.warnings == ()
    assert robot.simulation.joint_names == ("hinge", "rotor")
    assert go(robot, 3.0, hinge=0.3) == pytest.approx([0.3, 0.6], abs=2e-3)


def test_actuators_that_the_file_does_not_have_are_named(tmp_path: Path) -> None:
    robot = simulated_wrist(
        tmp_path, SERVOS, old='actuator name="first"', new='actuator name="other"'
    )
    assert any(
        "Transmission 'first_second'" in text
        and "has no effect: the file has no position, velocity or motor actuator 'other'" in text
        for text in robot.model.warnings
    )


@pytest.mark.parametrize(
    ("actuators", "right"),
    [
        (SERVOS, '<joint joint="bend" coef="1"/><joint joint="turn" coef="1"/>'),
        (SERVOS + '<velocity name="third" joint="turn" kv="1"/>', DIFFERENCE),
        (
            SERVOS.replace("position name", "motor name", 1).replace(' kp="5" kv="0.2"', "", 1),
            DIFFERENCE,
        ),
    ],
    ids=["neither", "a third actuator", "different kinds"],
)
def test_other_pairs_of_actuators_keep_their_controls_and_are_named(
    tmp_path: Path, actuators: str, right: str
) -> None:
    robot = simulated_wrist(tmp_path, actuators, right)
    assert robot.description.transmissions == ()
    keep = [text for text in robot.model.warnings if "does not move a single joint" in text]
    assert len(keep) == 2
