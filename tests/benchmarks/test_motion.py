"""Planning beside OMPL called directly with the same checker, and timing beside toppra.

100 queries in each of three scenes, with one second for a search; every path is checked again at
0.002 rad by MuJoCo's contacts. Random splines are timed under the same limits of velocity and
acceleration. OMPL and toppra are needed, each for its own part.
"""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from teleopctl.kinematics import (
    ClearanceChecker,
    GroupKinematics,
    MotionLimits,
    MotionSettings,
    PlanningError,
    plan_to_joints,
)
from teleopctl.kinematics.motion.edges import EdgeChecker
from teleopctl.kinematics.motion.path import JointPath
from teleopctl.kinematics.motion.planner_names import choose_planner
from teleopctl.kinematics.motion.search import find_path
from teleopctl.kinematics.motion.timing import excess, fastest_law, smoothed_law, within_limits
from teleopctl.kinematics.poses import Array
from tests.benchmarks.figure import Figure
from tests.kinematics.motion.scenes import PASSAGE, SHELF, TABLE, deepest, queries, scene

SCENES = {"table": TABLE, "shelf": SHELF, "narrow passage": PASSAGE}
COUNT, TIMEOUT_S = 100, 1.0
PATHS = 60

Search = Callable[[EdgeChecker, Array, Array], Array | None]


def direct_ompl(edges: EdgeChecker, start: Array, goal: Array) -> Array | None:
    """Return OMPL's path by RRTConnect, as a program that uses its Python package would."""
    from ompl import base, geometric, util

    util.noOutputHandler()
    kinematics, count = edges.kinematics, len(start)
    space = base.RealVectorStateSpace(count)
    bounds = base.RealVectorBounds(count)
    for place in range(count):
        bounds.setLow(place, float(kinematics.lower[place]))
        bounds.setHigh(place, float(kinematics.upper[place]))
    space.setBounds(bounds)
    information = base.SpaceInformation(space)

    class Motions(base.MotionValidator):  # type: ignore[misc]
        def checkMotion(self, first: Any, second: Any, _last: Any = None) -> bool:  # noqa: N802
            end = np.array(second[0:count])
            return edges.is_free(end) and edges.is_edge_free(np.array(first[0:count]), end)

    information.setStateValidityChecker(lambda state: edges.is_free(np.array(state[0:count])))
    information.setMotionValidator(Motions(information))
    return _solve(base, geometric, util, information, start, goal)


def discrete_ompl(edges: EdgeChecker, start: Array, goal: Array) -> Array | None:
    """Return OMPL's path with its own check of motions at each 0.002 rad, by contacts alone."""
    from ompl import base, geometric, util

    util.noOutputHandler()
    kinematics, count = edges.kinematics, len(start)
    clearance = edges.clearance
    assert clearance is not None
    space = base.RealVectorStateSpace(count)
    bounds = base.RealVectorBounds(count)
    for place in range(count):
        bounds.setLow(place, float(kinematics.lower[place]))
        bounds.setHigh(place, float(kinematics.upper[place]))
    space.setBounds(bounds)
    information = base.SpaceInformation(space)

    def is_valid(state: Any) -> bool:
        kinematics.set(np.array(state[0:count]))
        distances, _ = clearance.distances(0.0)
        return not (distances <= 0.0).any()

    information.setStateValidityChecker(is_valid)
    # A part of the diagonal of the space.
    diagonal = float(np.linalg.norm(kinematics.upper - kinematics.lower))
    information.setStateValidityCheckingResolution(0.002 * math.sqrt(count) / diagonal)
    return _solve(base, geometric, util, information, start, goal)


def _solve(
    base: Any, geometric: Any, util: Any, information: Any, start: Array, goal: Array
) -> Array | None:
    count = len(start)
    information.setup()
    util.RNG.setSeed(1)
    definition = base.ProblemDefinition(information)
    first, last = information.allocState(), information.allocState()
    first[0:count], last[0:count] = start.tolist(), goal.tolist()
    definition.addStartState(first)
    goals = base.GoalStates(information)
    goals.addState(last)
    definition.setGoal(goals)
    planner = geometric.RRTConnect(information)
    planner.setProblemDefinition(definition)
    planner.setup()
    planner.solve(base.timedPlannerTerminationCondition(TIMEOUT_S))
    if not definition.hasExactSolution():
        return None
    return np.array([state[0:count] for state in definition.getSolutionPath().getStates()])


def ours(library: str) -> Search:
    def search(edges: EdgeChecker, start: Array, goal: Array) -> Array | None:
        planner, _ = choose_planner(library=library)
        try:
            return find_path(edges, planner, start, goal[None], timeout_s=TIMEOUT_S).corners
        except PlanningError:
            return None

    return search


def measure(
    search: Search,
    kinematics: GroupKinematics,
    clearance: ClearanceChecker,
    pairs: list[tuple[Array, Array]],
) -> tuple[float, float, float]:
    """Return the share that was solved, the median time (s) and the least distance of the paths."""
    times, solved, least = [], 0, math.inf
    for start, goal in pairs:
        began = time.perf_counter()
        path = search(EdgeChecker(kinematics, clearance), start, goal)
        times.append(time.perf_counter() - began)
        if path is not None:
            solved += 1
            least = min(least, deepest(kinematics, clearance, path))
    return solved / len(pairs), statistics.median(times), least


def described(share: float, median_s: float) -> str:
    return f"{share:.0%} in {1000.0 * median_s:.1f} ms"


