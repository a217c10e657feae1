"""``launch_ros.actions``."""

from typing import TYPE_CHECKING

from .composable_node_container import ComposableNodeContainer
from .lifecycle_node import LifecycleNode
from .load_composable_nodes import LoadComposableNodes
from .node import Node
from .push_ros_namespace import PushROSNamespace
from .ros_timer import ROSTimer
from .set_parameter import SetParameter
from .set_parameters_from_file import SetParametersFromFile
from .set_remap import SetRemap
from .set_ros_log_dir import SetROSLogDir
from .set_use_sim_time import SetUseSimTime

if TYPE_CHECKING:
    from .lifecycle_transition import LifecycleTransition

PushRosNamespace = PushROSNamespace
RosTimer = ROSTimer

__all__ = [
    "ComposableNodeContainer",
    "LifecycleNode",
    "LifecycleTransition",
    "LoadComposableNodes",
    "Node",
    "PushROSNamespace",
    "PushRosNamespace",
    "ROSTimer",
    "RosTimer",
    "SetParameter",
    "SetParametersFromFile",
    "SetROSLogDir",
    "SetRemap",
    "SetUseSimTime",
]


def __getattr__(name: str) -> object:
    # It imports messages, which few launches need.
    if name == "LifecycleTransition":
        from .lifecycle_transition import LifecycleTransition

        return LifecycleTransition
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
