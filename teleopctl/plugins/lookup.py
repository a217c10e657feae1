"""Finds and imports plug-ins; `teleopctl.plugins` has the kinds that there are."""

from __future__ import annotations

import os
import sys

from teleopctl.base.lazy import import_module
from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.errors import BrokenPluginError, UnknownPluginError, did_you_mean

if TYPE_CHECKING:
    from collections.abc import Mapping
    from importlib.metadata import Distribution
    from typing import Any

# Finds plug-ins in the sources of packages, which are in a higher layer.
_SOURCES = "teleopctl.packages.modules:find_source_plugin"
# Beginnings of the group headers to read; the second one is for ROS 2's components in Python.
_MARKS = ("[teleopctl.", "[rclpy_components]")


# Not a named tuple: every command loads this module, and creating one takes half a millisecond.
class Kind:
    """A kind of plug-in: entry-point group, built-in plug-ins and required base classes.

    Attributes:
        noun: Name of such a plug-in in messages.
        group: Entry-point group of other distributions' plug-ins.
        builtin: Plug-ins that are part of teleopctl, as ``module:object`` by name.
        bases: Base classes of plug-ins, of which one is required, as ``module:Class``; empty for
            any object.
        classes: Whether plug-ins are subclasses of ``bases``; otherwise they are instances.
        direct: Whether ``module:object`` or ``file.py:object`` may be given instead of a name.
        in_sources: Whether packages that are not installed may have plug-ins, ``package/name``.
        summaries: One-line descriptions of teleopctl's own plug-ins by name, for lists that must
            not import the plug-ins; empty for most kinds.
    """

    __slots__ = (
        "bases",
        "builtin",
        "classes",
        "direct",
        "group",
        "in_sources",
        "noun",
        "summaries",
    )

    def __init__(
        self,
        noun: str,
        group: str,
        builtin: dict[str, str],
        *,
        bases: tuple[str, ...] = (),
        classes: bool = True,
        direct: bool = False,
        in_sources: bool = False,
        summaries: Mapping[str, str] | None = None,
    ) -> None:
        self.noun = noun
        self.group = group
        self.builtin = builtin
        self.bases = bases
        self.classes = classes
        self.direct = direct
        self.in_sources = in_sources
        self.summaries = summaries or {}


class Plugin:
    """Name, import path and distribution of a plug-in that may not be imported yet.

    Attributes:
        name: Name of the plug-in.
        target: Import path ``module:object``.
        distribution: Distribution that has the plug-in; empty for teleopctl.
        folder: Folder from which the plug-in is imported; empty for an installed one.
    """

    __slots__ = ("distribution", "folder", "name", "target")

    def __init__(self, name: str, target: str, distribution: str = "", folder: str = "") -> None:
        self.name = name
        self.target = target
        self.distribution = distribution
        self.folder = folder


def find(kind: Kind, name: str) -> Plugin | None:
    """Return a plug-in, unimported, by name or, if its kind allows, by its module; or None."""
    if name in kind.builtin:
        return Plugin(name, kind.builtin[name])
    if (installed := _installed_plugins(kind.group).get(name)) is not None:
        return installed
    if kind.direct and ":" in name:
        return _direct(name)
    if kind.in_sources and "/" in name:
        found = import_object(_SOURCES)(kind.group, name)
        if found is not None:
            target, folder = found
            return Plugin(name, target, name.partition("/")[0], folder)
    return None


def _direct(name: str) -> Plugin | None:
    """Return the plug-in ``module:object`` or ``file.py:object``; None for another text."""
    file, _, attribute = name.rpartition(":")
    if file.endswith(".py"):
        path = os.path.abspath(os.path.expanduser(file))  # noqa: PTH100, PTH111 -- paths are texts
        folder, last = os.path.split(path)
        return Plugin(name, f"{last.removesuffix('.py')}:{attribute}", folder=folder)
    return None if "/" in name else Plugin(name, name)


def available(kind: Kind) -> dict[str, Plugin]:
    """Return all plug-ins of a kind by name, not imported: built-in ones, then others sorted."""
    plugins = {name: Plugin(name, target) for name, target in kind.builtin.items()}
    for name, installed in _installed_plugins(kind.group).items():
        plugins.setdefault(name, installed)
    return plugins


# Any: the type of a plug-in depends on its kind.
def load(kind: Kind, name: str) -> Any:
    """Import the plug-in of a kind with a name, check it, and return its class or object.

    Returns:
        The class or object, whose type depends on the kind.

    Raises:
        UnknownPluginError: No plug-in has that name; the message lists the available ones.
        BrokenPluginError: The plug-in cannot be imported, or has none of the base classes of its
            kind. The message names the faulty line of its code. The next attempt reads its files
            again.
    """
    plugin = find(kind, name)
    if plugin is None:
        names = sorted(available(kind))
        listed = "\n".join(f"  {known}" for known in names)
        raise UnknownPluginError(
            f"There is no {kind.noun} '{name}'. Available are:\n{listed}",
            hint=did_you_mean(name, names),
        )
    if name in kind.builtin:
        return import_object(plugin.target)
    whose = f" of {plugin.distribution}" if plugin.distribution else ""
    what = f"{kind.noun} '{name}'{whose}"
    before = set(sys.modules)
    if plugin.folder and plugin.folder not in sys.path:
        sys.path.insert(0, plugin.folder)
    try:
        found = import_object(plugin.target)
    except (Exception, SystemExit) as error:
        broken = broken_import(what, plugin.target, error)
        _forget_imports(since=before)
        raise broken from error
    if plugin.folder:
        source = getattr(sys.modules[plugin.target.partition(":")[0]], "__file__", None) or ""
        if not source.startswith(plugin.folder + os.sep):
            raise BrokenPluginError(
                f"{what}: {source} has the same module name and was imported before"
            )
    if kind.bases and not _is_one(found, kind):
        relation = "a subclass" if kind.classes else "an object"
        raise BrokenPluginError(
            f"{what}: {plugin.target} is not {relation} of {' or '.join(kind.bases)}"
        )
    return found


