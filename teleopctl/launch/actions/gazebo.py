"""Launch actions of ``ros_gz_sim`` and ``ros_gz_bridge``, each for the launch file of its name."""

from __future__ import annotations

from teleopctl.base.typed import ClassVar, Self
from teleopctl.launch.actions.nesting import set_included_arguments
from teleopctl.launch.model.action import Action, Entity, Launch
from teleopctl.launch.model.records import dataclass
from teleopctl.launch.model.template import Template, literal
from teleopctl.packages import package_share

_COMPOSITION = ("container_name", "create_own_container", "use_composition")


@dataclass(frozen=True, slots=True)
class LaunchFileOf(Action):
    """Base of launch actions that include a package's launch file, with their keys as arguments.

    Attributes:
        arguments: Launch arguments that the entry gives, as key and value.
    """

    package: ClassVar[str]
    file: ClassVar[str]
    required: ClassVar[tuple[str, ...]] = ()
    # Names of launch arguments that differ from their keys, by key.
    names: ClassVar[dict[str, str]] = {}

    arguments: tuple[tuple[str, Template], ...]

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Return the action with the keys of a launch file's entry as launch arguments."""
        needed = [(key, entity.required(key)) for key in cls.required]
        others = [(key, entity.optional(key)) for key in cls.keys if key not in cls.required]
        return cls((*needed, *((key, value) for key, value in others if value is not None)))

    def evaluate(self, launch: Launch) -> None:
        """Include the launch file of the package, with the launch arguments."""
        set_included_arguments(
            tuple((literal(self.names.get(key, key)), value) for key, value in self.arguments),
            launch,
        )
        launch.include(package_share(self.package) / "launch" / self.file)


class GzServer(LaunchFileOf):
    """``gz_server``: starts the simulator without a window, as ``ros_gz_sim`` does."""

    __slots__ = ()
    package = "ros_gz_sim"
    file = "gz_server.launch.py"
    keys = ("world_sdf_file", "world_sdf_string", *_COMPOSITION)


class GzSpawnModel(LaunchFileOf):
    """``gz_spawn_model``: spawns a model in the simulator, as ``ros_gz_sim`` does."""

    __slots__ = ()
    package = "ros_gz_sim"
    file = "gz_spawn_model.launch.py"
    names: ClassVar = {"roll": "R", "pitch": "P", "yaw": "Y"}
    keys = (
        *("world", "file", "model_string", "topic", "entity_name", "allow_renaming"),
        *("x", "y", "z", "roll", "pitch", "yaw"),
    )


class RosGzBridge(LaunchFileOf):
    """``ros_gz_bridge``: starts ``ros_gz_bridge``'s bridge between topics of Gazebo and ROS."""

    __slots__ = ()
    package = "ros_gz_bridge"
    file = "ros_gz_bridge.launch.py"
    required = ("bridge_name", "config_file")
    keys = (*required, *_COMPOSITION, "namespace", "use_respawn", "log_level")
