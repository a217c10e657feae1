"""Arguments and options that verbs of bags share."""

from typing import Annotated

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
        help="The form of its files, where their names do not tell.",
        choices=("mcap", "sqlite3"),
    ),
]
