"""pytest hooks for ROS 2's launch tests, loaded when pytest starts.

``launch_testing`` and ``launch_pytest`` each have a plug-in, which imports all of ``launch``. At
its start pytest gets only the option and the marks. Each plug-in is loaded with the first test file
that may contain such tests.
"""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import pytest

_PLUGINS = {
    "launch_testing": ("launch_testing.pytest.hooks", (b"generate_test_description",)),
    "launch_pytest": ("launch_pytest.plugin", (b"launch_pytest", b"mark.launch")),
}
_MARKS = (
    "launch_test: a generate_test_description() with launch tests of launch_testing",
    "rostest: likewise, of launch_testing_ros",
    "launch(fixture, shutdown=False): a test of launch_pytest, beside the launch of a fixture",
)


def are_imported_from(folder: str) -> bool:
    """Return whether ``launch_testing`` and ``launch_pytest`` would be imported from a folder."""
    specs = [find_spec(name) for name in _PLUGINS]
    return all(spec is not None and (spec.origin or "").startswith(folder) for spec in specs)


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add launch_testing's option ``--launch-args`` to pytest; called when pytest starts."""
    parser.addoption(
        "--launch-args",
        action="append",
        nargs="*",
        default=[],
        help="arguments of launch tests: name:=value",
    )


def pytest_configure(config: pytest.Config) -> None:
    """Declare the marks of launch_testing and launch_pytest; called when pytest starts."""
    for line in _MARKS:
        config.addinivalue_line("markers", line)


@pytest.hookimpl(tryfirst=True)
def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> None:
    """Load the launch test plug-in that a collected file mentions; called for each file."""
    if file_path.suffix != ".py":
        return
    manager = parent.config.pluginmanager
    text: bytes | None = None
    for name, (module, words) in _PLUGINS.items():
        if not manager.has_plugin(name) and not manager.is_blocked(name):
            text = file_path.read_bytes() if text is None else text
            if any(word in text for word in words):
                manager.register(import_module(module), name)
