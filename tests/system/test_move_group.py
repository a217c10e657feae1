"""move_group with a simulated arm, by the messages of MoveIt's clients."""

import threading

import numpy as np
import pytest

from teleopctl.interfaces import get_action, get_message, get_service
from teleopctl.kinematics import MoveItErrorCode
from teleopctl.node import ActionClient
from teleopctl.testing import eventually
from tests.system.move_group_interface import SUCCEEDED, MoveGroupInterface

MoveGroup = get_action("moveit_msgs/action/MoveGroup")
ExecuteTrajectory = get_action("moveit_msgs/action/ExecuteTrajectory")
Constraints = get_message("moveit_msgs/msg/Constraints")
JointConstraint = get_message("moveit_msgs/msg/JointConstraint")
PositionConstraint = get_message("moveit_msgs/msg/PositionConstraint")
OrientationConstraint = get_message("moveit_msgs/msg/OrientationConstraint")
CollisionObject = get_message("moveit_msgs/msg/CollisionObject")
AttachedCollisionObject = get_message("moveit_msgs/msg/AttachedCollisionObject")
SolidPrimitive = get_message("shape_msgs/msg/SolidPrimitive")
JointState = get_message("sensor_msgs/msg/JointState")
Pose = get_message("geometry_msgs/msg/Pose")
String = get_message("std_msgs/msg/String")
PlanningScene = get_message("moveit_msgs/msg/PlanningScene")

GetPositionFK = get_service("moveit_msgs/srv/GetPositionFK")
GetPositionIK = get_service("moveit_msgs/srv/GetPositionIK")
GetStateValidity = get_service("moveit_msgs/srv/GetStateValidity")
GetMotionPlan = get_service("moveit_msgs/srv/GetMotionPlan")
GetCartesianPath = get_service("moveit_msgs/srv/GetCartesianPath")
GetPlanningScene = get_service("moveit_msgs/srv/GetPlanningScene")
ApplyPlanningScene = get_service("moveit_msgs/srv/ApplyPlanningScene")
QueryPlannerInterfaces = get_service("moveit_msgs/srv/QueryPlannerInterfaces")

LINK = "claw_support"
JOINTS = ("joint_1", "joint_2", "joint_3")
LONGEST_S = 30.0


class Client:
    """What MoveIt's clients open, and where the arm is."""

    def __init__(self, node):
        self._node = node
        self.positions: dict[str, float] = {}
        self.step = 0.0
        node.create_subscription(JointState, "/joint_states", self._seen, 10)
        self.objects = node.create_publisher(CollisionObject, "/collision_object", 10)
        self.attached = node.create_publisher(
            AttachedCollisionObject, "/attached_collision_object", 10
        )
        self.event = node.create_publisher(String, "/trajectory_execution_event", 1)
        self._clients = {}
        self.move_action = ActionClient(node, MoveGroup, "/move_action")
        self.execute_action = ActionClient(node, ExecuteTrajectory, "/execute_trajectory")
        assert self.move_action.wait_for_server(LONGEST_S)
        assert self.execute_action.wait_for_server(LONGEST_S)
        eventually(lambda: self.positions and self.objects.get_subscription_count())

    def _seen(self, message):
        new = dict(zip(message.name, message.position, strict=True))
        self.step = max(abs(new[name] - self.positions.get(name, 0.0)) for name in JOINTS)
        self.positions = new

    def is_still(self):
        return self.step < 1e-4

    def is_at(self, **positions):
        return all(abs(self.positions[name] - at) < 0.01 for name, at in positions.items())

    def call(self, kind, name, **fields):
        client = self._clients.get(name)
        if client is None:
            client = self._clients[name] = self._node.create_client(kind, name)
            assert client.wait_for_service(LONGEST_S)
        future = client.call_async(kind.Request(**fields))
        assert future.wait(LONGEST_S)
        return future.result()

    def send(self, client, goal):
        future = client.send_goal_async(goal)
        assert future.wait(LONGEST_S)
        return future.result()

    def result(self, handle):
        future = handle.get_result_async()
        assert future.wait(LONGEST_S)
        return future.result()

    def move(self, goal, **options):
        """Send a goal of ``move_action``, wait for its end and return the result."""
        return self.result(self.send(self.move_action, move_goal(goal, **options))).result

    def tool(self):
        response = self.call(GetPositionFK, "/compute_fk", fk_link_names=[LINK])
        assert response.error_code.val == MoveItErrorCode.SUCCESS
        at = response.pose_stamped[0].pose.position
        return np.array((at.x, at.y, at.z))

    def scene(self):
        return self.call(GetPlanningScene, "/get_planning_scene").scene

    def object_names(self):
        return {one.id for one in self.scene().world.collision_objects}


