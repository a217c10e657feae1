"""``launch_ros.descriptions.composable_lifecycle_node``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from launch._texts import optional, template

from teleopctl.launch import ComponentPart, Template

from .composable_node import ComposableNode

if TYPE_CHECKING:
    from launch.some_substitutions_type import SomeSubstitutionsType


class ComposableLifecycleNode(ComposableNode):
    """Lifecycle node that is loaded into a container.

    Args:
        autostart: Whether it is configured and activated once it is loaded.
        kwargs: Further arguments of `ComposableNode`.
    """

    # Any: arguments of `ComposableNode.`
    def __init__(self, *, autostart: bool | SomeSubstitutionsType = False, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._autostart = optional(autostart) or template("false")

    @property
    def node_autostart(self) -> Template:
        """Whether the node is configured and activated after loading."""
        return self._autostart

    def component(self, autostart: Template | None = None) -> ComponentPart:
        """Return the component as one of `teleopctl.launch`; raises as that of the base class."""
        return super().component(autostart or self._autostart)
