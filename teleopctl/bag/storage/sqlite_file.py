"""Reads one SQLite database of rosbag2, damaged or not, in the order of log times.

| table | since | has |
|---|---|---|
| ``topics``, ``messages`` | Crystal | names and types; times and bytes |
| ``topics.offered_qos_profiles`` | Foxy | quality of service |
| ``schema`` | Humble | the distribution that recorded it |
| ``message_definitions``, ``topics.type_description_hash`` | Iron | definitions and hashes |

A type may be one that nobody here knows: its messages are bytes all the same.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Callable, Collection, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, Self
from urllib.parse import quote

from teleopctl.bag.known_definition import known_definition
from teleopctl.bag.metadata import SQLITE3, BagFile
from teleopctl.bag.qos_text import parse_offers
from teleopctl.bag.records import (
    CDR,
    NO_TIME_NS,
    BagAttachment,
    BagMessage,
    BagTopic,
    TypeText,
    whole_type_name,
)
from teleopctl.bag.service_events import is_service_event, service_of
from teleopctl.errors import InvalidFileError
from teleopctl.interfaces import type_hash

# After so many numbers in turn that have no message, a damaged database has no further one.
_GAP = 10_000
_HEAD_BYTES = 20
_WAL_VERSION = 2


class SqliteFileReader:
    """One database.

    Args:
        path: The file.

    Attributes:
        topics: Its topics by name, each with its number of messages.
        is_finished: Whether it is whole; one that is not is read as far as it can be.
        remarks: What of it cannot be understood, and is left out.
        distribution: The ROS 2 distribution that recorded it; empty where that is not told.

    Raises:
        InvalidFileError: It is no database of rosbag2, or cannot be read.
    """

    STORAGE = SQLITE3

    def __init__(self, path: Path) -> None:
        self.path = path
        self.remarks: list[str] = []
        self.is_finished = True
        try:
            path.open("rb").close()
            self._database = _connect(path)
        except OSError as error:
            raise InvalidFileError(f"Cannot read {path}: {error.strerror}") from error
        except sqlite3.Error as error:
            raise InvalidFileError(f"Cannot read {path}: {error}") from error
        try:
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
        """What ``metadata.yaml`` says of it."""
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
        left_out: Callable[[str], object] | None = None,
    ) -> Iterator[BagMessage]:
        """Yield messages by log time; see `Bag.messages`.

        A database that was damaged when it was opened is read as far as it can be.

        Raises:
            InvalidFileError: It is damaged, and nobody is to be told.
        """
        wanted = {id_: t.name for id_, t in self._ids.items() if topics is None or t.name in topics}
        reached = (-1, -1)
        if self.is_finished:
            try:
                query = (
                    "SELECT timestamp, id, topic_id, data FROM messages"  # noqa: S608 (our numbers)
                    f" WHERE timestamp >= ? AND timestamp < ? AND {_among(wanted)}"
                    " ORDER BY timestamp, id"
                )
                rows = self._database.execute(query, (start_ns, end_ns))
                for time_ns, number, id_, data in rows:
                    if isinstance(time_ns, int) and isinstance(data, bytes):
                        yield BagMessage(wanted[id_], time_ns, time_ns, data)
                    reached = (time_ns, number)
                return
            except sqlite3.Error as error:
                what = f"{self.path}: the database is damaged ({error})"
                if left_out is None:
                    raise InvalidFileError(
                        what, hint=f"teleopctl bag recover {self.path} saves what can be read."
                    ) from error
                left_out(what)
        for time_ns, number, id_ in sorted(self._salvage()):
            is_wanted = id_ in wanted and start_ns <= time_ns < end_ns
            if is_wanted and (time_ns, number) > reached:
                data = self._data_of(number)
                if data is not None:
                    yield BagMessage(wanted[id_], time_ns, time_ns, data)

    def latest(self, topic: str, end_ns: int, most: int = 1) -> list[BagMessage]:
        """Return the last messages of a topic before a log time, oldest first; see `Bag`."""
        wanted = {id_ for id_, known in self._ids.items() if known.name == topic}
        with suppress(sqlite3.Error):
            query = (
                "SELECT timestamp, data FROM messages"  # noqa: S608 (our numbers)
                f" WHERE timestamp < ? AND {_among(wanted)}"
                " ORDER BY timestamp DESC, id DESC LIMIT ?"
            )
            rows = self._database.execute(query, (end_ns, most)).fetchall()
            return [BagMessage(topic, time, time, data) for time, data in reversed(rows) if data]
        return []

    def attachments(self) -> Iterator[BagAttachment]:
        """Yield nothing: a database has no place for files."""
        return iter(())

    def records(self) -> Iterator[tuple[str, dict[str, str]]]:
        """Yield what it has of ``metadata.yaml``, as MCAP's records do."""
        text = self._first("SELECT metadata FROM metadata ORDER BY id DESC")
        if text:
            yield "rosbag2", {"serialized_metadata": text}

    def check(self) -> Iterator[str]:
        """Yield a sentence for each thing that is damaged; all of it is read."""
        try:
            found = [row[0] for row in self._database.execute("PRAGMA quick_check(5)")]
        except sqlite3.Error as error:
            found = [str(error)]
        for what in found:
            if what != "ok":
                yield "the database is damaged: " + " ".join(what.split())

    def close(self) -> None:
        """Close the file."""
        self._database.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _find_topics(self) -> dict[int, BagTopic]:
        """The topics by their numbers in the database."""
        self._database.row_factory = sqlite3.Row
        try:
            try:
                rows = self._database.execute("SELECT * FROM topics ORDER BY id").fetchall()
            except sqlite3.DatabaseError as error:
                if isinstance(error, sqlite3.OperationalError) or "malformed" not in str(error):
                    raise
                # It is shorter than its first page says. With this, SQLite reads what is there.
                self.is_finished = False
                self._database.execute("PRAGMA writable_schema=ON")
                rows = self._database.execute("SELECT * FROM topics ORDER BY id").fetchall()
            definitions = {}
            with suppress(sqlite3.Error):
                definitions = {
                    row["topic_type"]: TypeText(
                        str(row["encoding"]), row["encoded_message_definition"]
                    )
                    for row in self._database.execute("SELECT * FROM message_definitions")
                    if isinstance(row["encoded_message_definition"], str)
                }
        finally:
            self._database.row_factory = None
        return {
            row["id"]: self._topic(dict(row), definitions)
            for row in rows
            if isinstance(row["name"], str) and isinstance(row["type"], str)
        }

    # Any: a row has numbers and texts.
    def _topic(self, row: dict[str, Any], definitions: dict[str, TypeText]) -> BagTopic:
        name, type_name = row["name"], whole_type_name(row["type"])
        try:
            offers = tuple(dict.fromkeys(parse_offers(row.get("offered_qos_profiles"))))
        except InvalidFileError as error:
            self.remarks.append(f"{self.path}, topic {name}: {error.message}")
            offers = ()
        version = str(row.get("type_description_hash") or "")
        # rosbag2 keeps the definition of a service, and not that of its events.
        service = service_of(name, type_name)[1] if is_service_event(name, type_name) else ""
        definition = definitions.get(row["type"]) or definitions.get(service) or TypeText()
        if not definition.text.strip() or not definition.encoding:
            definition = known_definition(type_name, version) or TypeText()
            if definition.text:
                version = type_hash(type_name)
        form = str(row.get("serialization_format") or CDR)
        return BagTopic(name, type_name, version, definition, offers, form)

    def _summarize(self) -> dict[int, tuple[int, int, int]]:
        """Number of messages, first and last log time, by the number of the topic."""
        if self.is_finished:
            try:
                rows = self._database.execute(
                    "SELECT topic_id, COUNT(*), MIN(timestamp), MAX(timestamp)"
                    " FROM messages GROUP BY topic_id"
                )
                return {row[0]: row[1:] for row in rows if _is_whole(row)}
            except sqlite3.OperationalError:
                raise
            except sqlite3.DatabaseError:
                self.is_finished = False
        found: dict[int, tuple[int, int, int]] = {}
        for time_ns, _, id_ in self._salvage():
            count, first, last = found.get(id_, (0, time_ns, time_ns))
            found[id_] = (count + 1, min(first, time_ns), max(last, time_ns))
        return found

    def _salvage(self) -> Iterator[tuple[int, int, int]]:
        """Log time, number and topic of the messages that a damaged database still gives.

        They are read as they were written, and after each damage from the next one on that is
        there.
        """
        columns = "SELECT timestamp, id, topic_id FROM messages"
        last = 0
        while True:
            try:
                for row in self._database.execute(f"{columns} WHERE id > ? ORDER BY id", (last,)):
                    if row[1] <= last:  # The numbers are damaged, too.
                        return
                    last = row[1]
                    if _is_whole(row):
                        yield row
                return
            except sqlite3.Error:
                pass
            for number in range(last + 1, last + 1 + _GAP):
                with suppress(sqlite3.Error):
                    row = self._database.execute(f"{columns} WHERE id = ?", (number,)).fetchone()
                    if row is not None:
                        last = number
                        if _is_whole(row):
                            yield row
                        break
            else:
                return

    def _data_of(self, number: int) -> bytes | None:
        with suppress(sqlite3.Error):
            row = self._database.execute("SELECT data FROM messages WHERE id = ?", (number,))
            (data,) = row.fetchone() or (None,)
            return data if isinstance(data, bytes) else None
        return None

    def _first(self, query: str) -> str:
        with suppress(sqlite3.Error):
            row = self._database.execute(query).fetchone()
            return str(row[0] or "") if row else ""
        return ""