def move_goal(goal, *, plan_only=False, speed=1.0, replan=False):
    made = MoveGroup.Goal()
    request = made.request
    request.group_name, request.goal_constraints = "arm", [goal]
    request.allowed_planning_time = 2.0
    request.max_velocity_scaling_factor = request.max_acceleration_scaling_factor = speed
    made.planning_options.plan_only, made.planning_options.replan = plan_only, replan
    return made


def joints(*positions):
    return Constraints(
        joint_constraints=[
            JointConstraint(
                joint_name=name, position=at, tolerance_above=1e-3, tolerance_below=1e-3, weight=1.0
            )
            for name, at in zip(JOINTS, positions, strict=True)
        ]
    )


def pose(at):
    message = Pose()
    message.position.x, message.position.y, message.position.z = map(float, at)
    return message


def position(at, radius=1e-3):
    constraint = PositionConstraint(link_name=LINK, weight=1.0)
    constraint.header.frame_id = "world"
    constraint.constraint_region.primitives = [
        SolidPrimitive(type=SolidPrimitive.SPHERE, dimensions=[radius])
    ]
    constraint.constraint_region.primitive_poses = [pose(at)]
    orientation = OrientationConstraint(link_name=LINK, weight=1.0)
    orientation.header.frame_id = "world"
    orientation.absolute_x_axis_tolerance = orientation.absolute_y_axis_tolerance = 1e-3
    orientation.absolute_z_axis_tolerance = 1e-3
    return Constraints(position_constraints=[constraint], orientation_constraints=[orientation])


# What is in the scene of the simulation by itself.
WORLD = {"table", "cube", "floor"}


def box(name, at, size, operation=CollisionObject.ADD):
    message = CollisionObject(id=name, operation=operation, pose=pose(at))
    message.header.frame_id = "world"
    message.primitives = [SolidPrimitive(type=SolidPrimitive.BOX, dimensions=list(size))]
    return message


@pytest.fixture(scope="module")
def arm(shared_ros):
    """The arm in simulation, with the objects of its world as obstacles."""
    shared_ros.launch("sim.yaml", "camera:=false")
    shared_ros.launch("move.yaml", "servo:=false", "world_from_simulation:=true")
    return Client(shared_ros.node)


@pytest.fixture(autouse=True)
def empty_scene(arm):
    """Let each test begin with the simulator's objects alone, and the arm at rest."""
    eventually(arm.is_still)
    yield
    arm.attached.publish(
        AttachedCollisionObject(object=CollisionObject(operation=CollisionObject.REMOVE))
    )
    for name in arm.object_names() - WORLD:
        arm.objects.publish(CollisionObject(id=name, operation=CollisionObject.REMOVE))
    eventually(lambda: arm.object_names() <= WORLD)


def test_a_joint_goal_is_planned_and_executed(arm):
    result = arm.move(joints(0.3, 0.2, -0.3))
    assert result.error_code.val == MoveItErrorCode.SUCCESS
    eventually(lambda: arm.is_at(joint_1=0.3, joint_2=0.2, joint_3=-0.3))
    assert list(result.planned_trajectory.joint_trajectory.joint_names) == list(JOINTS)


