"""Requests of kinematics and planning as move_group understands them, on an arm of seven joints."""

import numpy as np
import pytest

from teleopctl.commander import write_pose
from teleopctl.interfaces import get_message, get_service, serialize
from teleopctl.kinematics import (
    AttachedBody,
    CollisionBody,
    CollisionShape,
    KinematicModel,
    MoveItErrorCode,
    PlanningError,
    ShapeKind,
    find_groups,
    rotation_matrix,
)
from teleopctl.nodes.moveit.move_group.context import MoveGroupContext
from teleopctl.nodes.moveit.move_group.kinematics_services import KinematicsServices
from teleopctl.nodes.moveit.move_group.messages import write_object
from teleopctl.nodes.moveit.move_group.planning import Planning
from teleopctl.robot import RobotDescription

from ...kinematics.arms import SEVEN, arm_urdf

MotionPlanRequest = get_message("moveit_msgs/msg/MotionPlanRequest")
Constraints = get_message("moveit_msgs/msg/Constraints")
JointConstraint = get_message("moveit_msgs/msg/JointConstraint")
PositionConstraint = get_message("moveit_msgs/msg/PositionConstraint")
OrientationConstraint = get_message("moveit_msgs/msg/OrientationConstraint")
SolidPrimitive = get_message("shape_msgs/msg/SolidPrimitive")
JointState = get_message("sensor_msgs/msg/JointState")
PlanningScene = get_message("moveit_msgs/msg/PlanningScene")
GetPositionIK = get_service("moveit_msgs/srv/GetPositionIK")
GetPositionFK = get_service("moveit_msgs/srv/GetPositionFK")

NAMES = tuple(f"joint_{number}" for number in range(1, 8))
BENT = np.array([0.2, 0.6, 0.5, 1.1, 0.6, 1.0, 0.1])
TIP = "tool0"


@pytest.fixture(scope="module")
def parts(shared_ros):
    description = RobotDescription.from_urdf(arm_urdf(SEVEN))
    model = KinematicModel(description)
    context = MoveGroupContext(shared_ros.node, model, find_groups(description))
    return context, KinematicsServices(context), Planning(context)


@pytest.fixture
def context(parts) -> MoveGroupContext:
    """The robot, bent, without objects."""
    context: MoveGroupContext = parts[0]
    state = JointState(name=list(NAMES), position=BENT.tolist())
    context.receive_state(bytes(serialize(state)))
    context.scene.clear()
    for name in list(context.scene.attached):
        context.scene.drop(name)
    context.update_state()
    return context


@pytest.fixture
def planning(parts, context):
    return parts[2]


def tip(context: MoveGroupContext, positions=None) -> np.ndarray:
    model = context.scene.model
    if positions is not None:
        model.set_positions(dict(zip(NAMES, positions, strict=True)))
    found = model.pose(TIP)
    model.set_positions(dict(zip(NAMES, BENT, strict=True)))
    return found


def request(*goals, **fields):
    return MotionPlanRequest(
        group_name="arm", goal_constraints=list(goals), allowed_planning_time=5.0, **fields
    )


def joint_goal(*positions):
    return Constraints(
        joint_constraints=[
            JointConstraint(joint_name=name, position=float(at))
            for name, at in zip(NAMES, positions, strict=False)
        ]
    )


def position(at, radius=1e-3):
    constraint = PositionConstraint(link_name=TIP)
    constraint.constraint_region.primitives = [
        SolidPrimitive(type=SolidPrimitive.SPHERE, dimensions=[radius])
    ]
    placed = np.eye(4)
    placed[:3, 3] = at
    constraint.constraint_region.primitive_poses = [write_pose(placed)]
    return constraint


def orientation(rotation, *tolerances):
    pose = np.eye(4)
    pose[:3, :3] = rotation
    x, y, z = tolerances or (1e-3, 1e-3, 1e-3)
    return OrientationConstraint(
        link_name=TIP,
        orientation=write_pose(pose).orientation,
        absolute_x_axis_tolerance=x,
        absolute_y_axis_tolerance=y,
        absolute_z_axis_tolerance=z,
    )


def solved(parts, **fields):
    made = GetPositionIK.Request()
    made.ik_request.group_name = "arm"
    for name, value in fields.items():
        setattr(made.ik_request, name, value)
    return parts[1]._compute_ik(made, GetPositionIK.Response())


