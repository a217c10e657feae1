"""Messages of a bag, decoded or as bytes."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from teleopctl.bag import DecodedMessage, Decoder, open_bag

if TYPE_CHECKING:
    from teleopctl.bag import BagMessage

_LAST_NS = 2**63 - 1


def read_bag(
    path: Path | str,
    topics: Collection[str] | None = None,
    *,
    start_ns: int = 0,
    end_ns: int = _LAST_NS,
) -> Iterator[DecodedMessage]:
    """Yield a bag's decoded messages in log-time order, of some topics or all decodable ones.

    The bag is a folder or file of rosbag2 (MCAP, SQLite), or a bag of ROS 1. Types come from the
    definitions in the bag. A message that cannot be decoded is left out.

    Args:
        path: Folder or file of the bag.
        topics: Full names of the topics; None for all that can be decoded.
        start_ns: First log time, in nanoseconds since the epoch.
        end_ns: Log time at which to end, exclusive.

    Raises:
        NotFoundError: The bag does not exist, or lacks a topic.
        InvalidFileError: The bag cannot be read.
        InvalidMessageError: A named topic cannot be decoded.

    Example:
        >>> for record in read_bag("session", ["/joint_states"], start_ns=3000):
        ...     print(record.log_time_ns, list(record.message.position))
        3000 [0.5, 0.6]
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
    """Yield a bag's messages as CDR bytes in log-time order, of some topics or all.

    Args:
        path: Folder or file of the bag.
        topics: Full names of the topics; None for all.
        start_ns: First log time, in nanoseconds since the epoch.
        end_ns: Log time at which to end, exclusive.

    Raises:
        NotFoundError: The bag does not exist.
        InvalidFileError: The bag cannot be read.

    Example:
        >>> [message.log_time_ns for message in read_raw_bag("session", end_ns=3000)]
        [1000, 2000]
    """
    with open_bag(Path(path)) as bag:
        yield from bag.messages(topics, start_ns, end_ns)
