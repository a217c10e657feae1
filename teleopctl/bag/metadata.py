"""``metadata.yaml`` of bags in rosbag2's format.

| version | added content | since |
|---|---|---|
| 1 to 3 | the format itself; compression | Dashing |
| 4 | quality of service of the topics | Foxy |
| 5 | times and counts of each file | Galactic |
| 6 | custom data | Iron |
| 7 | hashes of the types | Iron |
| 8 | ROS distribution of the recorder | Iron |
| 9 | quality of service as a list with names | Jazzy |

All versions are read. Version 8 is written, which every rosbag2 since Iron reads.
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import yaml

from teleopctl.bag.qos_profiles import format_offered_profiles, parse_offered_profiles
from teleopctl.bag.records import CDR, BagTopic, full_type_name
from teleopctl.base import ros_yaml
from teleopctl.base.files import read_text
from teleopctl.errors import InvalidFileError, SystemFailureError

METADATA_FILE = "metadata.yaml"
VERSION = 8

MCAP = "mcap"
SQLITE3 = "sqlite3"

_NEWEST_VERSION = 9
_ROOT = "rosbag2_bagfile_information"
# Start time that rosbag2 writes for a bag without messages.
_NO_START_NS = 2**63 - 1

_Yaml = dict[str, Any]


# The dumper of libyaml takes a third of the time, and a split bag writes the file again for each
# part. PyYAML lacks the class if it was built without libyaml.
_SAFE_DUMPER: Any = getattr(yaml, "CSafeDumper", yaml.SafeDumper)


class _Dumper(_SAFE_DUMPER):  # type: ignore[misc]
    """Dumper that also quotes texts such as 1e5, numbers for ROS 2's reader but not in YAML 1.1."""


for _first, _resolvers in ros_yaml.RosLoader.yaml_implicit_resolvers.items():
    for _tag, _pattern in _resolvers:
        _Dumper.add_implicit_resolver(_tag, _pattern, [_first])


@dataclass(frozen=True)
class BagFile:
    """Entry of a file in ``metadata.yaml``: path, times and message count.

    Attributes:
        path: Path relative to the bag's folder.
        start_ns: Log time of the file's first message, in nanoseconds since the epoch.
        duration_ns: Time from the file's first message to its last, in nanoseconds.
        message_count: Number of messages in the file.
    """

    path: str
    start_ns: int = _NO_START_NS
    duration_ns: int = 0
    message_count: int = 0

    @property
    def end_ns(self) -> int:
        """Log time of the file's last message, in nanoseconds since the epoch."""
        return self.start_ns + self.duration_ns


@dataclass(frozen=True)
class BagMetadata:
    """Metadata of a bag (``metadata.yaml``): files, topics, message counts, custom data.

    Attributes:
        files: Files of the bag, in the order of their times.
        topics: Topics with their number of messages, by name.
        storage: Storage format: ``mcap`` or ``sqlite3``.
        compression_format: Format of rosbag2's compression, such as ``zstd``; empty for none.
        compression_mode: ``file``, ``message`` or empty.
        custom_data: Keys and values that the user added when recording.
        distribution: ROS 2 distribution that recorded the bag; empty if unknown.
        version: Version of the metadata format.
    """

    files: tuple[BagFile, ...] = ()
    topics: tuple[tuple[BagTopic, int], ...] = ()
    storage: str = MCAP
    compression_format: str = ""
    compression_mode: str = ""
    custom_data: Mapping[str, str] = field(default_factory=dict)
    distribution: str = ""
    version: int = VERSION

    @property
    def message_count(self) -> int:
        """Number of messages in all files."""
        return sum(file.message_count for file in self.files)

    @property
    def start_ns(self) -> int:
        """Log time of the first message, in ns since the epoch; 2^63 - 1 without messages."""
        return min((f.start_ns for f in self.files if f.message_count), default=_NO_START_NS)

    @property
    def end_ns(self) -> int:
        """Log time of the last message, in ns since the epoch; 2^63 - 1 without messages."""
        return max((f.end_ns for f in self.files if f.message_count), default=_NO_START_NS)

    @property
    def duration_ns(self) -> int:
        """Time from the first message to the last, in nanoseconds; 0 without messages."""
        return self.end_ns - self.start_ns


def format_metadata(metadata: BagMetadata, *, with_root: bool = True) -> str:
    """Return the text of a bag's ``metadata.yaml``, in version 8.

    Args:
        metadata: Metadata to write.
        with_root: Whether to add the root key ``rosbag2_bagfile_information``.
    """
    content: _Yaml = {
        "version": VERSION,
        "storage_identifier": metadata.storage,
        "duration": {"nanoseconds": metadata.duration_ns},
        "starting_time": {"nanoseconds_since_epoch": metadata.start_ns},
        "message_count": metadata.message_count,
        "topics_with_message_count": [
            {"topic_metadata": _format_topic(topic), "message_count": count}
            for topic, count in metadata.topics
        ],
        "compression_format": metadata.compression_format,
        "compression_mode": metadata.compression_mode,
        "relative_file_paths": [file.path for file in metadata.files],
        "files": [
            {
                "path": file.path,
                "starting_time": {"nanoseconds_since_epoch": file.start_ns},
                "duration": {"nanoseconds": file.duration_ns},
                "message_count": file.message_count,
            }
            for file in metadata.files
        ],
        "custom_data": dict(metadata.custom_data) or None,
        "ros_distro": metadata.distribution,
    }
    document = {_ROOT: content} if with_root else content
    text: str = yaml.dump(document, Dumper=_Dumper, sort_keys=False)
    return text


