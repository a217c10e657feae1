"""Puts type stubs into the wheel, which pip then installs beside the package.

PEP 561: type checkers look for the types of ``std_msgs`` in ``std_msgs-stubs``, with nothing
configured. The message packages' are made from the definitions; those of ``rclpy`` and the like are
the modules that serve these names, as they are.
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

_SUFFIX = "-stubs"


class StubsHook(BuildHookInterface):
    """Writes the stubs into ``build/stubs`` and has the wheel take them from there."""

    PLUGIN_NAME = "custom"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:  # noqa: ARG002
        """Write the stubs; called before a wheel is put together."""
        root = Path(self.root)
        folder = root / "build" / "stubs"
        shutil.rmtree(folder, ignore_errors=True)
        sys.path.insert(0, self.root)
        try:
            _write_message_stubs(folder)
        finally:
            sys.path.remove(self.root)
        _copy_modules(root / "teleopctl" / "compat" / "site", folder)
        build_data["force_include"][str(folder)] = "/"


def _write_message_stubs(folder: Path) -> None:
    from teleopctl.interfaces.catalog import Catalog
    from teleopctl.interfaces.standard import DEFAULT_DISTRIBUTION
    from teleopctl.interfaces.stubs import write_stubs

    catalog = Catalog(DEFAULT_DISTRIBUTION, cached=False)
    write_stubs(folder, catalog.built_in_names(), catalog.find, suffix=_SUFFIX)


def _copy_modules(site: Path, folder: Path) -> None:
    for path in site.rglob("*.py"):
        top, *rest = path.relative_to(site).with_suffix("").parts
        target = folder.joinpath(f"{top}{_SUFFIX}", *(rest or ["__init__"])).with_suffix(".pyi")
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, target)
