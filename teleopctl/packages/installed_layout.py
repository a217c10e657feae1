"""Folders of links that lay a source package out as if it were installed.

A source package is used in place, so its share folder is its source folder, whose layout usually is
that of the installed package. If ``data_files`` installs files elsewhere
(``("share/arm/launch", ["bringup/up.launch.yaml"])``), or ``install`` of a ``CMakeLists.txt`` does,
the share folder is a folder of links: to everything in the source folder, and to the installed
files at their installed paths. Edits of a source file take effect at once, as with ``colcon build
--symlink-install``.

The install prefix, for ``ros2 pkg prefix`` or Gazebo's launch files, is a folder with
``share/NAME``, ``lib/NAME`` with a script for each program of the package, the other installed
files and the marker of the ament index, so that the folder also works in ``AMENT_PREFIX_PATH``.
"""

from __future__ import annotations

import os
import posixpath
import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from functools import lru_cache
from pathlib import Path

from teleopctl.base.folders import make_private, runtime_dir
from teleopctl.base.typed import Any, Final
from teleopctl.errors import SystemFailureError
from teleopctl.packages.source_folders import text_of

_SCRIPTS: Final = ("setup.py", "CMakeLists.txt")
_INTERFACE: Final = r"(msg|srv|action)/\w+\.(?:\1|idl)"
_FOLDER: Final = "packages"  # in the runtime folder
INDEX: Final = "share/ament_index/resource_index"
RUN_DEPENDENCIES: Final = "package_run_dependencies"
"""Type of the resources that list what a package needs when it runs, with ``;`` between."""
PLUGIN_RESOURCE: Final = "__pluginlib__plugin"
"""Ending of the resource types that name plug-in descriptions, after the package of the base."""
_DEPENDENCY: Final = re.compile(r"<(?:depend|exec_depend|run_depend)\b[^>]*>\s*([\w-]+)\s*<")
_PLUGINS: Final = re.compile(
    r"^[ \t]*pluginlib_export_plugin_description_file\(\s*(\w+)\s+\"?([\w./-]+)\"?\s*\)",
    re.MULTILINE,
)


@lru_cache(maxsize=256)
def share_folder(name: str, folder: Path) -> Path:
    """Return a source package's share folder: its source folder, or links laid out as installed.

    Args:
        name: Name of the package.
        folder: Source folder of the package.

    Raises:
        SystemFailureError: The folder of links cannot be written.
    """
    moved = _moved(name, folder, _installed_files(folder))
    if not moved:
        return folder
    view = _view(folder) / name
    _update(view, _links(folder, moved))
    return view


@lru_cache(maxsize=256)
def prefix_folder(
    name: str,
    folder: Path,
    share: Path,
    programs: tuple[str, ...],
    *,
    is_source: bool,
    manifest: str = "",
) -> Path:
    """Write and return a folder of links like the install prefix of a package not installed.

    Args:
        name: Name of the package.
        folder: Folder of the package's files.
        share: Share folder of the package, laid out as installed.
        programs: Names of the package's programs.
        is_source: Whether it is a source package, whose programs need ``TELEOPCTL_PACKAGE_PATH``.
        manifest: Text of a ``package.xml`` for a share folder without one.

    Raises:
        SystemFailureError: The folder cannot be written.
    """
    source = folder if is_source else None
    entries: dict[str, Path | str] = {
        f"lib/{name}/{program}": starter(name, program, source) for program in programs
    }
    if manifest:
        entries[f"share/{name}/package.xml"] = manifest
        for entry in share.iterdir():
            entries[f"share/{name}/{entry.name}"] = entry
    else:
        entries[f"share/{name}"] = share
    entries[f"{INDEX}/packages/{name}"] = ""
    if source is not None:
        entries |= {f"{INDEX}/{path}": content for path, content in resources(name, source).items()}
        entries |= {path: file for path, file in _beside_share(name, source) if path not in entries}
    prefix = _view(folder) / f"{name}.prefix"
    _update(prefix, entries)
    return prefix


