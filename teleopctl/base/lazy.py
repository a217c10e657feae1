"""Lazily loaded names of packages: a module is imported when one of its names is first used."""

from __future__ import annotations

import sys

from teleopctl.base.typed import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable
    from types import ModuleType
    from typing import Any


def import_module(module: str) -> ModuleType:
    """Import a module by its full name, without loading importlib, and return it."""
    __import__(module)
    return sys.modules[module]


# Any: values of module attributes.
def attach() -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """Return lazy ``__getattr__``, ``__dir__``, ``__all__`` for the caller's TYPE_CHECKING imports.

    The package's ``__init__`` imports the names below ``if TYPE_CHECKING`` from modules of its own
    distribution, by their full names, and calls this function in the ``else`` branch. Python does
    not run these imports but compiles them: ``co_names`` of the code lists each module followed by
    the names imported from it. Reading that list takes a few microseconds, parsing a stub file
    would take milliseconds.

    Example::

        if TYPE_CHECKING:
            from teleopctl.tf.buffer import Buffer as Buffer
        else:
            from teleopctl.base.lazy import attach

            __getattr__, __dir__, __all__ = attach()
    """
    frame = sys._getframe(1)  # noqa: SLF001 - the package that calls, as typing and logging do
    package: str = frame.f_globals["__name__"]
    distribution = f"{package.partition('.')[0]}."
    home_of: dict[str, str] = {}
    home = ""
    for name in frame.f_code.co_names:
        if "." in name:
            home = name
        elif home.startswith(distribution) and not f"{home}.".startswith("teleopctl.base."):
            home_of[name] = home

    def load(name: str) -> Any:
        home = home_of.get(name)
        if home is None:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = getattr(import_module(home), name)
        # The next look-up finds the attribute without calling this function.
        setattr(sys.modules[package], name, value)
        return value

    public = sorted(home_of)
    return load, lambda: public, public