def _connect(path: Path) -> sqlite3.Connection:
    """Open a database for reading, such that nothing is written beside it."""
    address = f"file:{quote(str(path.absolute()))}?mode=ro"
    log = path.with_name(f"{path.name}-wal")
    if _uses_log(path) and not (log.exists() and log.stat().st_size):
        # Closed cleanly; SQLite would make a log anew.
        address += "&immutable=1"
    database = sqlite3.connect(address, uri=True, check_same_thread=False)
    database.text_factory = lambda text: text.decode(errors="replace")
    try:
        database.execute("SELECT 1 FROM sqlite_master").fetchone()
    except sqlite3.OperationalError:
        # A folder that cannot be written, or a log that was begun: read without it.
        database.close()
        database = sqlite3.connect(f"{address}&immutable=1", uri=True, check_same_thread=False)
        database.text_factory = lambda text: text.decode(errors="replace")
    except sqlite3.DatabaseError:
        pass  # It is damaged, or none; the topics tell.
    return database


def _uses_log(path: Path) -> bool:
    with suppress(OSError), path.open("rb") as stream:
        head = stream.read(_HEAD_BYTES)
        return len(head) == _HEAD_BYTES and head[-1] == _WAL_VERSION
    return False


def _is_whole(row: tuple[object, ...]) -> bool:
    return all(isinstance(value, int) for value in row)


def _among(ids: Collection[int]) -> str:
    return f"topic_id IN ({', '.join(map(str, ids))})"
