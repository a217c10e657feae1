"""Inverse kinematics beside mink and ikpy, called directly from the same starts, without obstacles.

And alone, among ten of them.

Targets are poses at random joint positions, so that all can be reached; the search begins at the
arm's middle position. mink's loop solves and integrates with the same solver of quadratic
programs, limits and tolerances, and starts anew where ours does. ikpy has no loop of its own over
starts: it gets the first one only.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from teleopctl.kinematics import Arm, IkSolver, PoseTask, Tolerance
from teleopctl.kinematics.poses import Array, rotation_vector
from teleopctl.packages import package_share
from teleopctl.robot import read_world_text
from tests.benchmarks.figure import Figure
from tests.kinematics.arms import SEVEN, SIX, arm_urdf

TARGETS, UNREACHABLE, OF_IKPY = 1_000, 200, 50
MOST_STEPS, MOST_STARTS = 60, 42
WITHIN = Tolerance()
TELEOP = package_share("teleop_description") / "urdf" / "teleop.urdf.xacro"
ARMS: dict[str, Callable[[], Arm]] = {
    "3 joints": lambda: Arm(TELEOP),
    "6 joints": lambda: Arm(arm_urdf(SIX)),
    "7 joints": lambda: Arm(arm_urdf(SEVEN)),
}


def targets(arm: Arm, count: int) -> list[Array]:
    generator = np.random.default_rng(7)
    return [arm.fk(arm.kinematics.random(generator)) for _ in range(count)]


def starts(arm: Arm) -> Iterator[Array]:
    """The starts that `IkSolver` tries: the given one, the middle, and random ones."""
    middle = arm.kinematics.clamp(0.5 * (arm.lower + arm.upper))
    yield middle
    yield middle
    generator = np.random.default_rng(0)
    for _ in range(MOST_STARTS - 2):
        yield arm.kinematics.random(generator)


class Mink:
    """mink's own loop: solve, integrate, until the pose is reached or the steps are over."""

    def __init__(self, arm: Arm, task: PoseTask) -> None:
        mink: Any = pytest.importorskip("mink")
        self._mink, self._arm, self._task = mink, arm, task
        self._model = arm.model.mj_model
        self._configuration = mink.Configuration(self._model)
        self._columns = [arm.model.address(name) for name in arm.names]
        self._limits = [mink.ConfigurationLimit(self._model)]
        cost = 1.0 if task is PoseTask.POSE else 0.0
        self._frame = mink.FrameTask(
            frame_name=arm.group.tip,
            frame_type="body",
            position_cost=1.0,
            orientation_cost=cost,
            lm_damping=1e-3,
        )

    def solve(self, target: Array) -> Array | None:
        mink, arm = self._mink, self._arm
        self._frame.set_target(mink.SE3.from_matrix(arm.model.to_world(target)))
        whole = np.array(arm.model.mj_data.qpos)
        for start in starts(arm):
            whole[self._columns] = start
            self._configuration.update(whole)
            for _ in range(MOST_STEPS):
                error = self._frame.compute_error(self._configuration)
                is_near = np.linalg.norm(error[:3]) <= WITHIN.position_m
                if is_near and (
                    self._task is not PoseTask.POSE
                    or np.linalg.norm(error[3:]) <= WITHIN.rotation_rad
                ):
                    return np.array(self._configuration.q[self._columns])
                velocity = mink.solve_ik(
                    self._configuration, [self._frame], 1.0, "daqp", 1e-6, limits=self._limits
                )
                self._configuration.integrate_inplace(velocity, 1.0)
        return None


def is_reached(arm: Arm, task: PoseTask, target: Array, positions: Array) -> bool:
    """Whether positions within the limits reach a target to 1 mm and 0.01 rad."""
    if not np.all((positions >= arm.lower - 1e-9) & (positions <= arm.upper + 1e-9)):
        return False
    reached = arm.fk(positions)
    turn = rotation_vector(target[:3, :3] @ reached[:3, :3].T)
    near = np.linalg.norm(target[:3, 3] - reached[:3, 3]) < 1e-3
    return bool(near and (task is not PoseTask.POSE or np.linalg.norm(turn) < 0.01))


def percentiles(times_s: list[float]) -> str:
    p50, p99 = np.percentile(times_s, [50, 99])
    return f"p50 {1e3 * p50:.2f} ms, p99 {1e3 * p99:.1f} ms"


