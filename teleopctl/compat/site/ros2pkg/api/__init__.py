"""``ros2pkg.api``. Packages and their programs."""

import os
from pathlib import Path

from ament_index_python import (
    PackageNotFoundError,
    get_package_prefix,
    get_packages_with_prefixes,
)

__all__ = [
    "PackageNotFound",
    "get_executable_paths",
    "get_package_names",
    "get_prefix_path",
    "package_name_completer",
]


class PackageNotFound(Exception):
    """A package is not found.

    Args:
        package_name: Name of the package.
    """

    def __init__(self, package_name: str) -> None:
        super().__init__(package_name)
        self.package_name = package_name


def get_package_names() -> list[str]:
    """Return the names of all packages."""
    return list(get_packages_with_prefixes())


def get_prefix_path(package_name: str) -> str | None:
    """Return the prefix of a package; None if there is none."""
    try:
        return get_package_prefix(package_name)
    except PackageNotFoundError:
        return None


def get_executable_paths(*, package_name: str) -> list[str]:
    """Return the paths of a package's programs in ``lib/``.

    Raises:
        PackageNotFound: There is no such package.
    """
    prefix = get_prefix_path(package_name)
    if prefix is None:
        raise PackageNotFound(package_name)
    folder = Path(prefix, "lib", package_name)
    if not folder.is_dir():
        return []
    files = (file for file in sorted(folder.iterdir()) if file.is_file())
    return [str(file) for file in files if os.access(file, os.X_OK)]


def package_name_completer(**_: object) -> list[str]:
    """Return the names of all packages."""
    return get_package_names()
