"""Floor 2: the client library. Names and meanings are rclpy's.

The names load what they need when they are first used, so that importing this package costs
nothing.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from teleopctl.node.clock import Clock as Clock
    from teleopctl.node.clock import ROSClock as ROSClock
    from teleopctl.node.context import Context as Context
    from teleopctl.node.endpoints.client import Client as Client
    from teleopctl.node.endpoints.publisher import Publisher as Publisher
    from teleopctl.node.endpoints.service import Service as Service
    from teleopctl.node.endpoints.subscription import Subscription as Subscription
    from teleopctl.node.endpoints.timer import Timer as Timer
    from teleopctl.node.executor import (
        Executor as Executor,
    )
    from teleopctl.node.executor import (
        MultiThreadedExecutor as MultiThreadedExecutor,
    )
    from teleopctl.node.executor import (
        SingleThreadedExecutor as SingleThreadedExecutor,
    )
    from teleopctl.node.lifetime import create_node as create_node
    from teleopctl.node.lifetime import (
        get_default_context as get_default_context,
    )
    from teleopctl.node.lifetime import (
        get_global_executor as get_global_executor,
    )
    from teleopctl.node.lifetime import init as init
    from teleopctl.node.lifetime import ok as ok
    from teleopctl.node.lifetime import shutdown as shutdown
    from teleopctl.node.lifetime import spin as spin
    from teleopctl.node.lifetime import spin_once as spin_once
    from teleopctl.node.lifetime import (
        spin_until_future_complete as spin_until_future_complete,
    )
    from teleopctl.node.lifetime import try_shutdown as try_shutdown
    from teleopctl.node.node import Node as Node
    from teleopctl.node.values.callback_groups import (
        CallbackGroup as CallbackGroup,
    )
    from teleopctl.node.values.callback_groups import (
        MutuallyExclusiveCallbackGroup as MutuallyExclusiveCallbackGroup,
    )
    from teleopctl.node.values.callback_groups import (
        ReentrantCallbackGroup as ReentrantCallbackGroup,
    )
    from teleopctl.node.values.exceptions import (
        ExternalShutdownException as ExternalShutdownException,
    )
    from teleopctl.node.values.exceptions import (
        ServiceUnavailableError as ServiceUnavailableError,
    )
    from teleopctl.node.values.future import Future as Future
    from teleopctl.node.values.logging import get_logger as get_logger
    from teleopctl.node.values.parameter import Parameter as Parameter
    from teleopctl.node.values.qos import DurabilityPolicy as DurabilityPolicy
    from teleopctl.node.values.qos import HistoryPolicy as HistoryPolicy
    from teleopctl.node.values.qos import LivelinessPolicy as LivelinessPolicy
    from teleopctl.node.values.qos import QoSPresetProfiles as QoSPresetProfiles
    from teleopctl.node.values.qos import QoSProfile as QoSProfile
    from teleopctl.node.values.qos import ReliabilityPolicy as ReliabilityPolicy
    from teleopctl.node.values.qos import qos_profile_latched as qos_profile_latched
    from teleopctl.node.values.qos import (
        qos_profile_sensor_data as qos_profile_sensor_data,
    )
    from teleopctl.node.values.time import ClockType as ClockType
    from teleopctl.node.values.time import Duration as Duration
    from teleopctl.node.values.time import Time as Time

_MODULE_OF = {
    name: module
    for module, names in {
        "values.callback_groups": "CallbackGroup MutuallyExclusiveCallbackGroup "
        "ReentrantCallbackGroup",
        "endpoints.client": "Client",
        "clock": "Clock ROSClock",
        "context": "Context",
        "values.exceptions": "ExternalShutdownException ServiceUnavailableError",
        "executor": "Executor MultiThreadedExecutor SingleThreadedExecutor",
        "values.future": "Future",
        "lifetime": "create_node get_default_context get_global_executor init ok shutdown spin "
        "spin_once spin_until_future_complete try_shutdown",
        "values.logging": "get_logger",
        "node": "Node",
        "values.parameter": "Parameter",
        "endpoints.publisher": "Publisher",
        "values.qos": "DurabilityPolicy HistoryPolicy LivelinessPolicy QoSPresetProfiles "
        "QoSProfile ReliabilityPolicy qos_profile_latched qos_profile_sensor_data",
        "endpoints.service": "Service",
        "endpoints.subscription": "Subscription",
        "values.time": "ClockType Duration Time",
        "endpoints.timer": "Timer",
    }.items()
    for name in names.split()
}

__all__ = sorted(_MODULE_OF)


def __getattr__(name: str) -> Any:
    if name not in _MODULE_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(f"{__name__}.{_MODULE_OF[name]}"), name)
    globals()[name] = value
    return value
