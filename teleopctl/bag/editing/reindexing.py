"""``metadata.yaml`` made anew from the files of a bag."""

from __future__ import annotations

import contextlib
from pathlib import Path

from teleopctl.bag.editing.sources import Sources
from teleopctl.bag.mcap_file.repair import finish_file
from teleopctl.bag.metadata import (
    METADATA_FILE,
    SQLITE3,
    BagFile,
    BagMetadata,
    read_metadata,
    write_metadata,
)
from teleopctl.bag.storage.bag import by_number, open_bag, open_files
from teleopctl.errors import InvalidFileError, NotFoundError, UnsupportedError


def reindex(folder: Path) -> BagMetadata:
    """Make ``metadata.yaml`` anew, and give files that were not finished their end.

    What the old one has of the person's own data is kept, where it can be read.

    Raises:
        NotFoundError: The folder has no files of a bag.
        InvalidFileError: A file is broken otherwise than by being cut off.
        RefusedError: A file is being written.
        UnsupportedError: Its files are compressed as a whole.
        SystemFailureError: It cannot be written.
    """
    if not folder.is_dir():
        raise NotFoundError("Must specify a bag directory")
    files = [file for file in folder.iterdir() if file.suffix in (".mcap", ".db3")]
    files.sort(key=by_number)
    if not files:
        compressed = next(folder.glob("*.zstd"), None)
        if compressed is not None:
            raise UnsupportedError(
                f"{compressed}: a bag whose files are compressed as a whole cannot be reindexed",
                hint="Decompress them first: zstd -d --rm FILE.",
            )
        raise NotFoundError(f"No storage files found for reindexing in {folder}")
    old = None
    with contextlib.suppress(InvalidFileError):
        old = read_metadata(folder)
    if all(file.suffix == ".mcap" for file in files):
        for file in files:
            finish_file(file)
        with open_files(folder, files, old) as bag:
            metadata = bag.metadata
    else:
        metadata = _of_databases(files, old)
    write_metadata(folder / METADATA_FILE, metadata)
    return metadata


def _of_databases(files: list[Path], old: BagMetadata | None) -> BagMetadata:
    with contextlib.ExitStack() as stack:
        bags = [stack.enter_context(open_bag(file)) for file in files]
        return BagMetadata(
            files=tuple(
                BagFile(
                    file.name,
                    bag.metadata.start_ns,
                    bag.metadata.duration_ns,
                    bag.metadata.message_count,
                )
                for file, bag in zip(files, bags, strict=True)
            ),
            topics=tuple(Sources(bags).topics.values()),
            storage=SQLITE3,
            custom_data=old.custom_data if old else {},
            distribution=old.distribution if old else "",
        )
