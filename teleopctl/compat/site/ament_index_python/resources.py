"""``ament_index_python.resources``: the markers that installed packages leave.

Those of the type ``packages`` are of every package that teleopctl finds, installed or not. Those
of other types are below the prefixes of ``AMENT_PREFIX_PATH``, one of which has teleopctl's own
packages, or declared by the sources of a workspace.
"""

from pathlib import Path
from typing import Literal

from ament_index_python.constants import RESOURCE_INDEX_SUBFOLDER
from ament_index_python.search_paths import get_search_paths
from teleopctl.errors import TeleopctlError
from teleopctl.packages import list_packages, lookup_package, source_resources

__all__ = [
    "InvalidResourceNameError",
    "InvalidResourceTypeNameError",
    "get_resource",
    "get_resource_types",
    "get_resources",
    "has_resource",
]

_PACKAGES = "packages"


class InvalidResourceTypeNameError(ValueError):
    """Raised when the name of a resource type contains a path separator."""


class InvalidResourceNameError(ValueError):
    """Raised when the name of a resource contains a path separator."""


def get_resource(resource_type: str, resource_name: str) -> tuple[str, str]:
    """Return the text of a resource's marker, and the prefix below which it lies.

    Raises:
        LookupError: There is no such resource.
        InvalidResourceTypeNameError: The type is no name.
        InvalidResourceNameError: The name is none.
        OSError: The marker cannot be read, or the process has removed ``AMENT_PREFIX_PATH``.
    """
    prefix = has_resource(resource_type, resource_name)
    if prefix is False:
        raise LookupError(
            f"Could not find the resource '{resource_name}' of type '{resource_type}'"
        )
    marker = _index(prefix) / resource_type / resource_name
    try:
        return marker.read_text(), prefix
    except OSError as error:
        raise OSError(
            f"Could not open the resource '{resource_name}' of type '{resource_type}':\n{error}"
        ) from error


def get_resources(resource_type: str) -> dict[str, str]:
    """Return the names of the resources of a type, with the prefix of each.

    Raises:
        InvalidResourceTypeNameError: The type is no name.
    """
    _check_type(resource_type)
    if resource_type == _PACKAGES:
        return {package.name: str(package.prefix) for package in list_packages()}
    found: dict[str, str] = {}
    for prefix in get_search_paths():
        for name in _names(_index(prefix) / resource_type, of_folders=False):
            found.setdefault(name, prefix)
    for name, package in source_resources(resource_type).items():
        found.setdefault(name, str(package.prefix))
    return found


def get_resource_types() -> set[str]:
    """Return the types of which there are resources."""
    found = (_names(_index(prefix), of_folders=True) for prefix in get_search_paths())
    return {name for names in found for name in names}


def has_resource(resource_type: str, resource_name: str) -> str | Literal[False]:
    """Return the prefix below which a resource lies, or False.

    Raises:
        InvalidResourceTypeNameError: The type is no name.
        InvalidResourceNameError: The name is none.
    """
    _check_type(resource_type)
    assert resource_name, "The resource name must not be empty"
    if _has_separator(resource_name):
        raise InvalidResourceNameError(f"Resource name '{resource_name}' is invalid")
    if resource_type == _PACKAGES:
        return _prefix_of_package(resource_name)
    for prefix in get_search_paths():
        if (_index(prefix) / resource_type / resource_name).is_file():
            return prefix
    package = source_resources(resource_type).get(resource_name)
    return False if package is None else str(package.prefix)


def _prefix_of_package(name: str) -> str | Literal[False]:
    try:
        package = lookup_package(name)
    except TeleopctlError:  # a distribution without the files that it promises
        return False
    return False if package is None else str(package.prefix)


def _check_type(resource_type: str) -> None:
    assert resource_type, "The resource type must not be empty"
    if _has_separator(resource_type):
        raise InvalidResourceTypeNameError(f"Resource type '{resource_type}' is invalid")


def _has_separator(name: str) -> bool:
    return "/" in name or "\\" in name


def _index(prefix: str) -> Path:
    return Path(prefix, RESOURCE_INDEX_SUBFOLDER)


def _names(folder: Path, *, of_folders: bool) -> list[str]:
    if not folder.is_dir():
        return []
    entries = (entry for entry in folder.iterdir() if not entry.name.startswith("."))
    return [entry.name for entry in entries if entry.is_dir() is of_folders]
