"""Links of one robot that overlap at the start."""

import pytest

from teleopctl.mujoco_model.model import RobotModel
from teleopctl.sim.simulation import Simulation
from tests.sim.robots import INERTIAL, box, control, joint, link, model

PERIOD_NS = 10_000_000
LIMIT = 'lower="-1" upper="1" effort="20" velocity="2"'
SHAPE = INERTIAL + box("collision", "0.2 0.2 0.2")


def sliders(**starts: float) -> RobotModel:
    """Cubes of 0.2 m that slide along x, each from where it starts; beside them one stays at 0."""
    parts = [link("base", "")]
    for name, start in starts.items():
        parts += [
            link(name, SHAPE),
            joint(
                f"{name}_slide", "base", name,
                kind="prismatic", xyz=f"{start} 0 0.5", axis="1 0 0", limit=LIMIT,
            ),
        ]  # fmt: skip
    # Held by a drive of its own: what one drive alone moves against each other never touches.
    parts += [
        link("post", SHAPE),
        joint("held", "base", "post", kind="prismatic", axis="0 1 0", limit=LIMIT),
    ]
    names = [*(f"{name}_slide" for name in starts), "held"]
    return model(*parts, control(**dict.fromkeys(names, "position")))


def move(simulation: Simulation, seconds: float, **positions: float) -> None:
    for _ in range(round(seconds * 1e9 / PERIOD_NS)):
        simulation.apply(list(positions), position=list(positions.values()))
        simulation.step(simulation.steps_to_tick)
    simulation.read()


def test_links_that_overlap_at_the_start_stay_where_they_are() -> None:
    simulation = Simulation(sliders(near=0.1), control_period_ns=PERIOD_NS)
    move(simulation, 1.0, near_slide=0.0)

    assert simulation.positions[:-1] == pytest.approx([0.0], abs=1e-9)
    assert simulation.efforts[:-1] == pytest.approx([0.0], abs=1e-6)


def test_once_they_have_come_apart_they_touch() -> None:
    simulation = Simulation(sliders(near=0.1), control_period_ns=PERIOD_NS)
    move(simulation, 1.0, near_slide=0.3)
    assert simulation.positions[:-1] == pytest.approx([0.3], abs=1e-3)
    move(simulation, 2.0, near_slide=0.0)

    # Its face meets the other's when it has come back to 0.2 m.
    assert simulation.positions[:-1] == pytest.approx([0.1], abs=2e-3)
    assert simulation.efforts[:-1] == pytest.approx([-20.0], abs=0.1), "it pushes"


def test_a_reset_begins_anew() -> None:
    simulation = Simulation(sliders(near=0.1), control_period_ns=PERIOD_NS)
    for _ in range(2):
        move(simulation, 1.0, near_slide=0.3)
        move(simulation, 1.0, near_slide=0.0)
        assert simulation.positions[:-1] == pytest.approx([0.1], abs=2e-3)
        simulation.reset_state()
        move(simulation, 0.5, near_slide=0.0)
        assert simulation.positions[:-1] == pytest.approx([0.0], abs=1e-9)


def test_each_pair_waits_for_itself() -> None:
    simulation = Simulation(sliders(near=0.1, far=0.15), control_period_ns=PERIOD_NS)
    assert len(simulation.model.excluded) == 3
    # The far one leaves both others; the near one goes on overlapping the post.
    move(simulation, 1.0, near_slide=0.05, far_slide=0.4)
    assert simulation.positions[:-1] == pytest.approx([0.05, 0.4], abs=1e-3)
    move(simulation, 2.0, near_slide=0.05, far_slide=0.1)
    near, far, _ = simulation.positions

    assert near < 0.09, "it goes on passing through the post"
    assert far + 0.15 - (near + 0.1) == pytest.approx(0.2, abs=2e-3)


def test_shapes_that_never_part_never_touch() -> None:
    simulation = Simulation(sliders(near=0.05), control_period_ns=PERIOD_NS)
    for target in (0.1, -0.1, 0.0):
        move(simulation, 0.5, near_slide=target)
        assert simulation.positions[:-1] == pytest.approx([target], abs=1e-3)
    assert simulation.efforts[:-1] == pytest.approx([0.0], abs=0.01)


def test_who_looks_does_not_change_when_they_touch() -> None:
    ends = []
    for look in (False, True):
        simulation = Simulation(sliders(near=0.1), control_period_ns=PERIOD_NS)
        for target in (0.12, 0.0):
            for _ in range(500):
                simulation.apply(["near_slide"], position=[target])
                simulation.step(simulation.steps_to_tick)
                if look:
                    simulation.link_pose("near")
                    simulation.observe()
        simulation.read()
        ends.append(simulation.positions.tobytes())
    assert ends[0] == ends[1]


@pytest.mark.parametrize("follows", [True, False])
def test_the_fingers_of_a_gripper_close_as_far_as_they_were(follows: bool) -> None:
    """Their meshes' stand-ins overlap, as of the arm of many tutorials; one drive moves both."""
    fingers = [link("palm", ""), link("left", SHAPE), link("right", SHAPE)]
    mimic = '<mimic joint="open" multiplier="-1"/>' if follows else ""
    for name, finger, content in (("open", "left", ""), ("other", "right", mimic)):
        fingers.append(
            joint(
                name, "palm", finger,
                kind="prismatic", axis="1 0 0", limit=LIMIT, content=content,
            )
        )  # fmt: skip
    commands = {"open": "position"} if follows else {"open": "position", "other": "position"}
    gripper = model(*fingers, control(**commands))
    simulation = Simulation(gripper, control_period_ns=PERIOD_NS)
    move(simulation, 1.0, open=0.3)
    move(simulation, 2.0, open=0.0)

    told = "'left' and 'right' overlap at the start: they do not collide"
    assert (told in gripper.warnings) is follows
    if follows:
        assert simulation.positions[0] == pytest.approx(0.0, abs=2e-3)
    else:
        assert simulation.positions[0] > 0.05, "the other finger is in its way"
