"""ROS packages: which there are, where their files lie and which programs they offer."""

from teleopctl.packages.finding import (
    PACKAGE_PATH_VARIABLE,
    Executable,
    Package,
    find_executable,
    find_package,
    is_path,
    list_packages,
    lookup_package,
    package_share,
    resolve_uri,
)

__all__ = [
    "PACKAGE_PATH_VARIABLE",
    "Executable",
    "Package",
    "find_executable",
    "find_package",
    "is_path",
    "list_packages",
    "lookup_package",
    "package_share",
    "resolve_uri",
]
