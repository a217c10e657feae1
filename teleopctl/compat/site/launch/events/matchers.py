"""``launch.events.matchers``."""

from collections.abc import Callable

from ..action import Action


def matches_action(target_action: Action) -> Callable[[Action], bool]:
    """Return a matcher of events of an action."""
    return lambda action: action is target_action
