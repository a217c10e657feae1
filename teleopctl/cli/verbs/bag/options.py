"""Arguments and options that verbs of bags share."""

from teleopctl.base.typed import TYPE_CHECKING, Annotated
from teleopctl.cli.verb import Argument, Option, OptionSet
from teleopctl.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from teleopctl.bag import Bag, WriterOptions

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
OutputFolder = Annotated[str, Option("-o", "--output", help="Output folder.", metavar="FOLDER")]


class FileOptions(OptionSet):
    """Options for writing a bag: compression, and size and duration of each file."""

    compression: Annotated[
        str,
        Option("--compression", help="Compression of chunks.", choices=("none", "lz4", "zstd")),
    ] = "zstd"
    max_bag_size: Annotated[
        int,
        Option(
            "-b", "--max-bag-size", help="Size in bytes after which a new file starts; 0 for never."
        ),
    ] = 0
    max_bag_duration: Annotated[
        float,
        Option(
            "-d",
            "--max-bag-duration",
            help="Duration in seconds after which a new file starts; 0 for never.",
        ),
    ] = 0.0

    def check(self) -> None:
        """Raise a UsageError if the size or the duration is negative."""
        if self.max_bag_size < 0 or self.max_bag_duration < 0:
            raise UsageError("Size and duration of a file cannot be negative")

    def writer_options(self, storage: str = "mcap") -> "WriterOptions":
        """Return these options as WriterOptions, for storage ``mcap`` or ``sqlite3``."""
        from teleopctl.bag import Compression, WriterOptions, database_settings
        from teleopctl.interfaces import from_seconds

        return WriterOptions(
            compression=Compression(self.compression),
            database_settings=database_settings() if storage == "sqlite3" else None,
            split_bytes=self.max_bag_size,
            split_duration_ns=from_seconds(self.max_bag_duration),
        )


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
    Option(
        "-e", "--regex", help="Only topics and services whose names match this regular expression."
    ),
]
ExcludeRegex = Annotated[
    str,
    Option(
        "-x",
        "--exclude-regex",
        help="Exclude topics and services whose names match this regular expression.",
    ),
]
ExcludeTopics = Annotated[
    list[str] | None,
    Option("--exclude-topics", help="Not these topics.", metavar="TOPIC"),
]
ExcludeTypes = Annotated[
    list[str] | None,
    Option("--exclude-topic-types", help="Exclude topics of these types.", metavar="TYPE"),
]


class TimeRangeOptions(OptionSet):
    """Options for a time range of bags: start as offset or time, end as duration or time."""

    start_offset: Annotated[
        float | None,
        Option(
            "--start-offset", help="Seconds from the start of the bag to the start of the new one."
        ),
    ] = None
    duration: Annotated[
        float | None, Option("--duration", help="Longest duration of the new bag, in seconds.")
    ] = None
    start: Annotated[
        float | None, Option("--from", help="Start of the new bag, in seconds since the epoch.")
    ] = None
    until: Annotated[
        float | None,
        Option("--until", help="End of the new bag, in seconds since the epoch, exclusive."),
    ] = None

    def check(self) -> None:
        """Raise a UsageError for two starts or ends, or a negative offset or duration."""
        if self.start_offset is not None and self.start is not None:
            raise UsageError("--start-offset and --from both set the start; give one of them")
        if self.duration is not None and self.until is not None:
            raise UsageError("--duration and --until both set the end; give one of them")
        if (self.start_offset or 0) < 0 or (self.duration or 0) < 0:
            raise UsageError("--start-offset and --duration cannot be negative")

    @property
    def is_whole(self) -> bool:
        """Whether no option is given, so that all of the bags is selected."""
        options = (self.start_offset, self.duration, self.start, self.until)
        return all(option is None for option in options)

    def log_times(self, bags: "Sequence[Bag]") -> tuple[int, int]:
        """Return the start and exclusive end of the range, in nanoseconds of log time.

        Raises:
            UsageError: The range is empty.
        """
        from teleopctl.interfaces import NANOSECONDS_PER_SECOND, from_seconds

        filled = [bag.metadata for bag in bags if bag.metadata.message_count]
        first_ns = min((metadata.start_ns for metadata in filled), default=0)
        end_ns = max((metadata.end_ns for metadata in filled), default=0) + 1
        length_s = max(0, end_ns - 1 - first_ns) / NANOSECONDS_PER_SECOND
        start_ns = first_ns + from_seconds(self.start_offset or 0)
        if self.start is not None:
            start_ns = max(0, from_seconds(self.start))
        if self.duration is not None:
            end_ns = start_ns + from_seconds(self.duration)
        elif self.until is not None:
            end_ns = from_seconds(self.until)
        if end_ns <= start_ns:
            raise UsageError(
                f"The time range is empty: the bag lasts {length_s:.3f} s",
                hint="teleopctl bag info BAG shows from when to when it goes.",
            )
        return start_ns, end_ns


_SUFFIXES = (".mcap", ".db3", ".bag", ".zstd")


def complete_bags(incomplete: str) -> list[str]:
    """Return completion candidates: bags and folders whose paths begin with a text."""
    from teleopctl.cli.completion.candidates import files

    found = files(incomplete)
    return [name.removesuffix("/") for name in found if name.endswith(("/", *_SUFFIXES))]
