"""The page on ros2's verbs and flags says what is so, and why what is missing is missing."""

from teleopctl.cli import ros2_options
from tests import ros2_table
from tests.ros2_flags import FLAGS, NOT_HERE, OTHER_TEXTS, OTHERWISE

ROWS = ros2_table.rows()


def test_there_is_a_reason_for_what_is_missing():
    without = [name for row in ROWS for name, reason in row.reasons().items() if not reason]
    assert not without, "say in tests/ros2_flags.py why it is not here"


def test_no_reason_is_left_over():
    groups = {row.group for row in ROWS}
    missing = {row.group for row in ROWS if not row.is_here}
    for row in ROWS:
        missing |= {f"{name} {flag}" for name in (row.name, row.group) for flag in row.missing}
    assert NOT_HERE.keys() <= missing
    assert OTHERWISE.keys() <= FLAGS.keys() | groups
    assert {verb for verb, *_ in OTHER_TEXTS} <= {*FLAGS, *groups, "every verb"}


def test_a_verb_that_is_missing_is_told_from_a_misspelt_one():
    missing = {row.name for row in ROWS if not row.is_here}
    assert all(ros2_options.is_missing_verb(name.split()) for name in missing)
