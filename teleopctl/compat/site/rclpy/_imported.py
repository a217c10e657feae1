"""Names that rclpy's modules have only because they import them; programs take them from there."""

from collections.abc import Callable
from typing import TypeVar

from teleopctl import interfaces, node

_MESSAGES = (
    *("FloatingPointRange", "IntegerRange", "ListParametersResult", "ParameterDescriptor"),
    *("ParameterEvent", "ParameterType", "ParameterValue", "SetParametersResult"),
)
_TYPE_VARIABLES = {
    "MsgType": interfaces.MessageT,
    "SrvType": TypeVar("SrvType"),
    "SrvTypeRequest": interfaces.RequestT,
    "SrvTypeResponse": interfaces.ResponseT,
}


def imported(module: str) -> Callable[[str], object]:
    """Return the ``__getattr__`` of a module: it finds what the client library has by a name."""

    def find(name: str) -> object:
        if name in _TYPE_VARIABLES:
            return _TYPE_VARIABLES[name]
        if name in _MESSAGES:
            return interfaces.get_message(f"rcl_interfaces/msg/{name}")
        if name in dir(node):
            return getattr(node, name)
        raise AttributeError(f"module {module!r} has no attribute {name!r}")

    return find
