"""``launch_ros.actions.lifecycle_node``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from launch._entities import steps
from launch._texts import optional, template

from teleopctl.launch import Launch, ProcessPlan, Template, flag

from .node import Node

if TYPE_CHECKING:
    from launch.some_substitutions_type import SomeSubstitutionsType


class LifecycleNode(Node):
    """Starts a lifecycle node; its transitions are events, and events request transitions.

    Args:
        name: The node's name.
        namespace: Its namespace.
        autostart: Whether it is configured and activated once it is there.
        kwargs: Further arguments of `Node`.
    """

    # Any: arguments of `Node.`
    def __init__(
        self,
        *,
        name: SomeSubstitutionsType,
        namespace: SomeSubstitutionsType,
        autostart: bool | SomeSubstitutionsType = False,
        **kwargs: Any,
    ) -> None:
        super().__init__(name=name, namespace=namespace, **kwargs)
        self._autostart = optional(autostart) or template("false")

    @property
    def node_autostart(self) -> Template:
        """Whether the node is configured and activated after its start."""
        return self._autostart

    @property
    def is_lifecycle_node(self) -> bool:
        """Whether the node is a lifecycle node."""
        return True

    def planned(self, plan: ProcessPlan, launch: Launch) -> None:
        """Record the evaluated process, which is about to start."""
        # Messages and nodes, which few launches need.
        from lifecycle_msgs.msg import Transition

        from .._lifecycle import LifecycleLink
        from .lifecycle_transition import LifecycleTransition

        super().planned(plan, launch)
        launch.register(LifecycleLink(self, plan, launch))
        if flag(launch.text(self._autostart)):
            launch.run(
                steps(
                    LifecycleTransition(
                        lifecycle_node_names=[self.node_name],
                        transition_ids=[
                            Transition.TRANSITION_CONFIGURE,
                            Transition.TRANSITION_ACTIVATE,
                        ],
                    )
                )
            )
