"""A servo step, against what it needs of MuJoCo alone: kinematics, Jacobian and collision check.

Seven joints and ten obstacles around them, random twists; processor time of one thread.
"""

from __future__ import annotations

import time

import mujoco
import numpy as np

from teleopctl.kinematics import (
    ClearanceChecker,
    GroupKinematics,
    KinematicModel,
    ServoCore,
    find_groups,
)
from teleopctl.robot import RobotDescription, read_world_text
from tests.benchmarks.figure import Figure
from tests.kinematics.arms import SEVEN, arm_urdf

STEPS = 3000
PERIOD_S = 0.01
AIM_MS = 0.4


def test_a_step_beside_bare_mujoco(figures: list[Figure]):
    description = RobotDescription.from_urdf(arm_urdf(SEVEN))
    joints = description.joints
    places = [(0.6 * np.cos(a), 0.6 * np.sin(a), 0.3) for a in np.linspace(0.0, 5.6, 10)]
    things = "".join(
        f"  thing_{number}: {{shape: box, size: [0.1, 0.1, 0.4], at: [{x}, {y}, {z}]}}\n"
        for number, (x, y, z) in enumerate(places)
    )
    world = read_world_text(f"world: around\nthings:\n{things}", "world.yaml")
    model = KinematicModel(description, world)
    kinematics = GroupKinematics(model, find_groups(description).group())
    assert len(joints) > len(kinematics.names) == 7
    core = ServoCore(kinematics, np.full(7, 10.0), clearance=ClearanceChecker(model))
    core.reset(np.array([0.2, 0.6, 0.5, 1.1, 0.6, 1.0, 0.1]))
    generator = np.random.default_rng(0)
    visited = []
    spent_s = 0.0
    for number in range(STEPS):
        if number % 30 == 0:
            twist = generator.normal(size=6) * [0.4, 0.4, 0.4, 0.8, 0.8, 0.8]
        begun = time.process_time()
        core.twist_step(twist, PERIOD_S)
        spent_s += time.process_time() - begun
        visited.append(core.positions)
    jacobian, body = np.zeros((6, model.mj_model.nv)), model.body("tool0")
    begun = time.process_time()
    for positions in visited:
        model.mj_data.qpos[:7] = positions
        mujoco.mj_kinematics(model.mj_model, model.mj_data)
        mujoco.mj_comPos(model.mj_model, model.mj_data)
        mujoco.mj_jacBody(model.mj_model, model.mj_data, jacobian[:3], jacobian[3:], body)
        mujoco.mj_collision(model.mj_model, model.mj_data)
    bare_ms = (time.process_time() - begun) / STEPS * 1e3
    step_ms = spent_s / STEPS * 1e3
    figures.append(
        Figure(
            f"servo step, 7 joints, 10 obstacles (aim {AIM_MS:g} ms)",
            f"{step_ms:.3f} ms",
            f"{bare_ms:.3f} ms",
            step_ms / bare_ms,
        )
    )
