"""``launch_ros.actions.load_composable_nodes``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from launch._texts import template
from launch.action import Action

from teleopctl.launch import LoadComponents, Template, dataclass

from ..descriptions.composable_node import ComposableNode
from .composable_node_container import ComposableNodeContainer

if TYPE_CHECKING:
    from launch.some_substitutions_type import SomeSubstitutionsType


class LoadComposableNodes(Action):
    """Loads components into a container, one after the other, once it is there.

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
            Template((_NameOf(target_container),), target_container.describe())
            if isinstance(target_container, ComposableNodeContainer)
            else template(target_container)
        )

    def model_action(self) -> LoadComponents:
        """Return what the model does for it."""
        return LoadComponents(
            container=self._container,
            components=tuple(each.component() for each in self._components),
        )


@dataclass(frozen=True, slots=True)
class _NameOf:
    """The name of a container, which is known once that is evaluated."""

    container: ComposableNodeContainer

    @property
    def source(self) -> str:
        """The container in words."""
        return self.container.describe()

    def evaluate(self, _context: object) -> str:
        """Return the name."""
        return self.container.node_name
