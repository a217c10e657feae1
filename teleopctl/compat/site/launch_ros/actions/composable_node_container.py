"""``launch_ros.actions.composable_node_container``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from teleopctl.launch import Action

from .._components import Components
from ..descriptions.composable_node import ComposableNode
from .node import Node

if TYPE_CHECKING:
    from launch.some_substitutions_type import SomeSubstitutionsType


class ComposableNodeContainer(Node):
    """A process that components are loaded into.

    Components are libraries of C++, so that it is refused when it has one.

    Args:
        name: The container's name.
        namespace: Its namespace.
        composable_node_descriptions: Its components.
        kwargs: What `Node` takes.
    """

    # Any: the words of Node.
    def __init__(
        self,
        *,
        name: SomeSubstitutionsType,
        namespace: SomeSubstitutionsType,
        composable_node_descriptions: Iterable[ComposableNode] | None = None,
        **kwargs: Any,
    ) -> None:
        super().__init__(name=name, namespace=namespace, **kwargs)
        self._components = tuple(composable_node_descriptions or ())

    def model_action(self) -> Action:
        """Return what the model does for it."""
        return Components(self._node_name, self._components, (super().model_action(),))
