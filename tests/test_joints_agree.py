"""Publishers, control, mock hardware and simulator have the same limits and mimics of joints.

What is right is worked out by the few lines of `Drawn`; where links stand, by MuJoCo.
"""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, strategies as st

from teleopctl.mujoco_model.model import build_model
from teleopctl.robot.description import RobotDescription
from teleopctl.robot.joints import Joints, JointSet
from teleopctl.robot.kinematics import SegmentTree
from teleopctl.sim.simulation import Simulation
from teleopctl.testing import ControlStack
from teleopctl.tf.transforms import IDENTITY
from tests.sim.robots import joint, link

EVERYWHERE = (-math.inf, math.inf)
PERIOD_NS = 50_000_000
MILLISECOND_NS = 1_000_000


@dataclass(frozen=True)
class Drawn:
    """A joint as it is drawn; bands are positions from-to, None where nothing is written."""

    name: str
    parent: str
    kind: str
    leader: str | None
    multiplier: float
    offset: float
    mimic_by_parameters: bool
    mimic_switched_off: bool
    band: tuple[float, float]
    soft: tuple[float, float] | None
    commanded: tuple[float, float] | None
    enabled: bool
    interface_enabled: bool
    initial: float | None
    target: float

    @property
    def follows(self):
        return self.leader is not None and not self.mimic_switched_off

    @property
    def limits(self):
        """The most restrictive of what is written, and nothing where limits are switched off."""
        if not (self.enabled and self.interface_enabled):
            return EVERYWHERE
        own = [self.band, self.soft] if self.kind != "continuous" else []
        if self.kind == "continuous" and self.commanded:
            own = [self.soft]
        bands = [band for band in (*own, self.commanded) if band is not None]
        return max((low for low, _ in bands), default=-math.inf), min(
            (high for _, high in bands), default=math.inf
        )

    def position(self, positions, joints):
        """Where the joint stands, given the independent ones."""
        if not self.follows:
            return positions[self.name]
        return self.multiplier * joints[self.leader].position(positions, joints) + self.offset

    @property
    def urdf(self):
        lower, upper = (-500, 500) if self.follows else self.band
        content = ""
        if self.leader is not None and not self.mimic_by_parameters:
            content += (
                f'<mimic joint="{self.leader}" multiplier="{self.multiplier}" '
                f'offset="{self.offset}"/>'
            )
        if self.soft is not None and not self.follows:
            content += (
                f'<safety_controller soft_lower_limit="{self.soft[0]}" '
                f'soft_upper_limit="{self.soft[1]}" k_velocity="1"/>'
            )
        return link(f"{self.name}_link") + joint(
            self.name,
            self.parent,
            f"{self.name}_link",
            kind=self.kind,
            limit=f'lower="{lower}" upper="{upper}" effort="0" velocity="20"',
            content=content,
        )

    @property
    def control(self):
        attributes = 'mimic="false"' if self.mimic_switched_off else ""
        start = parameter("initial_value", self.initial)
        inside = f'<state_interface name="position">{start}</state_interface>'
        if self.follows and self.mimic_by_parameters:
            inside += parameter("mimic", self.leader) + parameter("multiplier", self.multiplier)
        if not self.follows:
            low, high = self.commanded or (None, None)
            inside += (
                f'<command_interface name="position">{parameter("min", low)}'
                f"{parameter('max', high)}{'' if self.interface_enabled else OFF}"
                f"</command_interface>{'' if self.enabled else OFF}"
            )
        return f'<joint name="{self.name}" {attributes}>{inside}</joint>'


OFF = '<limits enable="false"/>'


def parameter(name, value):
    return "" if value is None else f'<param name="{name}">{value}</param>'


def around(centre):
    """Bands that hold a position, so that any two of them have one in common."""
    side = st.floats(0.05, 1.5)
    return st.builds(
        lambda low, high: (round(centre - low, 3), round(centre + high, 3)), side, side
    )


