"""Joint groups of a robot: from an SRDF file, or found in the robot's description.

A group is a set of joints that move a link together, as in MoveIt: an arm, or a gripper.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from teleopctl.errors import NotFoundError
from teleopctl.robot import Joints

if TYPE_CHECKING:
    from pathlib import Path

    from teleopctl.robot import RobotDescription
    from teleopctl.tf import Transform

# Fewest independent joints of a branch that is a limb, and not a finger or a wheel.
_LIMB = 3
# Names of frames in which tools are steered, the most specific first.
_TOOL_FRAMES = tuple(
    re.compile(rf"(?:^|[_/-]){name}(?:$|[_/-]|\d)", re.IGNORECASE)
    for name in (
        "tcp",
        "tool_?cent(?:er|re)(?:_point)?",
        "grasp(?:ing)?",
        "grip(?:per)?_(?:frame|point|tip|center)",
        "tool0?",
        "end_?effector",
        "ee",
        "tip",
        "flange",
    )
)
_GRIPPER = re.compile(r"gripper|finger|jaw|claw|knuckle|thumb", re.IGNORECASE)
# What joints begin with that names the whole limb, as in ``arm_left_1_joint``.
_LIMB_NAME = re.compile(r"(?:^|_)(?:arm|leg|neck)(?:_|$)", re.IGNORECASE)
# Fingers of a hand may have as many joints as a limb.
_FINGER = re.compile(
    r"finger|knuckle|thumb|(?:^|_)(?:index|middle|ring|pinky|little)(?:_|$)", re.IGNORECASE
)

ARM, GRIPPER = "arm", "gripper"
"""Names of the groups of a robot with one arm and no SRDF."""
HOME, ZERO = "home", "zero"
"""Names of the states of a robot without an SRDF: at rest, and all positions nearest to 0."""


@dataclass(frozen=True, slots=True)
class JointGroup:
    """Joints that move together, as a ``<group>`` of an SRDF.

    Attributes:
        name: Name of the group.
        joints: Names of its joints with one axis, from the root to the tip; mimic joints too.
        base: Link that the group's first joint is attached to.
        tip: Link that the group moves, which poses are about; empty if it is not one chain.
        tool: Pose of the tool in the tip's frame, which poses are about instead; None for the tip.
        task: What of a pose is served, ``pose``, ``axis`` or ``position``; empty for what the
            joints allow.
    """

    name: str
    joints: tuple[str, ...]
    base: str
    tip: str = ""
    tool: Transform | None = None
    task: str = ""


@dataclass(frozen=True, slots=True)
class EndEffector:
    """Group that is attached to the tip of another one, as an ``<end_effector>`` of an SRDF.

    Attributes:
        name: Name of the end effector.
        group: Name of the group of its joints.
        parent_link: Link that it is attached to.
        parent_group: Name of the group that moves that link; empty if not given.
    """

    name: str
    group: str
    parent_link: str
    parent_group: str = ""


@dataclass(frozen=True)
class RobotGroups:
    """Groups of a robot with named states, as an SRDF describes them.

    Attributes:
        robot: Name of the robot.
        groups: Groups by name.
        states: Positions (rad or m) by joint, of each named state of each group.
        end_effectors: End effectors by name.
        passive_joints: Joints without a drive.
        allowed_collisions: Reason for each pair of links (in alphabetical order) that may touch.
        virtual_frame: Frame of the virtual joint that holds the root link, such as ``world``; empty
            without one.
        file: The SRDF file; None if the groups were found in the description.
        warnings: Elements of the SRDF that cannot be used, one sentence each.
    """

    robot: str
    groups: Mapping[str, JointGroup]
    states: Mapping[str, Mapping[str, Mapping[str, float]]] = field(default_factory=dict)
    end_effectors: Mapping[str, EndEffector] = field(default_factory=dict)
    passive_joints: frozenset[str] = frozenset()
    allowed_collisions: Mapping[tuple[str, str], str] = field(default_factory=dict)
    virtual_frame: str = ""
    file: Path | None = None
    warnings: tuple[str, ...] = ()

    def group(self, name: str = "") -> JointGroup:
        """Return a group; without a name, the first one that moves a tip and is no end effector.

        Raises:
            NotFoundError: There is no such group.
        """
        if not name:
            ends = {effector.group for effector in self.end_effectors.values()}
            moving = [group for group in self.groups.values() if group.tip]
            for group in sorted(moving, key=lambda one: one.name in ends):
                return group
        if name in self.groups:
            return self.groups[name]
        known = f"Its groups are: {', '.join(self.groups)}" if self.groups else "It has no groups"
        what = f"no group '{name}'" if name else "no group that moves a tip"
        raise NotFoundError(f"The robot '{self.robot}' has {what}", hint=known)

    def state(self, group: str, name: str) -> Mapping[str, float]:
        """Return the positions by joint, rad or m, of a group's named state.

        Raises:
            NotFoundError: The group has no such state.
        """
        states = self.states.get(group, {})
        if name in states:
            return states[name]
        known = f"Its states are: {', '.join(states)}" if states else "It has no named states"
        raise NotFoundError(f"The group '{group}' has no state '{name}'", hint=known)

    def gripper_of(self, group: str) -> JointGroup | None:
        """Return the group of the gripper at a group's tip; None if there is none."""
        for effector in self.end_effectors.values():
            if effector.parent_group == group and effector.group in self.groups:
                return self.groups[effector.group]
        tip = self.groups[group].tip if group in self.groups else ""
        for effector in self.end_effectors.values():
            if effector.parent_link == tip and effector.group in self.groups:
                return self.groups[effector.group]
        return None


