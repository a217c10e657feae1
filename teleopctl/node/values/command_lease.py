"""Command lease of a robot: which node may stream commands to controllers and servo.

Without a lease every node may. While a node holds one, only it may, and the nodes through which its
commands go. Of two claims the one with the higher term counts, then the earlier one, so that all
that receive both decide alike. A lease ends by its release, after `SILENCE_S` without a claim, with
the holder's node, and when the robot is stopped.
"""

from __future__ import annotations

from dataclasses import dataclass

SILENCE_S = 2.0
"""Age of the holder's last claim at which its lease ends, s."""

STREAM_FRAME = "stream"
"""``frame_id`` of a JointTrajectory that gives way to the goal of an action, as those of servo.

One that is on its way when a goal is accepted would replace the trajectory of the goal, which then
succeeds elsewhere. ROS 2's controllers ignore the ``frame_id``.
"""


@dataclass(frozen=True, slots=True)
class LeaseClaim:
    """Claim of a node to drive a robot, as on ``/teleop/lease``.

    Attributes:
        holder: Full name of the node.
        device: Name of its device, such as ``gamepad``.
        host: Name of its machine.
        since_ns: Beginning of the lease, in nanoseconds since the epoch.
        term: Number of the lease; a later one has a higher number.
        through: Full names of the nodes that carry out the holder's commands.
    """

    holder: str
    device: str = ""
    host: str = ""
    since_ns: int = 0
    term: int = 0
    through: tuple[str, ...] = ()

    def goes_before(self, other: LeaseClaim) -> bool:
        """Return whether this claim counts and the other one does not."""
        own = (-self.term, self.since_ns, self.holder)
        return own < (-other.term, other.since_ns, other.holder)

    def is_of(self, other: LeaseClaim) -> bool:
        """Return whether both are claims of one lease."""
        return (self.holder, self.term) == (other.holder, other.term)

    def __str__(self) -> str:
        where = ", ".join(filter(None, (self.device, self.host and f"on {self.host}")))
        return f"{self.holder} ({where})" if where else self.holder


class CommandLease:
    """Command lease of a robot, from the received claims.

    All times are on one monotonic clock, s.
    """

    def __init__(self) -> None:
        self._claim: LeaseClaim | None = None
        self._received_s = 0.0
        self._term = 0

    @property
    def term(self) -> int:
        """Highest term of all claims so far."""
        return self._term

    def holder(self, now_s: float) -> LeaseClaim | None:
        """Return the valid claim at a time; None if no node holds the lease."""
        if self._claim is not None and now_s - self._received_s > SILENCE_S:
            self._claim = None
        return self._claim

    def receive(self, claim: LeaseClaim, now_s: float, *, is_held: bool = True) -> None:
        """Process a claim, or its end.

        Args:
            claim: The claim.
            now_s: Time of its receipt.
            is_held: Whether the lease is held; False ends it, and those of lower terms.
        """
        present = self.holder(now_s)
        self._term = max(self._term, claim.term)
        if present is not None and not claim.is_of(present) and not claim.goes_before(present):
            return
        self._claim = claim if is_held else None
        self._received_s = now_s

    def end(self) -> None:
        """End the lease: the robot is stopped, or the holder's node has gone."""
        self._claim = None

    def refusal(self, sender: str, now_s: float) -> str:
        """Return why a node may not command at a time, as a sentence; empty if it may.

        Args:
            sender: Full name of the node; empty for one that is unknown.
            now_s: The time.
        """
        claim = self.holder(now_s)
        if claim is None or sender == claim.holder or (sender and sender in claim.through):
            return ""
        return f"{claim} drives the robot; 'teleopctl drive --release' ends that"
