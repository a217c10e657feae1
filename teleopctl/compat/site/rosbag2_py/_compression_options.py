"""``rosbag2_py._compression_options``. Compression of bags."""

import enum
from dataclasses import dataclass

__all__ = [
    "CompressionMode",
    "CompressionOptions",
    "compression_mode_from_string",
    "compression_mode_to_string",
]


class CompressionMode(enum.IntEnum):
    """What is compressed: nothing, whole files, or each message."""

    NONE = 0
    FILE = 1
    MESSAGE = 2


@dataclass
class CompressionOptions:
    """Compression of a bag: format ``zstd``, and what is compressed.

    The numbers of the queue and of threads have no effect: chunks are compressed as they are
    written.
    """

    compression_format: str = ""
    compression_mode: CompressionMode = CompressionMode.NONE
    compression_queue_size: int = 1
    compression_threads: int = 0


def compression_mode_from_string(name: str) -> CompressionMode:
    """Return the mode of a name such as ``file``; ``NONE`` for an unknown one."""
    return CompressionMode.__members__.get(name.upper(), CompressionMode.NONE)


def compression_mode_to_string(mode: CompressionMode) -> str:
    """Return the name of a mode, such as ``FILE``."""
    return mode.name