def test_a_solution_meets_the_constraints_of_its_request(parts, context):
    ask = GetPositionIK.Request().ik_request
    ask.pose_stamped.pose = write_pose(tip(context))
    constraint = JointConstraint(
        joint_name="joint_3", position=-0.5, tolerance_above=0.4, tolerance_below=0.4
    )
    response = solved(
        parts,
        pose_stamped=ask.pose_stamped,
        constraints=Constraints(joint_constraints=[constraint]),
    )
    assert response.error_code.val == MoveItErrorCode.SUCCESS
    found = dict(
        zip(response.solution.joint_state.name, response.solution.joint_state.position, strict=True)
    )
    assert -0.9 <= found["joint_3"] <= -0.1
    assert tip(context, [found[name] for name in NAMES]) == pytest.approx(tip(context), abs=2e-3)


def test_a_held_object_s_frame_is_brought_to_a_pose(parts, context):
    handle = np.eye(4)
    handle[:3, 3] = 0.0, 0.0, 0.1
    shape = CollisionShape.primitive(ShapeKind.SPHERE, (0.01,))
    cup = CollisionBody("cup", np.eye(4), (shape,), (np.eye(4),), {"handle": handle})
    context.scene.attach(AttachedBody(cup, TIP))
    ask = GetPositionIK.Request().ik_request
    target = tip(context) @ handle
    target[:3, 3] += 0.02, 0.0, -0.03
    ask.pose_stamped.pose = write_pose(target)
    response = solved(parts, pose_stamped=ask.pose_stamped, ik_link_name="cup/handle")
    assert response.error_code.val == MoveItErrorCode.SUCCESS
    made = GetPositionFK.Request(fk_link_names=["cup/handle"])
    made.robot_state.joint_state = response.solution.joint_state
    at = parts[1]._compute_fk(made, GetPositionFK.Response()).pose_stamped[0].pose.position
    assert (at.x, at.y, at.z) == pytest.approx(target[:3, 3], abs=1e-3)


def test_any_of_several_goals_will_do(context, planning):
    far = Constraints(position_constraints=[position((9.0, 0.0, 0.0))])
    planned = planning.plan(request(far, joint_goal(*(BENT + 0.1))))
    assert planned.plan.positions[-1] == pytest.approx(BENT + 0.1, abs=1e-6)


def test_a_position_alone_leaves_the_rotation_free(context, planning):
    target = tip(context)[:3, 3] + (0.05, -0.1, 0.05)
    planned = planning.plan(request(Constraints(position_constraints=[position(target)])))
    assert tip(context, planned.plan.positions[-1])[:3, 3] == pytest.approx(target, abs=2e-3)


def test_a_position_may_be_that_of_a_point_beside_the_link(context, planning):
    target = tip(context)[:3, 3] + (0.05, -0.1, 0.05)
    beside = position(target)
    beside.target_point_offset.y = 0.2
    planned = planning.plan(request(Constraints(position_constraints=[beside])))
    reached = tip(context, planned.plan.positions[-1])
    assert reached[:3, 3] + 0.2 * reached[:3, 1] == pytest.approx(target, abs=2e-3)
    # With the rotation it has to keep, too.
    beside.target_point_offset.y = 0.1
    before = tip(context)
    goal = Constraints(
        position_constraints=[beside], orientation_constraints=[orientation(before[:3, :3])]
    )
    center = beside.constraint_region.primitive_poses[0].position
    center.x, center.y, center.z = map(float, before[:3, 3] + 0.1 * before[:3, 1] + 0.02)
    planned = planning.plan(request(goal))
    reached = tip(context, planned.plan.positions[-1])
    assert reached[:3, 3] == pytest.approx(before[:3, 3] + 0.02, abs=2e-3)


def test_an_orientation_alone_turns_the_link_where_it_is(context, planning):
    before = tip(context)
    turned = before[:3, :3] @ rotation_matrix(np.array((0.0, 0.4, 0.0)))
    planned = planning.plan(request(Constraints(orientation_constraints=[orientation(turned)])))
    after = tip(context, planned.plan.positions[-1])
    assert after[:3, :3] == pytest.approx(turned, abs=1e-2)
    assert after[:3, 3] == pytest.approx(before[:3, 3], abs=2e-3)


def test_a_wide_tolerance_is_used_where_the_wanted_rotation_cannot_be_had(context, planning):
    before = tip(context)
    goal = Constraints(
        position_constraints=[position(before[:3, 3])],
        # About z anything will do.
        orientation_constraints=[orientation(before[:3, :3], 0.01, 0.01, 3.2)],
    )
    planned = planning.plan(request(goal))
    assert tip(context, planned.plan.positions[-1])[:3, 2] == pytest.approx(before[:3, 2], abs=0.02)


