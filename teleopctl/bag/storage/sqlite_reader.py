"""Reads one SQLite database of rosbag2, damaged or not, in the order of log times.

| table | since | content |
|---|---|---|
| ``topics``, ``messages`` | Crystal | names and types; times and bytes |
| ``topics.offered_qos_profiles`` | Foxy | quality of service |
| ``schema`` | Humble | ROS distribution of the recorder |
| ``message_definitions``, ``topics.type_description_hash`` | Iron | definitions and hashes |

Types need not be known, since messages are read as bytes. The reader of rosbags is no replacement:
it misses messages in the log of a killed recorder (measured: 256 of 200,000 messages), and cannot
open a damaged database.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any
from urllib.parse import quote

from teleopctl.bag.base import BagFileReader
from teleopctl.bag.metadata import SQLITE3, BagFile
from teleopctl.bag.qos_profiles import parse_offered_profiles
from teleopctl.bag.records import (
    CDR,
    NO_TIME_NS,
    BagAttachment,
    BagMessage,
    BagTopic,
    TypeText,
    full_type_name,
)
from teleopctl.bag.topic_kinds import is_service_event, service_of
from teleopctl.bag.type_definitions import known_definition
from teleopctl.errors import InvalidFileError
from teleopctl.interfaces import type_hash

# Number of row IDs without a message after which the search in a damaged database ends.
_GAP = 10_000
_LARGEST = 2**63
# Bounds of the length limit: SQLite itself needs some bytes, and no value is larger than 2 GB.
_LEAST_LENGTH, _MOST_LENGTH = 1_000_000, 2**31 - 1
# rosbag2 writes these types only, but SQLite accepts any value in any column.
_IS_MESSAGE = (
    "typeof(timestamp) = 'integer' AND timestamp >= 0 AND typeof(data) = 'blob'"
    " AND typeof(topic_id) = 'integer'"
)
_HEAD_BYTES = 20
_WAL_VERSION = 2


class SqliteFileReader(BagFileReader):
    """Reader of one SQLite file of a bag, which may be damaged.

    Args:
        path: Path of the file.

    Attributes:
        topics: Topics by name, each with its number of messages.
        is_finished: Whether the database is undamaged; a damaged one is read as far as possible.
        remarks: Unreadable parts of the database that are skipped, one sentence each.
        distribution: ROS 2 distribution that recorded the file; empty if unknown.

    Raises:
        InvalidFileError: The file is no database of rosbag2, or cannot be read.
    """

    STORAGE = SQLITE3

    def __init__(self, path: Path) -> None:
        self.path = path
        self.remarks: list[str] = []
        self.is_finished = True
        self._nonsense = 0
        try:
            path.open("rb").close()
            self._database = _Database(path)
        except OSError as error:
            raise InvalidFileError(f"Cannot read {path}: {error.strerror}") from error
        except sqlite3.Error as error:
            raise InvalidFileError(f"Cannot read {path}: {error}") from error
        try:
            self._require_tables()
            self._ids = self._find_topics()
            self._summary = self._summarize()
        except sqlite3.Error as error:
            self.close()
            raise InvalidFileError(f"Cannot read {path}: {error}") from error
        except BaseException:
            self.close()
            raise
        self.distribution = self._first("SELECT ros_distro FROM schema")
        self.topics: dict[str, tuple[BagTopic, int]] = {}
        for id_, topic in self._ids.items():
            known, count = self.topics.get(topic.name, (topic, 0))
            self.topics[topic.name] = (known, count + self._summary.get(id_, (0, 0, 0))[0])

    @property
    def description(self) -> BagFile:
        """The file's `BagFile` entry for ``metadata.yaml``: name, times and message count."""
        parts = self._summary.values()
        count = sum(part[0] for part in parts)
        if not count:
            return BagFile(self.path.name)
        start_ns = min(part[1] for part in parts)
        return BagFile(self.path.name, start_ns, max(part[2] for part in parts) - start_ns, count)

    def messages(
        self,
        topics: Collection[str] | None = None,
        start_ns: int = 0,
        end_ns: int = NO_TIME_NS,
        on_left_out: Callable[[str], object] | None = None,
    ) -> Iterator[BagMessage]:
        """Yield messages by log time; skip damage found on opening; report or raise later damage.

        A database whose damage was found when it was opened is read as far as possible.

        Raises:
            InvalidFileError: Damage is found while reading, and `on_left_out` is None.
        """
        wanted = {id_: t.name for id_, t in self._ids.items() if topics is None or t.name in topics}
        reached = (-1, -1)
        if self.is_finished:
            try:
                query = (
                    "SELECT timestamp, rowid, topic_id, data FROM messages"  # noqa: S608 (numbers)
                    f" WHERE timestamp >= ? AND timestamp < ? AND {_among(wanted)}"
                    " ORDER BY timestamp, rowid"
                )
                for row in self._database.rows(query, start_ns, end_ns):
                    *place, data = row
                    # A damaged index may lead to rows that do not match the query.
                    if _is_place(place) and place[2] in wanted and isinstance(data, bytes):
                        time_ns, number, id_ = place
                        yield BagMessage(wanted[id_], time_ns, time_ns, data)
                        reached = (time_ns, number)
                return
            except sqlite3.Error as error:
                what = f"{self.path}: the database is damaged ({error})"
                if on_left_out is None:
                    raise InvalidFileError(
                        what, hint=f"teleopctl bag recover {self.path} saves what can be read."
                    ) from error
                on_left_out(what)
        for time_ns, number, id_ in sorted(self._readable_places()):
            is_wanted = id_ in wanted and start_ns <= time_ns < end_ns
            if is_wanted and (time_ns, number) > reached:
                data = self._data_of(number)
                if data is not None:
                    yield BagMessage(wanted[id_], time_ns, time_ns, data)

    def latest(self, topic: str, end_ns: int, most: int = 1) -> list[BagMessage]:
        """Return up to `most` last messages of a topic before a log time, oldest first."""
        wanted = {id_ for id_, known in self._ids.items() if known.name == topic}
        with suppress(sqlite3.Error):
            query = (
                "SELECT timestamp, data FROM messages"  # noqa: S608 (our numbers)
                f" WHERE {_IS_MESSAGE} AND timestamp < ? AND {_among(wanted)}"
                " ORDER BY timestamp DESC, rowid DESC LIMIT ?"
            )
            rows = list(self._database.rows(query, end_ns, most))
            return [
                BagMessage(topic, time_ns, time_ns, data)
                for time_ns, data in reversed(rows)
                if _is_place((time_ns,)) and isinstance(data, bytes)
            ]
        return []

    def attachments(self) -> Iterator[BagAttachment]:
        """Yield nothing: rosbag2's SQLite format has no attachments."""
        return iter(())

    def records(self) -> Iterator[tuple[str, dict[str, str]]]:
        """Yield the bag metadata stored in the database, as a record named ``rosbag2``."""
        text = self._first("SELECT metadata FROM metadata ORDER BY id DESC")
        if text:
            yield "rosbag2", {"serialized_metadata": text}

    def check(self) -> Iterator[str]:
        """Check the whole database; yield a sentence for each damage."""
        try:
            found = [str(row[0]) for row in self._database.rows("PRAGMA quick_check(5)")]
        except sqlite3.Error as error:
            found = [str(error)]
        for what in found:
            if what != "ok":
                yield "the database is damaged: " + " ".join(what.split())
        if self._nonsense:
            yield f"{self._nonsense} rows of its messages are invalid: no time, no topic or no data"

    def close(self) -> None:
        """Close the database."""
        self._database.close()

    def _require_tables(self) -> None:
        """Require plain tables: a view may have an infinite number of rows.

        Raises:
            InvalidFileError: A table is a view, is virtual, or has computed columns.
        """
        for table in ("topics", "messages"):
            query = "SELECT type, sql FROM sqlite_master WHERE name = ?"
            try:
                kinds = [str(kind) for kind, _ in self._database.rows(query, table)]
                columns = list(self._database.rows(f"PRAGMA table_xinfo({table})"))
            except sqlite3.Error:
                continue  # the database is damaged; `_find_topics` raises the error
            is_computed = any(row[-1] not in (None, 0) for row in columns)
            if is_computed or (kinds and "table" not in kinds):
                raise InvalidFileError(
                    f"Cannot read {self.path}: its '{table}' is not a plain table"
                )

    def _find_topics(self) -> dict[int, BagTopic]:
        """Return the topics by their IDs in the database."""
        query = "SELECT * FROM topics ORDER BY id"
        try:
            rows = list(self._database.named_rows(query))
        except sqlite3.DatabaseError as error:
            if isinstance(error, sqlite3.OperationalError) or "malformed" not in str(error):
                raise
            # The file is shorter than its header states. With this pragma, SQLite still reads it.
            self.is_finished = False
            list(self._database.rows("PRAGMA writable_schema=ON"))
            rows = list(self._database.named_rows(query))
        definitions = {}
        with suppress(sqlite3.Error):
            for row in self._database.named_rows("SELECT * FROM message_definitions"):
                text = row.get("encoded_message_definition")
                if isinstance(text, str):
                    type_name, encoding = row.get("topic_type"), row.get("encoding")
                    definitions[str(type_name)] = TypeText(str(encoding), text)
        if rows and not {"id", "name", "type"} <= rows[0].keys():
            raise InvalidFileError(f"Cannot read {self.path}: its topics have no name or no type")
        return {
            row["id"]: self._topic(row, definitions)
            for row in rows
            if isinstance(row["id"], int)
            and isinstance(row["name"], str)
            and isinstance(row["type"], str)
        }

    # Any: numbers and texts of a row.
    def _topic(self, row: dict[str, Any], definitions: dict[str, TypeText]) -> BagTopic:
        name, type_name = row["name"], full_type_name(row["type"])
        try:
            offers = parse_offered_profiles(row.get("offered_qos_profiles"))
        except InvalidFileError as error:
            self.remarks.append(f"{self.path}, topic {name}: {error.message}")
            offers = ()
        version = str(row.get("type_description_hash") or "")
        # rosbag2 stores the definition of a service, not that of its event type.
        service = service_of(name, type_name)[1] if is_service_event(name, type_name) else ""
        definition = definitions.get(row["type"]) or definitions.get(service) or TypeText()
        if not definition.text.strip() or not definition.encoding:
            definition = known_definition(type_name, version) or TypeText()
            if definition.text:
                version = type_hash(type_name)
        form = str(row.get("serialization_format") or CDR)
        return BagTopic(name, type_name, version, definition, offers, form)

    def _summarize(self) -> dict[int, tuple[int, int, int]]:
        """Return the number of messages, and the first and last log time, by topic ID."""
        if self.is_finished:
            try:
                rows = self._database.rows(
                    "SELECT topic_id, COUNT(*), MIN(timestamp), MAX(timestamp)"  # noqa: S608 (ours)
                    f" FROM messages WHERE {_IS_MESSAGE} GROUP BY topic_id"
                )
                found = {row[0]: row[1:] for row in rows if _is_place(row[1:])}
                count = self._database.rows("SELECT COUNT(*) FROM messages")
                self._nonsense = next(count)[0] - sum(row[0] for row in found.values())
                return found
            except sqlite3.OperationalError:
                raise
            except sqlite3.DatabaseError:
                self.is_finished = False
        found = {}
        for time_ns, _, id_ in self._readable_places():
            count, first, last = found.get(id_, (0, time_ns, time_ns))
            found[id_] = (count + 1, min(first, time_ns), max(last, time_ns))
        return found

    def _readable_places(self) -> Iterator[tuple[int, int, int]]:
        """Yield log time, row ID and topic ID of the readable messages of a damaged database.

        Messages are read in the order of writing; after each damaged place, reading continues with
        the next readable row.
        """
        columns = "SELECT timestamp, rowid, topic_id FROM messages"
        last = 0
        while True:
            try:
                for row in self._database.rows(f"{columns} WHERE rowid > ? ORDER BY rowid", last):
                    if not isinstance(row[1], int) or row[1] <= last:  # row IDs are damaged, too
                        return
                    last = row[1]
                    if _is_place(row):
                        yield row
                return
            except sqlite3.Error:
                pass
            for number in range(last + 1, min(last + 1 + _GAP, _LARGEST)):
                with suppress(sqlite3.Error):
                    row = next(self._database.rows(f"{columns} WHERE rowid = ?", number), ())
                    if row:
                        last = number
                        if _is_place(row):
                            yield row
                        break
            else:
                return

    def _data_of(self, number: int) -> bytes | None:
        with suppress(sqlite3.Error):
            rows = self._database.rows("SELECT data FROM messages WHERE rowid = ?", number)
            (data,) = next(rows, (None,))
            return data if isinstance(data, bytes) else None
        return None

    def _first(self, query: str) -> str:
        with suppress(sqlite3.Error):
            (value,) = next(self._database.rows(query), ("",))
            return value if isinstance(value, str) else ""
        return ""


