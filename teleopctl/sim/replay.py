"""The simulator's loop in memory: with the commands of a recording, or with any that answer."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
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

    def answer(time_ns: int, state: JointState) -> JointState | None:
        on_state(time_ns, state)
        return commands.get(time_ns)

    run_in_lockstep(simulation, answer, lambda time_ns: time_ns < end_ns)


def run_in_lockstep(
    simulation: Simulation,
    answer: Callable[[int, JointState], JointState | None],
    goes_on: Callable[[int], bool],
) -> None:
    """Run a simulation with whoever answers its states, as fast as the machine allows.

    Args:
        simulation: At its start.
        answer: Given each simulated time, in nanoseconds, and the state of it, which is valid
            meanwhile; returns the command, or None where nobody answers.
        goes_on: Whether there is anything after the state of a time, which has been answered.
    """
    ports = _Ports(simulation, answer, goes_on)
    # What it waits for is there already: no wait is worth its time.
    ports.loop = LockstepLoop(simulation, ports, real_time_factor=0.0, lockstep_timeout_s=0.0)
    ports.loop.run()


class _Ports:
    """Has each state answered in memory; see `teleopctl.sim.loop_ports.Ports`."""

    loop: LockstepLoop

    def __init__(
        self,
        simulation: Simulation,
        answer: Callable[[int, JointState], JointState | None],
        goes_on: Callable[[int], bool],
    ) -> None:
        self._simulation = simulation
        self._answer = answer
        self._goes_on = goes_on
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
        command = self._answer(time_ns, state)
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
        if not self._goes_on(time_ns):
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

    def put_back(self, time_ns: int, things: Sequence[str]) -> None:
        """Do nothing: likewise."""
