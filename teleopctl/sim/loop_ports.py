"""What the lockstep loop takes and gives: commands in, states and poses out. No topics."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Protocol


@dataclass(frozen=True)
class Command:
    """Joint commands of a controller; see `Simulation.apply`.

    Attributes:
        stamp_ns: The time of the state that it answers; 0 for a sender that keeps no step.
        names: Joint names.
        position: Positions, one per name, or empty.
        velocity: Velocities, one per name, or empty.
        effort: Efforts, one per name, or empty.
    """

    stamp_ns: int
    names: list[str] = field(default_factory=list)
    position: list[float] = field(default_factory=list)
    velocity: list[float] = field(default_factory=list)
    effort: list[float] = field(default_factory=list)


@dataclass(eq=False)
class Steps:
    """Requested physics steps.

    Attributes:
        left: How many are still to be made.
        on_end: Told whether all were made.
    """

    left: int
    on_end: Callable[[bool], None]


class Ports(Protocol):
    """Interface of the loop's outputs. Called on the loop's thread."""

    def publish_clock(self, time_ns: int) -> None:
        """Publish the simulated time."""

    def publish_state(self, time_ns: int) -> None:
        """Publish the joint states of a control tick, for the controller."""

    def publish_view(self, time_ns: int) -> None:
        """Publish the states for viewers."""

    def controller_lost(self, time_ns: int, waited_s: float) -> None:
        """Report that the controller did not answer the state of a time."""

    def controller_back(self, time_ns: int) -> None:
        """Report that the controller answers again."""

    def fell_behind(self, seconds: float, factor: float) -> None:
        """Report lost wall time, with the real-time factor of the last second."""

    def diverged(self, time_ns: int) -> None:
        """Report that the robot's physics became unstable and was reset."""

    def commands_cut(self, sentences: Sequence[str]) -> None:
        """Report commands that exceed joints' limits for the first time, a sentence each."""

    def put_back(self, time_ns: int, things: Sequence[str]) -> None:
        """Report that the physics of objects became unstable, and that these were reset."""


class Sampler(Protocol):
    """Interface of sensors, which measure at times of their own. Called on the loop's thread."""

    def next_ns(self) -> int | None:
        """Return the simulated time of the next measurement; None if there is none."""

    def sample(self, time_ns: int) -> None:
        """Publish the measurements that are due at a time."""

    def show(self, time_ns: int) -> None:
        """Publish the present state again, after a change or on request."""
