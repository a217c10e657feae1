"""``teleopctl bag info`` and ``list``."""

from collections.abc import Iterable
from pathlib import Path

from teleopctl.base.typed import TYPE_CHECKING, Annotated
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.bag.options import BagPath, Storage

if TYPE_CHECKING:
    from teleopctl.bag import Bag, BagMessage, BagMetadata, BagTopic, ServiceCounter
    from teleopctl.cli.console import Json


def bag_info(
    bag_path: BagPath,
    names_only: Annotated[
        bool, Option("-t", "--topic-name", help="Print only the names of the topics.")
    ] = False,
    verbose: Annotated[
        bool,
        Option(
            "-v",
            "--verbose",
            help="Read the whole bag, and show the size of each topic and the events of services.",
        ),
    ] = False,
    sort: Annotated[
        str,
        Option("--sort", help="Sort order of topics.", choices=("name", "type", "count")),
    ] = "name",
    storage: Storage = None,
    as_json: AsJson = False,
) -> None:
    """Show the contents of a bag: files, times, topics and services."""
    from teleopctl.bag import open_bag

    if names_only and verbose:
        console.warn(
            "You have set both the '-t' and '-v' parameters. The '-t' parameter will be ignored."
        )
    with open_bag(Path(bag_path), storage) as bag:
        for remark in bag.remarks:
            console.warn(remark)
        summary = BagSummary(bag.metadata, _size(bag), sort)
        if verbose:
            summary.count_all(bag.messages())
        if as_json:
            console.out_json(summary_document(summary))
        elif names_only and not verbose:
            console.out_lines(topic.name for topic, _ in summary.topics)
        else:
            console.out_text(summary_text(summary))


def _size(bag: "Bag") -> int:
    if bag.path.is_file():
        return bag.path.stat().st_size
    return sum(file.stat().st_size for file in bag.path.iterdir() if file.is_file())


# Plug-ins by kind, with the descriptions that ``-v`` prints.
_PLUGINS = {
    "storage": {
        "mcap": "MCAP files, read and written.",
        "sqlite3": "SQLite databases, also of older ROS 2 distributions, read and written.",
        "rosbag_v2": "Bags of ROS 1, read.",
    },
    "converter": {"cdr": "Serialization of messages on the wire, stored unchanged."},
    "compressor": {
        "zstd": "Chunks of MCAP files, small.",
        "lz4": "Chunks of MCAP files, fast.",
    },
    "decompressor": {
        "zstd": "Chunks of MCAP files; files and messages of rosbag2's own compression.",
        "lz4": "Chunks of MCAP files.",
    },
}


