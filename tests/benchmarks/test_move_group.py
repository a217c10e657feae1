"""move_group beside the solver in this process, and beside a process that compiles the same model.

The time that `/compute_ik` adds to the solver; one object more in a scene of a thousand; memory at
the start, and its growth over 200 plans after 200 others.
"""

from __future__ import annotations

import subprocess
import sys
import time

import numpy as np
import psutil
import pytest

import teleopctl
from teleopctl.commander import write_pose
from teleopctl.interfaces import get_message, get_service
from teleopctl.kinematics import GroupKinematics, IkSolver, KinematicModel, find_groups
from teleopctl.robot import RobotDescription
from teleopctl.testing import LONGEST_WAIT_S
from tests.benchmarks.figure import Figure

REQUESTS, OBJECTS, PLANS = 300, 1000, 200
MOST_ADDED_MS, MOST_OBJECT_MS, MOST_MEMORY = 1.0, 50.0, 1.3
PERIOD_S = 0.05

JointState = get_message("sensor_msgs/msg/JointState")
String = get_message("std_msgs/msg/String")
PlanningScene = get_message("moveit_msgs/msg/PlanningScene")
CollisionObject = get_message("moveit_msgs/msg/CollisionObject")
SolidPrimitive = get_message("shape_msgs/msg/SolidPrimitive")
Constraints = get_message("moveit_msgs/msg/Constraints")
JointConstraint = get_message("moveit_msgs/msg/JointConstraint")
GetPositionIK = get_service("moveit_msgs/srv/GetPositionIK")
GetMotionPlan = get_service("moveit_msgs/srv/GetMotionPlan")
ApplyPlanningScene = get_service("moveit_msgs/srv/ApplyPlanningScene")

BARE = """
import sys
import mujoco
from teleopctl.mujoco_model import build_model
from teleopctl.robot import RobotDescription
built = build_model(RobotDescription.from_urdf(open(sys.argv[1]).read()), fixed_base=True)
data = mujoco.MjData(built.mj_model)
mujoco.mj_forward(built.mj_model, data)
print("ready", flush=True)
sys.stdin.read()
"""


class Server:
    """A running move_group with the teleop arm, and a client of its services."""

    def __init__(self, ros):
        self.node = ros.node
        self.urdf = teleopctl.load_robot("package://teleop_description/urdf/teleop.urdf.xacro").urdf
        file = ros.folder / "robot.yaml"
        text = "\n".join(f"      {line}" for line in self.urdf.splitlines())
        file.write_text(f"/**:\n  ros__parameters:\n    robot_description: |\n{text}\n")
        self.process = ros.spawn_module(
            "teleopctl.nodes", f"moveit_ros_move_group move_group --ros-args --params-file {file}"
        )
        self._states = self.node.create_publisher(JointState, "/joint_states", 1)
        self._timer = self.node.create_timer(PERIOD_S, self._publish)
        self.client(GetPositionIK, "/compute_ik")
        # Before the scene of a thousand objects.
        self.memory_at_start = psutil.Process(self.process.pid).memory_full_info().pss

    def _publish(self):
        names = [f"joint_{number}" for number in range(1, 6)]
        self._states.publish(JointState(name=names, position=[0.0] * 5))

    def client(self, kind, name):
        client = self.node.create_client(kind, name)
        assert client.wait_for_service(LONGEST_WAIT_S)
        return client


@pytest.fixture(scope="module")
def server(shared_ros):
    return Server(shared_ros)


def call(client, request):
    """Return the response, and the time until it came, s."""
    begun = time.perf_counter()
    response = client.call(request, LONGEST_WAIT_S)
    return response, time.perf_counter() - begun


def middle_ms(times):
    return float(np.median(times)) * 1e3


