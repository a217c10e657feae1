"""Output folder of an export: creation, clean-up after an error, and file names of topics."""

from __future__ import annotations

import contextlib
import re
import shutil
from collections.abc import Collection, Iterable, Iterator
from pathlib import Path

from teleopctl.errors import RefusedError, SystemFailureError

_OTHER = re.compile(r"[^A-Za-z0-9_~-]")
_LONGEST = 150


def make_output_folder(folder: Path) -> None:
    """Create the output folder of an export; raise if it exists and is not empty.

    Raises:
        RefusedError: The folder is not empty.
        SystemFailureError: The folder cannot be created.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        is_empty = next(folder.iterdir(), None) is None
    except OSError as error:
        raise SystemFailureError(f"Cannot write to {folder}: {error.strerror}") from error
    if not is_empty:
        raise RefusedError(
            f"Output folder '{folder}' already exists.", hint="Name another one with -o."
        )


@contextlib.contextmanager
def removed_on_error(paths: Collection[Path]) -> Iterator[None]:
    """Return a context manager that removes files and folders if its block fails.

    An incomplete table would be readable, and look like a complete one.

    Args:
        paths: Files, and folders to remove with their content. The block may add paths.
    """
    try:
        yield
    except BaseException:
        for path in paths:
            if path.is_dir():
                shutil.rmtree(path, ignore_errors=True)
            else:
                with contextlib.suppress(OSError):
                    path.unlink()
        raise


def file_stems(topics: Iterable[str]) -> dict[str, str]:
    """Return a unique file name without suffix for each topic, by topic name.

    ``/arm/joint_states`` becomes ``arm__joint_states``. Names of ROS 2 have no two underscores in a
    row, so that different valid names stay different; invalid names, and names that differ in case
    only, get a number as suffix if necessary.
    """
    stems: dict[str, str] = {}
    taken: set[str] = set()
    for topic in topics:
        plain = _OTHER.sub("_", topic.strip("/").replace("/", "__"))[:_LONGEST] or "_"
        stem, number = plain, 2
        while stem.lower() in taken:
            stem, number = f"{plain}_{number}", number + 1
        taken.add(stem.lower())
        stems[topic] = stem
    return stems
