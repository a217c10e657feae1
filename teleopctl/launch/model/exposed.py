"""Actions and substitutions that programs have made known to the text front ends."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

from teleopctl import plugins
from teleopctl.launch.model.action import Step
from teleopctl.launch.model.element import Element
from teleopctl.launch.model.template import Call, Template

exposed_actions: dict[str, Callable[[str, Element], Step]] = {}
"""What reads an action, by its name."""

exposed_substitutions: dict[str, Callable[[Call], Template]] = {}
"""What a substitution is, by its name."""


@cache
def look_for_strangers() -> None:
    """Load, once, the launch extensions of installed distributions.

    It takes tens of milliseconds to look for them, so that is done when a name is not known.
    """
    plugins.imported(plugins.LAUNCH_EXTENSIONS)()