@lru_cache(maxsize=2048)
def resources(name: str, folder: Path) -> dict[str, Path | str]:
    """Return the resources for the ament index that a source package declares.

    These are the files that its scripts install there, the list of its interfaces, its run
    dependencies and its plug-in descriptions; without the marker of the package itself.

    Args:
        name: Name of the package.
        folder: Source folder of the package.

    Returns:
        File or text of each resource by ``type/name``.
    """
    found: dict[str, Path | str] = {}
    if any("resource_index" in (text_of(folder / script) or "") for script in _SCRIPTS):
        for path, file in _installed_files(folder):
            resource = posixpath.relpath(posixpath.normpath(path), INDEX)
            if not resource.startswith(("..", "packages/")) and (folder / file).is_file():
                found[resource] = folder / file
    interfaces = {
        f"{kind}/{file.name}"
        for kind in ("action", "msg", "srv")
        if (folder / kind).is_dir()
        for file in (folder / kind).iterdir()
        if file.suffix in (f".{kind}", ".idl")
    }
    interfaces.update(interfaces_elsewhere(name, folder))
    if interfaces:
        found[f"rosidl_interfaces/{name}"] = "\n".join(sorted(interfaces))
    for category, file in _PLUGINS.findall(text_of(folder / "CMakeLists.txt") or ""):
        found[f"{category}{PLUGIN_RESOURCE}/{name}"] = f"share/{name}/{file}\n"
    manifest = text_of(folder / "package.xml") or ""
    found[f"{RUN_DEPENDENCIES}/{name}"] = ";".join(dict.fromkeys(run_dependencies(manifest)))
    return found


def run_dependencies(manifest: str) -> list[str]:
    """Return the names in the tags ``depend``, ``exec_depend`` and ``run_depend``.

    Args:
        manifest: Text of a ``package.xml``.
    """
    return _DEPENDENCY.findall(manifest)


@lru_cache(maxsize=2048)
def interfaces_elsewhere(name: str, folder: Path) -> dict[str, Path]:
    """Return the definition files of a source package that are not in ``msg`` and so on.

    A ``CMakeLists.txt`` may name files anywhere, such as ``srvs/Pause.srv``.

    Args:
        name: Name of the package.
        folder: Source folder of the package.

    Returns:
        File of each interface by its installed path below the share folder, ``srv/Pause.srv``.
    """
    text = text_of(folder / "CMakeLists.txt")
    if text is None or "rosidl_generate_interfaces" not in text:
        return {}
    from teleopctl.packages.cmake_script import installation

    moved = _moved(name, folder, installation(text, folder).files)
    return {path: file for path, file in moved.items() if re.fullmatch(_INTERFACE, path)}


def linked_module(name: str, folder: Path, module: Path) -> Path:
    """Write and return a folder of links to import a module whose folder has another name.

    Args:
        name: Name of the module.
        folder: Source folder of the package.
        module: Folder of the module's files, which has another name.

    Raises:
        SystemFailureError: The folder cannot be written.
    """
    root = _view(folder) / f"{name}.modules"
    _update(root, {name: module})
    return root


def starter(package: str, program: str, source: Path | None) -> str:
    """Return a shell script that runs a program of a package from any working directory.

    The script puts the source folder, if given, on ``TELEOPCTL_PACKAGE_PATH``.
    """
    from shlex import join

    command = join([sys.executable, "-P", "-m", "teleopctl.nodes", package, program])
    lines = ["#!/bin/sh", f'exec {command} "$@"', ""]
    if source is not None:
        named = join([str(source)])
        variable = "TELEOPCTL_PACKAGE_PATH"
        lines[1:1] = [f'{variable}={named}"${{{variable}:+:${variable}}}"', f"export {variable}"]
    return "\n".join(lines)


def _view(folder: Path) -> Path:
    import hashlib

    return runtime_dir() / _FOLDER / hashlib.sha256(os.fsencode(folder)).hexdigest()[:16]


