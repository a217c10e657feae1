"""``teleopctl lifecycle``: what ``ros2 lifecycle`` does, in its words."""

from teleopctl.cli.verb import Verb, VerbGroup

GROUP = VerbGroup(
    "Manage the states of managed nodes.",
    {
        "nodes": Verb(f"{__name__}.nodes:list_nodes", "List the managed nodes."),
        "get": Verb(f"{__name__}.states:get_state", "Print the state of one node, or of all."),
        "list": Verb(
            f"{__name__}.transitions:list_transitions", "List the transitions that are possible."
        ),
        "set": Verb(
            f"{__name__}.transitions:set_state",
            "Take a node through a transition.",
            examples=("teleopctl lifecycle set /camera configure",),
        ),
    },
)
