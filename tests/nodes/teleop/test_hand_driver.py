"""When a hand moves the robot: not from samples that have waited, nor again by itself."""

from typing import Any

import pytest

from teleopctl.node.values.command_lease import LeaseClaim
from teleopctl.nodes.teleop.hand_driver import HandDriver
from teleopctl.teleop import HandCommand
from teleopctl.tf import Transform

HELD, RELEASED = HandCommand(linear=(1.0, 0.0, 0.0), is_held=True), HandCommand()
SPEEDS = (1.0,)


class Servo:
    """Servo that notes what it is sent."""

    problem = ""

    def __init__(self):
        self.sent: list[Any] = []

    def move(self, command, part, frame, *, begins):
        self.sent.append(command)

    def repeat(self):
        self.sent.append("repeated")

    def pull(self, target, *, begins):
        self.sent.append(target)

    def jog(self, displacements, *, begins):
        self.sent.append(displacements)

    def halt(self):
        self.sent.append("halt")


class Lease:
    """Lease that is free.

    Attributes:
        holder: Another node that holds it, if one does.
    """

    holder: LeaseClaim | None = None
    is_held = False

    @property
    def watch(self):
        return self

    def take(self, device):
        return f"{self.holder} drives the robot" if self.holder else ""

    def is_lost(self):
        return False

    def release(self):
        pass


class Hand:
    """A driver with a clock of its own.

    Attributes:
        now_s: Time on the monotonic clock, s.
    """

    def __init__(self, node, monkeypatch):
        self.now_s = 1000.0
        monkeypatch.setattr("teleopctl.nodes.teleop.hand_driver.time.monotonic", lambda: self.now_s)
        self.driver = HandDriver(node, "gamepad")
        # The test itself looks, and nobody else drives.
        node.destroy_timer(self.driver._timer)
        self.lease = Lease()
        self.driver._lease = self.lease  # type: ignore[assignment]
        self.driver._servo = self._servo = Servo()  # type: ignore[assignment]

    def moves(self, act, period_s=0.02, samples=1):
        """Whether samples move the robot; the last one counts."""
        for _ in range(samples):
            self.now_s += period_s
            self._servo.sent.clear()
            act(self.driver)
        return any(sent != "halt" for sent in self._servo.sent)

    def is_silent(self, duration_s):
        """Let time pass in which nothing is heard, and the driver looks as often as it can."""
        end_s = self.now_s + duration_s
        while self.now_s < end_s:
            self.now_s += 0.02
            self.driver._watch()

    def holds(self, act, duration_s, *, is_answered):
        """Hold something for a time in which servo answers or not; return whether it moves."""
        end_s, moves = self.now_s + duration_s, True
        while self.now_s < end_s:
            moves = self.moves(act)
            if is_answered:
                self.driver.robot_state.answered_s = self.now_s
            self.driver._watch()
        return moves


def keys(driver):
    driver.apply(HELD, SPEEDS)


def lets_go(driver):
    driver.apply(RELEASED, SPEEDS)


def handle(driver):
    driver.pull(Transform((0.1, 0.2, 0.3)))


def leader(driver):
    driver.jog({"joint_1": 0.01})


@pytest.fixture
def hand(shared_ros, monkeypatch):
    return Hand(shared_ros.node, monkeypatch)


@pytest.mark.parametrize("act", [keys, handle, leader])
def test_samples_that_waited_while_the_process_stood_still_move_nothing(hand, act):
    assert hand.moves(act)
    hand.now_s += 0.5  # the process was suspended: nobody has looked
    assert not hand.moves(act, period_s=0.001, samples=50)
    assert hand.moves(act, samples=15)  # what is still held moves on


def test_a_hand_that_let_go_meanwhile_moves_nothing(hand):
    assert hand.moves(keys)
    hand.now_s += 0.5
    assert not hand.moves(keys, period_s=0.001)
    assert not hand.moves(lets_go, period_s=0.001)
    hand.now_s += 1.0
    assert hand.moves(keys)


@pytest.mark.parametrize("act", [keys, handle, leader])
def test_a_hand_that_servo_does_not_answer_is_pressed_again(hand, act):
    assert hand.holds(act, 3.0, is_answered=True)
    assert not hand.holds(act, 3.0, is_answered=False)
    assert "servo does not answer" in hand.driver.pull(Transform())
    assert not hand.holds(act, 1.0, is_answered=True)  # servo goes on, and the hand still holds
    hand.driver.release()
    assert hand.holds(act, 1.0, is_answered=True)


def test_a_command_that_comes_again_is_published_each_time_and_looked_at_in_between(hand):
    published = []
    for _ in range(20):
        assert hand.moves(keys)
        published += hand._servo.sent
    assert len(published) == 20
    assert 3 <= published.count(HELD) <= 6, "a whole look each 0.1 s"
    assert published.count(HELD) + published.count("repeated") == 20


def test_a_command_that_comes_again_ends_once_another_node_drives(hand):
    assert hand.moves(keys, samples=10)
    hand.lease.holder = LeaseClaim("/other", "keys", "here")
    assert not hand.moves(keys, samples=7)


@pytest.mark.parametrize("act", [keys, handle])
def test_a_hand_that_was_silent_is_pressed_again(hand, act):
    assert hand.moves(act)
    hand.is_silent(2.5)
    assert not hand.moves(act, samples=50)
    lets_go(hand.driver)
    assert hand.moves(act, samples=15)


@pytest.mark.parametrize("act", [keys, handle, leader])
def test_what_was_held_while_another_node_drove_is_pressed_again(hand, act):
    hand.lease.holder = LeaseClaim("/other", "keys", "here")
    assert not hand.moves(act, samples=5)
    assert hand.driver.state(SPEEDS)["refusal"] == "/other (keys, on here) drives the robot"
    hand.lease.holder = None
    assert not hand.moves(act, samples=50)
    assert "let go, and press again" in hand.driver.state(SPEEDS)["refusal"]
    hand.driver.release()
    assert hand.moves(act)
