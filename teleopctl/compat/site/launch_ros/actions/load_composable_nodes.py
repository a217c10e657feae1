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
    from composition_interfaces.srv import LoadNode
    from launch.launch_context import LaunchContext
    from launch.some_substitutions_type import SomeSubstitutionsType


class LoadComposableNodes(Action):
    """Loads components into a container one after another, once the container runs.

    Args:
        composable_node_descriptions: The components.
        target_container: The container, or its name.
        kwargs: Further arguments of `Action`.
    """

    # Any: arguments of `Action.`
    def __init__(
        self,
        *,
        composable_node_descriptions: Iterable[ComposableNode],
        target_container: SomeSubstitutionsType | ComposableNodeContainer,
        **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        self._components = tuple(composable_node_descriptions)
        self._target = target_container
        self._container = (
            Template((_NameOf(target_container),), target_container.describe())
            if isinstance(target_container, ComposableNodeContainer)
            else template(target_container)
        )

    def model_action(self) -> LoadComponents:
        """Return the corresponding action of `teleopctl.launch`."""
        return LoadComponents(
            container=self._container,
            components=tuple(each.component() for each in self._components),
        )


@dataclass(frozen=True, slots=True)
class _NameOf:
    """Text with a container's name, which is known once the container is evaluated."""

    container: ComposableNodeContainer

    @property
    def source(self) -> str:
        """Readable form of the container."""
        return self.container.describe()

    def evaluate(self, _context: object) -> str:
        """Return the name of the container."""
        return self.container.node_name


def get_composable_node_load_request(
    composable_node_description: ComposableNode, context: LaunchContext
) -> LoadNode.Request | None:
    """Return the ``load_node`` request of a component; None if its condition is false.

    Args:
        composable_node_description: The component.
        context: Context with the pushed namespaces, remappings and parameters.
    """
    from launch.launch_context import LaunchContext

    with LaunchContext.standing_for(context) as known:
        return _load_request(composable_node_description, known)


def _load_request(described: ComposableNode, context: LaunchContext) -> LoadNode.Request | None:
    from composition_interfaces.srv import LoadNode

    from ..utilities import (
        evaluate_parameters,
        make_namespace_absolute,
        normalize_parameters,
        prefix_namespace,
        to_parameters_list,
    )

    condition = described.condition()
    if condition is not None and not condition.evaluate(context):
        return None

    def text(given: SomeSubstitutionsType | Template | None) -> str | None:
        if given is None:
            return None
        return context.text(given if isinstance(given, Template) else template(given))

    configurations = context.launch_configurations
    namespace = make_namespace_absolute(
        prefix_namespace(configurations.get("ros_namespace"), text(described.node_namespace))
    )
    name = text(described.node_name) or ""
    remaps = [f"{source}:={target}" for source, target in configurations.get("ros_remaps") or ()]
    remaps += [f"{text(source)}:={text(target)}" for source, target in described.remappings or ()]
    everywhere = [
        {given[0]: given[1]} if isinstance(given, tuple) else given
        for given in configurations.get("global_params") or ()
    ]

    def messages(given: Iterable[Any]) -> list[Any]:
        evaluated = evaluate_parameters(context, normalize_parameters(list(given)))
        found = to_parameters_list(context, name, namespace or "", evaluated)
        return [parameter.to_parameter_msg() for parameter in found]

    return LoadNode.Request(
        package_name=text(described.package) or "",
        plugin_name=text(described.node_plugin) or "",
        node_name=name,
        node_namespace=namespace or "",
        remap_rules=remaps,
        parameters=messages([*everywhere, *(described.parameters or ())]),
        extra_arguments=messages(described.extra_arguments or ()),
    )
