"""Search of a path: checks of both ends, the way out of a collision, planners by their names."""

import math

import numpy as np
import pytest

from teleopctl.errors import UnsupportedError, UsageError
from teleopctl.kinematics import (
    ClearanceChecker,
    GroupKinematics,
    KinematicModel,
    MoveItErrorCode,
    PlanningError,
    find_groups,
)
from teleopctl.kinematics.motion import planner_names as planners
from teleopctl.kinematics.motion.edges import EdgeChecker
from teleopctl.kinematics.motion.planner import Query, search_bounds
from teleopctl.kinematics.motion.planner_names import choose_planner, planner_names
from teleopctl.kinematics.motion.search import find_path
from teleopctl.kinematics.motion.shortcut import path_length, shorten
from teleopctl.kinematics.motion.tree_planner import TreePlanner
from teleopctl.robot import RobotDescription, read_world_text
from tests.kinematics.arms import SEVEN, THREE, arm, arm_urdf
from tests.kinematics.motion.scenes import SHELF, TABLE, deepest, queries, scene
from tests.samples import sample

needs_ompl = pytest.mark.skipif(not planners.has_ompl(), reason="OMPL is not installed")
LIBRARIES = ["teleopctl", pytest.param("ompl", marks=needs_ompl)]
UP = np.zeros(7)
# Upright, the arm is free; leaning forward by this, its upper half is in the table.
INTO_TABLE = np.array([0.0, 1.65, 0.0, 0.0, 0.0, 0.0, 0.0])


@pytest.fixture(scope="module")
def shelf():
    return scene(SHELF)


@pytest.fixture(scope="module")
def table():
    return scene(TABLE)


def hard_query(kinematics, clearance):
    """Return a start and a goal in the shelf whose straight motion touches it."""
    edges = EdgeChecker(kinematics, clearance)
    for start, goal in queries(kinematics, clearance, SHELF, 20):
        if not edges.is_edge_free(start, goal):
            return start, goal
    raise AssertionError


def own(edges, start, *goals, **options):
    return find_path(edges, TreePlanner(), start, np.array(goals), **options)


@pytest.mark.parametrize("library", LIBRARIES)
def test_a_path_out_of_a_shelf_touches_nothing(shelf, library):
    kinematics, clearance = shelf
    start, goal = hard_query(kinematics, clearance)
    planner, notes = choose_planner(library=library)
    found = find_path(EdgeChecker(kinematics, clearance), planner, start, goal[None])
    assert notes == found.notes == ()
    assert found.planner == planner.text
    assert found.corners[[0, -1]] == pytest.approx(np.array([start, goal]))
    assert deepest(kinematics, clearance, found.corners) == math.inf


@pytest.mark.parametrize("library", LIBRARIES)
def test_the_same_seed_gives_the_same_path(shelf, library):
    kinematics, clearance = shelf
    start, goal = hard_query(kinematics, clearance)
    planner, _ = choose_planner(library=library)
    paths = [
        find_path(EdgeChecker(kinematics, clearance), planner, start, goal[None], seed=seed).corners
        for seed in (4, 4, 5)
    ]
    assert np.array_equal(paths[0], paths[1])
    assert not np.array_equal(paths[0], paths[2])


def test_a_free_straight_motion_needs_no_planner(table):
    kinematics, clearance = table
    found = own(EdgeChecker(kinematics, clearance), UP, np.full(7, 0.3))
    assert found.planner == "straight"
    assert len(found.corners) == 2


def test_of_several_goals_one_that_is_free_is_reached(table):
    kinematics, clearance = table
    found = own(EdgeChecker(kinematics, clearance), UP, INTO_TABLE, np.full(7, 0.2))
    assert found.corners[-1] == pytest.approx(np.full(7, 0.2))


