"""rosbag2's storage presets and storage configuration files, for MCAP and for SQLite."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any, TypeVar

import yaml

from teleopctl.bag.mcap_file.chunk_builder import ChunkSettings, Compression, CompressionLevel
from teleopctl.base import ros_yaml
from teleopctl.base.files import read_text
from teleopctl.errors import InvalidFileError, UnsupportedError, UsageError, did_you_mean

MCAP_PRESETS = ("none", "fastwrite", "zstd_fast", "zstd_small")
"""Storage preset profiles of rosbag2's MCAP plug-in."""

# rosbag2's fastwrite has no chunks, and its zstd_fast no checksums. These presets keep chunks,
# checksums and indexes, so that a file is readable after a crash, and damage can be found.
_CHUNKS_OF_PRESETS = {
    "": ChunkSettings(),
    "none": ChunkSettings(Compression.NONE),
    "fastwrite": ChunkSettings(Compression.NONE),
    "zstd_fast": ChunkSettings(compression_level=CompressionLevel.FASTEST),
    "zstd_small": ChunkSettings(chunk_bytes=4 * 2**20, compression_level=CompressionLevel.SLOWEST),
}
_COMPRESSIONS = {"None": Compression.NONE, "Lz4": Compression.LZ4, "Zstd": Compression.ZSTD}
_LEVELS = {level.value: level for level in CompressionLevel}

# Keys that are not supported, since all files have these parts.
_NEVER_LEFT_OUT = {
    "noAttachmentCRC": "checksums of attachments",
    "noAttachmentIndex": "an index of attachments",
    "noChunkIndex": "an index of chunks",
    "noChunking": "chunks, which a crash leaves readable",
    "noMessageIndex": "indexes of messages, by which rosbag2 plays them in order",
    "noMetadataIndex": "an index of metadata",
    "noRepeatedChannels": "all channels in the summary",
    "noRepeatedSchemas": "all schemas in the summary",
    "noStatistics": "statistics",
    "noSummary": "a summary",
    "noSummaryCRC": "a checksum of the summary",
    "noSummaryOffsets": "offsets of the summary",
}
_DATA_CHECKSUM = "enableDataCRC"
_KEYS = (
    *("compression", "compressionLevel", "chunkSize", "forceCompression", "noChunkCRC"),
    *(*_NEVER_LEFT_OUT, _DATA_CHECKSUM),
)

_Choice = TypeVar("_Choice")


def chunk_settings(preset: str = "", config_file: Path | None = None) -> ChunkSettings:
    """Return the MCAP chunk settings of a storage preset and a storage configuration file.

    Args:
        preset: Name of a preset of `MCAP_PRESETS`; empty for zstd.
        config_file: YAML file in the format of rosbag2's MCAP plug-in; takes precedence over the
            preset.

    Raises:
        UsageError: The preset is unknown.
        UnsupportedError: A setting of the file is not supported; names the line.
        InvalidFileError: The file cannot be read, or a key or value is invalid; names the line.
    """
    if preset not in _CHUNKS_OF_PRESETS:
        raise UsageError(
            f"unknown MCAP storage preset profile '{preset}'",
            hint=f"There are {', '.join(MCAP_PRESETS)}.",
        )
    settings = _CHUNKS_OF_PRESETS[preset]
    for key, place, value in read_storage_config(config_file) if config_file else ():
        settings = _changed(settings, key, place, value)
    return settings


# Any, here and below: YAML values.
def _changed(settings: ChunkSettings, key: str, place: str, value: Any) -> ChunkSettings:
    match key:
        case "compression":
            compression = _choice(key, place, value, _COMPRESSIONS)
            return settings._replace(compression=compression)
        case "compressionLevel":
            return settings._replace(compression_level=_choice(key, place, value, _LEVELS))
        case "chunkSize":
            if not isinstance(value, int) or isinstance(value, bool) or value <= 0:
                raise InvalidFileError(f"{place}: '{key}' is a number of bytes, not {value!r}")
            return settings._replace(chunk_bytes=value)
    if key not in _KEYS:
        raise InvalidFileError(f"{place}: '{key}' is not known", hint=did_you_mean(key, _KEYS))
    if not isinstance(value, bool):
        raise InvalidFileError(f"{place}: '{key}' must be true or false, not {value!r}")
    if key == "forceCompression":
        return settings._replace(forces_compression=value)
    if key == "noChunkCRC":
        return settings._replace(chunk_checksums=not value)
    if value and key == _DATA_CHECKSUM:
        raise UnsupportedError(
            f"{place}: '{key}' is not supported",
            hint="Chunks, attachments and the summary have a checksum each.",
        )
    if value:
        raise UnsupportedError(
            f"{place}: '{key}' is not supported: files always have {_NEVER_LEFT_OUT[key]}"
        )
    return settings


