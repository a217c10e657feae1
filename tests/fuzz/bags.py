"""Damages bags and gives them to the verbs: each ends with an answer or a refusal, never a defect.

``python -m tests.fuzz.bags [--count N] [--seconds S] [--seed N] [--kind db3|mcap|metadata|packed]``
"""

from __future__ import annotations

import argparse
import collections
import contextlib
import io
import math
import random
import re
import shutil
import sqlite3
import struct
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import zstandard

from teleopctl.bag import BagTopic, BagWriter, Compression, TypeText, WriterOptions
from teleopctl.cli.main import run
from teleopctl.interfaces import get_message, serialize
from tests.bag.bags import message, topic
from tests.fuzz.inputs import bytes_of, text_of

_TYPES = (
    "std_msgs/msg/String",
    "sensor_msgs/msg/JointState",
    "sensor_msgs/msg/Imu",
    "tf2_msgs/msg/TFMessage",
)
# Replacements of integers, lengths and times: limits of 8, 32 and 64 bits, and NaN.
_EDGES = (
    *(b"\0", b"\xff", b"\x80", b"\x7f", b"\xff" * 4, b"\xff\xff\xff\x7f", b"\0" * 8, b"\xff" * 8),
    *(
        b"\xff" * 9,
        b"\x81" * 9,
        b"\x7f" + b"\xff" * 7,
        b"\x80" + b"\0" * 7,
        b"\xc3\x28",
        b"\xed\xa0",
    ),
)
# Replacements of values in database columns and in metadata.yaml.
_VALUES: tuple[object, ...] = (
    *(None, 0, -1, 1, 2**31, 2**63 - 1, -(2**63), 0.5, float("inf"), 1e300),
    *("", "x", "/", "\0", "é" * 300, "999999999999999999999999", "2024-01-01", "[1", "a/b/c/d"),
    *(b"", b"\xff\xfe\x00", b"\x80abc", b"\0\1\0\0"),
)
_YAML_VALUES = (
    *("", "~", "-1", "0.5", ".inf", ".nan", "99999999999999999999", "x", "[]", "{}", "[1, 2]"),
    *("{a: b}", "'é'", "true", "2024-01-01", "!!int ''", "!!binary x", "*a", "/etc/passwd", "../x"),
    *("1e400", "9223372036854775807", "-9223372036854775808", '"\\0"'),
)
_TABLES = {
    "topics": ("id", "name", "type", "serialization_format", "offered_qos_profiles"),
    "messages": ("id", "topic_id", "timestamp", "data"),
}
_DEFECT = re.compile("defect of teleopctl|Traceback", re.IGNORECASE)


class Trial(NamedTuple):
    """Result of one command on a damaged bag.

    Attributes:
        kind: Damaged part: ``db3``, ``mcap``, ``metadata`` or ``packed``.
        words: Command line.
        seconds: Duration of the command.
        written: Output of the command.
    """

    kind: str
    words: list[str]
    seconds: float
    written: str

    @property
    def is_defect(self) -> bool:
        """Whether the output has a traceback or reports a defect of teleopctl."""
        return _DEFECT.search(self.written) is not None


def make_bags(folder: Path) -> dict[str, list[Path]]:
    """Write bags in all formats; return their folders by kind of damage, as in `Trial`."""
    bags: dict[str, list[Path]] = {"db3": [], "mcap": [], "metadata": [], "packed": []}
    for compression in Compression:
        options = WriterOptions(compression=compression, chunk_bytes=600)
        bags["mcap"].append(_bag(folder / f"mcap_{compression.value}", options))
    bags["db3"] += [_bag(folder / "db3", WriterOptions(database_settings=())), _old(folder / "old")]
    bags["metadata"] = [*bags["mcap"][:1], *bags["db3"][:1]]
    bags["packed"] = [_packed_file(folder / "packed_file", bags["db3"][0]), _packed(folder)]
    return bags


def _bag(folder: Path, options: WriterOptions) -> Path:
    with BagWriter(folder, options) as writer:
        for type_name in _TYPES:
            writer.add_topic(topic(_name(type_name), type_name))
        writer.add_topic(BagTopic("/unknown", "mine/msg/Own", "", TypeText("ros2msg", "int8 x\n")))
        for number in range(48):
            type_name = _TYPES[number % len(_TYPES)]
            fields = {"data": "y" * number} if type_name == _TYPES[0] else {}
            if fields:
                writer.write(message(_name(type_name), number, type_name, **fields))
            else:
                plain = message("/x", number)
                data = bytes(serialize(get_message(type_name)()))
                writer.write(plain._replace(topic=_name(type_name), data=data))
    return folder


def _name(type_name: str) -> str:
    return "/" + type_name.rpartition("/")[2].lower()


def _old(folder: Path) -> Path:
    """Write a bag as Humble's rosbag2 does, without definitions and metadata.yaml."""
    from tests.bag.test_sqlite_reader import write_database

    folder.mkdir()
    write_database(folder / "old_0.db3", count=60)
    return folder