def test_shortening_keeps_the_ends_and_touches_nothing(shelf):
    kinematics, clearance = shelf
    edges = EdgeChecker(kinematics, clearance)
    path = own(edges, *hard_query(kinematics, clearance)).corners
    shorter = shorten(edges, path, seed=1)
    assert shorter[[0, -1]] == pytest.approx(path[[0, -1]])
    assert path_length(shorter) < path_length(path)
    assert deepest(kinematics, clearance, shorter) == math.inf
    assert np.array_equal(shorter, shorten(edges, path, seed=1))


def test_a_detour_in_free_space_is_cut_to_a_straight_motion():
    edges = EdgeChecker(arm(SEVEN))
    detour = np.array([UP, UP + 1.0, UP - 1.0, UP + 0.1])
    assert shorten(edges, detour) == pytest.approx(detour[[0, -1]])


# --- what cannot be done ----------------------------------------------------------------------


def test_a_goal_in_collision_names_the_bodies(table):
    kinematics, clearance = table
    with pytest.raises(PlanningError, match=r"The goal is in collision: .*'table'") as caught:
        own(EdgeChecker(kinematics, clearance), UP, INTO_TABLE)
    assert caught.value.code is MoveItErrorCode.GOAL_IN_COLLISION


def test_a_start_deep_in_an_obstacle_names_the_bodies(table):
    kinematics, clearance = table
    with pytest.raises(PlanningError, match=r"The start is in collision: .*'table'") as caught:
        own(EdgeChecker(kinematics, clearance), INTO_TABLE, UP)
    assert caught.value.code is MoveItErrorCode.START_STATE_IN_COLLISION


def test_a_start_that_just_touches_is_left_by_moving_apart(table):
    kinematics, clearance = table
    edges = EdgeChecker(kinematics, clearance)
    free = edges.free_part(UP, INTO_TABLE)
    touching = (free + 0.01) * INTO_TABLE
    kinematics.set(touching)
    overlap = clearance.collisions()[0].distance_m
    assert overlap < 0.0
    found = own(edges, touching, UP)
    assert found.first >= 1
    assert "moving them apart" in found.notes[0]
    way = found.corners[: found.first + 1]
    distances = []
    for part in np.linspace(0.0, 1.0, 9):
        kinematics.set(way[0] + part * (way[-1] - way[0]))
        distances.append(clearance.near(0.05)[0].distance_m)
    assert (np.diff(distances) > 0.0).all()
    assert np.abs(way[-1] - way[0]).max() < 0.1
    assert deepest(kinematics, clearance, found.corners[found.first :]) == math.inf


def test_an_enclosed_goal_is_given_up_in_time():
    # A condition that walls a joint off.
    edges = EdgeChecker(arm(THREE), condition=lambda q: not 0.4 < q[0] < 0.6)
    with pytest.raises(PlanningError, match=r"found no path within 0\.2 s") as caught:
        own(edges, np.zeros(3), np.full(3, 0.9), timeout_s=0.2)
    assert caught.value.code is MoveItErrorCode.TIMED_OUT


def test_ends_that_break_the_condition_have_codes_of_their_own():
    edges = EdgeChecker(arm(THREE), condition=lambda q: q[0] >= 0.0)
    inside, outside = np.zeros(3), np.full(3, -0.5)
    with pytest.raises(PlanningError) as caught:
        own(edges, inside, outside)
    assert caught.value.code is MoveItErrorCode.GOAL_VIOLATES_PATH_CONSTRAINTS
    with pytest.raises(PlanningError) as caught:
        own(edges, outside, inside)
    assert caught.value.code is MoveItErrorCode.START_STATE_VIOLATES_PATH_CONSTRAINTS


def test_a_goal_outside_of_the_limits_names_the_joint():
    with pytest.raises(PlanningError, match=r"'joint_2' is 2.7, outside .*\[-2.6, 2.6\]") as caught:
        own(EdgeChecker(arm(THREE)), np.zeros(3), np.array([0.0, 2.7, 0.0]))
    assert caught.value.code is MoveItErrorCode.GOAL_STATE_INVALID


