"""``metadata.yaml`` made anew from the files of a bag."""

from __future__ import annotations

import contextlib
from pathlib import Path

from teleopctl.bag.editing.faults import DATABASE_SUFFIX
from teleopctl.bag.mcap_file.repair import finish_file
from teleopctl.bag.metadata import METADATA_FILE, BagMetadata, read_metadata, write_metadata
from teleopctl.bag.storage.bag import open_files, stored_files
from teleopctl.errors import InvalidFileError, NotFoundError


def reindex(folder: Path) -> BagMetadata:
    """Rewrite ``metadata.yaml``, and finish files that were not closed.

    What the old one has of the person's own data is kept, where it can be read.

    Raises:
        NotFoundError: The folder has no files of a bag.
        InvalidFileError: A file is broken otherwise than by being cut off.
        RefusedError: A file is being written.
        UnsupportedError: It is compressed in a way that is not known.
        SystemFailureError: It cannot be written.
    """
    if not folder.is_dir():
        raise NotFoundError("Must specify a bag directory")
    files = stored_files(folder)
    if not files:
        raise NotFoundError(f"No storage files found for reindexing in {folder}")
    old = None
    with contextlib.suppress(InvalidFileError):
        old = read_metadata(folder)
    for file in files:
        if file.suffix == ".mcap":
            finish_file(file)
        elif file.suffix == DATABASE_SUFFIX:
            from teleopctl.bag.storage.database_log import finish_database

            finish_database(file)
    with open_files(folder, files, old) as bag:
        metadata = bag.metadata
    write_metadata(folder / METADATA_FILE, metadata)
    return metadata
