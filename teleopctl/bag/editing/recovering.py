"""Recovery of bags that a recorder could not finish or a disk has damaged, and reindexing."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from teleopctl.bag.editing.checking import DATABASE_SUFFIX, bag_file_faults, metadata_differences
from teleopctl.bag.editing.copying import OutputBag, ProgressCallback, copy_bags
from teleopctl.bag.mcap_file.file_reader import ChunkRecovery, McapFileReader
from teleopctl.bag.mcap_file.file_writer import McapFileWriter
from teleopctl.bag.mcap_file.inspection import Fault
from teleopctl.bag.mcap_file.repair import finish_file
from teleopctl.bag.mcap_file.scan import MAGIC_BYTES, scan
from teleopctl.bag.metadata import METADATA_FILE, BagMetadata, read_metadata, write_metadata
from teleopctl.bag.records import BagMessage, BagTopic
from teleopctl.bag.storage.bag import bag_files, open_bag, open_files, stored_files
from teleopctl.bag.storage.compression import SUFFIX
from teleopctl.bag.type_definitions import topic_message_class
from teleopctl.errors import InvalidFileError, NotFoundError, RefusedError, TeleopctlError
from teleopctl.interfaces import deserialize


def reindex(folder: Path) -> BagMetadata:
    """Rebuild ``metadata.yaml`` from a bag's files, which are completed first; return the metadata.

    Custom data of the old ``metadata.yaml`` is kept if the file can be read.

    Raises:
        NotFoundError: The folder has no files of a bag.
        InvalidFileError: A file is damaged, not only truncated.
        RefusedError: A file is being written.
        UnsupportedError: The compression of a file is unknown.
        SystemFailureError: A file cannot be written.
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
            from teleopctl.bag.storage.sqlite_writer import finish_database

            finish_database(file)
    with open_files(folder, files, old) as bag:
        metadata = bag.metadata
    write_metadata(folder / METADATA_FILE, metadata)
    return metadata


class Recovery(NamedTuple):
    """Result of `recover`: the usable bag, what was repaired, and what was lost.

    Attributes:
        path: Path of the usable bag.
        message_count: Number of messages in the usable bag.
        done: Repairs, one sentence each.
        damage: Faults of the damaged bag, one sentence each.
        lost: Lost parts and messages, one sentence each.
    """

    path: Path
    message_count: int
    done: list[str]
    damage: list[str]
    lost: list[str]


def recover(
    path: Path, output: Path | None = None, on_progress: ProgressCallback = lambda _done: None
) -> Recovery:
    """Repair a truncated bag in place, or copy the readable part of a damaged one to a new bag.

    A truncated file is completed in place, where only an unfinished last record is removed. A bag
    with other damage is not changed; its readable messages are copied to a new bag.

    Args:
        path: Folder or file of the bag.
        output: Folder for the new bag. If None, a truncated bag is repaired in place, and a damaged
            one is copied to a folder next to it whose name ends with ``_recovered``.
        on_progress: Called with the copied part of the time span, from 0 to 1.

    Raises:
        NotFoundError: The bag does not exist, or has no files.
        InvalidFileError: No part of the bag can be read.
        RefusedError: The bag is being written, is of ROS 1, or the output exists.
        SystemFailureError: A file cannot be written.
    """
    if not path.exists():
        raise NotFoundError(f"Bag path '{path}' does not exist!")
    files = [file for file in bag_files(path) if file.exists()]
    if not files:
        raise NotFoundError(f"{path} has no files of a bag")
    if files[0].suffix == ".bag":
        raise RefusedError(
            f"{path} is a bag of ROS 1, which has its own programs for this",
            hint="rosbag reindex repairs it; teleopctl bag convert reads it then.",
        )
    faults = [(file, fault) for file in files for fault in _faults(file)]
    if output is None and all(fault.is_finishable for _, fault in faults):
        return _repair_in_place(path, files)
    return _copy_readable(
        path, output or path.with_name(f"{path.stem}_recovered"), faults, on_progress
    )