@st.composite
def robots(draw):
    """Joints on random links, in an order of the file other than that in which they follow."""
    names = [f"j{number}" for number in range(draw(st.integers(2, 6)))]
    joints = []
    for number, name in enumerate(names):
        parents = ["base", *(f"{before}_link" for before in names[:number])]
        leader = draw(st.sampled_from([None, *names[:number]]))
        by_parameters = leader is not None and draw(st.booleans())
        switched_off = leader is not None and not by_parameters and draw(st.booleans())
        centre = draw(st.floats(-0.8, 0.8))
        sign = draw(st.sampled_from([-1, 1]))
        joints.append(
            Drawn(
                name=name,
                parent=draw(st.sampled_from(parents)),
                kind=draw(st.sampled_from(["revolute", "prismatic", "continuous"])),
                leader=leader,
                multiplier=sign * round(draw(st.floats(0.3, 1.5)), 3),
                offset=0.0 if by_parameters else round(draw(st.floats(-0.5, 0.5)), 3),
                mimic_by_parameters=by_parameters,
                mimic_switched_off=switched_off,
                band=draw(around(centre)),
                soft=draw(st.none() | around(centre)),
                commanded=draw(st.none() | around(centre)),
                enabled=draw(st.sampled_from([True, True, False])),
                interface_enabled=draw(st.sampled_from([True, True, False])),
                initial=draw(st.none() | st.just(round(centre, 3))),
                target=draw(st.floats(-2, 2)),
            )
        )
    return draw(st.permutations(joints))


def describe(joints):
    tag = "".join(one.control for one in joints)
    return RobotDescription.from_urdf(
        f'<robot name="r">{link("base", "")}{"".join(one.urdf for one in joints)}'
        f'<ros2_control name="h" type="system"><hardware>'
        f"<plugin>mock_components/GenericSystem</plugin></hardware>{tag}</ros2_control></robot>"
    )


def by_hand(joints, values):
    """Positions of all joints as the mimics say, from those of the independent ones."""
    named = {one.name: one for one in joints}
    return {one.name: one.position(values, named) for one in joints}


def measured(stack, joints):
    return {
        one.name: stack.resources.state_interfaces[f"{one.name}/position"].value for one in joints
    }


def simulated(simulation):
    simulation.read()
    return dict(zip(simulation.joint_names, simulation.positions.tolist(), strict=True))


@given(robots())
def test_publishers_control_mock_hardware_and_simulator_have_the_same_joints(joints):
    description = describe(joints)
    independent = [one for one in joints if not one.follows]
    stack = ControlStack(description.urdf, enforce_limits=True)
    simulation = Simulation(build_model(description, fixed_base=True), control_period_ns=PERIOD_NS)

    # where everything starts
    stack.step()
    start = measured(stack, joints)
    assert start == pytest.approx(by_hand(joints, start), abs=1e-9)
    assert simulated(simulation) == pytest.approx(start, abs=1e-9)
    for one in independent:
        expected = one.initial if one.initial is not None else rest(one.limits)
        assert start[one.name] == pytest.approx(expected, abs=1e-9)
    simulation.step_to(MILLISECOND_NS)
    simulation.read()
    assert np.abs(simulation.velocities).max() < 0.02

    # where everything ends when it is sent somewhere
    targets = {one.name: one.target for one in independent}
    for _ in range(25):
        for name, value in targets.items():
            command = stack.resources.command_interfaces[f"{name}/position"]
            command.owner, command.value = "test", value
        stack.resources.enforce_command_limits(PERIOD_NS * 1e-9)
        stack.step()
        given = [stack.command(f"{name}/position") for name in targets]
        simulation.apply(list(targets), position=given)
        simulation.step(simulation.steps_to_tick)
    reached = {one.name: min(max(one.target, one.limits[0]), one.limits[1]) for one in independent}
    everywhere = by_hand(joints, reached)
    assert measured(stack, joints) == pytest.approx(everywhere, abs=1e-9)
    assert simulated(simulation) == pytest.approx(everywhere, abs=2e-3)

    # what is shown of it
    shown = Joints.for_display(description, pytest.fail)
    links = standing(description, SegmentTree(description, shown), reached)
    for name, translation in links.items():
        assert translation == pytest.approx(simulation.link_pose(name).position, abs=5e-3)
    sliders = JointSet(Joints.of(description))
    assert set(sliders.free) == set(reached)
    sliders.update(reached, reached.values())
    shown_positions = dict(zip(sliders.names, sliders.positions(), strict=True))
    assert shown_positions == pytest.approx(everywhere, abs=1e-9)
    for one in independent:
        slider = sliders.free[one.name]
        lower, upper = one.limits
        assert slider.minimum == (min(-math.pi, upper) if math.isinf(lower) else lower)
        assert slider.maximum == (max(math.pi, lower) if math.isinf(upper) else upper)