def test_a_pose_goal_is_reached_as_far_as_three_joints_allow(arm):
    target = arm.tool() + np.array((0.02, 0.01, -0.02))
    assert arm.move(position(target)).error_code.val == MoveItErrorCode.SUCCESS
    eventually(arm.is_still)
    assert arm.tool() == pytest.approx(target, abs=2e-3)


def test_a_plan_alone_moves_nothing_and_is_executed_later(arm):
    before = dict(arm.positions)
    result = arm.move(joints(0.0, 0.1, 0.0), plan_only=True)
    assert result.error_code.val == MoveItErrorCode.SUCCESS
    assert arm.positions["joint_1"] == pytest.approx(before["joint_1"], abs=1e-3)
    goal = ExecuteTrajectory.Goal(trajectory=result.planned_trajectory)
    response = arm.result(arm.send(arm.execute_action, goal))
    assert response.result.error_code.val == MoveItErrorCode.SUCCESS
    eventually(lambda: arm.is_at(joint_2=0.1))


def test_a_trajectory_from_elsewhere_is_refused(arm):
    result = arm.move(joints(0.2, 0.1, 0.0), plan_only=True)
    assert arm.move(joints(-0.4, 0.3, 0.2)).error_code.val == MoveItErrorCode.SUCCESS
    goal = ExecuteTrajectory.Goal(trajectory=result.planned_trajectory)
    found = arm.result(arm.send(arm.execute_action, goal)).result.error_code
    assert found.val == MoveItErrorCode.CONTROL_FAILED
    assert "start point deviates from current robot state more than 0.01" in found.message


def test_a_straight_line_is_followed(arm):
    assert arm.move(joints(0.0, 0.2, -0.2)).error_code.val == MoveItErrorCode.SUCCESS
    eventually(arm.is_still)
    target = arm.tool() + np.array((0.03, 0.0, 0.02))
    response = arm.call(
        GetCartesianPath,
        "/compute_cartesian_path",
        group_name="arm",
        link_name=LINK,
        waypoints=[pose(target)],
        max_step=0.005,
        avoid_collisions=True,
    )
    assert response.error_code.val == MoveItErrorCode.SUCCESS
    assert response.fraction == pytest.approx(1.0)
    goal = ExecuteTrajectory.Goal(trajectory=response.solution)
    assert arm.result(arm.send(arm.execute_action, goal)).result.error_code.val == 1
    eventually(arm.is_still)
    assert arm.tool() == pytest.approx(target, abs=3e-3)


@pytest.mark.parametrize("way", ["event", "cancel"])
def test_a_motion_is_stopped(arm, way):
    assert arm.move(joints(-0.8, 0.1, 0.0)).error_code.val == MoveItErrorCode.SUCCESS
    handle = arm.send(arm.move_action, move_goal(joints(0.8, 0.1, 0.0), speed=0.2))
    eventually(lambda: arm.positions["joint_1"] > -0.7)
    if way == "event":
        arm.event.publish(String(data="stop"))
    else:
        assert handle.cancel_goal_async().wait(LONGEST_S)
    response = arm.result(handle)
    assert response.result.error_code.val == MoveItErrorCode.PREEMPTED
    eventually(arm.is_still)
    assert arm.positions["joint_1"] < 0.7


def test_a_new_goal_replaces_the_one_that_is_executed(arm):
    assert arm.move(joints(-0.8, 0.1, 0.0)).error_code.val == MoveItErrorCode.SUCCESS
    handle = arm.send(arm.move_action, move_goal(joints(0.8, 0.1, 0.0), speed=0.2))
    eventually(lambda: arm.positions["joint_1"] > -0.7)
    assert arm.move(joints(-0.5, 0.2, 0.0)).error_code.val == MoveItErrorCode.SUCCESS
    assert arm.result(handle).result.error_code.val == MoveItErrorCode.PREEMPTED
    eventually(lambda: arm.is_at(joint_1=-0.5))


