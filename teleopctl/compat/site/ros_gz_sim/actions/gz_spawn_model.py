"""``ros_gz_sim.actions.gz_spawn_model``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from launch._texts import given
from launch.action import Action

from teleopctl.launch import GzSpawnModel as ModelGzSpawnModel

if TYPE_CHECKING:
    from launch.some_substitutions_type import SomeSubstitutionsType


class GzSpawnModel(Action):
    """Spawns a robot in the simulator.

    Args:
        world: The world's name.
        file: The file of its description.
        model_string: Its description as text.
        topic: The topic of its description.
        entity_name: Its name.
        allow_renaming: Whether it may get another name.
        x: Where it stands, in metres.
        y: Likewise.
        z: Likewise.
        roll: How it stands, in radians.
        pitch: Likewise.
        yaw: Likewise.
        kwargs: Further arguments of `Action`.
    """

    # Any: arguments of `Action.`
    def __init__(
        self,
        *,
        world: SomeSubstitutionsType | None = None,
        file: SomeSubstitutionsType | None = None,
        model_string: SomeSubstitutionsType | None = None,
        topic: SomeSubstitutionsType | None = None,
        entity_name: SomeSubstitutionsType | None = None,
        allow_renaming: SomeSubstitutionsType | None = None,
        x: SomeSubstitutionsType | None = None,
        y: SomeSubstitutionsType | None = None,
        z: SomeSubstitutionsType | None = None,
        roll: SomeSubstitutionsType | None = None,
        pitch: SomeSubstitutionsType | None = None,
        yaw: SomeSubstitutionsType | None = None,
        **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        self._given = given(
            world=world,
            file=file,
            model_string=model_string,
            topic=topic,
            entity_name=entity_name,
            allow_renaming=allow_renaming,
            x=x,
            y=y,
            z=z,
            roll=roll,
            pitch=pitch,
            yaw=yaw,
        )

    def model_action(self) -> ModelGzSpawnModel:
        """Return the corresponding action of `teleopctl.launch`."""
        return ModelGzSpawnModel(self._given)
