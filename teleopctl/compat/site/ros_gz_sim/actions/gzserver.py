"""``ros_gz_sim.actions.gzserver``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from launch._texts import given
from launch.action import Action

from teleopctl.launch import GzServer as ModelGzServer

if TYPE_CHECKING:
    from launch.some_substitutions_type import SomeSubstitutionsType


class GzServer(Action):
    """Starts the simulator, unpaused.

    Args:
        world_sdf_file: A world.
        world_sdf_string: A world as text.
        container_name: Where it would be loaded.
        create_own_container: Whether it would be loaded into a container of its own.
        use_composition: Whether it would be loaded into a container; it is a process of its own.
        kwargs: Further arguments of `Action`.
    """

    # Any: arguments of `Action.`
    def __init__(
        self,
        *,
        world_sdf_file: SomeSubstitutionsType | None = None,
        world_sdf_string: SomeSubstitutionsType | None = None,
        container_name: SomeSubstitutionsType | None = None,
        create_own_container: SomeSubstitutionsType | None = None,
        use_composition: SomeSubstitutionsType | None = None,
        **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        self._given = given(
            world_sdf_file=world_sdf_file,
            world_sdf_string=world_sdf_string,
            container_name=container_name,
            create_own_container=create_own_container,
            use_composition=use_composition,
        )

    def model_action(self) -> ModelGzServer:
        """Return the corresponding action of `teleopctl.launch`."""
        return ModelGzServer(self._given)
