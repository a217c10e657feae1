"""``teleopctl pkg``: which packages there are, where, and what they offer."""

from teleopctl.cli.verb import Verb, VerbGroup

GROUP = VerbGroup(
    "Find and create packages.",
    {
        "create": Verb(
            f"{__name__}.create:create",
            "Create a new package.",
            examples=(
                "teleopctl pkg create --build-type ament_python --node-name talker greeter",
                "teleopctl pkg create greeter --dependencies rclpy std_msgs",
            ),
        ),
        "executables": Verb(f"{__name__}.queries:executables", "List the programs of packages."),
        "list": Verb(f"{__name__}.queries:list_packages", "List the packages."),
        "prefix": Verb(
            f"{__name__}.queries:prefix", "Print the folder below which a package is installed."
        ),
        "xml": Verb(f"{__name__}.queries:xml", "Print the manifest of a package, or a tag of it."),
    },
)