def arm(*, limits="", control="", extra_links="", extra_control=""):
    """A joint ``a`` with limits of 1 in the URDF, and more as given."""
    return RobotDescription.from_urdf(
        f'<robot name="r">{link("base", "")}{link("a_link")}'
        + joint("a", "base", "a_link", limit='lower="-1" upper="1" effort="0" velocity="20"')
        + extra_links
        + '<ros2_control name="h" type="system"><hardware>'
        "<plugin>mock_components/GenericSystem</plugin></hardware>"
        f'<joint name="a">{limits}<command_interface name="position">{control}'
        f'</command_interface><state_interface name="position"/></joint>{extra_control}'
        "</ros2_control></robot>"
    )


def sent_to(description, target):
    """Where control lets joint ``a`` go, and where it goes in the simulator without control."""
    stack = ControlStack(description.urdf, enforce_limits=True)
    simulation = Simulation(build_model(description, fixed_base=True), control_period_ns=PERIOD_NS)
    for _ in range(25):
        command = stack.resources.command_interfaces["a/position"]
        command.owner, command.value = "test", target
        stack.resources.enforce_command_limits(PERIOD_NS * 1e-9)
        simulation.apply(["a"], position=[target])
        simulation.step(simulation.steps_to_tick)
    stack.step()
    return stack.resources.state_interfaces["a/position"].value, simulated(simulation)["a"]


def test_limits_of_a_command_interface_hold_in_control_and_those_of_the_urdf_in_simulation():
    narrow = arm(control=parameter("min", -0.2) + parameter("max", 0.2))
    assert sent_to(narrow, 0.9) == pytest.approx((0.2, 0.9), abs=1e-3)
    assert sent_to(narrow, 1.5) == pytest.approx((0.2, 1.0), abs=1e-3)


def test_a_simulated_joint_that_is_sent_by_velocity_stops_at_its_stops():
    narrow = arm(
        limits='<command_interface name="velocity"/>',
        control=parameter("min", -0.2) + parameter("max", 0.2),
    )
    simulation = Simulation(build_model(narrow, fixed_base=True), control_period_ns=PERIOD_NS)
    for _ in range(125):
        simulation.apply(["a"], velocity=[1.0])
        simulation.step(simulation.steps_to_tick)
    assert simulated(simulation)["a"] == pytest.approx(1.0, abs=1e-3)
    assert simulation.take_cut_commands() == []


def wheel(limits, control):
    """A wheel ``a`` that is driven by velocity."""
    return RobotDescription.from_urdf(
        f'<robot name="r">{link("base", "")}{link("a_link")}'
        f'<joint name="a" type="continuous"><parent link="base"/><child link="a_link"/>{limits}'
        '</joint><ros2_control name="h" type="system"><hardware>'
        "<plugin>mock_components/GenericSystem</plugin></hardware>"
        f'<joint name="a"><command_interface name="velocity">{control}</command_interface>'
        '<state_interface name="velocity"/></joint></ros2_control></robot>'
    )


