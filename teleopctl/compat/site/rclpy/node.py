"""``rclpy.node``. Nodes."""

from typing import TYPE_CHECKING

from rclpy._imported import imported
from teleopctl.node import (
    Client,
    Node,
    NodeNameNonExistentError,
    Parameter,
    Publisher,
    Rate,
    Service,
    Subscription,
    Timer,
)

HIDDEN_NODE_PREFIX = "_"

__all__ = [
    "HIDDEN_NODE_PREFIX",
    "Client",
    "Node",
    "NodeNameNonExistentError",
    "Parameter",
    "Publisher",
    "Rate",
    "Service",
    "Subscription",
    "Timer",
]

if not TYPE_CHECKING:  # checkers know the documented names only
    __getattr__ = imported(__name__)
