"""``teleopctl interface``: message, service and action types; one module per verb."""

from __future__ import annotations

from teleopctl.cli.verb import Verb, VerbGroup

GROUP = VerbGroup(
    "Use definitions of messages, services and actions.",
    {
        "list": Verb(f"{__name__}.listing:list_interfaces", "List the types."),
        "package": Verb(f"{__name__}.listing:package_interfaces", "List the types of a package."),
        "packages": Verb(f"{__name__}.listing:interface_packages", "List packages with types."),
        "show": Verb(
            f"{__name__}.show:show",
            "Print the definition of a type.",
            examples=(
                "teleopctl interface show sensor_msgs/msg/JointState",
                "teleopctl topic type /joint_states | teleopctl interface show -",
            ),
        ),
        "proto": Verb(f"{__name__}.show:proto", "Print the values of a type, to be filled in."),
        "stubs": Verb(
            f"{__name__}.stubs:stubs",
            "Write what editors and type checkers read of your own message packages.",
            examples=("teleopctl interface stubs typings",),
        ),
    },
    leaves_nothing=True,
)
