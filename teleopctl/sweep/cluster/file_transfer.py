"""Files between a sweep and its workers: the launch's folder there, finished runs back."""

from __future__ import annotations

import io
import os
import tarfile
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path, PurePath
from typing import NamedTuple

from teleopctl.errors import RefusedError
from teleopctl.launch import find_launch_file, is_builtin
from teleopctl.packages import enclosing_package
from teleopctl.sweep.one_run import RunRequest

# Robot descriptions with meshes take a few megabytes; a larger folder is mostly the wrong one.
_LARGEST_SENT = 64 << 20
# The result is one message of the cluster: larger bags should record less.
_LARGEST_BACK = 1 << 30
# Files that mark a folder as a bag, a sweep, or output of colcon.
_NOT_SENT = ("metadata.yaml", "sweep.json", "COLCON_IGNORE")


class SentFolder(NamedTuple):
    """Folder that is sent to Dask workers: its path, and the launch file and working folder in it.

    Attributes:
        root: Path of the folder on the sending machine; empty if no folder is sent.
        file: Path of the launch file relative to the folder, or the name of a built-in one.
        cwd: Working directory of the runs, relative to the folder.
    """

    root: str
    file: str
    cwd: str

    def for_worker(self, request: RunRequest, root: Path) -> RunRequest:
        """Return a copy of a run's request, with paths in the sent folder moved to a worker's root.

        Args:
            request: Request with paths of the sending machine.
            root: Path of the unpacked folder on the worker.
        """
        file = root / self.file if self.root else find_launch_file(None, self.file)

        def moved(values: dict[str, str]) -> dict[str, str]:
            return {name: self._moved(value, root) for name, value in values.items()}

        return replace(
            request,
            file=str(file),
            arguments=moved(request.arguments),
            parameters=moved(request.parameters),
        )

    def _moved(self, value: str, root: Path) -> str:
        if self.root and (value == self.root or value.startswith(self.root + os.sep)):
            return str(root) + value[len(self.root) :]
        return value


def pack_launch(file: Path, folder: Path | None, cwd: Path) -> tuple[SentFolder, bytes]:
    """Pack the folder of a launch file; return a `SentFolder` and the bytes of a tar archive.

    Args:
        file: Path of the launch file.
        folder: Folder to send. If None, the package that contains the launch file, else the
            file's folder, and no folder for a built-in launch file.
        cwd: Working directory of the runs.

    Returns:
        The description of the folder, and its archive; empty bytes if no folder is sent.

    Raises:
        RefusedError: The file is not in the folder, or the folder is larger than 64 MiB.
    """
    if folder is None:
        if is_builtin(file):
            return SentFolder("", file.name, ""), b""
        folder = enclosing_package(file.parent) or file.parent
    folder = folder.absolute()
    inner = str(cwd.relative_to(folder)) if cwd.is_relative_to(folder) else ""
    if is_builtin(file):
        name = str(file)
    elif file.is_relative_to(folder):
        name = str(file.relative_to(folder))
    else:
        raise RefusedError(
            f"{file} is not in {folder}, the folder that is sent",
            hint="--send names a folder with the launch file in it.",
        )
    return SentFolder(str(folder), name, inner), _packed_folder(folder)


def not_sent(values: Iterable[str], sent_folder: SentFolder, cwd: Path) -> list[str]:
    """Return the values that look like paths of existing files outside the sent folder."""
    found = []
    for value in dict.fromkeys(values):
        path = cwd / value
        # A word without separator and suffix is probably no path.
        if len(PurePath(value).parts) < 2 and not PurePath(value).suffix:
            continue
        if path.exists() and not (sent_folder.root and path.is_relative_to(sent_folder.root)):
            found.append(value)
    return found


def pack(folder: Path) -> bytes:
    """Return a finished run's folder as the bytes of a tar archive; raise RefusedError over 1 GiB.

    Raises:
        RefusedError: The folder is too large to be sent back.
    """
    files = [path for path in folder.rglob("*") if path.is_file()]
    size = sum(path.stat().st_size for path in files)
    if size > _LARGEST_BACK:
        raise RefusedError(f"{size >> 20} MB are too much to send back: record less")
    return _packed(folder, files)


def unpack(data: bytes, folder: Path) -> None:
    """Unpack the bytes of a tar archive into a folder, overwriting files."""
    with tarfile.open(fileobj=io.BytesIO(data)) as archive:
        if hasattr(tarfile, "data_filter"):
            archive.extractall(folder, filter="data")
        else:  # before Python 3.11.4
            archive.extractall(folder)  # noqa: S202 - from the machine that sends code to run


def _packed_folder(folder: Path) -> bytes:
    files: list[Path] = []
    size = 0
    for path in _sendable(folder):
        files.append(path)
        size += path.stat().st_size
        if size > _LARGEST_SENT:
            raise RefusedError(
                f"{folder} has more than {_LARGEST_SENT >> 20} MB to be sent to the workers",
                hint="Put the launch file and what it needs into a folder: --send FOLDER.",
            )
    return _packed(folder, files)


def _sendable(folder: Path) -> Iterator[Path]:
    above: dict[Path, tuple[Path, ...]] = {folder: ()}
    for here, folders, files in os.walk(folder, followlinks=True):
        # A link to a folder above it would never end.
        own = (*above.pop(Path(here)), Path(here).resolve())
        folders[:] = [
            name
            for name in folders
            if not name.startswith(".")
            and name != "__pycache__"
            and not any(Path(here, name, file).is_file() for file in _NOT_SENT)
            and Path(here, name).resolve() not in own
        ]
        above |= {Path(here, name): own for name in folders}
        yield from (path for name in files if (path := Path(here, name)).is_file())


def _packed(folder: Path, files: Iterable[Path]) -> bytes:
    packed = io.BytesIO()
    # Links are replaced by their targets.
    with tarfile.open(fileobj=packed, mode="w:gz", compresslevel=1, dereference=True) as archive:
        for path in files:
            archive.add(path, str(path.relative_to(folder)))
    return packed.getvalue()