def test_inverse_kinematics_by_service_beside_the_solver(server, figures: list[Figure]):
    description = RobotDescription.from_urdf(server.urdf)
    kinematics = GroupKinematics(KinematicModel(description), find_groups(description).group())
    solver, start = IkSolver(kinematics), np.zeros(len(kinematics.names))
    generator = np.random.default_rng(0)
    client = server.client(GetPositionIK, "/compute_ik")
    direct, served = [], []
    for _ in range(REQUESTS):
        kinematics.set(kinematics.random(generator))
        target = kinematics.pose()
        begun = time.perf_counter()
        solver.solve(target, start)
        direct.append(time.perf_counter() - begun)
        request = GetPositionIK.Request()
        request.ik_request.group_name = "arm"
        request.ik_request.pose_stamped.pose = write_pose(target)
        response, spent = call(client, request)
        assert response is not None
        served.append(spent)
    added = middle_ms(served) - middle_ms(direct)
    figures.append(
        Figure(
            f"/compute_ik, added to the solver (aim {MOST_ADDED_MS:g} ms)",
            f"{middle_ms(served):.2f} ms",
            f"{middle_ms(direct):.2f} ms",
            added / MOST_ADDED_MS,
            1.0,
        )
    )


def test_one_object_more_in_a_scene_of_a_thousand(server, figures: list[Figure]):
    client = server.client(ApplyPlanningScene, "/apply_planning_scene")
    generator = np.random.default_rng(0)

    def scene(names):
        message = PlanningScene(is_diff=True)
        message.robot_state.is_diff = True
        for name in names:
            box = SolidPrimitive(type=SolidPrimitive.BOX, dimensions=[0.1, 0.1, 0.1])
            thing = CollisionObject(id=name, primitives=[box])
            x, y, z = (np.array((5.0, 0.0, 0.0)) + generator.uniform(-2, 2, 3)).tolist()
            at = thing.pose.position
            at.x, at.y, at.z = x, y, z
            message.world.collision_objects.append(thing)
        return ApplyPlanningScene.Request(scene=message)

    response, first = call(client, scene(f"box_{number}" for number in range(OBJECTS)))
    assert response.success
    times = [call(client, scene([f"more_{number}"]))[1] for number in range(20)]
    figures.append(
        Figure(
            f"one object more in a scene of {OBJECTS} (aim {MOST_OBJECT_MS:g} ms)",
            f"{middle_ms(times):.1f} ms",
            f"all at once {first:.2f} s",
            middle_ms(times) / MOST_OBJECT_MS,
            1.0,
        )
    )
    message = PlanningScene(is_diff=True)
    message.robot_state.is_diff = True
    message.world.collision_objects = [CollisionObject(operation=CollisionObject.REMOVE)]
    assert call(client, ApplyPlanningScene.Request(scene=message))[0].success


def test_memory_beside_a_process_with_the_same_model(server, figures: list[Figure], tmp_path):
    file = tmp_path / "robot.urdf"
    file.write_text(server.urdf)
    bare = subprocess.Popen(
        [sys.executable, "-c", BARE, str(file)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    try:
        assert bare.stdout is not None
        assert bare.stdout.readline() == b"ready\n"
        floor = psutil.Process(bare.pid).memory_full_info().pss
    finally:
        bare.communicate(b"")
    watched = psutil.Process(server.process.pid)
    client = server.client(GetMotionPlan, "/plan_kinematic_path")

    def plan(number):
        request = GetMotionPlan.Request()
        wanted = request.motion_plan_request
        wanted.group_name, wanted.allowed_planning_time = "arm", 1.0
        constraint = JointConstraint(joint_name="joint_1", position=0.5 + 0.001 * number)
        wanted.goal_constraints = [Constraints(joint_constraints=[constraint])]
        assert call(client, request)[0].motion_plan_response.error_code.val == 1

    for number in range(PLANS):
        plan(number)
    before = watched.memory_full_info().pss
    for number in range(PLANS):
        plan(number)
    after = watched.memory_full_info().pss
    figures.append(
        Figure(
            "move_group's memory (PSS), teleop arm",
            f"{server.memory_at_start / 1e6:.0f} MB",
            f"{floor / 1e6:.0f} MB",
            server.memory_at_start / floor,
            MOST_MEMORY,
        )
    )
    figures.append(
        Figure(
            f"move_group's growth over {PLANS} plans", f"{(after - before) / 1e6:.1f} MB", "", None
        )
    )
