"""Second reading of a robot description, by yourdfpy, compared with ours in a robot check.

yourdfpy is a reader of URDF that shares no code with teleopctl's. Features that yourdfpy does not
support do not count as differences, and are compensated before the comparison:

- Capsules are left out, since yourdfpy does not support them.
- Every joint is set to its position, since yourdfpy does not move a joint that mimics a mimic
  joint. The values of ``<mimic>`` are compared.
- Axes are normalized, as in ROS: yourdfpy normalizes axes of rotation only.
- Floating and planar joints stay at their origins.
- Mesh sizes are compared without the unit of a COLLADA file, which yourdfpy ignores.
- A limit that is not given counts as 0, which is URDF's default.
"""

from __future__ import annotations

import io
import logging
import math
import warnings
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt
from lxml import etree

from teleopctl.errors import TeleopctlError
from teleopctl.packages import resolve_uri
from teleopctl.robot import (
    Box,
    Capsule,
    Cylinder,
    Geometry,
    Joint,
    Joints,
    Link,
    Mesh,
    Pose,
    RobotDescription,
    SegmentTree,
    Sphere,
    read_mesh,
)
from teleopctl.tf import Transform, matrix_from_quaternion, quaternion_from_rpy

# In m and rad; two computations of the same pose differ by much less.
_SAME_POSE = 1e-6
# Relative; two readings of a number differ only by a conversion to degrees and back.
_SAME_NUMBER = 1e-9
# Vertices of meshes are 32-bit floats, with seven digits.
_SAME_SIZE_M, _SAME_SIZE = 1e-6, 1e-5
# Allowed deviation of a unit vector's length from 1: many are rounded to four digits.
_UNIT = 1e-3
# Position of joints as a fraction of their ranges. The middle of many ranges is zero, where
# differences would not show.
_PART_OF_RANGE = 0.6
# Position of a joint without limits, in rad or m.
_ANYWHERE = 0.7

_Matrix = npt.NDArray[np.float64]
_Answer = TypeVar("_Answer")
_Part = TypeVar("_Part", Joint, Link)


class ReaderDifference(NamedTuple):
    """Difference between teleopctl's and yourdfpy's model of one robot description.

    Attributes:
        where: Joint or link, as text.
        what: Property that differs.
        ours: Value of the property in teleopctl, as text.
        yourdfpy: Value of the property in yourdfpy, as text.
    """

    where: str
    what: str
    ours: str
    yourdfpy: str

    @property
    def sentence(self) -> str:
        """The difference as one sentence: place, property and both values."""
        return f"{self.where}: {self.what} is {self.ours} here and {self.yourdfpy} in yourdfpy"


class SecondReading(NamedTuple):
    """Result of reading a robot description with yourdfpy too: an error, or differences.

    Attributes:
        error: Reason why yourdfpy cannot read the description; empty if it can.
        differences: Differences between the two models.
        meshes: Number of mesh files with the same size in both models.
        capsules: Number of capsules, which yourdfpy does not support.
    """

    error: str = ""
    differences: tuple[ReaderDifference, ...] = ()
    meshes: int = 0
    capsules: int = 0

    @property
    def summary(self) -> str:
        """Sentence for a robot description of which both readers make the same model."""
        same = "yourdfpy reads the same tree, limits, shapes and poses"
        if self.meshes:
            same += f", and {self.meshes} mesh{'es' if self.meshes > 1 else ''} of the same size"
        if self.capsules:
            same += (
                f"; it does not support {self.capsules} capsule{'s' if self.capsules > 1 else ''}"
            )
        return same


def read_again(description: RobotDescription) -> SecondReading:
    """Read a robot description with yourdfpy; return how its model differs from teleopctl's.

    Args:
        description: Robot description with absolute paths of meshes.
    """
    # yourdfpy logs the differences that are compared here.
    logging.getLogger("yourdfpy").setLevel(logging.CRITICAL)
    text, capsules = _without_capsules(description.urdf)
    try:
        robot = _asked(lambda: _parsed(text))
        differences = list(_in_tree(description, robot))
        if not differences:
            differences += _in_poses(description, robot)
        for ours, theirs in _pairs(description.joints, robot.joints):
            differences += _in_joint(ours, theirs)
        for link, other in _pairs(description.links, robot.links):
            differences += _in_shapes(link, other)
    except _YourdfpyError as error:
        return SecondReading(str(error), capsules=capsules)
    sizes = {uri: list(_in_mesh(uri)) for uri in _meshes(description)}
    differences += [found for mesh in sizes.values() for found in mesh if found is not None]
    same = sum(found == [None] for found in sizes.values())
    return SecondReading("", tuple(differences), same, capsules)


