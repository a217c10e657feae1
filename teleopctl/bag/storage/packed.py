"""rosbag2's own compression: whole files, or each message for itself, with zstd."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

from teleopctl.bag.records import BagMessage
from teleopctl.errors import InvalidFileError, SystemFailureError, UnsupportedError

ZSTD = "zstd"
SUFFIX = ".zstd"
"""What stands behind the name of a file that is compressed as a whole."""

_BLOCK_BYTES = 2**20


def require_zstd(name: str) -> None:
    """Refuse any other compression.

    Raises:
        UnsupportedError: The name is another one.
    """
    if name.lower() != ZSTD:
        raise UnsupportedError(
            f"A bag that is compressed with '{name}' cannot be read",
            hint=f"rosbag2's {ZSTD} can, and what MCAP has inside.",
        )


def unpack_file(path: Path, folder: Path) -> tuple[Path, str]:
    """Decompress a file, as far as it can be.

    Args:
        path: The file.
        folder: Where the other one goes.

    Returns:
        The other one, and what is wrong with the first; empty where nothing is.

    Raises:
        InvalidFileError: It is not compressed so, or cannot be read.
        SystemFailureError: There is no room.
    """
    import zstandard

    output = folder / path.name.removesuffix(SUFFIX)
    fault = ""
    try:
        with path.open("rb") as source:
            reader = zstandard.ZstdDecompressor().decompressobj()
            with output.open("wb") as target:
                try:
                    while block := source.read(_BLOCK_BYTES):
                        target.write(reader.decompress(block))
                    if not reader.eof:
                        fault = "it is cut off"
                except zstandard.ZstdError as error:
                    fault = f"its compressed data is broken ({error})"
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
    messages: Iterator[BagMessage], path: Path, left_out: Callable[[str], object] | None
) -> Iterator[BagMessage]:
    """Yield messages that are compressed one by one as they were; see `Bag.messages`.

    Raises:
        InvalidFileError: One is broken, and nobody is to be told.
    """
    import zstandard

    unpack = zstandard.ZstdDecompressor().decompressobj
    for message in messages:
        try:
            data = unpack().decompress(message.data)
        except zstandard.ZstdError as error:
            what = f"{path}, {message.topic} at {message.log_time_ns}: it is broken ({error})"
            if left_out is None:
                raise InvalidFileError(what) from error
            left_out(what)
            continue
        yield message._replace(data=data)
