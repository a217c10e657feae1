"""Messages are compared bit by bit, by their times; what differs is named with both values."""

from __future__ import annotations

import math

import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Transform, TransformStamped, Vector3
from hypothesis import given, strategies as st
from sensor_msgs.msg import JointState
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

from teleopctl.bag.verify.comparison import (
    ComparedStream,
    Difference,
    DifferenceKind,
    RecordedMessage,
    ReplayComparison,
    differences,
    flatten_fields,
)
from teleopctl.interfaces import serialize

TOPIC, TYPE = "/joint_states", "sensor_msgs/msg/JointState"
S = 1_000_000_000

numbers = st.floats(width=64)
states = st.lists(st.tuples(numbers, numbers, numbers), max_size=4).map(
    lambda rows: JointState(
        name=[f"joint_{number}" for number in range(len(rows))],
        position=[row[0] for row in rows],
        velocity=[row[1] for row in rows],
        effort=[row[2] for row in rows],
    )
)


def data(seconds, position=0.0):
    stamp = Time(sec=seconds)
    return bytes(serialize(JointState(header=Header(stamp=stamp), name=["a"], position=[position])))


def stream(seconds, numbers=None, **options):
    """A topic on which a message was recorded at each of these times, in this order."""
    numbers = numbers or range(1, len(seconds) + 1)
    recorded = [
        RecordedMessage(second * S, data(second), number, log_time_ns=index * S)
        for index, (second, number) in enumerate(zip(seconds, numbers, strict=True))
    ]
    return ComparedStream(TOPIC, TYPE, recorded, numbers=frozenset(numbers), **options)


def run(recorded, seconds, reference=None):
    """What differs from a run with a message at each of these times."""
    for second in seconds:
        recorded.take(second * S, data(second))
    recorded.close(reference)
    return [(each.kind, each.time_ns // S) for each in recorded.differences]


@given(states)
def test_a_message_is_the_same_as_itself(state):
    assert list(differences(TOPIC, 0, state, state)) == []


@given(states)
def test_each_number_is_named_by_its_joint(state):
    found = dict(flatten_fields(state))
    for index, name in enumerate(state.name):
        assert found[f"name[{index}]"] == name
        for field in ("position", "velocity", "effort"):
            value = getattr(state, field)[index]
            assert found[f"{field}[{name}]"] == value or math.isnan(value)


def test_a_transform_is_named_by_its_frame():
    move = TransformStamped(child_frame_id="arm", transform=Transform(translation=Vector3(x=0.5)))
    assert (
        dict(flatten_fields(TFMessage(transforms=[move])))[
            "transforms[arm].transform.translation.x"
        ]
        == 0.5
    )


@pytest.mark.parametrize(("one", "other"), [(1.0, math.nextafter(1.0, 2.0)), (0.0, -0.0)])
def test_the_last_bit_counts_unless_a_tolerance_is_given(one, other):
    for tolerance, is_same in ((0.0, False), (1e-9, True)):
        compared = ComparedStream(
            TOPIC, TYPE, [RecordedMessage(S, data(1, one))], tolerance=tolerance
        )
        compared.take(S, data(1, other))
        assert compared.is_same is is_same
        if not is_same:
            assert compared.differences == [Difference(TOPIC, S, "position[a]", one, other)]


def test_the_first_difference_is_listed_and_the_largest_of_each_field():
    verdict = ReplayComparison()
    compared = ComparedStream(
        TOPIC, TYPE, [RecordedMessage(t * S, data(t, 1.0)) for t in (1, 2, 3, 4)]
    )
    verdict.streams.append(compared)
    for second, offset in ((1, 0.0), (2, 0.5), (3, 2.0), (4, 1.0)):
        compared.take(second * S, data(second, 1.0 + offset))
    compared.close()
    assert [each.time_ns for each in verdict.first_differences] == [2 * S]
    assert verdict.largest_differences == [Difference(TOPIC, 3 * S, "position[a]", 1.0, 3.0)]
    assert str(verdict.first_differences[0]) == (
        "/joint_states 2.000 s: position[a] was 1.0 and is 1.5 (0.5 apart)"
    )


@pytest.mark.parametrize("tolerance", [0.0, 1e9])
def test_a_joint_that_one_of_them_lacks_differs_whatever_is_tolerated(tolerance):
    compared = ComparedStream(TOPIC, TYPE, [RecordedMessage(S, data(1))], tolerance=tolerance)
    compared.take(S, bytes(serialize(JointState(header=Header(stamp=Time(sec=1))))))
    assert [(each.field, each.replayed) for each in compared.differences] == [
        ("name[0]", None),
        ("position[a]", None),
    ]
    assert compared.differences[1].size == math.inf


def test_what_nobody_recorded_before_or_after_is_no_difference():
    assert run(stream([3, 4, 5]), range(9)) == []


@pytest.mark.parametrize(
    ("seconds", "found"),
    [
        ([1, 2, 4, 5], [(DifferenceKind.MISSING, 3)]),
        ([1, 2, 3, 3, 4], [(DifferenceKind.EXTRA, 3)]),
        (
            [1, 2, 9],
            [
                *((DifferenceKind.MISSING, second) for second in range(3, 9)),
                (DifferenceKind.EXTRA, 9),
            ],
        ),
        ([1, 3, 2, 4], [(DifferenceKind.ORDER, 2)]),
    ],
    ids=["missing", "twice", "of no time of the run", "in another order"],
)
def test_a_message_too_few_or_too_many_or_in_a_wrong_place_is_found(seconds, found):
    assert run(stream(seconds), [*range(9)]) == found


def test_states_of_a_paused_simulation_come_again_and_other_ones_after_a_change():
    assert run(stream([1, 2, 2, 2, 3], may_repeat=True), range(9)) == []
    moved = [
        RecordedMessage(2 * S, data(2, position), number)
        for number, position in enumerate([0.0, 0.5], 1)
    ]
    placed = ComparedStream(TOPIC, TYPE, moved, may_repeat=True)
    for position in (0.0, 0.5):
        placed.take(2 * S, data(2, position))
    placed.close()
    assert (placed.compared, placed.is_same) == (2, True)
    # A bag that holds a message twice has its number twice.
    twice = stream([1, 2, 2], [1, 2, 2], may_repeat=True)
    assert run(twice, range(9)) == [(DifferenceKind.EXTRA, 2)]


def test_a_publisher_that_may_leave_messages_out_has_whole_numbers_where_it_did():
    assert run(compared := stream([1, 2, 4, 5], may_skip=True), range(9)) == []
    assert compared.skipped_ns == [3 * S]
    # The recorder counted one that is not there.
    taken_out = stream([1, 2, 4, 5], [1, 2, 4, 5], may_skip=True)
    assert run(taken_out, range(9)) == [(DifferenceKind.MISSING, 3)]
    # Nobody counted.
    unnumbered = stream([1, 2, 4, 5], [0, 0, 0, 0], may_skip=True)
    assert run(unnumbered, range(9)) == [(DifferenceKind.MISSING, 3)]


def test_an_end_that_comes_too_early_is_missing():
    longer = stream(range(9))
    assert run(stream([1, 2, 3]), range(9), longer) == [(DifferenceKind.MISSING, 4)]
    assert run(stream(range(8)), range(9), longer) == []
    assert run(stream([]), range(9), longer) == [(DifferenceKind.MISSING, 0)]
