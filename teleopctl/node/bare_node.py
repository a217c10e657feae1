"""A node for a moment: without parameters and log topic, on the system's time."""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING, Literal
from teleopctl.node.context import Context
from teleopctl.node.node_endpoints import NodeEndpoints

if TYPE_CHECKING:
    from teleopctl.node.endpoints.qos_overrides import QoSOverridingOptions
    from teleopctl.node.values.qos import QoSProfile


class BareNode(NodeEndpoints):
    """Node without parameters, /rosout and /clock, for commands that need it once (ours).

    Starts in half the time of a `Node`, for what a command does once. It answers no question about
    parameters, publishes no log and does not follow ``/clock``.

    Args:
        node_name: Its name; command-line arguments do not change it.
        context: Where it lives.

    Raises:
        NotInitializedException: The context does not run.
        InvalidNodeNameException: The name breaks a rule.
    """

    def __init__(self, node_name: str, context: Context) -> None:
        super().__init__(node_name, context, None, None, use_global_arguments=False)
        self._announce()

    def _overridden_qos(
        self,
        profile: QoSProfile,
        options: QoSOverridingOptions,  # noqa: ARG002 -- of parameters, which it has not
        side: Literal["publisher", "subscription"],  # noqa: ARG002
        topic: str,  # noqa: ARG002
    ) -> QoSProfile:
        return profile
