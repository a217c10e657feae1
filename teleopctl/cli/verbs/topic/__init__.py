"""``teleopctl topic``: one module per verb, imported when that verb runs."""

from __future__ import annotations

from teleopctl.cli.verb import Verb, VerbGroup

GROUP = VerbGroup(
    "List, print, measure and publish topics.",
    {
        "list": Verb(f"{__name__}.listing:list_topics", "List the topics."),
        "info": Verb(
            f"{__name__}.listing:topic_info", "Show the publishers and subscriptions of a topic."
        ),
        "echo": Verb(
            f"{__name__}.echo:echo",
            "Print the messages of a topic.",
            examples=(
                "teleopctl topic echo /joint_states --field position",
                "teleopctl topic echo --once --full-length /robot_description",
                "teleopctl topic echo /joint_states --plot position",
            ),
        ),
        "pub": Verb(
            f"{__name__}.pub:publish",
            "Publish messages to a topic.",
            examples=(
                'teleopctl topic pub --once /chatter std_msgs/msg/String "{data: hello}"',
                'teleopctl topic pub -r 10 /cmd geometry_msgs/msg/Twist "{linear: {x: 0.5}}"',
            ),
        ),
        "hz": Verb(
            f"{__name__}.measuring:measure_rate",
            "Measure the rate of topics.",
            examples=("teleopctl topic hz /image_raw /joint_states",),
        ),
        "bw": Verb(f"{__name__}.measuring:measure_bandwidth", "Measure the bandwidth of topics."),
        "delay": Verb(
            f"{__name__}.measuring:measure_delay", "Measure the age of stamped messages."
        ),
        "type": Verb(f"{__name__}.listing:topic_type", "Print the type of a topic."),
        "find": Verb(f"{__name__}.listing:topics_of_type", "List the topics of a type."),
    },
    leaves_nothing=True,
)
