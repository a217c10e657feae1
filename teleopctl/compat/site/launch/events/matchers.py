"""``launch.events.matchers``."""

from collections.abc import Callable

from ..action import Action


def matches_action(target_action: Action) -> Callable[[Action], bool]:
    """Return a function that tells whether an action is a certain one."""
    return lambda action: action is target_action
