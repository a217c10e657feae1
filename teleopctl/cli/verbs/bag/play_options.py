"""Options that ``bag play`` and ``bag burst`` share, and what they mean."""

from pathlib import Path

from teleopctl.base.typed import TYPE_CHECKING, Annotated
from teleopctl.cli.verb import Option
from teleopctl.errors import UsageError

if TYPE_CHECKING:
    from teleopctl.node import QoSProfile

ReadAhead = Annotated[
    int,
    Option("--read-ahead-queue-size", help="Messages that are read before they are due."),
]
Topics = Annotated[
    list[str] | None,
    Option("--topics", help="Only these topics.", metavar="TOPIC..."),
]
Services = Annotated[
    list[str] | None,
    Option("--services", help="Only the events of these services.", metavar="SERVICE..."),
]
Actions = Annotated[
    list[str] | None,
    Option("--actions", help="Only the topics of these actions.", metavar="ACTION..."),
]
QosOverrides = Annotated[
    str | None,
    Option(
        "--qos-profile-overrides-path",
        help="A YAML file with the quality of service of single topics.",
        metavar="FILE",
    ),
]
Remaps = Annotated[
    list[str] | None,
    Option("-m", "--remap", help="Play topics under other names.", metavar="FROM:=TO..."),
]
StorageConfig = Annotated[
    str | None,
    Option(
        "--storage-config-file",
        help="Accepted for ros2's sake: reading has nothing to configure.",
        metavar="FILE",
    ),
]
StartOffset = Annotated[
    float, Option("--start-offset", help="Begin so many seconds into the bag.", metavar="S")
]
LogLevel = Annotated[
    str,
    Option(
        "--log-level",
        help="Lowest log level that is shown.",
        choices=("debug", "info", "warn", "error", "fatal"),
    ),
]


def overrides_from(file: str | None) -> "dict[str, QoSProfile]":
    """Read the QoS overrides of topics; empty without a file."""
    if file is None:
        return {}
    from teleopctl.bag import read_qos_overrides

    return read_qos_overrides(Path(file))


def check_common(read_ahead: int, start_offset: float, storage_config: str | None) -> None:
    """Raise for invalid values of options.

    Raises:
        UsageError: One of them cannot.
    """
    if read_ahead < 1:
        raise UsageError("read_ahead_queue_size must be at least 1")
    if start_offset < 0:
        raise UsageError(f"--start-offset {start_offset:g}: Value is less than zero.")
    if storage_config is not None and not Path(storage_config).is_file():
        raise UsageError(f"--storage-config-file: there is no file {storage_config}")
