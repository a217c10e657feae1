"""``rclpy.qos_overriding_options``. Quality of service that parameters override."""

from typing import TYPE_CHECKING, Any

from rclpy._imported import imported
from teleopctl.interfaces import get_message
from teleopctl.node import InvalidQosOverridesError, QoSOverridingOptions, QoSPolicyKind

__all__ = [
    "InvalidQosOverridesError",
    "QoSOverridingOptions",
    "QoSPolicyKind",
    "QosCallbackResult",
]

QosCallbackResult: Any = get_message("rcl_interfaces/msg/SetParametersResult")

if not TYPE_CHECKING:  # checkers know the documented names only
    __getattr__ = imported(__name__)
