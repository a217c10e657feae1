"""rosbag2's words for how SQLite databases are written."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path

from teleopctl.bag.storage.presets import read_keys
from teleopctl.errors import InvalidFileError, UsageError, did_you_mean

PRESETS = ("none", "resilient")
"""Storage preset profiles of rosbag2's SQLite plug-in."""

# rosbag2's own default keeps the journal in memory: a process that is killed while it writes leaves
# a database that nobody can read. With a log beside it, it is whole at every moment.
_LOG = "journal_mode=WAL"
_OF_PRESETS = {
    "": (_LOG, "synchronous=OFF"),
    "none": (_LOG, "synchronous=OFF"),
    # Whole also where the machine loses its power.
    "resilient": (_LOG, "synchronous=NORMAL"),
}
_SECTIONS = ("write", "read")
_FORBIDDEN = "';\""
# What SQLite's documentation, and so rosbag2's example, has in the place of a schema's name.
_ANY_SCHEMA = "schema."


def database_settings(preset: str = "", config_file: Path | None = None) -> tuple[str, ...]:
    """Return SQLite's ``PRAGMA`` settings of a preset and a file.

    Args:
        preset: One of `PRESETS`; empty for none.
        config_file: YAML as rosbag2's SQLite plug-in reads it; wins over the preset.

    Raises:
        UsageError: There is no such preset.
        InvalidFileError: The file cannot be read, or SQLite does not know a setting; with its line.
    """
    if preset not in _OF_PRESETS:
        raise UsageError(
            f"unknown SQLite storage preset profile '{preset}'",
            hint=f"There are {', '.join(PRESETS)}.",
        )
    given = _read(config_file) if config_file else {}
    ours = {_name(setting): setting for setting in _OF_PRESETS[preset]}
    # The size of pages is to be said before there is a log.
    return tuple({**given, **{name: s for name, s in ours.items() if name not in given}}.values())


def _read(file: Path) -> dict[str, str]:
    """The settings for writing, by name."""
    settings: dict[str, str] = {}
    for section, place, content in read_keys(file):
        if section not in _SECTIONS:
            raise InvalidFileError(
                f"{place}: '{section}' is not known", hint=did_you_mean(section, _SECTIONS)
            )
        listed = content.get("pragmas") if isinstance(content, dict) else None
        if not isinstance(listed, list) or not all(isinstance(each, str) for each in listed):
            raise InvalidFileError(f"{place}: '{section}' has a list of texts, pragmas: [...]")
        for setting in filter(None, (each.strip() for each in listed)):
            _check(setting, place)
            if section == "write":
                setting = setting.removeprefix(_ANY_SCHEMA)
                settings[_name(setting)] = setting
    return settings


def _check(setting: str, place: str) -> None:
    if any(sign in setting for sign in _FORBIDDEN):
        raise InvalidFileError(f"{place}: {setting!r} has one of the signs {_FORBIDDEN}")
    setting = setting.removeprefix(_ANY_SCHEMA)
    with closing(sqlite3.connect(":memory:")) as database:
        try:
            database.execute(f"PRAGMA {setting}").fetchall()
            is_known = database.execute(f"PRAGMA {_name(setting)}").fetchone() is not None
        except sqlite3.Error as error:
            raise InvalidFileError(f"{place}: SQLite says of {setting!r}: {error}") from error
    if not is_known:
        raise InvalidFileError(f"{place}: SQLite has no pragma '{_name(setting)}'")


def _name(setting: str) -> str:
    return setting.partition("=")[0].partition("(")[0].strip()
