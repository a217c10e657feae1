"""``convert --input-options FILE.yaml``: the bags that rosbag2's file names, and spans of them.

Its entries are rosbag2's storage options; those that only concern writing are told, not done.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from teleopctl.bag.metadata import MCAP, SQLITE3
from teleopctl.bag.option_file import Item, read_list
from teleopctl.bag.records import NO_TIME_NS
from teleopctl.errors import InvalidFileError, NotFoundError, UnsupportedError, did_you_mean

_ROOT = "input_bags"
_EXPECTED = (
    f"The file has one key, {_ROOT}, with a list of bags: {_ROOT}: [{{uri: …, start_time_ns: …}}]"
)

_TEXTS = {"uri", "storage_id"}
_TIMES = {"start_time_ns", "end_time_ns"}
_OF_WRITING = {
    *("max_bagfile_size", "max_bagfile_duration", "max_bag_files", "snapshot_mode"),
    *("max_cache_size", "max_cache_duration", "custom_data"),
    *("storage_preset_profile", "storage_config_uri"),
}


@dataclass(frozen=True)
class InputBag:
    """An input bag with its storage.

    Attributes:
        path: Its folder or file.
        storage: The form of its files, ``mcap`` or ``sqlite3``; None where they tell themselves.
        start_ns: Log time of its first message at the earliest, in nanoseconds since the epoch.
        end_ns: Log time that its last message has to be before.
    """

    path: Path
    storage: str | None = None
    start_ns: int = 0
    end_ns: int = NO_TIME_NS


def read_inputs(path: Path) -> tuple[list[InputBag], list[str]]:
    """Read the inputs' YAML file of ``bag convert``.

    Returns:
        The inputs, and remarks on what has no effect, each with its place.

    Raises:
        InvalidFileError: It cannot be read, or a value is not what it should be.
        NotFoundError: A bag is not there.
        UnsupportedError: A bag is of a form that there is not.
    """
    remarks: list[str] = []
    inputs = [_input(item, remarks) for item in read_list(path, _ROOT, _EXPECTED)]
    return inputs, remarks


def _input(item: Item, remarks: list[str]) -> InputBag:
    if item.pairs is None:
        raise InvalidFileError(f"{item.place}: here has to be a mapping", hint=_EXPECTED)
    texts: dict[str, str] = {}
    times: dict[str, int] = {}
    for key, line, value in item.pairs:
        place = f"{item.path}:{line}"
        if key in texts or key in times:
            raise InvalidFileError(f"{place}: '{key}' stands here twice")
        if key in _TEXTS:
            if not isinstance(value, str):
                raise InvalidFileError(f"{place}: '{key}' has to be a text, not {value!r}")
            texts[key] = value
        elif key in _TIMES:
            if not isinstance(value, int) or isinstance(value, bool):
                raise InvalidFileError(
                    f"{place}: '{key}' has to be a whole number of nanoseconds, not {value!r}"
                )
            times[key] = value
        elif key in _OF_WRITING:
            remarks.append(f"{place}: '{key}' has no effect on a bag that is read")
        else:
            known = {*_TEXTS, *_TIMES, *_OF_WRITING}
            raise InvalidFileError(
                f"{place}: '{key}' is not known",
                hint=did_you_mean(key, known)
                or "What is taken of the bags is said in the file of --output-options.",
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
    # As for rosbag2, times that are not positive say nothing, and what came at the end is in it.
    start_ns, end_ns = times.get("start_time_ns", -1), times.get("end_time_ns", -1)
    return InputBag(
        Path(folder), storage or None, max(0, start_ns), end_ns + 1 if end_ns > 0 else NO_TIME_NS
    )