def _packed_file(folder: Path, of: Path) -> Path:
    shutil.copytree(of, folder)
    (file,) = folder.glob("*.db3")
    file.with_suffix(".db3.zstd").write_bytes(zstandard.compress(file.read_bytes()))
    file.unlink()
    (folder / "metadata.yaml").unlink()
    return folder


def _packed(folder: Path) -> Path:
    made = folder / "packed"
    with BagWriter(made) as writer:
        writer.add_topic(topic("/x"))
        for number in range(30):
            plain = message("/x", number)
            writer.write(plain._replace(data=zstandard.compress(plain.data)))
    metadata = made / "metadata.yaml"
    text = metadata.read_text("utf-8")
    text = text.replace("compression_mode: ''", "compression_mode: MESSAGE")
    metadata.write_text(text.replace("compression_format: ''", "compression_format: zstd"), "utf-8")
    return made


# -- damage ----------------------------------------------------------------------------------------


def damage(chance: random.Random, kind: str, bag: Path) -> None:
    """Damage one file of a bag in place, in one or more ways."""
    files = sorted(file for file in bag.iterdir() if file.name != "metadata.yaml")
    if kind == "metadata":
        _damage_yaml(chance, bag / "metadata.yaml")
        return
    file = chance.choice(files)
    for _ in range(chance.choice((1, 1, 1, 2, 4))):
        if kind == "db3" and chance.random() < 0.35:
            with contextlib.suppress(sqlite3.Error, OverflowError, UnicodeError):
                _damage_table(chance, file)
            continue
        file.write_bytes(_damaged(chance, file.read_bytes(), 4096 if kind == "db3" else 512))


def _damaged(chance: random.Random, data: bytes, page: int) -> bytes:
    changed = bytearray(data)
    size = max(len(changed), 1)
    way = chance.randrange(9)
    if way == 0:
        return bytes(changed[: chance.randrange(size)])
    if way == 1:
        return bytes_of(chance, data)
    if way == 2:  # swap two pages
        pages = [bytes(changed[n : n + page]) for n in range(0, len(changed), page)]
        one, other = chance.randrange(len(pages) or 1), chance.randrange(len(pages) or 1)
        if pages:
            pages[one], pages[other] = pages[other], pages[one]
        return b"".join(pages)
    if way == 3:  # remove or duplicate a piece
        place, length = chance.randrange(size), chance.randrange(1, 2 * page)
        again = bytes(changed[place : place + length]) * chance.choice((0, 2))
        changed[place : place + length] = again
        return bytes(changed)
    if way == 4:
        place = chance.randrange(size) // page * page
        changed[place : place + page] = bytes(len(changed[place : place + page]))
        return bytes(changed)
    if way == 5:  # change a byte of the file's header
        place = chance.randrange(min(size, 120))
        changed[place : place + 1] = chance.choice(_EDGES)[:1]
        return bytes(changed)
    for _ in range(chance.choice((1, 2, 8, 32))):
        new = chance.choice(_EDGES) if way == 6 else chance.randbytes(chance.choice((1, 1, 2, 8)))
        place = chance.randrange(size)
        changed[place : place + len(new)] = new[: max(len(changed) - place, 0)]
    return bytes(changed)


def _damage_table(chance: random.Random, file: Path) -> None:
    """Change types, columns or values of a table in ways that no writer does."""
    table = chance.choice(list(_TABLES))
    column = chance.choice(_TABLES[table])
    value = chance.choice(_VALUES)
    with contextlib.closing(sqlite3.connect(file)) as database, database:
        way = chance.randrange(4)
        if way == 0:  # remove constraints and column types, which reject most of these values
            _loosen(database, table)
        if way == 1:
            # Random bytes as TEXT: SQLite does not check that they are valid UTF-8.
            bad = struct.pack("<Q", chance.getrandbits(64)).hex()
            database.execute(f"UPDATE {table} SET {column} = CAST(x'{bad}' AS TEXT)")
            return
        if way == 2:
            database.execute(f"ALTER TABLE {table} RENAME COLUMN {column} TO other")
            return
        where = f"WHERE rowid % {chance.randrange(1, 9)} = 0"
        database.execute(f"UPDATE {table} SET {column} = ? {where}", (value,))


def _loosen(database: sqlite3.Connection, table: str) -> None:
    columns = [row[1] for row in database.execute(f"PRAGMA table_info({table})")]
    database.execute(f"CREATE TABLE loose ({', '.join(columns)})")
    database.execute(f"INSERT INTO loose SELECT * FROM {table}")
    database.execute(f"DROP TABLE {table}")
    database.execute(f"ALTER TABLE loose RENAME TO {table}")


