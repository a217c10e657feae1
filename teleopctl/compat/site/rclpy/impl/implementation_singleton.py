"""``rclpy.impl.implementation_singleton``. What programs use of the C library's bindings."""

from types import SimpleNamespace
from typing import Any

from rclpy.event_handler import (
    QoSPublisherEventType,
    QoSSubscriptionEventType,
    UnsupportedEventTypeError,
    event_handle,
)
from teleopctl.errors import UsageError
from teleopctl.interfaces import MessageT
from teleopctl.node import (
    GuardHandle,
    Handle,
    InvalidHandle,
    LifecycleStateMachine,
    QoSPresetProfiles,
    QoSProfile,
    RCLError,
    SubscriptionHandle,
    TransitionCallbackReturn,
    WaitSet,
    subscribe_loosely,
)

__all__ = ["rclpy_implementation"]


def _wait_set(*numbers_and_context: Any) -> WaitSet:
    """Make a wait set; how many entities it will have need not be known."""
    *_, context = numbers_and_context
    return WaitSet(context.entity)


def _subscription(
    node: Handle, msg_type: type[MessageT], topic: str, qos: QoSProfile
) -> SubscriptionHandle:
    return subscribe_loosely(node.entity, msg_type, topic, qos)


def _predefined(name: str) -> QoSProfile:
    """Return the profile that rmw has by a name such as ``qos_profile_default``."""
    profile = QoSPresetProfiles[name.removeprefix("qos_profile_").upper()].value
    assert isinstance(profile, QoSProfile)
    return profile


rclpy_implementation = SimpleNamespace(
    EventHandle=event_handle,
    GuardCondition=GuardHandle,
    InvalidHandle=InvalidHandle,
    LifecycleStateMachine=LifecycleStateMachine,
    RCLError=RCLError,
    RCLInvalidROSArgsError=UsageError,
    Subscription=_subscription,
    TransitionCallbackReturnType=TransitionCallbackReturn,
    UnknownROSArgsError=UsageError,
    UnsupportedEventTypeError=UnsupportedEventTypeError,
    WaitSet=_wait_set,
    rcl_publisher_event_type_t=QoSPublisherEventType,
    rcl_subscription_event_type_t=QoSSubscriptionEventType,
    rmw_qos_profile_t=SimpleNamespace(predefined=_predefined),
)
