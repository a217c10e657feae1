"""``launch.actions.declare_boolean_launch_argument``."""

from __future__ import annotations

from typing import Any

from teleopctl.launch import DeclareBoolean

from .declare_launch_argument import DeclareLaunchArgument


class DeclareBooleanLaunchArgument(DeclareLaunchArgument):
    """An argument of the launch file that is true or false.

    Args:
        name: Its name.
        default_value: Default value; None makes the argument required.
        description: Description for ``--show-args``.
        kwargs: Further arguments of `Action`.

    Raises:
        RuntimeError: The default is neither.
    """

    # Any: arguments of `Action.` object: texts with substitutions, and truth values.
    def __init__(
        self,
        name: str,
        *,
        default_value: object | None = None,
        description: str | None = None,
        **kwargs: Any,
    ) -> None:
        if isinstance(default_value, bool):
            default_value = str(default_value).lower()
        super().__init__(
            name,
            default_value=default_value,
            description=description,
            choices=DeclareBoolean.words,
            **kwargs,
        )
