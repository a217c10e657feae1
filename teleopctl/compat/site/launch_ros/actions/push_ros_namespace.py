"""``launch_ros.actions.push_ros_namespace``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from launch._texts import template
from launch.action import Action

from teleopctl.launch import PushNamespace, Template

if TYPE_CHECKING:
    from launch.some_substitutions_type import SomeSubstitutionsType


class PushROSNamespace(Action):
    """Adds a namespace to the following nodes of the scope.

    Args:
        namespace: The namespace.
        kwargs: Further arguments of `Action`.
    """

    # Any: arguments of `Action.`
    def __init__(self, namespace: SomeSubstitutionsType, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._namespace = template(namespace)

    @property
    def namespace(self) -> Template:
        """The namespace."""
        return self._namespace

    def model_action(self) -> PushNamespace:
        """Return the corresponding action of `teleopctl.launch`."""
        return PushNamespace(namespace=self._namespace)