class _YourdfpyError(Exception):
    """yourdfpy raised an exception, whose type and message are the text."""


def _asked(ask: Callable[[], _Answer]) -> _Answer:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # numpy warns of infinite numbers
            return ask()
    except Exception as error:  # yourdfpy's parsers raise various exceptions
        reason = " ".join(f"{type(error).__name__}: {error}".split())[:200]
        raise _YourdfpyError(reason) from error


# Any, here and below: yourdfpy has no type hints.
def _parsed(text: str) -> Any:
    import yourdfpy

    file = io.BytesIO(text.encode())
    return yourdfpy.URDF.load(file, build_scene_graph=False, load_meshes=False).robot


def _without_capsules(urdf: str) -> tuple[str, int]:
    """Return a URDF without its capsules, and their number."""
    if "<capsule" not in urdf:
        return urdf, 0
    parser = etree.XMLParser(encoding="utf-8", resolve_entities=False, remove_comments=True)
    root = etree.fromstring(urdf.encode(), parser)
    found = [
        (link, shape)
        for link in root.findall("link")
        for shape in (*link.findall("visual"), *link.findall("collision"))
        if shape.find("geometry/capsule") is not None
    ]
    for link, shape in found:
        link.remove(shape)
    return etree.tostring(root, encoding="unicode"), len(found)


def _pairs(ours: Mapping[str, _Part], theirs: Any) -> Iterator[tuple[_Part, Any]]:
    """Yield pairs of teleopctl's and yourdfpy's links or joints with the same name."""
    return ((ours[one.name], one) for one in theirs if one.name in ours)


# -- tree, joints and poses ------------------------------------------------------------------------


def _in_tree(description: RobotDescription, robot: Any) -> Iterator[ReaderDifference]:
    for kind, ours, theirs in (
        ("Link", description.links, robot.links),
        ("Joint", description.joints, robot.joints),
    ):
        names = [one.name for one in theirs]
        for name in dict.fromkeys((*ours, *names)):
            here, there = int(name in ours), names.count(name)
            if here != there:
                what = f"the number of {kind.lower()}s of this name"
                yield ReaderDifference(f"{kind} '{name}'", what, str(here), str(there))
    for joint, other in _pairs(description.joints, robot.joints):
        for end in ("parent", "child"):
            mine, its = getattr(joint, end), getattr(other, end)
            if mine != its:
                yield ReaderDifference(_name(joint), f"its {end} link", f"'{mine}'", f"'{its}'")


def _name(joint: Joint) -> str:
    return f"Joint '{joint.name}'" + (f" (line {joint.line})" if joint.line else "")


def _in_joint(joint: Joint, other: Any) -> Iterator[ReaderDifference]:
    where = _name(joint)
    if joint.type != other.type:
        yield ReaderDifference(where, "its type", joint.type, str(other.type))
    if joint.is_single_axis and not _same_axis(joint, other.axis):
        yield ReaderDifference(where, "its axis", _numbers(joint.axis), _numbers(other.axis))
    yield from _in_limits(where, joint, other.limit)
    mimics = [
        "none"
        if mimic is None
        else f"{mimic.multiplier:.10g} * '{mimic.joint}' + {mimic.offset:.10g}"
        for mimic in (joint.mimic, other.mimic)
    ]
    if mimics[0] != mimics[1]:
        yield ReaderDifference(where, "its <mimic>", mimics[0], mimics[1])


def _same_axis(joint: Joint, axis: _Matrix) -> bool:
    """Return whether an axis has our direction and, if along it the joint moves, length 1."""
    length = float(np.linalg.norm(axis))
    too_long = joint.type == "prismatic" and abs(length - 1.0) > _UNIT
    return not too_long and np.allclose(joint.axis, axis / length, atol=_SAME_NUMBER)


