"""ROS packages: which there are, where their files lie and which programs they offer."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.packages.finding import (
        PACKAGE_PATH_VARIABLE as PACKAGE_PATH_VARIABLE,
        Executable as Executable,
        Package as Package,
        builtin_package as builtin_package,
        faults_of_search as faults_of_search,
        find_executable as find_executable,
        find_package as find_package,
        include_package_of as include_package_of,
        is_path as is_path,
        list_packages as list_packages,
        lookup_package as lookup_package,
        package_layers as package_layers,
        package_share as package_share,
        resolve_uri as resolve_uri,
    )
else:
    from teleopctl.lazy import attach

    __getattr__, __dir__, __all__ = attach(
        __name__,
        {
            "finding": "PACKAGE_PATH_VARIABLE Executable Package builtin_package faults_of_search "
            "find_executable find_package include_package_of is_path list_packages "
            "lookup_package package_layers package_share resolve_uri",
        },
    )
