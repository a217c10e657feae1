"""Catalog of type definitions: built-in ones and those of packages, found by name."""

from __future__ import annotations

import os
from _thread import RLock

from teleopctl.base.typed import TYPE_CHECKING, Iterable, Iterator
from teleopctl.errors import InvalidMessageError
from teleopctl.interfaces.definition import Definition
from teleopctl.interfaces.standard import StandardTypes, distribution
from teleopctl.interfaces.typenames import KINDS, normalize, split

if TYPE_CHECKING:
    from pathlib import Path

# Definitions are read by path strings: the import of pathlib takes longer than reading one.
_BUILT_IN = os.path.join(os.path.dirname(__file__), "definitions")

# Folders of definitions that changed after Jazzy, by distribution that has the changes.
_CHANGED = {
    "kilted": [os.path.join(_BUILT_IN, "_kilted")],
    "lyrical": [os.path.join(_BUILT_IN, "_lyrical"), os.path.join(_BUILT_IN, "_kilted")],
}


class Catalog:
    """Parsed definitions of message, service and action types, found by type name.

    Order of lookup: definitions added by the methods, rosbags' table of the distribution, the
    definition files of teleopctl, and the user's ROS packages. A lookup reads only the definition
    file of the type.

    Args:
        distribution_name: Name of the ROS 2 distribution; None for that of the environment.
        cached: Whether to use the user's cache folder.
    """

    def __init__(self, distribution_name: str | None = None, *, cached: bool = True) -> None:
        self.distribution = distribution_name or distribution()
        self._standard = StandardTypes(self.distribution, cached=cached)
        self._built_in = [*_CHANGED.get(self.distribution, ()), _BUILT_IN]
        self._definitions: dict[str, Definition] = {}
        self._used: set[str] = set()
        # Paths of definitions that were read from files, by type name.
        self._files: dict[str, str] = {}
        self._folders: dict[str, str | None] = {}
        self._lock = RLock()

    def find(self, type_name: str) -> Definition | None:
        """Return a type's `Definition`, read on first use, or None; mark the type as in use.

        Types derived from a service or action are found too.

        Raises:
            TeleopctlError: The definition exists, but cannot be parsed.
        """
        with self._lock:
            found = self._definitions.get(type_name) or self._load(type_name)
            if found is not None:
                self._used.add(type_name)
            return found

    def add_text(self, type_name: str, text: str, where: str | None = None) -> None:
        """Add a type, with its derived types, by the text of its definition file.

        Args:
            type_name: Full name of the type, ``package/kind/Name``.
            text: Content of the definition file.
            where: Name of the text in error messages; the type's name by default.

        Raises:
            TeleopctlError: The text cannot be parsed, or the type is in use with another
                definition.
        """
        from teleopctl.interfaces.services import split_definition

        self.add(split_definition(text, type_name, where))

    def add(self, definitions: Iterable[Definition]) -> None:
        """Add or replace definitions; raise if a type in use would get other fields or constants.

        Raises:
            InvalidMessageError: A type is in use with another definition.
        """
        with self._lock:
            for definition in definitions:
                name = definition.type_name
                known = self._definitions.get(name)
                if known is None and name in self._used:
                    known = self.find(name)
                if known is not None and name in self._used and not _same(known, definition):
                    raise InvalidMessageError(
                        f"{name} is already in use with another definition",
                        hint="Add definitions before anything uses the type.",
                    )
                if known is None or not _same(known, definition):
                    self._definitions[name] = definition

    def add_folder(self, folder: str | Path, package: str) -> list[str]:
        """Add the types in a package's ``msg``, ``srv``, ``action`` folders; return their names.

        Args:
            folder: Folder that contains ``msg``, ``srv`` or ``action``.
            package: Name of the package.

        Returns:
            Full names of the package's types.

        Raises:
            InvalidMessageError: The folder has no definition, or a definition cannot be parsed.
        """
        files = dict(_files(str(folder), package))
        if not files:
            raise InvalidMessageError(
                f"{folder} has no interface definitions",
                hint="Expected msg/Name.msg, srv/Name.srv and action/Name.action, or Name.idl in "
                "these folders.",
            )
        for name, path in files.items():
            definitions = _definitions(name, path)
            self.add(definitions)
            self._files.update((definition.type_name, path) for definition in definitions)
        return list(files)

    def names(self, kind: str | None = None) -> list[str]:
        """Return the sorted names of the known types without derived ones, optionally of a kind."""
        with self._lock:
            names = {name for name in self._definitions if "_" not in split(name)[2]}
            names.update(self.built_in_names(), self.user_names())
        return sorted(name for name in names if kind is None or split(name)[1] == kind)

    def built_in_names(self) -> list[str]:
        """Return the sorted names of the types that come with rosbags and teleopctl.

        These are the same on every machine.
        """
        packages = [name for name in os.listdir(_BUILT_IN) if not name.startswith("_")]
        ours = (_files(os.path.join(_BUILT_IN, name), name) for name in packages)
        return sorted({*self._standard.names(), *(name for files in ours for name, _ in files)})

    def folder_of_files(self, type_names: list[str]) -> str | None:
        """Return the folder with the definition files of built-in types; None if there is no one.

        Args:
            type_names: Names of all built-in types of a package and kind.
        """
        package, kind, _ = split(type_names[0])
        folder = os.path.join(_BUILT_IN, package, kind)
        files = [f"{split(name)[2]}.{kind}" for name in type_names]
        changed = any(os.path.isdir(os.path.join(f, package)) for f in self._built_in[:-1])
        if changed or not os.path.isdir(folder) or sorted(files) != sorted(os.listdir(folder)):
            return None
        return folder

    def user_names(self) -> list[str]:
        """Return the sorted names of the types in the interface folders of found ROS packages."""
        from teleopctl.packages import list_packages

        # teleopctl's own packages have the built-in types.
        found = [package for package in list_packages() if package.kind != "own"]
        return sorted(name for each in found for name in _user_files(str(each.folder), each.name))

    def package_names(self, package: str, kind: str | None = None) -> list[str]:
        """Return the sorted names of a package's types of a kind, or all; empty if unknown.

        The user's packages are searched only if no other source has the package, or its
        definitions of that kind.
        """
        start = f"{package}/" if kind is None else f"{package}/{kind}/"
        with self._lock:
            names = {name for name in self._standard.names() if name.startswith(start)}
            built_in = _files(os.path.join(_BUILT_IN, package), package)
            names.update(name for name, _ in built_in if name.startswith(start))
            loaded = {
                name
                for name in self._definitions
                if name.startswith(start) and "_" not in split(name)[2]
            }
            # Single types read from the user's files: the package may have more types.
            is_known = names or any(name not in self._files for name in loaded)
            names.update(loaded)
            if not is_known and (folder := self._folder(package)) is not None:
                names.update(n for n in _user_files(folder, package) if n.startswith(start))
        return sorted(names)

    def parts(self, type_name: str) -> list[str]:
        """Return the names of a type and of the types derived from it; empty if unknown."""
        with self._lock:
            if self.find(type_name) is None:
                return []
            derived = f"{type_name}_"
            return [n for n in self._definitions if n == type_name or n.startswith(derived)]

    def place_of_use(self, type_name: str) -> str | None:
        """Return ``file:line`` of a field of a type in a file read so far, or None."""
        from teleopctl.interfaces.parser import line_of_first_field

        with self._lock:
            for user, path in self._files.items():
                if type_name in self._definitions[user].nested_types():
                    return f"{path}:{line_of_first_field(_read(path), type_name, split(user)[0])}"
        return None

    def file(self, type_name: str) -> Path | None:
        """Return the path of the file that defines a type; None if unknown or without a file."""
        from pathlib import Path

        with self._lock:
            self.find(type_name)
            path = self._files.get(type_name)
        return None if path is None else Path(path)

    def _load(self, type_name: str) -> Definition | None:
        if (standard := self._standard.find(type_name)) is not None:
            self._definitions[type_name] = standard
            return standard
        package, kind, name = split(normalize(type_name))
        stem = name if kind == "msg" else name.split("_", 1)[0]
        path = self._file(package, kind, stem)
        if path is None:
            return None
        for definition in _definitions(f"{package}/{kind}/{stem}", path):
            self._definitions.setdefault(definition.type_name, definition)
            self._files[definition.type_name] = path
        return self._definitions.get(type_name)

    def _file(self, package: str, kind: str, stem: str) -> str | None:
        for folder in self._built_in:
            if os.path.isfile(path := os.path.join(folder, package, kind, f"{stem}.{kind}")):
                return path
        if (users := self._folder(package)) is None:
            return None
        # A build generates an .idl file from each .msg, .srv and .action file.
        for ending in (kind, "idl"):
            if os.path.isfile(path := os.path.join(users, kind, f"{stem}.{ending}")):
                return path
        return _user_files(users, package).get(f"{package}/{kind}/{stem}")

    def _folder(self, package: str) -> str | None:
        """Return the folder of a ROS package of the user, or None; searched once per package."""
        if package not in self._folders:
            from teleopctl.packages import lookup_package

            # Set first: package lookup may import modules, whose import may call this method again.
            self._folders[package] = None
            found = lookup_package(package)
            self._folders[package] = None if found is None else str(found.folder)
        return self._folders[package]


