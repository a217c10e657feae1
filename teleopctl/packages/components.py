"""Components: nodes that a container loads into its process.

A Python package registers a component as an entry point of the group ``rclpy_components``, with a
class, or a function that returns the node: ``my_package::Talker = my_package.talker:Talker``. As
for programs, the entry points of a package that is not built are read from its sources.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from functools import lru_cache
from pathlib import Path

from teleopctl import plugins
from teleopctl.base.typed import NamedTuple
from teleopctl.errors import NotFoundError, did_you_mean
from teleopctl.packages.finding import known_layers, package_names, search_places
from teleopctl.packages.prefixes import prefixes, python_folders
from teleopctl.packages.records import INSTALLED, SOURCES, Package

GROUP = plugins.COMPONENTS.group


class Component(NamedTuple):
    """Component of a package: registered name, package, and how its class is imported.

    Attributes:
        type_name: Registered name, such as ``composition::Talker``.
        package: Package of the component.
        target: Import path ``module:Class``.
        import_roots: Folders to put on the import path first; empty for an importable module.
    """

    type_name: str
    package: str
    target: str
    import_roots: tuple[Path, ...] = ()


def list_components() -> dict[str, list[Component]]:
    """Return the components of all packages, as sorted lists by package name."""
    found: dict[str, list[Component]] = {}
    for component in _all():
        known = found.setdefault(component.package, [])
        if all(other.type_name != component.type_name for other in known):
            known.append(component)
    return {package: sorted(found[package]) for package in sorted(found)}


def find_component(package: str, plugin: str) -> Component:
    """Return a component by package and type name; raise a NotFoundError if there is none.

    The type may be given without the package before the ``::``, as in ``rclpy_components``.

    Raises:
        NotFoundError: The component does not exist. The message is that of ROS 2's containers.
    """
    offered = _components_of(package, (*_of_layers(package), *_registered()))
    if not offered:
        # The part before the :: is usually, but not always, the name of the package.
        offered = _components_of(package, _all())
    for component in offered:
        if component.type_name in (plugin, f"{package}::{plugin}"):
            return component
    if not offered:
        known = list_components()
        raise NotFoundError(
            "Could not find requested resource in ament index",
            hint=did_you_mean(package, known)
            or f"Packages with components: {', '.join(known) or 'none'}.",
        )
    names = sorted({component.type_name for component in offered})
    raise NotFoundError(
        "Failed to find class with the requested plugin name.",
        hint=did_you_mean(plugin, names) or f"{package} has {', '.join(names)}.",
    )


def _components_of(package: str, among: Iterable[Component]) -> list[Component]:
    wanted = _plain(package)
    return [
        component
        for component in among
        if wanted in (_plain(component.package), _plain(component.type_name.partition("::")[0]))
    ]


def _all() -> tuple[Component, ...]:
    return (*_components_in(search_places(), tuple(prefixes())), *_registered())


# A launch file may name twenty components whose packages are not here: a search among a thousand
# packages reads all their scripts.
@lru_cache(maxsize=8)
def _components_in(*_places: tuple[object, ...]) -> tuple[Component, ...]:
    """Return the components of all packages in places, which the environment gives."""
    return tuple(component for name in package_names() for component in _of_layers(name))


def _of_layers(name: str) -> Iterator[Component]:
    """Yield the components of sources and of packages below a prefix."""
    for package in known_layers(name):
        if package.kind == SOURCES:
            yield from _of_sources(package)
        elif package.kind == INSTALLED:
            yield from _of_prefix(package)


def _of_sources(package: Package) -> Iterator[Component]:
    from teleopctl.packages.source_programs import entry_points, import_root

    for name, target in entry_points(package.folder, GROUP).items():
        roots = (import_root(package.folder, target),)
        yield Component(name, package.name, target, roots)


def _of_prefix(package: Package) -> Iterator[Component]:
    roots = python_folders(package.prefix)
    if not roots:
        return
    from importlib.metadata import distributions

    for distribution in distributions(path=[str(root) for root in roots]):
        # A prefix may be shared by many packages.
        if _plain(distribution.name or "") == _plain(package.name):
            for entry in distribution.entry_points.select(group=GROUP):
                yield Component(entry.name, package.name, entry.value, roots)


def _registered() -> Iterator[Component]:
    """Yield the components of teleopctl and of installed distributions."""
    for name, plugin in plugins.available(plugins.COMPONENTS).items():
        package, separator, _ = name.partition("::")
        owner = package if separator else plugin.distribution
        yield Component(name, owner, plugin.target)


def _plain(name: str) -> str:
    return re.sub(r"[-_.]+", "_", name).lower()
