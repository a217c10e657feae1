"""The tree of frames against a naive one, and tf2's answers where there is none."""

import logging
import math

import numpy as np
import pytest
from hypothesis import given, strategies as st

from teleopctl.tf.errors import (
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
)
from teleopctl.tf.history import TransformSample
from teleopctl.tf.transforms import (
    IDENTITY,
    Transform,
    interpolate,
    matrix_from_quaternion,
    quaternion_from_rpy,
)
from teleopctl.tf.tree import FrameTree

S = 1_000_000_000


def tree(*entries, length=10 * S):
    """A tree of (parent, child, stamp, x), or (parent, child, None, x) for a static frame."""
    made = FrameTree(length)
    for parent, child, stamp, x in entries:
        sample = TransformSample(stamp or 0, parent, Transform((x, 0.0, 0.0)))
        assert made.insert(sample, child, "test", static=stamp is None)
    return made


def matrix(transform):
    result = np.eye(4)
    result[:3, :3] = matrix_from_quaternion(transform.rotation)
    result[:3, 3] = transform.translation
    return result


angles = st.floats(-3, 3)
poses = st.builds(
    lambda x, y, z, r, p, w: Transform((x, y, z), quaternion_from_rpy(r, p, w)),
    angles,
    angles,
    angles,
    angles,
    angles,
    angles,
)


@st.composite
def forests(draw):
    """Parents and poses of a few frames: frame n hangs on an earlier one, or on nothing."""
    count = draw(st.integers(2, 7))
    parents = [None, *(draw(st.one_of(st.none(), st.integers(0, n - 1))) for n in range(1, count))]
    moves = [
        None if parent is None else draw(st.one_of(st.tuples(poses), st.tuples(poses, poses)))
        for parent in parents
    ]
    return parents, moves


def naive(parents, moves, frame, fraction):
    """(root, matrix of a frame in it): each frame times its parent's, up to the root."""
    if parents[frame] is None:
        return frame, np.eye(4)
    root, above = naive(parents, moves, parents[frame], fraction)
    move = moves[frame]
    step = move[0] if len(move) == 1 else interpolate(move[0], move[1], fraction)
    return root, above @ matrix(step)


@given(forests(), st.floats(0, 1), st.data())
def test_lookup_agrees_with_a_naive_computation(forest, fraction, data):
    parents, moves = forest
    made = FrameTree(10 * S)
    for child, (parent, move) in enumerate(zip(parents, moves, strict=True)):
        if parent is None:
            continue
        for n, transform in enumerate(move):
            sample = TransformSample((1 + n) * S, f"f{parent}", transform)
            made.insert(sample, f"f{child}", "test", static=len(move) == 1)
    target, source = (data.draw(st.integers(0, len(parents) - 1)) for _ in range(2))
    stamp = S + int(fraction * S)
    root_of_target, target_in_root = naive(parents, moves, target, (stamp - S) / S)
    root_of_source, source_in_root = naive(parents, moves, source, (stamp - S) / S)
    if root_of_target != root_of_source:
        with pytest.raises(ConnectivityException):
            made.lookup(f"f{target}", f"f{source}", stamp)
        return
    when, transform = made.lookup(f"f{target}", f"f{source}", stamp)
    assert when == stamp
    np.testing.assert_allclose(
        matrix(transform), np.linalg.inv(target_in_root) @ source_in_root, atol=1e-6
    )


def test_the_newest_common_time_is_the_oldest_of_the_newest():
    made = tree(
        ("a", "b", 3 * S, 1), ("b", "c", 5 * S, 1), ("b", "c", 2 * S, 0), ("c", "d", None, 1)
    )
    assert made.latest_common_time("a", "d") == 3 * S
    when, transform = made.lookup("a", "d", 0)
    assert when == 3 * S
    assert transform.translation[0] == pytest.approx(1 + 1 / 3 + 1)


def test_frames_above_the_meeting_point_do_not_matter():
    made = tree(
        ("root", "base", 1 * S, 0),
        ("base", "l", 7 * S, 1),
        ("base", "l", 9 * S, 3),
        ("base", "r", 8 * S, -1),
    )
    assert made.lookup("l", "r", 0) == (8 * S, Transform((-3.0, 0.0, 0.0)))


def test_static_frames_are_known_at_every_time_and_answer_with_time_zero():
    made = tree(("a", "b", None, 1), ("b", "c", None, 2))
    assert made.lookup("a", "c", 0) == (0, Transform((3.0, 0.0, 0.0)))
    assert made.lookup("a", "c", 123)[1].translation == (3.0, 0.0, 0.0)


def test_a_frame_in_itself_is_the_identity_at_its_newest_time():
    made = tree(("a", "b", 3 * S, 1))
    assert made.lookup("b", "b", 0) == (3 * S, IDENTITY)
    assert made.lookup("a", "a", 0) == (0, IDENTITY)
    assert made.lookup("b", "b", 7) == (7, IDENTITY)
    assert made.lookup("unheard", "unheard", 0) == (0, IDENTITY)


def test_a_new_parent_takes_over():
    made = tree(("a", "x", 1 * S, 1), ("b", "x", 2 * S, 2))
    assert made.lookup("b", "x", 0)[1].translation == (2.0, 0.0, 0.0)
    with pytest.raises(ConnectivityException):
        made.lookup("a", "x", 0)


def test_through_a_fixed_frame_two_times_meet():
    made = tree(
        ("odom", "base", 1 * S, 1),
        ("odom", "base", 2 * S, 5),
        ("base", "eye", None, 0.5),
    )
    _, moved = made.lookup_through("base", 2 * S, "eye", 1 * S, "odom")
    assert moved.translation == pytest.approx((1 + 0.5 - 5, 0, 0))


