"""``launch.actions.shutdown_action``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from teleopctl.launch import Shutdown as ModelShutdown

from .._texts import template
from ..action import Action

if TYPE_CHECKING:
    from ..some_substitutions_type import SomeSubstitutionsType


class Shutdown(Action):
    """Shuts the launch down.

    Args:
        reason: Why.
        kwargs: Further arguments of `Action`.
    """

    # Any: arguments of `Action.`
    def __init__(
        self, *, reason: SomeSubstitutionsType = "reason not given", **kwargs: Any
    ) -> None:
        super().__init__(**kwargs)
        self._reason = template(reason)

    def model_action(self) -> ModelShutdown:
        """Return the corresponding action of `teleopctl.launch`."""
        return ModelShutdown(reason=self._reason)
