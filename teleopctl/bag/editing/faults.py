"""What is wrong with one file of a bag, whatever its form."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from tempfile import gettempdir

from teleopctl.bag.mcap_file.inspection import Fault, file_faults
from teleopctl.bag.storage.packed import SUFFIX, unpack_file
from teleopctl.base.temporary import TemporaryFolder
from teleopctl.errors import InvalidFileError

DATABASE_SUFFIX = ".db3"


def faults_of(file: Path) -> Iterator[Fault]:
    """Read a whole file of a ROS 2 bag; yield its faults."""
    if file.suffix == SUFFIX:
        with TemporaryFolder(Path(gettempdir())) as folder:
            yield from _faults_inside(file, folder)
    elif file.suffix == DATABASE_SUFFIX:
        from teleopctl.bag.storage.database_log import is_left_open
        from teleopctl.bag.storage.sqlite_file import SqliteFileReader

        if is_left_open(file):
            yield Fault(
                "was not finished: programs that do not look at what SQLite has beside it miss"
                " messages",
                is_finishable=True,
            )
        try:
            with SqliteFileReader(file) as reader:
                yield from (Fault(what, loses=True) for what in reader.check())
        except InvalidFileError as error:
            yield Fault(error.message, loses=True)
    else:
        yield from file_faults(file)


def _faults_inside(file: Path, folder: Path) -> Iterator[Fault]:
    try:
        plain, fault = unpack_file(file, folder)
    except InvalidFileError as error:
        yield Fault(error.message, loses=True)
        return
    if fault:
        yield Fault(fault, loses=True)
    else:
        # Nothing inside it can be mended in place.
        yield from (found._replace(is_finishable=False) for found in faults_of(plain))