def broken_import(what: str, target: str, error: BaseException) -> BrokenPluginError:
    """Return the error for a failed import of a plug-in, with the faulty line or the file.

    Args:
        what: The plug-in in words.
        target: Its import path ``module:object``.
        error: Exception that the import raised.
    """
    from teleopctl.base.exception_origin import origin_of  # every command loads this module

    text = error.msg if isinstance(error, SyntaxError) else error
    broken = BrokenPluginError(
        f"{what}: {target} cannot be imported: {type(error).__name__}: {text}"
    )
    place = origin_of(error)
    module, _, attribute = target.partition(":")
    if place is None and isinstance(error, AttributeError) and module in sys.modules:
        content = vars(sys.modules[module])
        place = content.get("__file__")
        classes = [name for name, value in content.items() if isinstance(value, type)]
        broken.hint = did_you_mean(attribute, classes)
    return broken.at(place) if place else broken


# Any: any object of a module.
def import_object(target: str) -> Any:
    """Import a module, and return its object that ``module:name`` names."""
    module, _, attribute = target.partition(":")
    return getattr(import_module(module), attribute)


def _forget_imports(since: set[str]) -> None:
    """Remove the user's modules of a failed import, so that they are read again once fixed.

    Installed packages stay, since many of them cannot be imported twice.
    """
    from teleopctl.base.exception_origin import is_user_code

    for name in set(sys.modules) - since:
        source = getattr(sys.modules[name], "__file__", None) or ""
        if is_user_code(source) and source.endswith(".py"):
            del sys.modules[name]


def _is_one(found: object, kind: Kind) -> bool:
    bases = tuple(import_object(base) for base in kind.bases)
    if kind.classes:
        return isinstance(found, type) and issubclass(found, bases)
    return isinstance(found, bases)


def forget_entry_points() -> None:
    """Drop the cached plug-ins of installed distributions, which are read again when needed."""
    _installed.clear()


# Plug-ins of installed distributions by group and name; empty until they are read.
_installed: dict[str, dict[str, Plugin]] = {}


def _installed_plugins(group: str) -> dict[str, Plugin]:
    if not _installed:
        _installed.update({"": {}, **_read_installed()})
    return _installed.get(group, {})


def _read_installed() -> dict[str, dict[str, Plugin]]:
    """Return the plug-ins of all installed distributions, by group and name, sorted.

    Logs a warning for a distribution whose entries cannot be read, and for a name that two
    distributions have; then the first one is used.
    """
    if not _has_installed_plugins():
        return {}
    from importlib.metadata import distributions

    owners: dict[str, list[tuple[str, str, str]]] = {}
    for distribution in distributions():
        try:
            text = distribution.read_text("entry_points.txt") or ""
            if not any(mark in text for mark in _MARKS):
                continue
            owner = distribution.name
            entries = [
                (entry.group, entry.name, entry.value) for entry in distribution.entry_points
            ]
        except Exception as error:  # noqa: BLE001 -- with any error, the others still work
            _warn(f"The plug-ins of {_name_of(distribution)} cannot be read: {error}")
            continue
        # The modules of the first distribution on the path are imported.
        owners.setdefault(owner, entries)
    found: dict[str, dict[str, Plugin]] = {}
    for owner, entries in sorted(owners.items()):
        for group, name, value in entries:
            # Brackets contain extras, an obsolete part of entry points.
            plugin = Plugin(name, value.partition("[")[0].strip(), owner)
            known = found.setdefault(group, {}).setdefault(name, plugin)
            if known.distribution != owner and f"[{group}]".startswith(_MARKS):
                _warn(
                    f"Both {known.distribution} and {owner} offer '{name}' in {group}: "
                    f"that of {known.distribution} is used"
                )
    return {group: dict(sorted(plugins.items())) for group, plugins in found.items()}


def _has_installed_plugins() -> bool:
    """Return whether any installed distribution may have plug-ins for teleopctl.

    Most machines have none, and the import of `importlib.metadata` would take 20 ms.
    """
    for folder in sys.path:
        if folder.endswith(".egg") or os.path.isfile(folder):  # noqa: PTH113 -- paths are texts
            return True
        try:
            with os.scandir(folder or ".") as entries:
                names = [e.name for e in entries if e.name.endswith((".dist-info", ".egg-info"))]
        except OSError:
            continue
        for name in names:
            try:
                with open(f"{folder or '.'}/{name}/entry_points.txt", "rb") as file:  # noqa: PTH123
                    text = file.read()
                    if any(mark.encode() in text for mark in _MARKS):
                        return True
            except (FileNotFoundError, NotADirectoryError):
                continue
            except OSError:
                return True  # the caller then reports the error
    return False


def _name_of(distribution: Distribution) -> str:
    try:
        return distribution.name
    except Exception:  # noqa: BLE001 -- its metadata may be invalid
        return "a distribution without a name"


def _warn(text: str) -> None:
    from logging import getLogger

    getLogger(__name__).warning(text)