def list_plugins(
    plugin_type: Annotated[
        str, Argument(help="Which ones.", metavar="KIND", choices=tuple(_PLUGINS))
    ],
    verbose: Annotated[
        bool, Option("-v", "--verbose", help="Print what each of them is for.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Print bag formats of one kind: storage, converter, compressor or decompressor."""
    if as_json:
        console.out_json(
            [{"name": name, "description": text} for name, text in _PLUGINS[plugin_type].items()]
        )
        return
    if verbose:
        console.out(f"available {plugin_type} plugins are:")
    for name, description in _PLUGINS[plugin_type].items():
        console.out(f"name: {name}" if verbose else name)
        if verbose:
            console.out_text(f"\t{description}")


_UNITS = ("B", "KiB", "MiB", "GiB", "TiB")
_UNIT = 1024
# Indents of the lines of further topics and services.
_TOPIC_INDENT = " " * 19
_SERVICE_INDENT = " " * 21


class BagSummary:
    """Topics, services, counts and sizes of a bag that ``bag info`` prints.

    Args:
        metadata: Metadata of the bag.
        size: Size of all files of the bag, in bytes.
        sort: Sort order of topics: ``name``, ``type`` or ``count``.

    Attributes:
        topics: Topics without service events, with their message counts, sorted.
        services: Topics of service events, with their message counts, sorted.
        sizes: Bytes of the messages by topic, after `count_all`.
        counter: Numbers of requests and responses, after `count_all`; None before.
    """

    def __init__(self, metadata: "BagMetadata", size: int, sort: str = "name") -> None:
        from collections import Counter

        from teleopctl.bag import is_service_event

        self.metadata = metadata
        self.size = size
        self.sizes: Counter[str] = Counter()
        self.counter: ServiceCounter | None = None
        keys = {"type": lambda item: item[0].type_name, "count": lambda item: item[1]}
        topics = sorted(metadata.topics, key=lambda item: item[0].name)
        if sort in keys:
            topics.sort(key=keys[sort])
        self.topics: list[tuple[BagTopic, int]] = []
        self.services: list[tuple[BagTopic, int]] = []
        for topic, count in topics:
            is_event = is_service_event(topic.name, topic.type_name)
            (self.services if is_event else self.topics).append((topic, count))

    def count_all(self, messages: "Iterable[BagMessage]") -> None:
        """Store bytes per topic, and requests and responses per service, of a bag's messages."""
        from teleopctl.bag import ServiceCounter

        self.counter = ServiceCounter(topic.name for topic, _ in self.services)
        for message in messages:
            self.sizes[message.topic] += len(message.data)
            self.counter.add(message)


def summary_text(summary: BagSummary) -> str:
    """Return a bag's summary as the text that ``ros2 bag info`` prints."""
    metadata = summary.metadata
    has_messages = bool(metadata.message_count)
    start_ns = metadata.start_ns if has_messages else 0
    end_ns = metadata.end_ns if has_messages else 0
    events = sum(count for _, count in summary.services)
    files = [file.path for file in metadata.files]
    lines = [
        "",
        "Files:             " + f"\n{_TOPIC_INDENT}".join(files),
        f"Bag size:          {format_size(summary.size)}",
        f"Storage id:        {metadata.storage}",
        f"ROS Distro:        {metadata.distribution or 'unknown'}",
        f"Duration:          {_seconds(end_ns - start_ns)}s",
        f"Start:             {_point(start_ns)}",
        f"End:               {_point(end_ns)}",
        f"Messages:          {metadata.message_count - events}",
        "Topic information: "
        + f"\n{_TOPIC_INDENT}".join(_topic_line(summary, *item) for item in summary.topics),
        f"Service:           {len(summary.services)}",
        "Service information: "
        + f"\n{_SERVICE_INDENT}".join(_service_line(summary, *item) for item in summary.services),
    ]
    if summary.services:
        lines.append("")
    return "\n".join(lines)


def summary_document(summary: BagSummary) -> "Json":
    """Return a bag's summary as a JSON object."""
    metadata = summary.metadata
    has_messages = bool(metadata.message_count)
    return {
        "files": [
            {
                "path": file.path,
                "start_ns": file.start_ns if file.message_count else None,
                "duration_ns": file.duration_ns,
                "messages": file.message_count,
            }
            for file in metadata.files
        ],
        "size": summary.size,
        "storage": metadata.storage,
        "ros_distro": metadata.distribution,
        "start_ns": metadata.start_ns if has_messages else None,
        "end_ns": metadata.end_ns if has_messages else None,
        "duration_ns": metadata.duration_ns if has_messages else 0,
        "messages": metadata.message_count,
        "topics": [
            {
                "name": topic.name,
                "type": topic.type_name,
                "type_hash": topic.type_hash,
                "messages": count,
                "serialization_format": topic.serialization_format,
                **_size_entry(summary, topic),
            }
            for topic, count in summary.topics
        ],
        "services": [_service_entry(summary, topic, count) for topic, count in summary.services],
        "custom_data": dict(metadata.custom_data),
    }


def format_size(size: float) -> str:
    """Return a number of bytes as text in a suitable unit, such as ``1.5 MiB``."""
    unit = 0
    while size >= _UNIT and unit < len(_UNITS) - 1:
        size /= _UNIT
        unit += 1
    return f"{size:.{1 if unit else 0}f} {_UNITS[unit]}"


def _topic_line(summary: BagSummary, topic: "BagTopic", count: int) -> str:
    return " | ".join(
        [
            f"Topic: {topic.name}",
            f"Type: {topic.type_name}",
            f"Count: {count}",
            *_size_part(summary, topic),
            f"Serialization Format: {topic.serialization_format}",
        ]
    )


def _service_line(summary: BagSummary, topic: "BagTopic", count: int) -> str:
    from teleopctl.bag import service_of

    name, type_name = service_of(topic.name, topic.type_name)
    counts = [f"Event Count: {count}"]
    if summary.counter is not None:
        requests, responses = summary.counter.counts(topic.name)
        counts = [f"Request Count: {requests}", f"Response Count: {responses}"]
    return " | ".join(
        [
            f"Service: {name}",
            f"Type: {type_name}",
            *counts,
            *_size_part(summary, topic),
            f"Serialization Format: {topic.serialization_format}",
        ]
    )


def _size_part(summary: BagSummary, topic: "BagTopic") -> list[str]:
    if summary.counter is None:
        return []
    return [f"Size Contribution: {format_size(summary.sizes[topic.name])}"]


def _size_entry(summary: BagSummary, topic: "BagTopic") -> "dict[str, Json]":
    return {} if summary.counter is None else {"size": summary.sizes[topic.name]}


def _service_entry(summary: BagSummary, topic: "BagTopic", count: int) -> "dict[str, Json]":
    from teleopctl.bag import service_of

    name, type_name = service_of(topic.name, topic.type_name)
    entry: dict[str, Json] = {
        "name": name,
        "type": type_name,
        "events": count,
        "serialization_format": topic.serialization_format,
        **_size_entry(summary, topic),
    }
    if summary.counter is not None:
        entry |= summary.counter.counts(topic.name)._asdict()
    return entry


def _seconds(time_ns: int) -> str:
    from teleopctl.interfaces import NANOSECONDS_PER_SECOND

    seconds, rest_ns = divmod(time_ns, NANOSECONDS_PER_SECOND)
    return f"{seconds}.{rest_ns:09d}"


def _point(time_ns: int) -> str:
    import time

    from teleopctl.interfaces import NANOSECONDS_PER_SECOND

    seconds, rest_ns = divmod(time_ns, NANOSECONDS_PER_SECOND)
    local = time.localtime(seconds)
    day = f"{time.strftime('%b', local)} {local.tm_mday:>2} {local.tm_year}"
    return f"{day} {time.strftime('%H:%M:%S', local)}.{rest_ns:09d} ({_seconds(time_ns)})"
