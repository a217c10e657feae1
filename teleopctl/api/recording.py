"""Reading the messages of a bag."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from teleopctl.bag import Decoded, Decoder, open_bag

if TYPE_CHECKING:
    from teleopctl.bag import BagMessage

_LAST_NS = 2**63 - 1


def read_bag(
    path: Path | str,
    topics: Collection[str] | None = None,
    *,
    start_ns: int = 0,
    end_ns: int = _LAST_NS,
) -> Iterator[Decoded]:
    """Yield the decoded messages of a bag in the order of their log times.

    Reads rosbag2 folders and files (MCAP, SQLite) and bags of ROS 1. No ROS is needed: types come
    from the definitions in the bag. A message that cannot be decoded is left out.

    Args:
        path: Folder or file of the bag.
        topics: Full names of the topics; None for all that can be decoded.
        start_ns: First log time, in nanoseconds since the epoch.
        end_ns: Log time at which to end, exclusive.

    Raises:
        NotFoundError: There is no such bag, or it lacks a topic.
        InvalidFileError: The bag cannot be read.
        InvalidMessageError: A named topic cannot be decoded.
    """
    with open_bag(Path(path)) as bag:
        yield from Decoder(bag, topics).messages(None, start_ns, end_ns)


def read_raw_bag(
    path: Path | str,
    topics: Collection[str] | None = None,
    *,
    start_ns: int = 0,
    end_ns: int = _LAST_NS,
) -> Iterator[BagMessage]:
    """Yield the messages of a bag as CDR bytes; the arguments are those of `read_bag`.

    Raises:
        NotFoundError: There is no such bag.
        InvalidFileError: The bag cannot be read.
    """
    with open_bag(Path(path)) as bag:
        yield from bag.messages(topics, start_ns, end_ns)
