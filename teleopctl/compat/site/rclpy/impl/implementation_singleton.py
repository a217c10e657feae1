"""``rclpy.impl.implementation_singleton``. The parts of rclpy's C bindings that programs use."""

import time
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from rclpy.event_handler import (
    QoSPublisherEventType,
    QoSSubscriptionEventType,
    UnsupportedEventTypeError,
    event_handle,
)
from teleopctl.errors import UsageError
from teleopctl.interfaces import MessageT, RequestT, ResponseT
from teleopctl.node import (
    Caller,
    GuardHandle,
    Handle,
    InvalidHandle,
    LifecycleStateMachine,
    LoggingSeverity,
    NodeNameNonExistentError,
    QoSPresetProfiles,
    QoSProfile,
    RCLError,
    SubscriptionHandle,
    TimerCancelledError,
    TransitionCallbackReturn,
    WaitSet,
    create_polled_client,
    create_polled_service,
    create_polled_subscription,
    create_polled_timer,
    emit_log,
)

if TYPE_CHECKING:
    from teleopctl.interfaces import ServiceType

__all__ = ["rclpy_implementation"]


def _wait_set(*numbers_and_context: Any) -> WaitSet:
    """Return a wait set; the numbers of entities are not needed."""
    *_, context = numbers_and_context
    return WaitSet(context.entity)


def _subscription(
    node: Handle, msg_type: type[MessageT], topic: str, qos: QoSProfile
) -> SubscriptionHandle:
    return create_polled_subscription(node.entity, msg_type, topic, qos)


# Any: a handle of the client has its own class.
def _client(
    node: Handle, srv_type: "type[ServiceType[RequestT, ResponseT]]", name: str, qos: QoSProfile
) -> Any:
    return create_polled_client(node.entity, srv_type, name, qos)


def _service(
    node: Handle, srv_type: "type[ServiceType[RequestT, ResponseT]]", name: str, qos: QoSProfile
) -> Any:
    return create_polled_service(node.entity, srv_type, name, qos)


def _timer(clock: Handle, context: Handle, period_nsec: int, autostart: bool = True) -> Any:
    del context  # rclpy's: it belongs to no session
    return create_polled_timer(clock.entity, period_nsec, autostart=autostart)


def _log(severity: int, name: str, message: str, function: str, file: str, line: int) -> None:
    """Log a message of a place in a program, without a check of the level."""
    emit_log(LoggingSeverity(severity), name, message, Caller(file, function, line), time.time_ns())


def _predefined(name: str) -> QoSProfile:
    """Return the profile that rmw has by a name such as ``qos_profile_default``."""
    profile = QoSPresetProfiles[name.removeprefix("qos_profile_").upper()].value
    assert isinstance(profile, QoSProfile)
    return profile


rclpy_implementation = SimpleNamespace(
    Client=_client,
    EventHandle=event_handle,
    GuardCondition=GuardHandle,
    InvalidHandle=InvalidHandle,
    LifecycleStateMachine=LifecycleStateMachine,
    NodeNameNonExistentError=NodeNameNonExistentError,
    RCLError=RCLError,
    RCLInvalidROSArgsError=UsageError,
    Service=_service,
    Subscription=_subscription,
    Timer=_timer,
    TimerCancelledError=TimerCancelledError,
    TransitionCallbackReturnType=TransitionCallbackReturn,
    UnknownROSArgsError=UsageError,
    UnsupportedEventTypeError=UnsupportedEventTypeError,
    WaitSet=_wait_set,
    rcl_publisher_event_type_t=QoSPublisherEventType,
    rcl_subscription_event_type_t=QoSSubscriptionEventType,
    rclpy_logging_rcutils_log=_log,
    rmw_qos_profile_t=SimpleNamespace(predefined=_predefined),
)
