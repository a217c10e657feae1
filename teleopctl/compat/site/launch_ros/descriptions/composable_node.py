"""``launch_ros.descriptions.composable_node``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from launch._texts import optional, template

if TYPE_CHECKING:
    from launch.condition import Condition
    from launch.some_substitutions_type import SomeSubstitutionsType

    from ..parameters_type import SomeParameters
    from ..remap_rule_type import SomeRemapRules


class ComposableNode:
    """A node that is loaded into a container.

    Args:
        package: The package that offers it.
        plugin: Its class.
        name: Its name.
        namespace: Its namespace.
        parameters: Its parameters.
        remappings: Pairs from, to.
        extra_arguments: Further arguments of loading.
        condition: Has to hold for it to be loaded.
    """

    # Any: values of any kind.
    def __init__(
        self,
        *,
        package: SomeSubstitutionsType,
        plugin: SomeSubstitutionsType,
        name: SomeSubstitutionsType | None = None,
        namespace: SomeSubstitutionsType | None = None,
        parameters: SomeParameters | None = None,
        remappings: SomeRemapRules | None = None,
        extra_arguments: list[dict[str, Any]] | None = None,
        condition: Condition | None = None,
    ) -> None:
        self.package = template(package)
        self.node_plugin = template(plugin)
        self.node_name = optional(name)
        self.node_namespace = optional(namespace)
        self.parameters = parameters
        self.remappings = remappings
        self.extra_arguments = extra_arguments
        self._condition = condition

    def condition(self) -> Condition | None:
        """What has to hold for it to be loaded, or None."""
        return self._condition
