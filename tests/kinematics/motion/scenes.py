"""Scenes with obstacles for tests and benchmarks of motion planning, and random queries in them."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from teleopctl.kinematics import ClearanceChecker, GroupKinematics, KinematicModel, find_groups
from teleopctl.kinematics.motion.edges import EdgeChecker
from teleopctl.kinematics.poses import Array
from teleopctl.robot import RobotDescription, read_world_text
from tests.kinematics.arms import SEVEN, arm_urdf

# The arm stands at the origin; it is 1.05 m long.
TABLE = """
things:
  table: {shape: box, size: [0.8, 1.6, 0.04], at: [0.55, 0, 0.1]}
  carton: {shape: box, size: [0.15, 0.15, 0.3], at: [0.45, 0, 0.27]}
  bottle: {shape: cylinder, radius: 0.04, length: 0.3, at: [0.4, 0.3, 0.27]}
  jar: {shape: cylinder, radius: 0.06, length: 0.2, at: [0.4, -0.35, 0.22]}
  ball: {shape: sphere, radius: 0.08, at: [0.6, 0.15, 0.2]}
"""
SHELF = """
things:
  back: {shape: box, size: [0.02, 0.9, 0.9], at: [0.9, 0, 0.55]}
  left: {shape: box, size: [0.35, 0.02, 0.9], at: [0.73, 0.45, 0.55]}
  right: {shape: box, size: [0.35, 0.02, 0.9], at: [0.73, -0.45, 0.55]}
  middle: {shape: box, size: [0.35, 0.02, 0.9], at: [0.73, 0, 0.55]}
  low: {shape: box, size: [0.35, 0.9, 0.02], at: [0.73, 0, 0.1]}
  board: {shape: box, size: [0.35, 0.9, 0.02], at: [0.73, 0, 0.42]}
  high: {shape: box, size: [0.35, 0.9, 0.02], at: [0.73, 0, 0.74]}
"""
# A wall with a slit of 0.2 m; the arm is 0.06 m thick.
PASSAGE = """
things:
  near: {shape: box, size: [0.04, 1.4, 0.9], at: [0.45, 0.8, 0.55]}
  far: {shape: box, size: [0.04, 1.4, 0.9], at: [0.45, -0.8, 0.55]}
  above: {shape: box, size: [0.04, 0.2, 0.5], at: [0.45, 0, 0.95]}
"""
# Where the tool is at a query's inner end: on the table, in the shelf, behind the wall; smallest
# and largest x, y and z in metres.
_INNER = {
    TABLE: ((0.25, -0.6, 0.13), (0.9, 0.6, 0.35)),
    SHELF: ((0.6, -0.45, 0.1), (0.9, 0.45, 0.74)),
    PASSAGE: ((0.55, -0.45, 0.1), (0.9, 0.45, 1.0)),
}


def scene(world: str) -> tuple[GroupKinematics, ClearanceChecker]:
    """Return the seven-joint arm of the tests in a world."""
    description = RobotDescription.from_urdf(arm_urdf(SEVEN))
    model = KinematicModel(description, read_world_text(world, "scene.yaml"))
    kinematics = GroupKinematics(model, find_groups(description).group())
    return kinematics, ClearanceChecker(model)


def queries(
    kinematics: GroupKinematics, clearance: ClearanceChecker, world: str, count: int
) -> Iterator[tuple[Array, Array]]:
    """Yield free starts and goals: one of them at the inner place, or every second time both."""
    edges = EdgeChecker(kinematics, clearance)
    generator = np.random.default_rng(1)
    lower, upper = np.array(_INNER[world])

    def state(is_inner: bool) -> Array:
        while True:
            positions = kinematics.random(generator)
            kinematics.set(positions)
            origin = kinematics.pose()[:3, 3]
            fits = not is_inner or bool(((origin > lower) & (origin < upper)).all())
            if fits and edges.is_free(positions):
                return positions

    for number in range(count):
        ends = state(True), state(number % 2 == 0)
        yield (ends[0], ends[1]) if number % 4 < 2 else (ends[1], ends[0])


def deepest(kinematics: GroupKinematics, clearance: ClearanceChecker, path: Array) -> float:
    """Return the smallest distance (m) between bodies on a polyline, (m, n), each 0.002 rad.

    By MuJoCo's contacts alone, independently of the planner's check.
    """
    least = np.inf
    for before, after in pairwise(path):
        count = max(1, int(np.ceil(np.abs(after - before).max() / 0.002)))
        for part in np.linspace(0.0, 1.0, count + 1):
            kinematics.set(before + part * (after - before))
            if found := clearance.collisions():
                least = min(least, found[0].distance_m)
    return float(least)
