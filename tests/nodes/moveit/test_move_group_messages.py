"""Messages of MoveIt as the planning scene and constraints understand them."""

import math

import numpy as np
import pytest

from teleopctl.errors import UsageError
from teleopctl.interfaces import get_message
from teleopctl.kinematics import AllowedCollisions, ShapeKind
from teleopctl.nodes.moveit.move_group import messages
from teleopctl.nodes.moveit.move_group.constraints import Orientation, Region

CollisionObject = get_message("moveit_msgs/msg/CollisionObject")
SolidPrimitive = get_message("shape_msgs/msg/SolidPrimitive")
Pose = get_message("geometry_msgs/msg/Pose")
Matrix = get_message("moveit_msgs/msg/AllowedCollisionMatrix")
Entry = get_message("moveit_msgs/msg/AllowedCollisionEntry")
JointState = get_message("sensor_msgs/msg/JointState")
HERE = np.eye(4)


def pose(x=0.0, y=0.0, z=0.0, w=1.0):
    message = Pose()
    message.position.x, message.position.y, message.position.z = x, y, z
    message.orientation.w = w
    return message


def box(**fields):
    primitive = SolidPrimitive(type=SolidPrimitive.BOX, dimensions=[0.1, 0.2, 0.3])
    return CollisionObject(id="box", primitives=[primitive], **fields)


def test_an_object_has_its_pose_in_the_frame_of_its_header():
    at = np.eye(4)
    at[:3, 3] = 1.0, 0.0, 0.0
    found = messages.read_object(box(pose=pose(y=2.0), primitive_poses=[pose(z=3.0)]), at)
    assert found.pose[:3, 3] == pytest.approx((1.0, 2.0, 0.0))
    assert found.shape_poses[0][:3, 3] == pytest.approx((0.0, 0.0, 3.0))


def test_without_a_pose_the_only_shape_s_pose_is_the_object_s():
    found = messages.read_object(box(primitive_poses=[pose(z=3.0)]), HERE)
    assert found.pose[:3, 3] == pytest.approx((0.0, 0.0, 3.0))
    assert found.shape_poses[0] == pytest.approx(np.eye(4))


def test_an_object_is_written_as_it_was_read():
    plane = get_message("shape_msgs/msg/Plane")(coef=[0.0, 0.0, 1.0, -0.5])
    triangle = get_message("shape_msgs/msg/MeshTriangle")
    mesh = get_message("shape_msgs/msg/Mesh")(
        triangles=[triangle(vertex_indices=[0, 1, 2])],
        vertices=[
            get_message("geometry_msgs/msg/Point")(x=x, y=y) for x, y in ((0, 0), (1, 0), (0, 1))
        ],
    )
    given = box(pose=pose(y=2.0), meshes=[mesh], planes=[plane], subframe_names=["grip"])
    given.primitive_poses, given.mesh_poses, given.plane_poses = [pose(x=1.0)], [pose()], [pose()]
    given.subframe_poses = [pose(z=0.1)]
    given.type.key = "cup"
    given.header.frame_id = "world"
    assert messages.write_object(messages.read_object(given, HERE), "world") == given


@pytest.mark.parametrize(
    ("message", "problem"),
    [
        (box(pose=pose(w=0.0)), "quaternion of zeros"),
        (box(pose=pose(x=math.nan)), "not a finite number"),
        (box(primitive_poses=[pose(), pose()]), "1 shapes of the kind primitive, and 2 poses"),
        (CollisionObject(id="c", primitives=[SolidPrimitive(type=2)]), "dimensions radius, got 0"),
        (
            CollisionObject(id="c", primitives=[SolidPrimitive(type=2, dimensions=[-1.0])]),
            "radius of a sphere must be above 0 m, got -1",
        ),
        (CollisionObject(id="c", primitives=[SolidPrimitive(type=9)]), "type 9 are not supported"),
    ],
)
def test_what_is_no_object_is_refused_with_the_reason(message, problem):
    with pytest.raises(UsageError, match=problem):
        messages.read_object(message, HERE)


def test_allowed_collisions_are_written_as_they_were_read():
    allowed = AllowedCollisions([("a", "b"), ("b", "c")])
    allowed.set("a", "c", is_allowed=False)
    allowed.set_default("d", is_allowed=True)
    found = messages.read_allowed(messages.write_allowed(allowed))
    assert found.entries == allowed.entries
    assert found.defaults == allowed.defaults


def test_a_matrix_that_is_not_square_is_refused():
    with pytest.raises(UsageError, match="has 2 names, and 1 rows of 1 values"):
        messages.read_allowed(Matrix(entry_names=["a", "b"], entry_values=[Entry(enabled=[True])]))


def test_a_joint_state_needs_a_finite_position_for_each_name():
    assert messages.read_joint_state(JointState(name=["a"], position=[0.5])) == {"a": 0.5}
    with pytest.raises(UsageError, match="2 names and 1 positions"):
        messages.read_joint_state(JointState(name=["a", "b"], position=[0.5]))
    with pytest.raises(UsageError, match="'a' is not a finite number"):
        messages.read_joint_state(JointState(name=["a"], position=[math.inf]))


@pytest.mark.parametrize(
    ("kind", "half", "point", "distance"),
    [
        (ShapeKind.BOX, (0.1, 0.2, 0.3), (0.05, 0.1, 0.2), 0.0),
        (ShapeKind.BOX, (0.1, 0.2, 0.3), (0.4, 0.6, 0.0), 0.5),
        (ShapeKind.SPHERE, (0.1, 0.1, 0.1), (0.0, 0.3, 0.4), 0.4),
        (ShapeKind.CYLINDER, (0.1, 0.1, 0.3), (0.3, 0.4, 0.0), 0.4),
        (ShapeKind.CYLINDER, (0.1, 0.1, 0.3), (0.0, 0.0, 0.5), 0.2),
    ],
)
def test_a_region_says_how_far_outside_a_point_is(kind, half, point, distance):
    region = Region("tool0", np.zeros(3), ((np.eye(4), np.array(half)),), (kind.value,))
    assert region.distance_m(np.array(point)) == pytest.approx(distance)


@pytest.mark.parametrize("is_vector", [True, False])
def test_an_orientation_says_by_how_much_a_rotation_exceeds_its_tolerances(is_vector):
    cos, sin = math.cos(0.3), math.sin(0.3)
    turned = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    tight = Orientation("tool0", np.eye(3), np.array([0.1, 0.1, 0.1]), is_vector)
    assert tight.excess_rad(turned) == pytest.approx(0.2)
    free = Orientation("tool0", np.eye(3), np.array([0.1, 0.1, math.pi]), is_vector)
    assert free.excess_rad(turned) == 0.0