def test_an_obstacle_on_the_way_ends_a_motion_that_had_begun(arm):
    assert arm.move(joints(-0.9, 0.1, 0.0)).error_code.val == MoveItErrorCode.SUCCESS
    eventually(arm.is_still)
    ahead = arm.move(joints(0.6, 0.1, 0.0), plan_only=True)
    last = ahead.planned_trajectory.joint_trajectory.points[-1].positions
    state = {"name": list(JOINTS), "position": [float(at) for at in last]}
    request = GetPositionFK.Request(fk_link_names=[LINK])
    request.robot_state.joint_state = JointState(**state)
    there = arm.call(
        GetPositionFK, "/compute_fk", fk_link_names=[LINK], robot_state=request.robot_state
    )
    at = there.pose_stamped[0].pose.position
    handle = arm.send(arm.move_action, move_goal(joints(0.6, 0.1, 0.0), speed=0.2))
    eventually(lambda: arm.positions["joint_1"] > -0.8)
    arm.objects.publish(box("wall", (at.x, at.y, at.z), (0.1, 0.1, 0.1)))
    error = arm.result(handle).result.error_code
    assert error.val == MoveItErrorCode.MOTION_PLAN_INVALIDATED_BY_ENVIRONMENT_CHANGE
    assert "'wall'" in error.message


def test_inverse_kinematics_answers_with_positions_or_with_what_binds(arm):
    request = GetPositionIK.Request().ik_request
    request.group_name = "arm"
    request.pose_stamped.pose = pose(arm.tool() + np.array((0.01, 0.0, 0.0)))
    response = arm.call(GetPositionIK, "/compute_ik", ik_request=request)
    assert response.error_code.val == MoveItErrorCode.SUCCESS
    assert set(response.solution.joint_state.name) >= set(JOINTS)
    request.pose_stamped.pose = pose((5.0, 0.0, 0.0))
    response = arm.call(GetPositionIK, "/compute_ik", ik_request=request)
    assert response.error_code.val == MoveItErrorCode.NO_IK_SOLUTION
    assert "cannot reach the pose: the nearest is" in response.error_code.message


@pytest.mark.parametrize(
    ("change", "code", "text"),
    [
        ({"group_name": "leg"}, MoveItErrorCode.INVALID_GROUP_NAME, "the groups are arm, gripper"),
        ({"frame": "nowhere"}, MoveItErrorCode.FRAME_TRANSFORM_FAILURE, "frame 'nowhere'"),
        ({"quaternion": 0.0}, MoveItErrorCode.NO_IK_SOLUTION, "quaternion of zeros"),
        ({"x": float("nan")}, MoveItErrorCode.NO_IK_SOLUTION, "not a finite number"),
        ({"ik_link_name": "hand"}, MoveItErrorCode.INVALID_LINK_NAME, "no link 'hand'"),
    ],
    ids=["group", "frame", "quaternion", "nan", "link"],
)
def test_bad_requests_are_answered_with_a_code_and_a_sentence(arm, change, code, text):
    request = GetPositionIK.Request().ik_request
    request.group_name = change.get("group_name", "arm")
    request.ik_link_name = change.get("ik_link_name", "")
    request.pose_stamped.header.frame_id = change.get("frame", "world")
    request.pose_stamped.pose = pose((change.get("x", 0.0), 0.8, 1.4))
    request.pose_stamped.pose.orientation.w = change.get("quaternion", 1.0)
    error = arm.call(GetPositionIK, "/compute_ik", ik_request=request).error_code
    assert error.val == code
    assert text in error.message


