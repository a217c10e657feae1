"""MoveIt's ``MoveGroupInterface`` and ``PlanningSceneInterface`` as they are on the wire.

Each method makes the calls of the C++ method of that name, with the same fields set and left out:
source ``moveit_ros/planning_interface`` of MoveIt 2.
"""

from __future__ import annotations

from typing import Any

from teleopctl.interfaces import get_action, get_message, get_service, to_nanoseconds
from teleopctl.node import ActionClient
from teleopctl.testing import eventually

LONGEST_S = 30.0
MoveGroup = get_action("moveit_msgs/action/MoveGroup")
ExecuteTrajectory = get_action("moveit_msgs/action/ExecuteTrajectory")
SUCCEEDED = 4


def message(name, **fields):
    package, _, kind = name.partition("/")
    return get_message(f"{package}/msg/{kind}")(**fields)


class MoveGroupInterface:
    """Calls of ``MoveGroupInterface``.

    Attributes:
        start_state: The considered start state; a difference to the present one at first.
        path_constraints: Constraints on the path; None for none.
    """

    def __init__(self, node, group, end_effector_link):
        self._node, self._group, self._link = node, group, end_effector_link
        self._state: Any = None
        self._tolerance = 1e-4
        self._goal_constraints: list[Any] = []
        self.path_constraints: Any = None
        self.start_state = message("moveit_msgs/RobotState", is_diff=True)
        self.scaling = 0.1
        # RobotModelLoader: parameters of the own node, else the latched topics.
        self._event = node.create_publisher(
            get_message("std_msgs/msg/String"), "trajectory_execution_event", 1
        )
        self._attached = node.create_publisher(
            get_message("moveit_msgs/msg/AttachedCollisionObject"), "attached_collision_object", 1
        )
        node.create_subscription(
            get_message("sensor_msgs/msg/JointState"), "joint_states", self._on_state, 10
        )
        self._move = ActionClient(node, MoveGroup, "move_action")
        self._execute = ActionClient(node, ExecuteTrajectory, "execute_trajectory")
        assert self._move.wait_for_server(LONGEST_S)
        assert self._execute.wait_for_server(LONGEST_S)
        self._clients: dict[str, Any] = {}

    def _on_state(self, state):
        self._state = state

    def _call(self, kind, name, **fields):
        service = get_service(f"moveit_msgs/srv/{kind}")
        client = self._clients.get(name)
        if client is None:
            client = self._clients[name] = self._node.create_client(service, name)
            assert client.wait_for_service(LONGEST_S)
        future = client.call_async(service.Request(**fields))
        assert future.wait(LONGEST_S)
        return future.result()

    # --- state ------------------------------------------------------------------------------------

    def get_current_state(self):
        """Wait for a state that is newer than the call; return positions by joint."""
        before = to_nanoseconds(self._state.header.stamp) if self._state else 0
        eventually(lambda: self._state and to_nanoseconds(self._state.header.stamp) > before)
        return dict(zip(self._state.name, self._state.position, strict=True))

    def set_start_state(self, positions):
        state = message("moveit_msgs/RobotState")
        state.joint_state.name = list(positions)
        state.joint_state.position = list(positions.values())
        state.joint_state.velocity = [0.0] * len(positions)
        state.multi_dof_joint_state.header.frame_id = "world"
        self.start_state = state

    # --- targets ----------------------------------------------------------------------------------

    def set_joint_value_target(self, positions):
        made = message("moveit_msgs/Constraints")
        for name, at in positions.items():
            made.joint_constraints.append(
                message(
                    "moveit_msgs/JointConstraint",
                    joint_name=name,
                    position=at,
                    tolerance_above=self._tolerance,
                    tolerance_below=self._tolerance,
                    weight=1.0,
                )
            )
        self._goal_constraints = [made]

    def set_pose_target(self, pose, frame="world"):
        """kinematic_constraints::constructGoalConstraints(link, pose, tolerances)."""
        position = message("moveit_msgs/PositionConstraint", link_name=self._link, weight=1.0)
        position.header.frame_id = frame
        ball = message("shape_msgs/SolidPrimitive", type=2, dimensions=[self._tolerance])
        center = message("geometry_msgs/Pose", position=pose.position)
        center.orientation.w = 1.0
        position.constraint_region.primitives = [ball]
        position.constraint_region.primitive_poses = [center]
        turn = message(
            "moveit_msgs/OrientationConstraint",
            link_name=self._link,
            orientation=pose.orientation,
            absolute_x_axis_tolerance=1e-3,
            absolute_y_axis_tolerance=1e-3,
            absolute_z_axis_tolerance=1e-3,
            weight=1.0,
        )
        turn.header.frame_id = frame
        made = message("moveit_msgs/Constraints")
        made.position_constraints, made.orientation_constraints = [position], [turn]
        self._goal_constraints = [made]

    def set_position_target(self, x, y, z):
        pose = message("geometry_msgs/Pose")
        pose.position.x, pose.position.y, pose.position.z = x, y, z
        pose.orientation.w = 1.0
        self.set_pose_target(pose)
        self._goal_constraints[0].orientation_constraints = []

    # --- planning and moving ----------------------------------------------------------------------

    def _goal(self, *, plan_only):
        goal = MoveGroup.Goal()
        request, options = goal.request, goal.planning_options
        request.group_name, request.num_planning_attempts = self._group, 1
        request.allowed_planning_time = 5.0
        request.max_velocity_scaling_factor = self.scaling
        request.max_acceleration_scaling_factor = self.scaling
        request.start_state = self.start_state
        request.goal_constraints = self._goal_constraints
        if self.path_constraints is not None:
            request.path_constraints = self.path_constraints
        options.plan_only = plan_only
        options.replan_delay = 0.0 if plan_only else 2.0
        options.planning_scene_diff.is_diff = True
        options.planning_scene_diff.robot_state.is_diff = True
        return goal

    def plan(self):
        """Return the action's status and result."""
        return self._wait(self._send(self._move, self._goal(plan_only=True)))

    def move(self):
        return self._wait(self._send(self._move, self._goal(plan_only=False)))

    def async_move(self):
        """Return the goal's handle, as the C++ client keeps it."""
        return self._send(self._move, self._goal(plan_only=False))

    def execute(self, trajectory):
        return self._wait(self._send(self._execute, ExecuteTrajectory.Goal(trajectory=trajectory)))

    def _send(self, client, goal):
        sent = client.send_goal_async(goal)
        assert sent.wait(LONGEST_S)
        assert sent.result().accepted
        return sent.result()

    def _wait(self, handle):
        ended = handle.get_result_async()
        assert ended.wait(LONGEST_S)
        return ended.result().status, ended.result().result

    wait = _wait

    def stop(self):
        self._event.publish(message("std_msgs/String", data="stop"))

    def compute_cartesian_path(self, waypoints, step):
        """Return the fraction, -1 for none, and the trajectory."""
        request = {
            "start_state": self.start_state,
            "group_name": self._group,
            "waypoints": waypoints,
            "max_step": step,
            "avoid_collisions": True,
            "link_name": self._link,
            "max_velocity_scaling_factor": self.scaling,
            "max_acceleration_scaling_factor": self.scaling,
            "header": message("std_msgs/Header", frame_id="world"),
        }
        response = self._call("GetCartesianPath", "compute_cartesian_path", **request)
        return response.fraction if response.error_code.val == 1 else -1.0, response.solution

    # --- objects ----------------------------------------------------------------------------------

    def attach_object(self, name):
        attached = message("moveit_msgs/AttachedCollisionObject", link_name=self._link)
        attached.object.id, attached.object.operation = name, b"\x00"
        attached.touch_links = [self._link]
        self._attached.publish(attached)

    def detach_object(self, name="", link=""):
        attached = message("moveit_msgs/AttachedCollisionObject", link_name=link)
        attached.object.id, attached.object.operation = name, b"\x01"
        self._attached.publish(attached)

    # --- planners ---------------------------------------------------------------------------------

    def get_interface_descriptions(self):
        return self._call("QueryPlannerInterfaces", "query_planner_interface").planner_interfaces

    def get_planner_params(self, planner, group=""):
        response = self._call(
            "GetPlannerParams", "get_planner_params", planner_config=planner, group=group
        )
        return dict(zip(response.params.keys, response.params.values, strict=True))

    def set_planner_params(self, planner, group, params):
        given = message("moveit_msgs/PlannerParams", keys=[*params], values=[*params.values()])
        self._call(
            *("SetPlannerParams", "set_planner_params"),
            planner_config=planner,
            group=group,
            params=given,
            replace=False,
        )

    # --- PlanningSceneInterface -------------------------------------------------------------------

    def _scene(self, components):
        wanted = message("moveit_msgs/PlanningSceneComponents", components=components)
        return self._call("GetPlanningScene", "get_planning_scene", components=wanted).scene

    def get_known_object_names(self):
        return {one.id for one in self._scene(8).world.collision_objects}

    def get_objects(self):
        return {one.id: one for one in self._scene(16).world.collision_objects}

    def get_attached_objects(self):
        state = self._scene(4).robot_state
        return {one.object.id: one for one in state.attached_collision_objects}

    def apply_collision_objects(self, objects):
        scene = message("moveit_msgs/PlanningScene", is_diff=True)
        scene.robot_state.is_diff = True
        scene.world.collision_objects = objects
        return self._call("ApplyPlanningScene", "apply_planning_scene", scene=scene).success

    def remove_collision_objects(self, names):
        return self.apply_collision_objects(
            [message("moveit_msgs/CollisionObject", id=name, operation=b"\x01") for name in names]
        )
