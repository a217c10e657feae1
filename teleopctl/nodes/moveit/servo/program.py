"""Executable ``moveit_servo/servo_node``: a stream of commands becomes safe joint commands.

Subscribed topics: ``~/delta_twist_cmds`` (TwistStamped), ``~/delta_joint_cmds`` (JointJog),
``~/pose_target_cmds`` (PoseStamped), ``/joint_states``, ``/robot_description`` unless the parameter
of that name is given, ``/stop``. Published topics: ``~/status`` (ServoStatus), and the command
topic of each controller that commands the group's joints. Services: ``~/switch_command_type``,
``~/pause_servo``. Parameters: those of MoveIt Servo below ``moveit_servo``, and ``task`` there;
``robot_description_semantic`` (text) or ``srdf`` (file); by default the description has the groups.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Sequence

from teleopctl.node import ExternalShutdownException, init, spin


def main(args: Sequence[str] | None = None) -> None:
    """Run the node ``servo_node`` until Ctrl-C or a shutdown.

    Raises:
        TeleopctlError: A parameter is invalid, or a node of the same name runs already.
    """
    # Nothing is rendered; mujoco reads the variable at import.
    os.environ["MUJOCO_GL"] = "disable"
    from teleopctl.nodes.moveit.servo.node import ServoNode
    from teleopctl.nodes.single_instance import require_single_instance

    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException), init(args=args):
        node = ServoNode()
        require_single_instance(node)
        spin(node)
