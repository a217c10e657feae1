"""``tf2_ros`` for programs that import it: transforms with their familiar names."""

from typing import TYPE_CHECKING

from teleopctl import node
from teleopctl.interfaces import get_class
from teleopctl.tf import (
    Buffer,
    BufferClient,
    BufferCore,
    BufferInterface,
    ConnectivityException,
    ConvertRegistration,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
    NotImplementedException,
    Stamped,
    StaticTransformBroadcaster,
    TimeoutException,
    TransformBroadcaster,
    TransformException,
    TransformListener,
    TransformRegistration,
    TypeException,
    convert,
)

__all__ = [
    "Buffer",
    "BufferClient",
    "BufferCore",
    "BufferInterface",
    "ConnectivityException",
    "ConvertRegistration",
    "ExtrapolationException",
    "InvalidArgumentException",
    "LookupException",
    "NotImplementedException",
    "Stamped",
    "StaticTransformBroadcaster",
    "TimeoutException",
    "TransformBroadcaster",
    "TransformException",
    "TransformListener",
    "TransformRegistration",
    "TypeException",
    "convert",
]

# What its modules import themselves; programs take it from here, TransformStamped most of all.
_TYPES = {
    "FrameGraph": "tf2_msgs/srv/FrameGraph",
    "LookupTransform": "tf2_msgs/action/LookupTransform",
    "TFMessage": "tf2_msgs/msg/TFMessage",
    "TransformStamped": "geometry_msgs/msg/TransformStamped",
}


def _imported(name: str) -> object:
    if name in _TYPES:
        return get_class(_TYPES[name])
    if name in dir(node):
        return getattr(node, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


if not TYPE_CHECKING:  # checkers know the documented names only
    __getattr__ = _imported
