"""Executable ``mujoco_sim``: physics of a robot in lockstep with its controllers.

Published topics: ``/clock``, ``/robot_joint_states`` (at each control tick), the topics of the
description's sensors, ``/mujoco_sim/world_markers`` (shapes of the world), and, while they have a
subscriber, ``/mujoco_sim/joint_states`` (for viewers), ``/mujoco_sim/free_joint_states`` and
``/tf`` (free bodies), ``/mujoco_sim/contacts`` (all contacts), ``/performance_metrics`` (measured
real-time factor). Subscribed topics: ``/robot_description`` unless the parameter of that name is
given, ``/robot_joint_commands``. Services: ``~/set_pause``, ``~/step_simulation``,
``~/reset_world``, ``~/save_world``, ``~/set_free_joint_state``.

Parameters: ``robot_description``, ``world`` (a file, see `teleopctl.robot.read_world`),
``update_rate`` (control rate in Hz), ``timestep`` (longest physics step in s; 0: that of an MJCF
file, else 1 ms), ``real_time_factor`` (0: as fast as possible; settable at runtime), ``gravity``
(m/s²; settable at runtime), ``paused``, ``lockstep_timeout`` (s of wall time), ``state_rate`` (Hz,
for viewers), ``end_time`` (simulated time in s at which the node exits; 0: never), ``mass_scale``
and ``friction_scale`` (factors on the described values), ``joint_states_topic``,
``joint_commands_topic``.

``--controller-manager 'ARGUMENTS'`` hosts a controller manager in this process, with these ROS
arguments; see `teleopctl.nodes.hosted_control`. With ``--unless-running``, one that runs already
controls the robot instead.
"""

from __future__ import annotations

import contextlib
import importlib
import os
import shlex
import sys

from teleopctl.base import progress
from teleopctl.errors import UsageError
from teleopctl.node import ExternalShutdownException, init, parse_ros_arguments, spin
from teleopctl.nodes.argument_parser import ArgumentParser
from teleopctl.nodes.single_instance import require_single_instance


def main(args: list[str] | None = None) -> int:
    """Run the node ``mujoco_sim`` until Ctrl-C or a shutdown, and return the exit status.

    Raises:
        TeleopctlError: A simulator of the same name runs already.
    """
    _render_nothing()
    from teleopctl.sim import MujocoSim

    arguments = sys.argv if args is None else args
    hosted, unless_running = _manager_arguments(list(parse_ros_arguments(arguments).program[1:]))
    with contextlib.ExitStack() as stack:
        stack.enter_context(contextlib.suppress(KeyboardInterrupt, ExternalShutdownException))
        stack.enter_context(init(args=arguments, publishes_after_signal=True))
        if hosted is None:
            node = stack.enter_context(MujocoSim())
            require_single_instance(node)
        else:
            from teleopctl.nodes.hosted_control import MemoryChannel, hosted_control

            progress.report(progress.STARTING, part=progress.CONTROL)
            channel = MemoryChannel()
            node = stack.enter_context(MujocoSim(channel))
            channel.set_simulator(node)
            require_single_instance(node)
            stack.enter_context(
                hosted_control(node, channel, hosted, unless_running=unless_running)
            )
        spin(node)
    return 0


def preload() -> None:
    """Import the modules that the simulator needs for a robot with controllers."""
    _render_nothing()
    for module in (
        "teleopctl.control.controller_manager_node",
        "teleopctl.nodes.hosted_control",
        "teleopctl.sim.node",
    ):
        importlib.import_module(module)


def _render_nothing() -> None:
    # The simulator renders nothing, so MUJOCO_GL and its errors concern the camera node only.
    # mujoco reads the variable at import.
    os.environ["MUJOCO_GL"] = "disable"


def _manager_arguments(words: list[str]) -> tuple[list[str] | None, bool]:
    """Return the command line of the manager to host, None for none, and ``--unless-running``.

    Raises:
        UsageError: There are other arguments, or the command line has an open quotation mark.
    """
    parser = ArgumentParser(prog="mujoco_sim", allow_abbrev=False)
    parser.add_argument(
        "--controller-manager",
        metavar="ARGUMENTS",
        default="",
        help="host a controller manager in this process, with these ROS arguments; empty for none",
    )
    parser.add_argument(
        "--unless-running",
        action="store_true",
        help="let a controller manager of that name, if one runs already, control the robot",
    )
    options = parser.parse_args(words)
    given = options.controller_manager
    try:
        hosted = shlex.split(given)
    except ValueError as error:
        raise UsageError(f"Cannot split --controller-manager={given!r}: {error}") from error
    return (["controller_manager", *hosted] if hosted else None), options.unless_running
