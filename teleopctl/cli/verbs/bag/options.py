"""Arguments and options that verbs of bags share."""

from teleopctl.base.typed import Annotated
from teleopctl.cli.verb import Argument, Option

BagPath = Annotated[
    str,
    Argument(help="The bag: its folder, or one of its files.", metavar="BAG", complete="bags"),
]
Storage = Annotated[
    str | None,
    Option(
        "-s",
        "--storage",
        help="Storage of the bag, if its files' names do not show it.",
        choices=("mcap", "sqlite3"),
    ),
]

BagPaths = Annotated[
    list[str],
    Argument(help="The bags: folders, or files of them.", metavar="BAG...", complete="bags"),
]
OutputFolder = Annotated[
    str, Option("-o", "--output", help="The folder to be made.", metavar="FOLDER")
]
CompressionName = Annotated[
    str,
    Option("--compression", help="How chunks are compressed.", choices=("none", "lz4", "zstd")),
]
MaxBagSize = Annotated[
    int,
    Option("-b", "--max-bag-size", help="Bytes at which a new file begins; 0 for never."),
]
MaxBagDuration = Annotated[
    float,
    Option("-d", "--max-bag-duration", help="Seconds at which a new file begins; 0 for never."),
]
ChosenTopics = Annotated[
    list[str] | None,
    Option("--topics", help="Only these topics.", metavar="TOPIC"),
]
ChosenServices = Annotated[
    list[str] | None,
    Option("--services", help="Only the events of these services.", metavar="NAME"),
]
ChosenTypes = Annotated[
    list[str] | None,
    Option("--topic-types", help="Only topics of these types.", metavar="TYPE"),
]
Regex = Annotated[
    str,
    Option("-e", "--regex", help="Only topics and services in whose names this is found."),
]
ExcludeRegex = Annotated[
    str,
    Option("-x", "--exclude-regex", help="No topics and services in whose names this is found."),
]
ExcludeTopics = Annotated[
    list[str] | None,
    Option("--exclude-topics", help="Not these topics.", metavar="TOPIC"),
]
ExcludeTypes = Annotated[
    list[str] | None,
    Option("--exclude-topic-types", help="No topics of these types.", metavar="TYPE"),
]
StartOffset = Annotated[
    float | None,
    Option("--start-offset", help="Seconds from the beginning of the bag to that of the new one."),
]
Duration = Annotated[
    float | None, Option("--duration", help="Seconds that the new bag lasts at most.")
]
From = Annotated[
    float | None, Option("--from", help="Seconds since the epoch at which the new bag begins.")
]
Until = Annotated[
    float | None,
    Option("--until", help="Seconds since the epoch up to which the new bag lasts, exclusive."),
]
