"""States are compared bit by bit, by joint; what differs first is told, and what differs most."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, strategies as st
from sensor_msgs.msg import JointState

from teleopctl.bag.verify.comparison import Difference, Verdict

numbers = st.floats(width=64)
states = st.lists(st.tuples(numbers, numbers, numbers), max_size=4).map(
    lambda rows: JointState(
        name=[f"joint_{number}" for number in range(len(rows))],
        position=[row[0] for row in rows],
        velocity=[row[1] for row in rows],
        effort=[row[2] for row in rows],
    )
)


@given(states, st.randoms())
def test_a_state_is_the_same_as_itself_in_whatever_order_its_joints_come(state, random):
    order = list(range(len(state.name)))
    random.shuffle(order)
    turned = JointState(
        name=[state.name[index] for index in order],
        position=[state.position[index] for index in order],
        velocity=[state.velocity[index] for index in order],
        effort=[state.effort[index] for index in order],
    )
    verdict = Verdict()
    verdict.compare(0, state, turned)
    assert (verdict.is_same, verdict.states) == (True, 1)


def test_the_last_bit_counts_unless_a_tolerance_is_given():
    recorded = JointState(name=["a"], position=[1.0])
    replayed = JointState(name=["a"], position=[math.nextafter(1.0, 2.0)])
    strict, tolerant = Verdict(), Verdict(tolerance=1e-9)
    for verdict in (strict, tolerant):
        verdict.compare(5, recorded, replayed)
    assert strict.first == [Difference(5, "a", "position", 1.0, math.nextafter(1.0, 2.0))]
    assert tolerant.is_same


def test_the_first_difference_is_kept_and_the_largest_of_each_joint():
    verdict = Verdict()
    for time_ns, offset in ((10, 0.0), (20, 0.5), (30, 2.0), (40, 1.0)):
        recorded = JointState(name=["a", "b"], position=[1.0, 1.0], velocity=[0.0, 0.0])
        replayed = JointState(name=["a", "b"], position=[1.0 + offset, 1.0], velocity=[0.0, 0.0])
        verdict.compare(time_ns, recorded, replayed)
    assert [d.time_ns for d in verdict.first] == [20]
    assert verdict.largest == {("a", "position"): Difference(30, "a", "position", 1.0, 3.0)}
    assert str(verdict.first[0]) == "0.000 s: a position was 1.0 and is 1.5 (0.5 apart)"


@pytest.mark.parametrize("tolerance", [0.0, 1e9])
def test_a_joint_that_one_of_them_lacks_differs_whatever_is_tolerated(tolerance):
    verdict = Verdict(tolerance=tolerance)
    verdict.compare(0, JointState(name=["a"], position=[1.0]), JointState())
    assert math.isnan(verdict.first[0].replayed)
    assert verdict.first[0].size == math.inf
