"""Writes one SQLite database as rosbag2 does since Iron, and completes those left open.

The writer of rosbags commits once, when it is closed: a killed recorder would leave no messages.
"""

from __future__ import annotations

import contextlib
import os
import sqlite3
from pathlib import Path
from typing import TYPE_CHECKING

from teleopctl.bag.base import BagFileWriter
from teleopctl.bag.metadata import VERSION
from teleopctl.bag.qos_profiles import format_offered_profiles
from teleopctl.errors import InvalidFileError, RefusedError, SystemFailureError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from teleopctl.bag.records import BagAttachment, BagMessage, BagTopic


LOG_SUFFIX = "-wal"
"""Suffix of SQLite's write-ahead log, whose content is not in the database yet."""

_JOURNAL_SUFFIX = "-journal"


def is_left_open(path: Path) -> bool:
    """Return whether a non-empty SQLite log or journal is beside a database.

    Args:
        path: Path of the database.
    """
    beside = [path.with_name(path.name + suffix) for suffix in (LOG_SUFFIX, _JOURNAL_SUFFIX)]
    return any(file.exists() and file.stat().st_size for file in beside)


def finish_database(path: Path) -> None:
    """Complete a database that a killed process left open, from its log or journal.

    Args:
        path: Path of the database; without a log or journal, it is not changed.

    Raises:
        InvalidFileError: The database cannot be read or written.
        RefusedError: Another program is writing the database.
    """
    if not is_left_open(path):
        return
    try:
        with contextlib.closing(sqlite3.connect(path, timeout=0, isolation_level=None)) as database:
            merge_log(database)
    except sqlite3.OperationalError as error:
        if error.sqlite_errorcode & 0xFF not in (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED):
            raise InvalidFileError(f"Cannot finish {path}: {error}") from error
        raise RefusedError(
            f"{path} is being written by another program",
            hint="Stop the recorder first; it ends its files itself.",
        ) from error
    except sqlite3.Error as error:
        raise InvalidFileError(f"Cannot finish {path}: {error}") from error


def merge_log(database: sqlite3.Connection) -> None:
    """Merge SQLite's write-ahead log into a database, and switch the log off.

    Raises:
        sqlite3.OperationalError: Another connection has the database open.
    """
    # Only for a write-ahead log: a journal is handled by the query below.
    if database.execute("PRAGMA journal_mode").fetchone() == ("wal",):
        database.execute("PRAGMA journal_mode=DELETE").fetchall()
    database.execute("SELECT 1 FROM sqlite_master").fetchone()


SCHEMA_VERSION = 4

# Tables as rosbag2 creates them: its readers, and other readers, query these columns.
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

# Messages are committed together: a transaction for each would take most of the time.
_BATCH_BYTES = 2**20
# Size of a row in addition to the data of a message, as in rosbag2.
_ROW_BYTES = 24