def _installed_files(folder: Path) -> Iterable[tuple[str, str]]:
    """Return pairs of a path below the install prefix and a path below the package's folder."""
    text = text_of(folder / "setup.py")
    # The readers of build scripts are imported for packages that are used from their sources only.
    if text is not None and "data_files" in text:
        from teleopctl.packages.setup_script import setup_arguments

        return _of_data_files(setup_arguments(text, folder).get("data_files"))
    text = text_of(folder / "CMakeLists.txt")
    if text is None:
        return []
    from teleopctl.packages.cmake_script import installation

    return installation(text, folder).files


def _of_data_files(data_files: Any) -> Iterator[tuple[str, str]]:  # Any: as it was written
    for entry in data_files if isinstance(data_files, list | tuple) else ():
        match entry:
            case (str(target), list(files) | tuple(files)):
                for file in files:
                    if isinstance(file, str):
                        yield posixpath.join(target, posixpath.basename(file)), file


def _moved(name: str, folder: Path, installed: Iterable[tuple[str, str]]) -> dict[str, Path]:
    """Return the files with another path below the share folder than in the source: path → file."""
    moved = {}
    for path, file in installed:
        below = posixpath.relpath(posixpath.normpath(path), f"share/{name}")
        if below.startswith(("..", "/")):
            continue  # the markers of the ament index, programs in lib/
        source = Path(os.path.normpath(folder / file))
        if source != folder / below and source.is_file():
            moved[below] = source.absolute()
    return moved


def _beside_share(name: str, folder: Path) -> Iterator[tuple[str, Path]]:
    """Yield the installed files outside of the share folder: path below the prefix, and file."""
    for path, file in _installed_files(folder):
        below = posixpath.normpath(path)
        source = Path(os.path.normpath(folder / file))
        is_below = not below.startswith(("..", "/", f"share/{name}/"))
        if is_below and source.is_file():
            yield below, source.absolute()


def _links(folder: Path, moved: dict[str, Path]) -> dict[str, Path]:
    """Return the content of the folder of links, as path → target of the link.

    A subfolder with files from elsewhere is a real folder; each entry in it is a link.
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


def _update(view: Path, entries: Mapping[str, Path | str]) -> None:
    """Update a folder; correct entries stay untouched, since other processes may read them.

    Args:
        view: Folder to update.
        entries: Entries of the folder, by path: the target of a link, or the text of a file.

    Raises:
        SystemFailureError: The folder cannot be written.
    """
    import shutil

    folders = {view, *(above for path in entries for above in (view / path).parents)}
    try:
        make_private(runtime_dir() / _FOLDER)
        for root, inner, files in os.walk(view):
            for entry in (Path(root, each) for each in (*inner, *files)):
                wanted = entries.get(entry.relative_to(view).as_posix())
                if entry.is_symlink():
                    if wanted is None or entry.readlink() != wanted:
                        entry.unlink()
                elif entry.is_dir():
                    if entry not in folders:
                        shutil.rmtree(entry)
                elif not isinstance(wanted, str) or text_of(entry) != wanted:
                    entry.unlink()
        for path, content in entries.items():
            place = view / path
            place.parent.mkdir(parents=True, exist_ok=True)
            if isinstance(content, str):
                _write(place, content)
            elif not place.is_symlink():
                link(place, content)
    except OSError as error:
        raise SystemFailureError(f"{view} cannot be written: {error}") from error


def _write(place: Path, text: str) -> None:
    """Write an executable file atomically, since another process may be about to run it."""
    if place.is_file():
        return
    draft = runtime_dir() / _FOLDER / f".{os.getpid()}"
    draft.write_text(text, encoding="utf-8")
    draft.chmod(0o700)
    draft.replace(place)


def link(place: Path, target: Path) -> None:
    """Create a link unless it exists; on a system without links, a copy."""
    with suppress(FileExistsError):  # another process creates the same link
        try:
            place.symlink_to(target, target_is_directory=target.is_dir())
        except FileExistsError:
            raise
        except OSError:
            # Windows allows links only for administrators and in developer mode
            import shutil

            shutil.copytree(target, place) if target.is_dir() else shutil.copy2(target, place)