def _choice(key: str, place: str, value: Any, choices: dict[str, _Choice]) -> _Choice:
    for name, choice in choices.items():
        if isinstance(value, str) and value.lower() == name.lower():
            return choice
    raise InvalidFileError(
        f"{place}: '{key}' is {', '.join(choices)}, not {value!r}",
        hint=did_you_mean(str(value), choices),
    )


def read_storage_config(file: Path) -> list[tuple[str, str, Any]]:
    """Return (key, ``FILE:LINE``, value) of each setting in a storage configuration file.

    Raises:
        InvalidFileError: The file cannot be read, or is no YAML mapping; names the line.
    """
    with ros_yaml.faults_of(file):
        loader = ros_yaml.RosLoader(read_text(file))
        try:
            root = loader.get_single_node()
            if root is None:
                return []
            if not isinstance(root, yaml.MappingNode):
                raise InvalidFileError(f"{file} is no mapping of settings")
            return [
                (
                    str(key.value),
                    f"{file}:{key.start_mark.line + 1}",
                    loader.construct_object(value, deep=True),
                )
                for key, value in root.value
            ]
        finally:
            loader.dispose()


SQLITE_PRESETS = ("none", "resilient")
"""Storage preset profiles of rosbag2's SQLite plug-in."""

# rosbag2's default keeps the journal in memory: a process that is killed while it writes leaves an
# unreadable database. With a write-ahead log, the database is always consistent.
_LOG = "journal_mode=WAL"
_PRAGMAS_OF_PRESETS = {
    "": (_LOG, "synchronous=OFF"),
    "none": (_LOG, "synchronous=OFF"),
    # Consistent also after a power failure.
    "resilient": (_LOG, "synchronous=NORMAL"),
}
_SECTIONS = ("write", "read")
_FORBIDDEN = "';\""
# Placeholder of a schema's name in SQLite's documentation, and so in rosbag2's example.
_ANY_SCHEMA = "schema."


def database_settings(preset: str = "", config_file: Path | None = None) -> tuple[str, ...]:
    """Return SQLite's ``PRAGMA`` settings of a storage preset and a configuration file.

    Args:
        preset: Name of a preset of `SQLITE_PRESETS`; empty for ``none``.
        config_file: YAML file in the format of rosbag2's SQLite plug-in; takes precedence over the
            preset.

    Raises:
        UsageError: The preset is unknown.
        InvalidFileError: The file cannot be read, or SQLite rejects a setting; names the line.
    """
    if preset not in _PRAGMAS_OF_PRESETS:
        raise UsageError(
            f"unknown SQLite storage preset profile '{preset}'",
            hint=f"There are {', '.join(SQLITE_PRESETS)}.",
        )
    given = _read_pragmas(config_file) if config_file else {}
    ours = {_pragma_name(setting): setting for setting in _PRAGMAS_OF_PRESETS[preset]}
    # The page size must be set before the log is created, so the given settings are first.
    return tuple({**given, **{name: s for name, s in ours.items() if name not in given}}.values())


def _read_pragmas(file: Path) -> dict[str, str]:
    """Return the settings for writing in a configuration file, by name."""
    settings: dict[str, str] = {}
    for section, place, content in read_storage_config(file):
        if section not in _SECTIONS:
            raise InvalidFileError(
                f"{place}: '{section}' is not known", hint=did_you_mean(section, _SECTIONS)
            )
        listed = content.get("pragmas") if isinstance(content, dict) else None
        if not isinstance(listed, list) or not all(isinstance(each, str) for each in listed):
            raise InvalidFileError(f"{place}: '{section}' has a list of texts, pragmas: [...]")
        for setting in filter(None, (each.strip() for each in listed)):
            _check_pragma(setting, place)
            if section == "write":
                setting = setting.removeprefix(_ANY_SCHEMA)
                settings[_pragma_name(setting)] = setting
    return settings


def _check_pragma(setting: str, place: str) -> None:
    if any(sign in setting for sign in _FORBIDDEN):
        raise InvalidFileError(f"{place}: {setting!r} has one of the signs {_FORBIDDEN}")
    setting = setting.removeprefix(_ANY_SCHEMA)
    with closing(sqlite3.connect(":memory:")) as database:
        try:
            database.execute(f"PRAGMA {setting}").fetchall()
            is_known = database.execute(f"PRAGMA {_pragma_name(setting)}").fetchone() is not None
        except sqlite3.Error as error:
            raise InvalidFileError(f"{place}: SQLite refuses {setting!r}: {error}") from error
    if not is_known:
        raise InvalidFileError(f"{place}: SQLite has no pragma '{_pragma_name(setting)}'")


def _pragma_name(setting: str) -> str:
    return setting.partition("=")[0].partition("(")[0].strip()
