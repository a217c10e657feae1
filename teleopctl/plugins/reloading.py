"""Reloading of plug-ins in a running process, all of them or none."""

from __future__ import annotations

import os
import sys
from types import CodeType
from weakref import WeakKeyDictionary

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.errors import BrokenPluginError
from teleopctl.plugins.lookup import Kind, broken_import, find, forget_entry_points, load

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from types import ModuleType

_INSTALLED = "site-packages", "dist-packages"
# teleopctl tests for the classes in these modules, so that there must be one of each.
_FIXED = frozenset(
    f"teleopctl.control.controllers.{module}" for module in ("base", "chainable")
) | {"teleopctl.control.hardware.base"}

# Modification time, size and inode of a source file.
_Stamp = tuple[int, int, int]
# Version of the file from which each module was imported, as recorded by `remember_sources`.
_imported_from: WeakKeyDictionary[ModuleType, _Stamp | None] = WeakKeyDictionary()
# All names in the code of each module, from its compiled file soon after the import.
_names_imported: WeakKeyDictionary[ModuleType, set[str]] = WeakKeyDictionary()


class Reloaded:
    """Outcome of `reload`, which can be undone.

    Args:
        old: The modules before, by name.

    Attributes:
        modules: Names of the modules that were imported again, sorted. A module that the new code
            no longer imports is not among them.
    """

    def __init__(self, old: Mapping[str, ModuleType]) -> None:
        self._old = old
        self.modules = [name for name in sorted(old) if name in sys.modules]

    def undo(self) -> None:
        """Put the modules from before back, for imports from now on."""
        _put_back(self._old)


def reload(kind: Kind, names: Iterable[str], *, only_changed: bool = False) -> Reloaded:
    """Import plug-ins again with the modules of their packages; return what was imported.

    Objects of the old classes keep the old code. Of teleopctl's own plug-ins, only modules with
    changed files are imported again.

    Args:
        kind: Kind of the plug-ins.
        names: Names of the plug-ins. A plug-in whose module no longer exists is skipped.
        only_changed: Whether to import only modules whose files changed since `remember_sources`,
            and those that import these.

    Raises:
        BrokenPluginError: A plug-in cannot be imported; then all modules stay as before.
    """
    from importlib import invalidate_caches

    names = list(names)
    # The modules of the plug-ins are found among those that are imported now.
    own: set[str] = set()
    for name in names:
        modules = _own_modules(kind, name)
        changed_only = only_changed or name in kind.builtin
        own |= _changed(modules, unknown=name not in kind.builtin) if changed_only else modules
    old = {module: sys.modules[module] for module in sorted(own)}
    stamps = {module: _stamp(content) for module, content in old.items()}
    forget_entry_points()
    for content in old.values():
        _remove_bytecode(content)
    _compile(old.values())
    for module in old:
        del sys.modules[module]
    for module, content in old.items():
        # Else ``from package import module`` would find the old module in a package that stays.
        package, _, last = module.rpartition(".")
        if vars(sys.modules.get(package, sys)).get(last) is content:
            delattr(sys.modules[package], last)
    invalidate_caches()
    try:
        for name in names:
            if _exists(kind, name):
                _load(kind, name)
    except BrokenPluginError:
        _put_back(old)
        raise
    for module, stamp in stamps.items():
        if module in sys.modules:
            # The version before the import: a file saved during the import counts as changed.
            _imported_from[sys.modules[module]] = stamp
    for name in names:
        remember_sources(kind, name)
    return Reloaded(old)


def _load(kind: Kind, name: str) -> None:
    try:
        load(kind, name)
    except BrokenPluginError:
        raise
    except (Exception, SystemExit) as error:
        # One of teleopctl's own, edited in an editable install.
        raise broken_import(f"{kind.noun} '{name}'", kind.builtin[name], error) from error


def remember_sources(kind: Kind, name: str) -> None:
    """Note the present versions of an imported plug-in's files; `reload` compares with them."""
    for module in _own_modules(kind, name):
        content = sys.modules[module]
        if content not in _imported_from:
            _imported_from[content] = _stamp(content)


def source_files(kind: Kind, name: str) -> list[str]:
    """Return the paths of the files whose change `reload` notices for a plug-in, sorted."""
    return sorted({_source(sys.modules[module]) for module in _own_modules(kind, name)})


def _own_modules(kind: Kind, name: str) -> set[str]:
    """Return the imported modules of a plug-in: of its package, its class's bases, and imports.

    For a module without a package, the modules in the same folder are included, unless packages
    are installed in that folder. Modules that these import are included if they are the user's.
    For a plug-in of teleopctl, these are the modules beside it and below.
    """
    plugin = find(kind, name)
    module, _, attribute = plugin.target.partition(":") if plugin else ("", "", "")
    content = sys.modules.get(module)
    if content is None:
        return set()
    if name in kind.builtin:
        beside = kind.bases[0].rpartition(":")[0].rpartition(".")[0]
        own = {other for other in sys.modules if other.startswith(f"{beside}.")}
        return {m for m in own - _FIXED if _source(sys.modules[m]).endswith(".py")}
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
    own = _reloadable(own)
    waiting = set(own)
    while waiting:
        # Without a loop in Python: the names in a large package's code are many thousands.
        seen = set().union(*(_imports(sys.modules[one]) for one in waiting))
        seen &= sys.modules.keys() - own
        waiting = {other for other in _reloadable(seen) if _is_users(other)}
        own |= waiting
    return own


