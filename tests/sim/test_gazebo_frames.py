"""Gazebo's services between frames that are turned and move: judged by rigid-body mechanics."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from teleopctl.errors import NotFoundError
from teleopctl.interfaces import get_service
from teleopctl.mujoco_model import NewObject, build_model, with_objects
from teleopctl.robot import read_world_text
from teleopctl.sim.entities.entity import find, move
from teleopctl.sim.entities.running_simulation import RunningSimulation
from teleopctl.sim.gazebo_services import apply_link_wrench, get_entity_state, link_of
from teleopctl.sim.simulation import Simulation
from tests.mujoco_model.test_world import rod
from tests.sim.robots import INERTIAL, box, joint, link

BLOCK = f'<robot name="block">{link("b", INERTIAL + box("collision", "0.2 0.2 0.2"))}</robot>'
CHAIN = (
    f'<robot name="chain">{link("b", INERTIAL)}{link("tip", INERTIAL)}'
    f"{joint('hinge', 'b', 'tip')}</robot>"
)
# A quarter turn to the left: what was ahead is to the left of the world.
LEFT = np.array([0.5**0.5, 0.0, 0.0, 0.5**0.5])
GetEntityState = get_service("gazebo_msgs/srv/GetEntityState")
ApplyLinkWrench = get_service("gazebo_msgs/srv/ApplyLinkWrench")


@pytest.fixture
def simulation() -> Simulation:
    """Two blocks and a chain in the air, without gravity; the first one is turned to the left."""
    made = Simulation(build_model(rod(), fixed_base=True), control_period_ns=10_000_000)
    things = [(BLOCK, "turned", 10.0, LEFT), (BLOCK, "other", 11.0, [1.0, 0, 0, 0])]
    things.append((CHAIN, "chain", 20.0, [1.0, 0, 0, 0]))
    made.replace_model(
        with_objects(
            made.model,
            [
                NewObject(read_world_text(text, name), name, np.array([x, 0, 5.0]), np.array(turn))
                for text, name, x, turn in things
            ],
        )
    )
    made.set_gravity([0.0, 0.0, 0.0])
    return made


def stage_of(simulation: Simulation) -> RunningSimulation:
    """A stage whose simulation stands still."""
    stands = SimpleNamespace(
        simulation=simulation, call=lambda what: what(), call_and_publish=lambda what: what()
    )
    return cast("RunningSimulation", stands)


def complain(words: str) -> None:
    raise AssertionError(words)


# Any: messages, whose classes are made at run time.
def parts(vector: Any) -> list[float]:
    return [vector.x, vector.y, vector.z]


def test_a_state_is_told_as_seen_from_a_frame_that_moves_and_is_turned(
    simulation: Simulation,
) -> None:
    carried = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 2.0])
    move(simulation, find(simulation, "turned"), None, carried)
    response = GetEntityState.Response()
    request = GetEntityState.Request(name="other", reference_frame="turned")
    get_entity_state(stage_of(simulation), request, response, complain)

    # One metre along the world's x is one to the right of who looks along its y.
    assert parts(response.state.pose.position) == pytest.approx([0.0, -1.0, 0.0])
    assert parts(response.state.twist.linear) == pytest.approx([0.0, 1.0, 0.0])
    assert parts(response.state.twist.angular) == pytest.approx([0.0, 0.0, -2.0])


@pytest.mark.parametrize(
    ("frame", "turns", "goes"),
    [("", [0.0, -1.0, 0.0], [1.0, 0.0]), ("turned", [1.0, 0.0, 0.0], [0.0, 1.0])],
)
def test_a_force_acts_at_its_point_of_the_frame_that_is_named(
    simulation: Simulation, frame: str, turns: list[float], goes: list[float]
) -> None:
    """Ahead and upwards, one metre ahead: of the world without a frame, of its own by its own."""
    for field, point in (("z", (1.0, 0.0)), ("x", (0.0, 0.25))):
        simulation.reset_state()
        request = ApplyLinkWrench.Request(link_name="turned", reference_frame=frame)
        setattr(request.wrench.force, field, 1.0)
        # Through the centre of mass, 0.25 m above the origin, a force turns nothing.
        request.reference_point.x, request.reference_point.z = point
        request.duration.sec = -1
        apply_link_wrench(stage_of(simulation), request, ApplyLinkWrench.Response(), complain)
        simulation.step(1)
        response = GetEntityState.Response()
        get_entity_state(
            stage_of(simulation), GetEntityState.Request(name="turned"), response, complain
        )
        angular = np.array(parts(response.state.twist.angular))
        linear = np.array(parts(response.state.twist.linear))
        if field == "z":
            assert angular / np.linalg.norm(angular) == pytest.approx(turns, abs=1e-6)
        else:
            assert angular == pytest.approx(np.zeros(3), abs=1e-9)
            assert linear / np.linalg.norm(linear) == pytest.approx([*goes, 0.0], abs=1e-6)


def test_links_are_known_as_gazebo_scopes_them(simulation: Simulation) -> None:
    for name in ("chain::tip", "chain/tip"):
        assert link_of(simulation, name) == "chain/tip"
    assert link_of(simulation, "chain") == "chain"
    # The only link of a thing, whatever its file called it.
    assert link_of(simulation, "turned::b") == "turned"
    for name in ("chain::none", "none::tip", "turned::b::c"):
        with pytest.raises(NotFoundError, match="there is "):
            link_of(simulation, name)
