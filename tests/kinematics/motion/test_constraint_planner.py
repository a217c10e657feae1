"""Paths on which a constraint is kept, too narrow to be met by sampling."""

import numpy as np
import pytest

from teleopctl.kinematics import (
    GroupKinematics,
    IkSolver,
    MotionSettings,
    MoveItErrorCode,
    PlanningError,
    plan_to_joints,
)
from tests.kinematics.motion.scenes import TABLE, deepest, scene


class Upright:
    """Constraint that the tool's z axis keeps its direction, within an angle about x and y, rad."""

    def __init__(self, kinematics: GroupKinematics, start: np.ndarray, tolerance: float) -> None:
        self._kinematics, self._tolerance = kinematics, tolerance
        kinematics.set(start)
        self._rotation = kinematics.pose()[:3, :3]

    def angles(self, positions: np.ndarray) -> np.ndarray:
        self._kinematics.set(positions)
        x, y, z = self._rotation.T @ self._kinematics.pose()[:3, 2]
        return np.asarray(np.arctan2([-y, x], z))

    def __call__(self, positions: np.ndarray) -> bool:
        return bool((np.abs(self.angles(positions)) <= self._tolerance).all())

    def residual(self, positions: np.ndarray) -> np.ndarray:
        angles, most = self.angles(positions), 0.6 * self._tolerance
        return np.asarray(angles - np.clip(angles, -most, most))


def query(kinematics, clearance, tolerance):
    """Return a start, a goal with the same rotation, and the constraint; none is met between."""
    random = np.random.default_rng(3)
    while True:
        start = kinematics.random(random)
        upright = Upright(kinematics, start, tolerance)
        target = kinematics.pose()
        target[:3, 3] += random.uniform(-0.4, 0.4, 3)
        if clearance.collisions():
            continue
        found = IkSolver(kinematics, clearance=clearance).solve(target, start)
        if found.is_reached and upright(found.positions):
            middle = 0.5 * (start + found.positions)
            if not upright(middle):
                return start, found.positions, upright


@pytest.mark.parametrize("tolerance", [0.1, 0.01])
def test_a_narrow_constraint_is_kept_on_all_of_a_path_that_touches_nothing(tolerance):
    kinematics, clearance = scene(TABLE)
    start, goal, upright = query(kinematics, clearance, tolerance)
    plan = plan_to_joints(
        kinematics,
        start,
        goal,
        clearance=clearance,
        condition=upright,
        settings=MotionSettings(planner="RRTstar", timeout_s=10.0),
    )
    assert plan.planner == "teleopctl CBiRRT"
    assert "keeps the path's constraints, not " in plan.notes[0]
    assert plan.positions[-1] == pytest.approx(goal, abs=1e-6)
    angles = np.array([upright.angles(at) for at in plan.positions])
    assert np.abs(angles).max() < tolerance + 1e-4
    assert deepest(kinematics, clearance, plan.positions) > 0.0


def test_a_canceled_search_ends():
    kinematics, clearance = scene(TABLE)
    start, goal, upright = query(kinematics, clearance, 0.01)
    with pytest.raises(PlanningError, match="canceled") as caught:
        plan_to_joints(
            kinematics,
            start,
            goal,
            clearance=clearance,
            condition=upright,
            settings=MotionSettings(is_canceled=lambda: True),
        )
    assert caught.value.code is MoveItErrorCode.PREEMPTED
