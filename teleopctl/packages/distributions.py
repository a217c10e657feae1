"""Packages that installed Python distributions bring, by entry points.

Those of the group ``teleopctl.packages`` have the module as value in whose folder the package's
files lie; those of ``teleopctl.nodes`` are named ``package/executable``.
"""

from __future__ import annotations

from pathlib import Path

from teleopctl import plugins
from teleopctl.errors import BrokenPluginError
from teleopctl.packages.own import HERE, executables_of
from teleopctl.packages.records import DISTRIBUTION, Package


def distribution_names() -> set[str]:
    """Return the packages of installed Python distributions."""
    nodes = (name.rpartition("/")[0] for name in plugins.available(plugins.NODES))
    return {*plugins.available(plugins.PACKAGES), *nodes} - {""}


def distribution_package(name: str) -> Package | None:
    """Return a package of an installed Python distribution, or None.

    Raises:
        BrokenPluginError: Its files are not there.
    """
    nodes = {
        node: plugin
        for node, plugin in plugins.available(plugins.NODES).items()
        if plugin.distribution and node.rpartition("/")[0] == name
    }
    executables = executables_of(name, ((node, each.target) for node, each in nodes.items()))
    plugin = plugins.find(plugins.PACKAGES, name)
    if plugin is not None:
        folder = _module_folder(plugin.target)
        if folder is None:
            raise BrokenPluginError(
                f"package '{name}' of {plugin.distribution}: there is no module {plugin.target}"
            )
    elif executables:
        # Without an entry of its own, its files lie beside the code of its first executable.
        plugin = next(iter(nodes.values()))
        folder = _module_folder(plugin.target.partition(":")[0].partition(".")[0]) or HERE
    else:
        return None
    return Package(
        name,
        folder,
        kind=DISTRIBUTION,
        found_by=f"distribution {plugin.distribution}",
        read_executables=lambda: executables,
    )


def _module_folder(module: str) -> Path | None:
    """The folder of a package's or a module's file, found without importing anything."""
    from importlib.util import find_spec

    top, *below = module.split(".")
    spec = find_spec(top)
    if spec is None:
        return None
    if spec.submodule_search_locations:
        folder = Path(next(iter(spec.submodule_search_locations)), *below)
    else:
        folder = Path(spec.origin or "").parent
    return folder if folder.is_dir() else None
