"""Plug-ins of packages that are not installed: entry points in their sources."""

from __future__ import annotations

from teleopctl.packages.finding import known_layers
from teleopctl.packages.records import SOURCES


def find_source_plugin(group: str, name: str) -> tuple[str, str] | None:
    """Return import path and import folder of a plug-in that a package's sources declare.

    Args:
        group: Entry-point group, such as ``teleopctl.controllers``.
        name: Name of the plug-in, ``package/Class``.

    Returns:
        Import path ``module:Class`` and the folder to import it from; None if there is none.
    """
    from teleopctl.packages.source_programs import entry_points, import_root

    for package in known_layers(name.partition("/")[0]):
        if package.kind == SOURCES:
            target = entry_points(package.folder, group).get(name)
            if target is not None:
                return target, str(import_root(package.folder, target))
    return None