def _format_topic(topic: BagTopic) -> _Yaml:
    return {
        "name": topic.name,
        "type": topic.type_name,
        "serialization_format": topic.serialization_format,
        "offered_qos_profiles": format_offered_profiles(topic.qos),
        "type_description_hash": topic.type_hash,
    }


def write_metadata(path: Path, metadata: BagMetadata) -> None:
    """Write bag metadata to a ``metadata.yaml`` path, replacing the file atomically.

    Raises:
        SystemFailureError: The file cannot be written.
    """
    part = path.with_name(f"{path.name}.part")
    try:
        part.write_text(format_metadata(metadata), encoding="utf-8")
        part.replace(path)
    except OSError as error:
        with contextlib.suppress(OSError):
            part.unlink(missing_ok=True)
        raise SystemFailureError(f"Cannot write {path}: {error.strerror}") from error


def read_metadata(folder: Path) -> BagMetadata:
    """Read and return the metadata in the ``metadata.yaml`` of a bag's folder.

    Raises:
        InvalidFileError: The file cannot be read, or is invalid; the message names the file.
    """
    path = folder / METADATA_FILE
    try:
        return parse_metadata(read_text(path))
    except InvalidFileError as error:
        if str(path) in error.message:
            raise
        raise InvalidFileError(
            f"{path}: {error.message}",
            hint=f"teleopctl bag reindex {folder} rebuilds it from the files.",
        ) from error


def parse_metadata(text: str, *, with_root: bool = True) -> BagMetadata:
    """Parse and return the metadata in the text of a ``metadata.yaml`` of any version.

    Args:
        text: Content of the file.
        with_root: Whether the text has the root key ``rosbag2_bagfile_information``.

    Raises:
        InvalidFileError: The text is not valid metadata; the message gives the reason, but no file.
    """
    try:
        document = ros_yaml.load(text)
    except yaml.YAMLError as error:
        raise InvalidFileError(f"it is not YAML: {error}") from error
    content = document
    if with_root:
        content = document.get(_ROOT) if isinstance(document, dict) else None
    if not isinstance(content, dict):
        raise InvalidFileError(f"it has no {_ROOT}")
    version = content.get("version")
    if not isinstance(version, int) or not 1 <= version <= _NEWEST_VERSION:
        raise InvalidFileError(
            f"version {version} of the metadata is not known; {_NEWEST_VERSION} is the newest"
        )
    try:
        return _parse(content, version)
    except KeyError as error:
        raise InvalidFileError(f"the key {error} is missing") from error
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        raise InvalidFileError(f"a value is of the wrong kind: {error}") from error


def _parse(content: _Yaml, version: int) -> BagMetadata:
    # Before version 4 the paths began with the bag's folder.
    paths = [Path(path).name for path in content["relative_file_paths"]]
    whole = _parse_file({**content, "path": ""})
    listed = {Path(item["path"]).name: _parse_file(item) for item in content.get("files") or ()}
    if set(paths) == set(listed):
        files = tuple(listed[path] for path in paths)
    elif len(paths) == 1:
        files = (replace(whole, path=paths[0]),)
    else:
        # Without an entry for each file, each gets the whole time span, the first one the count.
        files = tuple(
            replace(whole, path=path, message_count=0 if number else whole.message_count)
            for number, path in enumerate(paths)
        )
    return BagMetadata(
        files=files,
        topics=tuple(
            (_parse_topic(item["topic_metadata"]), int(item["message_count"]))
            for item in content["topics_with_message_count"] or ()
        ),
        storage=str(content["storage_identifier"]),
        compression_format=str(content.get("compression_format") or ""),
        compression_mode=_mode(content.get("compression_mode")),
        custom_data={str(k): str(v) for k, v in (content.get("custom_data") or {}).items()},
        distribution=str(content.get("ros_distro") or ""),
        version=version,
    )


def _parse_file(item: _Yaml) -> BagFile:
    return BagFile(
        Path(item["path"]).name,
        int(item["starting_time"]["nanoseconds_since_epoch"]),
        int(item["duration"]["nanoseconds"]),
        int(item["message_count"]),
    )


def _parse_topic(item: _Yaml) -> BagTopic:
    return BagTopic(
        str(item["name"]),
        full_type_name(str(item["type"])),
        str(item.get("type_description_hash") or ""),
        qos=parse_offered_profiles(item.get("offered_qos_profiles")),
        serialization_format=str(item.get("serialization_format") or CDR),
    )


def _mode(value: object) -> str:
    mode = str(value or "").lower()
    return "" if mode == "none" else mode