def find_groups(description: RobotDescription, joints: Joints | None = None) -> RobotGroups:
    """Return the groups that a description itself suggests: each limb, and the gripper at its end.

    A limb is a chain of at least three independent joints, or all joints of a robot that has fewer
    and does not branch. Where it branches into parts that are no limbs, or are named as fingers,
    these are its gripper; so are last joints with a name such as ``gripper`` or ``jaw``. A wheel is
    neither. With one limb
    the groups are named ``arm`` and ``gripper``, with several after what the names of their joints
    begin with. The tip is a frame behind the last joint that is named as tools are (``tool0``,
    ``tcp``, …), else the last link.

    Args:
        description: The robot.
        joints: Its joints, if they have been read.
    """
    joints = Joints.of(description) if joints is None else joints
    limbs = [limb for limb in _limbs(description, joints) if limb.joints]
    groups: dict[str, JointGroup] = {}
    effectors: dict[str, EndEffector] = {}
    for number, limb in enumerate(limbs):
        before = _common_start([each.joints for each in limbs], number)
        is_named = _LIMB_NAME.search(before)
        arm, gripper = before[:-1] if is_named else f"{before}{ARM}", f"{before}{GRIPPER}"
        tip = _tool_frame(description, limb.end)
        groups[arm] = JointGroup(arm, tuple(limb.joints), limb.base, tip)
        if limb.gripper:
            groups[gripper] = JointGroup(gripper, tuple(limb.gripper), limb.end)
            effectors[gripper] = EndEffector(gripper, gripper, limb.end, arm)
    states = {name: named_states(group, joints) for name, group in groups.items()}
    return RobotGroups(description.name, groups, states, effectors)


def named_states(group: JointGroup, joints: Joints) -> dict[str, dict[str, float]]:
    """Return the states ``home`` and ``zero`` of a group: positions by independent joint."""
    independent = [name for name in group.joints if joints[name].mimic is None]
    limits = {name: joints[name].limits for name in independent}
    return {
        HOME: {name: limit.rest for name, limit in limits.items()},
        ZERO: {name: min(max(0.0, limit.lower), limit.upper) for name, limit in limits.items()},
    }


@dataclass(slots=True)
class _Limb:
    """Chain of joints with the joints of its gripper, while it is being found."""

    base: str
    joints: list[str]
    end: str
    gripper: list[str] = field(default_factory=list)


