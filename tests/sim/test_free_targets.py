"""Where `robot check --simulate` sends joints: where nothing is touched."""

import pytest

from teleopctl.nodes.robot_check.collision_free import free_targets
from teleopctl.nodes.robot_check.stability import check_stability
from teleopctl.sim.building import simulate
from tests.sim.robots import INERTIAL, box, control, joint, link

LIMIT = 'lower="-3" upper="3.1" effort="200" velocity="3"'


def urdf(*more: str) -> str:
    """A bar that lies 0.1 m above the ground and sinks as its joint turns to the farther limit."""
    bar = INERTIAL.replace("0 0 0.25", "0.5 0 0") + box("collision", "1 0.05 0.05", "0.55 0 0")
    parts = [
        link("base", box("collision", "0.1 0.1 0.05", "0 0 0.025")),
        link("bar", bar),
        joint("lift", "base", "bar", xyz="0 0 0.1", axis="0 1 0", limit=LIMIT),
        *more,
    ]
    return f'<robot name="arm">{"".join(parts)}{control(lift="position")}</robot>'


def roof(height: float) -> str:
    return link("roof", box("collision", "1 0.2 0.02", f"0.8 0 {height}")) + joint(
        "posts", "base", "roof", kind="fixed", xyz="0 0 0"
    )


@pytest.mark.parametrize(
    ("more", "targets"),
    [
        # Downwards, to the farther limit, the ground is nearer than a whole step or a half.
        ([], {"lift": -0.2}),
        ([roof(0.24)], {"lift": pytest.approx(-0.1)}),
        ([roof(0.14)], {"lift": pytest.approx(0.05)}),
    ],
)
def test_a_joint_is_sent_where_nothing_is_touched(
    more: list[str], targets: dict[str, float]
) -> None:
    robot = simulate(urdf(*more), control_period_ns=10_000_000)
    before = robot.simulation.positions.copy()
    assert free_targets(robot.simulation, robot.model.joints, 0.2) == targets
    assert robot.simulation.positions.tolist() == before.tolist()


def test_a_joint_that_can_go_nowhere_is_named_and_not_called_unable() -> None:
    lid = [roof(0.139), link("bed", box("collision", "1 0.2 0.02", "0.8 0 0.061"))]
    lid.append(joint("feet", "base", "bed", kind="fixed", xyz="0 0 0"))
    trial = check_stability(simulate(urdf(*lid), control_period_ns=10_000_000), 0.1)
    assert (trial.verdict, trial.moved, trial.unmoved) == ("stands", (), ())
    assert trial.blocked == ("lift",)


def test_a_good_arm_above_the_ground_follows() -> None:
    trial = check_stability(simulate(urdf(), control_period_ns=10_000_000), 0.1)
    assert (trial.moved, trial.unmoved, trial.blocked) == (("lift",), (), ())
