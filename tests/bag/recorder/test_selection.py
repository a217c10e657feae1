"""Which topics are recorded, by the rules of rosbag2."""

import pytest

from teleopctl.bag import Selection, read_static_topics
from teleopctl.errors import InvalidFileError, UsageError

STRING = "std_msgs/msg/String"
EVENT = "std_srvs/srv/Trigger_Event"
FEEDBACK = "example_interfaces/action/Fibonacci_FeedbackMessage"

PLAIN = ("/chatter", STRING)
HIDDEN = ("/_secret", STRING)
SERVICE = ("/reset/_service_event", EVENT)
ACTION = ("/walk/_action/feedback", FEEDBACK)
ACTION_EVENT = (
    "/walk/_action/send_goal/_service_event",
    "example_interfaces/action/Fibonacci_SendGoal_Event",
)
CANCEL_EVENT = ("/walk/_action/cancel_goal/_service_event", "action_msgs/srv/CancelGoal_Event")
EVERYTHING = [PLAIN, HIDDEN, SERVICE, ACTION, ACTION_EVENT, CANCEL_EVENT]


def recorded(**options):
    selection = Selection(**options)
    chosen = [topic for topic in EVERYTHING if selection.chooses(*topic)]
    return [topic for topic in chosen if selection.passes_hidden_rule(*topic)]


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({"all_topics": True}, [PLAIN]),
        ({"all_topics": True, "include_hidden_topics": True}, [PLAIN, HIDDEN]),
        ({"all_services": True}, [SERVICE]),
        ({"all_actions": True}, [ACTION, ACTION_EVENT, CANCEL_EVENT]),
        ({"topics": ["/chatter"]}, [PLAIN]),
        ({"topics": ["/_secret"]}, []),
        ({"topics": ["/reset"]}, []),
        ({"services": ["/reset"]}, [SERVICE]),
        ({"services": ["/chatter"]}, []),
        ({"actions": ["/walk"]}, [ACTION, ACTION_EVENT, CANCEL_EVENT]),
        ({"topic_types": [STRING]}, [PLAIN]),
        ({"topic_types": [EVENT]}, []),
        ({"regex": "chat"}, [PLAIN]),
        ({"regex": "^/(chatter|reset)$"}, [PLAIN, SERVICE]),
        ({"regex": "walk$"}, [ACTION, ACTION_EVENT, CANCEL_EVENT]),
        ({"all_topics": True, "exclude_topics": ["/chatter"]}, []),
        ({"all_topics": True, "exclude_topic_types": [STRING]}, []),
        ({"all_topics": True, "all_services": True, "exclude_regex": "e"}, []),
        ({"all_services": True, "exclude_services": ["/reset"]}, []),
        ({"all_actions": True, "exclude_actions": ["/walk"]}, []),
        ({"topics": ["/chatter"], "exclude_regex": "chat"}, []),
        ({"topic_types": [STRING], "exclude_topics": ["/chatter"]}, []),
        ({"regex": "chat", "exclude_topic_types": [STRING]}, []),
        ({"topics": ["/nobody"], "regex": "chat"}, [PLAIN]),
        ({"all_topics": True, "regex": "nothing"}, [PLAIN]),
        ({"static_topics": dict([PLAIN])}, [PLAIN]),
        ({"static_topics": dict([SERVICE, ACTION])}, [SERVICE, ACTION]),
        ({"static_topics": dict([HIDDEN])}, []),
        ({"static_topics": dict([PLAIN]), "exclude_regex": "chat"}, []),
        ({"static_topics": dict([SERVICE]), "topics": ["/chatter"]}, [PLAIN, SERVICE]),
    ],
)
def test_what_is_recorded_follows_from_the_options(options, expected):
    assert recorded(**options) == expected


def test_nothing_is_recorded_unless_something_is_chosen():
    assert Selection().is_empty
    assert Selection(include_hidden_topics=True, exclude_topics=["/x"]).is_empty
    assert recorded() == []
    assert not Selection(actions=["/walk"]).is_empty
    assert not Selection(static_topics=dict([PLAIN])).is_empty


def test_a_name_without_slash_is_resolved_as_the_node_resolves_it():
    selection = Selection(
        topics=["chatter"],
        services=["reset"],
        exclude_actions=["walk"],
        static_topics={"later": STRING},
    )
    absolute = selection.with_absolute_names(lambda name: f"/t/{name}", lambda name: f"/s/{name}")
    assert absolute.topics == {"/t/chatter"}
    assert absolute.services == {"/s/reset"}
    assert absolute.static_topics == {"/t/later": STRING}
    assert absolute.exclude_actions == {"/s/walk"}


def test_what_is_no_regular_expression_is_refused():
    with pytest.raises(UsageError, match="is not a regular expression"):
        Selection(regex="(")
    with pytest.raises(UsageError, match="is not a regular expression"):
        Selection(all_topics=True, exclude_regex="[")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("\n- /chatter", ":2: expected a topic and its type, got '/chatter'"),
        ("\n- [/chatter, '']", ":2: expected a topic and its type"),
        ("\n- [/a, b/C]\n- [/a, b/D]", ":3: '/a' is given twice"),
        (" {}", ": it has no list 'static_topics_and_types_list'"),
        (" [", ":2: not YAML"),
    ],
)
def test_a_wrong_file_of_static_topics_is_refused_with_its_line(tmp_path, text, told):
    file = tmp_path / "static.yaml"
    file.write_text(f"static_topics_and_types_list:{text}\n")
    with pytest.raises(InvalidFileError) as caught:
        read_static_topics(file)
    assert caught.value.message.startswith(f"{file}{told}")