class _Database:
    """Read-only connection to a database that may be damaged.

    Args:
        path: Path of the database; no other file is created.

    Raises:
        sqlite3.Error: The database cannot be opened.
    """

    def __init__(self, path: Path) -> None:
        address = f"file:{quote(str(path.absolute()))}?mode=ro"
        log = path.with_name(f"{path.name}-wal")
        if _uses_log(path) and not (log.exists() and log.stat().st_size):
            # Closed cleanly; without "immutable", SQLite would create a new log.
            address += "&immutable=1"
        self._connection = _connect(address, path, log)
        try:
            list(self.rows("SELECT 1 FROM sqlite_master LIMIT 1"))
        except sqlite3.OperationalError:
            # The folder is read-only, or the log is incomplete: read without the log.
            self._connection.close()
            self._connection = _connect(f"{address}&immutable=1", path, log)
        except sqlite3.DatabaseError:
            pass  # damaged, or no database; reading the topics raises the error

    # Any, here and below: SQLite values.
    def rows(self, query: str, *parameters: int | str) -> Iterator[tuple[Any, ...]]:
        """Execute an SQL query and yield its rows as tuples.

        Raises:
            sqlite3.Error: The query fails, also if a damaged file causes another error of Python's
                sqlite3 module.
        """
        for _, row in self._rows(query, parameters):
            yield row

    def named_rows(self, query: str) -> Iterator[dict[str, Any]]:
        """Execute an SQL query and yield its rows as mappings by column name."""
        for names, row in self._rows(query, ()):
            yield dict(zip(names, row, strict=True))

    def _rows(
        self, query: str, parameters: tuple[int | str, ...]
    ) -> Iterator[tuple[list[str], tuple[Any, ...]]]:
        try:
            cursor = self._connection.execute(query, parameters)
            names = [column[0] for column in cursor.description or ()]
            for row in cursor:
                yield names, row
        except sqlite3.Error:
            raise
        except (UnicodeError, OverflowError, ValueError, LookupError, MemoryError) as error:
            # Python decodes column names and SQLite's messages as UTF-8, which may be invalid.
            raise sqlite3.DatabaseError(f"database is malformed ({error})") from error

    def close(self) -> None:
        """Close the database."""
        self._connection.close()


def _connect(address: str, path: Path, log: Path) -> sqlite3.Connection:
    database = sqlite3.connect(address, uri=True, check_same_thread=False)
    database.text_factory = lambda text: text.decode(errors="replace")
    size = path.stat().st_size + (log.stat().st_size if log.exists() else 0)
    # No value is longer than the file, whatever length a damaged file states.
    database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, min(max(size, _LEAST_LENGTH), _MOST_LENGTH))
    return database


def _uses_log(path: Path) -> bool:
    with suppress(OSError), path.open("rb") as stream:
        head = stream.read(_HEAD_BYTES)
        return len(head) == _HEAD_BYTES and head[-1] == _WAL_VERSION
    return False


def _is_place(row: Sequence[object]) -> bool:
    """Return whether all values of a row are integers in the range of times and counts."""
    return all(isinstance(value, int) and 0 <= value < NO_TIME_NS for value in row)


def _among(ids: Collection[int]) -> str:
    return f"topic_id IN ({', '.join(map(str, ids))})"