@pytest.mark.parametrize("name", ARMS)
def test_inverse_kinematics(name: str, figures: list[Figure]) -> None:
    arm = ARMS[name]()
    solver = IkSolver(arm.kinematics)
    mink = Mink(arm, solver.task)
    middle = next(starts(arm))
    times: dict[str, list[float]] = {"ours": [], "mink": []}
    solved = dict.fromkeys(times, 0)
    for target in targets(arm, TARGETS):
        for who, solve in (
            ("ours", lambda pose: solver.solve(pose, middle).positions),
            ("mink", mink.solve),
        ):
            begin = time.perf_counter()
            found = solve(target)
            times[who].append(time.perf_counter() - begin)
            solved[who] += found is not None and is_reached(arm, solver.task, target, found)
    share = {who: 100.0 * count / TARGETS for who, count in solved.items()}
    figures.append(
        Figure(
            f"ik, {name}, {solver.task.value}",
            f"{share['ours']:.1f} %, {percentiles(times['ours'])}",
            f"mink {share['mink']:.1f} %, {percentiles(times['mink'])}",
            float(np.median(times["ours"]) / np.median(times["mink"])),
            1.3,
        )
    )
    assert share["ours"] >= 99.5


@pytest.mark.parametrize("links", [SIX, SEVEN], ids=["6 joints", "7 joints"])
def test_inverse_kinematics_among_ten_obstacles(
    links: tuple[tuple[str, float], ...], figures: list[Figure]
) -> None:
    """Pillars around the arm within its reach; targets are poses at which nothing touches."""
    places = [(0.4 * np.cos(a), 0.4 * np.sin(a), 0.3) for a in np.linspace(0.0, 5.6, 10)]
    things = "".join(
        f"  thing_{number}: {{shape: box, size: [0.1, 0.1, 0.4], at: [{x}, {y}, {z}]}}\n"
        for number, (x, y, z) in enumerate(places)
    )
    world = read_world_text(f"world: around\nthings:\n{things}", "world.yaml")
    arm = Arm(arm_urdf(links), world=world)
    solver = IkSolver(arm.kinematics, clearance=arm.clearance)
    middle = next(starts(arm))
    generator = np.random.default_rng(7)
    times: list[float] = []
    solved = 0
    while len(times) < TARGETS:
        positions = arm.kinematics.random(generator)
        if arm.collisions(positions):
            continue
        target = arm.fk(positions)
        begin = time.perf_counter()
        found = solver.solve(target, middle)
        times.append(time.perf_counter() - begin)
        solved += (
            found.is_reached
            and is_reached(arm, solver.task, target, found.positions)
            and not arm.collisions(found.positions)
        )
    share = 100.0 * solved / TARGETS
    name = f"ik, {len(arm.names)} joints, ten obstacles"
    figures.append(Figure(name, f"{share:.1f} %, {percentiles(times)}"))
    assert share >= 99.5


@pytest.mark.parametrize("name", ["6 joints", "7 joints"])
def test_inverse_kinematics_beside_ikpy(name: str, figures: list[Figure], tmp_path: Path) -> None:
    chain_module: Any = pytest.importorskip("ikpy.chain")
    arm = ARMS[name]()
    file = tmp_path / "arm.urdf"
    file.write_text(arm.model.description.urdf)
    chain = chain_module.Chain.from_urdf_file(
        str(file),
        base_elements=["base"],
        active_links_mask=[False, *[True] * len(arm.names), False],
    )
    solver = IkSolver(arm.kinematics)
    middle = next(starts(arm))
    times: list[float] = []
    solved = 0
    for target in targets(arm, OF_IKPY):
        begin = time.perf_counter()
        found = chain.inverse_kinematics_frame(
            target, initial_position=[0.0, *middle, 0.0], orientation_mode="all"
        )
        times.append(time.perf_counter() - begin)
        solved += is_reached(arm, solver.task, target, np.array(found[1:-1]))
    figures.append(
        Figure(
            f"ikpy, {name}, one start", f"{100.0 * solved / OF_IKPY:.0f} %, {percentiles(times)}"
        )
    )


@pytest.mark.parametrize("name", ARMS)
def test_unreachable_poses_are_answered_as_such(name: str, figures: list[Figure]) -> None:
    """Poses beyond the reach, and tools turned where no joint turns them."""
    arm = ARMS[name]()
    solver = IkSolver(arm.kinematics)
    middle = next(starts(arm))
    reach = arm.workspace(2_000, collisions=True).reach_m
    times: list[float] = []
    wrong = named = 0
    for number, target in enumerate(targets(arm, UNREACHABLE)):
        origin = arm.model.joint_origin(arm.names[0])
        away = target[:3, 3] - origin
        length = float(np.linalg.norm(away)) or 1.0
        target[:3, 3] = origin + away / length * (1.02 + 0.005 * number) * reach * 1.02
        begin = time.perf_counter()
        found = solver.solve(target, middle)
        times.append(time.perf_counter() - begin)
        wrong += found.is_reached
        named += bool(found.binding)
    figures.append(
        Figure(
            f"ik, {name}, unreachable",
            f"{UNREACHABLE - wrong} of {UNREACHABLE} answered, {named} with what binds, "
            f"{percentiles(times)}",
        )
    )
    assert wrong == 0
    assert named == UNREACHABLE
