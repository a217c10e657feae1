"""``launch_ros.utilities``: functions for third-party actions that start nodes."""

import importlib
from typing import TYPE_CHECKING, Any

from .evaluate_parameters import evaluate_parameters
from .namespace_utils import (
    is_namespace_absolute,
    is_root_namespace,
    make_namespace_absolute,
    prefix_namespace,
)
from .normalize_parameters import normalize_parameters
from .normalize_remap_rule import normalize_remap_rule, normalize_remap_rules
from .track_node_names import add_node_name, get_node_name_count

if TYPE_CHECKING:
    from .lifecycle_event_manager import LifecycleEventManager
    from .to_parameters_list import to_parameters_list

_WITH_RCLPY = {
    "LifecycleEventManager": ".lifecycle_event_manager",
    "to_parameters_list": ".to_parameters_list",
}

__all__ = [
    "LifecycleEventManager",
    "add_node_name",
    "evaluate_parameters",
    "get_node_name_count",
    "is_namespace_absolute",
    "is_root_namespace",
    "make_namespace_absolute",
    "normalize_parameters",
    "normalize_remap_rule",
    "normalize_remap_rules",
    "prefix_namespace",
    "to_parameters_list",
]


# Any: attributes of a module. These need messages and rclpy, which few launch files do.
def __getattr__(name: str) -> Any:
    if name not in _WITH_RCLPY:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    # The module of that name would take its place.
    found = globals()[name] = getattr(importlib.import_module(_WITH_RCLPY[name], __name__), name)
    return found