def test_a_simulated_wheel_turns_as_fast_as_control_lets_it():
    """As in Gazebo and on hardware that does not limit: who limits is the controller manager."""
    bounds = parameter("min", -1) + parameter("max", 1)
    description = wheel('<limit effort="30" velocity="2"/>', bounds)
    simulation = Simulation(build_model(description, fixed_base=True), control_period_ns=PERIOD_NS)
    for _ in range(50):
        simulation.apply(["a"], velocity=[6.0])
        simulation.step(simulation.steps_to_tick)
    simulation.read()
    assert simulation.velocities[0] == pytest.approx(6.0, abs=1e-2)
    assert simulation.take_cut_commands() == []


def test_what_a_simulated_joint_cannot_do_is_told_once_with_its_line():
    description = arm(limits='<command_interface name="effort"/>')
    simulation = Simulation(build_model(description, fixed_base=True), control_period_ns=PERIOD_NS)
    for target in (0.5, 1.5, 0.0, 2.0):
        simulation.apply(["a"], position=[target])
        simulation.step(simulation.steps_to_tick)
    line = description.urdf[: description.urdf.index("<limit")].count("\n") + 1
    assert simulation.take_cut_commands() == [
        "Command of joint 'a' is outside its limits: position 1.5 is clamped to 1 (position limits "
        f"[-1, 1], line {line} of the robot description)"
    ]
    assert simulation.take_cut_commands() == []


@pytest.mark.parametrize("where", ["limits", "control"])
def test_limits_that_are_switched_off_hold_neither_in_control_nor_in_simulation(where):
    assert sent_to(arm(**{where: OFF}), 1.5) == pytest.approx((1.5, 1.5), abs=1e-3)


def test_a_chain_of_mimics_starts_together_and_stays_at_rest_in_simulation():
    """c mimics b, b mimics a; c once started at 0 and snapped to its place at 155 rad/s."""
    links = "".join(
        link(f"{name}_link")
        + joint(
            name,
            "base",
            f"{name}_link",
            content=f'<mimic joint="{leader}" multiplier="{multiplier}" offset="{offset}"/>',
        )
        for name, leader, multiplier, offset in (("c", "b", 2.0, 0.5), ("b", "a", -1.0, 0.25))
    )
    states = "".join(
        f'<joint name="{name}"><state_interface name="position"/></joint>' for name in ("c", "b")
    )
    description = arm(extra_links=links, extra_control=states)
    simulation = Simulation(build_model(description, fixed_base=True), control_period_ns=PERIOD_NS)
    assert simulated(simulation) == {"a": 0.0, "b": 0.25, "c": 1.0}
    simulation.step_to(MILLISECOND_NS)
    simulation.read()
    assert np.abs(simulation.velocities).max() < 1e-3
    stack = ControlStack(description.urdf)
    assert {n: stack.resources.state_interfaces[f"{n}/position"].value for n in "abc"} == {
        "a": 0.0,
        "b": 0.25,
        "c": 1.0,
    }


def test_a_joint_that_mimics_a_fixed_one_stands_at_its_offset():
    links = (
        link("tool_link")
        + joint("tool", "base", "tool_link", kind="fixed")
        + link("b_link")
        + joint("b", "base", "b_link", content='<mimic joint="tool" offset="0.25"/>')
    )
    description = arm(extra_links=links)
    simulation = Simulation(build_model(description, fixed_base=True), control_period_ns=PERIOD_NS)
    simulation.step(simulation.steps_to_tick)
    assert simulated(simulation)["b"] == pytest.approx(0.25, abs=1e-3)
    assert JointSet(Joints.of(description)).positions() == [0.0, 0.25]


def rest(limits):
    lower, upper = limits
    return 0.0 if lower <= 0.0 <= upper else (lower + upper) / 2


def standing(description, tree, positions):
    """Where the links are, by the transforms of a message about the independent joints."""
    steps = {segment.joint.child: segment.origin for segment in tree.fixed}
    steps.update((moved.child, step) for moved, step in tree.transforms(positions))
    frames = {description.root: IDENTITY}
    for moved in description.tree:
        frames[moved.child] = frames[moved.parent] @ steps[moved.child]
    return {name: frame.translation for name, frame in frames.items()}
