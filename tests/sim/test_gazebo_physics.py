"""What ``<gazebo>`` says of weight, springs and bases, held against closed forms."""

import math

import pytest

from teleopctl.mujoco_model import RobotModel, build_model
from teleopctl.sim import Simulation
from tests.sim.robots import control, joint, link, model, robot

# Of a rod of `tests.sim.robots`, about its end.
MASS_KG, MIDDLE_M = 0.5, 0.25
INERTIA_ALONG_Z = 0.001
WEIGHT_NM = MASS_KG * 9.81 * MIDDLE_M
DOWN = math.pi / 2


def weightless(*links: str) -> str:
    return "".join(
        f'<gazebo reference="{name}"><gravity>false</gravity></gazebo>' for name in links
    )


def arm(extra: str, effort: float = 20.0) -> RobotModel:
    """Two rods, one behind the other."""
    limit = f'lower="-2" upper="2" effort="{effort}" velocity="3"'
    return model(
        link("base", ""),
        link("rod"),
        link("tip"),
        joint("shoulder", "base", "rod", limit=limit),
        joint("elbow", "rod", "tip", limit=limit),
        control(shoulder="position", elbow="position"),
        extra,
    )


def efforts_when_horizontal(built: RobotModel) -> list[float]:
    simulation = Simulation(built, control_period_ns=10_000_000)
    simulation.reset_state({"shoulder": DOWN})
    simulation.apply(["shoulder", "elbow"], position=[DOWN, 0.0])
    simulation.step_to(1_000_000_000)
    simulation.read()
    assert simulation.positions == pytest.approx([DOWN, 0.0], abs=1e-6)
    return [float(effort) for effort in simulation.efforts]


@pytest.mark.parametrize(
    ("light", "shoulder", "elbow"),
    [
        # The middle of the second rod is three times as far from the shoulder.
        ((), 4.0, 1.0),
        (("tip",), 1.0, 0.0),
        (("rod",), 3.0, 1.0),
        (("rod", "tip"), 0.0, 0.0),
    ],
)
def test_a_drive_carries_what_has_weight_alone(
    light: tuple[str, ...], shoulder: float, elbow: float
) -> None:
    found = efforts_when_horizontal(arm(weightless(*light)))
    assert found == pytest.approx([-shoulder * WEIGHT_NM, -elbow * WEIGHT_NM], abs=1e-6)


def test_a_drive_too_weak_for_a_rods_weight_holds_one_without() -> None:
    assert efforts_when_horizontal(arm(weightless("rod", "tip"), 0.1)) == pytest.approx([0.0, 0.0])


@pytest.mark.parametrize(
    ("tag", "stays"),
    [
        ("<gravity>0</gravity>", True),
        ('<turnGravityOff value="true"/>', True),
        ("<gravity>true</gravity>", False),
    ],
)
@pytest.mark.parametrize("commands", ["", "effort"])
def test_a_loose_rod_without_weight_stays_where_it_is(tag: str, stays: bool, commands: str) -> None:
    parts = [link("base", ""), link("rod"), joint("hinge", "base", "rod")]
    parts += [control(hinge=commands)] if commands else []
    built = model(*parts, f'<gazebo reference="rod">{tag}</gazebo>')
    simulation = Simulation(built, control_period_ns=10_000_000)
    simulation.reset_state({"hinge": 0.5})
    if commands:
        simulation.apply(["hinge"], effort=[0.0])
    simulation.step_to(300_000_000)
    simulation.read()
    assert (simulation.positions[0] == pytest.approx(0.5)) == stays


def test_a_joint_with_a_spring_swings_about_its_rest() -> None:
    stiffness = 2.0
    spring = (
        f'<gazebo reference="hinge"><springStiffness>{stiffness}</springStiffness>'
        "<springReference>0.3</springReference></gazebo>"
    )
    hinge = joint("hinge", "base", "rod", kind="continuous", axis="0 0 1", limit="")
    simulation = Simulation(
        model(link("base", ""), link("rod"), hinge, spring), control_period_ns=1_000_000
    )
    simulation.reset_state({"hinge": 0.5})
    half_s = math.pi * math.sqrt(INERTIA_ALONG_Z / stiffness)
    simulation.step_to(round(half_s * 1e9))
    simulation.read()
    assert simulation.positions[0] == pytest.approx(0.1, abs=2e-3)


def test_a_robot_that_is_static_stands_where_it_is() -> None:
    parts = (link("base"), "<gazebo><static>true</static></gazebo>")
    built = build_model(robot(*parts))
    assert built.base is None
    assert built.world_frame == "base"
    assert build_model(robot(link("base"))).base is not None
