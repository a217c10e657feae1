"""The flags of `topic echo`, `service echo` and `action echo` for how messages are written."""

import pytest

from teleopctl.cli.verb import parameters
from teleopctl.cli.verbs.action import echo as action_echo
from teleopctl.cli.verbs.service import echo as service_echo
from teleopctl.cli.verbs.topic.echo import echo as topic_echo
from teleopctl.cli.verbs.topic.text import TextOptions
from teleopctl.errors import UsageError


@pytest.mark.parametrize("echo", [action_echo, service_echo, topic_echo])
def test_every_echo_takes_them_all(echo):
    assert TextOptions.__annotations__.keys() <= {each.name for each in parameters(echo)}


def test_a_length_is_kept_unless_everything_is_wanted_and_is_never_negative():
    assert TextOptions(truncate_length=3).style(as_json=False).truncate == 3
    assert TextOptions(truncate_length=3, full_length=True).style(as_json=False).truncate is None
    with pytest.raises(UsageError, match="truncate-length"):
        TextOptions(truncate_length=-1)
