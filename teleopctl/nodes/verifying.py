"""Simulates a recorded session once more and compares: where `bag` and `sim` meet."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from teleopctl.bag import Verdict, open_bag, read_session
from teleopctl.errors import InvalidFileError

if TYPE_CHECKING:
    from sensor_msgs.msg import JointState

# The versions on which bits depend.
_LIBRARIES = ("mujoco", "numpy", "teleopctl")


class Verification(NamedTuple):
    """What came of it.

    Attributes:
        verdict: How the states compare.
        other_versions: Libraries that are of another version than then, with both; bits may differ.
        remarks: What may make it differ besides, one sentence each.
    """

    verdict: Verdict
    other_versions: dict[str, tuple[str, str]]
    remarks: list[str]


def verify_bag(
    path: Path,
    *,
    tolerance: float = 0.0,
    world: str | None = None,
    timestep_s: float | None = None,
    on_state: Callable[[int, JointState, JointState], object] = lambda *_: None,
) -> Verification:
    """Drive a simulator with the commands of a bag and compare its states with the recorded ones.

    Robot, period, timestep and world are those of the recording. It runs in this process, without
    a graph, and as fast as the machine allows.

    Args:
        path: The bag.
        tolerance: What two numbers may be apart; 0 asks for the same bits.
        world: Another world than the recorded one; empty for none.
        timestep_s: Another physics step than the recorded one, in seconds.
        on_state: Called with each simulated time in nanoseconds, the recorded state and the one of
            now, which is valid meanwhile.

    Raises:
        InvalidFileError: The bag has no whole session.
        InvalidDescriptionError: The robot or the world cannot be simulated.
        NotFoundError: The bag or the world is not there.
    """
    from teleopctl.sim import replay_session, simulate

    with open_bag(path) as bag:
        session = read_session(bag)
        remarks = list(bag.remarks)
    if session.other_commands:
        remarks.append(
            f"{session.other_commands} commands answer no state: when they took effect is not known"
        )
    for name, wanted in (("world", world), ("timestep", timestep_s)):
        if wanted is None and name not in session.parameters:
            remarks.append(f"The bag does not say which {name} it was; the default one is taken")
    robot = simulate(
        session.robot_description,
        world=str(session.parameters.get("world", "")) if world is None else world,
        mass_scale=_number(session.parameters.get("mass_scale"), 1.0),
        friction_scale=_number(session.parameters.get("friction_scale"), 1.0),
        control_period_ns=session.period_ns,
        # 0 is the model's own.
        timestep_ns=round(1e9 * (timestep_s or _number(session.parameters.get("timestep"), 0.0))),
    )
    verdict = Verdict(tolerance)

    def compare(time_ns: int, now: JointState) -> None:
        recorded = session.states[time_ns]
        verdict.compare(time_ns, recorded, now)
        on_state(time_ns, recorded, now)

    replay_session(robot.simulation, session.commands, max(session.states), compare)
    return Verification(verdict, _other_versions(session.versions), remarks)


def _number(value: object, default: float) -> float:
    if value is None:
        return default
    if isinstance(value, bool) or not isinstance(value, int | float) or not value >= 0:
        raise InvalidFileError(f"A recorded parameter is {value!r}, expected a number")
    return float(value)


def _other_versions(recorded: Mapping[str, str]) -> dict[str, tuple[str, str]]:
    here = {name: metadata.version(name) for name in _LIBRARIES}
    return {
        name: (recorded[name], here[name])
        for name in _LIBRARIES
        if name in recorded and recorded[name] != here[name]
    }
