"""``controller_manager.launch_utils``: descriptions that start controllers by a spawner."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from launch import LaunchDescription, SomeSubstitutionsType
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PythonExpression
from launch_ros.actions import Node

_Files = str | list[str] | None


def generate_controllers_spawner_launch_description(
    controller_names: Sequence[str],
    controller_params_files: Iterable[SomeSubstitutionsType] | None = None,
    extra_spawner_args: Sequence[SomeSubstitutionsType] = (),
    *,
    controller_type: str | None = None,
) -> LaunchDescription:
    """Return a launch description that spawns controllers, with launch arguments for the spawner.

    Args:
        controller_names: The controllers.
        controller_params_files: Parameter files for them.
        extra_spawner_args: Further arguments of the spawner.
        controller_type: Their type, of ROS 2 before Jazzy.
    """
    manager = LaunchConfiguration("controller_manager_name")
    unload = PythonExpression(
        ["'--unload-on-kill' if '", LaunchConfiguration("unload_on_kill"), "' == 'true' else ''"]
    )
    files = (word for file in controller_params_files or () if file for word in _file(file))
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "controller_manager_name",
                default_value="controller_manager",
                description="Name of the controller manager's node",
            ),
            DeclareLaunchArgument(
                "unload_on_kill",
                default_value="false",
                description="Whether the spawner stays, and unloads the controllers at its end",
            ),
            _spawner(
                [
                    *controller_names,
                    "--controller-manager",
                    manager,
                    *files,
                    *(["--controller-type", controller_type] if controller_type else []),
                    unload,
                    *extra_spawner_args,
                ]
            ),
        ]
    )


def generate_controllers_spawner_launch_description_from_dict(
    controller_info_dict: Mapping[str, _Files],
    extra_spawner_args: Sequence[SomeSubstitutionsType] = (),
) -> LaunchDescription:
    """Return a launch description that spawns controllers, each with its parameter files.

    Args:
        controller_info_dict: The parameter file, several of them or None, by controller.
        extra_spawner_args: Further arguments of the spawner.

    Raises:
        ValueError: The mapping is none, or there is something else in it.
    """
    _check_is_mapping(controller_info_dict)
    return generate_controllers_spawner_launch_description(
        list(controller_info_dict),
        [file for given in controller_info_dict.values() for file in _files(given)],
        extra_spawner_args,
    )


def generate_load_controller_launch_description(
    controller_name: str,
    controller_params_file: SomeSubstitutionsType | None = None,
    extra_spawner_args: Sequence[SomeSubstitutionsType] = (),
    *,
    controller_type: str | None = None,
) -> LaunchDescription:
    """Return a launch description that spawns one controller.

    Args:
        controller_name: The controller.
        controller_params_file: A parameter file for it.
        extra_spawner_args: Further arguments of the spawner.
        controller_type: Its type, of ROS 2 before Jazzy.
    """
    files = [controller_params_file] if controller_params_file else None
    return generate_controllers_spawner_launch_description(
        [controller_name], files, extra_spawner_args, controller_type=controller_type
    )


# Any: each setting has a type of its own.
def generate_spawner_launch_description(
    controller_info_dict: Mapping[str, Mapping[str, Any]],
    extra_spawner_args: Sequence[SomeSubstitutionsType] = (),
) -> LaunchDescription:
    """Return a launch description that spawns controllers with options for each.

    Args:
        controller_info_dict: By controller: ``param_file`` (one or several), ``load_only``,
            ``inactive`` and ``ros_args``.
        extra_spawner_args: Further arguments of the spawner.

    Raises:
        ValueError: The mapping is none, or a setting has another type.
    """
    _check_is_mapping(controller_info_dict)
    words: list[SomeSubstitutionsType] = []
    for name, settings in controller_info_dict.items():
        words += ["--controller", name]
        for file in _files(settings.get("param_file")):
            words += _file(file)
        for key in ("load_only", "inactive"):
            if _setting(settings, key, bool, default=False):
                words.append(f"--{key.replace('_', '-')}")
        if "ros_args" in settings:
            words += ["--controller-ros-args", _setting(settings, "ros_args", str, default="")]
    return LaunchDescription([_spawner([*words, *extra_spawner_args])])


def _spawner(words: list[SomeSubstitutionsType]) -> Node:
    # The shell lets a word vanish that is empty, as that of `unload_on_kill` is.
    return Node(  # noqa: S604
        package="controller_manager",
        executable="spawner",
        arguments=words,
        shell=True,
        output="screen",
    )


def _file(file: SomeSubstitutionsType) -> list[SomeSubstitutionsType]:
    return ["--param-file", file]


# object: callers may pass anything, which is checked.
def _files(given: object) -> list[str]:
    if not given:
        return []
    if isinstance(given, str):
        return [given]
    if isinstance(given, list):
        return given
    raise ValueError(f"expected the path of a parameter file or a list of them, got {given!r}")


def _setting(settings: Mapping[str, Any], key: str, kind: type, *, default: Any) -> Any:
    value = settings.get(key, default)
    if not isinstance(value, kind):
        raise ValueError(f"'{key}': expected {kind.__name__}, got {value!r}")
    return value


def _check_is_mapping(given: object) -> None:
    if not isinstance(given, Mapping):
        raise ValueError(f"expected a mapping from controllers to settings, got {given!r}")
