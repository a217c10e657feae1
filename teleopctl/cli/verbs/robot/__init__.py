"""``teleopctl robot``: what becomes of robots' files."""

from teleopctl.cli.verb import Verb, VerbGroup

GROUP = VerbGroup(
    "Check robots' files.",
    {
        "check": Verb(
            f"{__name__}.check:check",
            "Tell how robots' files are read, and whether they stand and move in simulation.",
            examples=(
                "teleopctl robot check my_robot.urdf.xacro",
                "teleopctl robot check ur.urdf.xacro ur_type:=ur5e name:=ur --simulate",
                "teleopctl robot check src --simulate",
            ),
        )
    },
)
