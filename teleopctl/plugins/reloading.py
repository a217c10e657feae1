"""Reloading of plug-ins in a running process, all of them or none."""

from __future__ import annotations

import os
import sys

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.errors import BrokenPluginError
from teleopctl.plugins.lookup import Kind, find, forget_entry_points, load

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from types import ModuleType

_INSTALLED = "site-packages", "dist-packages"


def reload(kind: Kind, names: Iterable[str]) -> list[str]:
    """Import plug-ins again with their packages' modules; return the names of those modules.

    Objects of the old classes keep the old code. teleopctl's own plug-ins are never reloaded.

    Args:
        kind: Kind of the plug-ins.
        names: Names of the plug-ins. A plug-in whose module no longer exists is skipped.

    Raises:
        BrokenPluginError: A plug-in cannot be imported; then all modules stay as before.
    """
    from importlib import invalidate_caches

    installed = [name for name in names if name not in kind.builtin]
    # The modules of the plug-ins are found among those that are imported now.
    own = {module for name in installed for module in _own_modules(kind, name)}
    old = {module: sys.modules[module] for module in sorted(own)}
    forget_entry_points()
    for module, content in old.items():
        _remove_bytecode(content)
        del sys.modules[module]
    invalidate_caches()
    try:
        for name in installed:
            if _exists(kind, name):
                load(kind, name)
    except BrokenPluginError:
        _put_back(old)
        raise
    return list(old)


def _own_modules(kind: Kind, name: str) -> set[str]:
    """Return the imported modules of a plug-in: of its package, and of its class's bases.

    For a module without a package, the modules in the same folder are included, unless packages
    are installed in that folder.
    """
    plugin = find(kind, name)
    module, _, attribute = plugin.target.partition(":") if plugin else ("", "", "")
    content = sys.modules.get(module)
    if content is None:
        return set()
    package = module.partition(".")[0]
    folder = os.path.dirname(_source(content))  # noqa: PTH120 -- paths of modules are texts
    own = {other for other in sys.modules if f"{other}.".startswith(f"{package}.")}
    if package == module and folder and not folder.endswith(_INSTALLED):
        own |= {
            other
            for other, neighbour in sys.modules.items()
            if os.path.dirname(_source(neighbour)) == folder  # noqa: PTH120
        }
    found: object = getattr(content, attribute, None)
    own |= {base.__module__ for base in found.__mro__} if isinstance(found, type) else set()
    ours = __name__.partition(".")[0]
    return {
        other
        for other in own - sys.stdlib_module_names - {"__main__"}
        # A C extension cannot be loaded twice.
        if other.partition(".")[0] != ours and _source(sys.modules.get(other)).endswith(".py")
    }


def _source(module: ModuleType | None) -> str:
    """Return the path of a module's file; empty if it has none."""
    return getattr(module, "__file__", None) or ""


def _remove_bytecode(module: ModuleType) -> None:
    """Remove a module's compiled file, since Python misses edits within one second."""
    import contextlib

    bytecode = getattr(module.__spec__, "cached", None)
    if bytecode:
        with contextlib.suppress(OSError):
            os.unlink(bytecode)  # noqa: PTH108 -- paths are texts


def _exists(kind: Kind, name: str) -> bool:
    """Return whether a plug-in still has an entry point and a module."""
    from importlib.util import find_spec

    plugin = find(kind, name)
    if plugin is None:
        return False
    package, _, _ = plugin.target.partition(":")[0].partition(".")
    return find_spec(package) is not None


def _put_back(old: Mapping[str, ModuleType]) -> None:
    sys.modules.update(old)
    for name, module in old.items():
        package, _, last = name.rpartition(".")
        if package in sys.modules:
            setattr(sys.modules[package], last, module)
