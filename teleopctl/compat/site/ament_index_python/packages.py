"""``ament_index_python.packages``. Packages are found as everywhere in teleopctl."""

import os
import re
import warnings
from pathlib import Path

from ament_index_python.resources import get_resource, get_resources
from teleopctl.errors import NotFoundError
from teleopctl.packages import find_package, search_paths

__all__ = [
    "PackageNotFoundError",
    "get_package_prefix",
    "get_package_share_directory",
    "get_package_share_path",
    "get_packages_with_prefixes",
]

_NAME = re.compile("[a-zA-Z0-9][a-zA-Z0-9_-]+", re.ASCII)  # as REP 127 has it


class PackageNotFoundError(KeyError):
    """Raised when no package of a name is found."""

    def __str__(self) -> str:
        # a KeyError would print its message with the quotes of a key
        return str(self.args[0])


def get_packages_with_prefixes() -> dict[str, str]:
    """Return the names of all packages, with their prefixes."""
    return get_resources("packages")


def get_package_prefix(package_name: str) -> str:
    """Return the folder with a package's ``share/NAME`` and ``lib/NAME``.

    Of a package that is used where it lies, that is a folder of links.

    Raises:
        PackageNotFoundError: The package is unknown.
        ValueError: That is no name of a package.
    """
    _check(package_name)
    try:
        return get_resource("packages", package_name)[1]
    except LookupError as error:
        raise _not_found(package_name) from error


def get_package_share_directory(package_name: str, print_warning: bool = True) -> str:
    """Return the folder that holds the files of a package.

    Args:
        package_name: The package.
        print_warning: Whether to warn where that folder does not exist.

    Raises:
        PackageNotFoundError: The package is unknown.
        ValueError: That is no name of a package.
    """
    return str(_share(package_name, print_warning))


def get_package_share_path(package_name: str, print_warning: bool = True) -> Path:
    """Return the folder that holds the files of a package, as a path.

    See `get_package_share_directory`.
    """
    return _share(package_name, print_warning)


def _share(name: str, print_warning: bool) -> Path:
    _check(name)
    try:
        share = find_package(name).share
    except NotFoundError as error:
        raise _not_found(name) from error
    if print_warning and not share.exists():
        warnings.warn(f"Share directory for {name} ({share}) does not exist.", stacklevel=3)
    return share


def _check(name: str) -> None:
    if _NAME.fullmatch(name) is None:
        raise ValueError(f"'{name}' is not a valid package name")


def _not_found(name: str) -> PackageNotFoundError:
    return PackageNotFoundError(f"package '{name}' not found, searching: {_searched()}")


def _searched() -> list[str]:
    return [*search_paths(), os.getcwd()]  # noqa: PTH109
