"""``launch.actions.reset_launch_configurations``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from teleopctl.launch import Reset

from .._texts import pairs
from ..action import Action

if TYPE_CHECKING:
    from ..some_substitutions_type import SomeSubstitutionsType


class ResetLaunchConfigurations(Action):
    """Removes all launch configurations, and sets the given ones.

    Args:
        launch_configurations: Configurations to set afterwards, evaluated before the reset.
        kwargs: Further arguments of `Action`.
    """

    # Any: arguments of `Action`; names are whatever text a dictionary can have.
    def __init__(
        self,
        launch_configurations: Mapping[Any, SomeSubstitutionsType] | None = None,
        **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        self._launch_configurations = launch_configurations

    def model_action(self) -> Reset:
        """Return the corresponding action of `teleopctl.launch`."""
        return Reset(keep=pairs(self._launch_configurations))
