"""Who may command while a hand drives: one rule for controllers and servo."""

from __future__ import annotations

from hypothesis import given, strategies as st

from teleopctl.node import SILENCE_S, CommandLease, LeaseClaim

HAND = LeaseClaim("/teleop_page", "keys", "pc", 5, 1, ("/servo_node",))
OTHER = LeaseClaim("/teleop_keyboard", term=1, since_ns=6)


def test_without_a_lease_anybody_may_command():
    assert CommandLease().refusal("/anybody", 0.0) == ""


def test_while_it_is_held_the_holder_and_its_servo_may_command_and_others_are_refused():
    lease = CommandLease()
    lease.receive(HAND, 10.0)
    assert lease.refusal("/teleop_page", 11.0) == lease.refusal("/servo_node", 11.0) == ""
    for sender in ("/move_group", ""):
        assert lease.refusal(sender, 11.0) == (
            "/teleop_page (keys, on pc) drives the robot; 'teleopctl drive --release' ends that"
        )


def test_it_ends_by_its_release_by_silence_and_by_a_stop():
    for end in (
        lambda lease: lease.receive(HAND, 11.0, is_held=False),
        lambda lease: None,
        lambda lease: lease.end(),
    ):
        lease = CommandLease()
        lease.receive(HAND, 10.0)
        end(lease)
        assert lease.holder(10.1 + SILENCE_S) is None
        assert lease.refusal("/move_group", 10.1 + SILENCE_S) == ""


def test_each_claim_of_the_holder_keeps_it():
    lease = CommandLease()
    for time_s in (10.0, 11.5, 13.0):
        lease.receive(HAND, time_s)
    assert lease.holder(14.5) == HAND


def test_a_later_term_takes_over_and_the_former_holder_s_claims_count_no_more():
    lease = CommandLease()
    lease.receive(HAND, 10.0)
    taker = LeaseClaim("/teleop_keyboard", term=2)
    lease.receive(taker, 10.1)
    lease.receive(HAND, 10.2)
    lease.receive(HAND, 10.3, is_held=False)
    assert lease.holder(10.4) == taker
    assert lease.term == 2


def test_a_later_term_that_is_not_held_ends_another_s_lease():
    lease = CommandLease()
    lease.receive(HAND, 10.0)
    lease.receive(LeaseClaim("/teleop_lease", term=2), 10.1, is_held=False)
    assert lease.holder(10.2) is None


claims = st.builds(
    LeaseClaim,
    holder=st.sampled_from(["/a", "/b", "/c"]),
    since_ns=st.integers(0, 2),
    term=st.integers(1, 3),
)


@given(st.lists(claims, min_size=1, max_size=5, unique=True), st.randoms())
def test_all_that_receive_the_same_claims_decide_alike_whatever_their_order(given_, random):
    one, other = CommandLease(), CommandLease()
    shuffled = list(given_)
    random.shuffle(shuffled)
    # A holder repeats its claim, so that the one that counts comes last everywhere.
    for lease, order in ((one, given_), (other, shuffled)):
        for claim in (*order, *order):
            lease.receive(claim, 0.0)
    first, second = one.holder(0.1), other.holder(0.1)
    assert first is not None and second is not None
    assert (first.holder, first.term) == (second.holder, second.term)
