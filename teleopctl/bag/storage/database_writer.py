"""Writes one SQLite database as rosbag2 does since Iron, whose readers it is for."""

from __future__ import annotations

import contextlib
import os
import sqlite3
from pathlib import Path
from typing import TYPE_CHECKING

from teleopctl.bag.metadata import VERSION, BagFile
from teleopctl.bag.qos_text import format_offers
from teleopctl.bag.storage.database_log import LOG_SUFFIX, take_in_log
from teleopctl.errors import SystemFailureError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from teleopctl.bag.records import BagAttachment, BagMessage, BagTopic

SCHEMA_VERSION = 4

# As rosbag2 creates them: its readers, and those of others, ask for these columns.
_TABLES = (
    "CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL)",
    "CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL,"
    " metadata TEXT NOT NULL)",
    "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,"
    " serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL,"
    " type_description_hash TEXT NOT NULL)",
    "CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL,"
    " encoding TEXT NOT NULL, encoded_message_definition TEXT NOT NULL,"
    " type_description_hash TEXT NOT NULL)",
    "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL,"
    " timestamp INTEGER NOT NULL, data BLOB NOT NULL)",
    "CREATE INDEX timestamp_idx ON messages (timestamp ASC)",
)

# Messages are written together: a transaction for each would take most of the time.
_BATCH_BYTES = 2**20
# The numbers beside the data of a message; rosbag2 reckons with as much.
_ROW_BYTES = 24


