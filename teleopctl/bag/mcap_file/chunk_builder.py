"""Building of MCAP chunks, message by message.

The library's writer is not used because it needs an object and seven writes for each message, which
is three quarters of the time to record small messages. `tests/interop/test_mcap_bytes.py` checks
that the files are equal to those of the library, byte for byte.
"""

from __future__ import annotations

import enum
import functools
import struct
import sys
import zlib
from array import array
from collections.abc import Callable
from typing import NamedTuple

from mcap.opcode import Opcode
from mcap.records import ChunkIndex

from teleopctl.bag.mcap_file.chunk import CHUNK_HEAD, HEAD, MESSAGE_HEAD
from teleopctl.base.budget import UNPACKED_FILE_BYTES, may_be_unpacked, unpacked_limit

CHUNK_BYTES = 2**20
"""Default size of a chunk, uncompressed, in bytes."""

_MESSAGE = struct.Struct("<BQHIQQ")
_INDEX = struct.Struct("<BQHI")
_LENGTH = struct.Struct("<I")
_SIZE = struct.Struct("<Q")

# Smallest relative gain of a compression; otherwise the chunk is stored uncompressed, as in
# rosbag2, since it is faster to read.
_LEAST_GAIN = 0.02


class Compression(enum.Enum):
    """Compression of MCAP chunks: none, LZ4 or Zstandard."""

    NONE = "none"
    LZ4 = "lz4"
    ZSTD = "zstd"


class CompressionLevel(enum.Enum):
    """Compression level of MCAP chunks, with rosbag2's names."""

    FASTEST = "Fastest"
    FAST = "Fast"
    DEFAULT = "Default"
    SLOW = "Slow"
    SLOWEST = "Slowest"


# Levels of rosbag2, except for the default, which is that of each library.
_ZSTD_LEVELS = dict(zip(CompressionLevel, (-5, -3, 3, 5, 19), strict=True))
_LZ4_LEVELS = dict(zip(CompressionLevel, (-1, 0, 0, 10, 12), strict=True))


class ChunkSettings(NamedTuple):
    """Size, compression and checksum settings for the chunks of an MCAP file.

    Attributes:
        compression: Compression of the chunks.
        chunk_bytes: Uncompressed size in bytes at which a chunk ends.
        compression_level: Level of the compression, from fastest to slowest.
        forces_compression: Whether to store a chunk compressed even if that is not smaller.
        chunk_checksums: Whether chunks have checksums, which show damage.
    """

    compression: Compression = Compression.ZSTD
    chunk_bytes: int = CHUNK_BYTES
    compression_level: CompressionLevel = CompressionLevel.DEFAULT
    forces_compression: bool = False
    chunk_checksums: bool = True


class ChunkBuilder:
    """Builder of MCAP chunks with their message indexes from single records.

    Args:
        settings: Size, compression and checksum settings.

    Attributes:
        size: Uncompressed size of the current chunk in bytes.
    """

    def __init__(self, settings: ChunkSettings) -> None:
        self._settings = settings
        self._compress = _compressor(settings.compression, settings.compression_level)
        self.size = 0
        self._parts: list[bytes] = []
        # Uncompressed and stored size of all finished chunks.
        self._content_bytes = self._stored_bytes = 0
        # For each channel, log time and offset of its messages, alternating.
        self._indexes: dict[int, array[int]] = {}

    @property
    def has_messages(self) -> bool:
        """Whether messages were added since the last finished chunk."""
        return bool(self._indexes)

    def add_record(self, data: bytes) -> None:
        """Add an encoded schema or channel record to the current chunk."""
        self._parts.append(data)
        self.size += len(data)

    def add_message(
        self, channel: int, sequence: int, log_ns: int, publish_ns: int, data: bytes
    ) -> None:
        """Add a message record to the current chunk and to the chunk's message indexes."""
        length = len(data)
        head = _MESSAGE.pack(
            Opcode.MESSAGE, MESSAGE_HEAD.size + length, channel, sequence, log_ns, publish_ns
        )
        index = self._indexes.get(channel)
        if index is None:
            index = self._indexes[channel] = array("Q")
        index.append(log_ns)
        index.append(self.size)
        self._parts += (head, data)
        self.size += _MESSAGE.size + length

    def finish(self, offset: int) -> tuple[list[bytes], ChunkIndex]:
        """Return the chunk's bytes with message indexes, and its chunk index; begin a new chunk.

        Args:
            offset: Offset in the file at which the chunk will be written.

        Returns:
            The bytes to write (chunk and message indexes), and the chunk index for the summary.
        """
        content = b"".join(self._parts)
        indexes = self._indexes
        self._parts, self._indexes, self.size = [], {}, 0
        name, data = "", content
        if self._settings.compression is not Compression.NONE:
            compressed = self._compress(content)
            is_worth_it = len(compressed) <= len(content) * (1 - _LEAST_GAIN)
            # Content that readers would reject as a decompression bomb, such as a gigabyte of
            # zeros, is stored uncompressed.
            is_read = may_be_unpacked(len(content), len(compressed)) and (
                self._content_bytes + len(content)
                <= unpacked_limit(self._stored_bytes + len(compressed), UNPACKED_FILE_BYTES)
            )
            if is_read and (is_worth_it or self._settings.forces_compression):
                name, data = self._settings.compression.value, compressed
        self._content_bytes += len(content)
        self._stored_bytes += len(data)
        checksum = zlib.crc32(content) if self._settings.chunk_checksums else 0
        start_ns = min(min(index[::2]) for index in indexes.values())
        end_ns = max(max(index[::2]) for index in indexes.values())
        about = (
            CHUNK_HEAD.pack(start_ns, end_ns, len(content), checksum)
            + _LENGTH.pack(len(name))
            + name.encode()
            + _SIZE.pack(len(data))
        )
        head = HEAD.pack(Opcode.CHUNK, len(about) + len(data)) + about
        length = len(head) + len(data)
        parts, places, place = [head, data], {}, offset + length
        for channel, index in indexes.items():
            record = _index_record(channel, index)
            parts.append(record)
            places[channel] = place
            place += len(record)
        return parts, ChunkIndex(
            chunk_length=length,
            chunk_start_offset=offset,
            compression=name,
            compressed_size=len(data),
            message_end_time=end_ns,
            message_index_length=place - offset - length,
            message_index_offsets=places,
            message_start_time=start_ns,
            uncompressed_size=len(content),
        )


def _index_record(channel: int, index: array[int]) -> bytes:
    if sys.byteorder == "big":
        index.byteswap()
    entries = index.tobytes()
    size = len(entries)
    length = _INDEX.size - HEAD.size + size
    return _INDEX.pack(Opcode.MESSAGE_INDEX, length, channel, size) + entries


def _compressor(compression: Compression, level: CompressionLevel) -> Callable[[bytes], bytes]:
    if compression is Compression.ZSTD:
        import zstandard

        return zstandard.ZstdCompressor(level=_ZSTD_LEVELS[level]).compress
    if compression is Compression.LZ4:
        import lz4.frame  # type: ignore[import-untyped]  # it has no stubs

        return functools.partial(lz4.frame.compress, compression_level=_LZ4_LEVELS[level])
    return bytes