def _limbs(description: RobotDescription, joints: Joints) -> Iterator[_Limb]:
    """Yield the limbs of a robot, in the order of the description."""
    pending = [_Limb(description.root, [], description.root)]
    while pending:
        limb = pending.pop(0)
        branches = _moving_below(description, limb.end, joints)
        while len(branches) == 1:
            _extend(limb, description, branches[0])
            branches = _moving_below(description, limb.end, joints)
        large = [name for name in branches if _depth(description, name, joints) >= _LIMB]
        if _independent(limb.joints, joints) and any(_is_finger(description, n) for n in large):
            large = []
        if len(large) == 1:
            # The rest are wheels, or what a parallel linkage drags along.
            _extend(limb, description, large[0])
            pending.insert(0, limb)
        elif large:
            pending = [*(_Limb(limb.end, [], limb.end) for _ in large), *pending]
            for part, name in zip(pending, large, strict=False):
                _extend(part, description, name)
        elif branches:
            if _independent(limb.joints, joints):
                for name in branches:
                    limb.gripper += _below(description, name, joints)
                parents = {description.joints[name].parent for name in branches}
                if len(parents) == 1:
                    (limb.end,) = parents
                yield limb
        else:
            _split_gripper(limb, description, joints)
            yield limb


def _extend(limb: _Limb, description: RobotDescription, joint: str) -> None:
    limb.joints.append(joint)
    limb.end = description.joints[joint].child


def _split_gripper(limb: _Limb, description: RobotDescription, joints: Joints) -> None:
    """Make the last joints of a chain its gripper if they are named so.

    The link that the last one moves may name it; before it, a link is the gripper's own body, which
    the wrist turns.
    """
    while len(_independent(limb.joints, joints)) > 1:
        joint = description.joints[limb.joints[-1]]
        is_last = not limb.gripper
        if not (_GRIPPER.search(joint.name) or (is_last and _GRIPPER.search(joint.child))):
            return
        limb.gripper.insert(0, limb.joints.pop())
        limb.end = joint.parent


def _is_finger(description: RobotDescription, joint: str) -> bool:
    return bool(_FINGER.search(joint) or _FINGER.search(description.joints[joint].child))


def _independent(names: list[str], joints: Joints) -> list[str]:
    return [name for name in names if joints[name].mimic is None]


def _moving_below(description: RobotDescription, link: str, joints: Joints) -> list[str]:
    """Return the joints with one axis below a link, through fixed joints."""
    found: list[str] = []
    for joint in description.child_joints[link]:
        if joint.name in joints:
            found.append(joint.name)
        elif joint.type == "fixed":
            found += _moving_below(description, joint.child, joints)
    return found


def _below(description: RobotDescription, joint: str, joints: Joints) -> list[str]:
    """Return a joint and all below it."""
    found = [joint]
    for name in _moving_below(description, description.joints[joint].child, joints):
        found += _below(description, name, joints)
    return found


def _depth(description: RobotDescription, joint: str, joints: Joints) -> int:
    """Return the number of independent joints on the longest way from a joint to an end."""
    below = _moving_below(description, description.joints[joint].child, joints)
    own = int(joints[joint].mimic is None)
    return own + max((_depth(description, name, joints) for name in below), default=0)


def _tool_frame(description: RobotDescription, link: str) -> str:
    """Return the frame fixed to a link with a tool's name; the link itself if there is none."""
    fixed = list(_fixed_below(description, link))
    for pattern in _TOOL_FRAMES:
        for name in fixed:
            if pattern.search(name):
                return name
    return link


def _fixed_below(description: RobotDescription, link: str) -> Iterator[str]:
    for joint in description.child_joints[link]:
        if joint.type == "fixed":
            yield from _fixed_below(description, joint.child)
            yield joint.child


def _common_start(chains: list[list[str]], number: int) -> str:
    """Return how a chain's names differ from others', such as ``left_``; empty for the only one."""
    if len(chains) == 1:
        return ""
    starts = []
    for names in chains:
        start = names[0]
        for name in names[1:]:
            while not name.startswith(start):
                start = start[:-1]
        starts.append(start[: start.rfind("_") + 1])
    if starts[number] and starts.count(starts[number]) == 1:
        return starts[number]
    return f"{number + 1}_"


def with_tip(group: JointGroup, tip: str) -> JointGroup:
    """Return a group with another link as its tip, without a tool."""
    return replace(group, tip=tip, tool=None)
