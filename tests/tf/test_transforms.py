"""Rotations in plain floats agree with numpy's matrices."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, strategies as st
from trimesh.transformations import euler_matrix

from teleopctl.tf.transforms import (
    IDENTITY,
    Transform,
    interpolate,
    matrix_from_quaternion,
    normalize,
    quaternion_from_axis_angle,
    quaternion_from_rpy,
    rotate,
    rpy_from_quaternion,
    slerp,
)

lengths = st.floats(-10, 10)
angles = st.floats(-math.pi, math.pi)
vectors = st.tuples(lengths, lengths, lengths)
rotations = st.builds(quaternion_from_rpy, angles, angles, angles)
transforms = st.builds(Transform, vectors, rotations)


def matrix(transform):
    result = np.eye(4)
    result[:3, :3] = matrix_from_quaternion(transform.rotation)
    result[:3, 3] = transform.translation
    return result


@given(transforms, transforms)
def test_composition_is_the_product_of_matrices(a, b):
    np.testing.assert_allclose(matrix(a @ b), matrix(a) @ matrix(b), atol=1e-9)


@given(transforms)
def test_a_transform_and_its_inverse_cancel(a):
    np.testing.assert_allclose(matrix(a @ a.inverse()), np.eye(4), atol=1e-9)


@given(rotations, vectors)
def test_turning_a_vector_is_multiplying_it_by_the_matrix(q, v):
    np.testing.assert_allclose(rotate(q, v), np.array(matrix_from_quaternion(q)) @ v, atol=1e-9)


@given(angles, angles, angles)
def test_rpy_means_fixed_axes(roll, pitch, yaw):
    rows = matrix_from_quaternion(quaternion_from_rpy(roll, pitch, yaw))
    expected = euler_matrix(roll, pitch, yaw)[:3, :3]
    np.testing.assert_allclose(rows, expected, atol=1e-12)


@given(rotations)
def test_rpy_of_a_rotation_give_that_rotation_back(q):
    again = quaternion_from_rpy(*rpy_from_quaternion(q))
    np.testing.assert_allclose(matrix_from_quaternion(again), matrix_from_quaternion(q), atol=1e-5)


@pytest.mark.parametrize("pitch", [math.pi / 2, -math.pi / 2])
@pytest.mark.parametrize("roll", [0.0, 0.7, -2.0])
def test_a_right_angle_of_pitch_leaves_the_yaw_at_zero(pitch, roll):
    q = quaternion_from_rpy(roll, pitch, 0.4)
    again = rpy_from_quaternion(q)
    assert again[1] == pytest.approx(pitch, abs=1e-6)
    np.testing.assert_allclose(
        matrix_from_quaternion(quaternion_from_rpy(*again)), matrix_from_quaternion(q), atol=1e-6
    )


def test_a_rotation_without_pitch_prints_as_minus_zero():
    assert math.copysign(1, rpy_from_quaternion(IDENTITY.rotation)[1]) == -1


@given(st.tuples(lengths, lengths, lengths), angles, st.floats(0, 1))
def test_slerp_turns_at_constant_speed(axis, angle, fraction):
    length = math.hypot(*axis)
    assume(length > 1e-3)
    assume(abs(angle) < 3.1)
    axis = tuple(part / length for part in axis)
    whole = quaternion_from_axis_angle(axis, angle)
    part = slerp(IDENTITY.rotation, whole, fraction)
    expected = quaternion_from_axis_angle(axis, angle * fraction)
    assert abs(np.dot(part, expected)) == pytest.approx(1.0, abs=1e-9)


def test_slerp_takes_the_shorter_way():
    start = quaternion_from_rpy(0, 0, 0.1)
    x, y, z, w = quaternion_from_rpy(0, 0, 0.3)
    end = (-x, -y, -z, -w)
    middle = slerp(start, end, 0.5)
    assert rpy_from_quaternion(middle)[2] == pytest.approx(0.2)


def test_interpolation_moves_on_a_straight_line():
    a, b = Transform((0, 0, 0)), Transform((2, 4, -6))
    assert interpolate(a, b, 0.25).translation == (0.5, 1.0, -1.5)


@given(rotations, st.floats(0.1, 10))
def test_normalizing_keeps_the_direction(q, factor):
    scaled = tuple(part * factor for part in q)
    np.testing.assert_allclose(normalize(scaled), q, atol=1e-9)
