"""Executable ``mujoco_sim``: physics of a robot in lockstep with its controllers.

Topics out: ``/clock``, ``/robot_joint_states`` (each control tick), ``/mujoco_sim/joint_states``
(for viewers, while somebody subscribes), ``/mujoco_sim/free_joint_states`` and ``/tf`` (what moves
freely, likewise), ``/mujoco_sim/contacts`` (all that touches, likewise), ``/performance_metrics``
(the real-time factor that is reached, likewise), ``/mujoco_sim/world_markers`` (what the world
looks like), and those of the description's sensors. In: ``/robot_description`` unless the
parameter of that name is given, ``/robot_joint_commands``. Services: ``~/set_pause``,
``~/step_simulation``, ``~/reset_world``, ``~/save_world``, ``~/set_free_joint_state``.

Parameters: ``robot_description``, ``world`` (a file, see `teleopctl.robot.read_world`),
``update_rate`` (Hz of control), ``timestep`` (s of physics, at most; 0 is what an MJCF file says,
and 1 ms for others), ``real_time_factor`` (0: as fast as possible; can be set while running),
``gravity`` (m/s²; likewise), ``paused``, ``lockstep_timeout`` (s of wall time), ``state_rate``
(Hz, for viewers), ``end_time`` (s of simulated time, then it ends; 0: never), ``mass_scale`` and
``friction_scale`` (factors to what is described), ``joint_states_topic``,
``joint_commands_topic``.
"""

from __future__ import annotations

import contextlib
import os

from teleopctl.node import ExternalShutdownException, init, spin
from teleopctl.nodes.single_instance import require_single_instance


def main(args: list[str] | None = None) -> int:
    """Run the node ``mujoco_sim`` until Ctrl-C or a shutdown, and return the exit status.

    Raises:
        TeleopctlError: A simulator of the same name runs already.
    """
    # The simulator renders nothing: MUJOCO_GL, and its errors, concern the camera node alone.
    # mujoco reads that when it is imported.
    os.environ["MUJOCO_GL"] = "disable"
    from teleopctl.sim import MujocoSim

    with (
        contextlib.suppress(KeyboardInterrupt, ExternalShutdownException),
        init(args=args, publishes_after_signal=True),
        MujocoSim() as node,
    ):
        require_single_instance(node)
        spin(node)
    return 0
