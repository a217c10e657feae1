"""rosbag2's own zstd compression, of whole files or of single messages."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import BinaryIO

from teleopctl.bag.records import BagMessage
from teleopctl.base.budget import (
    UNPACKED_BYTES,
    UNPACKED_FILE_BYTES,
    BudgetError,
    check_unpacked,
    tally_of_unpacked,
    unpacked_limit,
)
from teleopctl.errors import InvalidFileError, SystemFailureError, UnsupportedError

ZSTD = "zstd"
SUFFIX = ".zstd"
"""Suffix of a file that is compressed as a whole."""

# Compressed bytes per step, which become at most 32,768 times as large: 128 MB.
_PIECE_BYTES = 2**12
_HEAD_BYTES = 18


def require_zstd(name: str) -> None:
    """Raise UnsupportedError if a bag's compression name is not zstd.

    Raises:
        UnsupportedError: The name is another one.
    """
    if name.lower() != ZSTD:
        raise UnsupportedError(
            f"A bag that is compressed with '{name}' cannot be read",
            hint=f"rosbag2's {ZSTD} can, and what MCAP has inside.",
        )


def unpack_file(path: Path, folder: Path) -> tuple[Path, str]:
    """Decompress a zstd bag file into a folder; return the new path and a fault text or "".

    Args:
        path: Path of the compressed file.
        folder: Folder of the decompressed file.

    Returns:
        The path of the decompressed file, and a description of the fault of the compressed file,
        empty if it has none.

    Raises:
        InvalidFileError: The file cannot be read, is not compressed with zstd, or becomes too
            large.
        SystemFailureError: The decompressed file cannot be written.
    """
    import zstandard

    output = folder / path.name.removesuffix(SUFFIX)
    fault = ""
    try:
        with path.open("rb") as source:
            # rosbag2 writes the size to the header: a file that is too large is not unpacked.
            claimed = _claimed_size(source.read(_HEAD_BYTES))
            least = UNPACKED_FILE_BYTES if claimed else UNPACKED_BYTES
            most = unpacked_limit(path.stat().st_size, least)
            _check_size(path, claimed, most)
            source.seek(0)
            with output.open("wb") as target:
                try:
                    _unpack(source, lambda block: _take(path, block, target, most))
                except zstandard.ZstdError as error:
                    fault = f"its compressed data is broken ({error})"
                except EOFError:
                    fault = "it is cut off"
    except OSError as error:
        if error.filename == str(path):
            raise InvalidFileError(f"Cannot read {path}: {error.strerror}") from error
        raise SystemFailureError(
            f"{path} cannot be decompressed in {folder}: {error.strerror}",
            hint="TMPDIR=/another/folder makes room.",
        ) from error
    if fault and not output.stat().st_size:
        raise InvalidFileError(f"Cannot read {path}: {fault}")
    return output, fault and f"{path}: {fault}; it is read up to there"


def unpack_messages(
    messages: Iterator[BagMessage], path: Path, on_left_out: Callable[[str], object] | None
) -> Iterator[BagMessage]:
    """Yield messages, each compressed by itself, decompressed; report broken ones, or raise.

    Raises:
        InvalidFileError: A message is broken or becomes too large, and `on_left_out` is None; or
            all messages together become too large.
    """
    import zstandard

    unpacked = tally_of_unpacked(_size_of(path))
    for message in messages:
        try:
            data = _unpack_message(message.data)
        except (zstandard.ZstdError, EOFError, BudgetError) as error:
            what = f"{path}, {message.topic} at {message.log_time_ns}: it is broken ({error})"
            if on_left_out is None:
                raise InvalidFileError(what) from error
            on_left_out(what)
            continue
        try:
            unpacked.add(len(data))
        except BudgetError as error:
            raise InvalidFileError(f"Cannot read {path}: {error}") from error
        yield message._replace(data=data)


def _size_of(path: Path) -> int:
    """Return the size of a bag, which is a file or a folder of files."""
    files = path.iterdir() if path.is_dir() else (path,)
    return sum(file.stat().st_size for file in files if file.is_file())


def _unpack_message(data: bytes) -> bytes:
    """Decompress one message.

    Raises:
        zstandard.ZstdError: The data is broken.
        EOFError: The data is truncated.
        BudgetError: The message becomes too large.
    """
    import zstandard

    size = zstandard.frame_content_size(data)
    if size >= 0:
        check_unpacked(size, len(data))
        return zstandard.decompress(data, size)
    unpacked = bytearray()

    def take(block: bytes) -> None:
        check_unpacked(len(unpacked) + len(block), len(data))
        unpacked.extend(block)

    _unpack(io.BytesIO(data), take)
    return bytes(unpacked)


def _unpack(source: BinaryIO, take: Callable[[bytes], object]) -> None:
    """Decompress a stream piece by piece.

    Raises:
        zstandard.ZstdError: The data is broken.
        EOFError: The data is truncated.
    """
    import zstandard

    reader = zstandard.ZstdDecompressor().decompressobj()
    while piece := source.read(_PIECE_BYTES):
        take(reader.decompress(piece))
    if not reader.eof:
        raise EOFError("it is cut off")


def _take(path: Path, block: bytes, target: BinaryIO, most: int) -> None:
    target.write(block)
    _check_size(path, target.tell(), most)


def _claimed_size(head: bytes) -> int:
    """Return the decompressed size in the header of a file; 0 if the header has none."""
    import zstandard

    try:
        return max(zstandard.frame_content_size(head), 0)
    except zstandard.ZstdError:
        return 0


def _check_size(path: Path, size: int, most: int) -> None:
    if size > most:
        raise InvalidFileError(
            f"Cannot read {path}: it becomes larger than {most:,} bytes, which is the most that"
            " is unpacked of a file of its size",
            hint=f"zstd -d {path} unpacks it all the same.",
        )