class DatabaseWriter:
    """Writer of one SQLite bag file; same interface as `McapFileWriter`.

    What `flush` has written survives the death of this process, where the settings have SQLite
    keep a log or a journal. A database has no place for files and for records other than
    rosbag2's, and of a message it has one time alone.

    Args:
        path: Where it is to be; nothing may be there.
        settings: SQLite's, each as it stands behind ``PRAGMA``.
        distribution: The ROS 2 distribution.

    Raises:
        SystemFailureError: It cannot be made. The methods raise it where it cannot be written.
    """

    def __init__(self, path: Path, settings: tuple[str, ...], distribution: str = "") -> None:
        self.path = path
        self._topic_ids: dict[str, int] = {}
        self._defined: set[str] = set()
        self._message_counts: dict[str, int] = {}
        self._rows: list[tuple[int, int, bytes]] = []
        self._row_bytes = 0
        self._first_ns: int | None = None
        self._last_ns = 0
        try:
            path.open("xb").close()
        except OSError as error:
            raise SystemFailureError(f"Cannot write {path}: {error.strerror}") from error
        with self._told():
            self._database = sqlite3.connect(path, isolation_level=None, check_same_thread=False)
            for setting in settings:
                self._database.execute(f"PRAGMA {setting}").fetchall()
            with self._transaction():
                for table in _TABLES:
                    self._database.execute(table)
                row = (SCHEMA_VERSION, distribution)
                self._database.execute("INSERT INTO schema VALUES (?, ?)", row)
            # Readers that do not look into a log find a bag, if it comes to that.
            self._database.execute("PRAGMA wal_checkpoint").fetchall()
            (self._page_bytes,) = self._database.execute("PRAGMA page_size").fetchone()
            self._pages_bytes = self._count_pages()

    @property
    def size(self) -> int:
        """Return the size in bytes, including buffered messages."""
        return self._pages_bytes + self._row_bytes

    @property
    def is_empty(self) -> bool:
        """Return whether the file has no messages."""
        return self._first_ns is None

    @property
    def start_ns(self) -> int:
        """The earliest log time; 0 for a database without messages."""
        return self._first_ns or 0

    @property
    def message_counts(self) -> Mapping[str, int]:
        """Number of messages by topic."""
        return self._message_counts

    @property
    def description(self) -> BagFile:
        """Entry of the file for ``metadata.yaml``."""
        if self._first_ns is None:
            return BagFile(self.path.name)
        duration_ns = self._last_ns - self._first_ns
        count = sum(self._message_counts.values())
        return BagFile(self.path.name, self._first_ns, duration_ns, count)

    def add_topic(self, topic: BagTopic) -> None:
        """Add a topic, before its first message. Idempotent."""
        if topic.name in self._topic_ids:
            return
        definition = topic.definition
        with self._told(), self._transaction():
            added = self._database.execute(
                "INSERT INTO topics(name, type, serialization_format, offered_qos_profiles,"
                " type_description_hash) VALUES (?, ?, ?, ?, ?)",
                (
                    topic.name,
                    topic.type_name,
                    topic.serialization_format,
                    format_offers(topic.qos),
                    topic.type_hash,
                ),
            )
            if definition.text and topic.type_name not in self._defined:
                self._database.execute(
                    "INSERT INTO message_definitions(topic_type, encoding,"
                    " encoded_message_definition, type_description_hash) VALUES (?, ?, ?, ?)",
                    (topic.type_name, definition.encoding, definition.text, topic.type_hash),
                )
                self._defined.add(topic.type_name)
        assert added.lastrowid is not None
        self._topic_ids[topic.name] = added.lastrowid
        self._message_counts[topic.name] = 0

    def write(self, message: BagMessage) -> None:
        """Write a message of an added topic."""
        time_ns = message.log_time_ns
        if self._first_ns is None or time_ns < self._first_ns:
            self._first_ns = time_ns
        if time_ns > self._last_ns:
            self._last_ns = time_ns
        self._message_counts[message.topic] += 1
        self._rows.append((self._topic_ids[message.topic], time_ns, message.data))
        self._row_bytes += _ROW_BYTES + len(message.data)
        if self._row_bytes > _BATCH_BYTES:
            self.flush()

    def attach(self, attachment: BagAttachment) -> None:
        """Do nothing: the format has no attachments."""

    def add_record(self, name: str, values: Mapping[str, str]) -> None:
        """Store rosbag2's metadata; the format has no place for other records."""
        if name == "rosbag2":
            row = (VERSION, values["serialized_metadata"])
            with self._told():
                self._database.execute(
                    "INSERT INTO metadata(metadata_version, metadata) VALUES (?, ?)", row
                )

    def flush(self) -> None:
        """Flush to the operating system."""
        rows, self._rows, self._row_bytes = self._rows, [], 0
        if rows:
            with self._told(), self._transaction():
                self._database.executemany(
                    "INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)", rows
                )
            self._pages_bytes = self._count_pages()

    def sync(self) -> None:
        """Flush the write-ahead log to the disk, and wait until that is done (fsync).

        For another thread than the one that writes. Of the database itself SQLite takes care:
        whoever opens and closes it in this process takes SQLite's locks from it.
        """
        with contextlib.suppress(OSError):
            log = os.open(f"{self.path}{LOG_SUFFIX}", os.O_RDONLY)
            try:
                os.fsync(log)
            finally:
                os.close(log)

    def close(self) -> None:
        """Finish and close the file."""
        self.flush()
        # Where somebody is reading it, it keeps its log, into which SQLite looks.
        with contextlib.suppress(sqlite3.OperationalError):
            take_in_log(self._database)
        with self._told():
            self._database.close()

    def abandon(self) -> None:
        """Close the file after an error; the open transaction is rolled back."""
        with contextlib.suppress(sqlite3.Error):
            self._database.close()

    def _count_pages(self) -> int:
        (count,) = self._database.execute("PRAGMA page_count").fetchone()
        return int(count) * int(self._page_bytes)

    @contextlib.contextmanager
    def _transaction(self) -> Iterator[None]:
        self._database.execute("BEGIN")
        try:
            yield
            self._database.execute("COMMIT")
        except BaseException:
            # A full disk has SQLite undo it by itself.
            if self._database.in_transaction:
                self._database.execute("ROLLBACK")
            raise

    @contextlib.contextmanager
    def _told(self) -> Iterator[None]:
        """Raise SQLite's errors as ours."""
        try:
            yield
        except sqlite3.Error as error:
            raise SystemFailureError(f"Cannot write {self.path}: {error}") from error
