"""``teleopctl component``: what ``ros2 component`` does, in its words."""

from teleopctl.cli.verb import Verb, VerbGroup

GROUP = VerbGroup(
    "Load nodes into containers.",
    {
        "types": Verb(f"{__name__}.types:list_types", "List the components that can be loaded."),
        "list": Verb(f"{__name__}.containers:list_containers", "List the loaded components."),
        "load": Verb(
            f"{__name__}.loading:load",
            "Load a component into a container.",
            examples=(
                "teleopctl component load /ComponentManager composition composition::Talker "
                "-n alice -r chatter:=said",
            ),
        ),
        "unload": Verb(f"{__name__}.loading:unload", "Unload components from a container."),
        "standalone": Verb(
            f"{__name__}.standalone:standalone",
            "Run a component in a container of its own.",
            examples=("teleopctl component standalone composition composition::Talker",),
        ),
    },
)
