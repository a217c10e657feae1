"""``ros_gz_bridge.actions.ros_gz_bridge``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from launch._texts import given
from launch.action import Action

from teleopctl.launch import RosGzBridge as ModelRosGzBridge

if TYPE_CHECKING:
    from launch.some_substitutions_type import SomeSubstitutionsType


class RosGzBridge(Action):
    """Starts a bridge between topics of the simulator and of ROS.

    Args:
        bridge_name: The node's name.
        config_file: The file of its topics.
        container_name: Where it would be loaded.
        create_own_container: Whether it would be loaded into a container of its own.
        use_composition: Whether it would be loaded into a container; it is a process of its own.
        namespace: Its namespace.
        use_respawn: Whether it is started again when it ends.
        log_level: The lowest level of its messages.
        kwargs: Further arguments of `Action`.
    """

    # Any: arguments of `Action.`
    def __init__(
        self,
        *,
        bridge_name: SomeSubstitutionsType,
        config_file: SomeSubstitutionsType,
        container_name: SomeSubstitutionsType | None = None,
        create_own_container: SomeSubstitutionsType | None = None,
        use_composition: SomeSubstitutionsType | None = None,
        namespace: SomeSubstitutionsType | None = None,
        use_respawn: SomeSubstitutionsType | None = None,
        log_level: SomeSubstitutionsType | None = None,
        **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        self._given = given(
            bridge_name=bridge_name,
            config_file=config_file,
            container_name=container_name,
            create_own_container=create_own_container,
            use_composition=use_composition,
            namespace=namespace,
            use_respawn=use_respawn,
            log_level=log_level,
        )

    def model_action(self) -> ModelRosGzBridge:
        """Return the corresponding action of `teleopctl.launch`."""
        return ModelRosGzBridge(self._given)
