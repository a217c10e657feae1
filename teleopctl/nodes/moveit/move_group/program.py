"""Executable ``moveit_ros_move_group/move_group``: kinematics, scene, planning and execution.

Services: ``/compute_fk``, ``/compute_ik``, ``/check_state_validity``, ``/plan_kinematic_path``,
``/compute_cartesian_path``, ``/query_planner_interface``, ``/get_planner_params``,
``/set_planner_params``, ``/get_planning_scene``, ``/apply_planning_scene``. Actions:
``/move_action`` and ``/execute_trajectory``. Subscribed topics: ``/joint_states``,
``/robot_description`` and ``/robot_description_semantic`` unless the parameters of these names are
given, ``/planning_scene``, ``/collision_object``, ``/attached_collision_object``,
``/trajectory_execution_event``, ``/stop``, and ``/tf`` from the first request on that needs it.
Published topics: ``/monitored_planning_scene``, ``/display_planned_path``. Parameters: those of
MoveIt's configurations, and ``world_from_simulation``.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Sequence

from teleopctl.node import ExternalShutdownException, MultiThreadedExecutor, init

# Services of the scene, one planner, and callbacks of controllers and transforms.
_THREADS = 4


def main(args: Sequence[str] | None = None) -> None:
    """Run the node ``move_group`` until Ctrl-C or a shutdown.

    Raises:
        TeleopctlError: A parameter is invalid, or a node of the same name runs already.
    """
    # Nothing is rendered; mujoco reads the variable at import.
    os.environ["MUJOCO_GL"] = "disable"
    from teleopctl.nodes.moveit.move_group.node import MoveGroupNode
    from teleopctl.nodes.single_instance import require_single_instance

    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException), init(args=args):
        node = MoveGroupNode()
        require_single_instance(node)
        with MultiThreadedExecutor(_THREADS) as executor:
            executor.add_node(node)
            executor.spin()