def _faults(file: Path) -> list[Fault]:
    return [] if _has_nothing(file) else list(bag_file_faults(file))


def _has_nothing(file: Path) -> bool:
    """Return whether a file is an MCAP file that ends before its first record."""
    return _is_mcap(file) and file.stat().st_size < MAGIC_BYTES


def _is_mcap(file: Path) -> bool:
    return file.suffix not in (DATABASE_SUFFIX, SUFFIX)


def _repair_in_place(path: Path, files: list[Path]) -> Recovery:
    done = []
    for file in files:
        if file.suffix == DATABASE_SUFFIX:
            done += _finished_database(file)
            continue
        if not _is_mcap(file):
            continue
        if _has_no_header(file):
            file.unlink()
            McapFileWriter(file).close()
            done.append(f"{file}: it was empty, and is now a valid file without messages")
            continue
        with McapFileReader(file) as reader:
            is_finished = reader.is_finished
        if not is_finished:
            repair = finish_file(file)
            saved = (
                f", {repair.saved_count} of them from a chunk that was cut off; its checksum"
                " cannot be compared, so their content may have changed"
                if repair.saved_count
                else ""
            )
            done.append(
                f"{file}: it is finished now, with {repair.message_count} messages{saved};"
                f" {repair.bytes_cut} bytes of an unfinished record are removed"
            )
    if path.is_dir():
        with open_bag(path) as bag:
            old = _stored_metadata(path)
            agrees = old is not None and not any(metadata_differences(old, bag.metadata))
        if not agrees:
            reindex(path)
            done.append(f"{path / METADATA_FILE}: rebuilt from the files")
    with open_bag(path) as bag:
        return Recovery(path, bag.metadata.message_count, done, [], [])


def _finished_database(file: Path) -> list[str]:
    from teleopctl.bag.storage.sqlite_writer import finish_database, is_left_open

    if not is_left_open(file):
        return []
    finish_database(file)
    return [f"{file}: SQLite's log was merged into the file"]


def _copy_readable(
    path: Path, output: Path, faults: list[tuple[Path, Fault]], on_progress: ProgressCallback
) -> Recovery:
    damage = [f"{file}: {fault.what}" for file, fault in faults]
    lost = [f"{file}: {fault.what}" for file, fault in faults if fault.loses]
    classes: dict[str, type[Any] | None] = {}
    done = [f"{output}: what can be read of {path}"]
    recovery = ChunkRecovery(lambda message: _can_be_decoded(message, classes), done.append)
    with open_bag(path, recovery=recovery) as bag:
        classes.update((topic.name, _class_of(topic)) for topic, _ in bag.metadata.topics)
        (counts,) = copy_bags([bag], [OutputBag(output)], on_progress, on_left_out=lambda _: None)
        stated = {topic.name: count for topic, count in bag.metadata.topics}
        old = _stored_metadata(path)
        if old is not None:
            stated |= {topic.name: max(n, stated.get(topic.name, 0)) for topic, n in old.topics}
        for name, count in stated.items():
            missing = count - counts.get(name, 0)
            if missing > 0:
                lost.append(f"{name}: {missing} of {count} messages")
    return Recovery(output, sum(counts.values()), done, damage, lost)


# Any, here and below: classes made from the bag's definitions.
def _class_of(topic: BagTopic) -> type[Any] | None:
    with contextlib.suppress(TeleopctlError):
        return topic_message_class(topic)
    return None


def _can_be_decoded(message: BagMessage, classes: Mapping[str, type[Any] | None]) -> bool:
    """Return whether a message can be decoded as its type; True if the type is unknown."""
    message_class = classes.get(message.topic)
    if message_class is not None:
        try:
            deserialize(message.data, message_class)
        except TeleopctlError:
            return False
    return True


def _has_no_header(file: Path) -> bool:
    return file.stat().st_size < MAGIC_BYTES or scan(file).end == MAGIC_BYTES


def _stored_metadata(folder: Path) -> BagMetadata | None:
    with contextlib.suppress(InvalidFileError):
        return read_metadata(folder)
    return None
