"""Servo's status in words for people: a sentence for each code, for servo's real texts."""

import re

import numpy as np
import pytest

from teleopctl.kinematics import (
    ClearanceChecker,
    ServoCore,
    StatusCode,
    find_groups,
)
from teleopctl.nodes.teleop.servo_words import (
    OUT_OF_REACH,
    SERVO_SENTENCES,
    hand_links,
    words_of_status,
)
from teleopctl.robot import RobotDescription
from tests import ROOT
from tests.kinematics.arms import SIX, THREE, arm, arm_urdf


def core_of(kinematics, positions, *, obstacles=False):
    clearance = ClearanceChecker(kinematics.model) if obstacles else None
    core = ServoCore(kinematics, np.full(len(kinematics.names), 10.0), clearance=clearance)
    core.reset(np.array(positions))
    return core


def words(core, twist, steps=300):
    """Words of the last of many steps with a twist."""
    for _ in range(steps):
        step = core.twist_step(np.array(twist, float), 0.01)
    description = core.kinematics.model.description
    tip = core.kinematics.group.tip
    return words_of_status(step.code, step.message, hand_links(description, tip))


@pytest.mark.parametrize("code", [code for code in StatusCode if code is not StatusCode.NO_WARNING])
def test_each_code_has_a_sentence_also_with_moveits_own_text_alone(code):
    sentence = words_of_status(code, code.text)
    assert re.fullmatch(r"[A-Z][^{}]{20,100}", sentence)
    assert not re.search(r"singular|tool|servo|\d", sentence)


def test_without_a_warning_there_is_none():
    assert words_of_status(StatusCode.NO_WARNING, StatusCode.NO_WARNING.text) == ""


@pytest.mark.parametrize("links", [THREE, SIX])
def test_a_stretched_arm_is_told_from_one_that_can_still_bend(links):
    # Upright: the first joint turns about the vertical.
    bent = [0.2, 0.4, 0.5, 0.3, 0.6, 0.1][: len(arm(links).names)]
    core = core_of(arm(links), bent)
    at = core.kinematics
    at.set(core.positions)
    away = at.pose()[:3, 3] - at.model.joint_origin(at.names[1])
    outward = [*(0.2 * away / np.linalg.norm(away)), 0.0, 0.0, 0.0]
    assert "stretched to its end: move back towards its base" in words(core, outward)
    back = [-value for value in outward]
    assert "stretched" not in words(core, back, 50)


def test_joints_bodies_and_a_turn_that_is_impossible_are_named():
    core = core_of(arm(SIX), [0.2, 0.4, 1.1, 0.6, 0.9, 1.2])
    for _ in range(400):
        step = core.joint_step(np.array([2.0, 0, 0, 0, 0, 0]), 0.01)
    assert words_of_status(step.code, step.message).startswith("joint_1 is at its limit: move back")
    core = core_of(arm(THREE), [0.2, 0.6, 0.9])
    assert words(core, [0, 0, 0, 0, 0, 0.2], 1).startswith("With 3 joints this arm cannot turn")


def test_parts_of_the_gripper_are_the_gripper_and_other_bodies_have_their_names():
    description = RobotDescription.from_urdf(arm_urdf(SIX))
    group = find_groups(description).group()
    hand = hand_links(description, group.tip)
    assert group.tip in hand
    assert description.root not in hand
    tip = group.tip
    text = f"Collision detected, emergency stop: 'table' is 0.001 m from '{tip}'"
    sentence = words_of_status(StatusCode.HALT_FOR_COLLISION, text, hand)
    assert sentence == "The gripper would touch 'table': move the other way"
    text = "Close to a collision, decelerating: 'base' is 0.008 m from 'forearm'"
    sentence = words_of_status(StatusCode.DECELERATE_FOR_COLLISION, text, hand)
    assert sentence.startswith("'base' is close to 'forearm', so the arm moves slower")


def test_the_page_of_the_manual_has_the_whole_table():
    text = (ROOT / "docs/drive.md").read_text(encoding="utf-8")
    for row in SERVO_SENTENCES:
        shown = re.sub(r"\{(\w+)\}", lambda found: found[1].upper(), row.sentence)
        assert f"| {int(row.code)} | {shown} |" in text
    assert OUT_OF_REACH in text
