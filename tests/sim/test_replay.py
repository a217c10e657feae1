"""A session that is simulated once more, with the commands that it had, has the same bits."""

from __future__ import annotations

import copy
import math
import threading

import pytest
from sensor_msgs.msg import JointState

from teleopctl.sim import Simulation, run_in_lockstep
from teleopctl.sim.lockstep import Command, LockstepLoop
from tests.samples import sample
from tests.sim.robots import pendulum
from tests.sim.test_lockstep import Recorder

PERIOD_NS = 10_000_000
END_NS = 60 * PERIOD_NS


def simulation():
    return Simulation(pendulum(), control_period_ns=PERIOD_NS)


def command(time_ns):
    name = simulation().joint_names[0]
    return JointState(name=[name], position=[0.3 * math.sin(5.0 * time_ns * 1e-9)])


def played(commands):
    states = []

    def answer(time_ns, state):
        states.append(copy.deepcopy(state))
        return commands.get(time_ns)

    run_in_lockstep(simulation(), answer, lambda time_ns: time_ns < END_NS)
    return states


def run_live(answered):
    """Run the loop beside a controller that answers some states, and is gone at the others."""
    live = simulation()
    ports = Recorder()
    loop = LockstepLoop(live, ports, real_time_factor=0.0, lockstep_timeout_s=5.0)
    states = []

    def answer(time_ns):
        states.append((list(live.positions), list(live.velocities), list(live.efforts)))
        loop.set_controller_present(time_ns in answered)
        if time_ns in answered:
            message = command(time_ns)
            given = Command(time_ns, list(message.name), list(message.position))
            # As in life: it comes while the loop waits.
            threading.Thread(target=loop.receive_command, args=(given,)).start()
        if time_ns >= END_NS:
            loop.stop()

    ports.on_state = answer
    loop.run()
    return states


@pytest.mark.parametrize(
    "answered",
    sample(
        [
            pytest.param(range(0, END_NS, PERIOD_NS), id="always"),
            pytest.param(range(20 * PERIOD_NS, END_NS, PERIOD_NS), id="from some time on"),
            pytest.param([], id="never"),
            pytest.param(
                [
                    *range(5 * PERIOD_NS, 20 * PERIOD_NS, PERIOD_NS),
                    *range(40 * PERIOD_NS, END_NS, PERIOD_NS),
                ],
                id="gone for a while",
            ),
        ],
        4,
    ),
)
def test_a_replay_has_the_bits_of_the_session(answered):
    states = played({time_ns: command(time_ns) for time_ns in answered})
    assert [
        (list(state.position), list(state.velocity), list(state.effort)) for state in states
    ] == run_live(set(answered))


@pytest.mark.nightly
def test_another_command_gives_other_bits():
    commands = {time_ns: command(time_ns) for time_ns in range(0, END_NS, PERIOD_NS)}
    states = played(commands)
    commands[30 * PERIOD_NS].position[0] += 1e-9
    others = played(commands)
    assert states[:31] == others[:31]
    assert states[31] != others[31]
