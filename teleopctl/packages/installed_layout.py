"""The files of a source package where its ``setup.py`` or ``CMakeLists.txt`` installs them.

A package is used where it lies, so the folder of its files is its source folder, and mostly that is
laid out as the installed one would be. Where ``data_files`` puts files elsewhere
(``("share/arm/launch", ["bringup/up.launch.yaml"])``), or ``install`` of a ``CMakeLists.txt``
does, that folder is one of links: everything of the source folder, and the files once more where
they are installed. A file that is edited is the file that is used, as with ``colcon build
--symlink-install``.
"""

import os
import posixpath
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Any, Final

from teleopctl.errors import SystemFailureError
from teleopctl.folders import make_private, runtime_dir
from teleopctl.packages.cmake_script import installed_files
from teleopctl.packages.setup_script import setup_arguments

_FOLDER: Final = "packages"  # in the runtime folder


@lru_cache(maxsize=256)
def share_folder(name: str, folder: Path) -> Path:
    """Return the folder in which a package's files lie as they do when it is installed.

    Args:
        name: The package's name.
        folder: Its source folder.

    Raises:
        SystemFailureError: The folder of links cannot be written.
    """
    moved = _moved(name, folder, _data_files(folder))
    if not moved:
        return folder
    import hashlib

    key = hashlib.sha256(os.fsencode(folder)).hexdigest()[:16]
    view = runtime_dir() / _FOLDER / key / name
    try:
        make_private(view.parent.parent)
        _update(view, _links(folder, moved))
    except OSError as error:
        raise SystemFailureError(f"{view} cannot be written: {error}") from error
    return view


def _data_files(folder: Path) -> Any:  # Any: as it was written
    """Pairs of a folder below the install prefix and the files that are installed there."""
    for script in ("setup.py", "CMakeLists.txt"):
        try:
            text = (folder / script).read_text(encoding="utf-8", errors="replace")
        except OSError:
            continue
        if script == "setup.py" and "data_files" in text:
            return setup_arguments(text, folder).get("data_files")
        if script == "CMakeLists.txt":
            return installed_files(text, folder)
    return None


def _moved(name: str, folder: Path, data_files: Any) -> dict[str, Path]:  # Any: as it was written
    """Files that are installed elsewhere than they lie: path below the share folder → file."""
    moved = {}
    for entry in data_files if isinstance(data_files, list | tuple) else ():
        match entry:
            case (str(target), list(files) | tuple(files)):
                below = posixpath.relpath(posixpath.normpath(target), f"share/{name}")
                if below.startswith(("..", "/")):
                    continue  # the markers of the ament index, programs in lib/
                for file in files:
                    if isinstance(file, str) and (source := folder / file).is_file():
                        installed = posixpath.normpath(posixpath.join(below, source.name))
                        if Path(os.path.normpath(source)) != folder / installed:
                            moved[installed] = source.absolute()
    return moved


def _links(folder: Path, moved: dict[str, Path]) -> dict[str, Path]:
    """What the folder of links holds: path → what it is a link to.

    A folder that gets a file from elsewhere is no link itself; all that it holds is linked.
    """
    opened = {""}
    for installed in moved:
        above = posixpath.dirname(installed)
        while above:
            opened.add(above)
            above = posixpath.dirname(above)
    links = {}
    for below in opened:
        with suppress(OSError), os.scandir(folder / below) as entries:
            for entry in entries:
                path = posixpath.join(below, entry.name)
                if path not in opened and not entry.name.startswith("."):
                    links[path] = folder / path
    return links | moved


def _update(view: Path, links: dict[str, Path]) -> None:
    """Bring a folder of links up to date; what is right is not touched, as others may read it."""
    import shutil

    folders = {view, *(above for path in links for above in (view / path).parents)}
    for root, inner, files in os.walk(view):
        for entry in (Path(root, each) for each in (*inner, *files)):
            path = entry.relative_to(view).as_posix()
            if entry.is_symlink():
                if path not in links or entry.readlink() != links[path]:
                    entry.unlink()
            elif not entry.is_dir() or entry not in folders:
                shutil.rmtree(entry) if entry.is_dir() else entry.unlink()
    for path, target in links.items():
        link = view / path
        link.parent.mkdir(parents=True, exist_ok=True)
        if not link.is_symlink():
            _link(link, target)


def _link(link: Path, target: Path) -> None:
    with suppress(FileExistsError):  # another process makes the same one
        try:
            link.symlink_to(target, target_is_directory=target.is_dir())
        except FileExistsError:
            raise
        except OSError:
            # Windows allows links to administrators and developers alone
            import shutil

            shutil.copytree(target, link) if target.is_dir() else shutil.copy2(target, link)
