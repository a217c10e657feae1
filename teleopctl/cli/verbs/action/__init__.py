"""``teleopctl action``: what ``ros2 action`` does, in its words."""

from teleopctl.cli.verb import Verb, VerbGroup

GROUP = VerbGroup(
    "List actions, send goals and watch them.",
    {
        "list": Verb(f"{__name__}.listing:list_actions", "List the actions."),
        "info": Verb(f"{__name__}.listing:action_info", "Show who serves and who uses an action."),
        "type": Verb(f"{__name__}.listing:action_type", "Print the type of an action."),
        "find": Verb(f"{__name__}.listing:actions_of_type", "List the actions of a type."),
        "send_goal": Verb(
            f"{__name__}.send_goal:send_goal",
            "Send a goal and wait for its result.",
            examples=(
                "teleopctl action send_goal -f /fibonacci "
                'example_interfaces/action/Fibonacci "{order: 5}"',
            ),
        ),
        "echo": Verb(f"{__name__}.echo:echo", "Print the feedback and goal states of an action."),
    },
    leaves_nothing=True,
)