def test_an_orientation_is_kept_along_the_path_and_at_a_goal_of_a_position(context, planning):
    before = tip(context)
    goal = before[:3, 3] + (0.05, -0.2, 0.0)
    keep = Constraints(orientation_constraints=[orientation(before[:3, :3], 0.05, 0.05, 3.2)])
    wanted = Constraints(position_constraints=[position(goal)])
    planned = planning.plan(request(wanted, path_constraints=keep))
    assert tip(context, planned.plan.positions[-1])[:3, 3] == pytest.approx(goal, abs=2e-3)
    for positions in planned.plan.positions:
        z = (before[:3, :3].T @ tip(context, positions)[:3, :3])[:, 2]
        assert max(abs(z[0]), abs(z[1])) < 0.051


def test_half_a_turn_is_free_also_where_it_is_written_with_a_few_digits(context, planning):
    turned = tip(context)[:3, :3] @ rotation_matrix(np.array((np.pi, 0.0, 0.0)))
    kept = orientation(turned, 3.14159, 0.5, 0.5)
    kept.parameterization = OrientationConstraint.ROTATION_VECTOR
    keep = Constraints(orientation_constraints=[kept])
    goal = np.add(BENT, (0.1, 0.05, 0.0, -0.05, 0.0, 0.0, 0.3))
    wanted = request(joint_goal(*goal), path_constraints=keep)
    assert planning.plan(wanted).plan.positions[-1] == pytest.approx(goal, abs=1e-4)


def test_a_start_that_violates_the_path_constraints_is_refused(context, planning):
    turned = tip(context)[:3, :3] @ rotation_matrix(np.array((0.0, 0.5, 0.0)))
    keep = Constraints(orientation_constraints=[orientation(turned, 0.1, 0.1, 0.1)])
    with pytest.raises(PlanningError, match=r"start violates .*'tool0' is turned 0\.4") as error:
        planning.plan(request(joint_goal(*BENT), path_constraints=keep))
    assert error.value.code is MoveItErrorCode.START_STATE_VIOLATES_PATH_CONSTRAINTS


def test_a_scaling_that_is_no_number_is_refused(context, planning):
    with pytest.raises(PlanningError, match="max_velocity_scaling_factor is nan"):
        planning.plan(request(joint_goal(*BENT), max_velocity_scaling_factor=float("nan")))


def test_the_speed_of_a_link_is_limited(context, planning):
    goal = joint_goal(*(BENT + 0.5))
    free = planning.plan(request(goal)).plan
    slow = planning.plan(request(goal, max_cartesian_speed=0.1)).plan
    assert slow.duration_s > 1.5 * free.duration_s
    points = np.array([tip(context, positions)[:3, 3] for positions in slow.positions])
    speeds = np.linalg.norm(np.diff(points, axis=0), axis=1) / np.diff(slow.times)
    assert speeds.max() < 0.101


def test_changes_of_the_scene_in_a_request_hold_for_its_plan_alone(context, planning):
    there = tip(context, BENT + 0.3)
    box = CollisionBody(
        "wall",
        there,
        (CollisionShape.primitive(ShapeKind.BOX, (0.1, 0.1, 0.1)),),
        (np.eye(4),),
    )
    diff = PlanningScene(is_diff=True)
    diff.robot_state.is_diff = True
    diff.world.collision_objects = [write_object(box, "base")]
    with pytest.raises(PlanningError, match="'wall'") as error:
        planning.plan(request(joint_goal(*(BENT + 0.3))), diff)
    assert error.value.code is MoveItErrorCode.GOAL_IN_COLLISION
    assert not context.scene.objects
    planning.plan(request(joint_goal(*(BENT + 0.3))))


def test_pilz_s_line_is_straight(context, planning):
    before = tip(context)
    goal = np.array(before)
    goal[:3, 3] += 0.0, -0.08, 0.03
    wanted = Constraints(
        position_constraints=[position(goal[:3, 3])],
        orientation_constraints=[orientation(before[:3, :3])],
    )
    pipeline = "pilz_industrial_motion_planner"
    planned = planning.plan(request(wanted, pipeline_id=pipeline, planner_id="LIN"))
    way = goal[:3, 3] - before[:3, 3]
    for positions in planned.plan.positions:
        off = tip(context, positions)[:3, 3] - before[:3, 3]
        assert np.linalg.norm(off - way * (off @ way) / (way @ way)) < 1e-3
    with pytest.raises(PlanningError, match="Arcs"):
        planning.plan(request(wanted, pipeline_id=pipeline, planner_id="CIRC"))
