"""The flags of `topic echo`, `service echo` and `action echo` for how messages are written."""

import inspect

import pytest

from teleopctl.cli.verbs.action.echo import echo as action_echo
from teleopctl.cli.verbs.service.echo import echo as service_echo
from teleopctl.cli.verbs.topic.echo import echo as topic_echo
from teleopctl.cli.verbs.topic.text_options import style_of
from teleopctl.errors import UsageError

PLAIN = {"flow_style": False, "full_length": False, "no_arr": False, "no_str": False}


@pytest.mark.parametrize("echo", [action_echo, service_echo, topic_echo])
def test_every_echo_takes_them_all(echo):
    assert {*PLAIN, "truncate_length", "csv"} <= inspect.signature(echo).parameters.keys()


def test_a_length_is_kept_unless_everything_is_wanted_and_is_never_negative():
    assert style_of(**PLAIN, truncate_length=3).truncate == 3
    assert style_of(**PLAIN | {"full_length": True}, truncate_length=3).truncate is None
    with pytest.raises(UsageError, match="truncate-length"):
        style_of(**PLAIN, truncate_length=-1)


def test_an_action_is_not_looked_for_before_its_flags_are_right():
    with pytest.raises(UsageError, match="truncate-length"):
        action_echo("/nobody", truncate_length=-1)
