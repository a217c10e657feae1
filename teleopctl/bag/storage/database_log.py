"""What SQLite keeps beside a database that is being written: its log, or a journal."""

from __future__ import annotations

import contextlib
import sqlite3
from pathlib import Path

from teleopctl.errors import InvalidFileError, RefusedError

LOG_SUFFIX = "-wal"
"""What the name of a log ends with: what is in it is not in the database yet."""

_JOURNAL_SUFFIX = "-journal"


def is_left_open(path: Path) -> bool:
    """Return whether a database was left with a write-ahead log beside it.

    Args:
        path: The database.
    """
    beside = [path.with_name(path.name + suffix) for suffix in (LOG_SUFFIX, _JOURNAL_SUFFIX)]
    return any(file.exists() and file.stat().st_size for file in beside)


def finish_database(path: Path) -> None:
    """Complete a database that a killed process has left open.

    Args:
        path: The database; one with nothing beside it is left alone.

    Raises:
        InvalidFileError: It cannot be read, or cannot be written.
        RefusedError: Another program is writing it.
    """
    if not is_left_open(path):
        return
    try:
        with contextlib.closing(sqlite3.connect(path, timeout=0, isolation_level=None)) as database:
            take_in_log(database)
    except sqlite3.OperationalError as error:
        if error.sqlite_errorcode & 0xFF not in (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED):
            raise InvalidFileError(f"Cannot finish {path}: {error}") from error
        raise RefusedError(
            f"{path} is being written by another program",
            hint="Stop the recorder first; it ends its files itself.",
        ) from error
    except sqlite3.Error as error:
        raise InvalidFileError(f"Cannot finish {path}: {error}") from error


def take_in_log(database: sqlite3.Connection) -> None:
    """Merge the write-ahead log into the database, and disable it.

    Raises:
        sqlite3.OperationalError: Somebody else has it open.
    """
    # Only where it has one: a journal is looked at by any reading.
    if database.execute("PRAGMA journal_mode").fetchone() == ("wal",):
        database.execute("PRAGMA journal_mode=DELETE").fetchall()
    database.execute("SELECT 1 FROM sqlite_master").fetchone()
