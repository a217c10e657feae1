"""Leader and follower arms: mapping of joints, ramp at the start, and conditions of release.

Numbers in, numbers out: positions of the leader's joints in, those that the follower's joints shall
have out. A mapping is a YAML file per leader and robot::

    device: leader
    robot: ""                            # the follower; the file then applies to it alone
    by: joints                           # or pose: the gripper follows the leader's gripper
    joints: {shoulder: joint_1}          # the follower's joints by the leader's; the others by name
    signs: {shoulder: -1}                # of the leader's joints
    offsets: {shoulder: 0.1}             # rad or m, added
    gripper: {joint: jaw, closed: 0.0, open: 1.2}    # the leader's; by default its description's
    scale: 1.0                           # with pose: motion of the follower for one of the leader
"""

from __future__ import annotations

import enum
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from teleopctl.base.ros_yaml import faults_of, safe_load
from teleopctl.teleop.device import DeviceError
from teleopctl.teleop.mapping import FieldReader, check_robot, mapping_file, read_mapping

FOLDER = Path(__file__).with_name("mappings") / "leader"
RAMP = 0.5
"""Speed at which a follower goes to the leader's pose, rad/s."""
_RAMP_SLIDING = 0.1  # m/s
# Largest speed of a follower's target position, rad/s or m/s.
_FASTEST = 3.0
# Change of a leader's joint between two samples that counts as a jump, rad or m.
JUMP = 0.35
"""Change of a leader's joint from one sample to the next that ends the following, rad or m."""
# Distance of all joints at which the poses match, and longest time that a step counts, rad and s.
_MATCH, _LONGEST_STEP_S = 0.005, 0.1
_MOST_NAMED = 6

# Any, here: values of a YAML document.


@dataclass(frozen=True, slots=True)
class LeaderGripper:
    """Gripper of a leader.

    Attributes:
        joint: Its joint.
        closed: Position of the joint when it is closed, rad or m.
        open: Position of the joint when it is open, rad or m.
    """

    joint: str
    closed: float
    open: float

    def opening(self, position: float) -> float:
        """Return the opening of a position, from 0 (closed) to 1 (open)."""
        return min(max((position - self.closed) / (self.open - self.closed), 0.0), 1.0)


@dataclass(frozen=True, slots=True)
class LeaderMapping:
    """Mapping from a leader's joints to a follower's.

    Attributes:
        robot: Name of the follower for which it is; empty for any.
        by_pose: Whether the gripper's pose is followed, not the joints.
        joints: Names of the follower's joints by the leader's; joints of the same name need none.
        signs: Factors of the leader's joints that turn the other way.
        offsets: Offsets that are added to the leader's positions, rad or m.
        gripper: Gripper of the leader; None for that of its description.
        scale: With the pose: motion of the follower for one of the leader.
    """

    robot: str = ""
    by_pose: bool = False
    joints: Mapping[str, str] = field(default_factory=dict)
    signs: Mapping[str, float] = field(default_factory=dict)
    offsets: Mapping[str, float] = field(default_factory=dict)
    gripper: LeaderGripper | None = None
    scale: float = 1.0

    @classmethod
    def load(cls, name: str | Path, robot: str = "") -> LeaderMapping:
        """Read a mapping by its name or path; of a name, that for a robot if there is one.

        Args:
            name: Name of a mapping that comes with teleopctl, or a path of a YAML file.
            robot: Name of the robot that follows.

        Raises:
            NotFoundError: There is no such mapping.
            InvalidFileError: The file cannot be read, is no mapping, or is for another robot.
        """
        path = mapping_file(name, robot, FOLDER)
        text = read_mapping(path)
        with faults_of(path):
            mapping = _Reader(path, text).mapping(safe_load(text))
        check_robot(path, mapping.robot, robot)
        return mapping

    def of_follower(self, leader: Mapping[str, float]) -> dict[str, float]:
        """Return the positions of a leader's joints by the follower's names, rad or m."""
        return {
            self.joints.get(name, name): self.signs.get(name, 1.0) * at
            + self.offsets.get(name, 0.0)
            for name, at in leader.items()
        }

    def check(self, leader: Iterable[str], follower: Iterable[str]) -> None:
        """Raise an error unless the leader has a joint for each of the follower's.

        Args:
            leader: Names of the leader's joints.
            follower: Names of the follower's joints.

        Raises:
            DeviceError: A joint is missing.
        """
        leader, follower = list(leader), list(follower)
        strange = [name for name in (*self.joints, *self.signs) if name not in leader]
        if strange:
            raise DeviceError(
                f"The leader has no joint '{strange[0]}', which the mapping names; it has "
                f"{_listed(leader)}"
            )
        found = self.of_follower(dict.fromkeys(leader, 0.0))
        if missing := [name for name in follower if name not in found]:
            raise DeviceError(
                f"The leader has no joint for {_listed(missing)} of the follower; it has "
                f"{_listed(leader)}",
                hint="Name it in the mapping's 'joints', or follow the gripper with 'by: pose'.",
            )


