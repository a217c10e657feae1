"""Joints that close loops: rods, four-bar linkages, the tendons of a walker's legs.

Frames, joint states and MuJoCo's coordinates form a tree. The joints of an SDF need not, nor do
those in a URDF's ``<gazebo>``, which Gazebo adds to the robot's own. The joints that are not part
of the tree are constraints of physics only.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal, cast, get_args

from lxml import etree

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot.elements import child_text, describe, to_number
from teleopctl.robot.scene.scene import NOWHERE, SceneJoint, Vector3
from teleopctl.robot.urdf_text import numbers, pose_text
from teleopctl.tf import Transform, quaternion_from_rpy, rotate

LoopKind = Literal["revolute", "continuous", "ball", "fixed"]
# Half of the distance between the points of a hinge, in metres.
_HALF = 0.05


@dataclass(frozen=True, slots=True)
class Loop:
    """Joint that closes a kinematic loop, which a URDF tree cannot hold.

    Attributes:
        name: Name of the joint.
        kind: Type of the joint.
        parent: Name of the parent link.
        child: Name of the child link.
        pose: Pose of the joint in the child's frame, while all joints are at zero.
        axis: Rotation axis in the joint's frame, a unit vector.
    """

    name: str
    kind: LoopKind
    parent: str
    child: str
    pose: Transform = NOWHERE
    axis: Vector3 = (0.0, 0.0, 1.0)

    @property
    def anchors(self) -> list[Vector3]:
        """Points of the child link that the joint holds fixed in the parent link: none, 1 or 2.

        A hinge has two points, on its axis; a fixed joint has none.
        """
        if self.kind == "fixed":
            return []
        at = self.pose.translation
        if self.kind == "ball":
            return [at]
        along = rotate(self.pose.rotation, self.axis)
        return [
            (at[0] + side * along[0], at[1] + side * along[1], at[2] + side * along[2])
            for side in (-_HALF, _HALF)
        ]


def tree_and_loops(
    joints: Iterable[SceneJoint], bodies: Iterable[str]
) -> tuple[list[SceneJoint], list[SceneJoint]]:
    """Divide a model's joints into those of a tree and those that close loops; return both lists.

    Ball joints close loops rather than belong to the tree, where possible. A joint whose child is
    reached before its parent is reversed, with its axis, so that its position is the same.

    Args:
        joints: Joints of the model, as in the file.
        bodies: Names of the model's bodies.

    Returns:
        The joints of the tree, in the order of the file, and the joints that close loops.
    """
    rest = dict(enumerate(joints))
    names = list(bodies)
    moved = {joint.child for joint in rest.values()}
    reached = {joint.parent for joint in rest.values()} - set(names)
    tree: dict[int, SceneJoint] = {}
    roots = [name for name in names if name not in moved]
    for root in (None, *roots, *names):
        if root in reached:
            continue
        if root is not None:
            reached.add(root)
        while (found := _next(rest, reached)) is not None:
            number, joint = found
            del rest[number]
            tree[number] = joint
            reached.add(joint.child)
    return [joint for _, joint in sorted(tree.items())], list(rest.values())


def _next(joints: Mapping[int, SceneJoint], reached: set[str]) -> tuple[int, SceneJoint] | None:
    """Return the joint to add to the tree next, with its number; None if there is none."""
    candidates = []
    for number, joint in joints.items():
        if (joint.parent in reached) == (joint.child in reached):
            continue
        is_ball, is_reversed = joint.kind == "ball", joint.child in reached
        candidates.append((is_ball, is_reversed, number))
    if not candidates:
        return None
    _, is_reversed, number = min(candidates)
    joint = joints[number]
    return number, _reversed(joint) if is_reversed else joint


def _reversed(joint: SceneJoint) -> SceneJoint:
    x, y, z = joint.axis
    return replace(joint, parent=joint.child, child=joint.parent, axis=(-x, -y, -z))


def loops_path(loop: Loop, joints: Mapping[str, tuple[str, str]]) -> list[str]:
    """Return the names of the tree's joints between the links of a loop, from the root outward.

    Args:
        loop: Joint that closes the loop.
        joints: Parent and child link of each joint of the tree, by joint name.
    """
    above = {child: (name, parent) for name, (parent, child) in joints.items()}

    def upwards(link: str) -> list[str]:
        found = []
        while link in above:
            name, link = above[link]
            found.append(name)
        return found[::-1]

    one, other = upwards(loop.parent), upwards(loop.child)
    shared = set(one) & set(other)
    return [name for name in (*one, *other) if name not in shared]


def loop_of(joint: SceneJoint, child: Transform) -> Loop | None:
    """Return an SDF joint as a `Loop`, which closes a loop; None for a prismatic joint.

    Args:
        joint: Joint of the SDF file.
        child: Pose of the child link in the model.
    """
    if joint.kind == "prismatic":
        return None
    kind: LoopKind = "ball" if joint.kind == "ball" else "revolute"
    if joint.kind == "fixed":
        kind = "fixed"
    return Loop(
        joint.name, kind, joint.parent, joint.child, child.inverse() @ joint.pose, joint.axis
    )


# Any, here and below: lxml elements, whose class has no types.
def add_loop(robot: Any, loop: Loop) -> None:
    """Add a ``<gazebo>`` element with a loop-closing joint to a URDF, for `read_loops`."""
    holder = etree.SubElement(robot, "gazebo")
    joint = etree.SubElement(holder, "joint", name=loop.name, type=loop.kind)
    etree.SubElement(joint, "parent").text = loop.parent
    etree.SubElement(joint, "child").text = loop.child
    etree.SubElement(joint, "pose").text = pose_text(loop.pose)
    if loop.kind == "revolute":
        axis = etree.SubElement(joint, "axis")
        etree.SubElement(axis, "xyz").text = numbers(*loop.axis)


def read_loops(gazebo: Any) -> list[Loop]:
    """Return the joints of a ``<gazebo>`` element, which close loops; raise for invalid ones.

    Raises:
        InvalidDescriptionError: A joint has no name or links, an invalid pose or axis, or a type
            that closes no loop.
    """
    return [_read(element) for element in gazebo.findall("joint")]


def _read(element: Any) -> Loop:
    kind = element.get("type") or ""
    if kind not in get_args(LoopKind):
        raise InvalidDescriptionError(
            f"{describe(element)}: a joint of the type '{kind}' in <gazebo> closes no loop",
            hint=f"It may be {', '.join(get_args(LoopKind))}.",
        )
    name = element.get("name") or ""
    parent, child = (child_text(element, tag) for tag in ("parent", "child"))
    if not (name and parent and child):
        raise InvalidDescriptionError(
            f"{describe(element)}: it should have a name, a <parent> and a <child>"
        )
    *place, roll, pitch, yaw = _numbers(element, "pose", (0.0,) * 6)
    axis = _numbers(element, "axis/xyz", (0.0, 0.0, 1.0))
    length = sum(value * value for value in axis) ** 0.5
    if not length:
        raise InvalidDescriptionError(f"{describe(element)}: its axis has no direction")
    x, y, z = place
    return Loop(
        name,
        cast("LoopKind", kind),
        parent,
        child,
        Transform((x, y, z), quaternion_from_rpy(roll, pitch, yaw)),
        (axis[0] / length, axis[1] / length, axis[2] / length),
    )


def _numbers(element: Any, path: str, usual: tuple[float, ...]) -> tuple[float, ...]:
    text = child_text(element, path)
    if not text:
        return usual
    found = [to_number(word) for word in text.split()]
    values = tuple(value for value in found if value is not None)
    if len(values) != len(found) or len(values) != len(usual) or any(abs(v) > 1e9 for v in values):
        tag = path.partition("/")[0]
        raise InvalidDescriptionError(
            f"{describe(element)}: its <{tag}> should be {len(usual)} numbers, got '{text}'"
        )
    return values
