"""``moveit_configs_utils.launch_utils``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from launch import LaunchDescription, SomeSubstitutionsType
from launch.actions import DeclareLaunchArgument
from launch.conditions import IfCondition, UnlessCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


class DeclareBooleanLaunchArg(DeclareLaunchArgument):
    """Declares a launch argument that is true or false.

    Args:
        name: Its name.
        default_value: Default value.
        description: Description for ``--show-args``.
        kwargs: Further arguments of `DeclareLaunchArgument`.
    """

    # Any: arguments of `DeclareLaunchArgument.`
    def __init__(
        self,
        name: str,
        *,
        default_value: bool = False,
        description: str | None = None,
        **kwargs: Any,
    ) -> None:
        super().__init__(
            name,
            default_value=str(default_value),
            description=description,
            choices=["true", "false", "True", "False"],
            **kwargs,
        )


# Any: arguments of `Node.`
def add_debuggable_node(
    ld: LaunchDescription,
    package: SomeSubstitutionsType,
    executable: SomeSubstitutionsType,
    condition_name: str = "debug",
    commands_file: str | None = None,
    extra_debug_args: Sequence[SomeSubstitutionsType] | None = None,
    **kwargs: Any,
) -> None:
    """Add a node twice: as it is, and with gdb, selected by a launch argument.

    Args:
        ld: The description.
        package: The package that offers the program.
        executable: The program.
        condition_name: The argument.
        commands_file: Commands for gdb.
        extra_debug_args: Further arguments of the program below gdb.
        kwargs: Further arguments of `Node`.
    """
    debug = LaunchConfiguration(condition_name)
    ld.add_action(
        Node(package=package, executable=executable, condition=UnlessCondition(debug), **kwargs)
    )
    if extra_debug_args and "arguments" in kwargs:
        kwargs["arguments"] = [*kwargs["arguments"], *extra_debug_args]
    commands = f"-x {commands_file} " if commands_file else ""
    ld.add_action(
        Node(
            package=package,
            executable=executable,
            condition=IfCondition(debug),
            prefix=[f"gdb {commands}--ex run --args"],
            **kwargs,
        )
    )
