"""Status of a servo step: MoveIt Servo's codes, and the reasons in words."""

from __future__ import annotations

import enum
from dataclasses import dataclass

from teleopctl.kinematics.poses import Array

STRETCHED, FOLDED = "the arm is stretched out", "the arm is folded in"
"""Words in the text of a singularity's reason that is an end of the arm's reach."""


class StatusCode(enum.IntEnum):
    """Codes of ``moveit_msgs/msg/ServoStatus``."""

    INVALID = -1
    NO_WARNING = 0
    DECELERATE_FOR_APPROACHING_SINGULARITY = 1
    HALT_FOR_SINGULARITY = 2
    DECELERATE_FOR_LEAVING_SINGULARITY = 3
    DECELERATE_FOR_COLLISION = 4
    HALT_FOR_COLLISION = 5
    JOINT_BOUND = 6

    @property
    def text(self) -> str:
        """MoveIt Servo's sentence for the code."""
        return _TEXTS[self]


_TEXTS = {
    StatusCode.INVALID: "Invalid",
    StatusCode.NO_WARNING: "No warnings",
    StatusCode.DECELERATE_FOR_APPROACHING_SINGULARITY: (
        "Moving closer to a singularity, decelerating"
    ),
    StatusCode.HALT_FOR_SINGULARITY: "Very close to a singularity, emergency stop",
    StatusCode.DECELERATE_FOR_LEAVING_SINGULARITY: ("Moving away from a singularity, decelerating"),
    StatusCode.DECELERATE_FOR_COLLISION: "Close to a collision, decelerating",
    StatusCode.HALT_FOR_COLLISION: "Collision detected, emergency stop",
    StatusCode.JOINT_BOUND: "Close to a joint bound (position or velocity), halting",
}

# The code that is reported when several apply: the first.
_ORDER = (
    StatusCode.INVALID,
    StatusCode.HALT_FOR_COLLISION,
    StatusCode.HALT_FOR_SINGULARITY,
    StatusCode.JOINT_BOUND,
    StatusCode.DECELERATE_FOR_COLLISION,
    StatusCode.DECELERATE_FOR_APPROACHING_SINGULARITY,
    StatusCode.DECELERATE_FOR_LEAVING_SINGULARITY,
    StatusCode.NO_WARNING,
)


@dataclass(frozen=True, slots=True)
class Reason:
    """Why a step is slower than its command: code, and a phrase with the joint or bodies.

    Attributes:
        code: MoveIt Servo's code.
        text: The phrase.
        place: Where that is: the joint, or the point between the bodies, in the root link's frame,
            m; None for the tool.
    """

    code: StatusCode
    text: str
    place: tuple[float, float, float] | None = None


@dataclass(frozen=True, slots=True)
class ServoStep:
    """Joint command of one period.

    Attributes:
        positions: Positions of the group's independent joints at the end of the period, (n,).
        velocities: Velocities at the end of the period, (n,).
        is_moving: Whether any joint moves, or would if nothing kept it.
        reasons: What made the step slower than its command; empty if nothing did.
        scale: Part of the command's speed that is left, 0 to 1, before acceleration limits.
    """

    positions: Array
    velocities: Array
    is_moving: bool
    reasons: tuple[Reason, ...] = ()
    scale: float = 1.0

    @property
    def code(self) -> StatusCode:
        """The most important code of the reasons."""
        codes = {reason.code for reason in self.reasons}
        return next((code for code in _ORDER if code in codes), StatusCode.NO_WARNING)

    @property
    def message(self) -> str:
        """MoveIt's sentence for the code, then the reasons in words."""
        return f"{self.code.text}: {self.words}" if self.reasons else self.code.text

    @property
    def words(self) -> str:
        """The reasons in words, each once; empty for none."""
        return "; ".join(dict.fromkeys(reason.text for reason in self.reasons))
