"""Servo's status in words for people: what stops the arm, and what to do.

Servo's code and text are the truth, and are shown beside these sentences. They are one table, for
the drive page and for the terminals.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass
from functools import cache

from teleopctl.kinematics import FOLDED, STRETCHED, StatusCode
from teleopctl.robot import RobotDescription

_HAND = "The gripper"


@dataclass(frozen=True, slots=True)
class ServoSentence:
    """Row of the table: the sentence for a code, where servo's text has what a pattern says.

    Attributes:
        code: Servo's code.
        pattern: Regular expression that is searched in servo's text; empty for any text.
        sentence: The sentence, with the pattern's groups by name. ``one`` and ``other`` are two
            bodies: parts of the gripper are called the gripper, and stand first.
    """

    code: StatusCode
    pattern: str
    sentence: str


_JOINT = r"joint '(?P<joint>[^']+)'"
_BODIES = r"'(?P<one>[^']+)' is [\d.]+ m from '(?P<other>[^']+)'"
_HERE = "The arm does not get further that way from here"

SERVO_SENTENCES = (
    ServoSentence(
        StatusCode.HALT_FOR_COLLISION,
        _BODIES,
        "{one} would touch {other}: move the other way",
    ),
    ServoSentence(
        StatusCode.HALT_FOR_COLLISION,
        "",
        "The arm would touch something: move the other way",
    ),
    ServoSentence(
        StatusCode.DECELERATE_FOR_COLLISION,
        _BODIES,
        "{one} is close to {other}, so the arm moves slower: move the other way",
    ),
    ServoSentence(
        StatusCode.DECELERATE_FOR_COLLISION,
        "",
        "Something is close, so the arm moves slower: move the other way",
    ),
    *(
        row
        for code, nearly in (
            (StatusCode.HALT_FOR_SINGULARITY, ""),
            (StatusCode.DECELERATE_FOR_APPROACHING_SINGULARITY, "nearly "),
        )
        for row in (
            ServoSentence(
                code,
                re.escape(STRETCHED),
                f"The arm is {nearly}stretched to its end: move back towards its base",
            ),
            ServoSentence(
                code,
                re.escape(FOLDED),
                f"The arm is {nearly}folded to its end: move away from its base",
            ),
        )
    ),
    ServoSentence(
        StatusCode.HALT_FOR_SINGULARITY,
        r"no motion about",
        "The wrist does not turn further that way from here: tilt the gripper another way first",
    ),
    ServoSentence(StatusCode.HALT_FOR_SINGULARITY, "", f"{_HERE}: move another way first"),
    ServoSentence(
        StatusCode.DECELERATE_FOR_APPROACHING_SINGULARITY,
        "",
        "The arm can hardly move that way from here: move another way first",
    ),
    ServoSentence(
        StatusCode.DECELERATE_FOR_LEAVING_SINGULARITY,
        "",
        "The arm moves slowly out of a pose in which it was stuck: go on",
    ),
    ServoSentence(
        StatusCode.JOINT_BOUND,
        _JOINT,
        "{joint} is at its limit: move back, or another way",
    ),
    ServoSentence(
        StatusCode.JOINT_BOUND,
        "",
        "A joint is at its limit: move back, or another way",
    ),
    ServoSentence(
        StatusCode.NO_WARNING,
        r"(?P<count>\d+) joints cannot turn the tool in place",
        "With {count} joints this arm cannot turn its gripper in place: move it instead",
    ),
    ServoSentence(
        StatusCode.INVALID,
        r"stopped by (?P<who>.+)",
        "The robot is stopped by {who}: release it first",
    ),
    ServoSentence(
        StatusCode.INVALID,
        r"(?P<who>\S+) executes a trajectory",
        "The arm carries out a motion of {who}: wait until it has ended",
    ),
    ServoSentence(
        StatusCode.INVALID,
        r"no active controllers command",
        "No controller of the arm is active: activate one in the 3D page's panel Controllers",
    ),
    ServoSentence(
        StatusCode.INVALID,
        rf"{_JOINT} is [\d.]+ from where it was commanded",
        "{joint} is not where it was sent, as if it was held: let go, and press again",
    ),
    ServoSentence(
        StatusCode.INVALID,
        r"servo was suspended",
        "The program that moves the arm stood still for a moment: let go, and press again",
    ),
    ServoSentence(
        StatusCode.INVALID,
        r"no robot description",
        "The robot is not known yet: wait a moment",
    ),
    ServoSentence(
        StatusCode.INVALID,
        r"no states",
        "The arm does not report where its joints are: is it switched on?",
    ),
    ServoSentence(
        StatusCode.INVALID,
        "",
        "The arm cannot carry that out: let go, and press again",
    ),
)
"""The table: of the rows of a code, the first whose pattern is found in servo's text counts."""

OUT_OF_REACH = "The arm does not get there: drag the handle to a nearer place"
"""Sentence for a handle that the arm does not follow, where servo gives no reason."""


def words_of_status(code: int, text: str, gripper: Collection[str] = ()) -> str:
    """Return servo's status as one sentence for people; empty if nothing is slowed down.

    Args:
        code: Code of a ``moveit_msgs/msg/ServoStatus``.
        text: Its text.
        gripper: Names of the links of the gripper, which people see as one.
    """
    for row in SERVO_SENTENCES:
        if row.code == code and (found := _compiled(row.pattern).search(text)) is not None:
            return row.sentence.format_map(_named(found.groupdict(), gripper))
    return ""


def hand_links(description: RobotDescription, tip: str) -> frozenset[str]:
    """Return the links that move with a tip, and what is moved at them: the gripper."""
    above = {joint.child: joint for joint in description.joints.values()}
    first = tip
    while first in above and above[first].type == "fixed":
        first = above[first].parent
    found, below = {first}, [first]
    while below:
        parent = below.pop()
        new = {joint.child for joint in description.joints.values() if joint.parent == parent}
        below += new - found
        found |= new
    return frozenset(found)


@cache
def _compiled(pattern: str) -> re.Pattern[str]:
    return re.compile(pattern)


def _named(groups: dict[str, str], gripper: Collection[str]) -> dict[str, str]:
    """Return the groups of a row, with two bodies as people name them, the gripper first."""
    if "one" not in groups:
        return groups
    one, other = groups["one"], groups["other"]
    if other in gripper and one not in gripper:
        one, other = other, one
    is_hand = one in gripper and other not in gripper  # its fingers may touch each other
    return {**groups, "one": _HAND if is_hand else f"'{one}'", "other": f"'{other}'"}
