"""ROS 2's ``launch_ros``: nodes, parameters and packages in Python launch files."""

from importlib import import_module
from types import ModuleType

from . import actions, descriptions, substitutions

__all__ = ["actions", "descriptions", "event_handlers", "events", "ros_adapters", "substitutions"]

# Those of lifecycle nodes import messages, which few launch files need.
_LATER = ("event_handlers", "events", "ros_adapters")


def __getattr__(name: str) -> ModuleType:
    if name in _LATER:
        return import_module(f"{__name__}.{name}")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