_KEYS = ("device", "robot", "by", "joints", "signs", "offsets", "gripper", "scale")
_GRIPPER = ("joint", "closed", "open")


class _Reader(FieldReader):
    """Reader of a leader's mapping, whose errors name the place."""

    def mapping(self, document: Any) -> LeaderMapping:
        fields = self.table(document, "", _KEYS)
        if fields.get("device") != "leader":
            raise self.error("its 'device' is not leader", "device")
        by = fields.get("by", "joints")
        if by not in ("joints", "pose"):
            raise self.error(f"'by' is joints or pose, not {by!r}", "by")
        return LeaderMapping(
            self.text(fields.get("robot", ""), "robot"),
            by == "pose",
            self.texts(fields.get("joints", {}), "joints"),
            self._numbers(fields, "signs", -1.0, 1.0),
            self._numbers(fields, "offsets", -math.tau, math.tau),
            self._gripper(fields["gripper"]) if "gripper" in fields else None,
            self.number(fields.get("scale", 1.0), "scale", 0.01, 100.0),
        )

    def _numbers(
        self, fields: Mapping[str, Any], what: str, least: float, most: float
    ) -> dict[str, float]:
        table = self.table(fields.get(what, {}), what)
        return {
            str(name): self.number(each, f"{what}.{name}", least, most)
            for name, each in table.items()
        }

    def _gripper(self, value: Any) -> LeaderGripper:
        table = self.table(value, "gripper", _GRIPPER)
        if missing := [name for name in _GRIPPER if name not in table]:
            raise self.error(f"'gripper' has no '{missing[0]}'", "gripper")
        closed, opened = (
            self.number(table[name], f"gripper.{name}", -100.0, 100.0) for name in _GRIPPER[1:]
        )
        if closed == opened:
            raise self.error("the gripper's 'closed' and 'open' are equal", "gripper.open")
        return LeaderGripper(self.text(table["joint"], "gripper.joint"), closed, opened)


class LeaderState(enum.StrEnum):
    """State of a follower arm."""

    RELEASED = "released"
    MATCHING = "goes to the leader's pose"
    FOLLOWING = "follows"


class JointFollowing:
    """Target positions of a follower's joints while they follow a leader's.

    From the follower's pose they go to the leader's at `RAMP`; then each step is clamped. A jump of
    the leader ends the following.

    Args:
        joints: Names of the follower's joints.
        sliding: Names of the prismatic ones among them.

    Attributes:
        state: State of the follower.
    """

    def __init__(self, joints: Iterable[str], sliding: Iterable[str] = ()) -> None:
        sliding = frozenset(sliding)
        self._ramps = {name: _RAMP_SLIDING if name in sliding else RAMP for name in joints}
        self.state = LeaderState.RELEASED
        self._wanted: dict[str, float] = {}
        self._last: dict[str, float] = {}
        self._last_s = 0.0

    def engage(self, follower: Mapping[str, float], now_s: float) -> None:
        """Start to follow.

        Args:
            follower: Positions of the follower's joints, rad or m.
            now_s: Time on the monotonic clock, s.
        """
        self._wanted = {name: follower[name] for name in self._ramps}
        self._last, self._last_s = {}, now_s
        self.state = LeaderState.MATCHING

    def release(self) -> None:
        """Stop following."""
        self.state = LeaderState.RELEASED

    def step(self, leader: Mapping[str, float], now_s: float) -> dict[str, float]:
        """Return the target positions of the follower's joints, rad or m.

        Args:
            leader: Positions of the leader by the follower's names, rad or m.
            now_s: Time of the sample on the monotonic clock, s.

        Raises:
            DeviceError: The leader has jumped, or a position is no number; nothing is followed
                any more.
        """
        for name in self._ramps:
            at, before = leader[name], self._last.get(name)
            if not math.isfinite(at) or (before is not None and abs(at - before) > JUMP):
                self.release()
                by = f"by {abs(at - before):.2f}" if before is not None else f"to {at}"
                raise DeviceError(f"The leader has jumped at {name} {by}: engage again")
        duration_s = min(max(now_s - self._last_s, 0.0), _LONGEST_STEP_S)
        self._last = {name: leader[name] for name in self._ramps}
        self._last_s = now_s
        is_matching = self.state is LeaderState.MATCHING
        for name, ramp in self._ramps.items():
            most = (ramp if is_matching else _FASTEST) * duration_s
            left = leader[name] - self._wanted[name]
            self._wanted[name] += min(max(left, -most), most)
        if is_matching and self.distance(leader) < _MATCH:
            self.state = LeaderState.FOLLOWING
        return dict(self._wanted)

    def distance(self, leader: Mapping[str, float]) -> float:
        """Return the largest distance of a target position from the leader's, rad or m."""
        return max((abs(leader[name] - at) for name, at in self._wanted.items()), default=0.0)


def _listed(names: list[str]) -> str:
    more = len(names) - _MOST_NAMED
    return ", ".join(names[:_MOST_NAMED]) + (f" and {more} more" if more > 0 else "")
