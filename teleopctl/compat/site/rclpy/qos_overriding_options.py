"""``rclpy.qos_overriding_options``. Quality of service that parameters override."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from rclpy._imported import imported
from teleopctl.interfaces import get_message
from teleopctl.node import (
    DurabilityPolicy,
    Duration,
    HistoryPolicy,
    InvalidQosOverridesError,
    LivelinessPolicy,
    QoSOverridingOptions,
    QoSPolicyKind,
    QoSProfile,
    ReliabilityPolicy,
)

__all__ = [
    "InvalidQosOverridesError",
    "QoSOverridingOptions",
    "QoSPolicyKind",
    "QoSProfileAttributes",
    "QosCallbackResult",
    "QosCallbackType",
]

QosCallbackResult: Any = get_message("rcl_interfaces/msg/SetParametersResult")
QosCallbackType = Callable[[QoSProfile], Any]
QoSProfileAttributes = (
    HistoryPolicy | int | ReliabilityPolicy | DurabilityPolicy | Duration | LivelinessPolicy | bool
)

if not TYPE_CHECKING:  # checkers know the documented names only
    __getattr__ = imported(__name__)