def _in_limits(where: str, joint: Joint, other: Any) -> Iterator[ReaderDifference]:
    if joint.limit is None or other is None:
        if joint.limit is not other:
            here, there = ("none" if one is None else "given" for one in (joint.limit, other))
            yield ReaderDifference(where, "its <limit>", here, there)
        return
    for name in ("lower", "upper", "velocity", "effort"):
        ours, theirs = float(getattr(joint.limit, name)), float(getattr(other, name) or 0.0)
        # A joint of SDF may have an infinite limit, for which the URDF has a finite number.
        if not math.isclose(ours, theirs, rel_tol=_SAME_NUMBER) and math.isfinite(ours):
            yield ReaderDifference(where, f"its limit '{name}'", f"{ours:.10g}", f"{theirs:.10g}")


def _in_poses(description: RobotDescription, robot: Any) -> Iterator[ReaderDifference]:
    """Compare all links' poses in the root link's frame, at zero and within the joints' ranges."""
    mimics = {name: joint.mimic for name, joint in description.joints.items() if joint.mimic}
    joints = Joints(description.joints, {}, mimics)
    tree = SegmentTree(description, joints)
    for what, part in (
        ("its pose at zero", 0.0),
        (f"its pose with joints at {_PART_OF_RANGE:.0%} of their ranges", _PART_OF_RANGE),
    ):
        positions = joints.positions(
            {
                name: _within(model.limits.lower, model.limits.upper) if part else 0.0
                for name, model in joints.items()
                if model.mimic is None
            }
        )
        ours = {link: _matrix(pose) for link, pose in tree.link_poses(positions).items()}
        steps = _asked(partial(_steps, robot, positions))
        theirs = {description.root: np.eye(4)}
        for joint in description.tree:
            theirs[joint.child] = theirs[joint.parent] @ steps[joint.name]
        apart = {link for link, pose in ours.items() if not _same_pose(pose, theirs[link])}
        # Links below a link with another pose differ too, and are not reported.
        for joint in description.tree:
            link = joint.child
            if link in apart and joint.parent not in apart:
                where = f"Link '{link}' behind {_name(joint)[0].lower()}{_name(joint)[1:]}"
                yield ReaderDifference(where, what, _pose(ours[link]), _pose(theirs[link]))


def _within(lower: float, upper: float) -> float:
    if not math.isfinite(lower + upper):
        return min(max(_ANYWHERE, lower), upper)
    return lower + _PART_OF_RANGE * (upper - lower)


def _steps(robot: Any, positions: dict[str, float]) -> dict[str, _Matrix]:
    """Return each joint's transform in yourdfpy, from its parent to its child link, (4, 4)."""
    import copy

    import yourdfpy

    free = copy.deepcopy(robot)
    for joint in free.joints:
        joint.mimic = None
        if joint.type in ("revolute", "continuous", "prismatic"):
            joint.axis = joint.axis / np.linalg.norm(joint.axis)
    model = yourdfpy.URDF(free, load_meshes=False)
    moving = set(model.actuated_joint_names)
    model.update_cfg({name: value for name, value in positions.items() if name in moving})
    return {
        joint.name: np.asarray(model.get_transform(joint.child, joint.parent))
        for joint in free.joints
    }


def _matrix(transform: Transform) -> _Matrix:
    matrix = np.eye(4)
    matrix[:3, :3] = matrix_from_quaternion(transform.rotation)
    matrix[:3, 3] = transform.translation
    return matrix


def _same_pose(one: _Matrix, other: _Matrix) -> bool:
    """Return whether two poses differ by less than the tolerance, in m and in rad."""
    # For a small angle between them, rotations differ by sqrt(2) times the angle.
    angle = float(np.linalg.norm(one[:3, :3] - other[:3, :3])) / math.sqrt(2.0)
    return float(np.linalg.norm(one[:3, 3] - other[:3, 3])) < _SAME_POSE > angle


def _pose(matrix: _Matrix) -> str:
    r = matrix[:3, :3]
    rpy = (
        math.atan2(r[2, 1], r[2, 2]),
        math.atan2(-r[2, 0], math.hypot(r[2, 1], r[2, 2])),
        math.atan2(r[1, 0], r[0, 0]),
    )
    return f"xyz {_numbers(matrix[:3, 3])} rpy {_numbers(rpy)}"


def _numbers(values: Any) -> str:
    # Rounded by the tolerance; adding zero makes -0.0 a plain one.
    return " ".join(f"{round(float(value), 7) + 0.0:.10g}" for value in values)


# -- shapes and meshes -----------------------------------------------------------------------------


