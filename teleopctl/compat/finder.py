"""Finds the message packages of ROS 2 that are not installed.

``install`` lets Python import ``<package>.msg``, ``<package>.srv`` and ``<package>.action`` of each
package whose interface definitions are known, with classes made when they are first used, and the
Python modules of the packages that are found. What is really installed always wins.

Every Python that is started with ``rclpy`` at hand imports this module, so that it does without
``typing``, ``collections`` and ``importlib.abc``, which would be nearly all of its cost.
"""

from __future__ import annotations

import sys
from _thread import get_ident
from importlib.machinery import ModuleSpec, PathFinder
from types import ModuleType

from teleopctl.compat.interface_modules import (
    KINDS,
    InterfaceModule,
    PackageModule,
    class_names,
    has_package,
    unknown_name,
)

TYPE_CHECKING = False  # typing's constant, as type checkers know it by its name
if TYPE_CHECKING:
    from collections.abc import Sequence

_LOOKED_FOR_AT_START = ("sitecustomize", "usercustomize")
"""By each Python, which would look through all definitions for nothing."""

_USUAL_ENDINGS = ("_msgs", "_srvs", "_interfaces")

_searching: set[int] = set()
"""The threads that look for definitions, by their identifiers."""


class _Loader:
    """Makes the modules of a package that has interface definitions."""

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        """Make the module of a package, of one of its kinds, or of a single definition."""
        return InterfaceModule(spec.name) if "." in spec.name else PackageModule(spec.name)

    def exec_module(self, module: ModuleType) -> None:
        """Do nothing: classes of the module are created when they are first used."""


class _PackageFinder:
    """Serves ``<package>`` when nothing else does; it stands behind Python's own finders.

    The module of a source package comes first, its interfaces are still served by `_KindFinder`.
    Of an installed package with interfaces the module holds what ROS's generator made of them, for
    ROS's own libraries: ours are meant.
    """

    def find_spec(
        self, fullname: str, _path: Sequence[str] | None, _target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Find a package with a Python module or with interface definitions.

        Raises:
            ModuleNotFoundError: The definitions cannot be looked through, and a message package is
                what the name means.
        """
        if "." in fullname or fullname in _LOOKED_FOR_AT_START:
            return None
        from teleopctl.errors import TeleopctlError

        try:
            return (
                _module_spec(fullname, installed=False)
                or _interface_spec(fullname)
                or _module_spec(fullname, installed=True)
            )
        except TeleopctlError as error:
            # Imports of anything else are none of its business.
            if not fullname.endswith(_USUAL_ENDINGS):
                return None
            raise ModuleNotFoundError(
                f"No module named {fullname!r}: {error.message}", name=fullname
            ) from error


class _KindFinder:
    """Serves ``<package>.msg`` and what is below it.

    It stands in front, and asks Python's own finder itself: to that one, the folder ``msg/`` with
    the definitions of a source package is a package as well, an empty one.
    """

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, _target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Find the ``msg``, ``srv`` or ``action`` of a package.

        Raises:
            ImportError: A package that is served here has no class of that name.
        """
        top, _, rest = fullname.partition(".")
        if rest.split(".", 1)[0] not in KINDS or rest.count(".") > 1:
            return None
        if isinstance(sys.modules.get(top), PackageModule) or not _is_installed(fullname, path):
            return _interface_spec(fullname)
        return None


def install() -> None:
    """Make message packages importable in this process. Idempotent."""
    if not any(isinstance(finder, _KindFinder) for finder in sys.meta_path):
        sys.meta_path.insert(0, _KindFinder())
        sys.meta_path.append(_PackageFinder())


def _interface_spec(fullname: str) -> ModuleSpec | None:
    # Looking for definitions imports modules, some of which try optional imports of their own.
    thread = get_ident()
    if thread in _searching:
        return None
    _searching.add(thread)
    try:
        known = _is_interface_module(fullname)
    finally:
        _searching.remove(thread)
    if not known:
        return None
    return ModuleSpec(fullname, _Loader(), is_package=True)  # type: ignore[arg-type]  # by methods


def _module_spec(fullname: str, *, installed: bool) -> ModuleSpec | None:
    thread = get_ident()
    if thread in _searching or fullname.startswith("_") or not fullname.isascii():
        return None
    from teleopctl.packages import installed_module_roots, source_module_root

    _searching.add(thread)
    try:
        if installed:
            roots = installed_module_roots(fullname)
        else:
            root = source_module_root(fullname)
            roots = () if root is None else (root,)
    finally:
        _searching.remove(thread)
    if not roots:
        return None
    spec = PathFinder.find_spec(fullname, [str(root) for root in roots])
    return spec if spec is not None and spec.loader is not None else None


def _is_interface_module(fullname: str) -> bool:
    package, _, rest = fullname.partition(".")
    kind, _, single = rest.partition(".")
    if not has_package(package, kind or None):
        return False
    if single[:1].isupper():
        # Python asks for a module of that name when ``from package.msg import Name`` found no
        # class: the one chance to say which name was meant.
        module = fullname.rpartition(".")[0]
        raise ImportError(unknown_name(single, module), name=module)
    return not single or bool(class_names(fullname))


def _is_installed(fullname: str, path: Sequence[str] | None) -> bool:
    """Tell whether there is a real module; a mere folder of definitions is none."""
    spec = PathFinder.find_spec(fullname, path)
    return spec is not None and spec.loader is not None