def test_a_start_a_hair_outside_goes_back_and_one_far_outside_is_refused():
    edges = EdgeChecker(arm(THREE))
    found = own(edges, np.array([0.0, 2.62, 0.0]), np.zeros(3))
    assert found.corners[:2, 1] == pytest.approx([2.62, 2.6])
    assert "outside the limits of 'joint_2'" in found.notes[0]
    with pytest.raises(PlanningError, match=r"'joint_2' starts at 2\.8") as caught:
        own(edges, np.array([0.0, 2.8, 0.0]), np.zeros(3))
    assert caught.value.code is MoveItErrorCode.START_STATE_INVALID


def continuous_arm():
    text = arm_urdf(THREE).replace('"joint_1" type="revolute"', '"joint_1" type="continuous"')
    description = RobotDescription.from_urdf(text)
    return GroupKinematics(KinematicModel(description), find_groups(description).group())


def test_a_continuous_joint_goes_the_shorter_way_round():
    edges = EdgeChecker(continuous_arm())
    found = own(edges, np.array([3.0, 0, 0]), np.array([-3.0, 0, 0]))
    assert found.corners[:, 0] == pytest.approx([3.0, 2.0 * math.pi - 3.0])


def test_a_continuous_joint_goes_the_other_way_round_where_something_is_in_the_shorter_one():
    edges = EdgeChecker(
        continuous_arm(), condition=lambda q: abs(math.remainder(q[0], 2.0 * math.pi)) < 3.1
    )
    found = own(edges, np.array([3.0, 0, 0]), np.array([-3.0, 0, 0]))
    assert found.corners[-1, 0] == pytest.approx(-3.0)


# --- planners by name -------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name", ["", "RRTConnect", "rrtconnect", "RRTConnectkConfigDefault", "geometric::RRTConnect"]
)
def test_planners_are_known_by_the_names_of_ompl_and_of_moveits_configurations(name):
    planner, notes = choose_planner(name)
    assert planner.name == "RRTConnect"
    assert notes == ()


def test_a_planner_that_is_not_there_is_replaced_and_that_is_said(monkeypatch):
    monkeypatch.setattr(planners, "has_ompl", lambda: False)
    planner, notes = choose_planner("PRMkConfigDefault")
    assert planner.text == "teleopctl RRTConnect"
    assert notes == ("Without OMPL there is no PRM: RRTConnect is used",)
    assert planner_names() == ("RRTConnect",)


@needs_ompl
def test_a_planner_that_the_python_package_lacks_is_replaced_and_that_is_said():
    planner, notes = choose_planner("BiTRRT")
    assert planner.text == "OMPL RRTConnect"
    assert notes == ("OMPL's Python package has no BiTRRT: RRTConnect is used",)


def test_unknown_planners_and_libraries_are_refused(monkeypatch):
    with pytest.raises(UsageError, match="no planner 'RRTConect'") as caught:
        choose_planner("RRTConect")
    assert caught.value.hint == "Did you mean RRTConnect?"
    with pytest.raises(UsageError, match="no library of planners 'chomp'"):
        choose_planner(library="chomp")
    monkeypatch.setattr(planners, "has_ompl", lambda: False)
    with pytest.raises(UnsupportedError, match="OMPL is not installed"):
        choose_planner(library="ompl")


@pytest.mark.parametrize("library", LIBRARIES)
def test_parameters_of_planners_are_set_by_ompls_names_and_unknown_ones_refused(shelf, library):
    kinematics, clearance = shelf
    start, goal = hard_query(kinematics, clearance)
    planner, _ = choose_planner(library=library)
    edges = EdgeChecker(kinematics, clearance)
    short, long = (
        find_path(edges, planner, start, goal[None], parameters={"range": text}).corners
        for text in ("0.3", "3")
    )
    steps = np.linalg.norm(np.diff(short, axis=0), axis=1)
    assert steps.max() <= 0.3 + 1e-9
    assert np.linalg.norm(np.diff(long, axis=0), axis=1).max() > 0.3
    for parameters in ({"rnage": "1"}, {"range": "far"}):
        with pytest.raises(UsageError, match=next(iter(parameters))):
            find_path(edges, planner, start, goal[None], parameters=parameters)


