"""``launch_ros.actions.composable_node_container``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from teleopctl.launch import Action, Launch, LoadComponents, dataclass, literal

from ..descriptions.composable_node import ComposableNode
from .node import Node

if TYPE_CHECKING:
    from launch.some_substitutions_type import SomeSubstitutionsType


class ComposableNodeContainer(Node):
    """Starts a component container.

    Args:
        name: The container's name.
        namespace: Its namespace.
        composable_node_descriptions: Its components.
        kwargs: Further arguments of `Node`.
    """

    # Any: arguments of `Node.`
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
        """Return the corresponding action of `teleopctl.launch`."""
        return _Contained(self, self._components)


@dataclass(frozen=True, slots=True)
class _Contained(Action):
    """Action of `teleopctl.launch` that starts a container and loads its components."""

    container: ComposableNodeContainer
    components: tuple[ComposableNode, ...]

    def evaluate(self, launch: Launch) -> Iterable[Action]:
        """Start the container, and queue its components."""
        plan = launch.start(self.container.process())
        if not launch.is_trial:
            self.container.planned(plan, launch)
        assert plan.node_name is not None, "it has a name"
        parts = tuple(each.component() for each in self.components)
        return (LoadComponents(container=literal(plan.node_name), components=parts),)
