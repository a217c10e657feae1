"""Packages of teleopctl itself, and those that installed Python distributions bring.

The value of an entry point in the group ``teleopctl.packages`` is the module whose folder has the
package's files; entry points in ``teleopctl.nodes`` are named ``package/executable``.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from pathlib import Path

from teleopctl import plugins
from teleopctl.errors import BrokenPluginError
from teleopctl.packages.own_packages import (
    DATA_PACKAGES,
    HERE,
    Manifest,
    is_own,
    share_path,
)
from teleopctl.packages.records import DISTRIBUTION, Package, PackageProgram


def has_files(name: str) -> bool:
    """Return whether a built-in package has files, not only programs."""
    return name in DATA_PACKAGES


def builtin_package(name: str) -> Package | None:
    """Return teleopctl's built-in package of this name, or None."""
    if not is_own(name):
        return None
    programs = executables_of(name, plugins.NODES.builtin.items())
    return Package(name, share_path(name), read_executables=lambda: programs)


def executables_of(package: str, nodes: Iterable[tuple[str, str]]) -> dict[str, PackageProgram]:
    """Return one package's programs by name, from pairs of ``package/executable`` and target."""
    split = ((name.rpartition("/"), target) for name, target in nodes)
    return {
        name: PackageProgram(name=name, package=package, target=target)
        for (owner, _, name), target in split
        if owner == package
    }


def distribution_names() -> set[str]:
    """Return the names of packages that Python distributions register, teleopctl's included."""
    nodes = (name.rpartition("/")[0] for name in plugins.available(plugins.NODES))
    return {*plugins.available(plugins.PACKAGES), *nodes} - {""}


def distribution_package(name: str) -> Package | None:
    """Return the package of this name that an installed distribution brings, or None.

    Raises:
        BrokenPluginError: The module with the package's files does not exist.
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
        # Without its own entry point, the package's files are beside its first executable's code.
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
        make_manifest=partial(_manifest, name, plugin.distribution),
    )


def _manifest(name: str, distribution: str) -> str:
    """Return a ``package.xml`` made from a distribution's metadata."""
    from importlib.metadata import metadata

    known = {key: str(value) for key, value in metadata(distribution).json.items()}
    return Manifest(
        name,
        known["version"],
        known.get("summary", f"{name}, of the distribution {distribution}"),
        known.get("license_expression") or known.get("license", "unknown"),
        known.get("author") or known.get("maintainer", "unknown"),
        known.get("author_email") or known.get("maintainer_email", "unknown@example.com"),
    ).xml()


def _module_folder(module: str) -> Path | None:
    """Return the folder of a Python package or module, found without importing it; or None."""
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
