"""Building of MCAP chunks, message by message.

Why not the library's writer: it makes an object and seven writes of each message, which is three
quarters of what it costs to record small ones. `tests/interop/test_mcap_bytes.py` holds the files
equal to the library's, byte for byte.
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
"""How many bytes of messages are compressed and indexed together."""

_MESSAGE = struct.Struct("<BQHIQQ")
_INDEX = struct.Struct("<BQHI")
_LENGTH = struct.Struct("<I")
_SIZE = struct.Struct("<Q")

# A chunk that is not made smaller by this part is quicker to read as it is; so does rosbag2.
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


# Those of rosbag2, but for the default, which is that of each library.
_ZSTD_LEVELS = dict(zip(CompressionLevel, (-5, -3, 3, 5, 19), strict=True))
_LZ4_LEVELS = dict(zip(CompressionLevel, (-1, 0, 0, 10, 12), strict=True))


class ChunkSettings(NamedTuple):
    """Size, compression and checksum settings for the chunks of an MCAP file.

    Attributes:
        compression: Of what they hold.
        chunk_bytes: Uncompressed size at which a chunk ends.
        compression_level: How much time the compression may take.
        forces_compression: Whether chunks are compressed that are not made smaller by it.
        chunk_checksums: Whether damage to chunks can be found later.
    """

    compression: Compression = Compression.ZSTD
    chunk_bytes: int = CHUNK_BYTES
    compression_level: CompressionLevel = CompressionLevel.DEFAULT
    forces_compression: bool = False
    chunk_checksums: bool = True


class ChunkBuilder:
    """Builder of MCAP chunks with their message indexes from single records.

    Args:
        settings: How.

    Attributes:
        size: Bytes that it has gathered, uncompressed.
    """

    def __init__(self, settings: ChunkSettings) -> None:
        self._settings = settings
        self._compress = _compressor(settings.compression, settings.compression_level)
        self.size = 0
        self._parts: list[bytes] = []
        # Of all chunks that were made.
        self._content_bytes = self._stored_bytes = 0
        # Of each channel the times and the places of its messages, in turn.
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
        """Return the current chunk's bytes and chunk index record, and begin a new chunk.

        Args:
            offset: Where in the file it is going to be.

        Returns:
            What is to be written, and what the summary has of it.
        """
        content = b"".join(self._parts)
        indexes = self._indexes
        self._parts, self._indexes, self.size = [], {}, 0
        name, data = "", content
        if self._settings.compression is not Compression.NONE:
            compressed = self._compress(content)
            is_worth_it = len(compressed) <= len(content) * (1 - _LEAST_GAIN)
            # What readers would refuse as a bomb, a gigabyte of zeros, stays as it is.
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