@pytest.mark.timeout(900)
@pytest.mark.parametrize("name", SCENES)
def test_searches_in_scenes_beside_ompl(name: str, figures: list[Figure]) -> None:
    pytest.importorskip("ompl")
    kinematics, clearance = scene(SCENES[name])
    pairs = list(queries(kinematics, clearance, SCENES[name], COUNT))
    floor_share, floor_s, _ = measure(direct_ompl, kinematics, clearance, pairs)
    floor = f"OMPL directly: {described(floor_share, floor_s)}"
    for library, aim in (("ompl", 1.2), ("teleopctl", 4.0)):
        share, median_s, least = measure(ours(library), kinematics, clearance, pairs)
        assert least == math.inf, f"a path overlaps by {least} m"
        subject = f"{name}, planner of {library}"
        figures.append(Figure(subject, described(share, median_s), floor, median_s / floor_s, aim))
        figures.append(
            Figure(f"{subject}: unsolved + 1", "", "", (2 - share) / (2 - floor_share), 1.02)
        )
    bare_share, bare_s, _ = measure(discrete_ompl, kinematics, clearance, pairs)
    figures.append(
        Figure(f"{name}, OMPL's own check each 0.002 rad", described(bare_share, bare_s), floor)
    )


@pytest.mark.timeout(600)
@pytest.mark.parametrize("name", SCENES)
def test_whole_plans_touch_nothing(name: str, figures: list[Figure]) -> None:
    kinematics, clearance = scene(SCENES[name])
    pairs = list(queries(kinematics, clearance, SCENES[name], COUNT))
    settings = MotionSettings(timeout_s=TIMEOUT_S)
    times, durations, before, least = [], [], [], math.inf
    for start, goal in pairs:
        began = time.perf_counter()
        try:
            plan = plan_to_joints(kinematics, start, goal, clearance=clearance, settings=settings)
        except PlanningError:
            continue
        times.append(time.perf_counter() - began)
        durations.append(plan.duration_s)
        before.append(plan.duration_before_jerk_s)
        least = min(least, deepest(kinematics, clearance, plan.positions))
    assert least == math.inf, f"a motion overlaps by {least} m"
    figures.append(
        Figure(
            f"{name}: search, shortening, timing, check",
            f"{len(times)} of {COUNT} in {1000.0 * statistics.median(times):.1f} ms; "
            f"motions of {statistics.mean(durations):.2f} s",
            f"before jerk: {statistics.mean(before):.2f} s",
        )
    )


def test_timing_beside_toppra(figures: list[Figure]) -> None:
    toppra = pytest.importorskip("toppra")
    from toppra import algorithm, constraint

    toppra.setup_logging("ERROR")
    ratios, before, after, own_s, other_s, exceeded = [], [], [], [], [], []
    for seed in range(PATHS):
        generator = np.random.default_rng(seed)
        count = int(generator.integers(3, 8))
        velocities = generator.uniform(1.0, 3.0, count)
        accelerations = generator.uniform(3.0, 12.0, count)
        limits = MotionLimits(velocities, accelerations, accelerations / 0.1)
        points = generator.uniform(-2.0, 2.0, (int(generator.integers(2, 9)), count))
        path = JointPath.spline(points, velocities)
        began = time.process_time()
        law = fastest_law(path, limits)
        own_s.append(time.process_time() - began)
        grid = law.parameters
        began = time.process_time()
        spline = toppra.SplineInterpolator(path.breaks, points, bc_type="natural")
        problem = algorithm.TOPPRA(
            [
                constraint.JointVelocityConstraint(np.stack((-velocities, velocities), 1)),
                constraint.JointAccelerationConstraint(
                    np.stack((-accelerations, accelerations), 1)
                ),
            ],
            spline,
            gridpoints=grid,
            solver_wrapper="seidel",
        )
        _, speeds, _ = problem.compute_parameterization(0.0, 0.0)
        other_s.append(time.process_time() - began)
        duration = float(np.sum(2.0 * np.diff(grid) / (speeds[:-1] + speeds[1:])))
        bound = within_limits(law, limits)
        ratios.append(bound.duration_s / duration)
        before.append(bound.duration_s)
        smooth = smoothed_law(law, limits, keeps_path=True)
        after.append(smooth.duration_s)
        exceeded.append(max(excess(smooth, limits)))
    figures.append(
        Figure(
            f"{PATHS} random splines, duration before jerk: largest ratio",
            f"{statistics.mean(before):.3f} s, ratios {min(ratios):.4f} to {max(ratios):.4f}",
            f"toppra: median ratio {statistics.median(ratios):.4f}",
            max(ratios),
            1.05,
        )
    )
    figures.append(Figure("smallest ratio", "", "", 1.0 / min(ratios), 1.0 + 1e-6))
    figures.append(
        Figure(
            "processor time of a path",
            f"{1000.0 * statistics.median(own_s):.2f} ms",
            f"toppra: {1000.0 * statistics.median(other_s):.2f} ms",
            statistics.median(own_s) / statistics.median(other_s),
            3.0,
        )
    )
    figures.append(
        Figure(
            "duration after smoothing of jerk",
            f"{statistics.mean(after):.3f} s",
            f"before: {statistics.mean(before):.3f} s",
            statistics.mean(after) / statistics.mean(before),
        )
    )
    figures.append(Figure("largest part of a limit, each 1 ms", "", "", max(exceeded), 1.002))