def _user_files(folder: str, package: str) -> dict[str, str]:
    """Return the definition files of a package by type name, also those that a script names."""
    from pathlib import Path

    from teleopctl.packages import interfaces_elsewhere

    files = dict(_files(folder, package))
    for installed, path in interfaces_elsewhere(package, Path(folder)).items():
        files.setdefault(f"{package}/{os.path.splitext(installed)[0]}", str(path))
    return files


def _files(folder: str, package: str) -> Iterator[tuple[str, str]]:
    for kind in KINDS:
        place = os.path.join(folder, kind)
        names = sorted(os.listdir(place)) if os.path.isdir(place) else []
        for name in names:
            stem, _, ending = name.rpartition(".")
            path = os.path.join(place, name)
            if ending in (kind, "idl") and os.path.isfile(path):
                if ending == "idl" and f"{stem}.{kind}" in names:
                    continue  # generated by a build from the other file
                yield f"{package}/{kind}/{stem}", path


def _definitions(type_name: str, path: str) -> list[Definition]:
    if path.endswith(".idl"):
        from teleopctl.interfaces.foreign.idl import split_idl

        return split_idl(_read(path), type_name, path)
    from teleopctl.interfaces.services import split_definition

    return split_definition(_read(path), type_name, path)


def _read(path: str) -> str:
    try:
        with open(path, encoding="utf-8") as file:
            return file.read()
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidMessageError(f"{path} cannot be read: {error}") from error


def _same(one: Definition, other: Definition) -> bool:
    return one.fields == other.fields and one.constants == other.constants