def _reloadable(modules: set[str]) -> set[str]:
    ours = __name__.partition(".")[0]
    return {
        other
        for other in modules - sys.stdlib_module_names - {"__main__"}
        # A C extension cannot be loaded twice.
        if other.partition(".")[0] != ours and _source(sys.modules.get(other)).endswith(".py")
    }


def _is_users(module: str) -> bool:
    from teleopctl.base.exception_origin import is_user_code

    return is_user_code(_source(sys.modules.get(module)))


def _changed(modules: set[str], *, unknown: bool) -> set[str]:
    """Return the modules with changed files, and those that import them.

    Args:
        modules: Names of imported modules.
        unknown: Whether a module counts as changed if nothing is known about its file.
    """
    changed = set()
    for module in modules:
        content = sys.modules[module]
        known = content in _imported_from
        if _imported_from[content] != _stamp(content) if known else unknown:
            changed.add(module)
    while True:
        dependents = {m for m in modules - changed if changed & _imports(sys.modules[m])}
        if not dependents:
            return changed
        changed |= dependents


def _imports(module: ModuleType) -> set[str]:
    """Return the names of modules that a module's code may import, also within functions."""
    if module not in _names_imported:
        _names_imported[module] = _names_in(module)
    return _names_imported[module]


def _names_in(module: ModuleType) -> set[str]:
    """Return all names in a module's compiled code, those of imported modules among them.

    The compiled file is read, since compiling would keep the control loop from running: 1 ms for
    60 lines. The module's own loader may be another one, such as pytest's, which returns no code.
    """
    from importlib.machinery import SourceFileLoader

    try:
        code = SourceFileLoader(module.__name__, _source(module)).get_code(module.__name__)
    except (ImportError, OSError, SyntaxError, ValueError):
        return set()
    waiting: list[object] = [code]
    names: set[str] = set()
    while waiting:
        part = waiting.pop()
        if isinstance(part, CodeType):
            names.update(part.co_names)
            waiting += part.co_consts
        elif isinstance(part, tuple):
            # The names after ``from … import``.
            names.update(name for name in part if isinstance(name, str))
    dotted = {name.rpartition(".")[0] for name in names if "." in name}
    parts = (module.__package__ or "").split(".")
    # Packages that a relative import may begin with.
    above = [".".join(parts[:count]) for count in range(1, len(parts) + 1) if parts[0]]
    return names | dotted | {f"{package}.{name}" for package in above for name in names}


def _source(module: ModuleType | None) -> str:
    """Return the path of a module's file; empty if it has none."""
    return getattr(module, "__file__", None) or ""


def _stamp(module: ModuleType) -> _Stamp | None:
    try:
        found = os.stat(_source(module))  # noqa: PTH116 -- paths of modules are texts
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size, found.st_ino


def _remove_bytecode(module: ModuleType) -> None:
    """Remove a module's compiled file, since Python misses edits within one second."""
    import contextlib

    bytecode = getattr(module.__spec__, "cached", None)
    if bytecode:
        with contextlib.suppress(OSError):
            os.unlink(bytecode)  # noqa: PTH108 -- paths are texts


# Python of a child process: source and compiled file of each module are its arguments. The compiled
# files have hashes of the sources, so that edits within one second are noticed.
_COMPILER = """
import py_compile, sys
by_hash = py_compile.PycInvalidationMode.CHECKED_HASH
for source, compiled in zip(sys.argv[2::2], sys.argv[3::2]):
    try:
        py_compile.compile(
            source, compiled, doraise=True, optimize=int(sys.argv[1]), invalidation_mode=by_hash
        )
    except (OSError, py_compile.PyCompileError):
        pass
"""
# Below this number of bytes, a module is compiled in 3 ms, less than the child takes to start.
_LARGE = 8000
_LONGEST_COMPILATION_S = 20.0


def _compile(modules: Iterable[ModuleType]) -> None:
    """Compile large modules in a child process, if possible.

    Compiling keeps all threads of a process from running, the control loop among them: 20 ms for a
    thousand lines.
    """
    files: list[str] = []
    for module in modules:
        stamp, compiled = _stamp(module), getattr(module.__spec__, "cached", None)
        if stamp is not None and stamp[1] >= _LARGE and compiled:
            files += [_source(module), compiled]
    if not files:
        return
    import contextlib
    import subprocess

    # Without the compiled file, Python compiles the module when it imports it.
    with contextlib.suppress(OSError, subprocess.SubprocessError):
        subprocess.run(
            [sys.executable, "-I", "-S", "-c", _COMPILER, str(sys.flags.optimize), *files],
            check=False,
            capture_output=True,
            timeout=_LONGEST_COMPILATION_S,
        )


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