@pytest.mark.parametrize(
    ("stamps", "asked", "message"),
    [
        (
            (1, 2),
            3,
            "Lookup would require extrapolation into the future.  Requested time 3.000000 but the "
            "latest data is at time 2.000000, when looking up transform from frame [b] to frame "
            "[a]",
        ),
        (
            (1, 2),
            0.5,
            "Lookup would require extrapolation into the past.  Requested time 0.500000 but the "
            "earliest data is at time 1.000000, when looking up transform from frame [b] to frame "
            "[a]",
        ),
        (
            (1,),
            3,
            "Lookup would require extrapolation at time 3.000000, but only time 1.000000 is in "
            "the buffer, when looking up transform from frame [b] to frame [a]",
        ),
    ],
)
def test_times_that_are_not_known_are_refused_in_tf2s_words(stamps, asked, message):
    made = tree(*(("a", "b", stamp * S, 0) for stamp in stamps))
    with pytest.raises(ExtrapolationException) as caught:
        made.lookup("a", "b", int(asked * S))
    assert caught.value.message == message


def test_frames_of_two_trees_are_not_connected():
    made = tree(("a", "b", 1 * S, 0), ("c", "d", 1 * S, 0))
    with pytest.raises(ConnectivityException) as caught:
        made.lookup("b", "d", 0)
    assert caught.value.message == (
        "Could not find a connection between 'b' and 'd' because they are not part of the same "
        "tree.Tf has two or more unconnected trees."
    )


def test_names_are_checked_in_tf2s_words():
    made = tree(("a", "b", 1 * S, 0))
    with pytest.raises(InvalidArgumentException, match="frame_ids cannot be empty"):
        made.check("", "target_frame", "lookupTransform")
    with pytest.raises(InvalidArgumentException, match="cannot start with a '/'"):
        made.check("/a", "target_frame", "lookupTransform")
    with pytest.raises(LookupException) as caught:
        made.check("x", "source_frame", "lookupTransform")
    assert caught.value.message == (
        '"x" passed to lookupTransform argument source_frame does not exist. '
    )
    with pytest.raises(LookupException) as caught:
        made.check("x", "target_frame", "canTransform")
    assert caught.value.message == (
        'Invalid frame ID "x" passed to canTransform argument target_frame - frame does not exist'
    )


def test_a_ring_of_frames_is_reported():
    made = tree(("a", "b", 1 * S, 0), ("b", "c", 1 * S, 0), ("c", "a", 1 * S, 0), ("x", "y", S, 0))
    with pytest.raises(LookupException, match="contains a loop"):
        made.lookup("a", "x", 0)


def test_a_leading_slash_of_a_sender_is_dropped():
    assert tree(("/a", "/b", 1 * S, 1)).frames() == ["b", "a"]


def test_old_samples_are_forgotten():
    made = tree(*(("a", "b", n * S, float(n)) for n in range(1, 40)))
    assert made.lookup("a", "b", 30 * S)[1].translation[0] == 30
    with pytest.raises(ExtrapolationException, match="into the past"):
        made.lookup("a", "b", 20 * S)


def test_samples_may_arrive_out_of_order():
    made = tree(("a", "b", 20 * S, 20), ("a", "b", 18 * S, 18), ("a", "b", 19 * S, 100))
    assert made.lookup("a", "b", 19 * S)[1].translation[0] == 100


def test_a_second_sample_of_a_time_takes_the_place_of_the_first():
    made = tree(("a", "b", 1 * S, 1), ("a", "b", 2 * S, 2), ("a", "b", 3 * S, 3))
    for stamp in (3, 2):
        sample = TransformSample(stamp * S, "a", Transform((10.0 * stamp, 0.0, 0.0)))
        assert made.insert(sample, "b", "test", static=False)
        assert made.lookup("a", "b", stamp * S)[1].translation[0] == 10.0 * stamp


def test_late_samples_change_nothing_that_is_known(caplog):
    made = tree(("a", "b", 100 * S, 1), ("a", "still", None, 7))
    with caplog.at_level(logging.WARNING):
        for n in range(1, 30):
            sample = TransformSample(n * S // 10, "a", IDENTITY)
            assert not made.insert(sample, "b", "someone", static=False)
    assert caplog.text.count("TF_OLD_DATA ignoring data from the past for frame b") == 1
    for stamp in range(91, 96):
        assert made.insert(TransformSample(stamp * S, "a", IDENTITY), "b", "test", static=False)
    when, transform = made.lookup("a", "b", 0)
    assert (when, transform.translation[0]) == (100 * S, 1)


@pytest.mark.parametrize(
    ("parent", "child", "transform", "code"),
    [
        ("a", "a", IDENTITY, "TF_SELF_TRANSFORM"),
        ("a", "", IDENTITY, "TF_NO_CHILD_FRAME_ID"),
        ("", "a", IDENTITY, "TF_NO_FRAME_ID"),
        ("a", "b", Transform((math.nan, 0, 0)), "TF_NAN_INPUT"),
        ("a", "b", Transform(rotation=(0, 0, 0, 0)), "TF_DENORMALIZED_QUATERNION"),
        ("a", "b", Transform(rotation=(0, 0, 0, 1.1)), "TF_DENORMALIZED_QUATERNION"),
    ],
)
def test_what_is_no_transform_is_logged_and_left_out(parent, child, transform, code, caplog):
    made = FrameTree(10 * S)
    with caplog.at_level(logging.ERROR):
        assert not made.insert(TransformSample(S, parent, transform), child, "me", static=False)
    assert code in caplog.text
    assert made.frames() == []
