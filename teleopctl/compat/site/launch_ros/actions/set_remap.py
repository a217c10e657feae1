"""``launch_ros.actions.set_remap``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from launch._texts import template
from launch.action import Action

from teleopctl.launch import SetRemap as ModelSetRemap, Template

if TYPE_CHECKING:
    from launch.some_substitutions_type import SomeSubstitutionsType


class SetRemap(Action):
    """Adds a remapping to the following nodes of the scope.

    Args:
        src: The name that is replaced.
        dst: The name in its place.
        kwargs: Further arguments of `Action`.
    """

    # Any: arguments of `Action.`
    def __init__(
        self, src: SomeSubstitutionsType, dst: SomeSubstitutionsType, **kwargs: Any
    ) -> None:
        super().__init__(**kwargs)
        self._src = template(src)
        self._dst = template(dst)

    @property
    def src(self) -> Template:
        """Name to replace."""
        return self._src

    @property
    def dst(self) -> Template:
        """Replacement."""
        return self._dst

    def model_action(self) -> ModelSetRemap:
        """Return the corresponding action of `teleopctl.launch`."""
        return ModelSetRemap(source=self._src, target=self._dst)