class SqliteFileWriter(BagFileWriter):
    """Writer of one SQLite file of a bag, in rosbag2's format.

    Messages written before a `flush` are not lost if the process is killed, if the settings make
    SQLite keep a log or a journal. The format has no attachments, no metadata records other than
    that of rosbag2, and only one time for each message.

    Args:
        path: Path of the file, which must not exist.
        settings: SQLite settings, each in the form of the text after ``PRAGMA``.
        distribution: ROS 2 distribution; empty if unknown.

    Raises:
        SystemFailureError: The file cannot be created. The methods raise the error if writing
            fails.
    """

    def __init__(self, path: Path, settings: tuple[str, ...], distribution: str = "") -> None:
        super().__init__(path)
        self._topic_ids: dict[str, int] = {}
        self._defined: set[str] = set()
        self._rows: list[tuple[int, int, bytes]] = []
        self._row_bytes = 0
        try:
            path.open("xb").close()
        except OSError as error:
            raise SystemFailureError(f"Cannot write {path}: {error.strerror}") from error
        with self._errors_converted():
            self._database = sqlite3.connect(path, isolation_level=None, check_same_thread=False)
            for setting in settings:
                self._database.execute(f"PRAGMA {setting}").fetchall()
            with self._transaction():
                for table in _TABLES:
                    self._database.execute(table)
                row = (SCHEMA_VERSION, distribution)
                self._database.execute("INSERT INTO schema VALUES (?, ?)", row)
            # So that readers that ignore the log find the tables of a bag.
            self._database.execute("PRAGMA wal_checkpoint").fetchall()
            (self._page_bytes,) = self._database.execute("PRAGMA page_size").fetchone()
            self._pages_bytes = self._count_pages()

    @property
    def size(self) -> int:
        """Size of the database in bytes, including messages that are not committed yet."""
        return self._pages_bytes + self._row_bytes

    def add_topic(self, topic: BagTopic) -> None:
        """Add a topic to the database, before the topic's first message; idempotent."""
        if topic.name in self._topic_ids:
            return
        definition = topic.definition
        with self._errors_converted(), self._transaction():
            added = self._database.execute(
                "INSERT INTO topics(name, type, serialization_format, offered_qos_profiles,"
                " type_description_hash) VALUES (?, ?, ?, ?, ?)",
                (
                    topic.name,
                    topic.type_name,
                    topic.serialization_format,
                    format_offered_profiles(topic.qos),
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
        self.message_counts[topic.name] = 0

    def write(self, message: BagMessage) -> None:
        """Buffer a message of an added topic; commit when the buffer is full."""
        self._count(message)
        self._rows.append((self._topic_ids[message.topic], message.log_time_ns, message.data))
        self._row_bytes += _ROW_BYTES + len(message.data)
        if self._row_bytes > _BATCH_BYTES:
            self.flush()

    def attach(self, attachment: BagAttachment) -> None:
        """Do nothing: rosbag2's SQLite format has no attachments."""

    def add_record(self, name: str, values: Mapping[str, str]) -> None:
        """Store the record ``rosbag2`` (bag metadata); ignore all other records."""
        if name == "rosbag2":
            row = (VERSION, values["serialized_metadata"])
            with self._errors_converted():
                self._database.execute(
                    "INSERT INTO metadata(metadata_version, metadata) VALUES (?, ?)", row
                )

    def flush(self) -> None:
        """Commit the buffered messages to the database."""
        rows, self._rows, self._row_bytes = self._rows, [], 0
        if rows:
            with self._errors_converted(), self._transaction():
                self._database.executemany(
                    "INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)", rows
                )
            self._pages_bytes = self._count_pages()

    def sync(self) -> None:
        """Wait until the write-ahead log is on the disk (fsync); not for the thread that writes.

        To be called from another thread than the one that writes. SQLite syncs the database itself;
        opening and closing the file in this process would release SQLite's locks.
        """
        with contextlib.suppress(OSError):
            log = os.open(f"{self.path}{LOG_SUFFIX}", os.O_RDONLY)
            try:
                os.fsync(log)
            finally:
                os.close(log)

    def close(self) -> None:
        """Commit the buffered messages, merge the log, and close the database."""
        self.flush()
        # If another program is reading the database, the log remains, and SQLite reads it.
        with contextlib.suppress(sqlite3.OperationalError):
            merge_log(self._database)
        with self._errors_converted():
            self._database.close()

    def abandon(self) -> None:
        """Close the database after a write error, without committing."""
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
            # If the disk is full, SQLite has already rolled back.
            if self._database.in_transaction:
                self._database.execute("ROLLBACK")
            raise

    @contextlib.contextmanager
    def _errors_converted(self) -> Iterator[None]:
        """Raise SQLite's errors as `SystemFailureError`."""
        try:
            yield
        except sqlite3.Error as error:
            raise SystemFailureError(f"Cannot write {self.path}: {error}") from error
