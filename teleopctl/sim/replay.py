"""A session in lockstep once more: the same commands at the same ticks, in memory."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from teleopctl.interfaces import get_message, set_stamp
from teleopctl.sim.lockstep import LockstepLoop
from teleopctl.sim.loop_ports import Command
from teleopctl.sim.ports import reported_joints
from teleopctl.sim.simulation import Simulation

if TYPE_CHECKING:
    from sensor_msgs.msg import JointState


def replay_session(
    simulation: Simulation,
    commands: Mapping[int, JointState],
    end_ns: int,
    on_state: Callable[[int, JointState], object],
) -> None:
    """Run a simulation with commands that are at hand, as fast as the machine allows.

    It is the loop of `MujocoSim`, so that it gives the same bits. Where a state has no command,
    nobody answered it, and the joints hold as they did then.

    Args:
        simulation: At its start.
        commands: What answers the state of a simulated time, in nanoseconds.
        end_ns: Simulated time of the last state, in nanoseconds.
        on_state: Called with each simulated time and the state of it, which is valid meanwhile.
    """
    ports = _Ports(simulation, commands, end_ns, on_state)
    # What it waits for is there already: no wait is worth its time.
    ports.loop = LockstepLoop(simulation, ports, real_time_factor=0.0, lockstep_timeout_s=0.0)
    ports.loop.run()


class _Ports:
    """Answers each state from the recording; see `teleopctl.sim.loop_ports.Ports`."""

    loop: LockstepLoop

    def __init__(
        self,
        simulation: Simulation,
        commands: Mapping[int, JointState],
        end_ns: int,
        on_state: Callable[[int, JointState], object],
    ) -> None:
        self._simulation = simulation
        self._commands = commands
        self._end_ns = end_ns
        self._on_state = on_state
        self._reported = reported_joints(simulation.model)
        names = [simulation.joint_names[index] for index in self._reported]
        self._state: JointState = get_message("sensor_msgs/msg/JointState")(name=names)

    def publish_state(self, time_ns: int) -> None:
        """Show the state, and answer it."""
        state, simulation = self._state, self._simulation
        set_stamp(state.header.stamp, time_ns)
        state.position = simulation.positions[self._reported]
        state.velocity = simulation.velocities[self._reported]
        state.effort = simulation.efforts[self._reported]
        self._on_state(time_ns, state)
        command = self._commands.get(time_ns)
        self.loop.set_partner(command is not None)
        if command is not None:
            self.loop.offer(
                Command(
                    time_ns,
                    list(command.name),
                    list(command.position),
                    list(command.velocity),
                    list(command.effort),
                )
            )
        if time_ns >= self._end_ns:
            self.loop.stop()

    def publish_clock(self, time_ns: int) -> None:
        """Do nothing: nobody else has a clock here."""

    def publish_view(self, time_ns: int) -> None:
        """Do nothing: nobody looks."""

    def controller_lost(self, time_ns: int, waited_s: float) -> None:
        """Do nothing: it was lost then too."""

    def controller_back(self, time_ns: int) -> None:
        """Do nothing: it came back then too."""

    def fell_behind(self, seconds: float, factor: float) -> None:
        """Do nothing: there is no pace to hold."""

    def diverged(self, time_ns: int) -> None:
        """Do nothing: what became of it is in the states."""
