"""``launch.frontend``."""

from .expose import expose_action, expose_substitution

__all__ = ["expose_action", "expose_substitution"]