def test_a_motion_with_a_broken_start_state_is_refused(arm):
    goal = move_goal(joints(0.1, 0.0, 0.0))
    goal.request.start_state.joint_state.name = ["joint_1", "joint_2"]
    goal.request.start_state.joint_state.position = [0.0]
    error = arm.result(arm.send(arm.move_action, goal)).result.error_code
    assert error.val == MoveItErrorCode.INVALID_ROBOT_STATE
    assert "2 names and 1 positions" in error.message


def test_a_state_in_collision_is_invalid_and_names_both_bodies(arm):
    at = arm.tool()
    arm.objects.publish(box("wall", at, (0.1, 0.1, 0.1)))
    eventually(lambda: "wall" in arm.object_names())
    response = arm.call(GetStateValidity, "/check_state_validity", group_name="arm")
    assert not response.valid
    bodies = {(one.contact_body_1, one.contact_body_2) for one in response.contacts}
    assert any({"wall", LINK} == {*pair} for pair in bodies)
    error = arm.move(position(at), plan_only=True).error_code
    assert error.val == MoveItErrorCode.GOAL_IN_COLLISION
    assert "'wall'" in error.message


def test_the_simulator_s_world_is_in_the_scene_and_the_gripper_may_touch_its_cube(arm):
    eventually(lambda: arm.object_names() == WORLD)
    scene = arm.scene()
    matrix = scene.allowed_collision_matrix
    row = matrix.entry_values[list(matrix.entry_names).index("cube")].enabled
    assert row[list(matrix.entry_names).index("gripper_left")]


def test_an_object_is_attached_carried_and_put_down(arm):
    arm.objects.publish(box("cup", arm.tool(), (0.02, 0.02, 0.02)))
    eventually(lambda: "cup" in arm.object_names())
    arm.attached.publish(
        AttachedCollisionObject(
            link_name=LINK,
            object=CollisionObject(id="cup", operation=CollisionObject.ADD),
            touch_links=["gripper_left", "gripper_right"],
        )
    )
    eventually(lambda: arm.scene().robot_state.attached_collision_objects)
    assert "cup" not in arm.object_names()
    arm.attached.publish(
        AttachedCollisionObject(object=CollisionObject(id="cup", operation=CollisionObject.REMOVE))
    )
    eventually(lambda: "cup" in arm.object_names())


def test_a_scene_without_objects_clears_it_and_a_difference_adds_to_it(arm):
    added = PlanningScene(is_diff=True)
    added.robot_state.is_diff = True
    added.world.collision_objects = [box("a", (2.0, 0.0, 0.0), (0.1, 0.1, 0.1))]
    assert arm.call(ApplyPlanningScene, "/apply_planning_scene", scene=added).success
    assert "a" in arm.object_names()
    added.world.collision_objects = [box("b", (2.0, 0.0, 0.0), (0.1, -0.1, 0.1))]
    assert not arm.call(ApplyPlanningScene, "/apply_planning_scene", scene=added).success
    assert "b" not in arm.object_names()
    scene = arm.scene()
    scene.world.collision_objects = [
        one for one in scene.world.collision_objects if one.id in WORLD
    ]
    assert arm.call(ApplyPlanningScene, "/apply_planning_scene", scene=scene).success
    assert arm.object_names() == WORLD


def test_changes_of_the_scene_are_published(arm, shared_ros):
    seen = threading.Event()

    def look(message):
        if any(one.id == "news" for one in message.world.collision_objects):
            seen.set()

    subscription = shared_ros.node.create_subscription(
        PlanningScene, "/monitored_planning_scene", look, 100
    )
    eventually(lambda: subscription.get_publisher_count())
    arm.objects.publish(box("news", (2.0, 0.0, 0.0), (0.1, 0.1, 0.1)))
    assert seen.wait(LONGEST_S)


