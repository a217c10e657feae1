"""``launch_ros.actions.load_composable_nodes``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from launch._texts import template
from launch.action import Action

from .._components import Components
from ..descriptions.composable_node import ComposableNode
from .composable_node_container import ComposableNodeContainer

if TYPE_CHECKING:
    from launch.some_substitutions_type import SomeSubstitutionsType


class LoadComposableNodes(Action):
    """Loads components into a container that runs; they are refused, as libraries of C++.

    Args:
        composable_node_descriptions: The components.
        target_container: The container, or its name.
        kwargs: What `Action` takes.
    """

    # Any: the words of Action.
    def __init__(
        self,
        *,
        composable_node_descriptions: Iterable[ComposableNode],
        target_container: SomeSubstitutionsType | ComposableNodeContainer,
        **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        self._components = tuple(composable_node_descriptions)
        self._container = (
            target_container._node_name  # noqa: SLF001 -- known before it is evaluated
            if isinstance(target_container, ComposableNodeContainer)
            else template(target_container)
        )

    def model_action(self) -> Components:
        """Return what the model does for it."""
        return Components(self._container, self._components)
