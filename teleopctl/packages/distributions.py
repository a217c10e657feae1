"""Packages of teleopctl itself, and those that installed Python distributions bring.

The value of an entry point in the group ``teleopctl.packages`` is the module whose folder has the
package's files; entry points in ``teleopctl.nodes`` are named ``package/executable``.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Final

from teleopctl import plugins
from teleopctl.errors import BrokenPluginError
from teleopctl.packages.records import DISTRIBUTION, Package, PackageProgram

HERE: Final = Path(__file__).resolve().parents[1]

# Packages with files: name → folder in a source checkout; in a wheel, all folders are below share/.
_DATA_PACKAGES: Final = {
    "teleop_description": "robot",
    "teleop_controller": "config",
    **{
        name: f"teleopctl/share/{name}"
        for name in (
            *("demo_nodes_cpp", "demo_nodes_py", "gazebo_ros", "ros_gz_bridge", "ros_gz_sim"),
            *("ros_ign_gazebo", "teleop_twist_joy", "teleopctl", "turtlesim", "urdf_launch"),
            "urdf_tutorial",
        )
    },
}


def own_names() -> set[str]:
    """Return the names of teleopctl's built-in packages."""
    return {*_DATA_PACKAGES, *(name.rpartition("/")[0] for name in plugins.NODES.builtin)}


def has_files(name: str) -> bool:
    """Return whether a built-in package has files, not only programs."""
    return name in _DATA_PACKAGES


def builtin_package(name: str) -> Package | None:
    """Return teleopctl's built-in package of this name, or None."""
    programs = executables_of(name, plugins.NODES.builtin.items())
    folder = HERE
    if name in _DATA_PACKAGES:
        folder = HERE / "share" / name
        if not folder.is_dir():
            folder = HERE.parent / _DATA_PACKAGES[name]
    elif not programs:
        return None
    return Package(name, folder, read_executables=lambda: programs)


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
    )


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
