"""``launch_ros.descriptions``."""

from ..parameter_descriptions import Parameter, ParameterFile, ParameterValue
from .composable_lifecycle_node import ComposableLifecycleNode
from .composable_node import ComposableNode

__all__ = [
    "ComposableLifecycleNode",
    "ComposableNode",
    "Parameter",
    "ParameterFile",
    "ParameterValue",
]