def test_the_calls_of_a_client_in_c_plus_plus_are_served(arm, shared_ros):
    group = MoveGroupInterface(shared_ros.node, "arm", LINK)
    group.scaling = 0.3
    state = group.get_current_state()
    assert {*JOINTS} <= {*state}

    assert group.get_interface_descriptions()[0].planner_ids
    group.set_planner_params("RRTConnect", "arm", {"range": "0.3"})
    assert group.get_planner_params("RRTConnect", "arm")["range"] == "0.3"

    # setJointValueTarget, plan, execute.
    group.set_joint_value_target({"joint_1": 0.4, "joint_2": 0.1, "joint_3": 0.1})
    status, planned = group.plan()
    assert (status, planned.error_code.val) == (SUCCEEDED, MoveItErrorCode.SUCCESS)
    assert planned.planning_time > 0.0
    assert dict(
        zip(
            planned.trajectory_start.joint_state.name,
            planned.trajectory_start.joint_state.position,
            strict=True,
        )
    )["joint_1"] == pytest.approx(state["joint_1"], abs=1e-3)
    status, executed = group.execute(planned.planned_trajectory)
    assert (status, executed.error_code.val) == (SUCCEEDED, MoveItErrorCode.SUCCESS)
    assert group.get_current_state()["joint_1"] == pytest.approx(0.4, abs=0.01)

    # setPoseTarget, move; a line back.
    there = pose(arm.tool() + np.array([0.0, 0.0, -0.1]))
    there.orientation.w = 1.0
    group.set_pose_target(there)
    status, moved = group.move()
    assert (status, moved.error_code.val) == (SUCCEEDED, MoveItErrorCode.SUCCESS)
    back = pose(arm.tool() + np.array([0.0, 0.0, 0.1]))
    back.orientation.w = 1.0
    fraction, line = group.compute_cartesian_path([back], 0.01)
    assert fraction == pytest.approx(1.0)
    assert line.joint_trajectory.points

    # setStartState, a position alone, path constraints.
    group.set_start_state({**group.get_current_state(), "joint_1": -0.3})
    group.set_position_target(0.6, 0.8, 1.2)
    kept = JointConstraint(
        joint_name="joint_3", position=0.0, tolerance_above=1.5, tolerance_below=1.5, weight=1.0
    )
    group.path_constraints = Constraints(joint_constraints=[kept])
    status, planned = group.plan()
    assert (status, planned.error_code.val) == (SUCCEEDED, MoveItErrorCode.SUCCESS)
    assert planned.planned_trajectory.joint_trajectory.points[0].positions[0] == pytest.approx(-0.3)
    group.path_constraints = None
    group.start_state.is_diff = True
    group.start_state.joint_state = JointState()

    # asyncMove, stop.
    group.scaling = 0.02
    group.set_joint_value_target({"joint_1": -0.8, "joint_2": 0.1, "joint_3": 0.1})
    handle = group.async_move()
    eventually(lambda: not arm.is_still())
    group.stop()
    status, stopped = group.wait(handle)
    assert status != SUCCEEDED
    assert stopped.error_code.val == MoveItErrorCode.PREEMPTED
    eventually(arm.is_still)

    # applyCollisionObjects, attachObject, detachObject, removeCollisionObjects.
    near = arm.tool() + np.array([0.0, 0.5, 0.0])
    assert group.apply_collision_objects([box("tin", near, (0.05, 0.05, 0.05))])
    assert "tin" in group.get_known_object_names()
    assert group.get_objects()["tin"].primitives[0].dimensions[0] == 0.05
    group.attach_object("tin")
    eventually(lambda: "tin" in group.get_attached_objects())
    assert group.get_attached_objects()["tin"].link_name == LINK
    group.detach_object(link=LINK)
    eventually(lambda: "tin" in group.get_known_object_names())
    group.remove_collision_objects(["tin"])
    assert "tin" not in group.get_known_object_names()


def test_planners_are_named(arm):
    found = arm.call(QueryPlannerInterfaces, "/query_planner_interface").planner_interfaces
    assert "RRTConnect" in found[0].planner_ids
    assert {one.pipeline_id for one in found} == {"ompl", "pilz_industrial_motion_planner"}
