"""``record --static-topics-path FILE.yaml``: topics with their types, recorded from the start."""

from __future__ import annotations

from pathlib import Path

from teleopctl.bag.option_file import read_list
from teleopctl.bag.records import whole_type_name
from teleopctl.errors import InvalidFileError

_ROOT = "static_topics_and_types_list"
_EXPECTED = f"The file is a list of pairs: {_ROOT}: [[/chatter, std_msgs/msg/String], …]"


def read_static_topics(path: Path) -> dict[str, str]:
    """Read rosbag2's static topics file: topics and their types.

    Returns:
        The type of each topic.

    Raises:
        InvalidFileError: It cannot be read, or says something else; with its line.
    """
    topics: dict[str, str] = {}
    for item in read_list(path, _ROOT, _EXPECTED):
        pair = item.value
        is_pair = isinstance(pair, list) and len(pair) == 2
        if not is_pair or not all(isinstance(word, str) and word for word in pair):
            raise InvalidFileError(
                f"{item.place}: here have to be a topic and its type, not {pair!r}",
                hint=_EXPECTED,
            )
        name, type_name = pair
        if name in topics:
            raise InvalidFileError(f"{item.place}: '{name}' stands here twice")
        topics[name] = whole_type_name(type_name)
    return topics
