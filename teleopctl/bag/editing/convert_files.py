"""YAML files of ``bag convert``: ``--input-options`` and ``-o``, as rosbag2 defines them.

Every key of rosbag2 either has its effect or is reported with its line: an unsupported setting is
an error, and a setting that only concerns recording or speed is a remark.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from teleopctl.bag.editing.copying import OutputBag
from teleopctl.bag.mcap_file.chunk_builder import ChunkSettings, Compression
from teleopctl.bag.metadata import MCAP, SQLITE3
from teleopctl.bag.option_file import OptionItem, read_option_list
from teleopctl.bag.recorder.selection import Selection
from teleopctl.bag.records import NO_TIME_NS, BagTopic
from teleopctl.bag.storage.bag_writer import WriterOptions
from teleopctl.bag.storage.storage_settings import chunk_settings, database_settings
from teleopctl.errors import (
    InvalidFileError,
    NotFoundError,
    TeleopctlError,
    UnsupportedError,
    UsageError,
    did_you_mean,
)
from teleopctl.interfaces import NANOSECONDS_PER_SECOND

_INPUT_ROOT = "input_bags"
_INPUT_EXPECTED = (
    f"The file has one key, {_INPUT_ROOT}, with a list of bags:"
    f" {_INPUT_ROOT}: [{{uri: …, start_time_ns: …}}]"
)

_INPUT_TEXTS = {"uri", "storage_id"}
_INPUT_TIMES = {"start_time_ns", "end_time_ns"}
_WITHOUT_EFFECT_ON_INPUT = {
    *("max_bagfile_size", "max_bagfile_duration", "max_bag_files", "snapshot_mode"),
    *("max_cache_size", "max_cache_duration", "custom_data"),
    *("storage_preset_profile", "storage_config_uri"),
}


@dataclass(frozen=True)
class InputBag:
    """Bag that ``bag convert`` reads: path, storage format and time span.

    Attributes:
        path: Folder or file of the bag.
        storage: Storage format of the files, ``mcap`` or ``sqlite3``; None to detect it.
        start_ns: Earliest log time to read, in nanoseconds since the epoch.
        end_ns: Log time before which reading ends, in nanoseconds since the epoch.
    """

    path: Path
    storage: str | None = None
    start_ns: int = 0
    end_ns: int = NO_TIME_NS


def read_input_options(path: Path) -> tuple[list[InputBag], list[str]]:
    """Return the `InputBag` list of an ``--input-options`` file of ``bag convert``, and remarks.

    Returns:
        The inputs, and remarks on keys without effect, each with its file and line.

    Raises:
        InvalidFileError: The file cannot be read, or a value is invalid.
        NotFoundError: A bag does not exist.
        UnsupportedError: The storage format of a bag is unknown.
    """
    remarks: list[str] = []
    inputs = [
        _parse_input(item, remarks) for item in read_option_list(path, _INPUT_ROOT, _INPUT_EXPECTED)
    ]
    return inputs, remarks


def _parse_input(item: OptionItem, remarks: list[str]) -> InputBag:
    if item.pairs is None:
        raise InvalidFileError(f"{item.place}: expected a mapping", hint=_INPUT_EXPECTED)
    texts: dict[str, str] = {}
    times: dict[str, int] = {}
    for key, line, value in item.pairs:
        place = f"{item.path}:{line}"
        if key in texts or key in times:
            raise InvalidFileError(f"{place}: '{key}' is given twice")
        if key in _INPUT_TEXTS:
            if not isinstance(value, str):
                raise InvalidFileError(f"{place}: '{key}' must be a text, not {value!r}")
            texts[key] = value
        elif key in _INPUT_TIMES:
            if not isinstance(value, int) or isinstance(value, bool):
                raise InvalidFileError(
                    f"{place}: '{key}' must be a whole number of nanoseconds, not {value!r}"
                )
            times[key] = value
        elif key in _WITHOUT_EFFECT_ON_INPUT:
            remarks.append(f"{place}: '{key}' has no effect on a bag that is read")
        else:
            known = {*_INPUT_TEXTS, *_INPUT_TIMES, *_WITHOUT_EFFECT_ON_INPUT}
            raise InvalidFileError(
                f"{place}: '{key}' is not known",
                hint=did_you_mean(key, known)
                or "Topics of the outputs are chosen in the file of --output-options.",
            )
    folder, storage = texts.get("uri", ""), texts.get("storage_id", "")
    if not folder:
        raise InvalidFileError(f"{item.place}: an input has no 'uri'")
    if storage not in ("", MCAP, SQLITE3):
        raise UnsupportedError(
            f"{item.place}: storage_id cannot be {storage!r}: it is {MCAP} or {SQLITE3}"
        )
    if not Path(folder).exists():
        raise NotFoundError(f"{item.place}: Bag path '{folder}' does not exist!")
    # As in rosbag2, times that are not positive are no limit, and the end time is included.
    start_ns, end_ns = times.get("start_time_ns", -1), times.get("end_time_ns", -1)
    return InputBag(
        Path(folder), storage or None, max(0, start_ns), end_ns + 1 if end_ns > 0 else NO_TIME_NS
    )


_OUTPUT_ROOT = "output_bags"
_OUTPUT_EXPECTED = (
    f"The file has one key, {_OUTPUT_ROOT}, with a list of bags:"
    f" {_OUTPUT_ROOT}: [{{uri: …, all: true}}]"
)

# Any: YAML values, which `_Entry` checks.
_Values = dict[str, Any]

_CHOICES: dict[str, type] = {
    "all_topics": bool,
    "all_services": bool,
    "all_actions": bool,
    "topics": list,
    "topic_types": list,
    "services": list,
    "actions": list,
    "regex": str,
    "exclude_regex": str,
    "exclude_topics": list,
    "exclude_topic_types": list,
    "exclude_services": list,
    "exclude_actions": list,
    "include_hidden_topics": bool,
}
_FORMS: dict[str, type] = {
    "uri": str,
    "storage_id": str,
    "max_bagfile_size": int,
    "max_bagfile_duration": int,
    "storage_preset_profile": str,
    "storage_config_uri": str,
    "start_time_ns": int,
    "end_time_ns": int,
    "custom_data": dict,
    "compression_mode": str,
    "compression_format": str,
    "all": bool,
    "exclude": str,
}
# Keys with the only values that conversion supports.
_EMPTY_ONLY: dict[str, tuple[Any, ...]] = {
    "snapshot_mode": (False,),
    "topic_qos_profile_overrides": ({}, "", None),
    "rmw_serialization_format": ("", "cdr"),
}
_OF_RECORDING = {
    *("is_discovery_disabled", "topic_polling_interval", "node_prefix"),
    *("include_unpublished_topics", "ignore_leaf_topics", "start_paused", "use_sim_time"),
    *("disable_keyboard_controls", "max_cache_size", "compression_queue_size"),
    *("compression_threads", "compression_threads_priority"),
}


def read_output_options(path: Path) -> tuple[list[OutputBag], list[str]]:
    """Return the `OutputBag` list of an ``-o`` file of ``bag convert``, and remarks.

    Returns:
        The outputs, and remarks on keys without effect, each with its file and line.

    Raises:
        InvalidFileError: The file cannot be read, or a value is invalid.
        UnsupportedError: A key or value is not possible in a conversion.
    """
    entries = [_Entry(item) for item in read_option_list(path, _OUTPUT_ROOT, _OUTPUT_EXPECTED)]
    return [entry.output() for entry in entries], [r for entry in entries for r in entry.remarks]


class _Entry:
    """Entry of the list of outputs: its keys, checked, with their lines."""

    def __init__(self, item: OptionItem) -> None:
        self._path = item.path
        self._line = item.line
        self._lines: dict[str, int] = {}
        self._values: _Values = {}
        self.remarks: list[str] = []
        if item.pairs is None:
            raise InvalidFileError(f"{item.place}: expected a mapping", hint=_OUTPUT_EXPECTED)
        for key, line, value in item.pairs:
            if key in self._lines:
                raise InvalidFileError(f"{item.path}:{line}: '{key}' is given twice")
            self._lines[key] = line
            self._take(key, value)

    def output(self) -> OutputBag:
        """Return the `OutputBag` that the entry describes; raise if a value is invalid."""
        values = self._values
        if not values.get("uri"):
            raise InvalidFileError(f"{self._path}:{self._line}: an output has no 'uri'")
        if values.get("storage_id", "") not in ("", MCAP, SQLITE3):
            self._refuse("storage_id", f"it is {MCAP} or {SQLITE3}")
        selection = self._selection()
        end_ns = values.get("end_time_ns", -1)
        files = self._file_options()
        try:
            options = replace(
                files,
                split_bytes=values.get("max_bagfile_size", 0),
                split_duration_ns=values.get("max_bagfile_duration", 0) * NANOSECONDS_PER_SECOND,
                custom_data=self._custom_data(),
            )
        except UsageError as error:
            raise error.at(f"{self._path}:{self._line}") from error
        return OutputBag(
            Path(values["uri"]),
            chooses=lambda topic: _chooses(selection, topic),
            start_ns=max(0, values.get("start_time_ns", -1)),
            # rosbag2 includes a message at the end time.
            end_ns=end_ns + 1 if end_ns >= 0 else NO_TIME_NS,
            options=options,
        )

    def _take(self, key: str, value: object) -> None:
        place = f"{self._path}:{self._lines[key]}"
        kind = _CHOICES.get(key) or _FORMS.get(key)
        if kind is not None:
            is_bool_for_int = kind is int and isinstance(value, bool)
            if not isinstance(value, kind) or is_bool_for_int:
                raise InvalidFileError(f"{place}: '{key}' must be {_WORDS[kind]}, not {value!r}")
            if isinstance(value, list) and not all(isinstance(name, str) for name in value):
                raise InvalidFileError(f"{place}: '{key}' must be a list of names")
            if isinstance(value, int) and value < 0 and key.startswith("max_"):
                raise InvalidFileError(f"{place}: '{key}' cannot be negative")
            self._values[key] = value
        elif key in _EMPTY_ONLY:
            if value not in _EMPTY_ONLY[key]:
                raise UnsupportedError(f"{place}: '{key}' is not possible when converting")
        elif key in _OF_RECORDING:
            self.remarks.append(f"{place}: '{key}' has no effect when converting")
        else:
            known = {*_CHOICES, *_FORMS, *_EMPTY_ONLY, *_OF_RECORDING}
            raise InvalidFileError(f"{place}: '{key}' is not known", hint=did_you_mean(key, known))

    def _selection(self) -> Selection:
        values = {key: value for key, value in self._values.items() if key in _CHOICES}
        if self._values.get("all"):
            values |= {"all_topics": True, "all_services": True, "all_actions": True}
        values.setdefault("exclude_regex", self._values.get("exclude", ""))
        place = f"{self._path}:{self._line}"
        try:
            selection = Selection(**values)
        except UsageError as error:
            raise error.at(place) from error
        if selection.is_empty:
            self.remarks.append(f"{place}: nothing is chosen (all: true chooses everything)")
        return selection

    def _file_options(self) -> WriterOptions:
        """Return how the files of the bag are written: storage format and its settings."""
        values = self._values
        preset, config = (values.get(f"storage_{k}") for k in ("preset_profile", "config_uri"))
        file = Path(config) if config else None
        is_database = values.get("storage_id") == SQLITE3
        try:
            if is_database:
                options = WriterOptions(database_settings=database_settings(preset or "", file))
            else:
                chunks = chunk_settings(preset or "", file)
        except TeleopctlError as error:
            key = "storage_config_uri" if config else "storage_preset_profile"
            raise error.at(f"{self._path}:{self._lines[key]}") from error
        if not is_database:
            return WriterOptions(**self._compressed(chunks)._asdict())
        if (values.get("compression_mode") or "none").lower() != "none":
            self._refuse("compression_mode", "databases are written as they are")
        return options

    def _compressed(self, settings: ChunkSettings) -> ChunkSettings:
        """Return chunk settings with the compression keys of the entry applied."""
        values = self._values
        mode = (values.get("compression_mode") or "").lower()
        if mode not in ("", "none", "file", "message"):
            self._refuse("compression_mode", "expected none, file or message")
        form = (values.get("compression_format") or "").lower()
        if form not in ("", "zstd", "lz4"):
            self._refuse("compression_format", "expected zstd or lz4")
        if mode in ("file", "message"):
            place = f"{self._path}:{self._lines['compression_mode']}"
            self.remarks.append(f"{place}: MCAP files are compressed by chunks")
        if form and mode != "none":
            return settings._replace(compression=Compression(form))
        has_settings = values.get("storage_preset_profile") or values.get("storage_config_uri")
        if mode == "none" and not has_settings:
            return settings._replace(compression=Compression.NONE)
        return settings

    def _custom_data(self) -> Mapping[str, str]:
        return {str(key): str(value) for key, value in self._values.get("custom_data", {}).items()}

    def _refuse(self, key: str, why: str) -> None:
        place = f"{self._path}:{self._lines[key]}"
        raise UnsupportedError(f"{place}: {key} cannot be {self._values[key]!r}: {why}")


_WORDS = {
    bool: "true or false",
    int: "a whole number",
    str: "a text",
    list: "a list of names",
    dict: "a mapping",
}


def _chooses(selection: Selection, topic: BagTopic) -> bool:
    name, type_name = topic.name, topic.type_name
    return selection.chooses(name, type_name) and selection.passes_hidden_rule(name, type_name)
