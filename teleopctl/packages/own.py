"""The packages that teleopctl brings itself."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Final

from teleopctl import plugins
from teleopctl.packages.records import Package, PackageProgram

HERE: Final = Path(__file__).resolve().parents[1]

# Packages that have files: name → folder at the root of a source checkout; a wheel has all of them
# below share/.
_DATA_PACKAGES: Final = {
    "teleop_description": "robot",
    "teleop_controller": "config",
    **{
        name: f"teleopctl/share/{name}"
        for name in (
            *("demo_nodes_cpp", "demo_nodes_py", "gazebo_ros", "ros_gz_bridge", "ros_gz_sim"),
            *("teleopctl", "urdf_launch", "urdf_tutorial"),
        )
    },
}


def own_names() -> set[str]:
    """Return the names of teleopctl's built-in packages."""
    return {*_DATA_PACKAGES, *(name.rpartition("/")[0] for name in plugins.NODES.ours)}


def has_files(name: str) -> bool:
    """Return whether a built-in package has files, not only programs."""
    return name in _DATA_PACKAGES


def builtin_package(name: str) -> Package | None:
    """Return teleopctl's built-in package of this name, or None."""
    programs = executables_of(name, plugins.NODES.ours.items())
    folder = HERE
    if name in _DATA_PACKAGES:
        folder = HERE / "share" / name
        if not folder.is_dir():
            folder = HERE.parent / _DATA_PACKAGES[name]
    elif not programs:
        return None
    return Package(name, folder, read_executables=lambda: programs)


def executables_of(package: str, nodes: Iterable[tuple[str, str]]) -> dict[str, PackageProgram]:
    """Return the executables of one package, from pairs of ``package/executable`` and target."""
    split = ((name.rpartition("/"), target) for name, target in nodes)
    return {
        name: PackageProgram(name=name, package=package, target=target)
        for (owner, _, name), target in split
        if owner == package
    }
