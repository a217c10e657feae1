"""QoS overrides by parameters, with the names of ``rclpy.qos_overriding_options``.

The parameters are ``qos_overrides.TOPIC.publisher.POLICY``, or ``….publisher_ID.POLICY`` with an
entity ID, and likewise for subscriptions; they are read-only.
"""

from __future__ import annotations

import copy
import dataclasses
import enum
from collections.abc import Callable, Iterable

from teleopctl.base.typed import TYPE_CHECKING, Any, Literal, TypeAlias
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import get_message
from teleopctl.node.values.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSProfile,
    ReliabilityPolicy,
)
from teleopctl.node.values.time import Duration

if TYPE_CHECKING:
    from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult

    from teleopctl.interfaces import AllowableParameterValue
    from teleopctl.node.values.parameter import Parameter

# Node.declare_parameter, or a function that returns a parameter that is declared already.
Declare: TypeAlias = "Callable[[str, AllowableParameterValue, ParameterDescriptor], Parameter]"


class QoSPolicyKind(enum.IntEnum):
    """Kinds of QoS policies, numbered as in ``rmw/qos_policy_kind.h``."""

    INVALID = 1
    DURABILITY = 2
    DEADLINE = 4
    LIVELINESS = 8
    RELIABILITY = 16
    HISTORY = 32
    LIFESPAN = 64
    DEPTH = 128
    LIVELINESS_LEASE_DURATION = 256
    AVOID_ROS_NAMESPACE_CONVENTIONS = 512


_POLICIES = {
    QoSPolicyKind.DURABILITY: DurabilityPolicy,
    QoSPolicyKind.LIVELINESS: LivelinessPolicy,
    QoSPolicyKind.RELIABILITY: ReliabilityPolicy,
    QoSPolicyKind.HISTORY: HistoryPolicy,
}
_DURATIONS = (
    QoSPolicyKind.DEADLINE,
    QoSPolicyKind.LIFESPAN,
    QoSPolicyKind.LIVELINESS_LEASE_DURATION,
)


class InvalidQosOverridesError(TeleopctlError):
    """A QoS override has an invalid value, or the callback rejected the profile."""


@dataclasses.dataclass(frozen=True)
class QoSOverridingOptions:
    """Options of an endpoint: QoS policies that parameters may override, and a validation.

    Attributes:
        policy_kinds: Kinds of the policies that parameters may override.
        callback: Called with the resulting profile; returns a
            ``rcl_interfaces/msg/SetParametersResult`` that accepts or rejects the profile.
        entity_id: Suffix of the parameter names, to distinguish endpoints of the same topic.
    """

    policy_kinds: Iterable[QoSPolicyKind]
    callback: Callable[[QoSProfile], SetParametersResult] | None = dataclasses.field(
        default=None, kw_only=True
    )
    entity_id: str | None = dataclasses.field(default=None, kw_only=True)

    @classmethod
    def with_default_policies(
        cls,
        *,
        callback: Callable[[QoSProfile], SetParametersResult] | None = None,
        entity_id: str | None = None,
    ) -> QoSOverridingOptions:
        """Return options that let history, depth and reliability be overridden."""
        kinds = (QoSPolicyKind.HISTORY, QoSPolicyKind.DEPTH, QoSPolicyKind.RELIABILITY)
        return cls(kinds, callback=callback, entity_id=entity_id)


def apply_qos_overrides(
    profile: QoSProfile,
    options: QoSOverridingOptions,
    side: Literal["publisher", "subscription"],
    topic: str,
    declare: Declare,
) -> QoSProfile:
    """Declare an endpoint's QoS override parameters; return the profile with their values.

    Args:
        profile: Profile given by the program.
        options: Policies that may be overridden, and validation.
        side: Kind of the endpoint.
        topic: Fully qualified name of the topic.
        declare: Declares a parameter by name, default and descriptor, and returns the parameter.

    Raises:
        InvalidQosOverridesError: A value is invalid for its policy, or the callback rejects the
            profile.
    """
    result = copy.copy(profile)
    suffix = "" if options.entity_id is None else f"_{options.entity_id}"
    for kind in options.policy_kinds:
        if kind is QoSPolicyKind.LIFESPAN and side == "subscription":
            continue
        attribute = kind.name.lower()
        descriptor = get_message("rcl_interfaces/msg/ParameterDescriptor")(
            description=f"{attribute} of the {side} on `{topic}`", read_only=True
        )
        name = f"qos_overrides.{topic}.{side}{suffix}.{attribute}"
        parameter = declare(name, _as_parameter(kind, getattr(result, attribute)), descriptor)
        setattr(result, attribute, _as_policy(kind, parameter))
    if options.callback is not None:
        answer = options.callback(result)
        if not answer.successful:
            raise InvalidQosOverridesError(
                f"the overrides of the {side} on '{topic}' are refused: {answer.reason}"
            )
    return result


def _as_parameter(kind: QoSPolicyKind, value: Any) -> Any:
    if kind in _POLICIES:
        return value.short_key
    return value.nanoseconds if kind in _DURATIONS else value


def _as_policy(kind: QoSPolicyKind, parameter: Parameter) -> Any:
    if kind in _DURATIONS:
        return Duration(nanoseconds=parameter.value)
    if kind not in _POLICIES:
        return parameter.value
    try:
        return _POLICIES[kind].get_from_short_key(parameter.value)
    except TeleopctlError as error:
        raise InvalidQosOverridesError(
            f"{parameter.name}: {error.message}", hint=error.hint
        ) from error