def _in_shapes(link: Link, other: Any) -> Iterator[ReaderDifference]:
    for kind, ours, theirs in (
        ("visual", link.visuals, other.visuals),
        ("collision", link.collisions, other.collisions),
    ):
        known = [shape for shape in ours if not isinstance(shape.geometry, Capsule)]
        if len(known) != len(theirs):
            what = f"the number of its <{kind}> elements"
            yield ReaderDifference(f"Link '{link.name}'", what, str(len(known)), str(len(theirs)))
            continue
        for number, (shape, its) in enumerate(zip(known, theirs, strict=True), 1):
            where = f"Link '{link.name}'"
            part = f"<{kind}>" if len(known) == 1 else f"<{kind}> {number}"
            here, there = _shape(shape.geometry), _other_shape(its.geometry)
            if here != there:
                yield ReaderDifference(where, f"the shape of {part}", here, there)
            place = np.eye(4) if its.origin is None else its.origin
            mine = _matrix(_transform(shape.origin))
            if not _same_pose(mine, place):
                yield ReaderDifference(where, f"the origin of {part}", _pose(mine), _pose(place))


def _transform(pose: Pose) -> Transform:
    return Transform(pose.xyz, quaternion_from_rpy(*pose.rpy))


def _shape(shape: Geometry) -> str:
    match shape:
        case Box(size):
            return f"a box of {_numbers(size)}"
        case Cylinder(radius, length):
            return f"a cylinder of {_numbers((radius, length))}"
        case Sphere(radius):
            return f"a sphere of {_numbers((radius,))}"
        case Mesh(uri, scale):
            return f"the mesh {uri} times {_numbers(scale)}"
        case _:
            return "a capsule"


def _other_shape(shape: Any) -> str:
    if shape.box is not None:
        return f"a box of {_numbers(shape.box.size)}"
    if shape.cylinder is not None:
        return f"a cylinder of {_numbers((shape.cylinder.radius, shape.cylinder.length))}"
    if shape.sphere is not None:
        return f"a sphere of {_numbers((shape.sphere.radius,))}"
    scale = 1.0 if shape.mesh.scale is None else shape.mesh.scale
    return f"the mesh {shape.mesh.filename} times {_numbers(np.broadcast_to(scale, 3))}"


def _meshes(description: RobotDescription) -> list[str]:
    links = description.links.values()
    shapes = [shape.geometry for link in links for shape in link.visuals]
    shapes += [shape.geometry for link in links for shape in link.collisions]
    return list(dict.fromkeys(shape.uri for shape in shapes if isinstance(shape, Mesh)))


def _in_mesh(uri: str) -> Iterator[ReaderDifference | None]:
    """Compare a mesh's bounding boxes; yield a difference, or None if they are the same.

    Yields nothing for a missing or invalid mesh, which the report lists elsewhere.
    """
    try:
        ours = read_mesh(resolve_uri(uri))
    except (TeleopctlError, OSError):
        return
    try:
        theirs = _asked(lambda: _bounds(uri))
    except _YourdfpyError as error:
        yield ReaderDifference(f"Mesh '{uri}'", "its content", "read", f"not ({error})")
        return
    if theirs is None:
        yield ReaderDifference(f"Mesh '{uri}'", "its content", "read", "empty")
        return
    theirs = theirs * ours.unit_m
    size = float(np.abs(ours.bounds).max())
    if np.allclose(ours.bounds, theirs, rtol=0.0, atol=_SAME_SIZE_M + _SAME_SIZE * size):
        yield None
        return
    low, high = (f"{_numbers(one[0])} to {_numbers(one[1])}" for one in (ours.bounds, theirs))
    yield ReaderDifference(f"Mesh '{uri}'", "its bounding box", low, high)


def _bounds(uri: str) -> _Matrix | None:
    """Return the lowest and the highest corner of a mesh in yourdfpy, in the file's unit, (2, 3).

    None for a mesh without triangles, which yourdfpy also returns for an unreadable file.
    """
    import yourdfpy.urdf as parts

    geometry = parts.Geometry(mesh=parts.Mesh(uri))
    link = parts.Link("link", collisions=[parts.Collision("shape", geometry=geometry)])
    # A collision mesh, since yourdfpy reads the textures of visual meshes too.
    model = parts.URDF(
        parts.Robot("robot", links=[link]),
        build_scene_graph=False,
        build_collision_scene_graph=True,
        load_collision_meshes=True,
        force_collision_mesh=False,
        filename_handler=lambda fname: str(resolve_uri(fname)),
    )
    bounds = model.collision_scene.bounds
    return None if bounds is None else np.asarray(bounds, float)
