"""``teleopctl bag``: recording, playing and working on bags."""

from __future__ import annotations

from teleopctl.cli.verb import Verb, VerbGroup

GROUP = VerbGroup(
    "Record, play and inspect bags.",
    {
        "record": Verb(
            f"{__name__}.record:record",
            "Record topics, services and actions into a bag.",
            examples=(
                "teleopctl bag record --all",
                "teleopctl bag record -o session --topics /joint_states /tf",
                "teleopctl bag record --all --exclude-regex image",
            ),
        ),
        "play": Verb(
            f"{__name__}.play:play",
            "Play a bag into the graph.",
            examples=(
                "teleopctl bag play my_bag --rate 0.5 --clock",
                "teleopctl bag play my_bag --topics /joint_states --remap /joint_states:=/old",
                "teleopctl bag play -i arm -i camera --start-offset 10 --loop",
            ),
        ),
        "burst": Verb(
            f"{__name__}.play:burst",
            "Send a bag's messages as fast as they can be read.",
            examples=("teleopctl bag burst my_bag -n 100",),
        ),
        "info": Verb(
            f"{__name__}.info:bag_info",
            "Show the contents of a bag.",
            examples=("teleopctl bag info my_bag", "teleopctl bag info -v my_bag/my_bag_0.mcap"),
        ),
        "list": Verb(f"{__name__}.info:list_plugins", "List storage and compression plug-ins."),
        "convert": Verb(
            f"{__name__}.files:convert_bag",
            "Convert bags.",
            examples=(
                "teleopctl bag convert old_session.bag -o session",
                "teleopctl bag convert -i my_bag -o outputs.yaml",
            ),
        ),
        "reindex": Verb(f"{__name__}.files:reindex_bag", "Rebuild metadata.yaml from the files."),
        "check": Verb(f"{__name__}.files:check_bag", "Check a bag for faults."),
        "recover": Verb(
            f"{__name__}.files:recover_bag",
            "Recover a truncated or damaged bag.",
            examples=("teleopctl bag recover my_bag", "teleopctl bag recover my_bag -o saved"),
        ),
        "filter": Verb(
            f"{__name__}.files:filter_bag",
            "Write some topics of a bag to a new bag.",
            examples=(
                "teleopctl bag filter my_bag -o arm --topics /joint_states /tf",
                "teleopctl bag filter my_bag -o small --exclude-topic-types sensor_msgs/msg/Image",
            ),
        ),
        "merge": Verb(
            f"{__name__}.files:merge_bags",
            "Merge several bags into one.",
            examples=("teleopctl bag merge robot_bag camera_bag -o both",),
        ),
        "cut": Verb(
            f"{__name__}.files:cut_bag",
            "Write a time range of a bag to a new bag.",
            examples=("teleopctl bag cut my_bag -o part --start-offset 10 --duration 5",),
        ),
        "export": Verb(
            f"{__name__}.export:export",
            "Export a bag as CSV, Parquet, MP4 or a LeRobot data set.",
            examples=(
                "teleopctl bag export my_bag",
                "teleopctl bag export my_bag --topics /joint_states --format parquet",
                "teleopctl bag export my_bag --topics /image_raw --format mp4",
                "teleopctl bag export my_bag --format lerobot --camera /image_raw "
                "--action /joint_trajectory_controller/controller_state",
            ),
        ),
        "plot": Verb(
            f"{__name__}.plot:plot",
            "Draw numbers of a bag over time, in the terminal or as a picture.",
            examples=(
                "teleopctl bag plot my_bag /joint_states/position",
                "teleopctl bag plot my_bag /joint_states/effort[1] /wrench/force/z -o forces.svg",
            ),
        ),
        "view": Verb(
            f"{__name__}.view:view",
            "Show a bag on the page, with a time line.",
            examples=("teleopctl bag view my_bag --open",),
        ),
        "verify": Verb(
            f"{__name__}.verify:verify",
            "Simulate a recorded session again, and compare.",
            examples=("teleopctl bag verify my_bag", "teleopctl bag verify my_bag --json"),
        ),
    },
)