def _damage_yaml(chance: random.Random, file: Path) -> None:
    text = file.read_text("utf-8")
    lines = text.splitlines()
    for _ in range(chance.choice((1, 1, 2, 5))):
        way = chance.randrange(6)
        place = chance.randrange(len(lines))
        if way == 0:
            file.write_bytes(bytes_of(chance, text.encode()))
            return
        if way == 1:
            lines = text_of(chance, "\n".join(lines)).splitlines() or [""]
        elif way == 2:
            del lines[place:]
            lines = lines or [""]
        elif way == 3:
            lines[place : place + 1] = [lines[place]] * chance.choice((0, 2))
            lines = lines or [""]
        else:
            key, colon, _ = lines[place].partition(":")
            lines[place] = f"{key}{colon} {chance.choice(_YAML_VALUES)}"
    file.write_text("\n".join(lines), "utf-8", errors="surrogatepass")


# -- verbs -----------------------------------------------------------------------------------------

_VERBS: dict[str, Callable[[Path, Path], list[str]]] = {
    "info": lambda bag, _: ["info", str(bag)],
    "info -v": lambda bag, _: ["info", "-v", str(bag)],
    "info --json": lambda bag, _: ["info", "-v", "--json", str(bag)],
    "check": lambda bag, _: ["check", str(bag)],
    "recover": lambda bag, out: ["recover", str(bag), "-o", str(out)],
    "recover in place": lambda bag, _: ["recover", str(bag)],
    "reindex": lambda bag, _: ["reindex", str(bag)],
    "convert": lambda bag, out: ["convert", str(bag), "-o", str(out), "-s", "mcap"],
    "convert to db3": lambda bag, out: ["convert", str(bag), "-o", str(out), "-s", "sqlite3"],
    "cut": lambda bag, out: ["cut", str(bag), "-o", str(out), "--duration", "0.01"],
    "filter": lambda bag, out: ["filter", str(bag), "-o", str(out), "--topics", "/string"],
    "merge": lambda bag, out: ["merge", str(bag), str(bag), "-o", str(out)],
    "export": lambda bag, out: ["export", str(bag), "-o", str(out), "--format", "csv"],
    "plot": lambda bag, out: ["plot", str(bag), "/jointstate/position[0]"],
}


def trials(chance: random.Random, kind: str, bags: list[Path], folder: Path) -> Iterator[Trial]:
    """Damage a copy of a bag, run some verbs on the copy, and yield the result of each."""
    place = folder / "bag"
    shutil.rmtree(place, ignore_errors=True)
    source = chance.choice(bags)
    shutil.copytree(source, place)
    damage(chance, kind, place)
    files = [file for file in place.iterdir() if file.name != "metadata.yaml"]
    for name in ("check", *chance.sample([n for n in _VERBS if n != "check"], 3)):
        out = folder / "out"
        shutil.rmtree(out, ignore_errors=True)
        bag = chance.choice((place, place, files[0]))
        words = ["bag", *_VERBS[name](bag, out)]
        began_s = time.monotonic()
        shown = io.StringIO()
        with contextlib.redirect_stdout(shown), contextlib.redirect_stderr(shown):
            try:
                run(words)
            except (SystemExit, KeyboardInterrupt):
                pass
            except Exception as error:  # noqa: BLE001 -- any exception is a defect
                shown.write(f"Traceback: {type(error).__name__}: {error}")
        yield Trial(kind, words, time.monotonic() - began_s, shown.getvalue())


def main() -> None:
    """Run the trials of the command line; keep bags that show a defect, then exit with status 1."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seconds", type=float, help="begin no further trial after that")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kind", choices=("db3", "mcap", "metadata", "packed"))
    parser.add_argument("--keep", type=Path, help="a folder for bags that show a defect")
    options = parser.parse_args()
    outcomes: collections.Counter[str] = collections.Counter()
    defects: collections.Counter[str] = collections.Counter()
    slowest = (0.0, "")
    ends_s = math.inf if options.seconds is None else time.monotonic() + options.seconds
    with tempfile.TemporaryDirectory() as folder:
        bags = make_bags(Path(folder))
        for number in range(options.count):
            if time.monotonic() >= ends_s:
                break
            chance = random.Random(options.seed * 1_000_000 + number)
            kind = options.kind or chance.choice(("db3", "db3", "mcap", "metadata", "packed"))
            for trial in trials(chance, kind, bags[kind], Path(folder)):
                outcomes[trial.kind] += 1
                slowest = max(slowest, (trial.seconds, f"{number} {trial.words[:2]}"))
                if trial.is_defect:
                    line = " ".join(trial.written.split())[-300:]
                    if not defects[line]:
                        print(f"{number}: {kind}: {trial.words[1:3]}: {line}", flush=True)
                        if options.keep:
                            kept = options.keep / f"{options.seed}_{number}"
                            shutil.copytree(Path(folder) / "bag", kept, dirs_exist_ok=True)
                    defects[line] += 1
    print(dict(outcomes), f"{sum(defects.values())} defects, slowest {slowest}", flush=True)
    sys.exit(1 if defects else 0)


if __name__ == "__main__":
    main()
