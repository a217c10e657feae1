"""``ament_index_python.packages``. Packages are found as everywhere in teleopctl."""

from pathlib import Path

from teleopctl.errors import NotFoundError
from teleopctl.packages import find_package, list_packages, package_share

__all__ = [
    "PackageNotFoundError",
    "get_package_prefix",
    "get_package_share_directory",
    "get_package_share_path",
    "get_packages_with_prefixes",
]


class PackageNotFoundError(KeyError):
    """No source of packages knows the name."""

    def __str__(self) -> str:
        # a KeyError would print its message with the quotes of a key
        return str(self.args[0])


def get_package_share_directory(package_name: str, print_warning: bool = True) -> str:  # noqa: ARG001 -- the original's signature
    """Return the folder that holds the files of a package.

    Raises:
        PackageNotFoundError: The package is unknown.
    """
    try:
        return str(package_share(package_name))
    except NotFoundError as error:
        raise PackageNotFoundError(error.message) from error


def get_package_share_path(package_name: str, print_warning: bool = True) -> Path:
    """Return the folder that holds the files of a package, as a path.

    Raises:
        PackageNotFoundError: The package is unknown.
    """
    return Path(get_package_share_directory(package_name, print_warning))


def get_package_prefix(package_name: str) -> str:
    """Return the folder below which a package is found.

    Packages are used where they lie and not installed, so this is its folder.

    Raises:
        PackageNotFoundError: The package is unknown.
    """
    try:
        return str(find_package(package_name).folder)
    except NotFoundError as error:
        raise PackageNotFoundError(error.message) from error


def get_packages_with_prefixes() -> dict[str, str]:
    """Return every known package with its folder."""
    return {package.name: str(package.folder) for package in list_packages()}
