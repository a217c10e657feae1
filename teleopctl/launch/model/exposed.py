"""Actions and substitutions that programs have made known to the text front ends."""

from __future__ import annotations

from collections.abc import Callable

from teleopctl.launch.model.action import Step
from teleopctl.launch.model.element import Element
from teleopctl.launch.model.template import Call, Template

exposed_actions: dict[str, Callable[[str, Element], Step]] = {}
"""What reads an action, by its name."""

exposed_substitutions: dict[str, Callable[[Call], Template]] = {}
"""What a substitution is, by its name."""
