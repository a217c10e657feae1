"""Front doors: a package that names what others may use, and loads it when it is first used."""

from __future__ import annotations

import sys

from teleopctl.base.typed import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from types import ModuleType
    from typing import Any


def import_module(module: str) -> ModuleType:
    """Import a module, without importlib's import cost."""
    __import__(module)
    return sys.modules[module]


# Any: what Python hands on as a module's names.
def attach(
    package: str, names: Mapping[str, str]
) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """Return ``__getattr__``, ``__dir__`` and ``__all__`` of a lazily loading package (PEP 562).

    Type checkers do not see what it does: the package's ``__init__`` imports the same names below
    ``if TYPE_CHECKING``, and calls this in the ``else``. A test holds the two lists equal.

    Args:
        package: The package's ``__name__``.
        names: Public names, separated by spaces, by the module below the package that has them.
    """
    module_of = {name: module for module, listed in names.items() for name in listed.split()}

    def load(name: str) -> Any:
        module = module_of.get(name)
        if module is None:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = getattr(import_module(f"{package}.{module}"), name)
        # The next look-up finds it without coming here.
        setattr(sys.modules[package], name, value)
        return value

    public = sorted(module_of)
    return load, lambda: public, public
