"""Edges of a search: no step is so long that bodies could touch within it."""

from itertools import pairwise

import mujoco
import numpy as np
import pytest
from hypothesis import given, strategies as st

from teleopctl.kinematics import ClearanceChecker, GroupKinematics, KinematicModel, find_groups
from teleopctl.kinematics.motion.edges import LEAST_M, EdgeChecker
from teleopctl.robot import RobotDescription, read_world_text
from tests.kinematics.arms import FIVE, SEVEN, arm, arm_urdf
from tests.kinematics.motion.scenes import SHELF, TABLE, deepest, scene

# A slide on the third link, with a finger that mimics it with twice its motion, off the axis.
SLIDE = """
<link name="slider"><collision><geometry><box size="0.05 0.02 0.3"/></geometry></collision></link>
<joint name="slide" type="prismatic"><parent link="link_3"/><child link="slider"/>
 <origin xyz="0.1 0 0.3" rpy="0.3 0.2 0.1"/><axis xyz="1 0 0"/>
 <limit lower="0" upper="0.2" velocity="1" effort="10"/></joint>
<link name="finger"><collision><geometry><sphere radius="0.02"/></geometry></collision></link>
<joint name="mimic" type="revolute"><parent link="slider"/><child link="finger"/>
 <origin xyz="0 0.05 0.2"/><axis xyz="0 0 1"/><mimic joint="slide" multiplier="2"/>
 <limit lower="-3" upper="3" velocity="1" effort="10"/></joint>
"""


@pytest.fixture(scope="module")
def shelf():
    return scene(SHELF)


@pytest.fixture(scope="module")
def odd():
    """Kinematics of an arm with a slide, a mimic joint and turned axes."""
    description = RobotDescription.from_urdf(arm_urdf(FIVE, extra=SLIDE))
    model = KinematicModel(description)
    group = find_groups(description).group()
    whole = type(group)(group.name, (*group.joints[:3], "slide", "mimic"), group.base, "finger")
    return GroupKinematics(model, whole)


def free_states(kinematics, clearance, count, seed=0):
    edges = EdgeChecker(kinematics, clearance)
    generator = np.random.default_rng(seed)
    states = (kinematics.random(generator) for _ in range(1000))
    free = [positions for positions in states if edges.is_free(positions)]
    return free[:count]


def test_a_free_edge_touches_nothing_each_0_002_rad(shelf):
    kinematics, clearance = shelf
    edges = EdgeChecker(kinematics, clearance)
    states = free_states(kinematics, clearance, 7)
    checked = [(start, end) for start, end in pairwise(states) if edges.is_edge_free(start, end)]
    assert checked
    for start, end in checked:
        assert deepest(kinematics, clearance, np.array([start, end])) == np.inf


def test_an_edge_that_touches_is_refused_and_its_free_part_ends_before_the_touch(shelf):
    kinematics, clearance = shelf
    edges = EdgeChecker(kinematics, clearance)
    states = free_states(kinematics, clearance, 30)
    blocked = [
        (start, end)
        for start, end in pairwise(states)
        if deepest(kinematics, clearance, start + np.linspace(0, 1, 60)[:, None] * (end - start))
        < -0.01
    ][:4]
    assert blocked
    for start, end in blocked:
        assert not edges.is_edge_free(start, end)
        part = edges.free_part(start, end)
        assert 0.0 <= part < 1.0
        reached = start + part * (end - start)
        assert deepest(kinematics, clearance, np.array([start, reached])) == np.inf
        beyond = reached + 0.02 * (end - start) / np.abs(end - start).max()
        assert edges.touch_on_curve(np.linspace(reached, beyond, 20)) is not None


def test_clear_space_is_crossed_in_few_steps(shelf):
    kinematics, _ = shelf
    edges = EdgeChecker(kinematics, ClearanceChecker(arm(SEVEN).model))
    assert edges.is_edge_free(np.zeros(7), np.full(7, 0.3))
    crossed = edges.states
    steps_of_0_002_rad = 0.3 / 0.002
    assert crossed < 0.2 * steps_of_0_002_rad


@given(st.integers(0, 10_000))
def test_no_point_moves_farther_than_its_bound(odd, seed):
    generator = np.random.default_rng(seed)
    start, end = odd.random(generator), odd.random(generator)
    edges = EdgeChecker(odd)
    model, data = odd.model.mj_model, odd.model.mj_data
    geoms = np.flatnonzero(model.geom_contype)
    odd.set(start)
    before = {geom: (data.geom_xpos[geom].copy(), data.geom_xmat[geom].copy()) for geom in geoms}
    odd.set(end)
    for geom in geoms:
        radius = model.geom_rbound[geom] * 0.5
        (at, turn), row = before[geom], edges._rows[model.geom_bodyid[geom]]
        for corner in radius * np.vstack((np.eye(3), -np.eye(3))):
            old = at + turn.reshape(3, 3) @ corner
            new = data.geom_xpos[geom] + data.geom_xmat[geom].reshape(3, 3) @ corner
            bound = edges._reach[row, 0] @ np.abs(end - start)
            assert np.linalg.norm(new - old) <= bound + 1e-9


def test_bodies_that_no_joint_moves_apart_do_not_matter():
    # The cube lies on the ground, and in it by a hair, as after a simulation.
    world = read_world_text(
        "things: {cube: {shape: box, size: [0.1, 0.1, 0.1], at: [2, 0, 0.0499], mass: 1}}", "w.yaml"
    )
    model = KinematicModel(RobotDescription.from_urdf(arm_urdf(SEVEN)), world)
    clearance = ClearanceChecker(model)
    kinematics = GroupKinematics(model, find_groups(model.description).group())
    assert clearance.collisions()
    edges = EdgeChecker(kinematics, clearance)
    assert edges.is_free(np.zeros(7))
    assert edges.is_edge_free(np.zeros(7), np.full(7, 0.2))


def test_a_state_nearer_than_a_millimetre_is_not_free_unless_the_motion_begins_there():
    kinematics, clearance = scene(TABLE)
    edges = EdgeChecker(kinematics, clearance)
    # The arm leans forward until it is over the table.
    down = np.array([0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    near = edges.free_part(np.zeros(7), down) * down
    kinematics.set(near)
    gap = clearance.near(0.05)[0].distance_m
    assert LEAST_M < gap < 0.01
    edges.least_m = 2.0 * gap
    assert not edges.is_free(near)
    edges.loosen(near)
    assert edges.is_free(near)


def test_a_condition_holds_along_the_whole_edge():
    kinematics = arm(SEVEN)
    edges = EdgeChecker(kinematics, condition=lambda positions: bool(abs(positions[0]) > 0.05))
    start, end = np.full(7, -0.5), np.full(7, 0.5)
    assert edges.is_free(start)
    assert edges.is_free(end)
    assert not edges.is_edge_free(start, end)
    assert not edges.is_free(np.zeros(7))


def test_the_check_leaves_no_margin_of_the_model_behind(shelf):
    kinematics, clearance = shelf
    EdgeChecker(kinematics, clearance).is_free(np.zeros(7))
    kinematics.set(np.zeros(7))
    assert all(one.distance_m <= 0.0 for one in clearance.collisions())
    mujoco.mj_forward(kinematics.model.mj_model, kinematics.model.mj_data)