def test_the_parameters_of_planners_have_ompls_names():
    assert TreePlanner().parameters == ("range",)
    if planners.has_ompl():
        assert choose_planner("KPIECE1")[0].parameters == (
            "border_fraction",
            "failed_expansion_cell_score_factor",
            "goal_bias",
            "min_valid_path_fraction",
            "range",
        )


# Those that go on to improve their path take all the time that they are given.
ANYTIME = {"AORRTC", "BITstar", "InformedRRTstar", "PRMstar", "RRTstar", "SORRTstar"}


@needs_ompl
@pytest.mark.parametrize(
    "name",
    sample(
        [
            pytest.param(name, marks=[pytest.mark.nightly] * (name in ANYTIME - {"RRTstar"}))
            for name in planners.OMPL_PLANNERS
        ],
        3,
    ),
)
def test_each_planner_of_ompl_finds_a_path(name):
    # Two joints past a wall that leaves a gap.
    edges = EdgeChecker(arm(THREE), condition=lambda q: not (0.2 < q[0] < 0.4 and q[1] < 1.0))
    planner, _ = choose_planner(name)
    start, goal = np.array([-1.0, 0.0, 0.0]), np.array([1.5, 0.0, 0.0])
    found = find_path(edges, planner, start, goal[None], timeout_s=0.5 if name in ANYTIME else 20.0)
    assert found.planner == f"OMPL {name}"
    assert edges.touch_on_curve(found.corners) is None


def test_the_ground_of_a_world_is_an_obstacle():
    world = read_world_text(
        "things: {post: {shape: box, size: [0.1, 0.1, 1], at: [0, 2, 0.5]}}", "w.yaml"
    )
    description = RobotDescription.from_urdf(arm_urdf(SEVEN))
    model = KinematicModel(description, world)
    kinematics = GroupKinematics(model, find_groups(description).group())
    with pytest.raises(PlanningError, match="in collision"):
        own(
            EdgeChecker(kinematics, ClearanceChecker(model)),
            UP,
            1.4 * INTO_TABLE,
        )


class Countdown:
    """Whether a search shall end: after a number of states."""

    def __init__(self, states: int) -> None:
        self.left = states

    def __call__(self) -> bool:
        self.left -= 1
        return self.left < 0


@pytest.mark.parametrize(
    ("name", "library"),
    [
        ("RRTConnect", "teleopctl"),
        pytest.param("RRTstar", "ompl", marks=needs_ompl),
        # A planner with a thread of its own.
        pytest.param("PRMstar", "ompl", marks=needs_ompl),
    ],
)
def test_a_canceled_search_ends_at_the_next_state(table, name, library):
    kinematics, clearance = table
    countdown = Countdown(60)
    edges = EdgeChecker(kinematics, clearance, lambda at: abs(at[0]) > 0.3, is_canceled=countdown)
    left, right = UP.copy(), UP.copy()
    left[0], right[0] = 1.0, -1.0
    planner, _ = choose_planner(name, library)
    with pytest.raises(PlanningError, match="canceled") as caught:
        find_path(edges, planner, left, right[None, :])
    assert caught.value.code is MoveItErrorCode.PREEMPTED
    assert countdown.left == -1


@needs_ompl
def test_ctrl_c_in_a_check_of_ompl_ends_the_search(table):
    def interrupted(_: np.ndarray) -> bool:
        raise KeyboardInterrupt

    edges = EdgeChecker(table[0], table[1], interrupted)
    goal = UP + 0.1
    bounds = search_bounds(edges, np.vstack((UP, goal)))
    planner, _ = choose_planner("", "ompl")
    with pytest.raises(KeyboardInterrupt):
        planner.search(edges, Query(UP, goal[None, :], *bounds, 5.0, 0, {}))
