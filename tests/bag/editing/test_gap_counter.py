"""What a recorder's count tells of losses."""

from __future__ import annotations

from hypothesis import given, strategies as st

from teleopctl.bag.editing.checking import GapCounter

RECORDED = st.integers(1, 60).flatmap(
    lambda last: st.tuples(st.just(last), st.sets(st.integers(1, last)), st.randoms())
)


@given(RECORDED)
def test_what_is_missing_is_counted_exactly_whatever_overtakes_what(recorded):
    last, lost, random = recorded
    there = [number for number in range(1, last + 1) if number not in lost]
    sequences = GapCounter()
    # Repeated messages have no number.
    numbers = [*there, 0, 0]
    random.shuffle(numbers)
    for number in numbers:
        sequences.add(number)
    between = {number for number in lost if there and there[0] < number < there[-1]}
    assert sequences.missing == len(between)


@given(st.sets(st.integers(1, 60), min_size=1))
def test_in_order_a_loss_is_told_where_it_shows(there):
    sequences = GapCounter()
    shown = [number for number in sorted(there) if sequences.add(number)]
    assert shown == [n for n in sorted(there) if n - 1 not in there and n != min(there)]
